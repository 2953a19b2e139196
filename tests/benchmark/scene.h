// SPDX-License-Identifier: Apache-2.0
//
// A painted ball under one light before a pinhole camera, pixel by pixel, without a renderer.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "paint.h"

namespace trade {

using namespace metallic_paint;

inline const Light<double> kSun{LightKind::parallel, {0.36, 0.48, 0.8}, 0.00465};

struct Scene {
  std::string name;
  double pixel;  // its side on the ball where that is level, m
  Paint paint;
  Light<double> light = kSun;
};

// From near to far: from rare bright points over texture to the mean. Flakes that lie flatter than
// the default's are what tables see least of; those less flat show their backs. The lamp is as wide
// as the tilt: the quarter cone of normals that mirror it has a third of the tilt for its radius.
inline std::vector<Scene> scenes() {
  // Without diffraction: docs/accuracy tells of flakes that spread light by their waves alone.
  Paint plain;
  plain.diffraction = Diffraction::none;
  Paint narrow = plain;
  narrow.tilt = 0.05;
  Paint wide = plain;
  wide.tilt = 0.5;  // above kNarrowBack
  Paint flat = plain;
  flat.tilt = 0.06;
  const Light<double> lamp{LightKind::parallel, kSun.vector, std::sin(0.06)};
  return {{"near", 2.5e-3, plain},   {"middle", 12e-3, plain}, {"far", 0.1, plain},
          {"narrow", 12e-3, narrow}, {"wide", 12e-3, wide},    {"lamp", 1e-3, flat, lamp}};
}

struct Picture {
  int size;
  std::vector<SurfacePoint<double>> points;  // of the pixels that see the lit side
  std::vector<float> base;                   // of every pixel: the rest of the picture, grey
};

// Radiance of the ball's dull ground and of the background, the light on white being 1.
inline constexpr double kGround = 0.04, kBackground = 0.15;

inline Picture look(const Scene& scene, int size) {
  Picture picture{size, {}, {}};
  // The ball of radius 1/4 of the distance and a rim fill the picture.
  const double half = 1.06 / std::sqrt(15.0), step = 2 * half / size;
  const double radius = scene.pixel / (3 * step), distance = 4 * radius;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const Vec3<double> through{-half + (x + 0.5) * step, half - (y + 0.5) * step, -1};
      const double length_through = length(through);
      const Vec3<double> ray = through / length_through;
      const Vec3<double> eye{0, 0, distance};
      // |eye + t ray| = radius
      const double middle = -dot(eye, ray);
      const double root = middle * middle - (distance * distance - radius * radius);
      if (root <= 0) {
        picture.base.push_back(static_cast<float>(kBackground));
        continue;
      }
      const double t = middle - std::sqrt(root);
      const Vec3<double> position = eye + ray * t;
      const Vec3<double> normal = position / radius;
      const Vec3<double> view = ray * -1.0;
      const double lit = std::max(dot(normal, scene.light.vector), 0.0);
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
