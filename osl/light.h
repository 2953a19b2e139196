// SPDX-License-Identifier: Apache-2.0
//
// The lights that sparkle, as seen from a point: see core/light.h.
#pragma once

#include "choices.h"
#include "elementary.h"

#define LEAST_GAP 2e-3
#define SKY_REACH 0.02
#define WIDEST_SINE 0.5
#define MELTING_GAP 0.05

struct SeenLight {
  vector direction;
  float sin2_half_radius;
  int visible;
  float reach;
  float widest;
  float breadth;
  float apart;
  vector facing;
  float radius;
  int own_cone;  // the light and what lies about it share one cone, which all other light leaves out
};

float sparkling_share(float breadth, float apart, float turned)
{
  float width = breadth / min(turned, 0.8 * WIDEST_SINE);
  return apart * clamp(2.5 - 2.0 * width, 0.0, 1.0);
}

float sin2_of_flat_light(float t2, float c)
{
  return c * t2 / (1.0 + t2 * (0.25 * c + 0.125 * (15.0 * c * c - 9.0)));
}

float sin2_half_of(float sine)
{
  return 0.5 * (sine * sine / (1.0 + sqrt((1.0 - sine) * (1.0 + sine))));
}

float angle_of_half_chord(float half_chord)
{
  return M_PI - 2.0 * arccosine(half_chord);
}

SeenLight see_light(int kind, vector where, float size, vector facing, point position)
{
  SeenLight seen;
  seen.direction = vector(0.0, 0.0, 1.0);
  seen.sin2_half_radius = 0.0;
  seen.visible = 0;
  seen.reach = 0.0;
  seen.widest = M_PI_2;
  seen.breadth = 0.0;
  seen.apart = 1.0;
  seen.facing = vector(0.0);
  seen.radius = 0.0;
  seen.own_cone = kind == LIGHT_AREA || kind == LIGHT_SKY;
  if (kind == LIGHT_UNUSED)
    return seen;
  vector towards = where;
  if (kind == LIGHT_POSITIONAL || kind == LIGHT_AREA)
    towards = where - vector(position);
  float distance = sqrt(inner_product(towards, towards));
  if (!(distance > 0.0))
    return seen;
  seen.direction = towards / distance;
  float sine = size;
  if (kind == LIGHT_POSITIONAL)
    sine = size / distance;
  sine = clamp(sine, 0.0, 1.0);
  float reach = sine;
  if (kind == LIGHT_SKY)
    reach = max(sine, SKY_REACH);
  if (kind == LIGHT_AREA) {
    float extent = sqrt(inner_product(facing, facing));
    if (!(extent > 0.0))
      return seen;
    float cosine = -inner_product(facing, seen.direction) / extent;
    reach = max(extent, size) / distance;
    if (!(cosine > 0.0) || !(reach < WIDEST_SINE))
      return seen;
    float radius = size / distance;
    sine = sqrt(sin2_of_flat_light(radius * radius, min(cosine, 1.0)));
    seen.breadth = reach;
    seen.facing = facing / extent;
    seen.radius = radius;
  }
  seen.visible = 1;
  seen.sin2_half_radius = sin2_half_of(sine);
  seen.reach = angle_of_half_chord(sqrt(sin2_half_of(reach)));
  return seen;
}

float angle_between(SeenLight a, SeenLight b)
{
  vector chord = a.direction - b.direction;
  return angle_of_half_chord(min(0.5 * sqrt(inner_product(chord, chord)), 1.0));
}

void share_cones(output SeenLight seen[8], output int leader[8], int count, float turned)
{
  for (int i = 1; i < count; ++i) {
    for (int k = 0; k < i; ++k) {
      if (leader[i] == i && leader[k] == k && seen[i].breadth == 0.0 && seen[k].breadth == 0.0) {
        float angle = angle_between(seen[i], seen[k]);
        if (angle - seen[i].reach < seen[k].reach + LEAST_GAP) {
          leader[i] = k;
          seen[k].reach = max(seen[k].reach, angle + seen[i].reach);
        }
      }
    }
  }
  for (int i = 0; i < count; ++i) {
    if (leader[i] == i) {
      float gap = M_PI;
      for (int k = 0; k < count; ++k) {
        if (k != i && leader[k] != i)
          gap = min(gap, angle_between(seen[i], seen[k]) - seen[k].reach - seen[i].reach);
      }
      seen[i].widest = seen[i].reach + max(gap, 0.0) / 2.0;
      if (seen[i].breadth > 0.0)
        seen[i].apart = clamp((gap - LEAST_GAP) / MELTING_GAP, 0.0, 1.0);
    }
  }
  for (int i = 0; i < count; ++i) {
    if (seen[i].breadth > 0.0 && !(sparkling_share(seen[i].breadth, seen[i].apart, turned) > 0.0))
      leader[i] = -1;
  }
}
