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

#ifndef DIAGNOSTICS
#define Diagnostic SHOW_PAINT
#define DiagnosticLight 1
#define DiagnosticSpecies 1
#endif

int is_sound(float x)
{
  return isfinite(x) && x >= 0.0;
}

int is_sound(color x)
{
  return is_sound(x[0]) && is_sound(x[1]) && is_sound(x[2]);
}
