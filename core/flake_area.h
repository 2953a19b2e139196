// SPDX-License-Identifier: Apache-2.0
//
// The area of a flake: a normal deviate of mean <S> and standard deviation sigma_S (paper, 5.3.1).
// A deviate below zero is a flake of no area. Areas here are in units of the deviate's mean: X =
// max(0, 1 + s w) with the relative spread s = sigma_S/<S> and a standard normal w. The moments
// below are those of X itself, so every mean and variance of the model is exact for any spread; for
// s <= 0.25 they are 1 and 1 + s^2 to 1e-5.
#pragma once

#include <cmath>

#include "elementary.h"
#include "quadrature.h"

namespace metallic_paint {

template <class T>
struct AreaMoments {
  T mean, square, cube;  // E[X], E[X^2], E[X^3]
};

// Deviates further out than this are below the rounding of every number type in use.
inline constexpr double kNormalReach = 8.5;

template <class T>
AreaMoments<T> area_moments(T spread) {
  const T variance = spread * spread;
  if (spread * T(kNormalReach) <= 1) return {1, 1 + variance, 1 + 3 * variance};
  const T density = normal_density(1 / spread);
  const T positive = normal_cdf(1 / spread, density);
  const T edge = spread * density;
  return {positive + edge, (1 + variance) * positive + edge,
          (1 + 3 * variance) * positive + (1 + 2 * variance) * edge};
}

// E[min(X, cap)^n], n = 1, 2, 3: flakes seen through a pixel that `cap` mean areas would
// fill. Relative error: double 1e-14, float 2e-6.
template <class T>
AreaMoments<T> capped_area_moments(T spread, T cap, AreaMoments<T> whole) {
  if (cap >= 1 + spread * T(kNormalReach)) return whole;
  if (spread * T(kNormalReach) <= 1 - cap) return {cap, cap * cap, cap * cap * cap};
  if (cap < spread) {
    // integral over x from 0 to cap of n x^(n-1) P(X > x): the closed form below is a small
    // difference of large terms here.
    const GaussRule<T>& rule = gauss_rule<T>();
    T mean = 0, square = 0, cube = 0;
    for (int i = 0; i < kGaussPoints<T>; ++i) {
      const T x = cap * rule.node[i];
      const T term = rule.weight[i] * normal_cdf((1 - x) / spread);
      mean = mean + term;
      square = square + term * x;
      cube = cube + term * x * x;
    }
    return {cap * mean, 2 * cap * square, 3 * cap * cube};
  }
  // E[X^n] - E[(X^n - cap^n)+].
  const T d = (1 - cap) / spread;
  const T density = normal_density(d);
  const T above = normal_cdf(d, density);
  const T edge = spread * density;
  const T variance = spread * spread, cap2 = cap * cap;
  return {whole.mean - ((1 - cap) * above + edge),
          whole.square - ((1 + variance - cap2) * above + (1 + cap) * edge),
          whole.cube -
              ((1 + 3 * variance - cap2 * cap) * above + (1 + cap + cap2 + 2 * variance) * edge)};
}

}  // namespace metallic_paint
