// SPDX-License-Identifier: Apache-2.0
//
// The whole paint beside finite flakes: random paints, lights and views, and what the model shows
// there. For finite_flakes.cpp, which measures its errors, and mixture_fit.cpp, which fits its
// constants.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <vector>

#include "mixture_scenes.h"
#include "reference/disc_walk.h"
#include "whole_paint.h"

namespace core_tests {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDetectorRadius = 0.1;
// What is traced with a greater relative error is left out.
inline constexpr double kMostNoise = 0.04;

struct Geometry {
  double light, view, azimuth;  // degrees; the light's azimuth is 0
};
// At 45 degrees the views 15, 45, 75 and 110 off the highlight; then what grazes.
inline constexpr Geometry kGeometries[] = {
    {45, 30, 180}, {45, 0, 0},   {45, 30, 0},   {45, 65, 0}, {45, 45, 90}, {80, 0, 0},
    {80, 45, 0},   {80, 45, 90}, {80, 45, 180}, {85, 0, 0},  {85, 45, 0},  {85, 45, 180},
};
inline constexpr std::size_t kGeometriesInAll = std::size(kGeometries);

inline Vec3<double> direction(double degrees, double azimuth) {
  return spherical(degrees * kPi / 180, azimuth * kPi / 180);
}

// Tilts, coverages and flakes as car paints have them, and beyond.
inline Paint random_layer(Random& random) {
  const auto colour = [&](double from) {
    return Rgb<double>{random.uniform(from, 1), random.uniform(from, 1), random.uniform(from, 1)};
  };
  Paint paint = undiffracted();
  paint.depth_model = DepthModel::correlated;
  paint.layer_thickness_um = random.uniform(10, 60);
  paint.binder_ior = random.uniform(1.4, 1.6);
  const int species = 1 + (random.below(3) == 0 ? 1 : 0);
  const double coverage = random.log_uniform(0.1, 3) / species;
  const auto flakes = [&](FlakeSpecies& some) {
    some.flake_diameter_um = paint.layer_thickness_um * random.log_uniform(0.1, 2);
    some.flake_area_spread = random.uniform(0, 0.3);
    some.flakes_per_mm2 = coverage * 4e6 / (kPi * some.flake_diameter_um * some.flake_diameter_um);
    some.orientation = static_cast<Orientation>(random.below(3));
    some.tilt = random.log_uniform(0.05, 0.4);
    some.flake_transmission = random.below(3) == 0 ? colour(0) * 0.8 : Rgb<double>{};
    const Rgb<double> most = grey(1.0) - some.flake_transmission;
    some.flake_color = most * colour(0.4);
    some.flake_edge_color = most * colour(0.7);
  };
  flakes(paint);
  if (species > 1) flakes(paint.more[0]);
  paint.binder_absorption_per_mm = colour(0) * (random.below(2) == 0 ? 0.0 : 10.0);
  paint.rayleigh_per_mm = random.below(3) == 0 ? random.log_uniform(0.03, 1) : 0;
  paint.substrate_color = grey(random.uniform(0, 0.9));
  return paint;
}

// Photons from so many degrees, and a detector at each of kGeometries with this light.
inline reference::DiscScene scene_of(const Paint& paint, double slant, std::size_t photons,
                                     std::uint64_t seed) {
  reference::DiscScene scene;
  scene.paint = paint;
  scene.substrate = paint.substrate_color;
  scene.light = direction(slant, 0);
  scene.detector_radius = kDetectorRadius;
  scene.photons = photons;
  scene.seed = seed;
  for (const Geometry& at : kGeometries) {
    if (at.light == slant) scene.detectors.push_back(direction(at.view, at.azimuth));
  }
  return scene;
}

// The mean over the detector's cone, by the projected solid angle, of what lies below the coat and
// shows shown(layer, stack, point).
template <class Shown>
double seen_by_detector(const Paint& paint, Vec3<double> view, const Shown& shown) {
  const Layer<double> layer = make_layer<double>(paint);
  const Vec3<double> up{0, 0, 1};
  const reference::Frame frame = reference::frame_of(view);
  constexpr int kPoints = 24;
  double sum = 0, weights = 0;
  for (int i = 0; i < kPoints; ++i) {
    const double drop = 2 * std::pow(std::sin(kDetectorRadius / 2), 2) * (i + 0.5) / kPoints;
    const double sine = std::sqrt(drop * (2 - drop)), turn = i * 2.399963229728653;
    SurfacePoint<double> point{};
    point.normal = up;
    point.view = view * (1 - drop) + (frame.a * std::cos(turn) + frame.b * std::sin(turn)) * sine;
    const Stack<double> stack = make_stack(paint, layer, point, up);
    const double weight = point.view.z;
    sum += weight * stack.coat.rest * shown(layer, stack, point);
    weights += weight;
  }
  return sum / weights;
}

// f of the model in green: of single flakes, and of all else.
inline double single_of(const Paint& paint, Vec3<double> light, Vec3<double> view) {
  return seen_by_detector(paint, view, [&](const auto& layer, const auto&, const auto& point) {
    return flake_brdf(layer, point.normal, point.view, light).y;
  });
}

inline double rest_of(const Paint& paint, Vec3<double> light, Vec3<double> view) {
  return seen_by_detector(paint, view, [&](const auto&, const auto& stack, const auto& point) {
    return scattered_by(stack, point, light).y / light.z;
  });
}

inline double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5));
}

inline std::vector<double> sizes(std::vector<double> values) {
  for (double& value : values) value = std::fabs(value);
  return values;
}

// Share of them.
inline double within(const std::vector<double>& sizes, double limit) {
  const auto count = std::count_if(sizes.begin(), sizes.end(), [&](double x) { return x < limit; });
  return static_cast<double>(count) / static_cast<double>(sizes.size());
}

}  // namespace core_tests
