// SPDX-License-Identifier: Apache-2.0
//
// A light's sparkles as a closure: see core/cones.h. Cycles' glossy_toon about the mirror direction, of half-angle rho, has
// the value 1/(2 pi (1 - cos rho)) inside, so the weight T 4 pi sin^2(rho/2) gives the radiance T E_n.
#pragma once

#include "stdcycles.h"
#include "composition.h"
#include "diffuse_lobe.h"
#include "flake_lobe.h"
#include "light.h"
#include "random.h"

#define LEAST_WEIGHT 1.1e-5
// Half-angle margin to the edge of a light: half of LEAST_GAP.
#define CONE_MARGIN 1e-3
#define NARROW_CONE 0.02
#define WIDEST_CONE 0.5
#define IMAGE_EXPONENT 1e5
#define IMAGE_REACH 0.012
#define IMAGE_PICKED 10.0
#define LEAST_COSINE_OF_IMAGE 0.05

float cone_half_angle(float average, float least, float most)
{
  float wanted = 2.0 * asin(sqrt(min(2.0 * LEAST_WEIGHT / (4.0 * M_PI * max(average, 1e-30)), 0.5)));
  float mirror = 2.0 * asin(sqrt(1.0 / (4.0 * M_PI * max(average, 1.0))));
  float rho = clamp(max(wanted, min(NARROW_CONE, mirror)), least, max(most, least));
  return min(rho, max(WIDEST_CONE, least));
}

float cone_solid_angle(float rho)
{
  float s = sin(0.5 * rho);
  return 4.0 * M_PI * s * s;
}

float cone_roulette(float average, float solid_angle)
{
  return average * solid_angle / LEAST_WEIGHT;
}

closure color sparkle_cone(color radiance, vector view, vector direction, float rho, float deviate)
{
  closure color none = 0;
  float average = (radiance[0] + radiance[1] + radiance[2]) / 3.0;
  if (!(average > 0.0))
    return none;
  float solid_angle = cone_solid_angle(rho);
  color weight = radiance * solid_angle;
  float keep = cone_roulette(average, solid_angle);
  if (keep < 1.0) {
    if (deviate > keep)
      return none;
    weight = weight / keep;
  }
  return weight * glossy_toon(normalize(view + direction), rho / M_PI_2, 0.0);
}

// What one random flake shows of all light but the listed, whose sparkles have cones of their own: a wide cone, unless it
// holds a listed light; else a narrow one about the flake's own direction, or a mirror at the edge of a listed light, and
// within one only what has melted of it.
closure color mirrored_cone(MirroredSample mirrored, LobeCone wide, vector view, SeenLight seen[8], int lights)
{
  closure color none = 0;
  float rho = mirrored.spread;
  float left = 1.0;
  int is_wide = wide.half_angle > rho;
  SeenLight towards;
  towards.direction = mirrored.direction;
  SeenLight middle;
  middle.direction = wide.direction;
  for (int i = 0; i < lights; ++i) {
    float share = sparkling_share(seen[i].breadth, seen[i].apart, mirrored.turned);
    if (share > 0.0) {
      float reach = seen[i].reach + CONE_MARGIN;
      float off = angle_between(towards, seen[i]) - reach;
      // Where the light's cone is its own, that ends where this begins.
      if (off <= (seen[i].own_cone ? 0.0 : -CONE_MARGIN))
        left = left * (1.0 - share);
      rho = min(rho, fabs(off));
      if (angle_between(middle, seen[i]) - reach < wide.half_angle)
        is_wide = 0;
    }
  }
  if (!(left > 0.0))
    return none;
  vector direction = mirrored.direction;
  if (is_wide) {
    direction = wide.direction;
    rho = wide.half_angle;
  }
  vector half = normalize(view + direction);
  if (rho < CONE_MARGIN)
    return left * mirrored.weight * reflection(half);
  return left * mirrored.weight * glossy_toon(half, rho / M_PI_2, 0.0);
}

// A coat without roughness. No sampling of lamps finds what a mirror shows, so where that is a listed light, a cone about
// the light shows it instead, and beside it what the mirror shows: where the image is wider than the light (LEAST_IMAGE) by
// what the cone leaves. Of lights that overlap the first decides. What melts may have corners: rays find it.
// A coat shows a twentieth, so rays are seldom sent there, and a lamp's image is the noise of a whole picture. Where a ray
// meets the image of what melts, a lobe of 3 mrad takes the mirror's place: Cycles picks phong_ramp by its weight alone, so
// with a weight so many times as great and colours as much darker the ray is sent as many times as often. Not beside a light
// that has a cone, which the lobe would show again; nor where no light melts or rays do not meet all lamps (`met` is 0), of
// which the lobe would show fireflies.
closure color mirror(vector n, vector view, SeenLight seen[8], int lights, int met)
{
  closure color shown = 0;
  float left = 1.0;  // of the mirror
  int image = 0;  // of what melts
  int coned = 0;  // of what has a cone
  int shows[8];
  vector mirrored = n * (2.0 * inner_product(n, view)) - view;
  SeenLight towards;
  towards.direction = mirrored;
  for (int i = 0; i < lights; ++i) {
    shows[i] = 0;
    float radiance = highlight(n, view, seen[i].direction, seen[i].sin2_half_radius, 0.0, 1.0);
    if (radiance > 0.0 && seen[i].breadth == 0.0) {
      float rho = angle_of_half_chord(sqrt(seen[i].sin2_half_radius)) + CONE_MARGIN;
      vector off = mirrored - seen[i].direction;
      int alone = 1;
      for (int k = 0; k < i; ++k) {
        if (shows[k] && angle_between(seen[i], seen[k]) - angle_of_half_chord(sqrt(seen[k].sin2_half_radius)) <= rho)
          alone = 0;
      }
      if (alone) {
        shows[i] = 1;
        shown = shown + sparkle_cone(color(radiance), view, seen[i].direction, rho, 0.0);
        left = left - radiance * cone_solid_angle(rho);
      }
      // A ray there would meet the light a second time.
      if (inner_product(off, off) < rho * rho)
        left = 0.0;
    }
    if (met && angle_between(towards, seen[i]) < seen[i].reach + IMAGE_REACH) {
      if (seen[i].breadth > 0.0)
        image = 1;
      else
        coned = 1;
    }
  }
  float cosine = inner_product(n, view);
  if (image && !coned && left > 0.0 && cosine > LEAST_COSINE_OF_IMAGE) {
    // The lobe's integral over the lights is the cosine (core/phong_lobe.h).
    color dark = color(1.0 / IMAGE_PICKED);
    color ramp[RAMP_COLORS] = {dark, dark, dark, dark, dark, dark, dark, dark};
    shown = shown + left * IMAGE_PICKED / cosine * phong_ramp(n, IMAGE_EXPONENT, ramp);
  }
  else if (left > 0.0)
    shown = shown + left * reflection(n);
  return shown;
}
