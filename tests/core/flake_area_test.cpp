// SPDX-License-Identifier: Apache-2.0
//
// Moments of the flake area max(0, 1 + s w), whole and cut off at a cap, against quadrature over w.
#include "flake_area.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <type_traits>
#include <vector>

#include "independent.h"
#include "support.h"

namespace {

using namespace metallic_paint;
using core_tests::relative_error;
using core_tests::Worst;
using Real = long double;

constexpr Real kNoCap = 1e30L;

std::vector<float> spreads() {
  std::vector<float> made{0, 1e-6f, 1e-3f, 0.05f, 0.1f, 0.117f, 0.1177f, 0.12f, 0.15f};
  for (double s = 0.2; s < 100; s *= 1.15) made.push_back(static_cast<float>(s));
  made.push_back(100);
  return made;
}

TEST(FlakeArea, MomentsMatchQuadrature) {
  Worst wide, narrow;
  for (float spread : spreads()) {
    const Real mean = independent::area_moment(spread, 1, kNoCap);
    const Real square = independent::area_moment(spread, 2, kNoCap);
    const auto d = static_cast<double>(spread);
    wide.see(relative_error(area_mean(d), mean), "mean, spread", spread);
    wide.see(relative_error(capped_area_square(d, 1e30), square), "square, spread", spread);
    narrow.see(relative_error(area_mean(spread), mean), "mean, spread", spread);
    narrow.see(relative_error(capped_area_square(spread, 1e30f), square), "square, spread", spread);
  }
  wide.expect_at_most(1e-15, "double");
  narrow.expect_at_most(1e-6, "float");
}

TEST(FlakeArea, SmallSpreadsKeepTheNormalDeviatesOwnMoments) {
  for (double spread : {0.0, 0.1, 0.2, 0.25}) {
    EXPECT_NEAR(area_mean(spread), 1, 1e-5) << "spread " << spread;
    EXPECT_NEAR(capped_area_square(spread, 1e30), 1 + spread * spread, 1e-5) << "spread " << spread;
  }
}

TEST(FlakeArea, CappedMomentsMatchQuadrature) {
  Worst wide, narrow;
  for (float spread : spreads()) {
    const auto s = static_cast<double>(spread);
    std::vector<float> caps{0.0499f, 0.05f, 0.0501f, 0.3f, 0.5f, 0.9f, 0.99f, 1.0f, 1.01f, 2.0f};
    for (double c = 1e-6; c < 1e3; c *= 1.9) caps.push_back(static_cast<float>(c));
    for (float cap : caps) {
      const Real mean = independent::area_moment(spread, 1, cap);
      const Real square = independent::area_moment(spread, 2, cap);
      const auto c = static_cast<double>(cap);
      for (const auto& [name, exact, found, found_f] :
           {std::tuple{"mean", mean, capped_area_mean(s, c, area_mean(s)),
                       capped_area_mean(spread, cap, area_mean(spread))},
            std::tuple{"square", square, capped_area_square(s, c),
                       capped_area_square(spread, cap)}}) {
        wide.see(relative_error(found, exact), name, "spread", spread, "cap", cap);
        narrow.see(relative_error(found_f, exact), name, "spread", spread, "cap", cap);
      }
    }
  }
  wide.expect_at_most(1e-14, "double");
  narrow.expect_at_most(2e-6, "float");
}

template <class T>
void expect_sound_moments() {
  const T slack = std::is_same_v<T, float> ? T(1.00001) : T(1 + 1e-13);
  for (float narrow : spreads()) {
    const T spread = static_cast<T>(narrow), whole = area_mean(spread);
    T previous = 0;
    for (double c = 1e-9; c < 1e5; c *= 1.1) {
      const T cap = static_cast<T>(c);
      const T mean = capped_area_mean(spread, cap, whole), square = capped_area_square(spread, cap);
      // The square of a mean is at most the mean of a square, that at most cap times the mean.
      ASSERT_TRUE(mean > 0 && square > 0) << "spread " << spread << " cap " << cap;
      ASSERT_LE(mean, std::min(cap, whole) * slack) << "spread " << spread << " cap " << cap;
      ASSERT_LE(mean * mean, square * slack) << "spread " << spread << " cap " << cap;
      ASSERT_LE(square, cap * mean * slack) << "spread " << spread << " cap " << cap;
      ASSERT_GE(mean * slack, previous) << "spread " << spread << " cap " << cap;
      previous = mean;
    }
  }
}

TEST(FlakeArea, CappedMomentsArePossible) {
  expect_sound_moments<double>();
  expect_sound_moments<float>();
}

TEST(FlakeArea, EqualFlakesHaveNoSpread) {
  EXPECT_EQ(area_mean(0.0), 1);
  for (double cap : {2.0, 1.0, 0.25}) {
    const double seen = std::min(cap, 1.0);
    EXPECT_EQ(capped_area_mean(0.0, cap, 1.0), seen);
    EXPECT_EQ(capped_area_square(0.0, cap), seen * seen);
  }
}

}  // namespace
