// SPDX-License-Identifier: Apache-2.0
//
// Random numbers by hash of integers: the same bits in C++ and in OSL, no state, no order of
// evaluation.
#pragma once

#include <cstdint>

namespace metallic_paint {

struct HashWords {
  std::uint32_t x, y, z, w;
};

// pcg4d (Jarzynski and Olano, JCGT 9(3), 2020): four words into four, a bijection of 128 bits.
inline HashWords pcg4d(HashWords v) {
  v.x = v.x * 1664525u + 1013904223u;
  v.y = v.y * 1664525u + 1013904223u;
  v.z = v.z * 1664525u + 1013904223u;
  v.w = v.w * 1664525u + 1013904223u;
  for (int round = 0; round < 2; ++round) {
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    if (round == 0) {
      v.x ^= v.x >> 16;
      v.y ^= v.y >> 16;
      v.z ^= v.z >> 16;
      v.w ^= v.w >> 16;
    }
  }
  return v;
}

// What tells one stream of deviates from another, hashed once per light and paint.
inline HashWords stream_key(int light, int species, int frame, int seed) {
  return pcg4d({static_cast<std::uint32_t>(light), static_cast<std::uint32_t>(species),
                static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(seed)});
}

// The words of draw number `draw` in pixel (x, y) of a stream; any int is a valid coordinate.
inline HashWords draw_words(HashWords key, int x, int y, int draw) {
  return pcg4d({static_cast<std::uint32_t>(x) ^ key.x, static_cast<std::uint32_t>(y) ^ key.y, key.z,
                key.w + static_cast<std::uint32_t>(draw)});
}

// A uniform deviate in (0, 1] from two words: multiples of 2^-48 plus half a step. A float keeps 24
// significant bits of it, so small values are as fine as 2^-49: probabilities of 1e-9 and below are
// met.
template <class T>
T uniform_48(std::uint32_t high, std::uint32_t low) {
  const T step = T(1) / 16777216;
  return (static_cast<T>(high >> 8) + (static_cast<T>(low >> 8) + T(0.5)) * step) * step;
}

// A uniform deviate in (0, 1) from one word, exact in float: (multiples of 2^-23) + 2^-24.
template <class T>
T uniform_23(std::uint32_t word) {
  return (static_cast<T>(word >> 9) + T(0.5)) * (T(1) / 8388608);
}

// Likewise from the lower half of a word: (multiples of 2^-16) + 2^-17.
template <class T>
T uniform_16(std::uint32_t word) {
  return (static_cast<T>(word & 65535u) + T(0.5)) * (T(1) / 65536);
}

}  // namespace metallic_paint
