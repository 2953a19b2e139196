// SPDX-License-Identifier: Apache-2.0
//
// The law of the core's draw against that of the paper's sum, over mean counts.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

#include "alternatives.h"
#include "measure.h"
#include "paint.h"
#include "parallel.h"

namespace trade {

inline constexpr double kMeanCounts[] = {0.01, 0.1, 0.5, 1, 2, 3, 5, 10, 100, 1e3, 1e4, 1e5, 1e6};
inline constexpr double kMostDrawn = 1000;  // of more sparkles the paper's sums are made of its own

struct LawCase {
  std::string name;
  Paint paint;
};

inline std::vector<LawCase> law_cases() {
  Paint deep, shallow;
  deep.layer_thickness_um = 100;
  deep.flakes_per_mm2 *= 5;
  deep.flake_area_spread = 1;
  shallow.flakes_per_mm2 /= 100;
  shallow.flake_area_spread = 2;
  return {{"the default paint", {}},
          {"a deep layer of unequal flakes", deep},
          {"a few very unequal flakes", shallow}};
}

// So many sparkles on average, in the sun, half-way between it and the observer a level flake; the
// pixel is wide enough for all of them.
template <class T>
ExpectedSparkles<T> expect(const LawCase& law, double mean_count) {
  const Vec3<double> view{0.28, 0, 0.96}, light{-0.28, 0, 0.96};
  const SeenLight<T> seen =
      see_light<T>({LightKind::parallel, Vec3<T>(light), T(0.00465)}, Vec3<T>{});
  ExpectedSparkles<T> expected =
      expect_sparkles(make_layer<T>(law.paint), {{}, {0, 0, 1}, Vec3<T>(view), T(1), 0, 0}, seen);
  expected.mean_count = static_cast<T>(mean_count);
  return expected;
}

// draw(key) for each of `count` keys.
template <class Draw>
std::vector<double> drawn(double mean_count, std::size_t count, const Draw& draw) {
  std::vector<double> values(count);
  const HashKey stream = stream_key(kFlakeStream, 0, 0, static_cast<int>(100 * mean_count));
  parallel_for(
      count,
      [&](std::size_t i) {
        values[i] = draw(pixel_key(stream, static_cast<int>(i), static_cast<int>(i >> 22), 0));
      },
      256);
  return values;
}

inline std::vector<double> short_draws(const LawCase& law, double mean_count, std::size_t count) {
  const auto expected = expect<float>(law, mean_count);
  return drawn(mean_count, count, [&](HashKey key) {
    return static_cast<double>(draw_sparkles(expected, key).radiance.y);
  });
}

// A pixel of ten times as many sparkles is ten pixels, so that its law is that of ten draws. What
// the mean of few draws errs is taken off them.
inline std::vector<double> papers_draws(const LawCase& law, double mean_count, std::size_t count) {
  if (mean_count <= kMostDrawn) {
    const auto expected = expect<double>(law, mean_count);
    return drawn(mean_count, count, [&](HashKey key) {
      const int n = exact_count(mean_count, 0, static_cast<double>(uniform_deviates(key, 0).x));
      return sum_one_by_one(expected, hashed(key, 1), n).y;
    });
  }
  const std::vector<double> few = papers_draws(law, mean_count / 10, count);
  const double off = mean(few) - mean_radiance(expect<double>(law, mean_count / 10)).y;
  std::mt19937_64 engine(1);
  std::uniform_int_distribution<std::size_t> any(0, count - 1);
  std::vector<double> sums(count);
  for (double& sum : sums) {
    for (int i = 0; i < 10; ++i) sum += few[any(engine)] - off;
  }
  return sums;
}

// Of the pixel's green. Mean and variance over those of the closed form, whose law the paper's sum
// has, and their standard errors; a sum of <N> sparkles has the skewness E[Y^3]/(E[Y^2]^1.5
// sqrt(<N>)).
struct Law {
  double mean_count, mean, mean_error, variance, variance_error, skewness, papers_skewness;
  double distance, noise;  // Kolmogorov's, of two samples; its median for two of one law
};

inline Law law_of(const LawCase& law, double mean_count, std::size_t draws, std::size_t sums) {
  const auto expected = expect<double>(law, mean_count);
  const double closed_mean = mean_radiance(expected).y;
  const double closed_variance = radiance_variance(expected).y;
  const double number = static_cast<double>(draws);
  double cube = 0;
  for (double y : drawn(mean_count, draws, [&](HashKey key) {
         return sum_one_by_one(expected, hashed(key, 2), 1).y;
       })) {
    cube += y * y * y / number;
  }

  std::vector<double> found = short_draws(law, mean_count, draws);
  const double m = mean(found);
  double second = 0, third = 0, fourth = 0;
  for (double t : found) {
    const double d = t - m;
    second += d * d / number;
    third += d * d * d / number;
    fourth += d * d * d * d / number;
  }
  Law of{mean_count,
         m / closed_mean,
         std::sqrt(second / number) / closed_mean,
         second / closed_variance,
         std::sqrt((fourth - second * second) / number) / closed_variance,
         third / std::pow(second, 1.5),
         mean_count * cube / std::pow(closed_variance, 1.5),
         0,
         0};
  of.distance = kolmogorov(found, papers_draws(law, mean_count, sums));
  of.noise = 0.83 * std::sqrt(1 / number + 1 / static_cast<double>(sums));
  return of;
}

}  // namespace trade
