// SPDX-License-Identifier: Apache-2.0
//
// The hash as an endless stream for batteries of random number tests: the upper 24 bits, which
// deviates use, of three words of each pixel of a 4096 x 4096 picture in raster order, frame after
// frame.
//   c++ -std=c++20 -O2 -I core tools/verification/hash_stream.cpp -o build/hash_stream
//   build/hash_stream | dieharder -g 200 -a        (or | RNG_test stdin32, of PractRand)
#include <cstdio>
#include <vector>

#include "random.h"

int main() {
  using namespace metallic_paint;
  constexpr int kSide = 4096;
  std::vector<std::uint8_t> row;
  for (int frame = 1;; ++frame) {
    const HashKey stream = stream_key(0, 0, frame, 0);
    for (int y = 0; y < kSide; ++y) {
      row.clear();
      for (int x = 0; x < kSide; ++x) {
        const Deviates u = uniform_deviates(pixel_key(stream, x, y, 0), 0);
        for (const float each : {u.x, u.y, u.z}) {
          const auto word = static_cast<std::uint32_t>(each * 0x1p24f);
          for (int shift = 0; shift < 24; shift += 8) {
            row.push_back(static_cast<std::uint8_t>(word >> shift));
          }
        }
      }
      if (std::fwrite(row.data(), 1, row.size(), stdout) != row.size()) return 0;
    }
  }
}
