// SPDX-License-Identifier: Apache-2.0
//
// Regular texture: the light scattered several times fluctuates from pixel to pixel. See core/texture.h.
#pragma once

#include "anchor.h"
#include "elementary.h"
#include "random.h"

float texture_deviation(float contrast, float footprint)
{
  return min(contrast * 0.001 / sqrt(max(footprint, 1e-20)), 1.0);
}

float texture_factor(float contrast, float footprint, float w)
{
  float deviation = texture_deviation(contrast, footprint);
  float square = logarithm(1.0 + deviation * deviation);
  return exponential(sqrt(square) * w - 0.5 * square);
}

#define TEXTURE_STREAM 9

float texture_deviate(vector key)
{
  return normal_quantile(uniform_deviate(key[0], key[1], key[2], 0.0));
}

float pixel_texture(float contrast, float footprint, int pixel_x, int pixel_y, int frame, int seed)
{
  vector key = pixel_key(stream_key(TEXTURE_STREAM, 0, frame, seed), pixel_x, pixel_y, 0);
  return texture_factor(contrast, footprint, texture_deviate(key));
}

float texture_at(Layer layer, SurfacePoint surface, float contrast, int frame, int seed)
{
  if (layer.anchor == ANCHOR_PIXEL)
    return pixel_texture(contrast, surface.footprint, surface.pixel_x, surface.pixel_y, frame, seed);
  Cell cell = find_cell(surface, layer.cell_share, 0.0, own_stream(layer, surface.own, TEXTURE_STREAM, frame, seed));
  return texture_factor(contrast, cell.area, texture_deviate(cell.key));
}
