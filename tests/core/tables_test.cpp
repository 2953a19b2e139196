// SPDX-License-Identifier: Apache-2.0
//
// The paper's tables, which ./paint accuracy measures beside the core's functions.
#include "../benchmark/tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "scenes.h"
#include "sparkles.h"
#include "support.h"

namespace {

using namespace metallic_paint;
using core_tests::relative_error;
using core_tests::Worst;
using trade::kOrientationIntervals;
using trade::kProjectionIntervals;
using trade::OrientationTable;
using trade::ProjectionTable;

constexpr Orientation kKinds[] = {Orientation::gaussian, Orientation::beckmann, Orientation::ggx};

TEST(Tables, ProjectionHoldsItsStatedError) {
  const double from[] = {0.15, 0.03, 1e-6}, limit[] = {1.5e-5, 8e-5, 5e-4};
  Worst worst[3];
  for (Orientation kind : kKinds) {
    for (double tilt = 1e-6; tilt <= 1.05; tilt *= std::pow(10, 0.05)) {
      const auto density = make_orientation<double>(kind, std::min(tilt, 1.0));
      const Coating<double> coating{};  // opaque: <s>, the sharper of the two
      const ProjectionTable<double> table(density, coating, kProjectionIntervals);
      double error = 0, where = 0;
      for (int i = 0; i <= kProjectionIntervals * 8; ++i) {
        const double cosine = i / (kProjectionIntervals * 8.0);
        const double here = std::fabs(table.at(cosine).x - mean_projected_area(density, cosine));
        if (here > error) where = cosine;
        error = std::max(error, here);
      }
      for (int range = 0; range < 3; ++range) {
        if (tilt < from[range]) continue;
        worst[range].see(error, "kind", static_cast<int>(kind), "tilt", tilt, "cos", where);
      }
    }
  }
  for (int range = 0; range < 3; ++range) {
    worst[range].expect_at_most(limit[range], "tilt_from_" + std::to_string(from[range]));
  }
}

TEST(Tables, ProjectionStandsInForTheExactProjection) {
  core_tests::Random random = core_tests::same_scenes(30);
  Worst worst;
  for (int k = 0; k < 200; ++k) {
    core_tests::TestScene scene;
    scene.paint = core_tests::random_paint(random);
    core_tests::aim(scene, random, 5);
    const auto layer = scene.layer<double>();
    const Rgb<double> exact = mean_radiance(scene.expect<double>());
    const ProjectionTable<double> table(layer.flakes[0].orientation, layer.flakes[0].coating,
                                        kProjectionIntervals);
    const auto way = pass_between(layer, scene.point<double>(), scene.seen<double>());
    const auto depth = [&](Wide<double> g) {
      const double cosine = std::min(static_cast<double>(g) / layer.eta, 1.0);
      return slant_depth(table.at(cosine) * layer.coverage, layer.binder_depth, cosine);
    };
    const Rgb<double> slant = depth(way.mirror.g_view) + depth(way.mirror.g_light);
    const auto tabulated =
        mean_radiance(expect_sparkles(layer, scene.point<double>(), scene.seen<double>(), &slant));
    worst.see(relative_error(tabulated.y, exact.y), scene);
  }
  worst.expect_at_most(1e-4);
}

// 16384 even steps in cos(beta): the error relative to the peak, over all beta.
TEST(Tables, OrientationOverTheCosineIsNormalisedAndNear) {
  const auto worst_of = [](Orientation kind, double tilt) {
    const auto density = make_orientation<double>(kind, tilt);
    const OrientationTable<double> table(density, kOrientationIntervals);
    long double integral = 0;
    for (std::size_t i = 0; i + 1 < table.value.size(); ++i) {
      integral += (table.value[i] + table.value[i + 1]) / 2.0L / kOrientationIntervals;
    }
    EXPECT_NEAR(static_cast<double>(integral), 1, 1e-12) << "tilt " << tilt;
    const double peak = orientation_density(density, 0.0);
    double worst = 0;
    for (int i = 0; i <= 100000; ++i) {
      const double beta = std::numbers::pi / 2 * i / 100000;
      const double y = std::sin(beta / 2) * std::sin(beta / 2);
      worst = std::max(worst, std::abs(table.at(y) - orientation_density(density, y)) / peak);
    }
    return worst;
  };
  // Measured, relative to the peak: Gaussian 4.0e-8, 3.1e-6, 3.8e-4;
  // Beckmann 1.2e-7, 1.2e-5, 1.5e-3; GGX 9.2e-7, 8.4e-5, 8.0e-3. The error grows as 1/tilt^4.
  const std::array<std::array<double, 3>, 3> limits = {
      {{5e-8, 4e-6, 5e-4}, {1.5e-7, 1.5e-5, 2e-3}, {1.2e-6, 1e-4, 1e-2}}};
  for (Orientation kind : {Orientation::gaussian, Orientation::beckmann, Orientation::ggx}) {
    const auto& limit = limits[static_cast<std::size_t>(kind)];
    EXPECT_LT(worst_of(kind, 0.3), limit[0]) << "kind " << static_cast<int>(kind);
    EXPECT_LT(worst_of(kind, 0.1), limit[1]) << "kind " << static_cast<int>(kind);
    EXPECT_LT(worst_of(kind, 0.03), limit[2]) << "kind " << static_cast<int>(kind);
  }
}

}  // namespace
