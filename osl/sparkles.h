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

struct Layer {
  float areal_density;
  float flake_area;
  float area_spread;
  AreaMoments area;
  float coverage;
  OrientationDensity orientation;
  float flake_solid_angle;
  Coating coating;
  float eta;
  color binder_depth;
  int depth_model;
  int radiometry;
};

struct SurfacePoint {
  point position;
  vector n;
  vector view;
  float footprint;
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
};

struct Sparkles {
  float count;
  color radiance;
};

color slant_depth_of(Layer layer, float cos_in)
{
  return slant_depth(layer.coverage, blocked_area(layer.orientation, layer.coating, cos_in),
                     layer.binder_depth, cos_in);
}

color mean_transmittance(color x)
{
  return color(mean_transmittance(x[0]), mean_transmittance(x[1]), mean_transmittance(x[2]));
}

float flake_probability(Layer layer, float sin2_half_beta, float sin2_half_rho)
{
  if (layer.radiometry == RADIOMETRY_EXACT)
    return cap_probability(layer.orientation, sin2_half_beta, sin2_half_rho);
  return min(2.0 * orientation_density(layer.orientation, sin2_half_beta) * sin2_half_rho, 1.0);
}

ExpectedSparkles expect_sparkles(Layer layer, SurfacePoint surface, SeenLight light)
{
  ExpectedSparkles expected;
  expected.mean_count = 0.0;
  expected.slots = 0;
  expected.fill = 1.0;
  expected.area = layer.area;
  expected.slant = color(0.0);
  expected.mirror = color(0.0);
  expected.ceiling = 0.0;
  if (!light.visible || !(surface.footprint > 0.0))
    return expected;
  float eta = layer.eta;
  Mirror mirror = mirror_between(surface.n, surface.view, light.direction, eta);
  if (!mirror.possible)
    return expected;
  float cos_view_in = min(mirror.g_view / eta, 1.0);
  float cos_light_in = min(mirror.g_light / eta, 1.0);
  float cos_alpha = mirror.cos_alpha;

  float outside = 4.0 * M_PI * light.sin2_half_radius;
  if (layer.radiometry == RADIOMETRY_PUBLISHED)
    outside = M_PI * squared_angle(light.sin2_half_radius);
  float ratio = solid_angle_ratio(mirror.cos_light, mirror.g_light, eta);
  float inside = outside * ratio + layer.flake_solid_angle;
  if (!(inside > 0.0))
    return expected;
  inside = max(inside, LEAST_CONE * max(ratio, 1.0));

  float probability =
      flake_probability(layer, mirror.sin2_half_beta, inside / (16.0 * M_PI * cos_alpha));

  expected.slant = slant_depth_of(layer, cos_view_in) + slant_depth_of(layer, cos_light_in);
  float surface_transmittance = fresnel_transmittance(mirror.cos_view, mirror.g_view, eta) *
                                fresnel_transmittance(mirror.cos_light, mirror.g_light, eta);
  expected.ceiling = surface_transmittance * ratio / inside;
  expected.mirror = coating_reflectance(layer.coating, cos_alpha) * expected.ceiling;

  float cos_exit = cos_view_in;
  if (layer.radiometry == RADIOMETRY_PUBLISHED)
    cos_exit = mirror.cos_view;
  float footprint = clamp(surface.footprint, 1e-20, 1e6);
  expected.fill = footprint * cos_exit / (layer.flake_area * cos_alpha);
  expected.area = capped_area_moments(layer.area_spread, expected.fill, layer.area);
  float enlarged = 1.0;
  if (expected.area.mean < layer.area.mean)
    enlarged = layer.area.mean / expected.area.mean;
  expected.mean_count = layer.areal_density * footprint * enlarged * probability;

  float places = expected.fill / layer.area.mean;
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
  HashWords words = draw_words(key, pixel_x, pixel_y, 0);
  float count = count_deviate(expected.mean_count, expected.slots, uniform_48(words.x, words.y));
  if (count <= 0.0)
    return sparkles;
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
  sparkles.radiance = min(max(expected.mirror * sum, color(0.0)), color(expected.ceiling));
  return sparkles;
}
