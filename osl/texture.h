// SPDX-License-Identifier: Apache-2.0
//
// Regular texture: the light scattered several times fluctuates from pixel to pixel. See core/texture.h.
#pragma once

#include "elementary.h"

float texture_deviation(float contrast, float footprint)
{
  return min(contrast * 0.001 / sqrt(max(footprint, 1e-20)), 1.0);
}

float texture_factor(float contrast, float footprint, float w)
{
  float deviation = texture_deviation(contrast, footprint);
  float square = logarithm(1.0 + deviation * deviation);
  return exponential(sqrt(square) * w - 0.5 * square);
}
