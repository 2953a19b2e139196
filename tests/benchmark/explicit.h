// SPDX-License-Identifier: Apache-2.0
//
// The model against individually traced flakes that hide one another: how near each depth model
// is, and when; and what whole pictures of the two are like.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <iterator>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "batch.h"
#include "measure.h"
#include "reference/explicit_flakes.h"
#include "scene.h"

namespace trade {

// What is varied, and the value it has here.
struct ExplicitCase {
  std::string varied;
  double value;
  Paint paint;
  double angle;      // of view and light to the normal, degrees; mirrored by a level flake
  double aside = 0;  // azimuth from the mirror direction to the light, degrees
};

inline std::vector<ExplicitCase> explicit_cases() {
  Paint base;
  base.flake_spread = 0;
  base.diffraction = Diffraction::none;
  base.flakes_per_mm2 = 1600;  // coverage 0.5
  std::vector<ExplicitCase> cases;
  const auto area_mm2 =
      std::numbers::pi / 4 * base.flake_diameter_um * base.flake_diameter_um / 1e6;
  for (double coverage : {0.02, 0.05, 0.2, 0.5, 1.0, 2.0, 3.0}) {
    Paint paint = base;
    paint.flakes_per_mm2 = coverage / area_mm2;
    cases.push_back({"coverage", coverage, paint, 20});
  }
  for (double angle : {5.0, 30.0, 50.0, 65.0, 80.0}) {
    cases.push_back({"angle to the normal, degrees", angle, base, angle});
  }
  for (double ratio : {0.05, 0.1, 0.3, 0.67, 1.0, 2.0, 6.0}) {
    Paint paint = base;
    paint.layer_thickness_um = paint.flake_diameter_um / ratio;
    cases.push_back({"flake diameter over layer thickness", ratio, paint, 20});
  }
  for (double aside : {45.0, 90.0, 135.0, 180.0}) {
    cases.push_back({"azimuth from the mirror direction, degrees", aside, base, 20, aside});
  }
  for (double tilt : {0.05, 0.4}) {
    Paint paint = base;
    paint.tilt = tilt;
    cases.push_back({"tilt", tilt, paint, 20});
  }
  return cases;
}

struct Share {
  double mean, square;  // E[s], E[s^2] of what the layer leaves of a sparkle
};

inline constexpr std::pair<const char*, DepthModel> kDepthModels[] = {
    {"correlated", DepthModel::correlated},
    {"attenuated", DepthModel::attenuated},
    {"thinned", DepthModel::thinned}};

struct ExplicitFound {
  double count;  // of sparkles, over the model's
  Share traced;
  double deviation_of_mean, deviation_of_square;  // standard errors; of the square's no less
  // Of kDepthModels; Wasserstein's distances from the traced law, in its standard deviations.
  Share share[std::size(kDepthModels)];
  double distance[std::size(kDepthModels)];
  double floor;  // the distance of two traced samples
  double flakes, seconds;
};

inline constexpr double kWideLight = 0.1;  // rad: a sparkle for some thirty flakes
inline constexpr double kSparklesPerPixel = 3;

inline ExplicitFound trace(const ExplicitCase& c, int pixels) {
  const double angle = c.angle * std::numbers::pi / 180;
  reference::ExplicitScene scene;
  scene.paint = c.paint;
  scene.view = {std::sin(angle), 0, std::cos(angle)};
  const double azimuth = (180 - c.aside) * std::numbers::pi / 180;
  scene.light = {std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth),
                 std::cos(angle)};
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
    // Of the mean of so many points, squared, one pair in so many is a point with itself.
    const double mean = result.mean_share.y, points = scene.points;
    share = {mean, (result.mean_square_share.y * points - mean) / (points - 1)};
    std::vector<double> values;
    for (const Rgb<double>& t : result.radiance) values.push_back(t.y);
    return std::pair(values, result.flakes);
  };
  const auto modelled = [&](DepthModel depth) {
    const auto expected = expect(depth, scene.footprint);
    std::vector<double> values;
    for (int i = 0; i < pixels; ++i) {
      values.push_back(draw_sparkles(expected, pixel_key({1, 2, 3}, i, 0, 0)).radiance.y);
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
  found.count = count / (kSparklesPerPixel * pixels);
  found.deviation_of_mean =
      std::sqrt((found.traced.square - found.traced.mean * found.traced.mean) / count);
  found.deviation_of_square =  // s^4 is at most s^2
      std::sqrt((found.traced.square - found.traced.square * found.traced.square) / count);
  for (std::size_t i = 0; i < std::size(kDepthModels); ++i) {
    const DepthModel model = kDepthModels[i].second;
    found.distance[i] = wasserstein(modelled(model), traced) / spread;
    // Thinned has attenuated's mean, and s is 0 or 1.
    const bool thinned = model == DepthModel::thinned;
    const auto expected = expect(thinned ? DepthModel::attenuated : model, scene.footprint);
    const double depth = expected.slant.y, mean = mean_transmittance(depth);
    found.share[i] = {mean, thinned ? mean : mean_transmittance(2 * depth - expected.hidden)};
  }
  return found;
}

// The pixel as a plane z = 0; only the three cosines matter.
inline reference::ExplicitScene explicit_pixel(const Scene& scene,
                                               const SurfacePoint<double>& point) {
  const SeenLight<double> seen = see_light(scene.light, point.position);
  const Vec3<double> light(seen.direction);
  const double cos_view = dot(point.normal, point.view), cos_light = dot(point.normal, light);
  const double sin_view = std::sqrt((1 - cos_view) * (1 + cos_view));
  const double sin_light = std::sqrt((1 - cos_light) * (1 + cos_light));
  const double cos_azimuth = std::clamp(
      (dot(point.view, light) - cos_view * cos_light) / (sin_view * sin_light), -1.0, 1.0);
  reference::ExplicitScene pixel;
  pixel.paint = scene.paint;
  pixel.view = {sin_view, 0, cos_view};
  pixel.light = {sin_light * cos_azimuth, sin_light * std::sqrt(1 - cos_azimuth * cos_azimuth),
                 cos_light};
  pixel.light_radius = seen.reach;
  pixel.footprint = point.footprint;
  return pixel;
}

// The picture, each flake of each pixel traced.
inline std::vector<Rgb<double>> trace_picture(const Scene& scene, const Picture& picture,
                                              int seed) {
  std::vector<Rgb<double>> radiance(picture.points.size());
  parallel_for(
      radiance.size(),
      [&](std::size_t i) {
        reference::ExplicitScene pixel = explicit_pixel(scene, picture.points[i]);
        pixel.seed = static_cast<std::uint64_t>(seed) << 32 | i;
        radiance[i] = reference::trace_explicit_flakes(pixel).radiance[0];
      },
      16);
  return radiance;
}

// `count` pixels like each of `points`.
inline std::vector<Draws> trace_draws(const Scene& scene,
                                      const std::vector<SurfacePoint<double>>& points, int count,
                                      std::uint64_t seed) {
  std::vector<Draws> pixels;
  for (const SurfacePoint<double>& point : points) {
    reference::ExplicitScene pixel = explicit_pixel(scene, point);
    pixel.pixels = static_cast<std::size_t>(count);
    pixel.seed = seed;
    const reference::ExplicitResult result = reference::trace_explicit_flakes(pixel);
    Draws draws{result.count, {}};
    for (const Rgb<double>& t : result.radiance) draws.radiance.push_back(luminance(t));
    pixels.push_back(std::move(draws));
  }
  return pixels;
}

}  // namespace trade
