// SPDX-License-Identifier: Apache-2.0
//
// What flakes mirror of other light, as far as two lobes of microfacets show it: see core/smooth_part.h.
#pragma once

#include "coating.h"
#include "expected_sparkles.h"
#include "hot_spot.h"
#include "layer.h"
#include "outline.h"
#include "passage.h"

#define WIDER 2.0
#define MOST_WIDE 0.25
#define MOST_ASIDE 0.4
#define MOST_SQUARE 0.5
#define HEIGHT 0.98
#define HEIGHT_ASIDE 1.05
#define HEIGHT_FAR 1.1
#define LOWER 0.13
#define LOWER_FROM 0.15
#define LOWER_RANGE 0.1
#define LEAST_SMOOTH 0.2
#define LEAST_RISE 0.2
#define SHOWN_TWICE 2e-3

struct Facets {
  vector facing;  // their normal
  vector along;
  float alpha_x;
  float alpha_y;
  color weight;
};

struct SmoothPart {
  Facets narrow;
  Facets wide;
};

float masking_lambda(float square)
{
  if (square < 0.39)
    return 0.0;
  float a = 1.0 / sqrt(square);
  return ((0.396 * a - 1.259) * a + 1.0) / ((2.181 * a + 3.535) * a);
}

float masking_square(Facets facets, vector across, vector to)
{
  float x = inner_product(to, facets.along) * facets.alpha_x;
  float y = inner_product(to, across) * facets.alpha_y;
  float z = inner_product(to, facets.facing);
  return (x * x + y * y) / max(z * z, 1e-12);
}

float masked_by(Facets facets, vector view, vector light)
{
  vector across = cross(facets.facing, facets.along);
  return 1.0 + masking_lambda(masking_square(facets, across, view)) +
         masking_lambda(masking_square(facets, across, light));
}

float facets_show(Facets facets, vector view, vector light)
{
  vector across = cross(facets.facing, facets.along);
  float view_z = inner_product(view, facets.facing);
  float light_z = inner_product(light, facets.facing);
  if (!(view_z > 0.0 && light_z > 0.0))
    return 0.0;
  vector half = view + light;
  float half_z = view_z + light_z;
  float x = inner_product(half, facets.along) / (facets.alpha_x * half_z);
  float y = inner_product(half, across) / (facets.alpha_y * half_z);
  float area = facets.alpha_x * facets.alpha_y;
  float cos2 = half_z * half_z / inner_product(half, half);
  return exponential(-(x * x + y * y)) /
         (M_PI * area * cos2 * cos2 * masked_by(facets, view, light) * 4.0 * view_z);
}

struct FacetsFall {
  vector gradient;
  vector x;
  vector y;
};

FacetsFall facets_fall(Facets facets, vector view, vector light)
{
  vector across = cross(facets.facing, facets.along);
  vector half = view + light;
  float half_z = inner_product(half, facets.facing);
  float x = inner_product(half, facets.along) / half_z;
  float y = inner_product(half, across) / half_z;
  FacetsFall fall;
  fall.x = (facets.along - facets.facing * x) / (facets.alpha_x * half_z);
  fall.y = (across - facets.facing * y) / (facets.alpha_y * half_z);
  fall.gradient = half * (4.0 / inner_product(half, half)) - facets.facing * (4.0 / half_z) -
                  fall.x * (2.0 * x / facets.alpha_x) - fall.y * (2.0 * y / facets.alpha_y);
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

Facets facets_at(vector n, vector towards, float slope, float x2, float y2)
{
  float cosine = 1.0 / sqrt(1.0 + slope * slope);
  Facets facets;
  facets.facing = (n + towards * slope) * cosine;
  facets.along = (towards - n * slope) * cosine;
  facets.alpha_x = clamp(sqrt(x2), 1e-3, 1.0);
  facets.alpha_y = clamp(sqrt(y2), 1e-3, 1.0);
  facets.weight = color(0.0);
  return facets;
}

SmoothPart no_part(vector n)
{
  SmoothPart none;
  none.narrow = facets_at(n, vector(0.0), 0.0, 0.0, 0.0);
  none.wide = none.narrow;
  return none;
}

float lobe_height(OrientationDensity density)
{
  float wide = clamp((density.tilt - LOWER_FROM) / LOWER_RANGE, 0.0, 1.0);
  if (density.kind == ORIENTATION_GGX)
    wide = 1.0;
  return 1.0 - LOWER * wide;
}

float wide_share(float far, float fall)
{
  float far_wide = exponential(-4.0 * fall / WIDER);
  float near_wide = exponential(-1.0 / WIDER);
  float share = 0.0;
  float steep = 1.2;
  for (int k = 0; k < 2; ++k) {
    float far_narrow = exponential(-4.0 * fall * steep);
    share = clamp((far - far_narrow) / (far_wide - far_narrow), 0.0, MOST_WIDE);
    steep = -logarithm((exponential(-1.0) - share * near_wide) / (1.0 - share));
  }
  return share;
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
  float guessed_x2 = square / (1.0 + 1.44 * square / (cos_view * cos_view));
  float guessed_y2 = square / (1.0 + 2.73 * square);
  float slope = 1.07 * guessed_x2 * sqrt((1.0 - cos_view) * (1.0 + cos_view)) / cos_view;
  Facets guess = facets_at(n, towards, slope, guessed_x2, guessed_y2);

  vector along = guess.along * guess.alpha_x;
  vector across = cross(guess.facing, guess.along) * guess.alpha_y;
  vector light[6];
  color shown[6];
  float falls[6];
  float middle = 0.0;
  int is_far_seen = 1;
  color depth = color(0.0);
  for (int i = 0; i < 6; ++i) {
    vector half = guess.facing;
    if (i == 1)
      half = half + along;
    if (i == 2)
      half = half - along;
    if (i == 3)
      half = half + across;
    if (i == 4)
      half = half + along * 2.0;
    if (i == 5)
      half = half + across * 2.0;
    float steepness = inner_product(half, half);
    light[i] = half * (2.0 * inner_product(half, view) / steepness) - view;
    float cos_light = min(inner_product(n, light[i]), 1.0);
    falls[i] = 0.0;
    shown[i] = color(0.0);
    if (!(cos_light > LEAST_RISE)) {
      if (i < 4)
        return none;
      is_far_seen = 0;
      continue;
    }
    if (i == 0) {
      float cos_light_in = min(eta_cos_refracted(cos_light, layer.eta) / layer.eta, 1.0);
      depth = slant_depth_of(layer, library, cos_light_in) * cos_light_in;
    }
    shown[i] = flakes_show(layer, some, library, n, view, light[i], surface.slant, depth);
    float ratio = (shown[i][0] + shown[i][1] + shown[i][2]) * masked_by(guess, view, light[i]) / (steepness * steepness);
    if (i == 0)
      middle = ratio;
    if (!(middle > 0.0))
      return none;
    falls[i] = -logarithm(clamp(ratio / middle, 1e-6, 1e6));
  }

  float fall_x = clamp(0.5 * (falls[1] + falls[2]), 0.34, 4.0);
  float fall_y = clamp(falls[3], 0.34, 4.0);
  float wide_x2 = WIDER * (guess.alpha_x * guess.alpha_x) / fall_x;
  float wide_y2 = WIDER * (guess.alpha_y * guess.alpha_y) / fall_y;
  float share = 0.0;
  float aside = 0.0;
  if (is_far_seen && max(wide_x2, wide_y2) < MOST_SQUARE) {
    share = wide_share(exponential(-falls[5]), fall_y);
    if (share > 0.0) {
      float lower = max(falls[4] + logarithm(share), 0.0);
      aside = clamp(2.0 * guess.alpha_x - sqrt(wide_x2 * lower), -MOST_ASIDE * guess.alpha_x,
                    MOST_ASIDE * guess.alpha_x);
    }
  }

  float left[4];
  for (int i = 0; i < 4; ++i) {
    float x = (i == 1 ? guess.alpha_x : i == 2 ? -guess.alpha_x : 0.0) - aside;
    float y = i == 3 ? guess.alpha_y : 0.0;
    float by_wide = share * exponential(-(x * x / wide_x2 + y * y / wide_y2));
    left[i] = max(exponential(-clamp(falls[i], -6.0, 6.0)) - by_wide, 1e-3);
  }
  float near = -logarithm(left[1] / left[0]);
  float away = -logarithm(left[2] / left[0]);
  float both = near + away;
  float turn = clamp((away - near) / (2.0 * max(both, 0.4)), -0.7, 0.7);
  SmoothPart part = none;
  part.narrow = facets_at(n, towards, max(slope + guess.alpha_x * turn, 0.0),
                          guess.alpha_x * guess.alpha_x / clamp(both / 2.0, 0.34, 6.0),
                          guess.alpha_y * guess.alpha_y / clamp(-logarithm(left[3] / left[0]), 0.34, 6.0));
  if (share > 0.0)
    part.wide = facets_at(n, towards, slope + aside, wide_x2, wide_y2);

  float highest = lobe_height(some.orientation);
  float narrow_shows[6];
  float wide_shows[6];
  int points = share > 0.0 ? 6 : 4;
  for (int i = 0; i < points; ++i) {
    narrow_shows[i] = facets_show(part.narrow, view, light[i]);
    wide_shows[i] = 0.0;
    if (share > 0.0)
      wide_shows[i] = facets_show(part.wide, view, light[i]);
  }
  if (share > 0.0 && narrow_shows[0] > 0.0 && wide_shows[0] > 0.0) {
    float unit_narrow = left[0] / narrow_shows[0];
    float unit_wide = (1.0 - left[0]) / wide_shows[0];
    color most = color(1e30);
    for (int i = 0; i < 6; ++i) {
      if (i > 0 && i < 4)
        continue;
      float height = highest * (i == 0 ? HEIGHT : HEIGHT_FAR) * unit_wide /
                     (unit_narrow * narrow_shows[i] + unit_wide * wide_shows[i]);
      most = min(most, shown[i] * height);
    }
    part.wide.weight = most;
  }
  color most = color(1e30);
  for (int i = 0; i < 4; ++i) {
    if (narrow_shows[i] > 0.0 && max(max(shown[i][0], shown[i][1]), shown[i][2]) > 0.0) {
      float height = highest * (i == 0 ? HEIGHT : HEIGHT_ASIDE);
      color rest = shown[i] * height - part.wide.weight * wide_shows[i];
      most = min(most, max(rest, color(0.0)) / narrow_shows[i]);
    }
  }
  if (most[0] < 1e30)
    part.narrow.weight = most;
  return part;
}

color smooth_shows(SmoothPart part, vector view, vector light)
{
  return part.narrow.weight * facets_show(part.narrow, view, light) +
         part.wide.weight * facets_show(part.wide, view, light);
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
    SmoothPart of_species = parts[i];
    color shown = color(0.0);
    float seen = 0.0;
    for (int k = 0; k < points; ++k) {
      seen = seen + part[k];
      shown = shown + smooth_shows(of_species, view, towards[k]) * part[k];
    }
    Flakes some = flakes_of(layer, i);
    float share = sparkling_share(light.breadth, light.apart, turned_by(some, layer.eta));
    sum = sum + shown * (share / seen);
  }
  return sum;
}

color may_show(color lobes, color sparkles, color diffuse)
{
  return min((sparkles + diffuse * SHOWN_TWICE) / max(lobes, color(1e-30)), color(1.0));
}
