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

#include "random.h"
#include "reference.h"
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
  for (float mean :
       {32.0f, 32.3f, 33.0f, 35.5f, 40.0f, 50.0f, 64.0f, 100.0f, 316.0f, 1e3f, 1e4f, 1e5f}) {
    wide.see(compare_poisson<double>(mean).total_variation, "mean", mean);
    // A float tells counts up to 1e4 apart to 1e-3.
    if (mean <= 1e4f) narrow.see(compare_poisson<float>(mean).total_variation, "mean", mean);
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
  Worst mean_error, variance_error;
  std::vector<float> means{1, 4, 10, 16, 25, 31.999998f, 32, 33, 40, 64, 100, 1000, 1e4f, 1e5f};
  for (float m = 1e-9f; m < 1; m *= 10) means.push_back(m);
  for (float mean : means) {
    const Compared found = compare_poisson(mean);
    mean_error.see(relative_error(found.mean, mean), "mean", mean);
    variance_error.see(relative_error(found.variance, mean), "mean", mean);
  }
  mean_error.expect_at_most(1e-5, "mean");
  variance_error.expect_at_most(1e-4, "variance");
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
  // As many steps as the count, at the smallest deviate.
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

TEST(Count, AvoidsTheKnownFailuresOfOtherSamplers) {
  Random random(11);
  const double inf = std::numeric_limits<double>::infinity();
  const auto u = [&] { return deviate<double>(random.bits() >> 16); };
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 20'000; ++i) {
    // rand #1312: 1e37 in float hung; #1290: infinity hung.
    EXPECT_TRUE(std::isfinite(count_deviate(1e37f, 0, static_cast<float>(u()))));
    EXPECT_TRUE(std::isfinite(count_deviate(static_cast<float>(inf), 0, static_cast<float>(u()))));
    EXPECT_TRUE(std::isfinite(count_deviate(inf, 0, u())));
    // rand #1428: 2e-10 in float returned -1.
    EXPECT_GE(count_deviate(2e-10f, 0, static_cast<float>(u())), 0);
    // ROOT #6927, Stan #1053: means from 2^31 on returned -2147483648 or overflowed.
    EXPECT_GT(count_deviate(2147483648.0, 0, u()), 2147000000.0);
    EXPECT_GT(count_deviate(5e9, 0, u()), 4.9e9);
    // csound PR 3142: exp(-1000) underflows, Knuth's product never ends.
    EXPECT_GT(count_deviate(1000.0, 0, u()), 700);
    EXPECT_GT(count_deviate(1000.0f, 0, static_cast<float>(u())), 700);
    // numerics.md: 60 and 100 in float ran to their caps, or were a third wrong.
    EXPECT_LT(count_deviate(60.0f, 0, static_cast<float>(u())), 150);
    EXPECT_LT(count_deviate(100.0f, 0, static_cast<float>(u())), 220);
  }
  // Velox #13047: at the ends of u the inversion went on for ever.
  for (double mean : {1e-3, 0.5, 31.0, 1e3, 1e15}) {
    for (double end : {0x1p-49, 1 - 0x1p-49, 1.0}) {
      EXPECT_TRUE(std::isfinite(count_deviate(mean, 0, end))) << "mean " << mean << " u " << end;
      EXPECT_TRUE(
          std::isfinite(count_deviate(static_cast<float>(mean), 0, static_cast<float>(end))))
          << "mean " << mean << " u " << end;
    }
  }
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 20);
}

}  // namespace
