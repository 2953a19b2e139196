// SPDX-License-Identifier: Apache-2.0
//
// The diffuse lobe of the mixture (mixture.h): what substrate and pigment have scattered, M_d(v) of
// a white world.
//
// Light that grazes the binder enters it less, by the transmittance 1 - r of its surface. Inside no
// way is steeper than the critical angle, but light that comes so is absorbed more on its way, and
// flakes send more of it back. So
//   f = M_d(v)/pi h(cos(theta'))/(cos(theta') <h>),  h(c) = c (1 - r) a,
// a function of the slant alone (by_slant), <h> the mean over a white world, which leaves the
// albedo at M_d(v).
//
// Cycles has a closure, diffuse_ramp, whose f cos(theta') is 1/pi times a ramp of eight colours,
// linear between the cosines 0, 1/7, ..., 1. That is straight up to 1/7, the last 8 degrees, where
// h is a parabola that turns into a line. So a second closure bends the foot there: diffuse_toon,
// whose f cos(theta') is constant from the cosine 1/7 on and falls to 0 at 1/14, linearly in the
// angle. The ramp is lowered by as much. The foot is then a line up to 1/14 and another one up to
// 1/7. The second is a chord of a curve that bends upwards, so its ends are low by kChord: the lobe
// is within 3.0 % of h up to 86 degrees, for eta of 1.05 to 2.5. At 88 degrees it is 1.8 times h,
// where the ramp alone was 2.5 times (eta = 1.5). All is divided by the closures' own mean, so that
// no light is lost whatever they miss.
//
// What it shows of the random walk's light, where the mixture is mostly this lobe (200 paints,
// docs/fits.md), and what a Lambertian lobe would:
//
//   light at           0      45     60     75     80     85
//   median             1.00   1.00   0.99   1.00   1.00   1.01
//   5 %                0.86   0.95   0.94   0.93   0.92   0.94
//   95 %               1.14   1.10   1.09   1.06   1.07   1.11
//   Lambertian, median 0.95   0.96   0.99   1.20   1.46   2.29
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "layer.h"
#include "mixture.h"
#include "refraction.h"

namespace metallic_paint {

inline constexpr int kRampColours = 8;

template <class T>
struct Ramp {
  std::array<Rgb<T>, kRampColours> colours{};  // of diffuse_ramp
  Rgb<T> foot{};                               // of diffuse_toon: its f cos(theta') times pi
};

// Fitted to finite flakes, 150 paints of indices from 1.4 to 1.6 and coverages from 0.1 to 3
// (tests/fits/fit_mixture.py fits them anew). The mean relative error of the whole paint is 2.8 %
// on 150 others; without the first it would be 3.8 %, without the last 3.0 %. The second at 0 with
// the first at 1.1 makes 2.9 %.
inline constexpr double kFlakesBySlant = 2, kTiltBySlant = 1.09;
inline constexpr double kAbsorptionBySlant = 1.5;

// z of a, per slant 1 - cos(theta_p'): what flakes send back more, less what is absorbed. c is the
// flakes' coverage as hot_spot.h has it. The more they are tilted, which alpha of the glossy lobe
// (mixture.h) tells, the less do they send slanted light back more than steep light.
template <class T>
Rgb<T> by_slant(const Layer<T>& layer) {
  const T rayleigh = layer.rayleigh_depth;
  const Rgb<T> absorption =
      map(layer.binder_depth, [&](T depth) { return max(depth - rayleigh, T(0)); });
  const T per_flakes = T(kFlakesBySlant) * (1 - T(kTiltBySlant) * glossy_roughness(layer));
  return layer.shared_blocking * per_flakes - absorption * T(kAbsorptionBySlant);
}

// h at a cosine outside. a = 1/(1 - z + z^2/2) is e^z for small z and level at 2 from z = 1 on.
template <class T>
Rgb<T> let_in(T cosine, T eta, Rgb<T> slanted) {
  const T g = eta_cos_refracted(cosine, eta);
  const T slant = 1 - g / eta;
  const T entering = cosine * fresnel_transmittance(cosine, g, eta);
  return map(slanted, [&](T per_slant) {
    const T z = min(per_slant * slant, T(1));
    return entering / (1 - z * (1 - z * T(0.5)));
  });
}

inline constexpr double kChord = 0.03;
// Of diffuse_toon: its two angles over pi/2, acos(1/7) and acos(1/14) - acos(1/7); and the integral
// of what it shows over the cosines, 1 - (sin(a) - sin(b))/(a - b) of the angles b = acos(1/7) and
// a = acos(1/14).
inline constexpr double kFootSize = 0.908742103;
inline constexpr double kFootSmooth = 0.045746299;
inline constexpr double kFootMean = 0.892811016;

template <class T>
Ramp<T> make_ramp(const Layer<T>& layer) {
  const T eta = layer.eta;
  const Rgb<T> slanted = by_slant(layer);
  Ramp<T> ramp;
  // Twice h(1/14) is where a line through it is at 1/7.
  const Rgb<T> first = let_in(T(1) / 14, eta, slanted) * T(2 * (1 - kChord));
  const Rgb<T> end = let_in(T(1) / 7, eta, slanted) * T(1 - kChord);
  const Rgb<T> foot = map(end - first, [](T x) { return max(x, T(0)); });
  const auto above = [&](T cosine) {
    return map(let_in(cosine, eta, slanted) - foot, [](T x) { return max(x, T(0)); });
  };
  const Rgb<T> second = above(T(2) / 7), third = above(T(3) / 7), fourth = above(T(4) / 7);
  const Rgb<T> fifth = above(T(5) / 7), sixth = above(T(6) / 7), last = above(T(1));
  // The trapezoidal rule, exact for lines, of 2 times the ramp over the cosine; and the foot.
  const Rgb<T> mean = (first + second + third + fourth + fifth + sixth) * (T(2) / 7) +
                      last * (T(1) / 7) + foot * T(2 * kFootMean);
  ramp.colours = {Rgb<T>{},      first / mean, second / mean, third / mean,
                  fourth / mean, fifth / mean, sixth / mean,  last / mean};
  ramp.foot = foot / mean;
  return ramp;
}

// pi f cos(theta') of both closures for the albedo 1.
template <class T>
Rgb<T> ramp_at(const Ramp<T>& ramp, T cos_light) {
  const T cosine = clamp(cos_light, T(0), T(1));
  const T place = cosine * (kRampColours - 1);
  const auto i = static_cast<std::size_t>(min(place, T(kRampColours - 2)));
  const T offset = place - static_cast<T>(i);
  constexpr T quarter_turn = std::numbers::pi_v<T> / 2;
  const T beyond = std::acos(cosine) / quarter_turn - T(kFootSize);
  const T shown = clamp(1 - beyond / T(kFootSmooth), T(0), T(1));
  return ramp.colours[i] * (1 - offset) + ramp.colours[i + 1] * offset + ramp.foot * shown;
}

}  // namespace metallic_paint
