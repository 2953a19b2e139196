// SPDX-License-Identifier: Apache-2.0
//
// The draw: how many sparkles of a species a pixel happens to have, and what they add up to. See core/draw.h.
#pragma once

#include "elementary.h"
#include "expected_sparkles.h"
#include "poisson.h"
#include "random.h"

#define DEVIATES_OF_SPECIES 3
#define RARE_COUNT 1e-6

struct Sparkles {
  float count;
  color radiance;
};

// By the deviates of that number.
color draw_sparkle(ExpectedSparkles expected, vector key, float number)
{
  float area = 1.0;
  if (expected.area_spread > 0.0)
    area = max(1.0 + expected.area_spread * normal_quantile(uniform_deviate(key[0], key[1], key[2], number)), 0.0);
  float share = min(area, expected.fill) / expected.fill;
  float depth = uniform_deviate(key[2], key[0], number, key[1]);
  if (expected.hidden > 0.0 && uniform_deviate(number, key[2], key[1], key[0]) > exponential(-expected.hidden * depth))
    share = 0.0;
  return share * exponential((color(expected.hidden) - expected.slant) * depth);
}

color sum_of_others(ExpectedSparkles expected, float others, vector key, float number)
{
  color mean = mean_sparkle(expected);
  color faded = mean_transmittance(2.0 * expected.slant - color(expected.hidden));
  color variance =
      max(expected.area_square * (faded / expected.transmitted / expected.transmitted) - color(1.0), color(0.0));
  if (others <= 1.0 + max(max(variance[0], variance[1]), variance[2]))
    return mean * others + (draw_sparkle(expected, key, number + 2.0) - mean) * sqrt(others);
  float w = -normal_quantile(uniform_deviate(number, key[2], key[1], key[0]));
  color r = variance / others;
  color root = max(color(1.0) - r / 9.0 + w * sqrt(r) / 3.0, color(0.0));
  return mean * (others * (root * root * root));
}

Sparkles draw_sparkles(ExpectedSparkles expected, vector key, float contrast, int first)
{
  Sparkles sparkles;
  sparkles.count = 0.0;
  sparkles.radiance = color(0.0);
  if (!(expected.mean_count > 0.0))
    return sparkles;
  if (!(contrast > 0.0)) {
    sparkles.count = floor(expected.mean_count + 0.5);
    sparkles.radiance = min(max(mean_radiance(expected), color(0.0)), color(expected.ceiling));
    return sparkles;
  }
  float number = (float)first;
  float chance = uniform_deviate(key[0], key[1], key[2], number);
  if (expected.mean_count < RARE_COUNT)
    chance = chance < 0.0009765625 ? uniform_deviate(key[2], key[0], number, key[1]) * 0.0009765625 : 1.0;
  Count count = draw_count(expected.mean_count, expected.slots, chance);
  if (!(count.number > 0.0) && contrast == 1.0)
    return sparkles;
  sparkles.count = count.number;
  color sum = color(0.0);
  if (count.number > 0.0)
    sum = draw_sparkle(expected, key, number + 1.0);
  if (count.number > 1.0)
    sum = sum + sum_of_others(expected, count.number - 1.0, key, number);
  sum = sum * count.scale;
  if (contrast < 1.0) {
    color mean = mean_sparkle(expected) * expected.mean_count;
    sum = mean + (sum - mean) * contrast;
  }
  sparkles.radiance = min(max(expected.mirror * sum, color(0.0)), color(expected.ceiling));
  return sparkles;
}
