// SPDX-License-Identifier: Apache-2.0
//
// Means of the area of a flake, in units of its deviate's mean: see core/flake_area.h.
#pragma once

#include "elementary.h"
#include "quadrature.h"

#define NORMAL_REACH 8.5

float area_mean(float spread)
{
  float mean = 1.0;
  if (spread * NORMAL_REACH > 1.0) {
    float density = normal_density(1.0 / spread);
    mean = normal_cdf(1.0 / spread, density) + spread * density;
  }
  return mean;
}

float area_square(float spread)
{
  float square = 1.0 + spread * spread;
  if (spread * NORMAL_REACH > 1.0) {
    float density = normal_density(1.0 / spread);
    float positive = normal_cdf(1.0 / spread, density);
    float edge = spread * density;
    float mean = positive + edge;
    square = (square * positive + edge) / (mean * mean);
  }
  return square;
}

float capped_area_mean(float spread, float cap, float whole)
{
  if (cap >= 1.0 + spread * NORMAL_REACH)
    return whole;
  if (spread * NORMAL_REACH <= 1.0 - cap)
    return cap;
  if (cap < spread) {
    float node[12];
    float weight[12];
    gauss_rule(node, weight);
    float mean = 0.0;
    for (int i = 0; i < GAUSS_POINTS; ++i)
      mean = mean + weight[i] * normal_cdf((1.0 - cap * node[i]) / spread);
    return cap * mean;
  }
  float d = (1.0 - cap) / spread;
  float density = normal_density(d);
  return whole - ((1.0 - cap) * normal_cdf(d, density) + spread * density);
}
