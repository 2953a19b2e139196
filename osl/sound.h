// SPDX-License-Identifier: Apache-2.0
//
// Inputs made sound: core/paint.h rejects what is out of range, a render must go on.
#pragma once

#include "elementary.h"

#define GREATEST 3.40282347e38

// An input within its range; what is no number becomes the default. OSL folds comparisons, but not isfinite(). A comparison
// with NaN is false where it is folded and true where it is computed.
float sound(float x, float least, float most, float usual)
{
  float y = clamp(x, least, most);
  if (!(fabs(x) <= GREATEST) || fabs(x) > GREATEST)
    y = usual;
  return y;
}

color sound(color x, float least, float most, color usual)
{
  return color(sound(x[0], least, most, usual[0]), sound(x[1], least, most, usual[1]), sound(x[2], least, most, usual[2]));
}

// A linked normal, as every normal map gives it; another length becomes one, and what has no direction the usual.
vector sound_normal(vector given, vector usual)
{
  vector unit = given;
  float square = inner_product(given, given);
  if (square < 0.9999 || square > 1.0001) {  // NaN: see sound()
    float size = fabs(given[0]) + fabs(given[1]) + fabs(given[2]);
    unit = usual;
    if (!(size < 1e-30 || size > GREATEST))
      unit = normalize(given / size);
  }
  return unit;
}
