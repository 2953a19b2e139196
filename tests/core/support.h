// SPDX-License-Identifier: Apache-2.0
//
// What the tests share: the worst error of a sweep with the place where it occurred, seeded random
// numbers, and the thresholds of statistical tests.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace core_tests {

inline long double relative_error(long double value, long double reference) {
  return value == reference ? 0 : std::fabs(value - reference) / std::fabs(reference);
}

// Distance from the reference in units of the last place of T at the reference.
template <class T>
long double ulps(T value, long double reference) {
  const int exponent = std::ilogb(reference);
  return std::fabs(static_cast<long double>(value) - reference) /
         std::ldexp(1.0L, exponent - (std::numeric_limits<T>::digits - 1));
}

// The largest error of a sweep and the parameters that gave it: see(error, "x", x, "tilt", tilt).
class Worst {
 public:
  template <class... Named>
  void see(long double error, const Named&... named) {
    ++seen_;
    if (!(error > error_) && !std::isnan(error)) return;  // a NaN is the worst of all
    if (std::isnan(error_)) return;
    error_ = error;
    std::ostringstream text;
    text.precision(17);
    ((text << named << ' '), ...);
    where_ = text.str();
  }

  // The measured number also goes to the results file, under `name`.
  void expect_at_most(double limit, const std::string& name = "worst") const {
    EXPECT_GT(seen_, 0) << name;
    EXPECT_LE(error_, limit) << name << " at " << where_;
    std::ostringstream text;
    text.precision(3);
    text << error_ << " of " << limit << " at " << where_;
    ::testing::Test::RecordProperty(name, text.str());
  }

  long double error() const { return error_; }

 private:
  long double error_ = 0;
  long seen_ = 0;
  std::string where_;
};

// std's distributions differ between libraries; these do not.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double from = 0, double to = 1) {
    return from + (to - from) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  double log_uniform(double from, double to) {
    return std::exp(uniform(std::log(from), std::log(to)));
  }
  int below(int count) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(count)); }
  std::uint64_t bits() { return engine_(); }

 private:
  std::mt19937_64 engine_;
};

// Of a statistical test as a whole, all its comparisons together.
inline constexpr double kLevel = 1e-3;

// The address sanitizer makes code several times as slow: what is repeated over many random scenes
// is repeated this much less often under it. It looks for bad accesses, not for statistics.
#ifdef __SANITIZE_ADDRESS__
inline constexpr int kFewer = 10;
#else
inline constexpr int kFewer = 1;
#endif

// |z| that `tests` independent standard normal deviates all stay under with probability 1 - level
// (Sidak's correction).
inline double sidak_threshold(double level, double tests) {
  const double each = -std::expm1(std::log1p(-level) / tests);  // two-sided
  double low = 0, high = 40;
  for (int i = 0; i < 100; ++i) {
    const double middle = (low + high) / 2;
    (std::erfc(middle / std::sqrt(2.0)) > each ? low : high) = middle;
  }
  return high;
}

// A chi-square statistic as a standard normal deviate (Wilson and Hilferty 1931; good to a few
// per cent of the tail probability from 15 degrees of freedom on, below them too large a tail).
inline double chi_square_z(double chi_square, double degrees) {
  const double spread = 2 / (9 * degrees);
  return (std::cbrt(chi_square / degrees) - (1 - spread)) / std::sqrt(spread);
}

// Likewise Pearson's statistic of counts, neighbouring cells pooled until each expects `least`.
inline double chi_square_z(const std::vector<double>& found, const std::vector<double>& expected,
                           double least = 5) {
  struct Cell {
    double found = 0, expected = 0;
  };
  std::vector<Cell> cells(1);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (cells.back().expected >= least) cells.emplace_back();
    cells.back().found += found[i];
    cells.back().expected += expected[i];
  }
  if (cells.size() > 1 && cells.back().expected < least) {
    const Cell rest = cells.back();
    cells.pop_back();
    cells.back().found += rest.found;
    cells.back().expected += rest.expected;
  }
  if (cells.size() < 2) return 0;
  double sum = 0;
  for (const Cell& cell : cells) {
    sum += (cell.found - cell.expected) * (cell.found - cell.expected) / cell.expected;
  }
  return chi_square_z(sum, static_cast<double>(cells.size() - 1));
}

// Sums of a deviate's powers about its known mean.
struct Moments {
  double centre = 0, n = 0, first = 0, second = 0, fourth = 0;
  void add(double value) {
    const double d = value - centre;
    n += 1;
    first += d;
    second += d * d;
    fourth += d * d * d * d;
  }
  double mean() const { return centre + first / n; }
  double variance() const { return second / n; }  // unbiased
  double error_of_mean() const { return std::sqrt(variance() / n); }
  double error_of_variance() const {
    return std::sqrt(std::max(fourth / n - variance() * variance(), 0.0) / n);
  }
};

}  // namespace core_tests
