// SPDX-License-Identifier: Apache-2.0
//
// The lobe of Cycles' phong_ramp, whose colours are all white: about the mirror image of the view.
#pragma once

#include <cmath>
#include <numbers>

#include "elementary.h"
#include "vector.h"

namespace metallic_paint {

// f cos(theta'), 1/sr, of what reflects all where the normal is near the mirror image. 0 where the
// light lies below the surface of that normal.
template <class T>
T phong_lobe(Vec3<T> normal, Vec3<T> view, Vec3<T> light, T exponent) {
  const T cos_view = dot(normal, view), cos_light = dot(normal, light);
  const T along = min(dot(normal * (2 * cos_view) - view, light), T(1));
  if (!(cos_view > 0 && cos_light > 0 && along > 0)) return 0;
  return (exponent + 2) / (2 * std::numbers::pi_v<T>)*cos_light * std::pow(along, exponent);
}

// The integral of phong_lobe over the lights: what it reflects of a white world. Were nothing of
// the lobe below the surface, it would be the view's cosine c. At c = 0 half of it is, and the
// integral is I/pi, I that of cos^n over [0, pi/2]; its square is pi/(2 n + 1 + ...), within 0.2 %.
// In between what is added falls off as that of a Gaussian does. Error 0.6 % at most, for exponents
// from 0 to 1e4 (tests/core/whole_paint_test.cpp).
template <class T>
T phong_albedo(T cos_view, T exponent) {
  const T at_grazing =
      sqrt(1 / (std::numbers::pi_v<T> * (2 * exponent + 1 + T(0.2732) / (1 + exponent))));
  const T y = cos_view / at_grazing;
  return cos_view + at_grazing * exponential(-y * (T(0.5) + T(0.055) * y)) *
                        (1 - cos_view * cos_view * cos_view);
}

}  // namespace metallic_paint
