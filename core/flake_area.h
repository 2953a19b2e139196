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

// Deviates further out than this are below the rounding of every number type in use.
inline constexpr double kNormalReach = 8.5;

// E[X].
template <class T>
T area_mean(T spread) {
  if (spread * T(kNormalReach) <= 1) return 1;
  const T density = normal_density(1 / spread);
  return normal_cdf(1 / spread, density) + spread * density;
}

// E[X^2]/E[X]^2.
template <class T>
T area_square(T spread) {
  const T variance = spread * spread;
  if (spread * T(kNormalReach) <= 1) return 1 + variance;
  const T density = normal_density(1 / spread);
  const T positive = normal_cdf(1 / spread, density), edge = spread * density;
  const T mean = positive + edge;
  return ((1 + variance) * positive + edge) / (mean * mean);
}

// E[min(X, cap)], of flakes seen through a pixel that `cap` mean areas would fill; `whole` is E[X].
// Relative error: double 1e-14, float 2e-6.
template <class T>
T capped_area_mean(T spread, T cap, T whole) {
  if (cap >= 1 + spread * T(kNormalReach)) return whole;
  if (spread * T(kNormalReach) <= 1 - cap) return cap;
  if (cap < spread) {
    // integral over x from 0 to cap of P(X > x): the closed form below is a small difference of
    // large terms here.
    const GaussRule<T>& rule = gauss_rule<T>();
    T mean = 0;
    for (int i = 0; i < kGaussPoints<T>; ++i) {
      mean = mean + rule.weight[i] * normal_cdf((1 - cap * rule.node[i]) / spread);
    }
    return cap * mean;
  }
  // E[X] - E[(X - cap)+].
  const T d = (1 - cap) / spread;
  const T density = normal_density(d);
  return whole - ((1 - cap) * normal_cdf(d, density) + spread * density);
}

// E[min(X, cap)^2].
template <class T>
T capped_area_square(T spread, T cap) {
  const T variance = spread * spread;
  if (spread * T(kNormalReach) <= 1 - cap) return cap * cap;
  if (cap < spread) {
    const GaussRule<T>& rule = gauss_rule<T>();
    T square = 0;
    for (int i = 0; i < kGaussPoints<T>; ++i) {
      const T x = cap * rule.node[i];
      square = square + rule.weight[i] * normal_cdf((1 - x) / spread) * x;
    }
    return 2 * cap * square;
  }
  const T mean = area_mean(spread), whole = area_square(spread) * mean * mean;
  if (cap >= 1 + spread * T(kNormalReach)) return whole;
  const T d = (1 - cap) / spread;
  const T density = normal_density(d);
  return whole -
         ((1 + variance - cap * cap) * normal_cdf(d, density) + (1 + cap) * (spread * density));
}

}  // namespace metallic_paint
