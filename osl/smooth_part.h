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

#define LOBE_SHAPES {0.82, 2.2, -0.8, 0.75, 0.65, 0.6, 0.85}
#define LOBE_SHAPES_GGX {1.0, 5.5, 0.0, 5.5, 0.0, 0.4, 0.7}
#define NARROW_SLOPE 0.95
#define WIDE_SLOPE 0.4
#define HEIGHT 0.95
#define LOWER 0.13
#define LOWER_FROM 0.15
#define LOWER_RANGE 0.1
#define LEAST_RISE 0.02
#define PEAK_STEPS 6
#define NEAR_LIGHTS 3
#define LOBE_LIGHTS 6
#define SHOWN_TWICE 2e-3
#define LEAST_FALL 0.3
#define MOST_FALL 10.0
#define LEAN_BACK 0.75

struct LobeShapes {
  float narrow;
  float along;
  float along_by;
  float across;
  float across_by;
  float middle;
  float height;
};

struct Facets {
  vector facing;  // their normal
  vector along;
  vector across;
  float alpha_x;
  float alpha_y;
  float view_along;
  float view_across;
  float view_up;
  float view_masked;
  float narrowed;
  color weight;
};

struct SmoothPart {
  Facets narrow;
  Facets wide;
  float rise;
};

float masking_lambda(float square)
{
  if (square < 0.39)
    return 0.0;
  float a = 1.0 / sqrt(square);
  return ((0.396 * a - 1.259) * a + 1.0) / ((2.181 * a + 3.535) * a);
}

float masking_square(Facets facets, float along, float across, float up)
{
  float x = along * facets.alpha_x;
  float y = across * facets.alpha_y;
  return (x * x + y * y) / max(up * up, 1e-12);
}

float facets_show(Facets facets, vector light)
{
  float up = inner_product(light, facets.facing);
  if (!(facets.view_up > 0.0 && up > 0.0))
    return 0.0;
  float along = inner_product(light, facets.along);
  float across = inner_product(light, facets.across);
  float masked = facets.view_masked + masking_lambda(masking_square(facets, along, across, up));
  float half_along = facets.view_along + along;
  float half_across = facets.view_across + across;
  float half_up = facets.view_up + up;
  float x = half_along / facets.alpha_x;
  float y = half_across / facets.alpha_y;
  float per_up2 = 1.0 / (half_up * half_up);
  float per_cos2 = (half_along * half_along + half_across * half_across) * per_up2 + 1.0;
  return exponential(-(x * x + y * y) * per_up2) * per_cos2 * per_cos2 /
         (4.0 * M_PI * facets.alpha_x * facets.alpha_y * facets.view_up * masked);
}

struct FacetsFall {
  vector gradient;
  vector x;
  vector y;
};

FacetsFall facets_fall(Facets facets, vector view, vector light)
{
  vector half = view + light;
  float half_z = inner_product(half, facets.facing);
  float x = inner_product(half, facets.along) / half_z;
  float y = inner_product(half, facets.across) / half_z;
  FacetsFall fall;
  fall.x = (facets.along - facets.facing * x) / (facets.alpha_x * half_z);
  fall.y = (facets.across - facets.facing * y) / (facets.alpha_y * half_z);
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

struct FlakesSeen {
  vector n;
  vector tangent;
  float g;
  float factor;
  color slant;
};

FlakesSeen flakes_seen(Layer layer, Flakes some, SurfacePoint surface, float cos_view, float g)
{
  float exit = g;
  if (layer.radiometry == RADIOMETRY_PUBLISHED)
    exit = layer.eta * cos_view;
  FlakesSeen seen;
  seen.n = surface.n;
  seen.tangent = surface.view - surface.n * cos_view;
  seen.g = g;
  seen.factor = some.coverage * fresnel_transmittance(cos_view, g, layer.eta) / (8.0 * M_PI * exit);
  seen.slant = surface.slant;
  return seen;
}

struct MiddleOfLobe {
  color depth;
  color in_common;
};

MiddleOfLobe middle_of_lobe(Layer layer, float library[], FlakesSeen seen, vector light, float cos_light)
{
  float g = eta_cos_refracted(cos_light, layer.eta);
  float cos_in = min(g / layer.eta, 1.0);
  color slant = slant_depth_of(layer, library, cos_in);
  MiddleOfLobe middle;
  middle.depth = slant * cos_in;
  middle.in_common = color(0.0);
  if (layer.depth_model == DEPTH_MODEL_CORRELATED) {
    float apart = ways_apart(seen.n, seen.tangent, 0.0, seen.g, light, cos_light, g);
    middle.in_common = share_in_common(layer, both_ways(layer, seen.slant, slant, apart));
  }
  return middle;
}

color flakes_show(Layer layer, Flakes some, float library[], FlakesSeen seen, MiddleOfLobe middle, vector light,
                  float cos_light)
{
  float g = eta_cos_refracted(cos_light, layer.eta);
  if (!(g > 0.0))
    return color(0.0);
  MirroringFlake flake = mirroring_flake(seen.tangent + (light - seen.n * cos_light), seen.g + g, layer.eta);
  color slant = seen.slant + middle.depth * (layer.eta / g);
  if (layer.depth_model == DEPTH_MODEL_CORRELATED)
    slant = less_in_common(layer, slant, middle.in_common);
  return coating_reflectance(some.coating, library, flake.cos_alpha) * mean_transmittance(slant) *
         (seen.factor * orientation_density(some.orientation, flake.sin2_half_beta) *
          fresnel_transmittance(cos_light, g, layer.eta) * cos_light / g);
}

Facets facets_at(vector n, vector towards, float slope, float x2, float y2, float sin_view, float cos_view)
{
  float cosine = 1.0 / sqrt(1.0 + slope * slope);
  Facets facets;
  facets.facing = (n + towards * slope) * cosine;
  facets.along = (towards - n * slope) * cosine;
  facets.across = cross(n, towards);
  facets.alpha_x = clamp(sqrt(x2), 1e-3, 1.0);
  facets.alpha_y = clamp(sqrt(y2), 1e-3, 1.0);
  facets.view_along = (sin_view - slope * cos_view) * cosine;
  facets.view_across = 0.0;
  facets.view_up = (cos_view + slope * sin_view) * cosine;
  facets.view_masked = 1.0 + masking_lambda(masking_square(facets, facets.view_along, 0.0, facets.view_up));
  facets.narrowed = 1.0;
  facets.weight = color(0.0);
  return facets;
}

SmoothPart no_part(vector n)
{
  SmoothPart none;
  none.narrow = facets_at(n, vector(0.0), 0.0, 0.0, 0.0, 0.0, 1.0);
  none.wide = none.narrow;
  none.rise = 0.0;
  return none;
}

SmoothPart smooth_part(Layer layer, Flakes some, float library[], SurfacePoint surface)
{
  vector n = surface.n;
  vector view = surface.view;
  SmoothPart none = no_part(n);
  float cos_view = min(inner_product(n, view), 1.0);
  if (!(cos_view > LEAST_COSINE) || !(some.coverage > 0.0))
    return none;
  float g_view = eta_cos_refracted(cos_view, layer.eta);
  if (!(g_view > 0.0))
    return none;
  FlakesSeen seen = flakes_seen(layer, some, surface, cos_view, g_view);
  float sin_view = sqrt(inner_product(seen.tangent, seen.tangent));
  vector towards = seen.tangent;
  if (!(sin_view > 1e-6)) {
    towards = vector(0.0, 1.0, 0.0);
    if (fabs(n[0]) < 0.6)
      towards = vector(1.0, 0.0, 0.0);
  }
  towards = towards - n * inner_product(n, towards);
  towards = towards / sqrt(inner_product(towards, towards));

  float variance = core_variance(some.orientation);
  float away = 0.0;
  float rise = 1.0;
  float back = sin_view;
  float q = 0.0;
  float square = 1.0;
  for (int i = 0; i <= PEAK_STEPS; ++i) {
    float g = eta_cos_refracted(rise, layer.eta);
    q = max(2.0 - 2.0 * rise / max(g, 1e-6), 0.0);
    square = variance * ((g_view + g) * (g_view + g));
    if (i == PEAK_STEPS)
      break;
    float pull = q * square;
    away = clamp(away + (back * rise * rise - pull * away) / (rise * rise + 2.0 * away * back + pull), 0.0, sin_view);
    rise = sqrt((1.0 - away) * (1.0 + away));
    back = sin_view - away;
  }
  float up = cos_view + rise;
  float slope = back / up;
  float by_pull = back * away / square;
  float by_rise = q / (rise * rise);
  float along = rise * rise / square + by_rise;
  float x2 = 0.5 / (along + by_pull);
  float y2 = 2.0 / ((up * up + back * back) * (1.0 / square + by_pull + q));
  int tail = some.orientation.kind == ORIENTATION_GGX;
  LobeShapes shapes = LOBE_SHAPES;
  LobeShapes of_ggx = LOBE_SHAPES_GGX;
  if (tail)
    shapes = of_ggx;
  float tilted = clamp((some.orientation.tilt - LOWER_FROM) / LOWER_RANGE, tail ? 1.0 : 0.0, 1.0);
  float highest = 1.0 - LOWER * tilted;
  Facets guess = facets_at(n, towards, slope, x2, y2, sin_view, cos_view);
  SmoothPart part = none;
  part.rise = rise;
  part.narrow = facets_at(n, towards, NARROW_SLOPE * slope, shapes.narrow * x2, shapes.narrow * y2, sin_view, cos_view);
  part.wide = facets_at(n, towards, WIDE_SLOPE * slope, (shapes.along + shapes.along_by * cos_view) * (0.5 / along),
                        (shapes.across + shapes.across_by * cos_view) * y2, sin_view, cos_view);

  MiddleOfLobe middle;
  color shown[NEAR_LIGHTS];
  float narrow_shows[NEAR_LIGHTS];
  float wide_shows[NEAR_LIGHTS];
  color most = color(1e30);
  for (int i = 0; i < LOBE_LIGHTS; ++i) {
    float x = guess.alpha_x * (i == 2 ? 1.0 : i == 4 ? 2.0 : i == 5 ? -1.5 : 0.0);
    float y = guess.alpha_y * (i == 1 ? 1.0 : i == 3 ? 2.0 : 0.0);
    vector half = guess.facing + guess.along * x + guess.across * y;
    vector light = half * (2.0 * (guess.view_up + x * guess.view_along) / (1.0 + x * x + y * y)) - view;
    float cos_light = min(inner_product(n, light), 1.0);
    if (i < NEAR_LIGHTS)
      narrow_shows[i] = 0.0;
    if (!(cos_light > LEAST_RISE)) {
      if (i == 0)
        return none;
      continue;
    }
    if (i == 0)
      middle = middle_of_lobe(layer, library, seen, light, cos_light);
    color f = flakes_show(layer, some, library, seen, middle, light, cos_light);
    float wide = facets_show(part.wide, light);
    float height = (i == 0 ? shapes.middle : shapes.height) * highest;
    if (wide > 0.0)
      most = min(most, f * (height / wide));
    if (i < NEAR_LIGHTS) {
      shown[i] = f;
      narrow_shows[i] = facets_show(part.narrow, light);
      wide_shows[i] = wide;
    }
  }
  if (most[0] < 1e30)
    part.wide.weight = most;
  most = color(1e30);
  for (int i = 0; i < NEAR_LIGHTS; ++i) {
    if (narrow_shows[i] > 0.0) {
      color rest = shown[i] * (HEIGHT * highest) - part.wide.weight * wide_shows[i];
      most = min(most, max(rest, color(0.0)) / narrow_shows[i]);
    }
  }
  if (most[0] < 1e30)
    part.narrow.weight = most;
  return part;
}

color smooth_shows(SmoothPart part, vector light)
{
  return part.narrow.weight * facets_show(part.narrow, light) + part.wide.weight * facets_show(part.wide, light);
}

color smooth_sparkles(Layer layer, SmoothPart parts[SPECIES], SeenLight light, int flat)
{
  color sum = color(0.0);
  vector towards[8];
  float part[8];
  int points = 1;
  towards[0] = light.direction;
  part[0] = 1.0;
  if (flat && light.radius > 0.0) {
    points = 8;
    float of_eight[2] = {OF_EIGHT};
    for (int ring = 0; ring < 2; ++ring) {
      vector within[4];
      float share[4];
      points_within(light, of_eight[ring], ring, within, share);
      for (int k = 0; k < 4; ++k) {
        towards[4 * ring + k] = within[k];
        part[4 * ring + k] = share[k];
      }
    }
  }
  for (int i = 0; i < layer.species; ++i) {
    SmoothPart of_species = parts[i];
    color shown = color(0.0);
    float seen = 0.0;
    for (int k = 0; k < points; ++k) {
      seen = seen + part[k];
      shown = shown + smooth_shows(of_species, towards[k]) * part[k];
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

float fall_for(color may)
{
  float fall = -logarithm(clamp(min(may[0], min(may[1], may[2])), 1e-6, 1.0));
  return fall < LEAST_FALL ? 0.0 : min(fall, MOST_FALL);
}

Facets lean_lobe(Facets facets, vector view, vector light, float fall)
{
  Facets away = facets;
  float weight = max(max(facets.weight[0], facets.weight[1]), facets.weight[2]);
  if (!(weight > 0.0 && facets.view_up > 0.0 && inner_product(light, facets.facing) > 0.0))
    return away;
  vector half = view + light;
  float up = max(inner_product(half, facets.facing), 1e-6);
  float x = inner_product(half, facets.along) / (up * facets.alpha_x);
  float y = inner_product(half, facets.across) / (up * facets.alpha_y);
  float off = sqrt(x * x + y * y);
  int beside = off > 1e-6;
  x = beside ? x / off : 1.0;
  y = beside ? y / off : 0.0;
  float back = LEAN_BACK / (1.0 + off);
  float narrower = fall / ((off + back) * (off + back));
  float aside = back * narrower / (1.0 + narrower);

  float along2 = (1.0 + narrower * x * x) / (facets.alpha_x * facets.alpha_x);
  float across2 = (1.0 + narrower * y * y) / (facets.alpha_y * facets.alpha_y);
  float both = narrower * x * y / (facets.alpha_x * facets.alpha_y);
  float apart = 0.5 * (along2 - across2);
  float radius = sqrt(apart * apart + both * both);
  float steep = sqrt(0.5 * (along2 + across2) + radius);
  float less = sqrt(1.0 + narrower);
  float axis_along = apart + radius;
  float axis_across = both;
  if (apart < 0.0) {
    axis_along = both;
    axis_across = radius - apart;
  }
  if (!(radius > 0.0))
    axis_along = 1.0;

  vector leaning = facets.facing - facets.along * (aside * x * facets.alpha_x) -
                   facets.across * (aside * y * facets.alpha_y);
  away.facing = leaning / sqrt(inner_product(leaning, leaning));
  vector axis = facets.along * axis_along + facets.across * axis_across;
  vector level = axis - away.facing * inner_product(axis, away.facing);
  away.along = level / sqrt(inner_product(level, level));
  away.across = cross(away.facing, away.along);
  away.alpha_x = clamp(1.0 / steep, 1e-3, 1.0);
  away.alpha_y = clamp(facets.alpha_x * facets.alpha_y * steep / less, 1e-3, 1.0);
  away.view_along = inner_product(view, away.along);
  away.view_across = inner_product(view, away.across);
  away.view_up = inner_product(view, away.facing);
  away.view_masked = 1.0 + masking_lambda(masking_square(away, away.view_along, away.view_across, away.view_up));
  float seen = away.view_up * away.view_masked / (facets.view_up * facets.view_masked);
  away.narrowed = facets.narrowed / (1.0 + narrower);
  away.weight = facets.weight * (exponential(-aside * back) / less * clamp(seen, 0.0, 1.0));
  return away;
}

SmoothPart lean_away(SmoothPart part, vector view, vector light, float fall)
{
  SmoothPart away = part;
  away.narrow = lean_lobe(part.narrow, view, light, fall);
  away.wide = lean_lobe(part.wide, view, light, fall);
  return away;
}
