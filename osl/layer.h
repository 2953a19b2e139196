// SPDX-License-Identifier: Apache-2.0
//
// The paint as the evaluation needs it: see core/layer.h.
#pragma once

#include "choices.h"
#include "coating.h"
#include "flake_area.h"
#include "optical_thickness.h"
#include "orientation.h"

struct Flakes {
  float areal_density;
  float flake_area;
  float area_spread;
  AreaMoments area;
  float coverage;
  OrientationDensity orientation;
  float solid_angle;
  Coating coating;
};

#define SPECIES 3

// The layer's flakes go beside it: Flakes flakes[SPECIES], and float library[] of their coatings.
struct Layer {
  int species;
  float coverage;
  float eta;
  color binder_depth;
  float rayleigh_depth;
  int depth_model;
  int radiometry;
  float sparkle_contrast;
};

color flake_blocking(Layer layer, Flakes flakes[SPECIES], float library[], float cos_in)
{
  color sum = color(0.0);
  for (int i = 0; i < layer.species; ++i) {
    Flakes some = flakes[i];  // a struct inside an element passes as that of the first one
    sum = sum + blocked_area(some.orientation, some.coating, library, cos_in) * some.coverage;
  }
  return sum;
}

color slant_depth_of(Layer layer, Flakes flakes[SPECIES], float library[], float cos_in)
{
  return slant_depth(flake_blocking(layer, flakes, library, cos_in), layer.binder_depth, cos_in);
}
