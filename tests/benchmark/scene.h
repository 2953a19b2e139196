// SPDX-License-Identifier: Apache-2.0
//
// A painted ball under the sun before a pinhole camera, pixel by pixel, without a renderer.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "paint.h"

namespace trade {

using namespace metallic_paint;

struct Scene {
  std::string name, what;
  double radius;  // of the ball, m
  Paint paint;
};

// The same ball from near to far: from rare bright points over texture to the mean. Flakes that lie
// flatter than the default's are what tables see least of; those less flat show their backs.
inline std::vector<Scene> scenes() {
  Paint narrow;
  narrow.tilt = 0.05;
  Paint wide;
  wide.tilt = 0.4;
  return {{"near", "a ball of 0.3 m", 0.15, {}},
          {"middle", "a ball of 1.6 m", 0.8, {}},
          {"far", "a ball of 12 m", 6, {}},
          {"narrow", "a ball of 1.6 m, tilt 0.05", 0.8, narrow},
          {"wide", "a ball of 1.6 m, tilt 0.4", 0.8, wide}};
}

inline const Light<double> kSun{LightKind::parallel, {0.36, 0.48, 0.8}, 0.00465};

struct Picture {
  int size;
  std::vector<SurfacePoint<double>> points;  // of the pixels that see the lit side
  std::vector<float> base;                   // of every pixel: the rest of the picture, grey
};

// Radiance of the ball's dull ground and of the background, the sun on white being 1.
inline constexpr double kGround = 0.04, kBackground = 0.15;

inline Picture look(const Scene& scene, int size) {
  Picture picture{size, {}, {}};
  const double distance = 4 * scene.radius;
  // The image plane at distance 1 holds the ball and a rim.
  const double half = 1.06 / std::sqrt(15.0), step = 2 * half / size;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const Vec3<double> through{-half + (x + 0.5) * step, half - (y + 0.5) * step, -1};
      const double length_through = length(through);
      const Vec3<double> ray = through / length_through;
      const Vec3<double> eye{0, 0, distance};
      // |eye + t ray| = radius
      const double middle = -dot(eye, ray);
      const double root = middle * middle - (distance * distance - scene.radius * scene.radius);
      if (root <= 0) {
        picture.base.push_back(static_cast<float>(kBackground));
        continue;
      }
      const double t = middle - std::sqrt(root);
      const Vec3<double> position = eye + ray * t;
      const Vec3<double> normal = position / scene.radius;
      const Vec3<double> view = ray * -1.0;
      const double lit = std::max(dot(normal, kSun.vector), 0.0);
      picture.base.push_back(static_cast<float>(kGround * lit));
      // The pixel's solid angle is step^2 cos^3; over cos(gamma), times t^2, its footprint.
      const double solid_angle = step * step / (length_through * length_through * length_through);
      const double footprint = solid_angle * t * t / dot(normal, view);
      if (lit > 0) picture.points.push_back({position, normal, view, footprint, x, y});
    }
  }
  return picture;
}

}  // namespace trade
