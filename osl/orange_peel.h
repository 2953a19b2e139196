// SPDX-License-Identifier: Apache-2.0
//
// Orange peel: the waves that spraying leaves in the binder's surface. Their slope is Perlin noise of wavelength `size`; they
// bend the highlight, and not what the flakes see, which they would turn by a third of their slope.
#pragma once

#include "refraction.h"

// Of each channel of noise("perlin"), measured over 1e6 points.
#define PERLIN_DEVIATION 0.26

// The normal tilted by a slope whose root mean square is `slope`; p and `size` in scene units.
vector orange_peel(vector n, point p, float slope, float size)
{
  vector waves = noise("perlin", p / size);
  vector across = waves - n * inner_product(n, waves);
  vector tilted = n + across * (slope / (1.41421356 * PERLIN_DEVIATION));
  return tilted / sqrt(inner_product(tilted, tilted));
}

// Where a point lies in its object, which the waves are fixed to: in world units, as far as the object is scaled evenly.
point object_point(point p, vector n)
{
  vector unit = transform("object", n);
  return transform("object", p) / max(sqrt(inner_product(unit, unit)), 1e-12);
}
