// SPDX-License-Identifier: Apache-2.0
//
// The observer and the light, outside and as a flake in the binder sees them, and what a flake
// mirrors from the one to the other.
#pragma once

#include "explicit_flakes.h"
#include "population.h"
#include "random.h"

namespace metallic_paint::reference {

struct ViewAndLight {
  explicit ViewAndLight(const ExplicitScene& scene);

  double eta;
  Vec3<double> view, light;        // unit, outside
  Vec3<double> view_in, light_in;  // in the binder
  bool seen;                       // whether the observer sees into the binder
  double view_transmittance;       // of the surface
  double light_chord2;             // square of the chord of the light's radius
  double light_solid_angle;        // outside
  double least_cosine;             // of the light in the binder
  double most_cosine;
  int light_points;  // that a flake with a spread tries
};

struct LightMet {
  double received = 0;     // per unit irradiance normal to the light and sr, through the surface
  Vec3<double> towards{};  // the light in the binder
};

// What a flake without losses would show that mirrors the observer's ray into `mirrored`.
LightMet meet_light(const ViewAndLight& beams, const Population& flakes, Vec3<double> mirrored,
                    RandomStream& random);

}  // namespace metallic_paint::reference
