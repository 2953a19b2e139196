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

#include "choices.h"
#include "refraction.h"
#include "vector.h"

namespace metallic_paint {

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

// A rough surface reflects at its facets: Fresnel's reflectance at the angle on those that face the
// observer, of which the share facet_albedo comes back past the others. Both are fits to GGX's
// visible normals, exact for a smooth surface. The product is within 0.035 of single scattering for
// eta from 1.2 to 2.4, 0.008 in root mean square (tests/core/composition_test.cpp), within 0.09 for
// eta = 1.05. Fresnel at the view's own angle is up to 0.7 too much. Least squares over even steps
// of roughness and cosine give 0.60, 0.79, 1.26 and 0.45, 0.24: their root mean square is 0.0063
// where these have 0.0069, their largest error 0.028 where these have 0.024
// (tests/fits/facet_fit.cpp, docs/fits.md).
template <class T>
T facet_reflectance(T cos_view, T roughness, T eta) {
  const T q = roughness * roughness * sqrt(roughness);
  const T k = T(0.55) * q / (1 + T(0.56) * q);
  const T square = cos_view * cos_view;
  const T cosine = sqrt(square + k * (1 - T(0.6) * square));
  return 1 - fresnel_transmittance(cosine, eta_cos_refracted(cosine, eta), eta);
}

template <class T>
T facet_albedo(T cos_view, T roughness) {
  return 1 - roughness * roughness * (T(0.43) + T(0.26) * cos_view);
}

// What the binder's surface reflects. The flakes' light leaves by a smooth one of transmittance T;
// the rest of the paint takes the share (1 - reflected)/T of it, so that nothing is lost.
template <class T>
struct Coat {
  T reflected, rest;
};

template <class T>
Coat<T> make_coat(T cos_view, T roughness, T eta) {
  const T passed = fresnel_transmittance(cos_view, eta_cos_refracted(cos_view, eta), eta);
  if (!(roughness > 0 && passed > 0)) return {1 - passed, 1};
  const T reflected =
      facet_reflectance(cos_view, roughness, eta) * facet_albedo(cos_view, roughness);
  return {reflected, (1 - reflected) / passed};
}

// Smith's G of one direction.
template <class T>
T visible_facets(T square, T cosine) {
  return 2 * cosine / (cosine + sqrt(square + (1 - square) * cosine * cosine));
}

// A mirror shows no listed light smaller than this half-angle, 0.5 degrees, as sin^2 of its half:
// smaller ones as a disc of this size and as much light in all (ours). In a bent surface the sun's
// image is a hundredth of a pixel and less, which few samples find, as bright as they are rare. So
// that a sample at its rim is no speck, the disc fades from full to nothing over as much solid
// angle to either side of its rim: in the middle it is as bright, and it is as much in all.
inline constexpr double kLeastImage = 1.9e-5;

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
    const T disc = max(sin2_half_radius, T(kLeastImage));
    const T inside = disc - dot(off, off) / 4;
    const T shown = clamp((inside + T(kLeastImage)) / T(2 * kLeastImage), T(0), T(1));
    return reflectance * shown / (4 * pi * disc);
  }
  const Vec3<T> sum = view + light;
  const T cos_half = dot(normal, sum) / length(sum);
  const T square = alpha * alpha;
  const T spread = cos_half * cos_half * (square - 1) + 1;
  const T shape = square / max(spread * spread, T(1e-20));
  return reflectance * shape * visible_facets(square, cos_view) *
         visible_facets(square, cos_light) / (4 * pi * cos_view);
}

}  // namespace metallic_paint
