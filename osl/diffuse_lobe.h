// SPDX-License-Identifier: Apache-2.0
//
// What light at each angle adds to the diffuse lobe: see core/diffuse_lobe.h.
#pragma once

#include "layer.h"
#include "mixture.h"
#include "refraction.h"

#define RAMP_COLORS 8

color by_slant(Layer layer)
{
  color absorption = max(layer.binder_depth - color(layer.rayleigh_depth), color(0.0));
  float per_flakes = 2.0 * (1.0 - 1.09 * glossy_roughness(layer));
  return layer.shared_blocking * per_flakes - absorption * 1.5;
}

color let_in(float cosine, float eta, color slanted)
{
  float g = eta_cos_refracted(cosine, eta);
  float slant = 1.0 - g / eta;
  float entering = cosine * fresnel_transmittance(cosine, g, eta);
  color z = min(slanted * slant, color(1.0));
  return color(entering) / (color(1.0) - z * (color(1.0) - z * 0.5));
}

// Of diffuse_toon; the weight is 2 (1 - cos) of its outer angle for what shows 1.
#define FOOT_SIZE 0.908742103
#define FOOT_SMOOTH 0.045746299
#define FOOT_WEIGHT (13.0 / 7.0)
#define FOOT_ALBEDO 1.785622032

// Written out: OSL folds no loop.
void make_ramp(Layer layer, output color ramp[RAMP_COLORS], output color foot)
{
  float eta = layer.eta;
  color slanted = by_slant(layer);
  color first = let_in(1.0 / 14.0, eta, slanted) * 1.94;
  color end = let_in(1.0 / 7.0, eta, slanted) * 0.97;
  color bent = max(end - first, color(0.0));
  color second = max(let_in(2.0 / 7.0, eta, slanted) - bent, color(0.0));
  color third = max(let_in(3.0 / 7.0, eta, slanted) - bent, color(0.0));
  color fourth = max(let_in(4.0 / 7.0, eta, slanted) - bent, color(0.0));
  color fifth = max(let_in(5.0 / 7.0, eta, slanted) - bent, color(0.0));
  color sixth = max(let_in(6.0 / 7.0, eta, slanted) - bent, color(0.0));
  color last = max(let_in(1.0, eta, slanted) - bent, color(0.0));
  color mean = (first + second + third + fourth + fifth + sixth) * (2.0 / 7.0) + last * (1.0 / 7.0) + bent * FOOT_ALBEDO;
  ramp[0] = color(0.0);
  ramp[1] = first / mean;
  ramp[2] = second / mean;
  ramp[3] = third / mean;
  ramp[4] = fourth / mean;
  ramp[5] = fifth / mean;
  ramp[6] = sixth / mean;
  ramp[7] = last / mean;
  foot = bent / mean;
}
