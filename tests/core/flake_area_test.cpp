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
    const auto d = area_moments(static_cast<double>(spread));
    const auto f = area_moments(spread);
    wide.see(relative_error(d.mean, mean), "mean, spread", spread);
    wide.see(relative_error(d.square, square), "square, spread", spread);
    narrow.see(relative_error(f.mean, mean), "mean, spread", spread);
    narrow.see(relative_error(f.square, square), "square, spread", spread);
  }
  wide.expect_at_most(1e-15, "double");
  narrow.expect_at_most(1e-6, "float");
}

TEST(FlakeArea, SmallSpreadsKeepTheNormalDeviatesOwnMoments) {
  for (double spread : {0.0, 0.1, 0.2, 0.25}) {
    const auto moments = area_moments(spread);
    EXPECT_NEAR(moments.mean, 1, 1e-5) << "spread " << spread;
    EXPECT_NEAR(moments.square, 1 + spread * spread, 1e-5) << "spread " << spread;
  }
}

TEST(FlakeArea, CappedMomentsMatchQuadrature) {
  Worst wide, narrow, wide_ordinary, narrow_ordinary;
  for (float spread : spreads()) {
    const auto whole = area_moments(static_cast<double>(spread));
    const auto whole_f = area_moments(spread);
    std::vector<float> caps{0.0499f, 0.05f, 0.0501f, 0.3f, 0.5f, 0.9f, 0.99f, 1.0f, 1.01f, 2.0f};
    for (double c = 1e-6; c < 1e3; c *= 1.9) caps.push_back(static_cast<float>(c));
    for (float cap : caps) {
      const Real mean = independent::area_moment(spread, 1, cap);
      const Real square = independent::area_moment(spread, 2, cap);
      const auto d =
          capped_area_moments(static_cast<double>(spread), static_cast<double>(cap), whole);
      const auto f = capped_area_moments(spread, cap, whole_f);
      for (const auto& [name, exact, found, found_f] :
           {std::tuple{"mean", mean, d.mean, f.mean},
            std::tuple{"square", square, d.square, f.square}}) {
        wide.see(relative_error(found, exact), name, "spread", spread, "cap", cap);
        narrow.see(relative_error(found_f, exact), name, "spread", spread, "cap", cap);
        if (spread > 1) continue;
        wide_ordinary.see(relative_error(found, exact), name, "spread", spread, "cap", cap);
        narrow_ordinary.see(relative_error(found_f, exact), name, "spread", spread, "cap", cap);
      }
    }
  }
  wide_ordinary.expect_at_most(1e-14, "double_spread_to_1");
  wide.expect_at_most(1e-14, "double");
  narrow_ordinary.expect_at_most(2e-6, "float_spread_to_1");
  narrow.expect_at_most(2e-6, "float");
}

template <class T>
void expect_sound_moments() {
  for (float spread : spreads()) {
    const auto whole = area_moments(static_cast<T>(spread));
    AreaMoments<T> previous{0, 0};
    for (double c = 1e-9; c < 1e5; c *= 1.1) {
      const T cap = static_cast<T>(c);
      const auto capped = capped_area_moments(static_cast<T>(spread), cap, whole);
      ASSERT_GT(capped.mean, 0) << "spread " << spread << " cap " << cap;
      ASSERT_GT(capped.square, 0) << "spread " << spread << " cap " << cap;
      const T slack = std::is_same_v<T, float> ? T(1.00001) : T(1 + 1e-13);
      ASSERT_LE(capped.mean, cap * slack) << "spread " << spread << " cap " << cap;
      ASSERT_LE(capped.mean, whole.mean * slack) << "spread " << spread << " cap " << cap;
      // The square of a mean is at most the mean of a square, that at most cap times the mean.
      ASSERT_LE(capped.mean * capped.mean, capped.square * slack)
          << "spread " << spread << " cap " << cap;
      ASSERT_LE(capped.square, cap * capped.mean * slack) << "spread " << spread << " cap " << cap;
      ASSERT_GE(capped.mean * slack, previous.mean) << "spread " << spread << " cap " << cap;
      previous = capped;
    }
  }
}

TEST(FlakeArea, CappedMomentsArePossible) {
  expect_sound_moments<double>();
  expect_sound_moments<float>();
}

TEST(FlakeArea, EqualFlakesHaveNoSpread) {
  const auto whole = area_moments(0.0);
  EXPECT_EQ(whole.mean, 1);
  EXPECT_EQ(whole.square, 1);
  EXPECT_EQ(capped_area_moments(0.0, 2.0, whole).mean, 1);
  EXPECT_EQ(capped_area_moments(0.0, 1.0, whole).square, 1);
  EXPECT_EQ(capped_area_moments(0.0, 0.25, whole).mean, 0.25);
  EXPECT_EQ(capped_area_moments(0.0, 0.25, whole).square, 0.0625);
}

}  // namespace
