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

float angular_radius(SeenLight light)
{
  return M_PI - 2.0 * arccosine(sqrt(light.sin2_half_radius));
}

float angle_between(SeenLight a, SeenLight b)
{
  vector chord = a.direction - b.direction;
  float half_chord = min(0.5 * sqrt(inner_product(chord, chord)), 1.0);
  return M_PI - 2.0 * arccosine(half_chord);
}

float group_reach(SeenLight seen[8], int leader[8], int count, int group)
{
  float reach = angular_radius(seen[group]);
  for (int i = 0; i < count; ++i) {
    if (leader[i] == group && i != group)
      reach = max(reach, angle_between(seen[group], seen[i]) + angular_radius(seen[i]));
  }
  return reach;
}

// `leader` arrives as leader[i] = i: here every light is there.
void group_lights(SeenLight seen[8], output int leader[8], int count)
{
  int joined = 1;
  while (joined) {
    joined = 0;
    for (int group = 0; group < count && !joined; ++group) {
      if (leader[group] == group) {
        float reach = group_reach(seen, leader, count, group) + LEAST_GAP;
        for (int i = 0; i < count && !joined; ++i) {
          if (leader[i] != group &&
              angle_between(seen[group], seen[i]) - angular_radius(seen[i]) < reach) {
            int first = min(group, leader[i]);
            int second = max(group, leader[i]);
            for (int k = 0; k < count; ++k) {
              if (leader[k] == second)
                leader[k] = first;
            }
            joined = 1;
          }
        }
      }
    }
  }
}
