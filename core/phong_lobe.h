// SPDX-License-Identifier: Apache-2.0
//
// The lobe of Cycles' phong_ramp, whose colours are all white: about the mirror image of the view.
#pragma once

#include <cmath>
#include <numbers>

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

}  // namespace metallic_paint
