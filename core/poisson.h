// SPDX-License-Identifier: Apache-2.0
//
// How many flakes sparkle: a Poisson deviate, or a binomial one where few flakes fill the pixel.
#pragma once

#include <algorithm>
#include <cmath>

#include "elementary.h"

namespace metallic_paint {

// So many steps of inversion, up to this mean: they leave out 0.3 % of it at most, which `scale`
// gives back, and up to 2.3 % of the variance. Above it the normal deviate's total variation
// distance from Poisson is at most 0.55 %, its mean off by 0.5 % at 2, 0.1 % at 3.3 and 0.01 % at
// 6, its variance by less than 1 %. Of binomial counts with 7 to 15 places the distance is up to
// 2.1 %, the mean off by 0.4 % and the variance by 1.9 % (tests/core/poisson_test.cpp).
inline constexpr int kCountSteps = 6;
inline constexpr double kMostInverted = 2;

// Means above this count as this: a float still holds their sum with the deviate.
inline constexpr double kMaxMeanCount = 1e36;

template <class T>
struct Count {
  T number{};  // a whole number: exact to 2^24 in float
  T scale{1};  // of a number above 0: the mean over the mean of `number`, where that is known
};

// -ln(1 - p)/p for 0 <= p <= 1/2.
template <class T>
T logarithm_of_rest(T p) {
  if (p < T(0.03)) return 1 + p * (T(0.5) + p * (T(1) / 3 + p * (T(0.25) + p * T(0.2))));
  return -logarithm(1 - p) / p;
}

// The count for a uniform deviate u in (0, 1); u near 0 gives the large counts. slots = 0: Poisson.
// slots = k > 0: binomial, k places for a sparkle, each taken with probability mean/k; a mean above
// k counts as k. mean >= 0.
//
// Both laws are p_n = p_(n - 1) (b/n - a), with p = mean/k: a = p/(1 - p), b = (mean + p)/(1 - p)
// (Panjer 1981); Poisson has p = 0. Of more than half of the places the empty ones are counted.
// Above the inverted means, Cornish and Fisher's first terms with the skewness (1 - 2 p)/spread, up
// to where they turn back, and less the variance 1/12 that rounding adds.
template <class T>
Count<T> draw_count(T mean, int slots, T u) {
  Count<T> count;
  if (!(mean > 0)) return count;
  const T places = static_cast<T>(slots);
  const bool of_empty = slots > 0 && 2 * mean > places;
  const T lambda = of_empty ? max(places - mean, T(0)) : min(mean, T(kMaxMeanCount));
  const T v = of_empty ? 1 - u : u;
  const T p = slots > 0 ? lambda / places : T(0);
  T n = 0, mean_of_n = lambda;
  if (lambda <= T(kMostInverted) || (slots > 0 && slots <= kCountSteps)) {
    const T y = lambda * logarithm_of_rest(p);
    const T a = p / (1 - p), b = (lambda + p) / (1 - p);
    T term = exponential(-y);
    T survival = y * mean_transmittance(y);  // P(n >= k)
    mean_of_n = survival;
    if (!(v < survival || of_empty)) return count;  // of most pixels, where flakes are few
    for (int k = 1; k <= kCountSteps; ++k) {
      if (v < survival) n = static_cast<T>(k);
      term = term * (b / static_cast<T>(k) - a);
      survival = survival - term;
      if (k < kCountSteps) mean_of_n = mean_of_n + survival;
    }
  } else {
    const T w = -normal_quantile(v), c = (1 - 2 * p) / 6;
    const T spread = sqrt(lambda * (1 - p) - T(1) / 12);
    if (spread + 2 * c * w > 0) n = floor(lambda + T(0.5) + (spread * w + c * (w * w - 1)));
  }
  if (slots > 0) n = min(n, places);
  count.number = max(of_empty ? places - n : n, T(0));
  const T mean_of_count = of_empty ? places - mean_of_n : mean_of_n;
  if (mean_of_count > 0) count.scale = (of_empty ? places - lambda : lambda) / mean_of_count;
  return count;
}

}  // namespace metallic_paint
