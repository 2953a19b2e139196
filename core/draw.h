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

// The draws of a pixel by number: 0 its count and the first colour of the sum, 1 to 16 sparkles, 17
// the shader's own (the cone in which it shows them), 18 the other colours of the sum, from 19 on
// more sparkles.
inline constexpr int kColourDraw = kDrawnSparkles + 2;

// One sparkle's Y: its area by the words x and y, dimmed from a depth of 0 to 1, or hidden by w.
template <class T>
Rgb<T> draw_sparkle(const ExpectedSparkles<T>& expected, T area_spread, HashWords words, T depth) {
  T area = 1;
  if (area_spread > 0) {
    area = max(1 + area_spread * normal_quantile(uniform_48<T>(words.x, words.y)), T(0));
  }
  T share = min(area, expected.fill) / expected.fill;
  if (expected.hidden > 0 && uniform_23<T>(words.w) > exponential(-expected.hidden * depth)) {
    share = 0;
  }
  return map(expected.slant,
             [&](T x) { return share * exponential((expected.hidden - x) * depth); });
}

// How many of `count` sparkles are drawn one by one: all of up to 16. Of more the sum is drawn as
// one, unless its variance is above a tenth of its squared mean. There a deep layer shows little
// but the flakes nearest to its surface, and the law of the sum would reach below 0; so all of up
// to 32 are drawn, and the nearest 16 of more. A sparkle's variance is E[X^2]/E[X]^2 E[s^2]/E[s]^2
// - 1 of its squared mean. Where h = 0, E[s^2]/E[s]^2 is y coth y with y = x/2, at most y + 1/(1 +
// y), 14 % more; with h it grows about by 1 + h/(2 + 2 x - h).
template <class T>
int drawn_one_by_one(const ExpectedSparkles<T>& expected, T count) {
  if (count <= T(kDrawnSparkles)) return static_cast<int>(count);
  const T square = expected.area.square / (expected.area.mean * expected.area.mean);
  const T y = max_component(expected.slant) / 2;
  const T h = expected.hidden;
  const T varied = (y + 1 / (1 + y)) * (1 + h / (2 + 4 * y - h));
  if (square * varied - 1 <= T(0.1) * count) return 0;
  return count <= T(2 * kDrawnSparkles) ? static_cast<int>(count) : kDrawnSparkles;
}

// The law of a sum of many sparkles in one colour, of a normal deviate w (Cornish and Fisher's
// first term): mean + spread (w + c (w^2 - 1))/root with root^2 = 1 + 2 c^2.
template <class T>
struct SumLaw {
  T mean{}, spread{}, c{}, root{1};
};

// Of `count` sparkles in a colour of optical depth x, of which h hides whole, relative to their
// mean area; `square` and `cube` are the area's moments. The moments of their shares are A(x), A(2
// x - h) and A(3 x - 2 h). Mean, variance and skewness g = (6 c + 8 c^3)/root^3 are those of the
// sum; two steps solve for c to 1 % of g while c <= 1/4.
template <class T>
SumLaw<T> sum_law(T square, T cube, T x, T h, T count) {
  SumLaw<T> law;
  const T m1 = mean_transmittance(x);
  const T m2 = square * mean_transmittance(2 * x - h);
  const T m3 = cube * mean_transmittance(3 * x - 2 * h);
  law.mean = m1 * count;
  const T variance = m2 - m1 * m1;
  if (!(variance > m2 * T(1e-5))) return law;  // equal flakes: their count
  law.spread = sqrt(variance * count);
  const T skewness = (m3 - 3 * m2 * m1 + 2 * m1 * m1 * m1) / (variance * law.spread);
  law.c = clamp(skewness / 6, T(-0.25), T(0.25));
  for (int i = 0; i < 2; ++i) {
    const T q = 1 + 2 * law.c * law.c;
    law.c = clamp(skewness * q * sqrt(q) / (6 + 8 * law.c * law.c), T(-0.25), T(0.25));
  }
  law.root = sqrt(1 + 2 * law.c * law.c);
  return law;
}

// The correlation rho of two colours' normal deviates that gives their sums this covariance:
// spread_a spread_b (rho + 2 c_a c_b rho^2)/(root_a root_b).
template <class T>
T correlation_of_deviates(const SumLaw<T>& a, const SumLaw<T>& b, T covariance) {
  if (!(a.spread > 0 && b.spread > 0)) return 0;
  const T r = covariance / (a.spread * b.spread) * (a.root * b.root);
  const T rho = 2 * r / (1 + sqrt(max(1 + 8 * a.c * b.c * r, T(0))));
  return clamp(rho, T(0), T(1));
}

// The sum of `count` sparkles that lie evenly between `depth` and 1, relative to a filled, undimmed
// pixel. Every colour has its own law, and any two colours the covariance of theirs: per sparkle
// E[X^2]/E[X]^2 A(x_i + x_j - h) - A(x_i) A(x_j) with A the mean transmittance. Each n-th moment
// has e^((n - 1) h depth) more than the mean's power: so many fewer are left at that depth. Their
// deviates are those of Cholesky's factor of the correlations, row by row.
template <class T>
Rgb<T> sum_of_many(const ExpectedSparkles<T>& expected, T count, T depth, HashWords words,
                   HashWords more) {
  const T mean_area = expected.area.mean;
  const T share = mean_area / expected.fill;
  const T fewer = exponential(min(expected.hidden * depth, T(20)));  // all but dark below
  const T square = expected.area.square / (mean_area * mean_area) * fewer;
  const T cube = expected.area.cube / (mean_area * mean_area * mean_area) * (fewer * fewer);
  const T h = expected.hidden * (1 - depth);
  const T slant[3] = {expected.slant.x, expected.slant.y, expected.slant.z};
  const T chance[3] = {uniform_48<T>(words.z, words.w), uniform_48<T>(more.x, more.y),
                       uniform_48<T>(more.z, more.w)};
  SumLaw<T> law[3];
  T x[3] = {}, sum[3] = {}, deviate[3] = {}, factor[3][3] = {};
  for (int i = 0; i < 3; ++i) {
    int same = i;
    for (int j = 0; j < i; ++j) {
      if (slant[j] == slant[i]) same = j;
    }
    if (same < i) {
      sum[i] = sum[same];
      continue;
    }
    x[i] = slant[i] * (1 - depth);
    law[i] = sum_law(square, cube, x[i], h, count);
    T own = 1;  // what the colours before leave of the deviate's variance
    T w = 0;
    for (int j = 0; j < i; ++j) {
      const T covariance = square * mean_transmittance(x[i] + x[j] - h) * count -
                           law[i].mean * (law[j].mean / count);
      T along = correlation_of_deviates(law[i], law[j], covariance);
      for (int k = 0; k < j; ++k) along = along - factor[i][k] * factor[j][k];
      const T most = sqrt(own);
      along = factor[j][j] > 0 ? clamp(along / factor[j][j], -most, most) : T(0);
      factor[i][j] = along;
      own = max(own - along * along, T(0));
      w = w + along * deviate[j];
    }
    factor[i][i] = sqrt(own);
    deviate[i] = normal_quantile(chance[i]);
    w = w + factor[i][i] * deviate[i];
    const T drawn = law[i].mean + law[i].spread * (w + law[i].c * (w * w - 1)) / law[i].root;
    sum[i] = share * exponential(-slant[i] * depth) * max(drawn, T(0));
  }
  return {sum[0], sum[1], sum[2]};
}

// What `count` sparkles of a pixel add up to, relative to a filled, undimmed pixel; `words` are
// draw 0 of the pixel.
template <class T>
Rgb<T> sum_of_sparkles(const ExpectedSparkles<T>& expected, T area_spread, HashWords key,
                       int pixel_x, int pixel_y, HashWords words, T count) {
  const int drawn = drawn_one_by_one(expected, count);
  const T rest = count - static_cast<T>(drawn);
  Rgb<T> sum{};
  T depth = 0;
  T passed = 0;  // depth = 1 - e^-passed
  for (int i = 1; i <= drawn; ++i) {
    const HashWords own = draw_words(key, pixel_x, pixel_y, i <= kDrawnSparkles ? i : i + 2);
    depth = uniform_23<T>(own.z);
    if (rest > 0) {
      // The next one from the surface down: all k flakes that are left lie in the lower share v of
      // what is left of the layer with probability v^k.
      passed = passed - logarithm(depth) / (count - static_cast<T>(i - 1));
      depth = passed * mean_transmittance(passed);
    }
    sum = sum + draw_sparkle(expected, area_spread, own, depth);
  }
  if (rest > 0) {
    sum = sum +
          sum_of_many(expected, rest, depth, words, draw_words(key, pixel_x, pixel_y, kColourDraw));
  }
  return sum;
}

// The count and the radiance of this pixel.
template <class T>
Sparkles<T> draw_sparkles(const ExpectedSparkles<T>& expected, T area_spread, HashWords key,
                          int pixel_x, int pixel_y) {
  Sparkles<T> sparkles;
  if (!(expected.mean_count > 0)) return sparkles;
  const T left = fluctuation_left(expected);
  // No pixel outshines the light in a mirror (ours).
  const auto bounded = [&](Rgb<T> radiance) {
    return map(radiance, [&](T t) { return min(max(t, T(0)), expected.ceiling); });
  };
  if (!(left > 0)) {
    return {floor(expected.mean_count + T(0.5)), bounded(mean_radiance(expected))};
  }
  const HashWords words = draw_words(key, pixel_x, pixel_y, 0);
  const T count =
      count_deviate(expected.mean_count, expected.slots, uniform_48<T>(words.x, words.y));
  if (!(count > 0) && left == 1) return sparkles;  // of most pixels, where flakes are few
  sparkles.count = count;
  Rgb<T> sum = sum_of_sparkles(expected, area_spread, key, pixel_x, pixel_y, words, count);
  if (left < 1) {
    const Rgb<T> mean = mean_sparkle(expected) * expected.mean_count;
    sum = mean + (sum - mean) * left;
  }
  sparkles.radiance = bounded(expected.mirror * sum);
  return sparkles;
}

}  // namespace metallic_paint
