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

// Counts are those of the species `shown`, the rest of all.
struct PixelSparkles {
  float count;
  float mean_count;
  color radiance;
  color mean_radiance;
};

// Where the cells of the surface are those of the species. No light has a part in them.
void find_cells(Layer layer, SurfacePoint surface, FirstFlake firsts[SPECIES], int frame,
                int seed, output Cell cells[SPECIES])
{
  for (int i = 0; i < layer.species; ++i) {
    FirstFlake first = firsts[i];
    if (layer.anchor == ANCHOR_SURFACE && !first.close) {
      Flakes some = flakes_of(layer, i);
      cells[i] = find_cell(surface, layer.cell_share, some.flake_area * some.area.mean,
                           own_stream(layer, surface.own, i, frame, seed));
    }
  }
}

// `blurred`, or without contrast: the mean, and nothing is drawn. mean_radiance is found where it is asked for.
PixelSparkles sparkle(Layer layer, float library[], SurfacePoint surface,
                      FirstFlake firsts[SPECIES], Cell cells[SPECIES], Passage way, int flat, int light, int frame, int seed,
                      int blurred, int asked_mean, int shown)
{
  PixelSparkles all;
  all.count = 0.0;
  all.mean_count = 0.0;
  all.radiance = color(0.0);
  all.mean_radiance = color(0.0);
  float ceiling = 0.0;
  int only_mean = blurred || !(layer.sparkle_contrast > 0.0);
  for (int i = 0; i < layer.species; ++i) {
    Flakes some = flakes_of(layer, i);
    FirstFlake first = firsts[i];
    float area = surface.footprint;
    HashWords key;
    int x = 0;
    int y = 0;
    if (layer.anchor == ANCHOR_PIXEL) {
      key = stream_key(light, i, frame, seed);
      x = surface.pixel_x;
      y = surface.pixel_y;
    }
    else if (way.open && !first.close) {
      Cell cell = cells[i];
      float cone = quarter_cone(cone_in_binder(some, way), way);
      area = cell.area;
      key = about_normal(cell.key, own_direction(surface.own, way.mirror.flake_normal), cone);
    }
    ExpectedSparkles expected = expect_sparkles(layer, some, library, area, way, flat);
    color mean = color(0.0);
    if (only_mean || asked_mean || (first.close && layer.sparkle_contrast < 1.0))
      mean = mean_radiance(expected);
    Sparkles drawn;
    drawn.count = floor(expected.mean_count + 0.5);
    drawn.radiance = min(mean, color(expected.ceiling));
    if (!only_mean && first.close) {
      drawn.count = 0.0;
      drawn.radiance = color(0.0);
      if (mirrors(some, first, way)) {
        drawn.count = 1.0;
        drawn.radiance = flake_radiance(layer, first, expected, way);
      }
      float left = layer.sparkle_contrast;
      if (left < 1.0)
        drawn.radiance = drawn.radiance * left + mean * (1.0 - left);
      expected = expect_close(layer, some, first, expected, way);
    }
    else if (!only_mean)
      drawn = draw_sparkles(expected, some.area_spread, key, x, y);
    if (i == shown) {
      all.count = drawn.count;
      all.mean_count = expected.mean_count;
    }
    all.radiance = all.radiance + drawn.radiance;
    all.mean_radiance = all.mean_radiance + mean;
    ceiling = max(ceiling, expected.ceiling);
  }
  all.radiance = min(all.radiance, color(ceiling));
  return all;
}
