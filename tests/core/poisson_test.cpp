// SPDX-License-Identifier: Apache-2.0
//
// The count of sparkles. Its distribution is found exactly, not sampled: the count falls with u, so
// for each n the share of the 2^48 deviates that give more than n follows by bisection.
#include "poisson.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

#include "independent.h"
#include "random.h"
#include "support.h"

namespace {

using namespace metallic_paint;
using core_tests::Random;
using core_tests::relative_error;
using core_tests::Worst;
using Real = long double;

template <class T>
T deviate(std::uint64_t m) {
  return uniform_48<T>(static_cast<std::uint32_t>(m >> 24) << 8,
                       static_cast<std::uint32_t>(m & 0xffffffu) << 8);
}

// P(N > n) over all deviates; `below` is a known upper bound, in steps.
template <class T>
std::uint64_t steps_above(T mean, int slots, Real n, std::uint64_t below) {
  std::uint64_t low = 0, high = below;
  while (low < high) {
    const std::uint64_t m = (low + high) / 2;
    if (static_cast<Real>(count_deviate(mean, slots, deviate<T>(m))) > n) {
      low = m + 1;
    } else {
      high = m;
    }
  }
  return low;
}

struct Compared {
  Real total_variation = 0, mean = 0, variance = 0;
};

// The realised distribution against an exact one, p(n), over n from `least` to `most`.
template <class T, class Exact>
Compared compare(T mean, int slots, Real least, Real most, Real centre, const Exact& p) {
  Compared result;
  const std::uint64_t all = 1ull << 48;
  std::uint64_t above = steps_above(mean, slots, least - 1, all);
  Real outside = static_cast<Real>(all - above) * 0x1p-48L, exact_inside = 0;
  for (Real n = least; n <= most; ++n) {
    const std::uint64_t next = steps_above(mean, slots, n, above);
    const Real found = static_cast<Real>(above - next) * 0x1p-48L, exact = p(n);
    above = next;
    result.total_variation += std::fabs(found - exact);
    exact_inside += exact;
    result.mean += found * (n - centre);
    result.variance += found * (n - centre) * (n - centre);
  }
  outside += static_cast<Real>(above) * 0x1p-48L;
  result.total_variation += outside + std::fabs(1 - exact_inside);
  result.total_variation /= 2;
  result.variance -= result.mean * result.mean;
  result.mean += centre;
  return result;
}

template <class T>
Compared compare_poisson(T mean) {
  const Real lambda = mean;
  const Real reach = 10 * std::sqrt(lambda) + 30;
  return compare(
      mean, 0, std::max<Real>(0, std::floor(lambda - reach)), std::ceil(lambda + reach), lambda,
      [&](Real n) { return std::exp(n * std::log(lambda) - lambda - std::lgamma(n + 1)); });
}

template <class T>
Compared compare_binomial(T mean, int slots) {
  const Real q = static_cast<Real>(mean) / slots;
  return compare(mean, slots, 0, slots, mean, [&](Real n) {
    Real p = std::pow(q, n) * std::pow(1 - q, slots - n);
    for (int i = 1; i <= n; ++i) p = p * (slots - n + i) / i;
    return p;
  });
}

std::vector<float> small_means() {
  std::vector<float> means;
  for (double m = 1e-9; m < 32; m *= 1.3) means.push_back(static_cast<float>(m));
  for (float m :
       {0.1f, 1.0f, 4.0f, 10.0f, 16.0f, 20.0f, 24.0f, 28.0f, 30.0f, 31.0f, 31.9f, 31.999998f}) {
    means.push_back(m);
  }
  return means;
}

TEST(Count, IsExactlyPoissonBelowTheClosedForm) {
  Worst wide, narrow;
  for (float mean : small_means()) {
    wide.see(compare_poisson<double>(mean).total_variation, "mean", mean);
    narrow.see(compare_poisson<float>(mean).total_variation, "mean", mean);
  }
  wide.expect_at_most(1e-12, "double");
  narrow.expect_at_most(2e-6, "float");
}

TEST(Count, IsPoissonWithin1e4AboveIt) {
  Worst wide, narrow;
  for (float mean : {32.0f, 32.3f, 33.0f, 35.5f, 40.0f, 50.0f, 64.0f, 100.0f, 316.0f, 1e3f, 1e4f,
                     1e5f, 1e6f, 1.6e7f}) {
    if (mean <= 1e6f) wide.see(compare_poisson<double>(mean).total_variation, "mean", mean);
    // To 2^24, where a float no longer tells neighbouring counts apart.
    narrow.see(compare_poisson<float>(mean).total_variation, "mean", mean);
  }
  wide.expect_at_most(9.1e-5, "double");
  narrow.expect_at_most(1e-3, "float");
}

TEST(Count, BetterWithEveryLargerMean) {
  Real previous = 1;
  for (double mean : {32.0, 64.0, 128.0, 256.0, 512.0, 1024.0, 4096.0, 16384.0}) {
    const Real distance = compare_poisson(mean).total_variation;
    EXPECT_LT(distance, previous) << "mean " << mean;
    previous = distance;
  }
}

TEST(Count, HasTheMeanAndVarianceOfPoisson) {
  Worst mean_error, variance_error, tiny, closed_mean, closed_variance;
  std::vector<double> means{0.1, 1, 4, 10, 16, 25, 31.999};
  for (double m = 1e-3; m < 1e7; m *= 1.9) means.push_back(m);
  for (double m : {32.0, 33.0, 36.0, 40.0, 64.0}) means.push_back(m);
  for (double mean : means) {
    const Compared found = compare_poisson(mean);
    mean_error.see(relative_error(found.mean, mean), "mean", mean);
    variance_error.see(relative_error(found.variance, mean), "mean", mean);
    if (mean < 32) continue;
    closed_mean.see(relative_error(found.mean, mean), "mean", mean);
    closed_variance.see(relative_error(found.variance, mean), "mean", mean);
  }
  for (double mean : {1e-9, 1e-8, 1e-6, 1e-4}) {
    tiny.see(relative_error(compare_poisson(mean).mean, mean), "mean", mean);
  }
  mean_error.expect_at_most(1e-5, "mean");
  variance_error.expect_at_most(1e-5, "variance");
  closed_mean.expect_at_most(1e-12, "closed_form_mean");
  closed_variance.expect_at_most(6e-6, "closed_form_variance");
  tiny.expect_at_most(1e-5, "mean_of_rare_events");
}

TEST(Count, HasTheMeanAndVarianceOfPoissonInFloat) {
  Worst mean_error, variance_error, tiny;
  std::vector<float> means{10, 16, 31.999998f, 32, 33, 40, 64, 1e6f, 1e8f, 1e9f};
  // Where the rounding of the sums falls depends on the mean: many of them below 32.
  for (float m = 1e-3f; m < 32; m *= 1.003f) means.push_back(m);
  for (float m = 32; m < 1e7f; m *= 3) means.push_back(m);
  for (float mean : means) {
    const Compared found = compare_poisson<float>(mean);
    mean_error.see(relative_error(found.mean, mean), "mean", mean);
    variance_error.see(relative_error(found.variance, mean), "mean", mean);
  }
  for (float mean : {1e-9f, 1e-8f, 1e-7f, 1e-6f, 1e-5f, 1e-4f}) {
    tiny.see(relative_error(compare_poisson<float>(mean).mean, mean), "mean", mean);
  }
  mean_error.expect_at_most(1e-5, "mean");
  variance_error.expect_at_most(1e-5, "variance");
  tiny.expect_at_most(1e-5, "mean_of_rare_events");
}

TEST(Count, KeepsMeanAndVarianceForHugeMeans) {
  // Integrated over a grid of the normal deviate w, u = Phi(-w); the variance of floor's own
  // rounding is averaged by the grid.
  for (double lambda : {1e7, 1e8, 1e9, 2147483648.0, 1e12, 1e14, 1e15, 1e16}) {
    Real weight = 0, mean = 0, square = 0;
    for (int i = -60'000; i <= 60'000; ++i) {
      const double w = i * (7.5 / 60'000);
      const double u = std::erfc(w / std::sqrt(2.0)) / 2;
      const Real density = std::exp(-static_cast<Real>(w) * w / 2);
      const Real n = static_cast<Real>(count_deviate(lambda, 0, u)) - lambda;
      weight += density;
      mean += density * n;
      square += density * n * n;
    }
    mean /= weight;
    EXPECT_LE(std::fabs(mean) / lambda, 1e-8) << "mean " << lambda;
    EXPECT_LE(relative_error(square / weight - mean * mean, lambda), 1e-5) << "mean " << lambda;
  }
}

TEST(Count, IsBinomialInSmallPixels) {
  Worst wide, narrow, mean_error, variance_error;
  for (int slots = 1; slots <= 16; ++slots) {
    for (double share : {1e-9, 1e-6, 1e-3, 0.01, 0.1, 0.25, 0.4999, 0.5, 0.5001, 0.7, 0.9, 0.97,
                         0.99, 0.995, 0.997, 0.999, 0.9999, 0.999999}) {
      const auto mean = static_cast<float>(share * slots);
      const auto found = compare_binomial<double>(mean, slots);
      wide.see(found.total_variation, "slots", slots, "share", share);
      narrow.see(compare_binomial<float>(mean, slots).total_variation, "slots", slots, "share",
                 share);
      const Real q = static_cast<Real>(mean) / slots;
      if (share < 1e-4) continue;
      mean_error.see(relative_error(found.mean, mean), "slots", slots, "share", share);
      variance_error.see(relative_error(found.variance, slots * q * (1 - q)), "slots", slots,
                         "share", share);
    }
  }
  wide.expect_at_most(1e-12, "double");
  narrow.expect_at_most(1e-5, "float");
  mean_error.expect_at_most(1e-10, "mean");
  variance_error.expect_at_most(1e-7, "variance");
}

TEST(Count, FullPixelTakesEveryPlace) {
  for (int slots = 1; slots <= 16; ++slots) {
    for (float u : {0x1p-49f, 0.5f, 1.0f}) {
      EXPECT_EQ(count_deviate(static_cast<float>(slots), slots, u), static_cast<float>(slots));
      EXPECT_EQ(count_deviate(1e30f, slots, u), static_cast<float>(slots));
    }
  }
}

TEST(Count, OneSlotIsBernoulli) {
  // The paper's rule for <N> < 0.1: a sparkle with probability <N>, to the last step of u.
  for (double mean : {1e-9, 1e-5, 0.03, 0.0999}) {
    EXPECT_NEAR(static_cast<double>(steps_above(mean, 1, 0.0L, 1ull << 48)) * 0x1p-48, mean,
                0x1p-48);
    EXPECT_EQ(steps_above(mean, 1, 1.0L, 1ull << 48), 0u);
  }
}

template <class T>
void expect_whole_bounded_monotone() {
  const double means[] = {
      0,    1e-300, 1e-30, 1e-12, 2e-10,  1e-8,  0.01,
      1,    15.999, 16,    31.9,  31.999, 32,    60,
      87.4, 100,    1000,  1e5,   1e7,    2.2e9, 1e12,
      1e14, 1e15,   1e18,  1e30,  1e37,   1e38,  std::numeric_limits<double>::infinity()};
  for (double mean_wide : means) {
    const T mean = static_cast<T>(mean_wide);
    T previous = std::numeric_limits<T>::infinity();
    for (std::uint64_t m = 0; m < 1ull << 48; m = m < 64 ? m + 1 : m + m / 32) {
      const T n = count_deviate(mean, 0, deviate<T>(m));
      ASSERT_TRUE(std::isfinite(n) && n >= 0 && n == std::floor(n))
          << "mean " << mean << " m " << m << " count " << n;
      ASSERT_LE(n, previous) << "mean " << mean << " m " << m;
      const T lambda = std::min(mean, static_cast<T>(kMaxMeanCount));
      ASSERT_LE(n, lambda + 9 * std::sqrt(lambda) + 30) << "mean " << mean << " m " << m;
      previous = n;
    }
    EXPECT_LE(count_deviate(mean, 0, T(1)), previous) << "mean " << mean;
  }
}

TEST(Count, IsWholeBoundedAndFallsWithItsDeviate) {
  expect_whole_bounded_monotone<double>();
  expect_whole_bounded_monotone<float>();
}

TEST(Count, InversionTakesABoundedNumberOfSteps) {
  // As many steps up as the count, at the smallest deviate; the tail is summed no further.
  Worst steps;
  for (int i = 0; i < 320'000; ++i) {
    const double mean = i * 1e-4;
    steps.see(count_deviate(mean, 0, 0x1p-49), "mean", mean);
    steps.see(count_deviate(static_cast<float>(mean), 0, 0x1p-49f), "float mean", mean);
  }
  steps.expect_at_most(100);
}

TEST(Count, OfNothingIsNothing) {
  for (double mean : {0.0, -1.0, -1e300, -std::numeric_limits<double>::infinity(),
                      std::numeric_limits<double>::quiet_NaN()}) {
    for (int slots : {0, 1, 7}) {
      EXPECT_EQ(count_deviate(mean, slots, 1e-10), 0) << "mean " << mean << " slots " << slots;
      EXPECT_EQ(count_deviate(static_cast<float>(mean), slots, 1e-10f), 0)
          << "mean " << mean << " slots " << slots;
    }
  }
}

// What other samplers are known to get wrong (design: numerics, 3), each at its own mean.

// The mean and variance found from 2^16 deviates spread evenly over (0, 1), in units of the
// standard deviation and the variance. Midpoints miss the law's outermost 2^-17, which holds less
// than 6e-4 of a normal variance.
template <class T>
struct Spread {
  T least = std::numeric_limits<T>::infinity(), most = 0;
  Real mean_error = 0, variance_error = 0;
};
template <class T>
Spread<T> spread_of(T mean) {
  constexpr int kDeviates = 65536;
  Spread<T> found;
  Real first = 0, second = 0;
  for (int i = 0; i < kDeviates; ++i) {
    const T n = count_deviate(mean, 0, (static_cast<T>(i) + T(0.5)) / kDeviates);
    found.least = std::min(found.least, n);
    found.most = std::max(found.most, n);
    const Real d = static_cast<Real>(n) - static_cast<Real>(mean);
    first += d / kDeviates;
    second += d * d / kDeviates;
  }
  found.mean_error = std::fabs(first) / std::sqrt(static_cast<Real>(mean));
  found.variance_error = std::fabs((second - first * first) / static_cast<Real>(mean) - 1);
  return found;
}
template <class T>
void expect_poisson(T mean) {
  const auto found = spread_of(mean);
  EXPECT_GE(found.least, 0) << "mean " << mean;
  EXPECT_LE(found.mean_error, 1e-3) << "mean " << mean;
  EXPECT_LE(found.variance_error, 1e-3) << "mean " << mean;
}

TEST(CountKnownFailures, FloatMeanOf1e37Ends) {
  // rand #1312: infinity minus infinity, and the rejection never ended. From 1e36 on all means
  // count alike; a float this large holds no fluctuation at all.
  const auto found = spread_of(1e37f);
  EXPECT_GT(found.least, 0.999e36f);
  EXPECT_LT(found.most, 1.001e36f);
}

TEST(CountKnownFailures, InfiniteMeanEnds) {
  // rand #1290.
  const auto narrow = spread_of(std::numeric_limits<float>::infinity());
  EXPECT_TRUE(narrow.least > 0.999e36f && narrow.most < 1.001e36f) << narrow.least;
  const auto wide = spread_of(std::numeric_limits<double>::infinity());
  EXPECT_TRUE(wide.least > 0.999e36 && wide.most < 1.001e36) << wide.least;
}

TEST(CountKnownFailures, TinyFloatMeanIsNeverMinusOne) {
  // rand #1428: 2e-10 in float gave -1. Exactly: 0 but for a share 2e-10 of the deviates.
  const std::uint64_t all = 1ull << 48;
  EXPECT_EQ(steps_above(2e-10f, 0, -1.0L, all), all);
  EXPECT_NEAR(static_cast<double>(steps_above(2e-10f, 0, 0.0L, all)) * 0x1p-48, 2e-10, 1e-14);
}

TEST(CountKnownFailures, VarianceStandsFrom1e14On) {
  // rand #1515: double's variance was wrong from 1e14 on. To 1e28, where neighbouring doubles lie
  // 2^41 apart and the standard deviation is 46 of them.
  for (double mean : {1e14, 1e15, 1e16, 1e18, 1e20, 1e24, 1e28}) expect_poisson(mean);
}

TEST(CountKnownFailures, FloatVarianceIsNotInflated) {
  // dust #403: rejection under a Cauchy envelope in float. To 1e12, where neighbouring floats lie
  // 65536 apart and the standard deviation is 15 of them.
  for (float mean : {40.0f, 100.0f, 1e3f, 1e4f, 1e6f, 1e8f, 1e10f, 1e12f}) expect_poisson(mean);
}

TEST(CountKnownFailures, MeansBeyondIntegersAreNeverNegative) {
  // ROOT #6927 returned -2147483648 from 2^31 on, Stan #1053 overflowed.
  for (double mean : {2147483647.0, 2147483648.0, 4294967296.0, 9.3e18, 1.9e19}) {
    expect_poisson(mean);
  }
  for (float mean : {2147483520.0f, 2147483648.0f, 4294967296.0f, 1e11f}) expect_poisson(mean);
}

TEST(CountKnownFailures, NoNumberGivesNoFlakes) {
  // ROOT #6927: NaN returned -2147483648.
  for (int slots : {0, 1, 9}) {
    EXPECT_EQ(count_deviate(std::numeric_limits<double>::quiet_NaN(), slots, 0.5), 0);
    EXPECT_EQ(count_deviate(std::numeric_limits<float>::quiet_NaN(), slots, 0.5f), 0);
  }
}

TEST(CountKnownFailures, SmallestAndLargestDeviatesEnd) {
  // Velox #13047: the inversion looped for ever at deviates next to 0 and 1. Beyond what
  // uniform_48 gives, too: 0 itself and NaN.
  // 40 standard deviations, and what the law's skewness adds there.
  const auto check = [](auto mean, auto u) {
    const auto n = count_deviate(mean, 0, u);
    EXPECT_TRUE(std::isfinite(n) && n >= 0 && n <= mean + 40 * std::sqrt(mean) + 300)
        << "mean " << mean << " u " << u << " count " << n;
  };
  for (double mean : {1e-3, 0.5, 15.0, 31.0, 31.999, 32.0, 1e3, 1e15}) {
    for (double u : {1e-300, 0x1p-49, 1 - 0x1p-49, 1.0}) check(mean, u);
    for (float u : {1e-30f, 0x1p-49f, 1 - 0x1p-24f, 1.0f}) check(static_cast<float>(mean), u);
  }
  for (double mean : {1e-3, 0.5, 15.0, 31.0, 31.999}) {
    for (double u : {0.0, std::numeric_limits<double>::quiet_NaN()}) {
      check(mean, u);
      check(static_cast<float>(mean), static_cast<float>(u));
    }
  }
}

TEST(CountKnownFailures, MeansWhoseExponentialUnderflowsEnd) {
  // csound PR 3142: Knuth's product against exp(-1000) = 0 hung. float: from 87.3 on, where a third
  // of the inversions were wrong; at 60 its cumulated sum stuck below u (counts to 1900).
  for (double mean : {750.0, 1000.0, 1e5}) expect_poisson(mean);
  for (float mean : {60.0f, 87.2f, 87.4f, 100.0f, 1000.0f}) {
    expect_poisson(mean);
    EXPECT_LT(spread_of(mean).most, mean + 6 * std::sqrt(mean));
  }
}

TEST(CountKnownFailures, WorkDoesNotGrowWithTheMean) {
  // Knuth's product takes N + 1 deviates and inversion N steps: 1e9 and more of them, 1e5 times,
  // would not end in 20 seconds.
  const auto start = std::chrono::steady_clock::now();
  double sum = 0;
  for (double mean : {31.0, 1e3, 1e9, 1e18, 1e300}) {
    for (int i = 1; i < 20'000; ++i) sum += count_deviate(mean, 0, i / 20'000.0);
  }
  EXPECT_GT(sum, 0);
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 20);
}

}  // namespace
