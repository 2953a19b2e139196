// SPDX-License-Identifier: Apache-2.0
//
// The draw: how many sparkles a pixel happens to have, and what they add up to. See core/draw.h.
#pragma once

#include "elementary.h"
#include "expected_sparkles.h"
#include "poisson.h"
#include "random.h"

#define DRAWN_SPARKLES 16

struct Sparkles {
  float count;
  color radiance;
};

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
