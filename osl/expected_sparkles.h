// SPDX-License-Identifier: Apache-2.0
//
// How many sparkles are expected, and what each of them shows: see core/expected_sparkles.h.
#pragma once

#include "flake_area.h"
#include "layer.h"
#include "optical_thickness.h"
#include "orientation.h"
#include "passage.h"
#include "poisson.h"

#define POISSON_SLOTS 16
#define LEAST_CONE 1e-18

struct ExpectedSparkles {
  float mean_count;
  int slots;
  float fill;
  AreaMoments area;
  color slant;
  float hidden;
  color transmitted;
  color reflectance;
  color mirror;
  float ceiling;
  float contrast;
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
ExpectedSparkles nothing_expected(Flakes flakes)
{
  ExpectedSparkles expected;
  expected.mean_count = 0.0;
  expected.slots = 0;
  expected.fill = 1.0;
  expected.area = flakes.area;
  expected.slant = color(0.0);
  expected.hidden = 0.0;
  expected.transmitted = color(1.0);
  expected.reflectance = color(0.0);
  expected.mirror = color(0.0);
  expected.ceiling = 0.0;
  expected.contrast = 1.0;
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
  for (int i = 0; i < layer.species; ++i)
    most = max(most, turned_by(flakes_of(layer, i), layer.eta));
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
  expected.contrast = layer.sparkle_contrast;
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
  expected.area = capped_area_moments(flakes.area_spread, expected.fill, flakes.area);
  float enlarged = 1.0;
  if (expected.area.mean < flakes.area.mean)
    enlarged = flakes.area.mean / expected.area.mean;
  expected.mean_count = flakes.areal_density * footprint * enlarged * probability;

  float places = expected.fill / flakes.area.mean;
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
  if (layer.radiometry == RADIOMETRY_PUBLISHED && expected.slots == 0 &&
      expected.mean_count < 0.1)
    expected.slots = 1;
  return expected;
}

// `flat`: whether any listed light is.
ExpectedSparkles expect_sparkles(Layer layer, Flakes flakes, float library[], float pixel_area, Passage way, int flat)
{
  float inside = way.open ? cone_in_binder(flakes, way) : 0.0;
  if (!(inside > 0.0))
    return nothing_expected(flakes);
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
  float share = expected.area.mean / expected.fill;
  return expected.transmitted * share;
}

color mean_square_sparkle(ExpectedSparkles expected)
{
  float share = expected.area.square / expected.fill / expected.fill;
  return share * mean_transmittance(2.0 * expected.slant - color(expected.hidden));
}

color mean_radiance(ExpectedSparkles expected)
{
  return expected.mirror * (mean_sparkle(expected) * expected.mean_count);
}

#define FAR_COUNT 65536.0

float fluctuation_left(ExpectedSparkles expected)
{
  if (!(expected.mean_count > FAR_COUNT / 2.0))
    return expected.contrast;
  color mean = mean_sparkle(expected);
  color square = mean_square_sparkle(expected);
  float least = expected.mean_count;
  for (int c = 0; c < 3; ++c) {
    if (square[c] > 0.0)
      least = min(least, expected.mean_count * (mean[c] * mean[c] / square[c]));
  }
  return expected.contrast * clamp(2.0 - least / (FAR_COUNT / 2.0), 0.0, 1.0);
}
