// SPDX-License-Identifier: Apache-2.0
//
// Inner values, for tests, in the text that has DIAGNOSTICS defined; the one that ships has no such input. AOV nodes write
// nothing under OSL, so they leave as the colour Shown. They are no emission here, because Cycles takes every mesh for a
// lamp whose shader holds that closure.
#pragma once

#define SHOW_PAINT 0
#define SHOW_COUNT 1          // N of the sparkles of light slot DiagnosticLight
#define SHOW_MEAN_COUNT 2     // <N>
#define SHOW_RADIANCE 3       // T, radiance per unit normal irradiance, RGB
#define SHOW_MEAN_RADIANCE 4  // E[T]
#define SHOW_PIXEL 5          // footprint in m2, pixel x, pixel y
#define SHOW_POSITION 6
#define SHOW_NORMAL 7
#define SHOW_VIEW 8           // unit vector to the observer
#define SHOW_RASTER 9         // raster position
#define SHOW_IRRADIANCE 10    // the BSDF: a cone with T = 1, so the picture is the light's irradiance normal to it
#define SHOW_SPARKLES 11      // the BSDF: the sparkles alone, without substrate and highlight
#define SHOW_CONE 12          // solid angle of the cone that carries the sparkles, sr
#define SHOW_SOUND 13         // 1 where every inner value is a finite number, not below zero
#define SHOW_LOBE 14          // the BSDF: the flakes under all other light alone
#define SHOW_DIFFUSE 15       // albedo of the diffuse lobe: substrate and pigment, RGB
#define SHOW_TEXTURE 16       // the factor by which diffuse and glossy lobe fluctuate
#define SHOW_GLOSSY 17        // albedo of the glossy lobe: what flakes mirror more than once, RGB
#define SHOW_ROUGHNESS 18     // alpha of the glossy lobe
#define SHOW_OWN_POSITION 19  // in the own space, m
#define SHOW_OWN_X 20         // its axes in the world
#define SHOW_OWN_Y 21
#define SHOW_OWN_Z 22
#define SHOW_INSTANCE 23
#define SHOW_RETURNED 24      // albedo of the returning lobe: what leaves by the hole that it came in by, RGB
#define SHOW_EXPONENT 25      // of that lobe, and 1 over its share above the surface

int is_sound(float x)
{
  return !(x < 0.0) && !(x > 3e38);  // a comparison with no number is true
}

int is_sound(color x)
{
  return is_sound(x[0]) && is_sound(x[1]) && is_sound(x[2]);
}

// Where main hands its values over, by the names that they have there. Without DIAGNOSTICS these are empty.
#ifdef DIAGNOSTICS

#define ASKED_OWN_SPACE 1
#define ASKED_SMOOTH (Diagnostic != SHOW_SPARKLES && Diagnostic != SHOW_CONE)  // there the sparkles are whole

int is_sound(Facets facets)
{
  return is_sound(facets.weight) && is_sound(inner_product(facets.facing, facets.facing)) &&
         is_sound(inner_product(facets.along, facets.along)) && is_sound(facets.alpha_x) && is_sound(facets.alpha_y);
}

#define DIAGNOSE_PAINT \
  int all_sound = is_finite && is_sound(surface.footprint); \
  closure color irradiance = 0; \
  for (int i = 0; i < lights; ++i) { \
    if (leader[i] == i) { \
      float rho = listed_cone(seen[i].reach, seen[i].widest, seen[i].own_cone, drawn[i].radiance); \
      all_sound = all_sound && is_sound(drawn[i].mean_count) && is_sound(drawn[i].mean_radiance) && \
                  is_sound(drawn[i].count) && is_sound(drawn[i].radiance) && is_sound(rho); \
      if (slot[i] == DiagnosticLight - 1) { \
        if (Diagnostic == SHOW_COUNT) \
          Shown = color(drawn[i].count); \
        else if (Diagnostic == SHOW_MEAN_COUNT) \
          Shown = color(drawn[i].mean_count); \
        else if (Diagnostic == SHOW_RADIANCE) \
          Shown = drawn[i].radiance; \
        else if (Diagnostic == SHOW_MEAN_RADIANCE) \
          Shown = drawn[i].mean_radiance; \
        else if (Diagnostic == SHOW_CONE) \
          Shown = color(cone_solid_angle(rho)); \
        irradiance = sparkle_cone(color(1.0), view, seen[i].direction, \
                                  listed_cone(seen[i].reach, seen[i].widest, seen[i].own_cone, color(1.0)), \
                                  deviates.other[2]); \
      } \
    } \
  } \
  if (smooth) { \
    for (int i = 0; i < flake_layer.species; ++i) { \
      SmoothPart part = parts[i]; \
      all_sound = all_sound && is_sound(part.narrow) && is_sound(part.wide); \
    } \
  } \
  if (Diagnostic == SHOW_PIXEL) \
    Shown = color(surface.footprint, surface.pixel_x, surface.pixel_y); \
  else if (Diagnostic == SHOW_POSITION) \
    Shown = color(position); \
  else if (Diagnostic == SHOW_NORMAL) \
    Shown = color(n); \
  else if (Diagnostic == SHOW_VIEW) \
    Shown = color(view); \
  else if (Diagnostic == SHOW_RASTER) \
    Shown = color(pixel.raster); \
  else if (Diagnostic == SHOW_SOUND) \
    Shown = color(all_sound && is_sound(stack.coat.reflected) && is_sound(stack.coat.rest) && is_sound(stack.diffuse) && \
                  is_sound(stack.glossy) && is_sound(stack.alpha) && is_sound(stack.returned) && is_sound(stack.exponent) && \
                  is_sound(stack.returned_scale) && is_sound(stack.glossy_exponent) && \
                  is_sound(stack.glossy_scale)); \
  else if (Diagnostic == SHOW_DIFFUSE) \
    Shown = stack.diffuse; \
  else if (Diagnostic == SHOW_TEXTURE) \
    Shown = color(stack.texture); \
  else if (Diagnostic == SHOW_GLOSSY) \
    Shown = stack.glossy; \
  else if (Diagnostic == SHOW_ROUGHNESS) \
    Shown = color(stack.alpha); \
  else if (Diagnostic == SHOW_OWN_POSITION) \
    Shown = color(surface.own.position); \
  else if (Diagnostic == SHOW_OWN_X) \
    Shown = color(surface.own.x); \
  else if (Diagnostic == SHOW_OWN_Y) \
    Shown = color(surface.own.y); \
  else if (Diagnostic == SHOW_OWN_Z) \
    Shown = color(surface.own.z); \
  else if (Diagnostic == SHOW_INSTANCE) \
    Shown = color(surface.own.instance); \
  else if (Diagnostic == SHOW_RETURNED) \
    Shown = stack.returned; \
  else if (Diagnostic == SHOW_EXPONENT) \
    Shown = color(stack.exponent, stack.returned_scale, 0.0); \
  if (Diagnostic == SHOW_IRRADIANCE) \
    BSDF = irradiance; \
  else if (Diagnostic == SHOW_SPARKLES) \
    BSDF = sparkles; \
  else if (Diagnostic == SHOW_LOBE) \
    BSDF = lobe;

#else

#define ASKED_OWN_SPACE 0
#define ASKED_SMOOTH 1
#define DIAGNOSE_PAINT

#endif
