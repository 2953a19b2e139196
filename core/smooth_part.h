// SPDX-License-Identifier: Apache-2.0
//
// What flakes mirror of light that does not sparkle, as far as a lobe of microfacets shows it.
//
// Random flakes (flake_lobe.h) are noise: of an HDRI or a wide lamp a renderer sees what one of
// their cones holds. A lobe g of microfacets it samples evenly and by its lamps. So where no listed
// light sparkles, f cos(theta') = g + (f cos(theta') - g): microfacets show g, and what a random
// flake shows is less by g over the density that drew it. The mean stays whatever g is, as long as
// it lies below.
//
// Of the half vector h of view and light the slope to the surface is (v + l)_t/(cos + cos'), and
// that of the flake which mirrors them (v + l)_t/(g + g'), g = eta cos(theta_p). Near the mirror
// direction, where cos' = cos, facets of alpha0^2 = 2 var g^2/cos^2 mirror as the flakes do
// (`core_variance`). (1 - r') cos' falls to the horizon as cos'^2, hence in the plane of view by
// (x/cos)^2 and 2 x tan(theta), x from the mirror direction: the facets' normal turns from the
// horizon, and alpha is smaller. From that first guess the lobe is fitted to f by a Newton step:
// the logarithm of f over g's other factors is taken for a parabola through its middle and a point
// on each side. Then it is lowered until it passes f at none of six points out to 1.6 alpha.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hot_spot.h"
#include "layer.h"

namespace metallic_paint {

template <class T>
struct SmoothPart {
  Vec3<T> normal, along;  // of the facets, and the direction of alpha_x
  T alpha_x{}, alpha_y{};
  Rgb<T> weight{};  // of the lobe; 0: there is none
};

// Smith's Lambda of Beckmann's facets by (alpha tan(theta))^2, in the approximation of Walter
// (2007) that Cycles has.
template <class T>
T masking_lambda(T square) {
  if (square < T(0.39)) return 0;
  const T a = 1 / sqrt(square);
  return ((T(0.396) * a - T(1.259)) * a + 1) / ((T(2.181) * a + T(3.535)) * a);
}

// BRDF times cos(theta') of facets that reflect all, as Cycles evaluates them.
template <class T>
T facets_show(const SmoothPart<T>& part, Vec3<T> view, Vec3<T> light) {
  const Vec3<T> across = cross(part.normal, part.along);
  const T view_z = dot(view, part.normal), light_z = dot(light, part.normal);
  if (!(view_z > 0 && light_z > 0)) return 0;
  const T view_x = dot(view, part.along) * part.alpha_x, view_y = dot(view, across) * part.alpha_y;
  const T light_x = dot(light, part.along) * part.alpha_x,
          light_y = dot(light, across) * part.alpha_y;
  const T area = part.alpha_x * part.alpha_y;
  const T half_z = view_z + light_z;
  const T x = (view_x + light_x) / (part.alpha_x * part.alpha_x * half_z);
  const T y = (view_y + light_y) / (part.alpha_y * part.alpha_y * half_z);
  const Vec3<T> half = view + light;
  const T cos2 = half_z * half_z / dot(half, half);
  const T masked = 1 + masking_lambda((view_x * view_x + view_y * view_y) / (view_z * view_z)) +
                   masking_lambda((light_x * light_x + light_y * light_y) / (light_z * light_z));
  return exponential(-(x * x + y * y)) /
         (std::numbers::pi_v<T> * area * cos2 * cos2 * masked * 4 * view_z);
}

// f cos(theta') of flakes but for factors that the whole lobe has alike, for which stand those in
// its middle: what the coating reflects, and the depth's blocking and colours. Optical depths:
// towards the observer, and of the way out at cos = 1.
template <class T>
T flakes_show(const Layer<T>& layer, const OrientationDensity<T>& orientation, Vec3<T> normal,
              Vec3<T> view, Vec3<T> light, T slant_view, T depth) {
  const Mirror<T> mirror = mirror_between(normal, view, light, layer.eta);
  if (!mirror.possible) return 0;
  const T apart = ways_apart(normal, view, mirror.cos_view, mirror.g_view, light, mirror.cos_light,
                             mirror.g_light);
  const Rgb<T> slant =
      there_and_back(layer, grey(slant_view), grey(depth * layer.eta / mirror.g_light), apart);
  return orientation_density(orientation, mirror.sin2_half_beta) * mean_transmittance(slant.x) *
         fresnel_transmittance(mirror.cos_light, mirror.g_light, layer.eta) * mirror.cos_light /
         mirror.g_light;
}

// That over what the facets show, where the half vector has these slopes to them, in alphas.
template <class T>
T flakes_over_facets(const Layer<T>& layer, const OrientationDensity<T>& orientation,
                     Vec3<T> normal, Vec3<T> view, T slant_view, T depth, const SmoothPart<T>& part,
                     T x, T y) {
  const Vec3<T> across = cross(part.normal, part.along);
  const Vec3<T> half = part.normal + part.along * (x * part.alpha_x) + across * (y * part.alpha_y);
  const Vec3<T> light = half * (2 * dot(half, view) / dot(half, half)) - view;
  const T facets = facets_show(part, view, light);
  if (!(facets > 0)) return 0;
  return flakes_show(layer, orientation, normal, view, light, slant_view, depth) / facets;
}

// Facets whose normal has the slope towards the observer.
template <class T>
SmoothPart<T> facets_at(Vec3<T> normal, Vec3<T> towards, T slope, T x2, T y2) {
  const T cosine = 1 / sqrt(1 + slope * slope);
  return {(normal + towards * slope) * cosine, (towards - normal * slope) * cosine,
          clamp(sqrt(x2), T(1e-3), T(1)), clamp(sqrt(y2), T(1e-3), T(1))};
}

// Chosen over random paints for the largest part that stays below f (tests/fits/smooth_part.cpp):
// the slopes, in alphas, of the parabola and of the points that hold the lobe down;
inline constexpr double kFitted = 0.8, kHeld = 1.63;
// how much smaller the squares of the alphas are than the parabola's, as f falls ever faster
// to the horizon; and what is left for its bends between the points.
inline constexpr double kNarrower = 1.08, kNarrowerAcross = 1.01, kBelow = 0.985;
// Nearer to the horizon f has no lobe that facets resemble.
inline constexpr double kLeastSmooth = 0.2;

template <class T>
SmoothPart<T> smooth_part(const Layer<T>& layer, const Flakes<T>& flakes, Vec3<T> normal,
                          Vec3<T> view) {
  const OrientationDensity<T>& orientation = flakes.orientation;
  const T cos_view = min(dot(normal, view), T(1));
  if (!(cos_view > T(kLeastSmooth)) || !(flakes.coverage > 0)) return {};
  const T g_view = eta_cos_refracted(cos_view, layer.eta);

  // The first guess.
  Vec3<T> towards = abs(normal.x) < T(0.6) ? Vec3<T>{1, 0, 0} : Vec3<T>{0, 1, 0};
  if (cos_view < T(0.999999)) towards = view;
  towards = towards - normal * dot(normal, towards);
  towards = towards / length(towards);
  const T turned = g_view / cos_view;
  const T square = 2 * core_variance(orientation) * turned * turned;
  T x2 = square / (1 + T(1.44) * square / (cos_view * cos_view));
  T y2 = square / (1 + T(2.73) * square);
  T slope = T(1.07) * x2 * sqrt((1 - cos_view) * (1 + cos_view)) / cos_view;
  SmoothPart<T> part = facets_at(normal, towards, slope, x2, y2);

  Vec3<T> light = part.normal * (2 * dot(part.normal, view)) - view;
  const T cos_light = min(dot(normal, light), T(1));
  if (!(cos_light > T(1e-3))) return {};
  const T cos_light_in = min(eta_cos_refracted(cos_light, layer.eta) / layer.eta, T(1));
  const Rgb<T> slant_view = slant_depth_of(layer, min(g_view / layer.eta, T(1)));
  const Rgb<T> slant_light = slant_depth_of(layer, cos_light_in);
  const T grey_view = (slant_view.x + slant_view.y + slant_view.z) / 3;
  const T grey_light = (slant_light.x + slant_light.y + slant_light.z) / 3;
  const T depth = grey_light * cos_light_in;

  // The Newton step. `falls`: -ln of f over g's other factors, from the middle to each side.
  const T at2 = T(kFitted) * T(kFitted);
  T whole = 0;
  T falls[4];
  for (int i = 0; i < 4; ++i) {
    const T x = i == 1 ? T(kFitted) : i == 2 ? T(-kFitted) : T(0);
    const T y = i == 3 ? T(kFitted) : T(0);
    const T ratio =
        flakes_over_facets(layer, orientation, normal, view, grey_view, depth, part, x, y);
    if (i == 0) whole = ratio;
    if (!(whole > 0)) return {};
    falls[i] = at2 - logarithm(clamp(ratio / whole, T(1e-3), T(1e3)));
  }
  const T both = falls[1] + falls[2];
  const T aside = (falls[2] - falls[1]) / (2 * max(both, T(0.4) * at2));
  slope = max(slope + T(kFitted) * part.alpha_x * clamp(aside, T(-0.7), T(0.7)), T(0));
  x2 = x2 / (clamp(both / (2 * at2), T(0.34), T(4)) * T(kNarrower));
  y2 = y2 / (clamp(falls[3] / at2, T(0.34), T(4)) * T(kNarrowerAcross));
  part = facets_at(normal, towards, slope, x2, y2);

  // Held below f.
  T lowest = 0;
  for (int i = 0; i < 6; ++i) {
    const T reach = i == 0 ? T(0) : i < 4 ? T(kHeld) : T(0.7) * T(kHeld);
    const T x = i == 3 ? T(0) : i == 1 || i == 4 ? reach : -reach;
    const T y = i < 3 ? T(0) : reach;
    const T ratio =
        flakes_over_facets(layer, orientation, normal, view, grey_view, depth, part, x, y);
    if (i == 0 || (ratio > 0 && ratio < lowest)) lowest = ratio;
  }

  // The factors of the middle.
  light = part.normal * (2 * dot(part.normal, view)) - view;
  const Mirror<T> mirror = mirror_between(normal, view, light, layer.eta);
  if (!mirror.possible) return {};
  const T apart = ways_apart(normal, view, mirror.cos_view, mirror.g_view, light, mirror.cos_light,
                             mirror.g_light);
  const Rgb<T> slant = there_and_back(layer, slant_view, slant_light, apart);
  const Rgb<T> greyed = there_and_back(layer, grey(grey_view), grey(grey_light), apart);
  const T exit = layer.radiometry == Radiometry::published ? layer.eta * cos_view : g_view;
  const T factor = flakes.coverage * fresnel_transmittance(cos_view, g_view, layer.eta) /
                   (8 * std::numbers::pi_v<T> * exit * mean_transmittance(greyed.x));
  part.weight = coating_reflectance(flakes.coating, mirror.cos_alpha) *
                map(slant, [](T x) { return mean_transmittance(x); }) *
                (factor * lowest * T(kBelow));
  return part;
}

}  // namespace metallic_paint
