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
#define STANDS_ASIDE -2

struct SeenLight {
  vector direction;
  float sin2_half_radius;
  int visible;
  float reach;
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

// Of each two lights, found once: of i and k at 8 i + k. Says whether any two are so near that they may share a cone.
int angles_between(SeenLight seen[8], int count, output float between[64])
{
  int near = 0;
  for (int i = 1; i < count; ++i) {
    for (int k = 0; k < i; ++k) {
      float angle = angle_between(seen[i], seen[k]);
      between[8 * i + k] = angle;
      between[8 * k + i] = angle;
      near = near || angle - seen[i].reach < seen[k].reach + LEAST_GAP ||
             angle - seen[k].reach < seen[i].reach + LEAST_GAP;
    }
  }
  return near;
}

float group_reach(SeenLight seen[8], float between[64], int leader[8], int count, int group)
{
  float reach = seen[group].reach;
  for (int i = 0; i < count; ++i) {
    if (leader[i] == group && i != group)
      reach = max(reach, between[8 * group + i] + seen[i].reach);
  }
  return reach;
}

// Here every light is there.
void group_lights(SeenLight seen[8], float between[64], output int leader[8], int count)
{
  int joined = 1;
  while (joined) {
    joined = 0;
    for (int group = 0; group < count && !joined; ++group) {
      if (leader[group] == group) {
        float reach = group_reach(seen, between, leader, count, group) + LEAST_GAP;
        for (int i = 0; i < count && !joined; ++i) {
          if (leader[i] >= 0 && leader[i] != group &&
              between[8 * group + i] - seen[i].reach < reach) {
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

void admit_melting(output SeenLight seen[8], float between[64], output int leader[8], int count, float turned)
{
  for (int i = 0; i < count; ++i) {
    if (seen[i].breadth > 0.0 && leader[i] == STANDS_ASIDE) {
      float gap = M_PI;
      for (int k = 0; k < count; ++k) {
        if (k != i && (leader[k] == k || leader[k] == STANDS_ASIDE)) {
          float reach = seen[k].reach;
          if (leader[k] == k)
            reach = group_reach(seen, between, leader, count, k);
          gap = min(gap, between[8 * i + k] - reach);
        }
      }
      seen[i].apart = clamp((gap - seen[i].reach - LEAST_GAP) / MELTING_GAP, 0.0, 1.0);
      if (sparkling_share(seen[i].breadth, seen[i].apart, turned) > 0.0)
        leader[i] = i;
    }
  }
}
