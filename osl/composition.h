// SPDX-License-Identifier: Apache-2.0
//
// How sparkles join the rest of the paint's light: see core/composition.h.
#pragma once

#include "choices.h"
#include "refraction.h"

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

float facet_reflectance(float cos_view, float roughness, float eta)
{
  float q = roughness * roughness * sqrt(roughness);
  float k = 0.55 * q / (1.0 + 0.56 * q);
  float square = cos_view * cos_view;
  float cosine = sqrt(square + k * (1.0 - 0.6 * square));
  return 1.0 - fresnel_transmittance(cosine, eta_cos_refracted(cosine, eta), eta);
}

float facet_albedo(float cos_view, float roughness)
{
  return 1.0 - roughness * roughness * (0.43 + 0.26 * cos_view);
}

struct Coat {
  float reflected;
  float rest;
};

Coat make_coat(float cos_view, float roughness, float eta)
{
  float passed = fresnel_transmittance(cos_view, eta_cos_refracted(cos_view, eta), eta);
  Coat coat;
  coat.reflected = 1.0 - passed;
  coat.rest = 1.0;
  if (roughness > 0.0 && passed > 0.0) {
    coat.reflected = facet_reflectance(cos_view, roughness, eta) * facet_albedo(cos_view, roughness);
    coat.rest = (1.0 - coat.reflected) / passed;
  }
  return coat;
}

float visible_facets(float square, float cosine)
{
  return 2.0 * cosine / (cosine + sqrt(square + (1.0 - square) * cosine * cosine));
}

#define LEAST_IMAGE 1.9e-5

float highlight(vector n, vector view, vector light, float sin2_half_radius, float alpha, float reflectance)
{
  float cos_view = inner_product(n, view);
  float cos_light = inner_product(n, light);
  if (!(cos_view > 0.0 && cos_light > 0.0))
    return 0.0;
  if (!(alpha > 0.0)) {
    vector off = n * (2.0 * cos_view) - view - light;
    float disc = max(sin2_half_radius, LEAST_IMAGE);
    float inside = disc - inner_product(off, off) / 4.0;
    float shown = clamp((inside + LEAST_IMAGE) / (2.0 * LEAST_IMAGE), 0.0, 1.0);
    return reflectance * shown / (4.0 * M_PI * disc);
  }
  vector sum = view + light;
  float cos_half = inner_product(n, sum) / sqrt(inner_product(sum, sum));
  float square = alpha * alpha;
  float spread = cos_half * cos_half * (square - 1.0) + 1.0;
  float shape = square / max(spread * spread, 1e-20);
  return reflectance * shape * visible_facets(square, cos_view) * visible_facets(square, cos_light) /
         (4.0 * M_PI * cos_view);
}
