// SPDX-License-Identifier: Apache-2.0
//
// How lights look from a point of the surface.
#include "light.h"

#include <cmath>

#include "independent.h"
#include "support.h"

namespace {

using namespace metallic_paint;
using core_tests::fresh;
using core_tests::Random;
using core_tests::relative_error;
using core_tests::Worst;
using Real = long double;

template <class T>
SeenLight<T> sun(Vec3<T> direction, T sine) {
  return see_light<T>({LightKind::parallel, direction, sine}, {T(7), T(-3), T(1)});
}

TEST(Light, AngularRadiusIsKeptToTheLastPlaces) {
  // h = sin^2(Delta_a/2), from the sine of the angular radius.
  Worst wide, narrow;
  for (double sine = 1e-12; sine <= 1; sine *= 1.07) {
    const float s = static_cast<float>(sine);
    const Real exact = std::pow(std::sin(std::asin(static_cast<Real>(s)) / 2), 2);
    narrow.see(relative_error(sun<float>({0, 0, 1}, s).sin2_half_radius, exact), "sine", s);
    wide.see(relative_error(sun<double>({0, 0, 1}, s).sin2_half_radius, exact), "sine", s);
  }
  wide.expect_at_most(1e-15, "double");
  narrow.expect_at_most(4e-7, "float");
  EXPECT_EQ(sun<double>({0, 0, 1}, 0).sin2_half_radius, 0);
  EXPECT_EQ(sun<double>({0, 0, 1}, 1).sin2_half_radius, 0.5) << "a half sphere of light";
}

TEST(Light, SolidAngleOfASmallDiscIsFlat) {
  const double radius = 1e-5;
  const auto seen = sun<double>({0, 0, 1}, std::sin(radius));
  EXPECT_NEAR(static_cast<double>(4 * seen.sin2_half_radius) / (radius * radius), 1, 1e-10);
}

TEST(Light, PositionalLightShowsItsRadiusOverItsDistance) {
  Random random = fresh(60);
  Worst direction, size;
  for (int i = 0; i < 10'000; ++i) {
    const auto any = [&] { return random.uniform(-10, 10); };
    const Vec3<double> centre{any(), any(), any()}, point{any(), any(), any()};
    const double radius = random.log_uniform(1e-6, 3);
    const auto seen = see_light<double>({LightKind::positional, centre, radius}, point);
    const independent::Vector away{Real(centre.x) - point.x, Real(centre.y) - point.y,
                                   Real(centre.z) - point.z};
    const Real distance = independent::length(away);
    const Real exact = std::pow(std::sin(std::asin(std::fmin(radius / distance, 1)) / 2), 2);
    size.see(relative_error(seen.sin2_half_radius, exact), "radius", radius, "distance", distance);
    direction.see(std::fabs(seen.direction.x - away.x / distance), "x, distance", distance);
    EXPECT_NEAR(static_cast<double>(length(seen.direction)), 1, 1e-15);
    EXPECT_TRUE(seen.visible);
  }
  size.expect_at_most(1e-14, "size");
  direction.expect_at_most(1e-15, "direction");
}

TEST(Light, PositionalLightFarAwayIsParallel) {
  const auto far = see_light<double>({LightKind::positional, {3e15, 0, 4e15}, 5e13}, {1, 2, 3});
  EXPECT_NEAR(static_cast<double>(far.direction.x), 0.6, 1e-14);
  EXPECT_NEAR(static_cast<double>(far.direction.z), 0.8, 1e-14);
  EXPECT_NEAR(static_cast<double>(far.sin2_half_radius),
              static_cast<double>(sun<double>({0, 0, 1}, 0.01).sin2_half_radius), 1e-16);
}

TEST(Light, PositionalLightAroundThePointFillsHalfTheSky) {
  for (double distance : {1.0, 0.999, 1e-6}) {
    const auto seen = see_light<double>({LightKind::positional, {0, 0, distance}, 1}, {});
    EXPECT_EQ(seen.sin2_half_radius, 0.5) << "distance " << distance;
    EXPECT_TRUE(seen.visible);
  }
  // At its very centre there is no direction.
  EXPECT_FALSE(see_light<double>({LightKind::positional, {1, 2, 3}, 1}, {1, 2, 3}).visible);
}

TEST(Light, ParallelLightIsTheSameEverywhereAndOfAnyLength) {
  const Light<double> light{LightKind::parallel, {0, 30, 40}, 0.01};
  for (Vec3<double> point : {Vec3<double>{}, Vec3<double>{1e6, -5, 2}}) {
    const auto seen = see_light(light, point);
    EXPECT_DOUBLE_EQ(static_cast<double>(seen.direction.y), 0.6);
    EXPECT_DOUBLE_EQ(static_cast<double>(seen.direction.z), 0.8);
  }
}

TEST(Light, UnusedAndUndirectedLightsAreNotSeen) {
  EXPECT_FALSE(see_light<double>({}, {}).visible);
  EXPECT_FALSE(see_light<double>({LightKind::parallel, {0, 0, 0}, 0.1}, {}).visible);
  EXPECT_FALSE(see_light<float>({LightKind::parallel, {0, 0, 0}, 0.1f}, {}).visible);
}

TEST(Light, TwoLightsShareACone_WhereDiscsAndGapMeet) {
  Random random = fresh(61);
  for (int i = 0; i < 20'000; ++i) {
    const double a = random.log_uniform(1e-6, 0.5), b = random.log_uniform(1e-6, 0.5);
    const double phi = random.uniform(0, 6.28);
    const double apart = random.uniform(0, 2 * (a + b) + 2 * kLeastGap);
    std::array<SeenLight<double>, 2> seen = {
        sun<double>({0, 0, 1}, std::sin(a)),
        sun<double>(
            {std::sin(apart) * std::cos(phi), std::sin(apart) * std::sin(phi), std::cos(apart)},
            std::sin(b))};
    std::array<int, 2> leader = {0, 1};
    share_cones(seen.data(), leader.data(), 2, 1.0);
    if (std::abs(apart - (a + b + kLeastGap)) > 1e-9) {
      EXPECT_EQ(leader[1], apart < a + b + kLeastGap ? 0 : 1) << a << ' ' << b << ' ' << apart;
    }
  }
}

TEST(Light, ConesEndBeforeOtherLights) {
  Random random = fresh(62);
  int followers = 0, leaders = 0, chained = 0;
  for (int i = 0; i < 5'000; ++i) {
    std::array<SeenLight<double>, 8> seen, own;
    std::array<int, 8> leader;
    for (std::size_t k = 0; k < 8; ++k) {
      const double x = random.uniform(-0.05, 0.05), y = random.uniform(-0.05, 0.05);
      seen[k] = sun<double>({x, y, std::sqrt(1 - x * x - y * y)}, random.log_uniform(1e-4, 0.01));
      leader[k] = k == 5 ? -1 : static_cast<int>(k);  // one that is not there
    }
    own = seen;
    share_cones(seen.data(), leader.data(), 8, 1.0);
    EXPECT_EQ(leader[5], -1);
    for (std::size_t k = 0; k < 8; ++k) {
      if (leader[k] < 0) continue;
      const auto lead = static_cast<std::size_t>(leader[k]);
      ASSERT_LE(lead, k);
      ASSERT_EQ(leader[lead], leader[k]);
      // The cone holds all that follow.
      EXPECT_LE(angle_between(seen[lead], own[k]) + own[k].reach, seen[lead].reach + 1e-12);
      if (lead != k) {
        ++followers;
        continue;
      }
      ++leaders;
      EXPECT_GE(seen[k].widest, seen[k].reach);
      bool meets = false;  // another's cone that grew afterwards, by lights that joined it
      for (std::size_t other = 0; other < 8; ++other) {
        if (leader[other] < 0 || leader[other] == leader[k]) continue;
        const double angle = angle_between(seen[k], own[other]);
        if (leader[other] == static_cast<int>(other)) {
          EXPECT_GE(angle, own[k].reach + own[other].reach + kLeastGap - 1e-12);
          meets = meets || angle < seen[k].reach + seen[other].reach;
          if (angle < seen[k].reach + seen[other].reach) continue;
          EXPECT_LE(seen[k].widest + seen[other].widest, angle + 1e-12);
        }
        if (angle < seen[k].reach + own[other].reach) {
          meets = true;
        } else {
          EXPECT_LE(seen[k].widest + own[other].reach, angle + 1e-12);
        }
      }
      chained += meets;
    }
  }
  EXPECT_GT(followers, 1'000);
  EXPECT_LT(chained, leaders / 2) << "of " << leaders;
}

}  // namespace
