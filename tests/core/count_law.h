// SPDX-License-Identifier: Apache-2.0
//
// The law of the counts that are drawn, found exactly and not sampled: the count falls with its
// deviate, so for each n the share of all deviates that give more follows by bisection.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "poisson.h"

namespace core_tests {

// ln of the exact probability of n: Poisson (slots = 0) or binomial.
inline double log_probability(double mean, int slots, double n) {
  if (slots == 0) return n * std::log(mean) - mean - std::lgamma(n + 1);
  const double p = mean / slots, rest = slots - n;
  return std::lgamma(slots + 1.0) - std::lgamma(n + 1) - std::lgamma(rest + 1) + n * std::log(p) +
         (rest > 0 ? rest * std::log1p(-p) : 0);
}

// Deviate number m of 2^32, as uniform_deviate gives it.
template <class T>
T deviate_of_count(std::uint64_t m) {
  return static_cast<T>(std::clamp(static_cast<float>(m) * 0x1p-32f, 0x1p-33f, 1 - 0x1p-24f));
}

// How many of them, times `finer`, give more than n.
template <class T>
std::uint64_t deviates_above(T mean, int slots, double n, T finer = 1) {
  std::uint64_t low = 0, high = 1ull << 32;
  while (low < high) {
    const std::uint64_t m = (low + high) / 2;
    const T count = metallic_paint::draw_count(mean, slots, deviate_of_count<T>(m) * finer).number;
    (static_cast<double>(count) > n ? low : high) = static_cast<double>(count) > n ? m + 1 : m;
  }
  return low;
}

struct CountLaw {
  std::vector<double> n, probability;
  double scale = 1;               // the drawn sums are multiplied by it
  double mean = 0, variance = 0;  // of scale * n
};

template <class T>
CountLaw law_of_counts(T mean, int slots) {
  CountLaw law;
  law.scale = static_cast<double>(metallic_paint::draw_count(mean, slots, T(0x1p-33)).scale);
  const auto lambda = static_cast<double>(mean);
  const double reach = 10 * std::sqrt(lambda) + 30;
  double above = 0x1p32, first = 0, second = 0;
  for (double n = std::max(0.0, std::floor(lambda - reach)); above > 0; ++n) {
    const auto next = static_cast<double>(deviates_above(mean, slots, n));
    const double p = (above - next) * 0x1p-32, d = n - lambda;
    above = next;
    if (!(p > 0)) continue;
    law.n.push_back(n);
    law.probability.push_back(p);
    first += p * d;
    second += p * d * d;
  }
  law.mean = law.scale * (lambda + first);
  law.variance = law.scale * law.scale * (second - first * first);
  return law;
}

}  // namespace core_tests
