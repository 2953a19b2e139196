// SPDX-License-Identifier: Apache-2.0
//
// What the paint shows, as closures: the flakes under the listed lights and under all other light, and the coat over them.
#pragma once

#include "stdcycles.h"
#include "cones.h"
#include "flake_lobe.h"
#include "footprint.h"
#include "smooth_part.h"
#include "sparkles.h"
#include "whole_paint.h"

// The sparkles that the pixel has under each listed light. Where they outshine the rest of the paint, as published, what they
// add to it.
void draw_listed(Paint paint, Layer layer, float library[], SurfacePoint surface, Stack stack, FirstFlake firsts[SPECIES],
                 SeenLight seen[8], int slot[8], int leader[8], int lights, int flat, int frame, int blurred,
                 output PixelSparkles drawn[8])
{
  Cell cell = cell_of_counts(layer, surface, firsts, frame, paint.seed);
  for (int i = 0; i < lights; ++i) {
    if (leader[i] != i)
      continue;
    SeenLight light = seen[i];
    Passage way = pass_between(layer, library, surface, light, flat);
    PixelSparkles here = sparkle(layer, library, surface, firsts, cell, way, flat, slot[i], frame, paint.seed, blurred);
    if (paint.composition == COMPOSITION_PUBLISHED) {
      float cos_light = max(inner_product(surface.n, light.direction), 0.0);
      float shine = highlight(stack.coat_normal, surface.view, light.direction, light.sin2_half_radius, stack.coat_alpha,
                              stack.facets);
      here.radiance = greatest(here.radiance, stack.diffuse * (cos_light / M_PI) + color(shine / stack.coat.rest));
    }
    drawn[i] = here;
  }
}

// The lobes beside the listed lights: they lean away from those of which they would show more than the sparkles, which is said
// in `lean`, and `shown` is what of them may be shown. The sparkles lose what the lobes show. Once the lobes lean away from a
// light, what they show of each is another: so twice.
void lobes_beside_listed(Layer layer, SurfacePoint surface, Stack stack, SeenLight seen[8], int leader[8], int lights, int flat,
                         output SmoothPart parts[SPECIES], output PixelSparkles drawn[8], output color shown, output int lean)
{
  color in_lobes[8];
  for (int again = 0; again <= lean; ++again) {
    shown = color(1.0);
    for (int i = 0; i < lights; ++i) {
      if (leader[i] != i)
        continue;
      in_lobes[i] = smooth_sparkles(layer, parts, seen[i], flat);
      color around = stack.diffuse * (max(inner_product(surface.n, seen[i].direction), 0.0) / M_PI);
      color may = may_show(in_lobes[i], drawn[i].radiance, around);
      shown = min(shown, may);
      float fall = fall_for(may);
      if (again == 0 && fall > 0.0) {
        lean = 1;
        for (int k = 0; k < layer.species; ++k) {
          SmoothPart part = parts[k];
          parts[k] = lean_away(part, surface.view, seen[i].direction, fall);
        }
      }
    }
  }
  for (int i = 0; i < lights; ++i) {
    if (leader[i] == i)
      drawn[i].radiance = max(drawn[i].radiance - shown * in_lobes[i], color(0.0));
  }
  for (int i = 0; i < layer.species; ++i) {
    SmoothPart part = parts[i];
    part.narrow.weight = part.narrow.weight * shown;
    part.wide.weight = part.wide.weight * shown;
    parts[i] = part;
  }
}

// A listed light's cone holds it, and no other listed light.
float listed_cone(float reach, float widest, int own_cone, color radiance)
{
  float least = min(reach + CONE_MARGIN, M_PI_2);
  return cone_half_angle((radiance[0] + radiance[1] + radiance[2]) / 3.0, least, own_cone ? least : widest);
}

closure color listed_sparkles(PixelSparkles drawn[8], vector view, SeenLight seen[8], int slot[8], int leader[8], int lights,
                              float u)
{
  closure color shown = 0;
  for (int i = 0; i < lights; ++i) {
    if (leader[i] != i)
      continue;
    color radiance = drawn[i].radiance;
    float rho = listed_cone(seen[i].reach, seen[i].widest, seen[i].own_cone, radiance);
    shown += sparkle_cone(radiance, view, seen[i].direction, rho, mod(u + slot[i] * 0.618034, 1.0));
  }
  return shown;
}

// Drawn anew for each sample.
struct SampleDeviates {
  float u;  // of a random flake
  float w;
  vector other;
};

// A random flake is drawn by the place in the pixel, which Cycles spreads evenly over a pixel's samples. The place is turned
// and stretched by whole numbers: so draws are even to 0.7 % under Blender's default filter too, whose Fourier transform at
// (2, 1) is that small. In mirrors, glass and panoramas, where the place need not spread over a pixel, the hash draws alone.
// Of 32 frames and seeds no two draw alike; a stream's key would be hashed anew for each sample, since OSL folds no noise.
SampleDeviates sample_deviates(Pixel pixel, int frame, int seed)
{
  float x = pixel.raster[0] - floor(pixel.raster[0]);
  float y = pixel.raster[1] - floor(pixel.raster[1]);
  vector of_pixel = vector(wrapped(pixel.x), wrapped(pixel.y), 131072.0 * (frame & 31));
  vector of_sample = of_pixel + vector(0.0, 0.0, 1.0 + floor(65536.0 * x));
  float of_seed = 131072.0 * (seed & 31);
  float word = of_seed + floor(65536.0 * y);
  SampleDeviates drawn;
  drawn.other = uniform_deviates(of_sample, word);
  vector key = of_sample;
  if (pixel.projects) {
    // Finer than the place's own digits.
    drawn.u = 2.0 * x + y + drawn.other[0] / 2048.0;
    drawn.w = 2.0 * y - x + 1.0 + drawn.other[1] / 2048.0;
    key = of_pixel;
    word = of_seed;
  }
  else {
    drawn.u = 0.0;
    drawn.w = 0.0;
    word = word + 65536.0;
  }
  drawn.u = drawn.u + uniform_deviate(key[0], key[1], key[2], word);
  drawn.w = drawn.w + uniform_deviate(key[2], key[0], word, key[1]);
  return drawn;
}

// So many random flakes under all light but the listed. Beside lobes (`smooth`) they show what those leave; what the lobes have
// too little or too much of is given to them. `is_finite`: whether all of this is a number.
closure color random_flakes(Layer layer, float library[], SurfacePoint surface, FirstFlake firsts[SPECIES], SeenLight seen[8],
                            int lights, int flakes, int smooth, float rise, SampleDeviates drawn,
                            output SmoothPart parts[SPECIES], output int is_finite)
{
  closure color shown = 0;
  color more[SPECIES] = {color(0.0), color(0.0), color(0.0)};
  color less[SPECIES] = {color(0.0), color(0.0), color(0.0)};
  for (int k = 0; k < flakes; ++k) {
    float on = (float)k / flakes;  // deviates evenly apart
    MirroredSample mirrored =
        sample_flake(layer, library, surface, firsts, inside_unit(mod(drawn.u + on, 1.0)), mod(drawn.w + 2.0 * on, 1.0), rise);
    if (smooth) {
      SmoothPart part = parts[mirrored.species];
      color given = leave_beside(mirrored, part, surface.n, surface.view) / flakes;
      mirrored.weight = mirrored.weight / flakes;
      more[mirrored.species] += max(given, color(0.0));
      less[mirrored.species] += min(given, color(0.0));
    }
    if (!(mirrored.weight[0] + mirrored.weight[1] + mirrored.weight[2] > 0.0))
      continue;
    LobeCone wide = wide_cone(mirrored, surface.n, inside_unit(mod(drawn.other[0] + on, 1.0)), mod(drawn.other[1] + on, 1.0),
                              inside_unit(mod(drawn.other[2] + on, 1.0)));
    if (surface.bends) {
      mirrored.direction = back_through_wave(mirrored.direction, surface.n, surface.wave, layer.eta);
      wide.direction = back_through_wave(wide.direction, surface.n, surface.wave, layer.eta);
    }
    shown += mirrored_cone(mirrored, wide, surface.view, seen, lights);
    is_finite = is_finite && isfinite(mirrored.weight[0]) && isfinite(mirrored.direction[0]);
  }
  if (smooth) {
    for (int i = 0; i < layer.species; ++i) {
      SmoothPart part = parts[i];
      parts[i] = give_to_lobes(part, more[i], less[i]);
    }
  }
  return shown;
}

closure color smooth_lobes(SmoothPart parts[SPECIES], int species)
{
  closure color shown = 0;
  for (int i = 0; i < species; ++i) {
    SmoothPart part = parts[i];
    for (int k = 0; k < 2; ++k) {
      Facets facets = part.narrow;
      if (k == 1)
        facets = part.wide;
      if (facets.weight[0] + facets.weight[1] + facets.weight[2] > 0.0)
        shown += facets.weight * microfacet("beckmann", facets.facing, facets.along, facets.alpha_x, facets.alpha_y, 0.0, 0);
    }
  }
  return shown;
}

// `met`: see mirror().
closure color coat_reflection(Paint paint, Stack stack, vector view, SeenLight seen[8], int lights, int met)
{
  closure color shown = 0;
  if (!(stack.coat_alpha > 0.0))
    shown = mirror(stack.coat_normal, view, seen, lights, met);
  else if (paint.composition == COMPOSITION_PUBLISHED)
    // The sparkles were compared with this one.
    shown = microfacet("ggx", stack.coat_normal, vector(0.0), stack.coat_alpha, stack.coat_alpha, 0.0, 0);
  else
    // Cycles scales these GGX facets so that they reflect all, whatever their alpha.
    shown = microfacet_multi_ggx_aniso(stack.coat_normal, vector(0.0), stack.coat_alpha, stack.coat_alpha, color(1.0));
  return shown;
}
