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
  float area_mean;
  float area_square;
  float coverage;
  OrientationDensity orientation;
  float solid_angle;
  Coating coating;
  float diameter;
};

#define SPECIES 3

// Whether the species differ in this.
struct Unlike {
  int area;
  int orientation;
  int back;
  int narrow;
  int coating;
  int transmittance;
};

// The library of their coatings, float library[], goes beside it.
struct Layer {
  int species;
  Flakes first;
  Flakes second;
  Flakes third;
  Unlike unlike;
  float coverage;
  float eta;
  color binder_depth;
  float rayleigh_depth;
  color shared_blocking;
  color blocking_again;
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
  flakes.area_mean = area_mean(flakes.area_spread);
  flakes.area_square = area_square(flakes.area_spread);
  flakes.coverage = flakes.areal_density * flakes.flake_area * flakes.area_mean;
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

color shared_blocking_of(Flakes some, color transmitted)
{
  color kept = color(1.0) - transmitted;
  return kept * kept * (some.coverage * some.orientation.mean_cos);
}

void add_blocking(output Layer layer, Flakes some, float library[])
{
  color transmitted = usual_transmittance(some, library);
  color blocking = shared_blocking_of(some, transmitted);
  layer.shared_blocking = layer.shared_blocking + blocking;
  layer.blocking_again = layer.blocking_again + blocking * transmitted * (color(2.0) + transmitted);
}

float reach_below(Flakes some)
{
  float mean_cos = some.orientation.mean_cos;
  float sine = sqrt(max((1.0 - mean_cos) * (1.0 + mean_cos), 0.0));
  float reach = some.diameter * min(1.25 * sine, 0.5);
  if (!(some.coverage > 0.0))
    reach = 0.0;
  return reach;
}

// A species that the layer lacks: it covers nothing.
Flakes no_such_flakes()
{
  Flakes none;
  none.areal_density = 0.0;
  none.flake_area = 1.0;
  none.area_spread = 0.0;
  none.area_mean = 1.0;
  none.area_square = 1.0;
  none.coverage = 0.0;
  none.orientation.kind = ORIENTATION_BECKMANN;
  none.orientation.tilt = 1.0;
  none.orientation.norm = 1.0;
  none.orientation.mean_cos = 1.0;
  none.orientation.below = 1.0;
  none.orientation.back_cosine = 0.0;
  none.orientation.narrow = 1;
  none.solid_angle = 0.0;
  none.coating.normal_reflectance = color(0.0);
  none.coating.grazing_reflectance = color(0.0);
  none.coating.transmittance = color(0.0);
  none.coating.kind = COATING_COLORS;
  none.coating.thickness_nm = 0.0;
  none.diameter = 1.0;
  return none;
}

int differs(int species, float first, float second, float third)
{
  return (species > 1 && second != first) || (species > 2 && third != first);
}

Unlike unlike_in(int species, Flakes a, Flakes b, Flakes c)
{
  Unlike unlike;
  unlike.area = differs(species, a.area_spread, b.area_spread, c.area_spread);
  unlike.orientation = differs(species, a.orientation.kind, b.orientation.kind, c.orientation.kind);
  unlike.back = differs(species, a.orientation.back_cosine, b.orientation.back_cosine, c.orientation.back_cosine);
  unlike.narrow = differs(species, a.orientation.narrow, b.orientation.narrow, c.orientation.narrow);
  unlike.coating = differs(species, a.coating.kind, b.coating.kind, c.coating.kind);
  color t = a.coating.transmittance;
  unlike.transmittance = (species > 1 && !(b.coating.transmittance == t)) ||
                         (species > 2 && !(c.coating.transmittance == t));
  return unlike;
}

// Each species by its name: OSL folds no loop, and no element of an array.
Layer make_layer(Paint given, Flakes first, Flakes second, Flakes third, float library[])
{
  Layer layer;
  layer.eta = given.binder_ior;
  layer.species = 1;
  if (second.areal_density > 0.0)
    layer.species = 2;
  if (third.areal_density > 0.0)
    layer.species = 3;
  layer.first = first;
  layer.second = second;
  layer.third = third;
  layer.unlike = unlike_in(layer.species, first, second, third);
  color covered = color(first.coverage, second.coverage, third.coverage);
  layer.coverage = covered[0] + covered[1] + covered[2];
  layer.shared_blocking = color(0.0);
  layer.blocking_again = color(0.0);
  add_blocking(layer, first, library);
  add_blocking(layer, second, library);
  add_blocking(layer, third, library);
  layer.diameters = color(first.diameter, second.diameter, third.diameter);
  float gap = max(max(reach_below(first), reach_below(second)), reach_below(third));
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

// Of these flakes what may tell them from the layer's first; what all species have alike stays a constant for OSL, and so
// which formula is theirs.
void become(output Flakes some, Flakes other, Unlike unlike)
{
  some.areal_density = other.areal_density;
  some.flake_area = other.flake_area;
  some.coverage = other.coverage;
  some.orientation.tilt = other.orientation.tilt;
  some.orientation.norm = other.orientation.norm;
  some.orientation.mean_cos = other.orientation.mean_cos;
  some.orientation.below = other.orientation.below;
  some.solid_angle = other.solid_angle;
  some.coating.normal_reflectance = other.coating.normal_reflectance;
  some.coating.grazing_reflectance = other.coating.grazing_reflectance;
  some.coating.thickness_nm = other.coating.thickness_nm;
  some.diameter = other.diameter;
  if (unlike.area) {
    some.area_spread = other.area_spread;
    some.area_mean = other.area_mean;
    some.area_square = other.area_square;
  }
  if (unlike.orientation)
    some.orientation.kind = other.orientation.kind;
  if (unlike.back)
    some.orientation.back_cosine = other.orientation.back_cosine;
  if (unlike.narrow)
    some.orientation.narrow = other.orientation.narrow;
  if (unlike.coating)
    some.coating.kind = other.coating.kind;
  if (unlike.transmittance)
    some.coating.transmittance = other.coating.transmittance;
}

// The species by number.
Flakes flakes_of(Layer layer, int species)
{
  Flakes some = layer.first;
  if (layer.species > 1) {
    if (species == 1)
      become(some, layer.second, layer.unlike);
    if (layer.species > 2) {
      if (species == 2)
        become(some, layer.third, layer.unlike);
    }
  }
  return some;
}

// `areas` becomes mean_projected_area of each species.
color slant_depth_of(Layer layer, float library[], float cos_in, output color areas)
{
  color blocking = color(0.0);
  areas = color(0.0);
  for (int i = 0; i < layer.species; ++i) {
    Flakes some = flakes_of(layer, i);
    float area = mean_projected_area(some.orientation, cos_in);
    areas[i] = area;
    blocking = blocking + blocked_area(some.orientation, some.coating, library, area, cos_in) * some.coverage;
  }
  return slant_depth(blocking, layer.binder_depth, cos_in);
}

color slant_depth_of(Layer layer, float library[], float cos_in)
{
  color areas;
  return slant_depth_of(layer, library, cos_in, areas);
}
