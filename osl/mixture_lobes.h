// SPDX-License-Identifier: Apache-2.0
//
// The mixture's lobes as closures: see scattered_by() in core/whole_paint.h.
#pragma once

#include "stdcycles.h"
#include "diffuse_lobe.h"
#include "whole_paint.h"

// What substrate and pigment have scattered is a ramp and its foot; then there is what only flakes have mirrored, and what goes
// back through the hole that it came in by. Each closure takes a twentieth of a sample's time, and all but the ramp are little
// light. So in a scene of uneven light (`by_chance`) one of the three, drawn by its albedo, stands for all: under listed lights
// too.
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

    float of_glossy = stack.glossy[0] + stack.glossy[1] + stack.glossy[2];
    float of_foot = FOOT_ALBEDO * (foot[0] + foot[1] + foot[2]);
    float of_returned = stack.returned[0] + stack.returned[1] + stack.returned[2];
    float of_all = of_glossy + of_foot + of_returned;
    float at = deviate * of_all;
    color white[RAMP_COLORS] = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
    shown = stack.diffuse * diffuse_ramp(n, ramp);
    if (!by_chance || at < of_glossy) {
      float scale = by_chance ? of_all / of_glossy : 1.0;
      shown += stack.glossy * (stack.glossy_scale * scale) * phong_ramp(n, stack.glossy_exponent, white);
    }
    if (!by_chance || (at >= of_glossy && at < of_glossy + of_foot)) {
      float scale = by_chance ? of_all / of_foot : 1.0;
      shown += foot * (FOOT_WEIGHT * scale) * diffuse_toon(n, FOOT_SIZE, FOOT_SMOOTH);
    }
    if (paint.depth_model == DEPTH_MODEL_CORRELATED && of_returned > 0.0 &&
        (!by_chance || at >= of_glossy + of_foot)) {
      float scale = by_chance ? of_all / of_returned : 1.0;
      shown += stack.returned * (stack.returned_scale * scale) *
               phong_ramp(returning_normal(n, view), stack.exponent, white);
    }
  }
  return shown;
}
