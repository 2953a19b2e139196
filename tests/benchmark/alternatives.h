// SPDX-License-Identifier: Apache-2.0
//
// Other ways to draw a pixel's sparkles than the core's, to be measured beside it. Each is a
// functor (expected, key of the pixel).
#pragma once

#include <algorithm>
#include <cmath>

#include "one_by_one.h"
#include "sparkles.h"

namespace trade {

using namespace metallic_paint;

struct Shipped {
  template <class T>
  Sparkles<T> operator()(const ExpectedSparkles<T>& expected, HashKey key) const {
    return draw_sparkles(expected, key);
  }
};

// Sequential inversion at every mean, in long double: e^-mean is a number to this mean.
inline constexpr double kMostInverted = 11000;

// As draw_count, but exact. A binomial count, which counts the empty places of more than half, is
// exact there up to a few.
inline int exact_count(double mean, int slots, double u) {
  if (slots > 0) return static_cast<int>(draw_count(mean, slots, u).number);
  long double term = std::exp(-static_cast<long double>(mean));
  long double survival = -std::expm1(-static_cast<long double>(mean));
  int n = 0;
  while (u < survival) {
    term *= mean / ++n;
    if (n > mean && survival - term == survival) break;
    survival -= term;
  }
  return n;
}

// The paper's. Another `stream` gives other sparkles with the same count.
struct OneByOne {
  float stream = 0;
  template <class T>
  Sparkles<T> operator()(const ExpectedSparkles<T>& expected, HashKey key) const {
    if (!(expected.mean_count > 0)) return {};
    const int n = exact_count(static_cast<double>(expected.mean_count), expected.slots,
                              static_cast<double>(uniform_deviates(key, 0).x));
    const Rgb<T> sum = sum_one_by_one(expected, hashed(key, stream), n);
    return {static_cast<T>(n), map(sum, [&](T t) { return std::min(t, expected.ceiling); })};
  }
};

struct CountTimesMean {
  template <class T>
  Sparkles<T> operator()(const ExpectedSparkles<T>& expected, HashKey key) const {
    if (!(expected.mean_count > 0)) return {};
    const T u = static_cast<T>(uniform_deviates(key, 0).x);
    const T n = draw_count(expected.mean_count, expected.slots, u).number;
    return {n, mean_radiance(expected) * (n / expected.mean_count)};
  }
};

struct MeanOnly {
  template <class T>
  Sparkles<T> operator()(const ExpectedSparkles<T>& expected, HashKey) const {
    return {expected.mean_count, mean_radiance(expected)};
  }
};

}  // namespace trade
