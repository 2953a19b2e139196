// SPDX-License-Identifier: Apache-2.0
//
// The draw: how many sparkles a pixel happens to have, and what they add up to. See core/draw.h.
#pragma once

#include "elementary.h"
#include "expected_sparkles.h"
#include "poisson.h"
#include "random.h"

#define DRAWN_SPARKLES 16
#define COLOUR_DRAW (DRAWN_SPARKLES + 2)

struct Sparkles {
  float count;
  color radiance;
};

color draw_sparkle(ExpectedSparkles expected, float area_spread, HashWords words, float depth)
{
  float area = 1.0;
  if (area_spread > 0.0)
    area = max(1.0 + area_spread * normal_quantile(uniform_48(words.x, words.y)), 0.0);
  float share = min(area, expected.fill) / expected.fill;
  if (expected.hidden > 0.0 && uniform_23(words.w) > exponential(-expected.hidden * depth))
    share = 0.0;
  return share * exponential((color(expected.hidden) - expected.slant) * depth);
}

int drawn_one_by_one(ExpectedSparkles expected, float count)
{
  if (count <= (float)DRAWN_SPARKLES)
    return (int)count;
  float square = expected.area.square / (expected.area.mean * expected.area.mean);
  float y = max(max(expected.slant[0], expected.slant[1]), expected.slant[2]) / 2.0;
  float h = expected.hidden;
  float varied = (y + 1.0 / (1.0 + y)) * (1.0 + h / (2.0 + 4.0 * y - h));
  if (square * varied - 1.0 <= 0.1 * count)
    return 0;
  if (count <= (float)(2 * DRAWN_SPARKLES))
    return (int)count;
  return DRAWN_SPARKLES;
}

struct SumLaw {
  float mean;
  float spread;
  float c;
  float root;
};

SumLaw sum_law(float square, float cube, float x, float h, float count)
{
  SumLaw law;
  color passed = mean_transmittance(color(x, 2.0 * x - h, 3.0 * x - 2.0 * h));
  float m1 = passed[0];
  float m2 = square * passed[1];
  float m3 = cube * passed[2];
  law.mean = m1 * count;
  law.spread = 0.0;
  law.c = 0.0;
  law.root = 1.0;
  float variance = m2 - m1 * m1;
  if (!(variance > m2 * 1e-5))
    return law;
  law.spread = sqrt(variance * count);
  float skewness = (m3 - 3.0 * m2 * m1 + 2.0 * m1 * m1 * m1) / (variance * law.spread);
  law.c = clamp(skewness / 6.0, -0.25, 0.25);
  for (int i = 0; i < 2; ++i) {
    float q = 1.0 + 2.0 * law.c * law.c;
    law.c = clamp(skewness * q * sqrt(q) / (6.0 + 8.0 * law.c * law.c), -0.25, 0.25);
  }
  law.root = sqrt(1.0 + 2.0 * law.c * law.c);
  return law;
}

float correlation_of_deviates(SumLaw a, SumLaw b, float covariance)
{
  if (!(a.spread > 0.0 && b.spread > 0.0))
    return 0.0;
  float r = covariance / (a.spread * b.spread) * (a.root * b.root);
  float rho = 2.0 * r / (1.0 + sqrt(max(1.0 + 8.0 * a.c * b.c * r, 0.0)));
  return clamp(rho, 0.0, 1.0);
}

color sum_of_many(ExpectedSparkles expected, float count, float depth, HashWords words, HashWords more)
{
  float mean_area = expected.area.mean;
  float share = mean_area / expected.fill;
  float fewer = exponential(min(expected.hidden * depth, 20.0));
  float square = expected.area.square / (mean_area * mean_area) * fewer;
  float cube = expected.area.cube / (mean_area * mean_area * mean_area) * (fewer * fewer);
  float h = expected.hidden * (1.0 - depth);
  float chance[3] = {uniform_48(words.z, words.w), uniform_48(more.x, more.y), uniform_48(more.z, more.w)};
  SumLaw law[3];
  float x[3] = {0.0, 0.0, 0.0};
  float deviate[3] = {0.0, 0.0, 0.0};
  float factor[9] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};  // row by row
  int channels = channels_of(expected.slant);
  color sum = color(0.0);
  for (int i = 0; i < channels; ++i) {
    int same = i;
    for (int j = 0; j < i; ++j) {
      if (expected.slant[j] == expected.slant[i])
        same = j;
    }
    if (same < i) {
      law[i] = law[same];
      sum[i] = sum[same];
    }
    else {
      x[i] = expected.slant[i] * (1.0 - depth);
      SumLaw here = sum_law(square, cube, x[i], h, count);
      float own = 1.0;
      float w = 0.0;
      for (int j = 0; j < i; ++j) {
        SumLaw there = law[j];
        float covariance = square * mean_transmittance(x[i] + x[j] - h) * count - here.mean * (there.mean / count);
        float along = correlation_of_deviates(here, there, covariance);
        for (int k = 0; k < j; ++k)
          along = along - factor[3 * i + k] * factor[3 * j + k];
        float most = sqrt(own);
        if (factor[4 * j] > 0.0)
          along = clamp(along / factor[4 * j], -most, most);
        else
          along = 0.0;
        factor[3 * i + j] = along;
        own = max(own - along * along, 0.0);
        w = w + along * deviate[j];
      }
      factor[4 * i] = sqrt(own);
      deviate[i] = normal_quantile(chance[i]);
      w = w + factor[4 * i] * deviate[i];
      float drawn = here.mean + here.spread * (w + here.c * (w * w - 1.0)) / here.root;
      sum[i] = share * exponential(-expected.slant[i] * depth) * max(drawn, 0.0);
      law[i] = here;
    }
  }
  if (channels == 1)
    sum = color(sum[0]);
  return sum;
}

color sum_of_sparkles(ExpectedSparkles expected, float area_spread, HashWords key, int pixel_x,
                      int pixel_y, HashWords words, float count)
{
  int drawn = drawn_one_by_one(expected, count);
  float rest = count - (float)drawn;
  color sum = color(0.0);
  float depth = 0.0;
  float passed = 0.0;
  for (int i = 1; i <= drawn; ++i) {
    int number = i;
    if (i > DRAWN_SPARKLES)
      number = i + 2;
    HashWords own = draw_words(key, pixel_x, pixel_y, number);
    depth = uniform_23(own.z);
    if (rest > 0.0) {
      passed = passed - logarithm(depth) / (count - (float)(i - 1));
      depth = passed * mean_transmittance(passed);
    }
    sum = sum + draw_sparkle(expected, area_spread, own, depth);
  }
  if (rest > 0.0)
    sum = sum + sum_of_many(expected, rest, depth, words, draw_words(key, pixel_x, pixel_y, COLOUR_DRAW));
  return sum;
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
  color sum = sum_of_sparkles(expected, area_spread, key, pixel_x, pixel_y, words, count);
  if (left < 1.0) {
    color mean = mean_sparkle(expected) * expected.mean_count;
    sum = mean + (sum - mean) * left;
  }
  sparkles.radiance = min(max(expected.mirror * sum, color(0.0)), color(expected.ceiling));
  return sparkles;
}
