// SPDX-License-Identifier: Apache-2.0
//
// Random numbers by hash: Bob Jenkins' lookup3 (2006) on the bits of four floats, which is
// Blender's White Noise node and OSL's noise("hash"), the same bits everywhere. No state, no order
// of evaluation.
//
// What is hashed are whole numbers from 0 to 2^23: a key of three below 2^22, to which cells of the
// paint or pixels are added modulo 2^22, and a word more. A float holds them exactly, and no device
// has another bit pattern of theirs: a zero is never negative.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "vector.h"

namespace metallic_paint {

// lookup3's final mixing of three words.
inline std::uint32_t lookup3_final(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  c = (c ^ b) - std::rotl(b, 14);
  a = (a ^ c) - std::rotl(c, 11);
  b = (b ^ a) - std::rotl(a, 25);
  c = (c ^ b) - std::rotl(b, 16);
  a = (a ^ c) - std::rotl(c, 4);
  b = (b ^ a) - std::rotl(a, 14);
  return (c ^ b) - std::rotl(b, 24);
}

// Of four words.
inline std::uint32_t lookup3(std::uint32_t x, std::uint32_t y, std::uint32_t z, std::uint32_t w) {
  constexpr std::uint32_t start = 0xdeadbeefu + (4u << 2) + 13u;
  std::uint32_t a = start + x, b = start + y, c = start + z;
  a = (a - c) ^ std::rotl(c, 4);
  c += b;
  b = (b - a) ^ std::rotl(a, 6);
  a += c;
  c = (c - b) ^ std::rotl(b, 8);
  b += a;
  a = (a - c) ^ std::rotl(c, 16);
  c += b;
  b = (b - a) ^ std::rotl(a, 19);
  a += c;
  c = (c - b) ^ std::rotl(b, 4);
  b += a;
  return lookup3_final(a + w, b, c);
}

// The node's Value, in [0, 1]: multiples of 2^-32 as a float holds them.
inline float hash_value(float x, float y, float z, float w) {
  return static_cast<float>(
             lookup3(std::bit_cast<std::uint32_t>(x), std::bit_cast<std::uint32_t>(y),
                     std::bit_cast<std::uint32_t>(z), std::bit_cast<std::uint32_t>(w))) *
         0x1p-32f;
}

// A uniform deviate in (0, 1): 0 is read as half a step, 1 as what lies before it.
inline float uniform_deviate(float x, float y, float z, float w) {
  return clamp(hash_value(x, y, z, w), 0x1p-33f, 1 - 0x1p-24f);
}

using Deviates = Vec3<float>;  // three uniform ones
using HashKey = Vec3<float>;   // whole numbers from 0 to 2^22 - 1

// The node's Color.
inline Deviates uniform_deviates(HashKey at, float w) {
  return {uniform_deviate(at.x, at.y, at.z, w), uniform_deviate(at.z, at.x, w, at.y),
          uniform_deviate(w, at.z, at.y, at.x)};
}

inline HashKey hashed(HashKey at, float w) {
  return map(uniform_deviates(at, w), [](float u) { return std::floor(u * 4194304.0f); });
}

// A whole number modulo 2^22.
inline float wrapped(int whole) { return static_cast<float>(whole & 4194303); }
template <class T>
float wrapped(T whole) {
  const T bounded = clamp(whole, T(-1e30), T(1e30));
  return static_cast<float>(bounded - floor(bounded * T(0x1p-22)) * T(4194304));
}

// What tells one stream of deviates from another. Numbers that differ by a multiple of 2^22 are
// one.
inline HashKey stream_key(int kind, int instance, int frame, int seed) {
  return hashed({wrapped(kind), wrapped(instance), wrapped(frame)}, wrapped(seed));
}

// The key of a pixel.
inline HashKey pixel_key(HashKey stream, int x, int y, int number) {
  return hashed(stream + HashKey{wrapped(x), wrapped(y), 0}, wrapped(number));
}

}  // namespace metallic_paint
