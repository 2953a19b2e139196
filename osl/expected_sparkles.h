// SPDX-License-Identifier: Apache-2.0
//
// How many sparkles are expected, and what each of them shows: see core/expected_sparkles.h.
#pragma once

#include "flake_area.h"
#include "layer.h"
#include "optical_thickness.h"
#include "orientation.h"
#include "passage.h"

#define POISSON_SLOTS 16
#define LEAST_CONE 1e-18

struct ExpectedSparkles {
  float mean_count;
  int slots;
  float fill;
  float area_spread;
  float area_mean;
  float area_square;
  color slant;
  float hidden;
  color transmitted;
  color reflectance;
  color mirror;
  float ceiling;
  float share;
  float probability;
};

float flake_probability(OrientationDensity density, int radiometry, float sin2_half_beta, float sin2_half_rho)
{
  float probability = 0.0;
  if (radiometry == RADIOMETRY_EXACT)
    probability = cap_probability(density, sin2_half_beta, sin2_half_rho);
  else
    probability = min(2.0 * orientation_density(density, sin2_half_beta) * sin2_half_rho, 1.0);
  return probability;
}

// No sparkle.
ExpectedSparkles nothing_expected()
{
  ExpectedSparkles expected;
  expected.mean_count = 0.0;
  expected.slots = 0;
  expected.fill = 1.0;
  expected.area_spread = 0.0;
  expected.area_mean = 1.0;
  expected.area_square = 1.0;
  expected.slant = color(0.0);
  expected.hidden = 0.0;
  expected.transmitted = color(1.0);
  expected.reflectance = color(0.0);
  expected.mirror = color(0.0);
  expected.ceiling = 0.0;
  expected.share = 1.0;
  expected.probability = 0.0;
  return expected;
}

float cone_in_binder(Flakes flakes, Passage way)
{
  float inside = way.inside + flakes.solid_angle;
  if (!(inside > 0.0))
    return 0.0;
  return max(inside, LEAST_CONE * max(way.ratio, 1.0));
}

float turned_by(Flakes flakes, float eta)
{
  return 2.0 * eta * flakes.orientation.tilt;
}

float turned_by(Layer layer)
{
  float most = 0.0;
  for (int i = 0; i < layer.species; ++i) {
    Flakes some = flakes_of(layer, i);
    if (some.coverage > 0.0)
      most = max(most, turned_by(some, layer.eta));
  }
  return most;
}

float quarter_cone(float inside, Passage way)
{
  return inside / (16.0 * M_PI * way.mirror.cos_alpha);
}

ExpectedSparkles expect_sparkles(Layer layer, Flakes flakes, float library[], float pixel_area, Passage way, float inside,
                                 float probability)
{
  float cos_alpha = way.mirror.cos_alpha;
  ExpectedSparkles expected;
  expected.area_spread = flakes.area_spread;
  expected.area_square = flakes.area_square;
  expected.probability = probability;
  expected.slots = 0;

  expected.ceiling = way.surface_transmittance * way.ratio / inside;
  expected.reflectance = coating_reflectance(flakes.coating, library, cos_alpha);
  expected.share = sparkling_share(way.breadth, way.apart, turned_by(flakes, layer.eta));
  expected.mirror = expected.reflectance * (expected.ceiling * expected.share);
  expected.slant = way.slant;
  expected.hidden = hidden_whole(layer, flakes, way.slant, way.ways);
  expected.transmitted = mean_transmittance(expected.slant);

  float footprint = clamp(pixel_area, 1e-20, 1e6);
  expected.fill = footprint * way.cos_exit / (flakes.flake_area * cos_alpha);
  expected.area_mean = capped_area_mean(flakes.area_spread, expected.fill, flakes.area_mean);
  float enlarged = 1.0;
  if (expected.area_mean < flakes.area_mean)
    enlarged = flakes.area_mean / expected.area_mean;
  expected.mean_count = flakes.areal_density * footprint * enlarged * probability;

  float places = expected.fill / flakes.area_mean;
  if (places < (float)POISSON_SLOTS)
    expected.slots = (int)max(places, 1.0);
  float slots = (float)expected.slots;
  int crowded = expected.slots > 0 && expected.mean_count > slots;
  if (layer.depth_model == DEPTH_MODEL_THINNED || crowded) {
    color transmitted = expected.transmitted;
    float visible = max(max(transmitted[0], transmitted[1]), transmitted[2]);
    if (visible > 0.0)
      expected.mirror = expected.mirror * (transmitted / visible);
    expected.mean_count = expected.mean_count * visible;
    expected.slant = color(0.0);
    expected.hidden = 0.0;
    expected.transmitted = color(1.0);
  }
  if (expected.slots > 0 && expected.mean_count > slots) {
    expected.mirror = expected.mirror * (expected.mean_count / slots);
    expected.mean_count = slots;
  }
  if (layer.radiometry == RADIOMETRY_PUBLISHED && expected.slots == 0 && expected.mean_count < 0.1)
    expected.slots = 1;
  return expected;
}

// `flat`: whether any listed light is.
ExpectedSparkles expect_sparkles(Layer layer, Flakes flakes, float library[], float pixel_area, Passage way, int flat)
{
  float inside = way.open ? cone_in_binder(flakes, way) : 0.0;
  if (!(inside > 0.0))
    return nothing_expected();
  float probability = flake_probability(flakes.orientation, layer.radiometry, way.mirror.sin2_half_beta,
                                        quarter_cone(inside, way));
  if (flat && way.outline.given) {
    float factor = outline_factor(flakes.orientation, way.outline, way.mirror.sin2_half_beta,
                                  quarter_cone(way.outline.inside, way));
    probability = min(probability * factor, 1.0);
  }
  return expect_sparkles(layer, flakes, library, pixel_area, way, inside, probability);
}

color mean_sparkle(ExpectedSparkles expected)
{
  return expected.transmitted * (expected.area_mean / expected.fill);
}

color mean_radiance(ExpectedSparkles expected)
{
  return expected.mirror * (mean_sparkle(expected) * expected.mean_count);
}
