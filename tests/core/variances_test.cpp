// SPDX-License-Identifier: Apache-2.0
//
// The test of variances itself: that it finds the errors it is for.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

#include "support.h"

namespace {

using namespace core_tests;

// z of the variance found from n Poisson counts, taken for `wrong` times what it is.
double poisson_deviation(double mean, double wrong, int n, std::mt19937_64& engine) {
  std::poisson_distribution<int> poisson(mean);
  Moments counts{mean};
  for (int i = 0; i < n; ++i) counts.add(poisson(engine));
  const double exact = mean * wrong;
  const double fourth = fourth_moment_of_sum(mean, 0, 1, 1, 1, 1) * wrong * wrong;
  return Variances::deviation(counts.variance(), exact, fourth, n);
}

TEST(Variances, OneOf400000DrawsTellsThreePerCent) {
  std::mt19937_64 engine(run_seed());
  for (double mean : {2.0, 30.0}) {
    EXPECT_LE(std::fabs(poisson_deviation(mean, 1, 400'000, engine)), Variances::threshold());
    EXPECT_GT(poisson_deviation(mean, 0.97, 400'000, engine), Variances::threshold());
    EXPECT_LT(poisson_deviation(mean, 1.03, 400'000, engine), -Variances::threshold());
  }
}

TEST(Variances, ManyOf20000DrawsTogetherTellThreePerCent) {
  std::mt19937_64 engine(run_seed() + 1);
  double sum = 0;
  constexpr int kTests = 60;
  for (int i = 0; i < kTests; ++i) sum += poisson_deviation(5, 0.97, 20'000, engine);
  EXPECT_GT(sum / std::sqrt(1.0 * kTests), Variances::threshold());
}

TEST(Variances, RareSparklesAreJudgedByTheirFourthMoment) {
  // 400 sparkles in 40,000 pixels: a normal law's error, sqrt(2/n), would call chance an error.
  std::mt19937_64 engine(run_seed() + 2);
  for (int i = 0; i < 20; ++i) {
    EXPECT_LE(std::fabs(poisson_deviation(0.01, 1, 40'000, engine)), Variances::threshold());
  }
}

}  // namespace
