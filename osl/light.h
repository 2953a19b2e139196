// SPDX-License-Identifier: Apache-2.0
//
// The lights that sparkle, as seen from a point: see core/light.h.
#pragma once

#include "elementary.h"

#define LIGHT_UNUSED 0
#define LIGHT_PARALLEL 1
#define LIGHT_POSITIONAL 2
#define LEAST_GAP 2e-3

struct SeenLight {
  vector direction;
  float sin2_half_radius;
  int visible;
};

SeenLight see_light(int kind, vector where, float size, point position)
{
  SeenLight seen;
  seen.direction = vector(0.0, 0.0, 1.0);
  seen.sin2_half_radius = 0.0;
  seen.visible = 0;
  if (kind == LIGHT_UNUSED)
    return seen;
  vector towards = where;
  if (kind == LIGHT_POSITIONAL)
    towards = where - vector(position);
  float distance = sqrt(inner_product(towards, towards));
  if (!(distance > 0.0))
    return seen;
  seen.visible = 1;
  seen.direction = towards / distance;
  float sine = size;
  if (kind == LIGHT_POSITIONAL)
    sine = size / distance;
  sine = clamp(sine, 0.0, 1.0);
  seen.sin2_half_radius = 0.5 * (sine * sine / (1.0 + sqrt((1.0 - sine) * (1.0 + sine))));
  return seen;
}

int lights_overlap(SeenLight a, SeenLight b)
{
  vector chord = a.direction - b.direction;
  float sine = sqrt(a.sin2_half_radius) * sqrt(1.0 - b.sin2_half_radius) +
               sqrt(b.sin2_half_radius) * sqrt(1.0 - a.sin2_half_radius);
  float reach = 2.0 * sine + LEAST_GAP;
  return inner_product(chord, chord) < reach * reach;
}
