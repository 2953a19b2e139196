// SPDX-License-Identifier: Apache-2.0
//
// What flakes mirror of light that does not sparkle, as far as a lobe of microfacets shows it: see core/smooth_part.h.
#pragma once

#include "hot_spot.h"
#include "layer.h"
#include "passage.h"

#define FITTED 0.8
#define HELD 1.63
#define NARROWER 1.08
#define NARROWER_ACROSS 1.01
#define BELOW 0.985
#define LEAST_SMOOTH 0.2

struct SmoothPart {
  vector facing;  // the facets' normal
  vector along;
  float alpha_x;
  float alpha_y;
  color weight;
};

float masking_lambda(float square)
{
  if (square < 0.39)
    return 0.0;
  float a = 1.0 / sqrt(square);
  return ((0.396 * a - 1.259) * a + 1.0) / ((2.181 * a + 3.535) * a);
}

float facets_show(SmoothPart part, vector view, vector light)
{
  vector across = cross(part.facing, part.along);
  float view_z = inner_product(view, part.facing);
  float light_z = inner_product(light, part.facing);
  if (!(view_z > 0.0 && light_z > 0.0))
    return 0.0;
  float view_x = inner_product(view, part.along) * part.alpha_x;
  float view_y = inner_product(view, across) * part.alpha_y;
  float light_x = inner_product(light, part.along) * part.alpha_x;
  float light_y = inner_product(light, across) * part.alpha_y;
  float area = part.alpha_x * part.alpha_y;
  float half_z = view_z + light_z;
  float x = (view_x + light_x) / (part.alpha_x * part.alpha_x * half_z);
  float y = (view_y + light_y) / (part.alpha_y * part.alpha_y * half_z);
  vector half = view + light;
  float cos2 = half_z * half_z / inner_product(half, half);
  float masked = 1.0 + masking_lambda((view_x * view_x + view_y * view_y) / (view_z * view_z)) +
                 masking_lambda((light_x * light_x + light_y * light_y) / (light_z * light_z));
  return exponential(-(x * x + y * y)) / (M_PI * area * cos2 * cos2 * masked * 4.0 * view_z);
}

float flakes_show(Layer layer, OrientationDensity orientation, vector n, vector view, vector light, float slant_view,
                  float depth)
{
  Mirror mirror = mirror_between(n, view, light, layer.eta);
  if (!mirror.possible)
    return 0.0;
  float apart = ways_apart(n, view, mirror.cos_view, mirror.g_view, light, mirror.cos_light, mirror.g_light);
  color slant = there_and_back(layer, color(slant_view), color(depth * layer.eta / mirror.g_light), apart);
  return orientation_density(orientation, mirror.sin2_half_beta) * mean_transmittance(slant[0]) *
         fresnel_transmittance(mirror.cos_light, mirror.g_light, layer.eta) * mirror.cos_light / mirror.g_light;
}

float flakes_over_facets(Layer layer, OrientationDensity orientation, vector n, vector view, float slant_view, float depth,
                         SmoothPart part, float x, float y)
{
  vector across = cross(part.facing, part.along);
  vector half = part.facing + part.along * (x * part.alpha_x) + across * (y * part.alpha_y);
  vector light = half * (2.0 * inner_product(half, view) / inner_product(half, half)) - view;
  float facets = facets_show(part, view, light);
  if (!(facets > 0.0))
    return 0.0;
  return flakes_show(layer, orientation, n, view, light, slant_view, depth) / facets;
}

SmoothPart facets_at(vector n, vector towards, float slope, float x2, float y2)
{
  float cosine = 1.0 / sqrt(1.0 + slope * slope);
  SmoothPart part;
  part.facing = (n + towards * slope) * cosine;
  part.along = (towards - n * slope) * cosine;
  part.alpha_x = clamp(sqrt(x2), 1e-3, 1.0);
  part.alpha_y = clamp(sqrt(y2), 1e-3, 1.0);
  part.weight = color(0.0);
  return part;
}

SmoothPart smooth_part(Layer layer, Flakes flakes[SPECIES], float library[], SurfacePoint surface, int species)
{
  vector n = surface.n;
  vector view = surface.view;
  Flakes some = flakes_of(layer, flakes, species);
  OrientationDensity orientation = some.orientation;
  SmoothPart none = facets_at(n, vector(0.0), 0.0, 0.0, 0.0);
  float cos_view = min(inner_product(n, view), 1.0);
  if (!(cos_view > LEAST_SMOOTH) || !(some.coverage > 0.0))
    return none;
  float g_view = eta_cos_refracted(cos_view, layer.eta);

  vector towards = vector(0.0, 1.0, 0.0);
  if (fabs(n[0]) < 0.6)
    towards = vector(1.0, 0.0, 0.0);
  if (cos_view < 0.999999)
    towards = view;
  towards = towards - n * inner_product(n, towards);
  towards = towards / sqrt(inner_product(towards, towards));
  float turned = g_view / cos_view;
  float square = 2.0 * core_variance(orientation) * turned * turned;
  float x2 = square / (1.0 + 1.44 * square / (cos_view * cos_view));
  float y2 = square / (1.0 + 2.73 * square);
  float slope = 1.07 * x2 * sqrt((1.0 - cos_view) * (1.0 + cos_view)) / cos_view;
  SmoothPart part = facets_at(n, towards, slope, x2, y2);

  vector light = part.facing * (2.0 * inner_product(part.facing, view)) - view;
  float cos_light = min(inner_product(n, light), 1.0);
  if (!(cos_light > 1e-3))
    return none;
  float cos_light_in = min(eta_cos_refracted(cos_light, layer.eta) / layer.eta, 1.0);
  color slant_light = slant_depth_of(layer, flakes, library, cos_light_in);
  float grey_view = (surface.slant[0] + surface.slant[1] + surface.slant[2]) / 3.0;
  float grey_light = (slant_light[0] + slant_light[1] + slant_light[2]) / 3.0;
  float depth = grey_light * cos_light_in;

  float at2 = FITTED * FITTED;
  float whole = 0.0;
  float falls[4] = {0.0, 0.0, 0.0, 0.0};
  for (int i = 0; i < 4; ++i) {
    float x = i == 1 ? FITTED : i == 2 ? -FITTED : 0.0;
    float y = i == 3 ? FITTED : 0.0;
    float ratio = flakes_over_facets(layer, orientation, n, view, grey_view, depth, part, x, y);
    if (i == 0)
      whole = ratio;
    if (!(whole > 0.0))
      return none;
    falls[i] = at2 - logarithm(clamp(ratio / whole, 1e-3, 1e3));
  }
  float both = falls[1] + falls[2];
  float aside = (falls[2] - falls[1]) / (2.0 * max(both, 0.4 * at2));
  slope = max(slope + FITTED * part.alpha_x * clamp(aside, -0.7, 0.7), 0.0);
  x2 = x2 / (clamp(both / (2.0 * at2), 0.34, 4.0) * NARROWER);
  y2 = y2 / (clamp(falls[3] / at2, 0.34, 4.0) * NARROWER_ACROSS);
  part = facets_at(n, towards, slope, x2, y2);

  float lowest = 0.0;
  for (int i = 0; i < 6; ++i) {
    float reach = i == 0 ? 0.0 : i < 4 ? HELD : 0.7 * HELD;
    float x = i == 3 ? 0.0 : i == 1 || i == 4 ? reach : -reach;
    float y = i < 3 ? 0.0 : reach;
    float ratio = flakes_over_facets(layer, orientation, n, view, grey_view, depth, part, x, y);
    if (i == 0 || (ratio > 0.0 && ratio < lowest))
      lowest = ratio;
  }

  light = part.facing * (2.0 * inner_product(part.facing, view)) - view;
  Mirror mirror = mirror_between(n, view, light, layer.eta);
  if (!mirror.possible)
    return none;
  float apart = ways_apart(n, view, mirror.cos_view, mirror.g_view, light, mirror.cos_light, mirror.g_light);
  color slant = there_and_back(layer, surface.slant, slant_light, apart);
  color greyed = there_and_back(layer, color(grey_view), color(grey_light), apart);
  float exit = g_view;
  if (layer.radiometry == RADIOMETRY_PUBLISHED)
    exit = layer.eta * cos_view;
  float factor = some.coverage * fresnel_transmittance(cos_view, g_view, layer.eta) /
                 (8.0 * M_PI * exit * mean_transmittance(greyed[0]));
  part.weight = coating_reflectance(some.coating, library, mirror.cos_alpha) * mean_transmittance(slant) *
                (factor * lowest * BELOW);
  return part;
}
