// SPDX-License-Identifier: Apache-2.0
//
// How sparkles join the rest of the paint's light: see core/composition.h.
#pragma once

#include "refraction.h"

#define COMPOSITION_EXACT 0
#define COMPOSITION_PUBLISHED 1

float luminance_of(color c)
{
  return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

color greatest(color sparkles, color base)
{
  float bright = luminance_of(sparkles);
  float other = luminance_of(base);
  if (!(bright > other))
    return color(0.0);
  return sparkles * ((bright - other) / bright);
}

float visible_facets(float square, float cosine)
{
  return 2.0 * cosine / (cosine + sqrt(square + (1.0 - square) * cosine * cosine));
}

float highlight(vector n, vector view, vector light, float sin2_half_radius, float alpha, float reflectance)
{
  float cos_view = inner_product(n, view);
  float cos_light = inner_product(n, light);
  if (!(cos_view > 0.0 && cos_light > 0.0))
    return 0.0;
  if (!(alpha > 0.0)) {
    vector off = n * (2.0 * cos_view) - view - light;
    if (!(sin2_half_radius > 0.0) || inner_product(off, off) > 4.0 * sin2_half_radius)
      return 0.0;
    return reflectance / (4.0 * M_PI * sin2_half_radius);
  }
  vector sum = view + light;
  float cos_half = inner_product(n, sum) / sqrt(inner_product(sum, sum));
  float square = alpha * alpha;
  float spread = cos_half * cos_half * (square - 1.0) + 1.0;
  float shape = square / max(spread * spread, 1e-20);
  return reflectance * shape * visible_facets(square, cos_view) * visible_facets(square, cos_light) /
         (4.0 * M_PI * cos_view);
}
