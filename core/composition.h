// SPDX-License-Identifier: Apache-2.0
//
// How sparkles join the rest of the paint's light. exact: they add. published: the paper's remark
// at the end of 5.3.5, a pixel takes the greatest luminance, here of each listed light; its
// highlight and diffuse light are one here, for the renderer adds these itself. Sparkles can darken
// nothing in either.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "refraction.h"
#include "vector.h"

namespace metallic_paint {

enum class Composition { exact = 0, published = 1 };

// Rec. 709
template <class T>
T luminance(Rgb<T> c) {
  return T(0.2126) * c.x + T(0.7152) * c.y + T(0.0722) * c.z;
}

// What `sparkles` add to `base` so that the sum has the greater luminance of the two.
template <class T>
Rgb<T> greatest(Rgb<T> sparkles, Rgb<T> base) {
  const T bright = luminance(sparkles), other = luminance(base);
  if (!(bright > other)) return {};
  return sparkles * ((bright - other) / bright);
}

// The highlight of a binder surface that reflects `reflectance`, per unit of the light's irradiance
// on a plane normal to it: the light's disc in a mirror, or Walter's GGX microfacets (2007) of
// roughness alpha, D G/(4 cos(theta)), with Smith's G of both directions apart. The light's solid
// angle is 4 pi sin^2(Delta_a/2).
template <class T>
T highlight(Vec3<T> normal, Vec3<T> view, Vec3<T> light, T sin2_half_radius, T alpha,
            T reflectance) {
  constexpr T pi = std::numbers::pi_v<T>;
  const T cos_view = dot(normal, view), cos_light = dot(normal, light);
  if (!(cos_view > 0 && cos_light > 0)) return 0;
  if (!(alpha > 0)) {
    const Vec3<T> off = normal * (2 * cos_view) - view - light;
    if (!(sin2_half_radius > 0) || dot(off, off) > 4 * sin2_half_radius) return 0;
    return reflectance / (4 * pi * sin2_half_radius);
  }
  const Vec3<T> sum = view + light;
  const T cos_half = dot(normal, sum) / length(sum);
  const T square = alpha * alpha;
  const T spread = cos_half * cos_half * (square - 1) + 1;
  const auto visible = [&](T cosine) {
    return 2 * cosine / (cosine + std::sqrt(square + (1 - square) * cosine * cosine));
  };
  const T shape = square / std::max(spread * spread, T(1e-20));
  return reflectance * shape * visible(cos_view) * visible(cos_light) / (4 * pi * cos_view);
}

}  // namespace metallic_paint
