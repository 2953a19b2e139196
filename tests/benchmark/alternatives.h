// SPDX-License-Identifier: Apache-2.0
//
// Other ways to draw the count and the sum of a pixel's sparkles than the core's, to be measured
// beside it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "sparkles.h"

namespace trade {

using namespace metallic_paint;

// ---------------------------------------------------------------------------------------------
// Counts: a functor (mean, slots, words). Binomial counts (slots > 0) are always the core's.

enum class Form { cornish_fisher, wilson_hilferty, normal };

// A closed form for the Poisson deviate of the uniform deviate u. Large counts come from small u.
template <Form form, class T>
T closed_form(T mean, T u) {
  const T w = -normal_quantile(u);
  const T root = std::sqrt(mean);
  if (form == Form::cornish_fisher) {  // core/poisson.h's, here for every mean
    const T shift = T(1) / 3 + w * w / 6 - w * (T(1) / 36 + w * w / 72) / root;
    return std::max(std::floor(mean + (root * w + shift)), T(0));
  }
  if (form == Form::wilson_hilferty) {
    // Mean, variance and skewness of the Poisson law are those of G - mean, G of the gamma law of
    // shape 4 mean and scale 1/2, whose cube root is nearly normal (Wilson and Hilferty 1931).
    const T c = 1 - 1 / (36 * mean) + w / (6 * root);
    return std::max(std::floor(2 * mean * c * c * c - mean + T(0.5)), T(0));
  }
  return std::max(std::floor(mean + root * w + T(0.5)), T(0));
}

template <Form form, int from>
struct InversionThen {
  template <class T>
  T operator()(T mean, int slots, HashWords words) const {
    const T u = uniform_48<T>(words.x, words.y);
    if (slots > 0 || !(mean >= T(from)) || !(mean > 0)) return count_deviate(mean, slots, u);
    return closed_form<form>(mean, u);
  }
};

// Sequential inversion at every mean, in long double: e^-mean is a number to this mean.
inline constexpr double kMostInverted = 11000;

struct Inversion {
  template <class T>
  T operator()(T mean, int slots, HashWords words) const {
    const T u = uniform_48<T>(words.x, words.y);
    if (slots > 0 || mean > T(kMostInverted)) return count_deviate(mean, slots, u);
    const long double lambda = mean;
    long double term = std::exp(-lambda), survival = -std::expm1(-lambda), n = 0;
    while (u < survival) {
      n += 1;
      term *= lambda / n;
      if (n > lambda && survival - term == survival) break;
      survival -= term;
    }
    return static_cast<T>(n);
  }
};

// The hash as a generator for the standard library's distributions.
struct HashGenerator {
  using result_type = std::uint32_t;
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }
  HashWords state;
  result_type operator()() {
    state = pcg4d(state);
    return state.x;
  }
};

struct StandardLibrary {
  template <class T>
  T operator()(T mean, int slots, HashWords words) const {
    if (slots > 0) return count_deviate(mean, slots, uniform_48<T>(words.x, words.y));
    HashGenerator generator{words};
    return static_cast<T>(std::poisson_distribution<long>(static_cast<double>(mean))(generator));
  }
};

// The paper's step 3: one sparkle or none below a mean of 0.1.
struct Bernoulli {
  template <class T>
  T operator()(T mean, int slots, HashWords words) const {
    if (slots == 0 && mean < T(0.1)) slots = 1;
    return count_deviate(mean, slots, uniform_48<T>(words.x, words.y));
  }
};

// ---------------------------------------------------------------------------------------------
// Sums: a functor (expected, area spread, key, x, y, words of the pixel, count).

template <class T>
Rgb<T> sum_of_drawn(const ExpectedSparkles<T>& expected, T area_spread, HashWords key, int x, int y,
                    int first, int count) {
  Rgb<T> sum{};
  for (int i = 0; i < count; ++i) {
    const HashWords words = draw_words(key, x, y, first + i);
    sum = sum + draw_sparkle(expected, area_spread, words, uniform_23<T>(words.z));
  }
  return sum;
}

// Exact. Another `first` gives other sparkles with the same count.
struct EachDrawn {
  int first = 1;
  template <class T>
  Rgb<T> operator()(const ExpectedSparkles<T>& expected, T area_spread, HashWords key, int x, int y,
                    HashWords, T count) const {
    return sum_of_drawn(expected, area_spread, key, x, y, first, static_cast<int>(count));
  }
};

// The first sparkles drawn one by one, more of them as one sum, however much it fluctuates.
template <int drawn>
struct DrawnThenSkewed {
  template <class T>
  Rgb<T> operator()(const ExpectedSparkles<T>& expected, T area_spread, HashWords key, int x, int y,
                    HashWords words, T count) const {
    if (count <= T(drawn)) {
      return sum_of_drawn(expected, area_spread, key, x, y, 1, static_cast<int>(count));
    }
    return sum_of_many(expected, count, T(0), words, draw_words(key, x, y, kColourDraw));
  }
};

// Likewise, with the mean and the variance of the sum alone.
template <int drawn>
struct DrawnThenNormal {
  template <class T>
  Rgb<T> operator()(const ExpectedSparkles<T>& expected, T area_spread, HashWords key, int x, int y,
                    HashWords words, T count) const {
    if (count <= T(drawn)) {
      return sum_of_drawn(expected, area_spread, key, x, y, 1, static_cast<int>(count));
    }
    const Rgb<T> mean = mean_sparkle(expected);
    const Rgb<T> variance =
        map(mean_square_sparkle(expected) - mean * mean, [](T v) { return std::max(v, T(0)); });
    const T w = std::sqrt(count) * normal_quantile(uniform_48<T>(words.z, words.w));
    return mean * count + map(variance, [&](T v) { return w * std::sqrt(v); });
  }
};

struct CountTimesMean {
  template <class T>
  Rgb<T> operator()(const ExpectedSparkles<T>& expected, T, HashWords, int, int, HashWords,
                    T count) const {
    return mean_sparkle(expected) * count;
  }
};

// ---------------------------------------------------------------------------------------------
// The draw of a pixel: a functor (expected, area spread, key, x, y).

struct Shipped {
  template <class T>
  Sparkles<T> operator()(const ExpectedSparkles<T>& expected, T area_spread, HashWords key, int x,
                         int y) const {
    return draw_sparkles(expected, area_spread, key, x, y);
  }
};

template <class Count, class Sum>
struct Alternative {
  Count draw_count{};
  Sum draw_sum{};
  template <class T>
  Sparkles<T> operator()(const ExpectedSparkles<T>& expected, T area_spread, HashWords key, int x,
                         int y) const {
    Sparkles<T> sparkles;
    if (!(expected.mean_count > 0)) return sparkles;
    const HashWords words = draw_words(key, x, y, 0);
    sparkles.count = draw_count(expected.mean_count, expected.slots, words);
    if (sparkles.count <= 0) return {};
    const Rgb<T> sum = draw_sum(expected, area_spread, key, x, y, words, sparkles.count);
    sparkles.radiance = map(expected.mirror * sum,
                            [&](T t) { return std::min(std::max(t, T(0)), expected.ceiling); });
    return sparkles;
  }
};

struct MeanOnly {
  template <class T>
  Sparkles<T> operator()(const ExpectedSparkles<T>& expected, T, HashWords, int, int) const {
    if (!(expected.mean_count > 0)) return {};
    return {expected.mean_count, mean_radiance(expected)};
  }
};

// What the core draws, and the exact draw.
using CoreCount = InversionThen<Form::cornish_fisher, kPoissonClosedForm>;
struct CoreSum {
  template <class T>
  Rgb<T> operator()(const ExpectedSparkles<T>& expected, T area_spread, HashWords key, int x, int y,
                    HashWords words, T count) const {
    return sum_of_sparkles(expected, area_spread, key, x, y, words, count);
  }
};
using Exact = Alternative<Inversion, EachDrawn>;

}  // namespace trade
