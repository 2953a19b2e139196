// SPDX-License-Identifier: Apache-2.0
//
// The diffuse lobe of the mixture (mixture.h): what substrate and pigment have scattered, M_d(v) of
// a white world.
//
// Light that grazes the binder enters it less, by the transmittance 1 - r of its surface; that
// flakes and absorption then hide the substrate more is little, for inside no way is steeper than
// the critical angle. So
//   f = M_d(v)/pi (1 - r(theta'))/<1 - r>,
// the mean over a white world, which leaves the albedo at M_d(v). f is reciprocal as far as M_d(v)
// goes with 1 - r(theta).
//
// Cycles has a closure, diffuse_ramp, whose f cos(theta') is 1/pi times a ramp of eight colours,
// linear between the cosines 0, 1/7, ..., 1. Here they are cos(theta') (1 - r), divided by the mean
// of the ramp itself, so that no light is lost whatever the ramp misses. Below 1/7 (the last 8
// degrees) it is a line from 0; of the lines that is the one through the true value at 3/4 of
// 1/7, where a line and a parabola from 0 agree by least squares: the integrals of x^3 and x^2 over
// [0, 1] are as 3/4.
//
// What it shows of the random walk's light, where the mixture is mostly this lobe (200 paints,
// docs/fits.md), and what a Lambertian lobe would:
//
//   light at           0      45     60     75     80     85
//   median             1.01   1.00   1.00   0.99   0.92   1.16
//   5 %                0.89   0.95   0.93   0.88   0.83   1.04
//   95 %               1.12   1.12   1.13   1.16   1.11   1.43
//   Lambertian, median 0.95   0.96   1.00   1.20   1.47   2.31
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "refraction.h"

namespace metallic_paint {

inline constexpr int kRampColours = 8;

template <class T>
using Ramp = std::array<T, kRampColours>;

// The share that enters the binder.
template <class T>
T let_in(T cosine, T eta) {
  return fresnel_transmittance(cosine, eta_cos_refracted(cosine, eta), eta);
}

template <class T>
Ramp<T> make_ramp(T eta) {
  Ramp<T> ramp{};
  ramp[1] = T(1) / 7 * let_in(T(0.75) / 7, eta);
  ramp[2] = T(2) / 7 * let_in(T(2) / 7, eta);
  ramp[3] = T(3) / 7 * let_in(T(3) / 7, eta);
  ramp[4] = T(4) / 7 * let_in(T(4) / 7, eta);
  ramp[5] = T(5) / 7 * let_in(T(5) / 7, eta);
  ramp[6] = T(6) / 7 * let_in(T(6) / 7, eta);
  ramp[7] = let_in(T(1), eta);
  // The trapezoidal rule, exact for lines, of 2 times the ramp over the cosine.
  const T mean =
      T(2) / 7 * (ramp[1] + ramp[2] + ramp[3] + ramp[4] + ramp[5] + ramp[6]) + ramp[7] / 7;
  for (T& colour : ramp) colour = colour / mean;
  return ramp;
}

// pi f cos(theta') of the closure for the albedo 1.
template <class T>
T ramp_at(const Ramp<T>& ramp, T cos_light) {
  const T place = clamp(cos_light, T(0), T(1)) * (kRampColours - 1);
  const auto i = static_cast<std::size_t>(min(place, T(kRampColours - 2)));
  const T offset = place - static_cast<T>(i);
  return ramp[i] * (1 - offset) + ramp[i + 1] * offset;
}

}  // namespace metallic_paint
