// SPDX-License-Identifier: Apache-2.0
//
// The lights that sparkle (paper, 5.3.5): parallel light, and spot and point lights. Intensity,
// colour, falloff, spot cone and shadows are the renderer's; the model needs where a light is and
// how large it looks.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "elementary.h"
#include "vector.h"

namespace metallic_paint {

enum class LightKind { unused = 0, parallel = 1, positional = 2 };

template <class T>
struct Light {
  LightKind kind = LightKind::unused;
  Vec3<T> vector;  // parallel: towards the light; positional: where its centre is (scene units)
  T size{};        // parallel: sine of the angular radius; positional: radius (scene units)
};

// A light as seen from a point. Its angular radius is kept as h = sin^2(Delta_a/2), which neither
// cancels for small lights nor saturates for large ones.
template <class T>
struct SeenLight {
  Vec3<T> direction;   // unit
  T sin2_half_radius;  // h
  bool visible = false;
};

// Two listed lights closer together than this (plus their radii) are one to the shader: Cycles'
// cone closure measures angles by an acos in float, which resolves 3.5e-4 rad, and each light keeps
// a margin of 1e-3.
inline constexpr double kLeastGap = 2e-3;

template <class T>
SeenLight<T> see_light(const Light<T>& light, Vec3<T> position) {
  SeenLight<T> seen;
  if (light.kind == LightKind::unused) return seen;
  Vec3<T> towards = light.vector;
  if (light.kind == LightKind::positional) towards = light.vector - position;
  const T distance = length(towards);
  if (!(distance > 0)) return seen;
  seen.visible = true;
  seen.direction = towards / distance;
  T sine = light.size;
  if (light.kind == LightKind::positional) sine = light.size / distance;
  sine = std::clamp(sine, T(0), T(1));
  // 1 - cos = sin^2/(1 + cos).
  seen.sin2_half_radius = T(0.5) * (sine * sine / (1 + std::sqrt((1 - sine) * (1 + sine))));
  return seen;
}

// Whether the discs of two lights, widened by the least gap, overlap: the chord between the
// directions against the chord of the sum of angles, sin(a + b) = sin a cos b + cos a sin b at half
// angles.
template <class T>
bool lights_overlap(const SeenLight<T>& a, const SeenLight<T>& b) {
  const Vec3<T> chord = a.direction - b.direction;
  const T sine = std::sqrt(a.sin2_half_radius) * std::sqrt(1 - b.sin2_half_radius) +
                 std::sqrt(b.sin2_half_radius) * std::sqrt(1 - a.sin2_half_radius);
  const T reach = 2 * sine + T(kLeastGap);
  return dot(chord, chord) < reach * reach;
}

}  // namespace metallic_paint
