// SPDX-License-Identifier: Apache-2.0
//
// The flakes under light that is no sparkling one: a random flake for each sample, whose mirror direction is followed.
// See core/flake_lobe.h for the weight and the cones.
#pragma once

#include "close_up.h"
#include "passage.h"
#include "smooth_part.h"

#define WIDE_SHARE 0.15
#define WIDEST_DEVIATION 0.2
#define TO_HORIZON 0.1
#define TO_HORIZON_BESIDE 0.2
#define LOBE_SPREAD 0.33
#define WIDEST_LOBE 0.1
#define GIVEN_TO_LOBE 0.03
#define FLAKES_BESIDE 2
#define FLAKES_LEANING 5

struct MirroredSample {
  vector direction;
  color weight;
  float spread;
  float variance;
  vector drift;
  float along;
  float across;
  float density;
  int species;
  float turned;  // 2 eta tilt of its species, which tells what of an area light sparkles
};

float inside_unit(float x)
{
  return clamp(x, 1e-7, 1.0 - 1e-7);
}

MirroredSample sample_flake(Layer layer, float library[], SurfacePoint surface,
                            FirstFlake firsts[SPECIES], float uniform_tilt, float uniform_azimuth, float rise)
{
  MirroredSample mirrored;
  mirrored.direction = surface.n;
  mirrored.weight = color(0.0);
  mirrored.spread = 0.0;
  mirrored.variance = 0.0;
  mirrored.drift = vector(0.0);
  mirrored.along = 1.0;
  mirrored.across = 1.0;
  mirrored.density = 0.0;
  mirrored.species = 0;
  mirrored.turned = 1.0;
  vector n = surface.n;
  vector view = surface.below;
  float eta = layer.eta;
  float cos_view = min(inner_product(n, view), 1.0);
  if (!(cos_view > LEAST_COSINE))
    return mirrored;
  float g_view = eta_cos_refracted(cos_view, eta);
  if (!(g_view > 0.0))
    return mirrored;
  vector inside = (view + n * (g_view - cos_view)) / eta;

  if (!(layer.coverage > 0.0))
    return mirrored;
  float rest = uniform_tilt;
  int kind = 0;
  if (layer.species > 1) {
    float at = uniform_tilt * layer.coverage;
    float covered = layer.first.coverage;
    if (at >= covered) {
      at = at - covered;
      covered = layer.second.coverage;
      kind = 1;
      if (layer.species > 2) {
        if (at >= covered) {
          at = at - covered;
          covered = layer.third.coverage;
          kind = 2;
        }
      }
    }
    rest = inside_unit(at / max(covered, 1e-30));
  }
  Flakes some = flakes_of(layer, kind);
  mirrored.species = kind;
  mirrored.turned = 2.0 * eta * some.orientation.tilt;
  FirstFlake first = firsts[kind];
  if (first.close && !first.seen)
    return mirrored;
  vector m = first.m;
  float tilt_weight = 1.0;
  float h = 0.0;
  if (first.close) {
    mirrored.spread = min(eta * sqrt(some.solid_angle / M_PI), WIDEST_LOBE);
  }
  else {
    SampledTilt tilt = sample_tilt(some.orientation, rest);
    tilt_weight = tilt.weight;
    mirrored.spread = min(LOBE_SPREAD * (eta * some.orientation.tilt), WIDEST_LOBE);
    h = tilt.sin2_half_beta;
    float sin_beta = 2.0 * sqrt(h * (1.0 - h));
    float phi = M_2PI * uniform_azimuth;
    vector across = vector(0.0, 1.0, 0.0);
    if (fabs(n[0]) < 0.6)
      across = vector(1.0, 0.0, 0.0);
    across = across - n * inner_product(n, across);
    across = across / sqrt(inner_product(across, across));
    vector other = cross(n, across);
    m = n * (1.0 - 2.0 * h) + across * (sin_beta * cos(phi)) + other * (sin_beta * sin(phi));
  }

  float facing = inner_product(m, inside);
  vector l = m * (2.0 * facing) - inside;
  float along = inner_product(l, n);
  if (!(along > 0.0))
    return mirrored;
  vector tangent = (l - n * along) * eta;
  float cos2_light = 1.0 - inner_product(tangent, tangent);
  if (!(cos2_light > 0.0))
    return mirrored;
  float cos_light = sqrt(cos2_light);
  float g_light = eta * along;
  if (!(cos_light > LEAST_COSINE))
    return mirrored;
  mirrored.direction = tangent + n * cos_light;

  float cos_alpha = min(fabs(facing), 1.0);
  float cos_view_in = min(g_view / eta, 1.0);
  vector apart = inside / cos_view_in - l / along;
  color slant = there_and_back(layer, surface.slant, slant_depth_of(layer, library, min(along, 1.0)),
                               sqrt(inner_product(apart, apart)));
  float exit = cos_view_in;
  if (layer.radiometry == RADIOMETRY_PUBLISHED)
    exit = cos_view;
  float through = fresnel_transmittance(cos_view, g_view, eta) / exit *
                  fresnel_transmittance(cos_light, g_light, eta);
  color reflectance = coating_reflectance(some.coating, library, cos_alpha);
  if (first.close)
    mirrored.weight = shown_by(first, reflectance, slant) * (through * cos_view_in * (layer.coverage / some.coverage));
  else {
    mirrored.weight = reflectance * (layer.coverage * mean_transmittance(slant)) * (through * tilt_weight * cos_alpha);
    float p = orientation_density(some.orientation, h) / tilt_weight;
    mirrored.density = p * cos_light * some.coverage / (8.0 * M_PI * cos_alpha * eta * g_light * layer.coverage);
    float turned = 2.0 * eta * cos_view_in;
    float most = min(WIDEST_DEVIATION, rise > 0.0 ? TO_HORIZON_BESIDE * rise : TO_HORIZON * cos_view);
    mirrored.variance = min(WIDE_SHARE * turned * turned * core_variance(some.orientation), most * most);
    float slope = orientation_slope(some.orientation, h);
    vector pull = (n - m * (1.0 - 2.0 * h)) * (slope / (2.0 * facing));
    vector gradient = (pull - l * (inner_product(pull, n) / along)) / eta +
                      tangent * (1.0 / (eta * eta * along * along) - 1.0 / cos2_light);
    mirrored.drift = (gradient - mirrored.direction * inner_product(gradient, mirrored.direction)) * mirrored.variance;
    float along_turn = cos_light / (2.0 * eta * along);
    float across_turn = 1.0 / (2.0 * eta * cos_alpha);
    float bend = mirrored.variance * slope;
    mirrored.along = sqrt(max(1.0 - bend * along_turn * along_turn, 0.0));
    mirrored.across = sqrt(max(1.0 - bend * across_turn * across_turn, 0.0));
  }
  return mirrored;
}

vector level_across(vector n, vector direction)
{
  vector sideways = cross(n, direction);
  float sine = sqrt(inner_product(sideways, sideways));
  if (!(sine > 1e-6))
    return vector(0.0);
  return sideways / sine;
}

color leave_beside(output MirroredSample mirrored, SmoothPart part, vector n, vector view)
{
  if (!(mirrored.density > 0.0))
    return color(0.0);
  color whole = mirrored.weight;
  color narrow = part.narrow.weight * (facets_show(part.narrow, mirrored.direction) / mirrored.density);
  color wide = part.wide.weight * (facets_show(part.wide, mirrored.direction) / mirrored.density);
  color all = whole - narrow - wide;
  float shows[2] = {0.0, 0.0};
  float after = 0.0;
  color left = color(0.0);
  for (int c = 0; c < 3; ++c) {
    if (all[c] > GIVEN_TO_LOBE * whole[c]) {
      left[c] = all[c];
      shows[0] = shows[0] + narrow[c];
      shows[1] = shows[1] + wide[c];
      after = after + all[c];
    }
  }
  mirrored.weight = left;
  color given = all - left;
  if (!(after > 0.0 && mirrored.variance > 0.0))
    return given;

  float narrowed = sqrt(min(part.narrow.narrowed, part.wide.narrowed));
  float t = mirrored.variance * narrowed;
  mirrored.variance = t;
  mirrored.drift = mirrored.drift * narrowed;
  vector across = level_across(n, mirrored.direction);
  vector along = cross(mirrored.direction, across);
  float pull_along = 0.0;
  float pull_across = 0.0;
  float bend_in = 0.0;
  float bend_across = 0.0;
  float f_along = (mirrored.along * mirrored.along - 1.0) * narrowed;
  float f_across = (mirrored.across * mirrored.across - 1.0) * narrowed;
  for (int i = 0; i < 2; ++i) {
    float k = shows[i] / after;
    if (k > 0.0) {
      Facets facets = part.narrow;
      if (i == 1)
        facets = part.wide;
      FacetsFall fall = facets_fall(facets, view, mirrored.direction);
      vector apart = mirrored.drift - fall.gradient * t;
      float a = inner_product(apart, along);
      float b = inner_product(apart, across);
      pull_along = pull_along + k * a;
      pull_across = pull_across + k * b;
      bend_in = bend_in + k * (f_along - t * bend_along(fall, along) - a * a / t);
      bend_across = bend_across + k * (f_across - t * bend_along(fall, across) - b * b / t);
    }
  }
  mirrored.drift = mirrored.drift + along * pull_along + across * pull_across;
  mirrored.along = sqrt(max(1.0 + f_along + bend_in - pull_along * pull_along / t, 0.0));
  mirrored.across = sqrt(max(1.0 + f_across + bend_across - pull_across * pull_across / t, 0.0));
  return given;
}

SmoothPart give_to_lobes(SmoothPart part, color more, color less)
{
  SmoothPart given = part;
  color rest = part.wide.weight + less;
  given.wide.weight = max(rest, color(0.0));
  given.narrow.weight = max(part.narrow.weight + more + min(rest, color(0.0)), color(0.0));
  return given;
}

struct LobeCone {
  vector direction;
  float half_angle;
};

LobeCone wide_cone(MirroredSample mirrored, vector n, float u, float w, float e)
{
  LobeCone cone;
  cone.direction = mirrored.direction;
  cone.half_angle = 0.0;
  vector across = level_across(n, mirrored.direction);
  if (!(mirrored.variance > 0.0 && inner_product(across, across) > 0.0))
    return cone;
  vector along = cross(mirrored.direction, across);
  float off = sqrt(-2.0 * mirrored.variance * logarithm(u));
  float phi = M_2PI * w;
  vector middle = mirrored.direction + mirrored.drift + along * (mirrored.along * off * cos(phi)) +
                  across * (mirrored.across * off * sin(phi));
  vector towards = middle / sqrt(inner_product(middle, middle));
  vector chord = mirrored.direction - towards;
  float square = inner_product(chord, chord) - 2.0 * mirrored.variance * logarithm(e);
  float half = 0.5 * sqrt(square);
  if (!(square < 2.0 && 2.0 * half * sqrt(1.0 - half * half) < inner_product(towards, n)))
    return cone;
  cone.direction = towards;
  cone.half_angle = 2.0 * asin(half);
  return cone;
}
