// SPDX-License-Identifier: Apache-2.0
//
// OSL's noise("perlin"), whose values are vectors: Perlin's gradient noise (2002) on the hash of
// Bob Jenkins' lookup3, as Open Shading Language computes it (src/include/OSL/oslnoise.h). Signed,
// 0 at the corners of the unit lattice.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "random.h"
#include "vector.h"

namespace metallic_paint {

// lookup3 of three words.
inline std::uint32_t lattice_hash(int x, int y, int z) {
  constexpr std::uint32_t start = 0xdeadbeefu + (3u << 2) + 13u;
  return lookup3_final(start + static_cast<std::uint32_t>(x), start + static_cast<std::uint32_t>(y),
                       start + static_cast<std::uint32_t>(z));
}

// The product of (x, y, z) with the direction to one of a cube's edges, by the hash's last 4 bits.
template <class T>
T lattice_gradient(std::uint32_t hash, T x, T y, T z) {
  const std::uint32_t h = hash & 15u;
  const T u = h < 8 ? x : y;
  const T v = h < 4 ? y : (h == 12 || h == 14 ? x : z);
  return ((h & 1u) != 0 ? -u : u) + ((h & 2u) != 0 ? -v : v);
}

// The cell of a coordinate; beyond the ints every cell is the same.
template <class T>
int lattice_cell(T x) {
  return static_cast<int>(clamp(floor(x), T(-2147483520), T(2147483520)));
}

template <class T>
Vec3<T> perlin_noise(Vec3<T> p) {
  const int cell[3] = {lattice_cell(p.x), lattice_cell(p.y), lattice_cell(p.z)};
  const Vec3<T> f = map(p, [](T x) { return x - floor(x); });
  const Vec3<T> fade = map(f, [](T t) { return t * t * t * (t * (t * 6 - 15) + 10); });
  const auto mix = [](T from, T to, T t) { return (1 - t) * from + t * to; };
  const auto wrap = [](int i, int step) {
    return static_cast<int>(static_cast<std::uint32_t>(i) + static_cast<std::uint32_t>(step));
  };
  // The three components take a byte of the hash each.
  const auto component = [&](int shift) {
    const auto corner = [&](int x, int y, int z) {
      const std::uint32_t hash =
          lattice_hash(wrap(cell[0], x), wrap(cell[1], y), wrap(cell[2], z)) >> shift;
      return lattice_gradient(hash, f.x - static_cast<T>(x), f.y - static_cast<T>(y),
                              f.z - static_cast<T>(z));
    };
    const auto edge = [&](int x, int y) { return mix(corner(x, y, 0), corner(x, y, 1), fade.z); };
    const auto face = [&](int y) { return mix(edge(0, y), edge(1, y), fade.x); };
    return T(0.982L) * mix(face(0), face(1), fade.y);
  };
  return {component(0), component(8), component(16)};
}

}  // namespace metallic_paint
