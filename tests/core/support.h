// SPDX-License-Identifier: Apache-2.0
//
// What the tests share: the worst error of a sweep with the place where it occurred, random
// numbers, and the thresholds of statistical tests.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <numbers>
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

// The seed of a run's random tests: the same in each run but where the environment variable
// METALLIC_PAINT_TEST_SEED has another, as ./paint test --all gives it a new one.
inline std::uint32_t run_seed() {
  static const std::uint32_t seed = [] {
    const char* given = std::getenv("METALLIC_PAINT_TEST_SEED");
    const auto taken =
        given != nullptr ? static_cast<std::uint32_t>(std::strtoul(given, nullptr, 10)) : 0;
    std::cout << "METALLIC_PAINT_TEST_SEED=" << taken << " repeats this run\n";
    return taken;
  }();
  return seed;
}

// Of a test's own stream.
inline Random fresh(std::uint64_t stream) { return Random(run_seed() + (stream << 32)); }

// Of a sweep for the largest rounding error, in which nothing is a matter of chance but the scenes:
// the same ones in each run, so that what fails once fails again. Its bars come from fresh ones.
inline Random same_scenes(std::uint64_t stream) { return Random(stream); }

// Of a statistical test as a whole, all its comparisons together, where another run cannot find
// anything else: what the hash draws for the same keys.
inline constexpr double kLevel = 1e-3;

// The address sanitizer makes code several times as slow: what is repeated over many random scenes
// is repeated this much less often under it. It looks for bad accesses, not for statistics.
#ifdef __SANITIZE_ADDRESS__
inline constexpr int kFewer = 10;
#else
inline constexpr int kFewer = 1;
#endif

// Likewise, of a test whose seed --all renews.
inline constexpr double kFreshLevel = 1e-6;

// Of all tests of variances and covariances in one run together, and how many comparisons they may
// make: `Variances` counts them.
inline constexpr double kVarianceLevel = 1e-4;
inline constexpr long kVarianceComparisons = 8000;

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

// Comparisons of variances found about a known mean with exact ones.
class Variances {
 public:
  // So many comparisons in a row may be of the same draws (colours).
  explicit Variances(double dependent = 1) : dependent_(dependent) {}

  // z of one of them, from the mean of n squares. The mean's own variance is (fourth - exact^2)/n
  // with the fourth central moment; leaning to large values, it is taken for a gamma deviate.
  static double deviation(double found, double exact, double fourth, double n) {
    const double relative = (fourth - exact * exact) / (exact * exact) / n;
    if (!(relative > 1e-12)) return (found / exact - 1) * 1e6;  // squares that are all the same
    return chi_square_z(found / exact * 2 / relative, 2 / relative);
  }

  template <class Named>
  void see(double found, double exact, double fourth, double n, const Named& where) {
    see(deviation(found, exact, fourth, n), where);
  }
  template <class Named>
  void see(double z, const Named& where) {
    EXPECT_LE(std::fabs(z), threshold()) << "variance: z " << z << " at " << where;
    ++seen_;
    sum_ += z;
  }

  long seen() const { return seen_; }

  // All of them together, which a common error of the variances does not pass.
  double common_deviation() const {
    return sum_ / std::sqrt(dependent_ * static_cast<double>(seen_));
  }
  void expect_chance() {
    EXPECT_GT(seen_, 0);
    EXPECT_LE(std::fabs(common_deviation()), threshold()) << "variances of the whole test";
    std::ostringstream text;
    text.precision(3);
    text << "all " << seen_ << " together: z " << common_deviation() << " of " << threshold();
    ::testing::Test::RecordProperty("variances", text.str());
    made() += seen_ + 1;
    EXPECT_LE(made(), kVarianceComparisons) << "comparisons of variances in this run";
  }

  static double threshold() {
    static const double z = sidak_threshold(kVarianceLevel, kVarianceComparisons);
    return z;
  }

 private:
  static long& made() {
    static long count = 0;
    return count;
  }
  double dependent_;
  long seen_ = 0;
  double sum_ = 0;
};

// Fourth central moment of a sum of so many deviates of these raw moments: Poisson (slots = 0) or
// one in each of `slots` places with probability mean_count/slots.
inline double fourth_moment_of_sum(double mean_count, int slots, double m1, double m2, double m3,
                                   double m4) {
  if (slots == 0) return mean_count * m4 + 3 * mean_count * m2 * mean_count * m2;
  const double k = slots, p = mean_count / k, m = p * m1;
  const double second = p * m2 - m * m;
  const double fourth = p * m4 - 4 * m * p * m3 + 6 * m * m * p * m2 - 3 * m * m * m * m;
  return k * fourth + 3 * k * (k - 1) * second * second;
}

// The Fourier transform of a square picture, row by row and column by column.
inline std::vector<std::complex<double>> transformed(const std::vector<double>& picture, int side) {
  std::vector<std::complex<double>> turns, field(picture.begin(), picture.end()), out(field.size());
  for (int k = 0; k < side; ++k) turns.push_back(std::polar(1.0, -2 * std::numbers::pi * k / side));
  const auto at = [&](int row, int k) { return static_cast<std::size_t>(row * side + k); };
  for (int pass = 0; pass < 2; ++pass) {
    for (int row = 0; row < side; ++row) {
      for (int f = 0; f < side; ++f) {
        std::complex<double> sum = 0;
        for (int k = 0; k < side; ++k) {
          const auto& turn = turns[static_cast<std::size_t>(f * k % side)];
          const auto& value = field[at(row, k)];
          sum += std::complex<double>{value.real() * turn.real() - value.imag() * turn.imag(),
                                      value.real() * turn.imag() + value.imag() * turn.real()};
        }
        out[at(f, row)] = sum;  // transposed, twice
      }
    }
    field = out;
  }
  return field;
}

// Sums of a deviate's powers about its known mean.
struct Moments {
  double centre = 0, n = 0, first = 0, second = 0;
  void add(double value) {
    const double d = value - centre;
    n += 1;
    first += d;
    second += d * d;
  }
  double mean() const { return centre + first / n; }
  double variance() const { return second / n; }  // unbiased
  double error_of_mean() const { return std::sqrt(variance() / n); }
};

}  // namespace core_tests
