// SPDX-License-Identifier: Apache-2.0
//
// What the lobe of phong_ramp reflects: see core/phong_lobe.h.
#pragma once

#include "elementary.h"

float phong_albedo(float cos_view, float exponent)
{
  float at_grazing = sqrt(1.0 / (M_PI * (2.0 * exponent + 1.0 + 0.2732 / (1.0 + exponent))));
  float y = cos_view / at_grazing;
  return cos_view + at_grazing * exponential(-y * (0.5 + 0.055 * y)) * (1.0 - cos_view * cos_view * cos_view);
}
