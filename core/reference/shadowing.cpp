// SPDX-License-Identifier: Apache-2.0
#include "shadowing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "optics.h"
#include "spiral.h"

namespace metallic_paint::reference {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kCosineSteps = 32;  // over the light

struct DiscPoint {
  Vec3<double> position;
  Rgb<double> visible;
};

// Dims each point of a flake by the discs above it along `direction`. A way is followed to the
// highest that any disc can reach, and sideways for a thousand layers at most.
void shadow(const FlakePlane& plane, Cell home, std::uint64_t own_index, const Flake& own,
            double radius, Vec3<double> direction, std::vector<DiscPoint>& points,
            const std::stop_token& stop) {
  const double deepest = -own.position.z + radius + plane.widest_radius;
  const double limit = 1e3 * (plane.thickness + plane.widest_radius);
  const double sideways = std::sqrt(square(direction.x) + square(direction.y));
  double full = deepest / direction.z;
  if (sideways * full > limit) full = limit / sideways;
  const double margin = radius + plane.widest_radius;
  plane.visit_along(home, own.position, direction * full, margin, stop,
                    [&](const Flake& other, std::uint64_t index, bool at_home) {
                      if (at_home && index == own_index) return;
                      RandomStream rest = other.rest;
                      const double radius2 = flake_area(*other.species, rest) / kPi;
                      // Too far from the middle of the beam, whatever the disc's tilt.
                      const Vec3<double> between = other.position - own.position;
                      const double along = std::clamp(dot(between, direction), 0.0, full);
                      const Vec3<double> off = between - direction * along;
                      if (dot(off, off) > square(std::sqrt(radius2) + radius)) return;
                      const double slope = dot(other.normal, direction);
                      if (slope == 0) return;
                      const Rgb<double> transmission =
                          flake_transmittance(other.species->flakes, std::abs(slope));
                      for (DiscPoint& point : points) {
                        const Vec3<double> to_centre = other.position - point.position;
                        const double distance = dot(other.normal, to_centre) / slope;
                        if (!(distance > 0)) continue;
                        const Vec3<double> miss = to_centre - direction * distance;
                        if (dot(miss, miss) <= radius2)
                          point.visible = point.visible * transmission;
                      }
                    });
}

}  // namespace

MeanShadowing::MeanShadowing(const FlakePlane& plane, const ViewAndLight& beams)
    : plane_(plane), beams_(beams), passed_(plane.species.size()) {
  if (!beams.seen) return;
  const double width = beams.most_cosine - beams.least_cosine;
  for (std::size_t i = 0; i < passed_.size(); ++i) {
    const Species& some = plane.species[i];
    if (!transmits_by_angle(some.flakes)) continue;
    passed_[i].to_view = some.mean_transmittance(beams.view_in.z);
    for (int k = 0; k <= kCosineSteps; ++k) {
      passed_[i].to_light.push_back(
          some.mean_transmittance(beams.least_cosine + width * k / kCosineSteps));
    }
  }
}

Rgb<double> MeanShadowing::depth(double cos_light) const {
  Rgb<double> sum{};
  for (std::size_t i = 0; i < passed_.size(); ++i) {
    const Species& some = plane_.species[i];
    const double to_view = some.projected_area.at(beams_.view_in.z) / beams_.view_in.z;
    const double to_light = some.projected_area.at(cos_light) / cos_light;
    if (passed_[i].to_light.empty()) {
      sum = sum + (grey(1.0) - flake_transmittance(some.flakes, 1)) * some.coverage *
                      (to_view + to_light);
      continue;
    }
    const double width = std::max(beams_.most_cosine - beams_.least_cosine, 1e-12);
    const double place =
        std::clamp((cos_light - beams_.least_cosine) / width, 0.0, 1.0) * kCosineSteps;
    const int below = std::min(static_cast<int>(place), kCosineSteps - 1);
    const Rgb<double>* node = &passed_[i].to_light[static_cast<std::size_t>(below)];
    const Rgb<double> passed = node[0] + (node[1] - node[0]) * (place - below);
    sum = sum + ((grey(1.0) - passed_[i].to_view) * to_view + (grey(1.0) - passed) * to_light) *
                    some.coverage;
  }
  return sum;
}

Rgb<double> visible_share(const FlakePlane& plane, Vec3<double> view_in, Vec3<double> towards_light,
                          Cell home, std::uint64_t index, const Flake& flake, double area,
                          int count, RandomStream& random, const std::stop_token& stop) {
  const double radius = std::sqrt(area / kPi);
  const Frame frame = frame_of(flake.normal);
  const Spiral spiral(count, random);
  std::vector<DiscPoint> points;
  for (int i = 0; i < count; ++i) {
    const double r = radius * std::sqrt(spiral.area_within(i)), angle = spiral.angle(i);
    points.push_back(
        {flake.position + frame.a * (r * std::cos(angle)) + frame.b * (r * std::sin(angle)),
         {1, 1, 1}});
  }
  shadow(plane, home, index, flake, radius, view_in, points, stop);
  shadow(plane, home, index, flake, radius, towards_light, points, stop);
  Rgb<double> sum{};
  for (const DiscPoint& point : points) sum = sum + point.visible;
  return sum / static_cast<double>(count);
}

}  // namespace metallic_paint::reference
