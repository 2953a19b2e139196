// SPDX-License-Identifier: Apache-2.0
//
// The flakes' single scattering as a BRDF.
#pragma once

#include <algorithm>
#include <numbers>

#include "hot_spot.h"
#include "layer.h"
#include "orientation.h"
#include "refraction.h"
#include "vector.h"

namespace metallic_paint {

// The mean as a BRDF (1/sr): single scattering by the flakes under light of any size and kind,
//   f = D H <S> p(n_f) r_p A (1 - r)(1 - r')/(4 eta^2 cos(theta_p) cos(theta'_p)),
// published: times cos(theta_p)/cos(theta), which is not reciprocal. Unit vectors, all pointing
// away from the surface; 0 where one of them lies below it.
template <class T>
Rgb<T> flake_brdf(const Layer<T>& layer, Vec3<T> normal, Vec3<T> view, Vec3<T> light) {
  using W = Wide<T>;
  const W eta = layer.eta;
  const Mirror<W> mirror = mirror_between(Vec3<W>(normal), Vec3<W>(view), Vec3<W>(light), eta);
  if (!mirror.possible) return {};
  const T apart =
      static_cast<T>(ways_apart(Vec3<W>(normal), Vec3<W>(view), mirror.cos_view, mirror.g_view,
                                Vec3<W>(light), mirror.cos_light, mirror.g_light));
  const Rgb<T> slant =
      there_and_back(layer, slant_depth_of(layer, static_cast<T>(min(mirror.g_view / eta, W(1)))),
                     slant_depth_of(layer, static_cast<T>(min(mirror.g_light / eta, W(1)))), apart);
  const W exit = layer.radiometry == Radiometry::published ? eta * mirror.cos_view : mirror.g_view;
  const W surface = fresnel_transmittance(mirror.cos_view, mirror.g_view, eta) *
                    fresnel_transmittance(mirror.cos_light, mirror.g_light, eta);
  Rgb<T> sum{};
  for (int i = 0; i < layer.species; ++i) {
    const Flakes<T>& flakes = layer.flakes[static_cast<std::size_t>(i)];
    const W p = orientation_density(flakes.orientation, mirror.sin2_half_beta) /
                (2 * std::numbers::pi_v<W>);
    sum = sum + coating_reflectance(flakes.coating, static_cast<T>(mirror.cos_alpha)) *
                    static_cast<T>(flakes.coverage * p * surface / (4 * exit * mirror.g_light));
  }
  return sum * mean_transmittance(slant);
}

}  // namespace metallic_paint
