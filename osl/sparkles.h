// SPDX-License-Identifier: Apache-2.0
//
// The sparkles of one light in one pixel: see core/sparkles.h for the model and its derivation.
#pragma once

#include "anchor.h"
#include "close_up.h"
#include "draw.h"
#include "expected_sparkles.h"
#include "layer.h"
#include "passage.h"
#include "random.h"

struct PixelSparkles {
  float count;
  float mean_count;
  color radiance;
  color mean_radiance;
};

Cell cell_of_counts(Layer layer, SurfacePoint surface, FirstFlake firsts[SPECIES], int frame, int seed)
{
  Cell cell;
  cell.area = surface.footprint;
  cell.key = vector(0.0);
  if (layer.anchor == ANCHOR_SURFACE) {
    float least = 0.0;
    for (int i = 0; i < layer.species; ++i) {
      Flakes some = flakes_of(layer, i);
      if (!firsts[i].close && some.coverage > 0.0)
        least = max(least, some.flake_area * some.area_mean);
    }
    cell = find_cell(surface, layer.cell_share, least, own_stream(layer, surface.own, FLAKE_STREAM, frame, seed));
  }
  return cell;
}

// `flat`: whether any listed light is. `blurred`: the mean, and nothing is drawn.
PixelSparkles sparkle(Layer layer, float library[], SurfacePoint surface, FirstFlake firsts[SPECIES], Cell cell, Passage way,
                      int flat, int light, int frame, int seed, int blurred)
{
  PixelSparkles all;
  all.count = 0.0;
  all.mean_count = 0.0;
  all.radiance = color(0.0);
  all.mean_radiance = color(0.0);
  float contrast = blurred ? 0.0 : layer.sparkle_contrast;
  vector key = vector(0.0);
  if (layer.anchor == ANCHOR_PIXEL)
    key = pixel_key(stream_key(FLAKE_STREAM, light, frame, seed), surface.pixel_x, surface.pixel_y, 0);
  else if (way.open)
    key = about_normal(cell.key, own_direction(surface.own, way.mirror.flake_normal),
                       quarter_cone(cone_in_binder(flakes_of(layer, 0), way), way));
  float ceiling = 0.0;
  for (int i = 0; i < layer.species; ++i) {
    Flakes some = flakes_of(layer, i);
    FirstFlake first = firsts[i];
    ExpectedSparkles expected = expect_sparkles(layer, some, library, first.close ? surface.footprint : cell.area, way, flat);
    color mean = mean_radiance(expected);
    Sparkles drawn;
    if (first.close) {
      drawn.count = 0.0;
      drawn.radiance = color(0.0);
      if (contrast > 0.0 && mirrors(some, first, way)) {
        drawn.count = 1.0;
        drawn.radiance = flake_radiance(layer, first, expected, way) * contrast;
      }
      drawn.radiance = drawn.radiance + mean * (1.0 - contrast);
      expected = expect_close(layer, some, first, expected, way);
    }
    else
      drawn = draw_sparkles(expected, key, contrast, DEVIATES_OF_SPECIES * i);
    all.count = all.count + drawn.count;
    all.mean_count = all.mean_count + expected.mean_count;
    all.radiance = all.radiance + drawn.radiance;
    all.mean_radiance = all.mean_radiance + mean;
    ceiling = max(ceiling, expected.ceiling);
  }
  all.radiance = min(all.radiance, color(ceiling));
  return all;
}
