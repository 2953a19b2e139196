// SPDX-License-Identifier: Apache-2.0
//
// Orange peel (ours): the waves that spraying leaves in the binder's surface. Their slope is Perlin
// noise of wavelength `size`; they bend the highlight, and not what the flakes see, which they
// would turn by a third of their slope.
#pragma once

#include <algorithm>
#include <cmath>

#include "noise.h"
#include "vector.h"

namespace metallic_paint {

// Of each channel of perlin_noise, measured over 1e6 points.
inline constexpr double kPerlinDeviation = 0.26;
// The sine of how far above the horizon light leaves, unless the view is lower.
inline constexpr double kLeastHeight = 0.01;

// The normal tilted by a slope whose root mean square is `slope`; p, where the point lies in its
// own space, and `size` in m.
template <class T>
Vec3<T> orange_peel(Vec3<T> normal, Vec3<T> p, T slope, T size) {
  const Vec3<T> waves = perlin_noise(p / size);
  const Vec3<T> across = waves - normal * dot(normal, waves);
  const Vec3<T> tilted =
      normal + across * (slope / (T(1.41421356237309504880L) * T(kPerlinDeviation)));
  return tilted / length(tilted);
}

// The coat's normal turned so that a mirror's light stays above the surface: what a wave sends down
// meets another that sends it up again.
template <class T>
Vec3<T> above_surface(Vec3<T> coat_normal, Vec3<T> normal, Vec3<T> view) {
  const Vec3<T> mirrored = coat_normal * (2 * dot(coat_normal, view)) - view;
  const T height = dot(mirrored, normal);
  const T least = clamp(dot(normal, view), T(0), T(kLeastHeight));
  if (height >= least) return coat_normal;
  const Vec3<T> up = mirrored + normal * (max(-height, least) - height);
  const Vec3<T> half = view + up / length(up);
  return half / length(half);
}

}  // namespace metallic_paint
