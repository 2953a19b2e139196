// SPDX-License-Identifier: Apache-2.0
//
// How the layer dims light on its way: see core/optical_thickness.h.
#pragma once

#include "coating.h"
#include "orientation.h"
#include "refraction.h"

color mean_flake_transmittance(OrientationDensity density, Coating coating, float library[], float cos_theta)
{
  float sin_theta = sqrt(max(1.0 - cos_theta, 0.0) * (1.0 + cos_theta));
  color sum = color(0.0);
  float area = 0.0;
  for (int i = 0; i < 2; ++i) {
    float deviate = 0.211324865;
    if (i == 1)
      deviate = 0.788675135;
    SampledTilt tilt = sample_tilt(density, deviate);
    float h = tilt.sin2_half_beta;
    float a = cos_theta * (1.0 - 2.0 * h);
    float b = sin_theta * (1.41421356 * sqrt(h * (1.0 - h)));
    for (int side = 0; side < 2; ++side) {
      float across = b;
      if (side == 1)
        across = -b;
      float cosine = fabs(a + across);
      float weight = tilt.weight * cosine;
      sum = sum + coating_transmittance(coating, library, cosine) * weight;
      area = area + weight;
    }
  }
  return sum / area;
}

// `area`: the flakes' mean projected area in that direction.
color blocked_area(OrientationDensity density, Coating coating, float library[], float area, float cos_theta)
{
  color passed = color(0.0);
  if (coating.kind == COATING_COLORS)
    passed = coating.transmittance;
  else if (is_clear(coating.kind))
    passed = mean_flake_transmittance(density, coating, library, cos_theta);
  return (color(1.0) - passed) * area;
}

color slant_depth(color blocking, color binder_depth, float cos_theta)
{
  return (blocking + binder_depth) * (1.0 / max(cos_theta, LEAST_COSINE));
}
