// SPDX-License-Identifier: Apache-2.0
//
// How many flakes sparkle: see core/poisson.h.
#pragma once

#include "elementary.h"

#define COUNT_STEPS 6
#define MOST_INVERTED 2.0
#define MAX_MEAN_COUNT 1e36

struct Count {
  float number;
  float scale;
};

float logarithm_of_rest(float p)
{
  if (p < 0.03)
    return 1.0 + p * (0.5 + p * (1.0 / 3.0 + p * (0.25 + p * 0.2)));
  return -logarithm(1.0 - p) / p;
}

Count draw_count(float mean, int slots, float u)
{
  Count count;
  count.number = 0.0;
  count.scale = 1.0;
  if (!(mean > 0.0))
    return count;
  float places = (float)slots;
  int of_empty = slots > 0 && 2.0 * mean > places;
  float lambda = of_empty ? max(places - mean, 0.0) : min(mean, MAX_MEAN_COUNT);
  float v = of_empty ? 1.0 - u : u;
  float p = slots > 0 ? lambda / places : 0.0;
  float n = 0.0;
  float mean_of_n = lambda;
  if (lambda <= MOST_INVERTED || (slots > 0 && slots <= COUNT_STEPS)) {
    float y = lambda * logarithm_of_rest(p);
    float a = p / (1.0 - p);
    float b = (lambda + p) / (1.0 - p);
    float term = exponential(-y);
    float survival = y * mean_transmittance(y);
    mean_of_n = survival;
    if (!(v < survival || of_empty))
      return count;
    for (int k = 1; k <= COUNT_STEPS; ++k) {
      if (v < survival)
        n = (float)k;
      term = term * (b / (float)k - a);
      survival = survival - term;
      if (k < COUNT_STEPS)
        mean_of_n = mean_of_n + survival;
    }
  }
  else {
    float w = -normal_quantile(v);
    float c = (1.0 - 2.0 * p) / 6.0;
    float spread = sqrt(lambda * (1.0 - p) - 1.0 / 12.0);
    if (spread + 2.0 * c * w > 0.0)
      n = floor(lambda + 0.5 + (spread * w + c * (w * w - 1.0)));
  }
  if (slots > 0)
    n = min(n, places);
  count.number = max(of_empty ? places - n : n, 0.0);
  float mean_of_count = of_empty ? places - mean_of_n : mean_of_n;
  if (mean_of_count > 0.0)
    count.scale = (of_empty ? places - lambda : lambda) / mean_of_count;
  return count;
}
