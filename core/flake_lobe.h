// SPDX-License-Identifier: Apache-2.0
//
// The flakes' single scattering of light that has no sparkles: of the world, of area lights, of
// neighbours. It is the mean over random flakes. For each sample a renderer takes one flake, and
// looks along the direction that it mirrors to the observer.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "close_up.h"
#include "hot_spot.h"
#include "layer.h"

namespace metallic_paint {

// Between the ends of (0, 1), where rounding may put a share of an interval.
template <class T>
T inside_unit(T x) {
  return clamp(x, T(1e-7), T(1) - T(1e-7));
}

// Half-angle of the cone in which a flake's mirror direction is widened, so that area lights are
// sampled as well, and lights beyond the slots seen. In units of eta tilt: the tilt turns the
// mirror direction by 2 eta tilt. The disc adds a quarter of its radius squared to that variance,
// and by that the tilt is drawn narrower. What is left is 4 % of a lamp's light at most,
// 1 % in 95 % (60 paints under round lamps of 0.1 to 0.5 rad; tests/fits/lobe_spread.cpp).
inline constexpr double kLobeSpread = 0.33;
inline constexpr double kWidestLobe = 0.1;

template <class T>
struct MirroredSample {
  Vec3<T> direction;  // outside, unit, away from the surface
  Rgb<T> weight{};    // what it shows of the radiance from there; 0 if it shows nothing
  T spread{};         // half-angle of the cone about the direction from which it shows radiance
};

// A flake's species is drawn by covered area, its normal m from p. The mirror law takes m to the
// light's direction in the binder, dw_m = dw/(4 |v . m|), and refraction takes that outside. So the
// direction outside has the density
//   q = p/(4 |v . m|) cos(theta')/(eta^2 cos(theta'_p)),
// and with the BRDF f of flake_brdf.h the sample's weight is
//   f cos(theta')/q = D H <S> |v . m|/cos(theta_p) r_p A (1 - r)(1 - r'), <S> over all species.
// The spread of a flake's own mirror image is left out. That shows where it is not narrow against
// the tilt: under the sun a spread of 0.1 rad at a tilt of 0.15 changes the mean by 3 %.
// Of a species that is seen close up the flake is the one that the sample sees (`firsts`, one for
// each species), or none; drawn with the probability of its species' share of the covered area.
// u and w are uniform deviates in (0, 1). spread is kLobeSpread as in the shader, or 0 for the law
// itself. Blender has the same mean but not the same bits: OSL's own sin and cos place the azimuth.
template <class T>
MirroredSample<T> sample_flake(const Layer<T>& layer, Vec3<T> normal, Vec3<T> view, T u, T w,
                               T spread = 0, const FirstFlake<T>* firsts = nullptr) {
  MirroredSample<T> sample{normal};
  const T eta = layer.eta;
  const T cos_view = min(dot(normal, view), T(1));
  if (!(cos_view > T(kLeastCosine))) return sample;
  const T g_view = eta_cos_refracted(cos_view, eta);
  if (!(g_view > 0)) return sample;
  const Vec3<T> v = (view + normal * (g_view - cos_view)) / eta;
  if (!(layer.coverage > 0)) return sample;

  // u picks the species, and what is left of it the tilt.
  T at = u * layer.coverage;
  std::size_t i = 0;
  while (i + 1 < static_cast<std::size_t>(layer.species) && at >= layer.flakes[i].coverage) {
    at = at - layer.flakes[i].coverage;
    ++i;
  }
  const Flakes<T>& flakes = layer.flakes[i];
  const FirstFlake<T> first = firsts != nullptr ? firsts[i] : FirstFlake<T>{};
  if (first.close && !first.seen) return sample;
  Vec3<T> m = first.normal;
  SampledTilt<T> tilt{};
  if (first.close) {
    // The flake's own cone, pi epsilon^2, as it leaves the binder.
    sample.spread = min(eta * sqrt(flakes.solid_angle / std::numbers::pi_v<T>), T(kWidestLobe));
  } else {
    const T rest = layer.species > 1 ? inside_unit(at / max(flakes.coverage, T(1e-30))) : u;
    tilt = sample_tilt(flakes.orientation, rest);
    const T turned = eta * flakes.orientation.tilt;
    sample.spread = min(spread * turned, T(kWidestLobe));
    const T widened = sample.spread / (4 * turned);
    const T h = tilt.sin2_half_beta * (1 - widened * widened);
    const T sin_beta = 2 * sqrt(h * (1 - h)), phi = 2 * std::numbers::pi_v<T> * w;
    // Any two directions across the normal.
    Vec3<T> across = abs(normal.x) < T(0.6) ? Vec3<T>{1, 0, 0} : Vec3<T>{0, 1, 0};
    across = across - normal * dot(normal, across);
    across = across / length(across);
    const Vec3<T> other = cross(normal, across);
    m = normal * (1 - 2 * h) + across * (sin_beta * std::cos(phi)) +
        other * (sin_beta * std::sin(phi));
  }

  const T facing = dot(m, v);
  const Vec3<T> l = m * (2 * facing) - v;
  const T along = dot(l, normal);
  if (!(along > 0)) return sample;  // deeper into the layer
  const Vec3<T> tangent = (l - normal * along) * eta;
  const T cos2_light = 1 - dot(tangent, tangent);
  if (!(cos2_light > 0)) return sample;  // total reflection
  const T cos_light = sqrt(cos2_light), g_light = eta * along;
  if (!(cos_light > T(kLeastCosine))) return sample;
  sample.direction = tangent + normal * cos_light;

  const T cos_alpha = min(abs(facing), T(1));
  const T cos_view_in = min(g_view / eta, T(1)), cos_light_in = min(along, T(1));
  const Rgb<T> slant =
      there_and_back(layer, slant_depth_of(layer, cos_view_in), slant_depth_of(layer, cos_light_in),
                     length(v / cos_view_in - l / along));
  const T exit = layer.radiometry == Radiometry::published ? cos_view : cos_view_in;
  // 1 - r goes to zero with the cosine of the exit, A with its inverse: neither overflows.
  const T through = fresnel_transmittance(cos_view, g_view, eta) / exit *
                    fresnel_transmittance(cos_light, g_light, eta);
  const Rgb<T> reflectance = coating_reflectance(flakes.coating, cos_alpha);
  if (first.close) {
    sample.weight = shown_by(first, reflectance, slant) *
                    (through * cos_view_in * (layer.coverage / flakes.coverage));
  } else {
    sample.weight = reflectance *
                    map(slant, [&](T x) { return layer.coverage * mean_transmittance(x); }) *
                    (through * tilt.weight * cos_alpha);
  }
  return sample;
}

}  // namespace metallic_paint
