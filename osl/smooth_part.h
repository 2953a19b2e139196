// SPDX-License-Identifier: Apache-2.0
//
// What flakes mirror of other light, as far as a lobe of microfacets shows it: see core/smooth_part.h.
#pragma once

#include "coating.h"
#include "expected_sparkles.h"
#include "hot_spot.h"
#include "layer.h"
#include "outline.h"
#include "passage.h"

#define HEIGHT 0.98
#define HEIGHT_ASIDE 1.078
#define LOWER 0.13
#define LOWER_FROM 0.15
#define LOWER_RANGE 0.1
#define LEAST_SMOOTH 0.2
#define LEAST_RISE 0.2
#define SHOWN_TWICE 2e-3

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

struct FacetsFall {
  vector gradient;
  vector x;
  vector y;
};

FacetsFall facets_fall(SmoothPart part, vector view, vector light)
{
  vector across = cross(part.facing, part.along);
  vector half = view + light;
  float half_z = inner_product(half, part.facing);
  float x = inner_product(half, part.along) / half_z;
  float y = inner_product(half, across) / half_z;
  FacetsFall fall;
  fall.x = (part.along - part.facing * x) / (part.alpha_x * half_z);
  fall.y = (across - part.facing * y) / (part.alpha_y * half_z);
  fall.gradient = half * (4.0 / inner_product(half, half)) - part.facing * (4.0 / half_z) -
                  fall.x * (2.0 * x / part.alpha_x) - fall.y * (2.0 * y / part.alpha_y);
  return fall;
}

float bend_along(FacetsFall fall, vector tangent)
{
  float x = inner_product(fall.x, tangent);
  float y = inner_product(fall.y, tangent);
  return -2.0 * (x * x + y * y);
}

color flakes_show(Layer layer, Flakes some, float library[], vector n, vector view, vector light, color slant_view,
                  color depth)
{
  Mirror mirror = mirror_between(n, view, light, layer.eta);
  if (!mirror.possible)
    return color(0.0);
  float apart = ways_apart(n, view, mirror.cos_view, mirror.g_view, light, mirror.cos_light, mirror.g_light);
  color slant = there_and_back(layer, slant_view, depth * (layer.eta / mirror.g_light), apart);
  float exit = mirror.g_view;
  if (layer.radiometry == RADIOMETRY_PUBLISHED)
    exit = layer.eta * mirror.cos_view;
  float through = fresnel_transmittance(mirror.cos_view, mirror.g_view, layer.eta) *
                  fresnel_transmittance(mirror.cos_light, mirror.g_light, layer.eta);
  return coating_reflectance(some.coating, library, mirror.cos_alpha) * mean_transmittance(slant) *
         (some.coverage * orientation_density(some.orientation, mirror.sin2_half_beta) * through * mirror.cos_light /
          (8.0 * M_PI * exit * mirror.g_light));
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

SmoothPart no_part(vector n)
{
  return facets_at(n, vector(0.0), 0.0, 0.0, 0.0);
}

float lobe_height(OrientationDensity density)
{
  float wide = clamp((density.tilt - LOWER_FROM) / LOWER_RANGE, 0.0, 1.0);
  if (density.kind == ORIENTATION_GGX)
    wide = 1.0;
  return 1.0 - LOWER * wide;
}

SmoothPart smooth_part(Layer layer, Flakes some, float library[], SurfacePoint surface)
{
  vector n = surface.n;
  vector view = surface.view;
  SmoothPart none = no_part(n);
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
  float square = 2.0 * core_variance(some.orientation) * turned * turned;
  float x2 = square / (1.0 + 1.44 * square / (cos_view * cos_view));
  float y2 = square / (1.0 + 2.73 * square);
  float slope = 1.07 * x2 * sqrt((1.0 - cos_view) * (1.0 + cos_view)) / cos_view;
  SmoothPart part = facets_at(n, towards, slope, x2, y2);

  vector across = cross(part.facing, part.along) * part.alpha_y;
  vector light[4];
  color shown[4];
  float ratio[4];
  color depth = color(0.0);
  for (int i = 0; i < 4; ++i) {
    vector half = part.facing;
    if (i == 1)
      half = half + part.along * part.alpha_x;
    if (i == 2)
      half = half - part.along * part.alpha_x;
    if (i == 3)
      half = half + across;
    light[i] = half * (2.0 * inner_product(half, view) / inner_product(half, half)) - view;
    float cos_light = min(inner_product(n, light[i]), 1.0);
    if (!(cos_light > LEAST_RISE))
      return none;
    if (i == 0) {
      float cos_light_in = min(eta_cos_refracted(cos_light, layer.eta) / layer.eta, 1.0);
      depth = slant_depth_of(layer, library, cos_light_in) * cos_light_in;
    }
    shown[i] = flakes_show(layer, some, library, n, view, light[i], surface.slant, depth);
    ratio[i] = (shown[i][0] + shown[i][1] + shown[i][2]) / max(facets_show(part, view, light[i]), 1e-30);
    if (!(ratio[0] > 0.0))
      return part;
  }

  float near = 1.0 - logarithm(clamp(ratio[1] / ratio[0], 1e-3, 1e3));
  float far = 1.0 - logarithm(clamp(ratio[2] / ratio[0], 1e-3, 1e3));
  float both = near + far;
  float aside = (far - near) / (2.0 * max(both, 0.4));
  slope = max(slope + part.alpha_x * clamp(aside, -0.7, 0.7), 0.0);
  x2 = x2 / clamp(both / 2.0, 0.34, 4.0);
  y2 = y2 / clamp(1.0 - logarithm(clamp(ratio[3] / ratio[0], 1e-3, 1e3)), 0.34, 4.0);
  part = facets_at(n, towards, slope, x2, y2);

  color weight = color(1e30);
  float highest = lobe_height(some.orientation);
  for (int i = 0; i < 4; ++i) {
    float facets = facets_show(part, view, light[i]);
    if (facets > 0.0 && max(max(shown[i][0], shown[i][1]), shown[i][2]) > 0.0)
      weight = min(weight, shown[i] * (highest * (i == 0 ? HEIGHT : HEIGHT_ASIDE) / facets));
  }
  if (weight[0] < 1e30)
    part.weight = weight;
  return part;
}

color smooth_sparkles(Layer layer, SmoothPart parts[SPECIES], vector view, SeenLight light, int flat)
{
  color sum = color(0.0);
  vector towards[4];
  float part[4];
  int points = 1;
  towards[0] = light.direction;
  part[0] = 1.0;
  if (flat && light.radius > 0.0) {
    points_within(light, towards, part);
    points = 4;
  }
  for (int i = 0; i < layer.species; ++i) {
    float shown = 0.0;
    float seen = 0.0;
    for (int k = 0; k < points; ++k) {
      seen = seen + part[k];
      shown = shown + part[k] * facets_show(parts[i], view, towards[k]);
    }
    Flakes some = flakes_of(layer, i);
    float share = sparkling_share(light.breadth, light.apart, turned_by(some, layer.eta));
    sum = sum + parts[i].weight * (shown / seen * share);
  }
  return sum;
}

color may_show(color lobes, color sparkles, color diffuse)
{
  return min((sparkles + diffuse * SHOWN_TWICE) / max(lobes, color(1e-30)), color(1.0));
}
