// SPDX-License-Identifier: Apache-2.0
//
// The space in which the paint's flakes rest (ours), and the plane in it along which the surface
// lies.
#pragma once

#include <algorithm>
#include <cmath>

#include "vector.h"

namespace metallic_paint {

// The space in which the paint's flakes rest: the object's, or that of a rest position.
template <class T>
struct OwnSpace {
  Vec3<T> position{};                          // of the point, m
  Vec3<T> x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};  // its axes in the world
  int instance = 0;                            // tells copies of one object apart
};

// A direction of the world in the own space.
template <class T>
Vec3<T> own_direction(const OwnSpace<T>& own, Vec3<T> d) {
  return {dot(own.x, d), dot(own.y, d), dot(own.z, d)};
}

// The plane of a lattice, across that axis of the own space which is nearest to the normal.
template <class T>
struct LatticePlane {
  Vec3<T> n;  // the normal in the own space
  int w;      // that axis: 0, 1 or 2
  int u, v;   // the axes in the plane
  int face;   // w, and 3 more on the other face of a sheet
};
template <class T>
LatticePlane<T> lattice_plane(const OwnSpace<T>& own, Vec3<T> surface_normal) {
  const Vec3<T> n = own_direction(own, surface_normal);
  const T normal[3] = {n.x, n.y, n.z};
  int w = 0;
  if (abs(n.y) > abs(n.x)) w = 1;
  if (abs(n.z) > max(abs(n.x), abs(n.y))) w = 2;
  return {n, w, (w + 1) % 3, (w + 2) % 3, normal[w] < 0 ? w + 3 : w};
}

}  // namespace metallic_paint
