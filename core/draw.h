// SPDX-License-Identifier: Apache-2.0
//
// The draw: how many sparkles a pixel happens to have, and what they add up to.
#pragma once

#include <algorithm>
#include <cmath>

#include "elementary.h"
#include "expected_sparkles.h"
#include "poisson.h"
#include "random.h"
#include "vector.h"

namespace metallic_paint {

template <class T>
struct Sparkles {
  T count{};
  Rgb<T> radiance{};  // T
};

// So many sparkles of a pixel are drawn one by one.
inline constexpr int kDrawnSparkles = 16;

// One sparkle's Y: its area by the words x and y, its depth by the word z.
template <class T>
Rgb<T> draw_sparkle(const ExpectedSparkles<T>& expected, T area_spread, HashWords words) {
  T area = 1;
  if (area_spread > 0) {
    area = std::max(1 + area_spread * normal_quantile(uniform_48<T>(words.x, words.y)), T(0));
  }
  const T share = std::min(area, expected.fill) / expected.fill;
  const T depth = uniform_23<T>(words.z);
  return map(expected.slant, [&](T x) { return x > 0 ? share * exponential(-x * depth) : share; });
}

// The sum of `count` sparkles in a colour of optical depth x, relative to a filled, undimmed pixel,
// from a normal deviate w as w + c (w^2 - 1): with the exact mean, variance and skewness of the sum
// given the count (Cornish and Fisher's first term). The skewness g of that deviate is (6 c +
// 8 c^3)/(1 + 2 c^2)^(3/2); two steps solve for c to 1 % of g while c <= 1/4.
template <class T>
T sum_of_many(const ExpectedSparkles<T>& expected, T x, T count, T w) {
  // Moments of a sparkle relative to its mean share of the pixel.
  const T mean_area = expected.area.mean;
  const T share = mean_area / expected.fill;
  const T m1 = mean_transmittance(x);
  const T m2 = expected.area.square / (mean_area * mean_area) * mean_transmittance(2 * x);
  const T m3 = expected.area.cube / (mean_area * mean_area * mean_area) * mean_transmittance(3 * x);
  const T variance = m2 - m1 * m1;
  if (!(variance > m2 * T(1e-5))) return share * m1 * count;  // equal flakes: their count
  const T spread = std::sqrt(variance * count);
  const T skewness = (m3 - 3 * m2 * m1 + 2 * m1 * m1 * m1) / (variance * spread);
  T c = std::clamp(skewness / 6, T(-0.25), T(0.25));
  for (int i = 0; i < 2; ++i) {
    const T q = 1 + 2 * c * c;
    c = std::clamp(skewness * q * std::sqrt(q) / (6 + 8 * c * c), T(-0.25), T(0.25));
  }
  return share * (m1 * count + spread * (w + c * (w * w - 1)) / std::sqrt(1 + 2 * c * c));
}

// The count and the radiance of this pixel. Up to kDrawnSparkles sparkles are drawn one by one;
// above, their sum is.
template <class T>
Sparkles<T> draw_sparkles(const ExpectedSparkles<T>& expected, T area_spread, HashWords key,
                          int pixel_x, int pixel_y) {
  Sparkles<T> sparkles;
  if (!(expected.mean_count > 0)) return sparkles;
  const T left = fluctuation_left(expected);
  // No pixel outshines the light in a mirror (ours).
  const auto bounded = [&](Rgb<T> radiance) {
    return map(radiance, [&](T t) { return std::min(std::max(t, T(0)), expected.ceiling); });
  };
  if (!(left > 0)) {
    return {std::floor(expected.mean_count + T(0.5)), bounded(mean_radiance(expected))};
  }
  const HashWords words = draw_words(key, pixel_x, pixel_y, 0);
  const T count =
      count_deviate(expected.mean_count, expected.slots, uniform_48<T>(words.x, words.y));
  sparkles.count = count;

  Rgb<T> sum{};
  if (count <= T(kDrawnSparkles)) {
    const int n = static_cast<int>(count);
    for (int i = 1; i <= n; ++i) {
      sum = sum + draw_sparkle(expected, area_spread, draw_words(key, pixel_x, pixel_y, i));
    }
  } else {
    const T w = normal_quantile(uniform_48<T>(words.z, words.w));
    sum = map(expected.slant, [&](T x) { return sum_of_many(expected, x, count, w); });
  }
  if (left < 1) {
    const Rgb<T> mean = mean_sparkle(expected) * expected.mean_count;
    sum = mean + (sum - mean) * left;
  }
  sparkles.radiance = bounded(expected.mirror * sum);
  return sparkles;
}

}  // namespace metallic_paint
