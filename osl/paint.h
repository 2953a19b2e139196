// SPDX-License-Identifier: Apache-2.0
//
// From a paint in real units to what the evaluation needs: see core/paint.h.
#pragma once

#include "layer.h"
#include "parameters.h"

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
  return flakes;
}
