// SPDX-License-Identifier: Apache-2.0
//
// Moments of the area of a flake, in units of its deviate's mean: see core/flake_area.h.
#pragma once

#include "elementary.h"

#define NORMAL_REACH 8.5

struct AreaMoments {
  float mean;
  float square;
};

AreaMoments area_moments(float spread)
{
  AreaMoments moments;
  if (spread * NORMAL_REACH <= 1.0) {
    moments.mean = 1.0;
    moments.square = 1.0 + spread * spread;
    return moments;
  }
  float positive = normal_cdf(1.0 / spread);
  float edge = spread * normal_density(1.0 / spread);
  moments.mean = positive + edge;
  moments.square = (1.0 + spread * spread) * positive + edge;
  return moments;
}

AreaMoments capped_area_moments(float spread, float cap, AreaMoments whole)
{
  AreaMoments moments = whole;
  if (cap >= 1.0 + spread * NORMAL_REACH)
    return moments;
  if (spread * NORMAL_REACH <= 1.0 - cap) {
    moments.mean = cap;
    moments.square = cap * cap;
    return moments;
  }
  if (cap < 0.05) {
    float offset = 0.387298335 * cap;
    float p0 = normal_cdf((1.0 - (cap / 2.0 - offset)) / spread);
    float p1 = normal_cdf((1.0 - cap / 2.0) / spread);
    float p2 = normal_cdf((1.0 - (cap / 2.0 + offset)) / spread);
    moments.mean = cap * (5.0 * p0 + 8.0 * p1 + 5.0 * p2) / 18.0;
    moments.square = cap * (5.0 * p0 * (cap - 2.0 * offset) + 8.0 * p1 * cap +
                            5.0 * p2 * (cap + 2.0 * offset)) / 18.0;
    return moments;
  }
  float d = (1.0 - cap) / spread;
  float above = normal_cdf(d);
  float edge = spread * normal_density(d);
  moments.mean = whole.mean - ((1.0 - cap) * above + edge);
  moments.square = whole.square - ((1.0 + spread * spread - cap * cap) * above + (1.0 + cap) * edge);
  return moments;
}
