// SPDX-License-Identifier: Apache-2.0
//
// What light at each angle adds to the diffuse lobe: see core/diffuse_lobe.h.
#pragma once

#include "refraction.h"

#define RAMP_COLORS 8

float let_in(float cosine, float eta)
{
  return fresnel_transmittance(cosine, eta_cos_refracted(cosine, eta), eta);
}

// Written out: OSL folds no loop.
void make_ramp(float eta, output color ramp[RAMP_COLORS])
{
  float first = 1.0 / 7.0 * let_in(0.75 / 7.0, eta);
  float second = 2.0 / 7.0 * let_in(2.0 / 7.0, eta);
  float third = 3.0 / 7.0 * let_in(3.0 / 7.0, eta);
  float fourth = 4.0 / 7.0 * let_in(4.0 / 7.0, eta);
  float fifth = 5.0 / 7.0 * let_in(5.0 / 7.0, eta);
  float sixth = 6.0 / 7.0 * let_in(6.0 / 7.0, eta);
  float last = let_in(1.0, eta);
  float mean = 2.0 / 7.0 * (first + second + third + fourth + fifth + sixth) + last / 7.0;
  ramp[0] = color(0.0);
  ramp[1] = color(first / mean);
  ramp[2] = color(second / mean);
  ramp[3] = color(third / mean);
  ramp[4] = color(fourth / mean);
  ramp[5] = color(fifth / mean);
  ramp[6] = color(sixth / mean);
  ramp[7] = color(last / mean);
}
