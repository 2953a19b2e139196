// SPDX-License-Identifier: Apache-2.0
//
// The paint as the evaluation needs it: see core/layer.h.
#pragma once

#include "coating.h"
#include "flake_area.h"
#include "optical_thickness.h"
#include "orientation.h"
#include "parameters.h"
#include "refraction.h"

struct Flakes {
  float areal_density;
  float flake_area;
  float area_spread;
  AreaMoments area;
  float coverage;
  OrientationDensity orientation;
  float solid_angle;
  Coating coating;
  float diameter;
};

#define SPECIES 3

// The layer's flakes go beside it: Flakes flakes[SPECIES], and float library[] of their coatings.
struct Layer {
  int species;
  Flakes first;
  float coverage;
  float eta;
  color binder_depth;
  float rayleigh_depth;
  color shared_blocking;
  color hiding;
  color diameters;
  color thickness_in_flakes;
  color gap_in_flakes;
  float haze;
  int depth_model;
  int radiometry;
  float sparkle_contrast;
  int anchor;
  int instances;
  float cell_share;
};

float diffraction_spread(float diameter_um, float eta)
{
  return min(0.350140875 / (eta * diameter_um), 0.5);
}

Flakes make_flakes(FlakeSpecies species, float eta, int diffraction)
{
  Flakes flakes;
  flakes.areal_density = species.flakes_per_mm2 * 1e6;
  float diameter_um = species.flake_diameter_um;
  float diameter = diameter_um * 1e-6;
  flakes.flake_area = 0.785398163 * (diameter * diameter);
  flakes.area_spread = species.flake_area_spread;
  flakes.area = area_moments(flakes.area_spread);
  flakes.coverage = flakes.areal_density * flakes.flake_area * flakes.area.mean;
  flakes.orientation = make_orientation(species.orientation, species.tilt);
  if (flakes.orientation.back_cosine <= critical_cosine(eta))
    flakes.orientation.back_cosine = 0.0;
  float spread = species.flake_spread;
  float edge = 0.0;
  if (diffraction == DIFFRACTION_DISC)
    edge = diffraction_spread(diameter_um, eta);
  flakes.solid_angle = M_PI * (spread * spread + edge * edge);
  // Flakes give back no more than they get: core/paint.h rejects colours that do.
  color most = color(1.0) - species.flake_transmission;
  flakes.coating.normal_reflectance = min(species.flake_color, most);
  flakes.coating.grazing_reflectance = min(species.flake_edge_color, most);
  flakes.coating.transmittance = species.flake_transmission;
  flakes.coating.kind = species.coating;
  flakes.coating.thickness_nm = species.coating_nm;
  flakes.diameter = diameter;
  return flakes;
}

color usual_transmittance(Flakes some, float library[])
{
  return coating_transmittance(some.coating, library, 0.9);
}

color shared_blocking_of(Flakes some, float library[])
{
  color kept = color(1.0) - usual_transmittance(some, library);
  return kept * kept * (some.coverage * some.orientation.mean_cos);
}

float reach_below(Flakes some)
{
  float mean_cos = some.orientation.mean_cos;
  float sine = sqrt(max((1.0 - mean_cos) * (1.0 + mean_cos), 0.0));
  return some.diameter * min(1.25 * sine, 0.5);
}

// `present`: how many of the flakes are made.
Layer make_layer(Paint given, Flakes first, Flakes flakes[SPECIES], int present, float library[])
{
  Layer layer;
  layer.eta = given.binder_ior;
  layer.species = 1;
  layer.first = first;
  layer.coverage = first.coverage;
  layer.shared_blocking = shared_blocking_of(first, library);
  color covered = color(first.coverage, 0.0, 0.0);
  layer.diameters = color(first.diameter);
  float gap = 0.0;
  if (first.coverage > 0.0)
    gap = reach_below(first);
  if (present > 1) {
    for (int i = 1; i < present; ++i) {
      if (flakes[i].areal_density > 0.0)
        layer.species = i + 1;
      layer.coverage = layer.coverage + flakes[i].coverage;
      layer.shared_blocking = layer.shared_blocking + shared_blocking_of(flakes[i], library);
      if (flakes[i].coverage > 0.0)
        gap = max(gap, reach_below(flakes[i]));
    }
    covered = color(first.coverage, flakes[1].coverage, flakes[2].coverage);
    layer.diameters = color(first.diameter, flakes[1].diameter, flakes[2].diameter);
  }
  float rayleigh = 16.7551608 * given.rayleigh_per_mm;
  float thickness_mm = given.layer_thickness_um * 0.001;
  layer.binder_depth = (given.binder_absorption_per_mm + color(rayleigh)) * thickness_mm;
  layer.rayleigh_depth = rayleigh * thickness_mm;
  layer.hiding = color(0.0);
  if (layer.coverage > 0.0)
    layer.hiding = covered / layer.coverage;
  layer.thickness_in_flakes = color(thickness_mm * 0.001) / layer.diameters;
  layer.gap_in_flakes = color(gap) / layer.diameters;
  float alpha = given.coat_roughness * given.coat_roughness;
  layer.haze = 3.0 * M_PI * (alpha * alpha);
  layer.depth_model = given.depth_model;
  layer.radiometry = given.radiometry;
  layer.sparkle_contrast = given.sparkle_contrast;
  layer.anchor = given.anchor;
  layer.instances = given.instances;
  layer.cell_share = 1.0 / given.cells_per_pixel;
  return layer;
}

// The species by number. OSL folds no element of an array, but all that a single species decides.
Flakes flakes_of(Layer layer, Flakes flakes[SPECIES], int species)
{
  Flakes some = layer.first;
  if (layer.species > 1)
    some = flakes[species];
  return some;
}

// mean_projected_area of each species.
color projected_areas(Layer layer, Flakes flakes[SPECIES], float cos_in)
{
  color areas = color(0.0);
  for (int i = 0; i < layer.species; ++i) {
    Flakes some = flakes_of(layer, flakes, i);
    areas[i] = mean_projected_area(some.orientation, cos_in);
  }
  return areas;
}

color flake_blocking(Layer layer, Flakes flakes[SPECIES], float library[], color areas, float cos_in)
{
  color sum = color(0.0);
  for (int i = 0; i < layer.species; ++i) {
    Flakes some = flakes_of(layer, flakes, i);
    sum = sum + blocked_area(some.orientation, some.coating, library, areas[i], cos_in) * some.coverage;
  }
  return sum;
}

color slant_depth_of(Layer layer, Flakes flakes[SPECIES], float library[], color areas, float cos_in)
{
  return slant_depth(flake_blocking(layer, flakes, library, areas, cos_in), layer.binder_depth, cos_in);
}

color slant_depth_of(Layer layer, Flakes flakes[SPECIES], float library[], float cos_in)
{
  return slant_depth_of(layer, flakes, library, projected_areas(layer, flakes, cos_in), cos_in);
}
