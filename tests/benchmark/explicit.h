// SPDX-License-Identifier: Apache-2.0
//
// The model against individually traced flakes that hide one another: which of the two depth models
// is nearer, and when.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <numbers>
#include <string>
#include <vector>

#include "measure.h"
#include "paint.h"
#include "reference/explicit_flakes.h"

namespace trade {

// What is varied, and the value it has here.
struct ExplicitCase {
  std::string varied;
  double value;
  Paint paint;
  double angle;  // of view and light to the normal, degrees; mirrored by a level flake
};

inline std::vector<ExplicitCase> explicit_cases() {
  Paint base;
  base.flake_spread = 0;
  base.flakes_per_mm2 = 1600;  // coverage 0.5
  std::vector<ExplicitCase> cases;
  const auto area_mm2 =
      std::numbers::pi / 4 * base.flake_diameter_um * base.flake_diameter_um / 1e6;
  for (double coverage : {0.05, 0.2, 0.5, 1.0, 2.0}) {
    Paint paint = base;
    paint.flakes_per_mm2 = coverage / area_mm2;
    cases.push_back({"coverage", coverage, paint, 20});
  }
  for (double angle : {5.0, 30.0, 50.0, 65.0, 80.0}) {
    cases.push_back({"angle to the normal, degrees", angle, base, angle});
  }
  for (double ratio : {0.1, 0.3, 0.67, 2.0, 6.0}) {
    Paint paint = base;
    paint.layer_thickness_um = paint.flake_diameter_um / ratio;
    cases.push_back({"flake diameter over layer thickness", ratio, paint, 20});
  }
  return cases;
}

struct Share {
  double mean, square;  // E[s], E[s^2] of what the layer leaves of a sparkle
};

struct ExplicitFound {
  double count;  // of sparkles, over the model's
  Share traced, attenuated, thinned;
  double deviation_of_mean;                             // standard error of traced.mean
  double distance_attenuated, distance_thinned, floor;  // Wasserstein, in standard deviations
  double flakes, seconds;
};

inline constexpr double kWideLight = 0.1;  // rad: a sparkle for some thirty flakes
inline constexpr double kSparklesPerPixel = 3;

inline ExplicitFound trace(const ExplicitCase& c, int pixels) {
  const double angle = c.angle * std::numbers::pi / 180;
  reference::ExplicitScene scene;
  scene.paint = c.paint;
  scene.view = {std::sin(angle), 0, std::cos(angle)};
  scene.light = {-std::sin(angle), 0, std::cos(angle)};
  scene.light_radius = kWideLight;
  scene.pixels = static_cast<std::size_t>(pixels);

  const SeenLight<double> light =
      see_light<double>({LightKind::parallel, scene.light, std::sin(kWideLight)}, {});
  const auto expect = [&](DepthModel depth, double footprint) {
    Paint paint = c.paint;
    paint.depth_model = depth;
    return expect_sparkles(make_layer<double>(paint), {{}, {0, 0, 1}, scene.view, footprint, 0, 0},
                           light);
  };
  const double per_area = expect(DepthModel::attenuated, 1).mean_count;
  scene.footprint = kSparklesPerPixel / per_area;

  const auto radiances = [&](std::uint64_t seed, double& count, Share& share) {
    scene.seed = seed;
    const reference::ExplicitResult result = reference::trace_explicit_flakes(scene);
    for (double n : result.count) count += n;
    share = {result.mean_share.y, result.mean_square_share.y};
    std::vector<double> values;
    for (const Rgb<double>& t : result.radiance) values.push_back(t.y);
    return std::pair(values, result.flakes);
  };
  const auto modelled = [&](DepthModel depth) {
    const auto expected = expect(depth, scene.footprint);
    std::vector<double> values;
    for (int i = 0; i < pixels; ++i) {
      values.push_back(
          draw_sparkles(expected, c.paint.flake_area_spread, HashWords{1, 2, 3, 4}, i, 0)
              .radiance.y);
    }
    return values;
  };

  ExplicitFound found{};
  double count = 0, other_count = 0;
  Share other;
  const std::clock_t start = std::clock();  // of all threads
  const auto [traced, flakes] = radiances(1, count, found.traced);
  found.seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  found.flakes = flakes;
  const double spread = deviation(traced);
  found.floor = wasserstein(radiances(2, other_count, other).first, traced) / spread;
  found.distance_attenuated = wasserstein(modelled(DepthModel::attenuated), traced) / spread;
  found.distance_thinned = wasserstein(modelled(DepthModel::thinned), traced) / spread;
  found.count = count / (kSparklesPerPixel * pixels);
  found.deviation_of_mean =
      std::sqrt((found.traced.square - found.traced.mean * found.traced.mean) / count);
  const double depth = expect(DepthModel::attenuated, scene.footprint).slant.y;
  found.attenuated = {mean_transmittance(depth), mean_transmittance(2 * depth)};
  found.thinned = {found.attenuated.mean, found.attenuated.mean};  // s is 0 or 1
  return found;
}

// Seconds that one pixel takes if each of its flakes is traced.
inline double seconds_to_trace(const Paint& paint, const SurfacePoint<double>& point,
                               const Light<double>& sun) {
  // The pixel's plane turned to z = 0: only the three cosines matter.
  const double cos_view = dot(point.normal, point.view), cos_light = dot(point.normal, sun.vector);
  const double sin_view = std::sqrt(1 - cos_view * cos_view);
  const double sin_light = std::sqrt(1 - cos_light * cos_light);
  const double cos_azimuth = std::clamp(
      (dot(point.view, sun.vector) - cos_view * cos_light) / (sin_view * sin_light), -1.0, 1.0);
  reference::ExplicitScene scene;
  scene.paint = paint;
  scene.view = {sin_view, 0, cos_view};
  scene.light = {sin_light * cos_azimuth, sin_light * std::sqrt(1 - cos_azimuth * cos_azimuth),
                 cos_light};
  scene.light_radius = std::asin(sun.size);
  scene.footprint = point.footprint;
  scene.pixels = 16;
  const std::clock_t start = std::clock();
  reference::trace_explicit_flakes(scene);
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC /
         static_cast<double>(scene.pixels);
}

}  // namespace trade
