// SPDX-License-Identifier: Apache-2.0
//
// The pixel that sees a point, and the area of its projection on the surface: what the renderer
// knows of its camera, as numbers.
#pragma once

#include <algorithm>
#include <cmath>

#include "vector.h"

namespace metallic_paint {

template <class T>
int pixel_coordinate(T raster) {
  return static_cast<int>(floor(clamp(raster, T(-1e9), T(1e9))));
}

// The area of a pixel across the view, for perspective and orthographic cameras: with s_x and s_y
// pixels per unit length across the camera's axis at the point's depth, an area A facing along V
// covers A |V_z|/|V| s_x s_y pixels. V: the view in the camera's space.
template <class T>
T facing_area(Vec3<T> view_in_camera, T pixels_x, T pixels_y) {
  return abs(view_in_camera.z) / (length(view_in_camera) * pixels_x * pixels_y);
}

// On the surface: 1/cos(theta) as much. Seen in a mirror, by a camera without a projection
// (panorama), or with an `exact` far from it, the ray differentials |Dx x Dy|, which are traced as
// a cone and lack that cosine.
template <class T>
T surface_area(T exact, T differential, T cos_view) {
  if (exact > T(0.2) * differential && exact < 5 * differential) return exact / cos_view;
  return differential / cos_view;
}

}  // namespace metallic_paint
