// SPDX-License-Identifier: Apache-2.0
//
// How far drawn pixels are from drawn pixels.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "vector.h"

namespace trade {

using namespace metallic_paint;

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

// Kolmogorov's distance of two samples: the largest of their distribution functions.
inline double kolmogorov(std::vector<double> a, std::vector<double> b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  const auto share = [](std::size_t i, const std::vector<double>& of) {
    return static_cast<double>(i) / static_cast<double>(of.size());
  };
  double most = 0;
  for (std::size_t i = 0, k = 0; i < a.size() && k < b.size();) {
    const double x = std::min(a[i], b[k]);
    while (i < a.size() && a[i] <= x) ++i;
    while (k < b.size() && b[k] <= x) ++k;
    most = std::max(most, std::abs(share(i, a) - share(k, b)));
  }
  return most;
}

}  // namespace trade
