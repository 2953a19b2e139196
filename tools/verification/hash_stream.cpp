// SPDX-License-Identifier: Apache-2.0
//
// The hash as an endless stream for batteries of random number tests: the bits that deviates use,
// the upper 24 of the four words of draw 0, of each pixel of a 4096 x 4096 picture in raster order,
// frame after frame. (With the unused lower 8, dieharder's diehard_dna and dab_monobit2 fail.)
//   c++ -std=c++20 -O2 -I core tools/verification/hash_stream.cpp -o build/hash_stream
//   build/hash_stream | dieharder -g 200 -a        (or | RNG_test stdin32, of PractRand)
#include <array>
#include <cstdio>
#include <vector>

#include "random.h"

int main() {
  using namespace metallic_paint;
  constexpr int kSide = 4096;
  std::vector<std::array<std::uint32_t, 3>> row(kSide);
  for (int frame = 1;; ++frame) {
    const HashWords key = stream_key(0, 0, frame, 0);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const HashWords h = draw_words(key, x, y, 0);
        row[static_cast<std::size_t>(x)] = {(h.x >> 8) | (h.w >> 8 << 24),
                                            (h.y >> 8) | (h.w >> 16 << 24),
                                            (h.z >> 8) | (h.w >> 24 << 24)};
      }
      if (std::fwrite(row.data(), sizeof(row[0]), row.size(), stdout) != row.size()) return 0;
    }
  }
}
