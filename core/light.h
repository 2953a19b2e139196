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
  Vec3<Wide<T>> direction;   // unit
  Wide<T> sin2_half_radius;  // h
  bool visible = false;
};

// Two listed lights closer together than this (plus their radii) are one to the shader: Cycles'
// cone closure measures angles by an acos in float, which resolves 3.5e-4 rad, and each light keeps
// a margin of 1e-3.
inline constexpr double kLeastGap = 2e-3;

template <class T>
SeenLight<T> see_light(const Light<T>& light, Vec3<T> position) {
  using W = Wide<T>;
  SeenLight<T> seen;
  if (light.kind == LightKind::unused) return seen;
  Vec3<W> towards(light.vector);
  if (light.kind == LightKind::positional) towards = towards - Vec3<W>(position);
  const W distance = length(towards);
  if (!(distance > 0)) return seen;
  seen.visible = true;
  seen.direction = towards / distance;
  W sine = light.size;
  if (light.kind == LightKind::positional) sine = light.size / distance;
  sine = clamp(sine, W(0), W(1));
  // 1 - cos = sin^2/(1 + cos).
  seen.sin2_half_radius = W(0.5) * (sine * sine / (1 + sqrt((1 - sine) * (1 + sine))));
  return seen;
}

// Angles by their half chord: exact for small and large ones alike.
template <class T>
T angular_radius(const SeenLight<T>& light) {
  return std::numbers::pi_v<T> - 2 * arccosine(static_cast<T>(sqrt(light.sin2_half_radius)));
}
template <class T>
T angle_between(const SeenLight<T>& a, const SeenLight<T>& b) {
  const T half_chord =
      static_cast<T>(min(Wide<T>(0.5) * length(a.direction - b.direction), Wide<T>(1)));
  return std::numbers::pi_v<T> - 2 * arccosine(half_chord);
}

inline constexpr int kLightSlots = 8;

// Half-angle of the cone about the leader that holds all lights of its group.
template <class T>
T group_reach(const SeenLight<T>* seen, const int* leader, int count, int group) {
  T reach = angular_radius(seen[group]);
  for (int i = 0; i < count; ++i) {
    if (leader[i] != group || i == group) continue;
    reach = max(reach, angle_between(seen[group], seen[i]) + angular_radius(seen[i]));
  }
  return reach;
}

// Lights that no two cones can tell apart share the cone, and so the sparkles, of the first of
// them, the leader. Groups are joined until no group's cone comes within the least gap of another
// group's light. leader[i] is the index of light i's leader; -1 on entry marks a light that is not
// there.
template <class T>
void group_lights(const SeenLight<T>* seen, int* leader, int count) {
  bool joined = true;
  while (joined) {  // each pass but the last joins two groups: at most `count` passes
    joined = false;
    for (int group = 0; group < count && !joined; ++group) {
      if (leader[group] != group) continue;
      const T reach = group_reach(seen, leader, count, group) + T(kLeastGap);
      for (int i = 0; i < count && !joined; ++i) {
        if (leader[i] < 0 || leader[i] == group) continue;
        if (angle_between(seen[group], seen[i]) - angular_radius(seen[i]) >= reach) continue;
        const int first = min(group, leader[i]);
        const int second = max(group, leader[i]);
        for (int k = 0; k < count; ++k) {
          if (leader[k] == second) leader[k] = first;
        }
        joined = true;
      }
    }
  }
}

}  // namespace metallic_paint
