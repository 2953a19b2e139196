// SPDX-License-Identifier: Apache-2.0
//
// How many flakes sparkle: a Poisson deviate, or a binomial one where few flakes fill the pixel.
#pragma once

#include <algorithm>
#include <cmath>

#include "elementary.h"

namespace metallic_paint {

// From this mean on the closed form serves. There its total variation distance from Poisson is
// 9.1e-5 and its variance right to 6e-6 relative, better with every larger mean; its mean is exact
// (tests/core/poisson_test.cpp). Below, inversion is exact to rounding (float: total variation
// 2e-6, variance right to 5e-6) and takes at most 150 steps.
inline constexpr int kPoissonClosedForm = 32;

// Means above this count as this: a float still holds their sum with the deviate.
inline constexpr double kMaxMeanCount = 1e36;

// The count N of sparkles for a uniform deviate u in (0, 1]; u near 0 gives the large counts, whose
// small probabilities are resolved there. slots = 0: Poisson. slots = k > 0: binomial, k places for
// a sparkle, each taken with probability mean/k; a mean above k counts as k. mean >= 0. Bounded
// work for every mean. A whole number in T: exact to 2^24 in float.
template <class T>
T count_deviate(T mean, int slots, T u) {
  if (!(mean > 0)) return 0;
  if (slots > 0) {
    const T q = mean / static_cast<T>(slots);
    if (q >= 1) return static_cast<T>(slots);
    // Counts the taken places or the empty ones, whichever are rarer: (1-p)^k cannot underflow.
    const T p = q > T(0.5) ? 1 - q : q;
    // P(n > 0) = 1 - (1-p)^k = p (1 + (1-p) + (1-p)^2 + ...): nothing cancels.
    T term = 1;
    T survival = 0;
    for (int k = 0; k < slots; ++k) {
      survival = survival * (1 - p) + p;
      term = term * (1 - p);
    }
    const T odds = p / (1 - p);
    int n = 0;
    if (q > T(0.5)) {
      T cumulated = term;
      while (n < slots && u >= cumulated) {
        n = n + 1;
        term = term * (static_cast<T>(slots - n + 1) / static_cast<T>(n) * odds);
        cumulated = cumulated + term;
      }
      return static_cast<T>(slots - n);
    }
    while (n < slots && u < survival) {
      n = n + 1;
      term = term * (static_cast<T>(slots - n + 1) / static_cast<T>(n) * odds);
      survival = survival - term;
    }
    return static_cast<T>(n);
  }
  if (mean < T(kPoissonClosedForm)) {
    // Sequential inversion of the survival function: N = #{k : u < P(N > k)}. P(N > k) is
    // 1 - p_0 - ... - p_k up to two standard deviations above the mean; farther out that would be
    // all rounding (float: 8e-5 of the variance), and it is p_k+1 + p_k+2 + ..., summed first.
    const T turn = mean + 2 * sqrt(mean);
    T n = 0;
    T term = exponential(-mean);
    T survival = mean * mean_transmittance(mean);
    while (u < survival && n < turn) {
      n = n + 1;
      term = term * mean / n;
      survival = survival - term;
    }
    if (n < turn) return n;
    T last = n;
    T tail = term;
    T previous;
    survival = 0;
    do {
      last = last + 1;
      tail = tail * mean / last;
      previous = survival;
      survival = survival + tail;
    } while (survival > previous);
    while (u < survival && n < last) {
      n = n + 1;
      term = term * mean / n;
      survival = survival - term;
    }
    return n;
  }
  // Cornish-Fisher expansion of the quantile to order mean^(-1/2) (Giles 2016, eq. for Q_N2); w is
  // antisymmetric in u so that large counts come from small u.
  const T lambda = min(mean, T(kMaxMeanCount));
  const T root = sqrt(lambda);
  const T w = -normal_quantile(u);
  const T shift = T(1) / 3 + w * w / 6 - w * (T(1) / 36 + w * w / 72) / root;
  return max(floor(lambda + (root * w + shift)), T(0));
}

}  // namespace metallic_paint
