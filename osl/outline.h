// SPDX-License-Identifier: Apache-2.0
//
// The outline of a flat light in the domain of normals: see core/outline.h for the derivation.
#pragma once

#include "light.h"
#include "orientation.h"
#include "refraction.h"

struct Outline {
  int given;
  float sin2_half_beta[4];
  float weight[4];
  float inside;
};

#define OF_FOUR 0.707106781186547524401
#define OF_EIGHT 0.459700843380983, 0.888073833977115

void points_within(SeenLight light, float radii, int between, output vector towards[4], output float part[4])
{
  vector m = light.facing;
  float sign = m[2] < 0.0 ? -1.0 : 1.0;
  float a = -1.0 / (sign + m[2]);
  float b = m[0] * m[1] * a;
  float off = radii * light.radius;
  vector u = vector(1.0 + sign * m[0] * m[0] * a, sign * b, -(sign * m[0])) * off;
  vector v = vector(b, sign + m[1] * m[1] * a, -m[1]) * off;
  if (between) {
    vector turned = (u + v) * OF_FOUR;
    v = (v - u) * OF_FOUR;
    u = turned;
  }
  towards[0] = light.direction + u;
  towards[1] = light.direction - u;
  towards[2] = light.direction + v;
  towards[3] = light.direction - v;
  for (int i = 0; i < 4; ++i) {
    float square = inner_product(towards[i], towards[i]);
    float distance = sqrt(square);
    part[i] = 1.0 / (square * distance);
    towards[i] = towards[i] * (1.0 / distance);
  }
}

Outline outline_of(SeenLight light, Mirror middle, float inside, vector n, vector view, float eta)
{
  Outline outline;
  outline.given = 1;
  outline.inside = inside;
  vector towards[4];
  float part[4];
  points_within(light, OF_FOUR, 0, towards, part);
  float seen = 0.0;
  for (int i = 0; i < 4; ++i) {
    seen = seen + part[i];
    outline.sin2_half_beta[i] = 0.0;
    outline.weight[i] = 0.0;
    Mirror mirror = mirror_between(n, view, towards[i], eta);
    if (mirror.possible) {
      outline.sin2_half_beta[i] = mirror.sin2_half_beta;
      outline.weight[i] = part[i] * solid_angle_ratio(mirror.cos_light, mirror.g_light, eta) / mirror.cos_alpha;
    }
  }
  float whole = seen * solid_angle_ratio(middle.cos_light, middle.g_light, eta) / middle.cos_alpha;
  for (int i = 0; i < 4; ++i)
    outline.weight[i] = outline.weight[i] / whole;
  return outline;
}

float outline_factor(OrientationDensity density, Outline outline, float middle, float sin2_half_rho)
{
  float found = 0.0;
  for (int i = 0; i < 4; ++i) {
    if (outline.weight[i] > 0.0)
      found = found + outline.weight[i] * orientation_density(density, outline.sin2_half_beta[i]);
  }
  float r = 0.5 * sin2_half_rho;
  float aside = middle + r - 2.0 * middle * r;
  float along = 2.0 * sqrt(middle * (1.0 - middle) * r * (1.0 - r));
  float even = 0.0;
  if (aside < 0.5)
    even = even + 2.0 * orientation_density(density, aside);
  if (aside + along < 0.5)
    even = even + orientation_density(density, aside + along);
  if (aside - along < 0.5)
    even = even + orientation_density(density, max(aside - along, 0.0));
  if (!(even > 0.0))
    return 1.0;
  return clamp(found / (0.25 * even), 0.5, 2.0);
}
