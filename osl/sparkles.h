// SPDX-License-Identifier: Apache-2.0
//
// The sparkles of one light in one pixel: see core/sparkles.h for the model and its derivation.
#pragma once

#include "coating.h"
#include "flake_area.h"
#include "light.h"
#include "optical_thickness.h"
#include "orientation.h"
#include "poisson.h"
#include "random.h"
#include "refraction.h"

#define DEPTH_ATTENUATED 0
#define DEPTH_THINNED 1
#define RADIOMETRY_EXACT 0
#define RADIOMETRY_PUBLISHED 1
#define POISSON_SLOTS 16
#define DRAWN_SPARKLES 16
#define LEAST_CONE 1e-18

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

struct SurfacePoint {
  point position;
  vector n;
  vector view;
  float footprint;
  color slant;  // optical depth of the layer towards the observer
  int pixel_x;
  int pixel_y;
};

struct ExpectedSparkles {
  float mean_count;
  int slots;
  float fill;
  AreaMoments area;
  color slant;
  color mirror;
  float ceiling;
  float contrast;
};

struct Sparkles {
  float count;
  color radiance;
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

color mean_transmittance(color x)
{
  return color(mean_transmittance(x[0]), mean_transmittance(x[1]), mean_transmittance(x[2]));
}

float flake_probability(Flakes flakes, int radiometry, float sin2_half_beta, float sin2_half_rho)
{
  if (radiometry == RADIOMETRY_EXACT)
    return cap_probability(flakes.orientation, sin2_half_beta, sin2_half_rho);
  return min(2.0 * orientation_density(flakes.orientation, sin2_half_beta) * sin2_half_rho, 1.0);
}

struct Passage {
  int open;
  Mirror mirror;
  float inside;
  float ratio;
  float surface_transmittance;
  float cos_exit;
  color slant;
};

Passage pass_between(Layer layer, Flakes flakes[SPECIES], float library[], SurfacePoint surface, SeenLight light)
{
  Passage way;
  way.open = 0;
  way.inside = 0.0;
  way.ratio = 1.0;
  way.surface_transmittance = 0.0;
  way.cos_exit = 1.0;
  way.slant = color(0.0);
  way.mirror.possible = 0;
  if (!light.visible || !(surface.footprint > 0.0))
    return way;
  float eta = layer.eta;
  way.mirror = mirror_between(surface.n, surface.view, light.direction, eta);
  way.open = way.mirror.possible;
  if (!way.open)
    return way;
  float cos_view_in = min(way.mirror.g_view / eta, 1.0);
  float cos_light_in = min(way.mirror.g_light / eta, 1.0);
  way.cos_exit = cos_view_in;
  if (layer.radiometry == RADIOMETRY_PUBLISHED)
    way.cos_exit = way.mirror.cos_view;

  float outside = 4.0 * M_PI * light.sin2_half_radius;
  if (layer.radiometry == RADIOMETRY_PUBLISHED)
    outside = M_PI * squared_angle(light.sin2_half_radius);
  way.ratio = solid_angle_ratio(way.mirror.cos_light, way.mirror.g_light, eta);
  way.inside = outside * way.ratio;
  way.slant = surface.slant + slant_depth_of(layer, flakes, library, cos_light_in);
  way.surface_transmittance = fresnel_transmittance(way.mirror.cos_view, way.mirror.g_view, eta) *
                              fresnel_transmittance(way.mirror.cos_light, way.mirror.g_light, eta);
  return way;
}

ExpectedSparkles expect_sparkles(Layer layer, Flakes flakes, float library[], float pixel_area, Passage way)
{
  ExpectedSparkles expected;
  expected.mean_count = 0.0;
  expected.slots = 0;
  expected.fill = 1.0;
  expected.area = flakes.area;
  expected.slant = color(0.0);
  expected.mirror = color(0.0);
  expected.ceiling = 0.0;
  expected.contrast = layer.sparkle_contrast;
  if (!way.open)
    return expected;
  float cos_alpha = way.mirror.cos_alpha;
  float inside = way.inside + flakes.solid_angle;
  if (!(inside > 0.0))
    return expected;
  inside = max(inside, LEAST_CONE * max(way.ratio, 1.0));

  float probability = flake_probability(flakes, layer.radiometry, way.mirror.sin2_half_beta,
                                        inside / (16.0 * M_PI * cos_alpha));

  expected.ceiling = way.surface_transmittance * way.ratio / inside;
  expected.mirror = coating_reflectance(flakes.coating, library, cos_alpha) * expected.ceiling;
  expected.slant = way.slant;

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
  if (layer.depth_model == DEPTH_THINNED || crowded) {
    color transmitted = mean_transmittance(expected.slant);
    float visible = max(max(transmitted[0], transmitted[1]), transmitted[2]);
    if (visible > 0.0)
      expected.mirror = expected.mirror * (transmitted / visible);
    expected.mean_count = expected.mean_count * visible;
    expected.slant = color(0.0);
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

color mean_sparkle(ExpectedSparkles expected)
{
  float share = expected.area.mean / expected.fill;
  return share * mean_transmittance(expected.slant);
}

color mean_square_sparkle(ExpectedSparkles expected)
{
  float share = expected.area.square / expected.fill / expected.fill;
  return share * mean_transmittance(2.0 * expected.slant);
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

float dimmed(float share, float x, float depth)
{
  if (x > 0.0)
    return share * exponential(-x * depth);
  return share;
}

color draw_sparkle(ExpectedSparkles expected, float area_spread, HashWords words)
{
  float area = 1.0;
  if (area_spread > 0.0)
    area = max(1.0 + area_spread * normal_quantile(uniform_48(words.x, words.y)), 0.0);
  float share = min(area, expected.fill) / expected.fill;
  float depth = uniform_23(words.z);
  return color(dimmed(share, expected.slant[0], depth), dimmed(share, expected.slant[1], depth),
               dimmed(share, expected.slant[2], depth));
}

float sum_of_many(ExpectedSparkles expected, float x, float count, float w)
{
  float mean_area = expected.area.mean;
  float share = mean_area / expected.fill;
  float m1 = mean_transmittance(x);
  float m2 = expected.area.square / (mean_area * mean_area) * mean_transmittance(2.0 * x);
  float m3 = expected.area.cube / (mean_area * mean_area * mean_area) * mean_transmittance(3.0 * x);
  float variance = m2 - m1 * m1;
  if (!(variance > m2 * 1e-5))
    return share * m1 * count;
  float spread = sqrt(variance * count);
  float skewness = (m3 - 3.0 * m2 * m1 + 2.0 * m1 * m1 * m1) / (variance * spread);
  float c = clamp(skewness / 6.0, -0.25, 0.25);
  for (int i = 0; i < 2; ++i) {
    float q = 1.0 + 2.0 * c * c;
    c = clamp(skewness * q * sqrt(q) / (6.0 + 8.0 * c * c), -0.25, 0.25);
  }
  return share * (m1 * count + spread * (w + c * (w * w - 1.0)) / sqrt(1.0 + 2.0 * c * c));
}

Sparkles draw_sparkles(ExpectedSparkles expected, float area_spread, HashWords key, int pixel_x,
                       int pixel_y)
{
  Sparkles sparkles;
  sparkles.count = 0.0;
  sparkles.radiance = color(0.0);
  if (!(expected.mean_count > 0.0))
    return sparkles;
  float left = fluctuation_left(expected);
  if (!(left > 0.0)) {
    sparkles.count = floor(expected.mean_count + 0.5);
    sparkles.radiance = min(max(mean_radiance(expected), color(0.0)), color(expected.ceiling));
    return sparkles;
  }
  HashWords words = draw_words(key, pixel_x, pixel_y, 0);
  float count = count_deviate(expected.mean_count, expected.slots, uniform_48(words.x, words.y));
  sparkles.count = count;

  color sum = color(0.0);
  if (count <= (float)DRAWN_SPARKLES) {
    int n = (int)count;
    for (int i = 1; i <= n; ++i)
      sum = sum + draw_sparkle(expected, area_spread, draw_words(key, pixel_x, pixel_y, i));
  }
  else {
    float w = normal_quantile(uniform_48(words.z, words.w));
    sum = color(sum_of_many(expected, expected.slant[0], count, w),
                sum_of_many(expected, expected.slant[1], count, w),
                sum_of_many(expected, expected.slant[2], count, w));
  }
  if (left < 1.0) {
    color mean = mean_sparkle(expected) * expected.mean_count;
    sum = mean + (sum - mean) * left;
  }
  sparkles.radiance = min(max(expected.mirror * sum, color(0.0)), color(expected.ceiling));
  return sparkles;
}

// Counts are those of the species `shown`, the rest of all.
struct PixelSparkles {
  float count;
  float mean_count;
  color radiance;
  color mean_radiance;
};

// `blurred`, or without contrast: the mean, and nothing is drawn. mean_radiance is found where it is asked for.
PixelSparkles sparkle(Layer layer, Flakes flakes[SPECIES], float library[], SurfacePoint surface, Passage way,
                      int light, int frame, int seed, int blurred, int asked_mean, int shown)
{
  PixelSparkles all;
  all.count = 0.0;
  all.mean_count = 0.0;
  all.radiance = color(0.0);
  all.mean_radiance = color(0.0);
  float ceiling = 0.0;
  int only_mean = blurred || !(layer.sparkle_contrast > 0.0);
  for (int i = 0; i < layer.species; ++i) {
    ExpectedSparkles expected = expect_sparkles(layer, flakes[i], library, surface.footprint, way);
    color mean = color(0.0);
    if (only_mean || asked_mean)
      mean = mean_radiance(expected);
    Sparkles drawn;
    drawn.count = floor(expected.mean_count + 0.5);
    drawn.radiance = min(mean, color(expected.ceiling));
    if (!only_mean)
      drawn = draw_sparkles(expected, flakes[i].area_spread, stream_key(light, i, frame, seed),
                            surface.pixel_x, surface.pixel_y);
    if (i == shown) {
      all.count = drawn.count;
      all.mean_count = expected.mean_count;
    }
    all.radiance = all.radiance + drawn.radiance;
    all.mean_radiance = all.mean_radiance + mean;
    ceiling = max(ceiling, expected.ceiling);
  }
  all.radiance = min(all.radiance, color(ceiling));
  return all;
}
