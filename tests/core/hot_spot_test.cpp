// SPDX-License-Identifier: Apache-2.0
#include "hot_spot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "both_ways.h"
#include "reference/explicit_flakes.h"
#include "scenes.h"
#include "sparkles.h"

using namespace metallic_paint;
using namespace metallic_paint::reference;
using namespace core_tests;

namespace {

TestScene random_scene(Random& random) {
  TestScene scene;
  scene.paint = random_paint(random);
  scene.light_sine = 0.02;
  scene.footprint = 1e-6;
  aim(scene, random, 2);
  return scene;
}

TEST(HotSpot, TheOpticalDepthLeavesTheMeanOfBothWays) {
  Random random = fresh(1601);
  Worst worst;
  for (int k = 0; k < 400; ++k) {
    const double c = random.log_uniform(0.02, 5);
    const double w = random.below(10) == 0 ? 0 : random.log_uniform(0.01, 100);
    const double x = 2 * c + (random.below(2) == 0 ? 0 : random.log_uniform(0.02, 20));
    const double left = x - c * share_in_common(w, x);
    worst.see(relative_error(mean_transmittance(left), free_on_both_ways(c, w, x)), "c", c, "w", w,
              "x", x);
  }
  worst.expect_at_most(0.0125);  // what hot_spot.h states, and the rule's own error
}

TEST(HotSpot, HolesInCommonAreTheIntegralOfWhatDiscsShare) {
  Random random = fresh(1604);
  Worst worst;
  for (int k = 0; k < 400; ++k) {
    const double w = random.log_uniform(1e-2, 1e3), g = random.log_uniform(1e-3, 2);
    constexpr int kPoints = 20000;  // where discs still overlap
    const double end = std::clamp((1 - g) / w, 0.0, 1.0);
    double sum = 0;
    for (int i = 0; i < kPoints; ++i) {
      const double u = g + w * end * (i + 0.5) / kPoints;
      sum += 2 / std::numbers::pi *
             (std::acos(std::min(u, 1.0)) - u * std::sqrt(1 - std::min(u * u, 1.0)));
    }
    worst.see(std::abs(holes_in_common(w, g) - sum * end / kPoints), "w", w, "g", g);
  }
  // O itself is within 0.014, at u = 1, and its integral within 0.001.
  worst.expect_at_most(0.014);
}

TEST(HotSpot, OneWayThereAndBackIsMetOnce) {
  // Light from the observer's own direction, opaque flakes, no binder: x' = D H <S> <cos>, half of
  // what two ways would lose.
  Random random = fresh(1602);
  Worst worst;
  for (int k = 0; k < 200; ++k) {
    TestScene scene = random_scene(random);
    scene.paint.binder_absorption_per_mm = {};
    scene.paint.rayleigh_per_mm = 0;
    scene.paint.flake_transmission = {};
    scene.paint.tilt = std::min(scene.paint.tilt, 0.1);  // no flake shows its back
    scene.view = scene.light = scene.normal;
    scene.paint.depth_model = DepthModel::attenuated;
    const double both = scene.expect<double>().slant.x;
    scene.paint.depth_model = DepthModel::correlated;
    worst.see(relative_error(scene.expect<double>().slant.x, both / 2), scene);
  }
  worst.expect_at_most(1e-12);
}

TEST(HotSpot, SmallFlakesHideIndependently) {
  Random random = fresh(1603);
  Worst worst;
  for (int k = 0; k < 200;) {
    TestScene scene = random_scene(random);
    scene.paint.layer_thickness_um = 1e3;
    scene.paint.flake_diameter_um = 1e-3;
    if (length(scene.view - scene.light) < 0.1) continue;
    ++k;
    scene.paint.depth_model = DepthModel::attenuated;
    const double independent = scene.expect<double>().slant.y;
    scene.paint.depth_model = DepthModel::correlated;
    worst.see(relative_error(scene.expect<double>().slant.y, independent), scene);
  }
  worst.expect_at_most(1e-4);
}

// So much of the paint, in 64 pixels, with every flake traced.
ExplicitScene explicit_scene(const TestScene& s, double area_m2) {
  ExplicitScene scene;
  scene.paint = s.paint;
  scene.view = s.view;
  scene.light = s.light;
  scene.light_radius = std::asin(s.light_sine);
  scene.pixels = 64;
  scene.footprint = area_m2 / 64;
  return scene;
}

// Discs that hide one another, of the paints and angles for which hot_spot.h is made: what they
// leave of a sparkle, over what the model does. Opaque or not, one species or two, of equal flakes
// or spread. The model's own approximations have 3 % of the mean and 6 % of the mean square;
// chance the rest.
void expect_like_traced_discs(Random& random, int scenes) {
  Worst worst, worst_square;
  const double threshold = sidak_threshold(kFreshLevel, scenes);
  int refused = 0;
  for (int k = 0; k < scenes;) {
    TestScene s;
    Paint& paint = s.paint;
    const double coverage = random.log_uniform(0.02, 3);
    const double width = random.log_uniform(0.05, 2);  // D/H
    paint.tilt = random.log_uniform(0.03, 0.4);
    double sticking_out = coverage * width * paint.tilt;
    paint.binder_ior = random.uniform(1.3, 1.8);
    paint.layer_thickness_um = 30;
    paint.flake_diameter_um = width * 30;
    paint.flakes_per_mm2 =
        coverage * 4e6 / (std::numbers::pi * paint.flake_diameter_um * paint.flake_diameter_um);
    paint.flake_area_spread = random.below(2) == 0 ? 0 : random.uniform(0, 0.4);
    if (random.below(3) == 0) {
      paint.flake_color = paint.flake_edge_color = grey(0.5);
      paint.flake_transmission = grey(random.uniform(0, 0.5));
    }
    if (random.below(3) == 0) {
      FlakeSpecies& more = paint.more[0];
      more = paint;
      more.flake_diameter_um = 30 * random.log_uniform(0.05, 2);
      const double covered = coverage * random.uniform(0, 1);
      more.flakes_per_mm2 =
          covered * 4e6 / (std::numbers::pi * more.flake_diameter_um * more.flake_diameter_um);
      more.tilt = random.log_uniform(0.03, 0.4);
      sticking_out += covered * more.flake_diameter_um / 30 * more.tilt;
    }
    if (sticking_out > 0.3) continue;
    aim(s, random, 2, false);
    // Light wide enough to make flakes sparkle, narrow enough for one pair of ways.
    s.light_sine = 0.05;
    s.footprint = 1;
    const double per_m2 = s.expect<double>().mean_count;
    paint.depth_model = DepthModel::correlated;
    ExplicitScene scene = explicit_scene(s, 4'000 / per_m2);
    scene.points = 16;
    scene.seed = random.bits();
    // Where next to no flake sparkles, the reference would take a day and refuses.
    try {
      validate(scene);
    } catch (const std::invalid_argument&) {
      ++refused;
      continue;
    }
    ++k;
    const ExplicitResult traced = trace_explicit_flakes(scene);
    const double sparkles = traced.sparkles[0] + traced.sparkles[1] + traced.sparkles[2];
    const double share = traced.mean_share.y;
    const double by_chance =
        std::sqrt((traced.mean_square_share.y - share * share) / sparkles) / share;
    const double x = s.expect<double>().slant.y;
    const double off = mean_transmittance(x) / share - 1;
    worst.see(std::max(std::fabs(off) - threshold * by_chance, 0.0), s);
    // Of the mean of so many points, squared, one pair in so many is a point with itself.
    const double square = (traced.mean_square_share.y * scene.points - share) / (scene.points - 1);
    const double chance_of_square = std::sqrt((square - square * square) / sparkles) / square;
    const Layer<double> layer = s.layer<double>();
    double model = 0;
    for (std::size_t i = 0; i < 2; ++i) {
      const double hidden = expect_sparkles(layer, s.point<double>(), s.seen<double>(),
                                            static_cast<const Rgb<double>*>(nullptr), i)
                                .hidden;
      model += traced.sparkles[i] / sparkles * mean_transmittance(2 * x - hidden);
    }
    const double off_square = model / square - 1;
    worst_square.see(std::max(std::fabs(off_square) - threshold * chance_of_square, 0.0), s);
  }
  testing::Test::RecordProperty("scenes that the reference refused", refused);
  worst.expect_at_most(0.03, "mean");
  worst_square.expect_at_most(0.06, "mean square");
}

// Where many wide tilted flakes stick out of the layer that holds their centres, the model is too
// bright, as hot_spot.h states: here 1.7 % along the normal, 13 % at 75 degrees.
TEST(HotSpot, WideTiltedFlakesErrAsStated) {
  const struct {
    double degrees, least, most;
  } cases[] = {{0, 0, 0.03}, {75, 0.1, 0.15}};
  for (const auto& [degrees, least, most] : cases) {
    TestScene s;
    Paint& paint = s.paint;
    paint.depth_model = DepthModel::correlated;
    paint.tilt = 0.4;
    paint.binder_ior = 1.33;
    paint.layer_thickness_um = paint.flake_diameter_um = 30;
    paint.flake_spread = paint.flake_area_spread = 0;
    paint.flakes_per_mm2 = 3 * 4e6 / (std::numbers::pi * 30 * 30);  // coverage 3
    const double angle = degrees * std::numbers::pi / 180;
    s.normal = {0, 0, 1};
    s.view = {std::sin(angle), 0, std::cos(angle)};
    s.light = {-s.view.x, 0, s.view.z};
    s.light_sine = 0.03;
    s.footprint = 1;
    ExplicitScene scene = explicit_scene(s, 16'000 / s.expect<double>().mean_count);
    scene.seed = 1;  // the standard error is 1 %
    const ExplicitResult traced = trace_explicit_flakes(scene);
    const double off = mean_transmittance(s.expect<double>().slant.y) / traced.mean_share.y - 1;
    EXPECT_GE(off, least) << degrees;
    EXPECT_LE(off, most) << degrees;
  }
}

TEST(HotSpot, LeavesWhatTracedDiscsLeave) {
  Random random = fresh(1604);
  expect_like_traced_discs(random, 20);
}

TEST(HotSpot, LongLeavesWhatTracedDiscsLeave) {
  Random random = fresh(1605);
  expect_like_traced_discs(random, 300 / kFewer);
}

}  // namespace
