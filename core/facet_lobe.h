// SPDX-License-Identifier: Apache-2.0
//
// The lobe of GGX microfacets as Cycles evaluates it: Walter's distribution (2007) with Smith's
// masking of both directions together (Heitz 2014), scaled where it is to reflect all.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vector.h"

namespace metallic_paint {

// cos(theta) (1 + 2 Lambda), Smith's Lambda of a direction by its cosine to the normal.
template <class T>
T masking(T cosine, T alpha) {
  return sqrt(cosine * cosine + alpha * alpha * (1 - cosine) * (1 + cosine));
}

// Facets of less roughness count as these: narrower than any lamp.
inline constexpr double kLeastAlpha = 1e-4;

// f cos(theta') = D/(4 cos(theta) (1 + Lambda + Lambda')), 1/sr, of facets that reflect all: the
// radiance under a light so narrow that the lobe is even over it, per unit of its irradiance on a
// plane normal to it. 0 where a direction lies below the surface.
template <class T>
T facet_lobe(Vec3<T> normal, Vec3<T> view, Vec3<T> light, T alpha) {
  const T cos_view = min(dot(normal, view), T(1));
  const T cos_light = min(dot(normal, light), T(1));
  if (!(cos_view > 0 && cos_light > 0)) return 0;
  const T rough = max(alpha, T(kLeastAlpha));
  const Vec3<T> half = (view + light) / length(view + light);
  const T cos_half = dot(normal, half);
  const T square = rough * rough;
  // cos^2 (alpha^2 - 1) + 1 is alpha^2 cos^2 + sin^2, which keeps its digits.
  const Vec3<T> across = half - normal * cos_half;
  const T spread = square * cos_half * cos_half + dot(across, across);
  const T density = square / (std::numbers::pi_v<T> * spread * spread);
  return density * cos_light /
         (2 * (cos_light * masking(cos_view, rough) + cos_view * masking(cos_light, rough)));
}

// The integral of facet_lobe over the lights: what single scattering reflects. Facets drawn as the
// view sees them (Heitz 2018) on a grid of the disc; each shows the share (1 + Lambda)/(1 + Lambda
// + Lambda') of what it mirrors up. Error 3e-4 at most (tests/core/whole_paint_test.cpp).
template <class T>
T facet_lobe_albedo(T cos_view, T alpha) {
  constexpr int rings = 64, sectors = 32;
  const T rough = max(alpha, T(kLeastAlpha));
  const T sin_view = sqrt((1 - cos_view) * (1 + cos_view));
  const T at_view = masking(cos_view, rough);
  // The view in the space where the facets are a half sphere.
  const T x = rough * sin_view / at_view, z = cos_view / at_view;
  T sum = 0;
  for (int i = 0; i < rings; ++i) {
    // Rings crowd at the edge, where the steep facets of the long tail are: 1 - r^2 = w^3.
    const T w = (static_cast<T>(i) + T(0.5)) / rings;
    const T share = 3 * w * w, r = sqrt((1 - w) * (1 + w + w * w));
    for (int j = 0; j < sectors; ++j) {  // the other half of the disc is the same
      const T phi = std::numbers::pi_v<T> * ((static_cast<T>(j) + T(0.5)) / sectors - T(0.5));
      const T aside = r * std::cos(phi);
      const T rest = sqrt(1 - aside * aside);
      const T up = (1 - z) / 2 * rest + (1 + z) / 2 * r * std::sin(phi);
      const T out = sqrt(max((rest - up) * (rest + up), T(0)));
      const Vec3<T> facet{rough * (out * x - up * z), rough * aside, max(up * x + out * z, T(0))};
      const T square = dot(facet, facet);
      const T facing = sin_view * facet.x + cos_view * facet.z;
      const T cos_light = min(2 * facing * facet.z / square - cos_view, T(1));
      if (!(cos_light > 0)) continue;
      sum = sum + share * (at_view + cos_view) * cos_light /
                      (at_view * cos_light + cos_view * masking(cos_light, rough));
    }
  }
  return sum / (rings * sectors);
}

}  // namespace metallic_paint
