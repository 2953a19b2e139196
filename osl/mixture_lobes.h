// SPDX-License-Identifier: Apache-2.0
//
// The mixture's lobes as closures: see scattered_by() in core/whole_paint.h.
#pragma once

#include "stdcycles.h"
#include "diffuse_lobe.h"
#include "whole_paint.h"

// What substrate and pigment have scattered is a ramp and its foot; then there is what only flakes have mirrored, and what goes
// back through the hole that it came in by. Each closure takes a twentieth of a sample's time, and the foot and what goes back
// are little light. So in a scene of uneven light (`by_chance`) one of these two, drawn by its albedo, stands for both: under
// listed lights too.
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

    int shows_foot = 1;
    int shows_returned = paint.depth_model == DEPTH_MODEL_CORRELATED;
    float share = 1.0;  // the probability of what is shown
    if (by_chance && shows_returned) {
      float of_returned = stack.returned[0] + stack.returned[1] + stack.returned[2];
      float of_foot = FOOT_ALBEDO * (foot[0] + foot[1] + foot[2]);
      share = of_returned / max(of_returned + of_foot, 1e-30);
      if (deviate < share)
        shows_foot = 0;
      else {
        shows_returned = 0;
        share = 1.0 - share;
      }
    }
    color white[RAMP_COLORS] = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
    shown = stack.diffuse * diffuse_ramp(n, ramp);
    shown += stack.glossy * stack.glossy_scale * phong_ramp(n, stack.glossy_exponent, white);
    if (shows_foot)
      shown += foot * (FOOT_WEIGHT / share) * diffuse_toon(n, FOOT_SIZE, FOOT_SMOOTH);
    if (shows_returned)
      shown += stack.returned * (stack.returned_scale / share) * phong_ramp(returning_normal(n, view), stack.exponent, white);
  }
  return shown;
}
