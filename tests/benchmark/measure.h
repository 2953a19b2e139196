// SPDX-License-Identifier: Apache-2.0
//
// How far drawn pixels are from drawn pixels.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "alternatives.h"

namespace trade {

inline double luminance(Rgb<double> c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

// The draws of one pixel over many seeds.
struct Draws {
  std::vector<double> count, radiance;
};

inline double mean(const std::vector<double>& values) {
  double sum = 0;
  for (double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}
inline double deviation(const std::vector<double>& values) {
  const double m = mean(values);
  double sum = 0;
  for (double v : values) sum += (v - m) * (v - m);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// Wasserstein's distance of two samples of one size: the mean distance of their order statistics.
inline double wasserstein(std::vector<double> a, std::vector<double> b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / static_cast<double>(a.size());
}

// Root mean square over pixels: relative errors of the mean count, of the mean radiance and of its
// standard deviation; Wasserstein's distance of the radiance's distributions in standard
// deviations of the reference.
struct Errors {
  double count = 0, mean = 0, deviation = 0, distribution = 0;
};

inline Errors errors(const std::vector<Draws>& pixels, const std::vector<Draws>& reference) {
  Errors sum;
  const auto add = [](double& to, double error) { to += error * error; };
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Draws &p = pixels[i], &r = reference[i];
    const double spread = deviation(r.radiance);
    add(sum.count, mean(p.count) / mean(r.count) - 1);
    add(sum.mean, mean(p.radiance) / mean(r.radiance) - 1);
    add(sum.deviation, deviation(p.radiance) / spread - 1);
    add(sum.distribution, wasserstein(p.radiance, r.radiance) / spread);
  }
  const double n = static_cast<double>(pixels.size());
  return {std::sqrt(sum.count / n), std::sqrt(sum.mean / n), std::sqrt(sum.deviation / n),
          std::sqrt(sum.distribution / n)};
}

// Total variation distance from Poisson's law of a count that does not rise with its uniform
// deviate: the 48 bits are halved until the share of words with N > n is found, for every n.
template <class Count>
double total_variation(const Count& count, double poisson_mean) {
  constexpr std::uint64_t end = std::uint64_t{1} << 48;
  const auto above = [&](double n) {
    std::uint64_t low = 0, high = end;  // N > n at all deviates below low, at none from high on
    while (low < high) {
      const std::uint64_t middle = (low + high) / 2;
      const HashWords words{static_cast<std::uint32_t>(middle >> 24) << 8,
                            static_cast<std::uint32_t>(middle & 0xffffff) << 8, 0, 0};
      if (count(poisson_mean, 0, words) > n) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return static_cast<double>(low) / static_cast<double>(end);
  };
  const double reach = 9 * std::sqrt(poisson_mean) + 20;
  const double first = std::max(std::floor(poisson_mean - reach), 0.0);
  double sum = 0, at_least = 1;
  if (first > 0) at_least = above(first - 1);
  for (double n = first; n <= poisson_mean + reach; ++n) {
    const double more = above(n);
    const double p = std::exp(n * std::log(poisson_mean) - poisson_mean - std::lgamma(n + 1));
    sum += std::abs((at_least - more) - p);
    at_least = more;
  }
  return sum / 2;
}

}  // namespace trade
