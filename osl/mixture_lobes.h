// SPDX-License-Identifier: Apache-2.0
//
// The mixture's lobes as closures: see core/mixture.h and core/diffuse_lobe.h.
#pragma once

#include "stdcycles.h"
#include "diffuse_lobe.h"
#include "whole_paint.h"

float sum_of(color c)
{
  return c[0] + c[1] + c[2];
}

// What substrate and pigment have scattered, a ramp and its foot; what only flakes have mirrored; and what goes back through
// the holes that it came in by. Each closure takes a twentieth of a sample's time, and all but the ramp show little. So where
// other light is noise anyway (`by_chance`) one of them, drawn by its albedo, stands for all three.
closure color mixture_lobes(Paint paint, Layer layer, Stack stack, vector n, vector view, int by_chance, float deviate)
{
  closure color shown = 0;
  if (paint.composition == COMPOSITION_PUBLISHED)
    shown = stack.diffuse * diffuse(n);
  else {
    color ramp[RAMP_COLORS];
    color foot = color(0.0);
    make_ramp(layer, ramp, foot);
    foot = stack.diffuse * foot;
    shown = stack.diffuse * diffuse_ramp(n, ramp);

    int glossy = 1;
    int returned = paint.depth_model == DEPTH_MODEL_CORRELATED;
    int bent = 1;
    float share = 1.0;  // of the lobe that is drawn
    if (by_chance) {
      float of_glossy = sum_of(stack.glossy);
      float of_returned = sum_of(stack.returned);
      float all = of_glossy + of_returned + sum_of(foot);
      float lot = deviate * all;
      glossy = lot < of_glossy;
      returned = !glossy && lot < of_glossy + of_returned;
      bent = !glossy && !returned && foot != color(0.0);
      share = (glossy ? of_glossy : returned ? of_returned : sum_of(foot)) / all;
    }
    color white[RAMP_COLORS] = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
    if (glossy)
      shown += stack.glossy * (stack.glossy_scale / share) * phong_ramp(n, stack.glossy_exponent, white);
    if (returned)
      shown += stack.returned * (stack.returned_scale / share) * phong_ramp(returning_normal(n, view), stack.exponent, white);
    if (bent)
      shown += foot * (FOOT_WEIGHT / share) * diffuse_toon(n, FOOT_SIZE, FOOT_SMOOTH);
  }
  return shown;
}
