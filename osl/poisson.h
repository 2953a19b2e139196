// SPDX-License-Identifier: Apache-2.0
//
// How many flakes sparkle: see core/poisson.h.
#pragma once

#include "elementary.h"

#define POISSON_CLOSED_FORM 32.0
#define MAX_MEAN_COUNT 1e36

float count_deviate(float mean, int slots, float deviate)
{
  if (!(mean > 0.0))
    return 0.0;
  if (slots > 0) {
    float q = mean / (float)slots;
    if (q >= 1.0)
      return (float)slots;
    float p = q > 0.5 ? 1.0 - q : q;
    float term = 1.0;
    float survival = 0.0;
    for (int k = 0; k < slots; ++k) {
      survival = survival * (1.0 - p) + p;
      term = term * (1.0 - p);
    }
    float odds = p / (1.0 - p);
    int n = 0;
    if (q > 0.5) {
      float cumulated = term;
      while (n < slots && deviate >= cumulated) {
        n = n + 1;
        term = term * ((float)(slots - n + 1) / (float)n * odds);
        cumulated = cumulated + term;
      }
      return (float)(slots - n);
    }
    while (n < slots && deviate < survival) {
      n = n + 1;
      term = term * ((float)(slots - n + 1) / (float)n * odds);
      survival = survival - term;
    }
    return (float)n;
  }
  if (mean < POISSON_CLOSED_FORM) {
    float turn = mean + 2.0 * sqrt(mean);
    float n = 0.0;
    float term = exponential(-mean);
    float survival = mean * mean_transmittance(mean);
    while (deviate < survival && n < turn) {
      n = n + 1.0;
      term = term * mean / n;
      survival = survival - term;
    }
    if (n < turn)
      return n;
    float last = n;
    float tail = term;
    float previous = 0.0;
    survival = 0.0;
    do {
      last = last + 1.0;
      tail = tail * mean / last;
      previous = survival;
      survival = survival + tail;
    } while (survival > previous);
    while (deviate < survival && n < last) {
      n = n + 1.0;
      term = term * mean / n;
      survival = survival - term;
    }
    return n;
  }
  float lambda = min(mean, MAX_MEAN_COUNT);
  float root = sqrt(lambda);
  float w = -normal_quantile(deviate);
  float shift = 1.0 / 3.0 + w * w / 6.0 - w * (1.0 / 36.0 + w * w / 72.0) / root;
  return max(floor(lambda + (root * w + shift)), 0.0);
}
