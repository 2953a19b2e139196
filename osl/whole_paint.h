// SPDX-License-Identifier: Apache-2.0
//
// The stack of the paint at a pixel: the coat over the flakes over what is scattered several times. See core/whole_paint.h.
#pragma once

#include "composition.h"
#include "layer.h"
#include "mixture.h"
#include "orange_peel.h"
#include "passage.h"
#include "phong_lobe.h"
#include "texture.h"

struct Stack {
  Coat coat;
  vector coat_normal;
  float coat_alpha;
  float facets;
  color diffuse;
  color glossy;
  color returned;
  float alpha;
  float exponent;
  float glossy_exponent;
  float glossy_scale;
  float returned_scale;
  float texture;
};

// What no light has a part in.
Stack make_stack(Paint given, Layer layer, float library[], SurfacePoint surface, vector given_coat_n,
                 int frame)
{
  Stack stack;
  vector n = surface.n;
  float cos_view = seen_cosine(n, surface.view);
  stack.coat = make_coat(cos_view, given.coat_roughness, layer.eta);
  stack.coat_alpha = given.coat_roughness * given.coat_roughness;
  stack.facets = 0.0;
  if (given.composition == COMPOSITION_PUBLISHED) {
    stack.facets = facet_reflectance(cos_view, given.coat_roughness, layer.eta);
    if (stack.coat_alpha > 0.0)
      stack.coat.reflected = stack.facets;
  }
  // A coat whose normal is bent reflects elsewhere, and as much; so it lets as much through.
  float cos_below = cos_view;
  if (surface.bends) {
    cos_below = seen_cosine(n, surface.below);
    float passed = fresnel_transmittance(cos_view, eta_cos_refracted(cos_view, layer.eta), layer.eta);
    float below = fresnel_transmittance(cos_below, eta_cos_refracted(cos_below, layer.eta), layer.eta);
    stack.coat.rest = stack.coat.rest * (passed / max(below, 1e-20));
  }
  vector coat_n = given_coat_n;
  if (given.orange_peel > 0.0)
    coat_n = orange_peel(coat_n, surface.waves, given.orange_peel);
  if (inner_product(coat_n, n) < 0.999999)
    coat_n = above_surface(coat_n, n, surface.view);
  stack.coat_normal = coat_n;

  Mixture scattered = mixture(layer, library, surface.areas, surface.slant, given.substrate_color, cos_below);
  stack.diffuse = scattered.diffuse_albedo;
  stack.glossy = scattered.glossy_albedo;
  stack.returned = scattered.returned_albedo;
  stack.alpha = scattered.alpha;
  stack.exponent = scattered.exponent;
  stack.returned_scale = 1.0 / scattered.above;
  stack.glossy_exponent = glossy_exponent(scattered.alpha);
  stack.glossy_scale = 1.0 / phong_albedo(cos_view, stack.glossy_exponent);
  // What the sparkles outshine is Lambertian, as published.
  if (given.composition == COMPOSITION_PUBLISHED) {
    stack.diffuse = stack.diffuse + stack.glossy + stack.returned;
    stack.glossy = color(0.0);
    stack.returned = color(0.0);
  }
  stack.texture = 1.0;
  if (given.texture_contrast > 0.0)
    stack.texture = texture_at(layer, surface, given.texture_contrast, frame, given.seed);
  stack.diffuse = stack.diffuse * stack.texture;
  stack.glossy = stack.glossy * stack.texture;
  stack.returned = stack.returned * stack.texture;
  return stack;
}

vector returning_normal(vector n, vector view)
{
  vector sum = view + n * LEAN;
  return sum * (1.0 / sqrt(inner_product(sum, sum)));
}
