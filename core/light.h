// SPDX-License-Identifier: Apache-2.0
//
// The lights that sparkle (paper, 5.3.5): parallel light, spot and point lights; and ours, flat
// area lights and the sun of a sky. Intensity, colour, falloff, spot cone and shadows are the
// renderer's; the model needs where a light is and how large it looks.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "choices.h"
#include "elementary.h"
#include "vector.h"

namespace metallic_paint {

template <class T>
struct Light {
  LightKind kind = LightKind::unused;
  Vec3<T> vector;    // parallel, sky: towards the light; the others: its centre (scene units)
  T size{};          // parallel, sky: sine of the angular radius; positional: radius (scene units);
                     // area: radius of the disc of its area
  Vec3<T> facing{};  // area: its normal on the lit side, as long as its farthest point is off
};

// A light as seen from a point. Its angular radius is kept as h = sin^2(Delta_a/2), which neither
// cancels for small lights nor saturates for large ones.
template <class T>
struct SeenLight {
  Vec3<Wide<T>> direction;   // unit
  Wide<T> sin2_half_radius;  // h
  bool visible = false;
  T reach{};  // half-angle of the cone about the direction that holds all of it
  T widest =
      std::numbers::pi_v<T> / 2;  // that of the widest cone which holds no other listed light
  T breadth{};                    // sine of that half-angle of a light that melts into the mean
  T apart = 1;                    // 0: where another light is so near that it has melted
  Vec3<Wide<T>> facing{};         // unit normal of a flat light
  Wide<T> radius{};               // of the disc of its area, in distances; 0: no flat light
};

// Two listed lights closer together than this (plus their radii) are one to the shader: Cycles'
// cone closure measures angles by an acos in float, which resolves 3.5e-4 rad, and each light keeps
// a margin of 1e-3.
inline constexpr double kLeastGap = 2e-3;

// The glow about the sun of a sky is that sky's too. So it sparkles with it, in a cone of this
// half-angle, and the flakes show none of that cone besides. A renderer's own angles and a
// picture's pixels are narrower.
inline constexpr double kSkyReach = 0.02;

// Flakes mirror a light to the observer whose normals lie in a cone of a quarter of its half-angle
// squared; in the binder that is reach/(2 eta). Once this is as wide as the flakes' tilt, most
// flakes that could mirror the light do: no sparkle stands out, and the closed form of their mean
// errs by more than 6 % (sparkles.h). There an area light melts into the mean, which is then that
// of all other light (flake_lobe.h). Wider than kWidestSine it makes no sparkles.
inline constexpr double kWidestSine = 0.5;
// So it does near the cone of another listed light, which could not tell its light apart.
inline constexpr double kMeltingGap = 0.05;

// What the sparkles show of the light, in [0, 1]; all other light has the rest. turned: 2 eta tilt.
template <class T>
T sparkling_share(T breadth, T apart, T turned) {
  const T width = breadth / min(turned, T(0.8 * kWidestSine));
  return apart * clamp(T(2.5) - 2 * width, T(0), T(1));
}

// sin^2 of the angular radius of the disc that fills the solid angle of a small flat light, whose
// disc of the same area has the radius t, in distances, and is seen from c = cos to its normal.
// Solid angles are harmonic functions: that of a disc is
//   pi t^2 (P_1(c) - 3/4 t^2 P_3(c) + ...) = pi c t^2 (1 - 3/8 t^2 (5 c^2 - 3) + ...),
// and that of a cone of s = sin^2 is pi s (1 + s/4 + ...). A square's differs by 5 % of the second
// term.
template <class T>
T sin2_of_flat_light(T t2, T c) {
  return c * t2 / (1 + t2 * (T(0.25) * c + T(0.125) * (15 * c * c - 9)));
}

template <class T>
T sin2_half_of(T sine) {
  // 1 - cos = sin^2/(1 + cos).
  return T(0.5) * (sine * sine / (1 + sqrt((1 - sine) * (1 + sine))));
}

// Angles by their half chord: exact for small and large ones alike.
template <class T>
T angle_of_half_chord(T half_chord) {
  return std::numbers::pi_v<T> - 2 * arccosine(half_chord);
}

template <class T>
SeenLight<T> see_light(const Light<T>& light, Vec3<T> position) {
  using W = Wide<T>;
  SeenLight<T> seen;
  if (light.kind == LightKind::unused) return seen;
  Vec3<W> towards(light.vector);
  if (light.kind == LightKind::positional || light.kind == LightKind::area) {
    towards = towards - Vec3<W>(position);
  }
  const W distance = length(towards);
  if (!(distance > 0)) return seen;
  seen.direction = towards / distance;
  W sine = light.size;
  if (light.kind == LightKind::positional) sine = light.size / distance;
  sine = clamp(sine, W(0), W(1));
  W reach = sine;
  if (light.kind == LightKind::sky) reach = max(sine, W(kSkyReach));
  if (light.kind == LightKind::area) {
    const Vec3<W> facing(light.facing);
    const W extent = length(facing);
    if (!(extent > 0)) return seen;
    const W cosine = -dot(facing, seen.direction) / extent;
    reach = max(extent, W(light.size)) / distance;
    if (!(cosine > 0) || !(reach < W(kWidestSine))) return seen;
    const W radius = light.size / distance;
    sine = sqrt(sin2_of_flat_light(radius * radius, min(cosine, W(1))));
    seen.breadth = static_cast<T>(reach);
    seen.facing = facing / extent;
    seen.radius = radius;
  }
  seen.visible = true;
  seen.sin2_half_radius = sin2_half_of(sine);
  seen.reach = angle_of_half_chord(static_cast<T>(sqrt(sin2_half_of(reach))));
  return seen;
}

template <class T>
T angle_between(const SeenLight<T>& a, const SeenLight<T>& b) {
  return angle_of_half_chord(
      static_cast<T>(min(Wide<T>(0.5) * length(a.direction - b.direction), Wide<T>(1))));
}

inline constexpr int kLightSlots = 8;

// Of lights so near that no two cones tell them apart the first one's cone, and so its sparkles,
// serves all: leader[i] is its index. On entry leader[i] is i, or below 0 where a light takes no
// part. Area lights share no cone: they melt beside other lights, and one of which nothing sparkles
// in the flakes turned widest (`turned`: the largest 2 eta tilt) takes no part. Every cone ends at
// half the gap to the nearest other light.
template <class T>
void share_cones(SeenLight<T>* seen, int* leader, int count, T turned) {
  for (int i = 1; i < count; ++i) {
    for (int k = 0; k < i; ++k) {
      if (leader[i] != i || leader[k] != k || seen[i].breadth > 0 || seen[k].breadth > 0) continue;
      const T angle = angle_between(seen[i], seen[k]);
      if (angle - seen[i].reach >= seen[k].reach + T(kLeastGap)) continue;
      leader[i] = k;
      seen[k].reach = max(seen[k].reach, angle + seen[i].reach);
    }
  }
  for (int i = 0; i < count; ++i) {
    if (leader[i] != i) continue;
    T gap = std::numbers::pi_v<T>;
    for (int k = 0; k < count; ++k) {
      if (k == i || leader[k] < 0 || leader[k] == i) continue;
      gap = min(gap, angle_between(seen[i], seen[k]) - seen[k].reach - seen[i].reach);
    }
    seen[i].widest = seen[i].reach + max(gap, T(0)) / 2;
    if (seen[i].breadth > 0) {
      seen[i].apart = clamp((gap - T(kLeastGap)) / T(kMeltingGap), T(0), T(1));
    }
  }
  for (int i = 0; i < count; ++i) {
    if (seen[i].breadth > 0 && !(sparkling_share(seen[i].breadth, seen[i].apart, turned) > 0)) {
      leader[i] = -1;
    }
  }
}

}  // namespace metallic_paint
