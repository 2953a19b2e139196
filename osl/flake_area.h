// SPDX-License-Identifier: Apache-2.0
//
// Moments of the area of a flake, in units of its deviate's mean: see core/flake_area.h.
#pragma once

#include "elementary.h"
#include "quadrature.h"

#define NORMAL_REACH 8.5

struct AreaMoments {
  float mean;
  float square;
  float cube;
};

AreaMoments area_moments(float spread)
{
  AreaMoments moments;
  float variance = spread * spread;
  if (spread * NORMAL_REACH <= 1.0) {
    moments.mean = 1.0;
    moments.square = 1.0 + variance;
    moments.cube = 1.0 + 3.0 * variance;
  }
  else {
    float density = normal_density(1.0 / spread);
    float positive = normal_cdf(1.0 / spread, density);
    float edge = spread * density;
    moments.mean = positive + edge;
    moments.square = (1.0 + variance) * positive + edge;
    moments.cube = (1.0 + 3.0 * variance) * positive + (1.0 + 2.0 * variance) * edge;
  }
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
    moments.cube = cap * cap * cap;
    return moments;
  }
  if (cap < spread) {
    float node[12];
    float weight[12];
    gauss_rule(node, weight);
    float mean = 0.0;
    float square = 0.0;
    float cube = 0.0;
    for (int i = 0; i < GAUSS_POINTS; ++i) {
      float x = cap * node[i];
      float term = weight[i] * normal_cdf((1.0 - x) / spread);
      mean = mean + term;
      square = square + term * x;
      cube = cube + term * x * x;
    }
    moments.mean = cap * mean;
    moments.square = 2.0 * cap * square;
    moments.cube = 3.0 * cap * cube;
    return moments;
  }
  float d = (1.0 - cap) / spread;
  float density = normal_density(d);
  float above = normal_cdf(d, density);
  float edge = spread * density;
  moments.mean = whole.mean - ((1.0 - cap) * above + edge);
  float variance = spread * spread;
  float cap2 = cap * cap;
  moments.square = whole.square - ((1.0 + variance - cap2) * above + (1.0 + cap) * edge);
  moments.cube = whole.cube - ((1.0 + 3.0 * variance - cap2 * cap) * above +
                               (1.0 + cap + cap2 + 2.0 * variance) * edge);
  return moments;
}
