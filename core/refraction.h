// SPDX-License-Identifier: Apache-2.0
//
// The binder's surface: Snell, Fresnel, and the transformation of cones (paper, 5.3.4).
#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "vector.h"

namespace metallic_paint {

// eta cos(theta_p), for the cosine outside and the relative index eta of the binder; negative
// squares, i.e. total reflection (eta < 1 only), give 0. With sin(theta) = eta sin(theta_p)
// (Snell), eta^2 cos^2(theta_p) = eta^2 - 1 + cos^2(theta). float: (eta - 1)(eta + 1) keeps its
// digits near eta = 1. Wider types keep them next to total reflection too, where the squares
// cancel: what rounding took from each is added at the end, and 1 goes from the one nearer to it,
// which is exact.
template <class T>
T eta_cos_refracted(T cos_theta, T eta) {
  T square;
  if constexpr (std::is_same_v<T, float>) {
    square = (eta - 1) * (eta + 1) + cos_theta * cos_theta;
  } else {
    const T a = eta * eta, b = cos_theta * cos_theta;
    const T rounding = std::fma(eta, eta, -a) + std::fma(cos_theta, cos_theta, -b);
    square = (a < T(0.5) ? (b - 1) + a : (a - 1) + b) + rounding;
  }
  return sqrt(max(square, T(0)));
}

// Of light that comes through the surface, the least in the binder.
template <class T>
T critical_cosine(T eta) {
  return sqrt(max((eta - 1) * (eta + 1), T(0))) / eta;
}

// 1 - r_eta(theta): the unpolarised transmittance of the surface, from Fresnel's T_s and T_p rather
// than as 1 - r, so that nothing cancels at grazing angles, and from quotients, so that nothing
// underflows. g = eta_cos_refracted(cos_theta, eta).
template <class T>
T fresnel_transmittance(T cos_theta, T g, T eta) {
  using W = Wide<T>;
  const W index = eta, cosine = cos_theta;
  const W s = cosine + g;
  const W p = index * index * cosine + g;
  if (s <= 0) return 0;  // grazing at eta = 1
  const W transmittance = 2 * ((cosine / s) * (g / s) + (index * cosine / p) * (index * g / p));
  return static_cast<T>(min(transmittance, W(1)));
}

// d omega inside / d omega outside = cos(theta)/(eta^2 cos(theta_p)) (paper, eq. 7 squared).
template <class T>
T solid_angle_ratio(T cos_theta, T g, T eta) {
  return cos_theta / (eta * g);
}

// By how much facets of the surface, tilted by delta, turn what they refract, per delta: by (g -
// c)/g in the plane of incidence and by (g - c)/eta across, from Snell's law on the tangents. A
// solid angle of tilts becomes the product's. c = cos(theta).
template <class T>
T solid_angle_of_facets(T cos_theta, T g, T eta) {
  return (g - cos_theta) * (g - cos_theta) / (eta * g);
}

// A direction closer to the surface, in rad, sees nothing of it: optical depths and the squares of
// the ways through a layer stay inside a float.
inline constexpr double kLeastCosine = 1e-18;

// The view's cosine. A smooth normal can turn away from the observer near a silhouette: 1e-4 there.
template <class T>
T seen_cosine(Vec3<T> normal, Vec3<T> view) {
  const T cosine = min(dot(normal, view), T(1));
  return cosine > T(kLeastCosine) ? cosine : T(1e-4);
}

// A flake that mirrors view and light into each other, by what lies along the surface and across
// it: refracted (paper, eq. 8), v = V/eta + n (cos(theta_p) - cos(theta)/eta), so v + v' = (t + n
// G)/eta with the tangential part of V + V', t = V + V' - n (cos(theta) + cos(theta')), and G = g +
// g'. Its length is s/eta = 2 cos(alpha) with s^2 = t^2 + G^2, and tan(beta) = t/G, so
// sin^2(beta/2) = (1 - G/s)/2 = t^2/(2 s (s + G)).
template <class T>
struct MirroringFlake {
  T s;
  T cos_alpha;       // angle on the flake
  T sin2_half_beta;  // flake normal to paint normal
};

template <class T>
MirroringFlake<T> mirroring_flake(Vec3<T> tangent, T along, T eta) {
  const T tangent_square = dot(tangent, tangent);
  const T s = sqrt(tangent_square + along * along);
  return {s, min(s / (2 * eta), T(1)), min(tangent_square / (2 * s * (s + along)), T(0.5))};
}

// Where view, light and surface leave a flake to mirror one into the other, and what is said of it.
template <class T>
struct Mirror {
  bool possible = false;      // both directions above the surface, none totally reflected
  T cos_view{}, cos_light{};  // outside
  T g_view{}, g_light{};      // eta times the cosines in the binder
  T cos_alpha{};              // angle on the flake
  T sin2_half_beta{};         // flake normal to paint normal
  Vec3<T> flake_normal{};
};

// Unit vectors that point away from the surface. The flake's normal halves the angle between both:
// (t + n G)/s.
template <class T>
Mirror<T> mirror_between(Vec3<T> normal, Vec3<T> view, Vec3<T> light, T eta) {
  Mirror<T> mirror;
  mirror.cos_view = min(dot(normal, view), T(1));
  mirror.cos_light = min(dot(normal, light), T(1));
  if (!(mirror.cos_view > T(kLeastCosine)) || !(mirror.cos_light > T(kLeastCosine))) return mirror;
  mirror.g_view = eta_cos_refracted(mirror.cos_view, eta);
  mirror.g_light = eta_cos_refracted(mirror.cos_light, eta);
  if (!(mirror.g_view > 0) || !(mirror.g_light > 0)) return mirror;
  const Vec3<T> tangent = (view + light) - normal * (mirror.cos_view + mirror.cos_light);
  const T along = mirror.g_view + mirror.g_light;
  const MirroringFlake<T> flake = mirroring_flake(tangent, along, eta);
  mirror.cos_alpha = flake.cos_alpha;
  mirror.sin2_half_beta = flake.sin2_half_beta;
  mirror.flake_normal = (tangent + normal * along) * (1 / flake.s);
  mirror.possible = true;
  return mirror;
}

}  // namespace metallic_paint
