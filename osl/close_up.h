// SPDX-License-Identifier: Apache-2.0
//
// Close-ups: the flakes themselves, one by one. See core/close_up.h for their law and why it keeps the mean.
#pragma once

#include "anchor.h"
#include "elementary.h"
#include "expected_sparkles.h"
#include "layer.h"
#include "optical_thickness.h"
#include "orientation.h"
#include "passage.h"
#include "random.h"

#define MOST_STRETCH 1.2
#define MOST_SHEAR 0.3
#define OUTLINE_REACH 0.8356

#define MOST_DEVIATION 2.0
#define CUT_DEVIATION 0.00849070261

#define LEAST_IN_CELL 0.5
#define BLOCK_SIDE 12.0
#define MOST_IN_CELL 64
#define CLOSE_COLUMN 256.0
#define CLOSE_STREAM 1
#define MOST_PASSED 0.9

#define FLATTEST_VIEW 0.25

struct LatticePoint {
  float a;
  float b;
  float c;
  int face;
  vector towards_a;
  vector towards_b;
};

struct FirstFlake {
  int close;
  int seen;
  vector m;  // normal
  float facing;
  float depth;
  float hiding;
  float passed;
};

float outline(float x, float y)
{
  float right = max(1.52605945 * x + 0.834011129 * y, 1.52605945 * x - 0.892467562 * y);
  float left = max(0.888914990 * y - 1.64512237 * x, -(1.88381833 * x + 0.464797057 * y));
  float rest = max(0.310337949 * x + 1.92865169 * y, 0.0164892106 * x - 1.94948002 * y);
  return max(max(right, left), rest);
}

float passed_over(Flakes some, float library[])
{
  color t = usual_transmittance(some, library);
  float least = min(min(t[0], t[1]), t[2]);
  return min(least * least, MOST_PASSED);
}

struct Turn {
  float cosine;
  float sine;
};

Turn turn_by(float deviate)
{
  float quarters = 4.0 * deviate;
  float whole = floor(quarters);
  float angle = (quarters - whole) * HALF_PI;
  float c = cosine(angle);
  float s = sine(angle);
  Turn turn;
  turn.cosine = c;
  turn.sine = s;
  if (whole == 1.0 || whole == 3.0) {
    turn.cosine = -s;
    turn.sine = c;
  }
  if (whole >= 2.0) {
    turn.cosine = -turn.cosine;
    turn.sine = -turn.sine;
  }
  return turn;
}

struct TangentFrame {
  vector along;
  vector across;
  float a_along;
  float b_along;
  float b_across;
};

TangentFrame tangent_frame(vector n, LatticePoint at)
{
  TangentFrame frame;
  vector along = at.towards_a - n * inner_product(n, at.towards_a);
  frame.a_along = sqrt(inner_product(along, along));
  frame.along = along / frame.a_along;
  frame.across = cross(n, frame.along);
  frame.b_along = inner_product(at.towards_b, frame.along);
  frame.b_across = inner_product(at.towards_b, frame.across);
  return frame;
}

struct DrawnFlake {
  vector m;
  float facing;
  int covers;
};

DrawnFlake draw_flake(Flakes flakes, float most_weight, float off_along, float off_across, vector inside, vector tilted,
                      vector shaped)
{
  DrawnFlake flake;
  flake.m = vector(0.0);
  flake.facing = 0.0;
  flake.covers = 0;
  SampledTilt tilt = sample_tilt(flakes.orientation, tilted[0]);
  if (tilted[1] * most_weight >= tilt.weight)
    return flake;
  Turn azimuth = turn_by(tilted[2]);
  float h = tilt.sin2_half_beta;
  float cos_beta = 1.0 - 2.0 * h;
  float sin_beta = 2.0 * sqrt(h * (1.0 - h));
  flake.m = vector(sin_beta * azimuth.cosine, sin_beta * azimuth.sine, cos_beta);
  flake.facing = inner_product(flake.m, inside);
  if (!(fabs(flake.facing) > 1e-6))
    return flake;
  float run = (off_along * azimuth.cosine + off_across * azimuth.sine) / flake.facing;
  float aside = inside[1] * azimuth.cosine - inside[0] * azimuth.sine;
  float most = MOST_STRETCH;
  float least = 1.0 / MOST_STRETCH;
  float stretch = least + (most - least) * shaped[1];
  int mirrored = shaped[2] < 0.5;
  float shear = MOST_SHEAR * (4.0 * shaped[2] - (mirrored ? 1.0 : 3.0));
  float x = run * inside[2] * stretch;
  float y = (off_across * azimuth.cosine - off_along * azimuth.sine - run * (aside * sin_beta)) / stretch + shear * x;
  if (mirrored)
    y = -y;
  float edge = outline(x, y);
  float area = 1.0;
  if (flakes.area_spread > 0.0) {
    float deviate = min(normal_quantile(shaped[0]), MOST_DEVIATION);
    area = max(1.0 + flakes.area_spread * deviate, 0.0);
  }
  flake.covers = edge * edge < area * flakes.flake_area;
  return flake;
}

// No species is seen so.
FirstFlake no_flake()
{
  FirstFlake first;
  first.close = 0;
  first.seen = 0;
  first.m = vector(0.0);
  first.facing = 0.0;
  first.depth = 1.0;
  first.hiding = 0.0;
  first.passed = 0.0;
  return first;
}

FirstFlake first_flake(Layer layer, Flakes flakes, float library[], vector n, vector inside, float cos_in, float area,
                       LatticePoint at, float size, vector key)
{
  FirstFlake first = no_flake();
  first.passed = passed_over(flakes, library);
  first.hiding = (1.0 - first.passed) * (flakes.coverage * area / cos_in);
  if (!(first.hiding > 0.0))
    return first;
  float block = BLOCK_SIDE * sqrt(flakes.flake_area);
  first.close = size < 1.0 + uniform_deviate(key[0] + wrapped(floor(at.a / block)), key[1] + wrapped(floor(at.b / block)),
                                             key[2], (float)at.face);
  if (!first.close)
    return first;
  TangentFrame frame = tangent_frame(n, at);
  vector v = vector(inner_product(inside, frame.along), inner_product(inside, frame.across), cos_in);

  float most = most_tilt_weight(flakes.orientation);
  float enlarged = flakes.area_mean / (flakes.area_mean - CUT_DEVIATION * flakes.area_spread);
  float density = flakes.areal_density * enlarged * most;
  float radius = OUTLINE_REACH * sqrt(flakes.flake_area * (1.0 + MOST_DEVIATION * flakes.area_spread));
  float reach = radius / max(cos_in, FLATTEST_VIEW);
  float flattest = sqrt(max(1.0 - 1.0 / (layer.eta * layer.eta), FLATTEST_VIEW * FLATTEST_VIEW));
  float side = max(radius / flattest, min(sqrt(LEAST_IN_CELL / density), 1.0));
  float in_cell = density * (side * side) / fabs(frame.a_along * frame.b_across);

  float x = clamp(at.a / side, -1e30, 1e30);
  float y = clamp(at.b / side, -1e30, 1e30);
  float column = floor(x);
  float row = floor(y);
  vector place = vector(wrapped(floor((x - column) * 4194304.0)), wrapped(floor((y - row) * 4194304.0)), 0.0);
  float sheet = wrapped(floor(at.c / (CLOSE_COLUMN * side)));
  vector m = vector(0.0);
  for (int k = 0; k < 9; ++k) {
    int of_nine = (k + 4) % 9;
    float right = (float)(of_nine % 3 - 1);
    float up = (float)(of_nine / 3 - 1);
    vector cell = key + vector(wrapped(column + right), wrapped(row + up), sheet);
    float from_x = x - column - right;
    float from_y = y - row - up;
    float gap = max(max(-from_x, from_x - 1.0), max(-from_y, from_y - 1.0));
    if (gap * side > reach)
      continue;
    float depth = 0.0;
    for (int number = 1; number <= MOST_IN_CELL; ++number) {
      float word = (float)(4 * (number + (MOST_IN_CELL + 1) * at.face) + 8);
      vector u = uniform_deviates(cell, word);
      depth = depth - logarithm(u[0]) / in_cell;
      if (!(depth < first.depth))
        break;
      float da = (from_x - u[1]) * side / frame.a_along;
      float db = ((from_y - u[2]) * side - frame.b_along * da) / frame.b_across;
      if (da * da + db * db > reach * reach)
        continue;
      DrawnFlake flake = draw_flake(flakes, most, da, db, v, uniform_deviates(cell, word + 1.0),
                                    uniform_deviates(cell, word + 2.0));
      if (!flake.covers)
        continue;
      if (first.passed > 0.0) {
        vector here = hashed(cell, word + 3.0) + place;
        if (uniform_deviate(here[0], here[1], here[2], 0.0) < first.passed)
          continue;
      }
      first.seen = 1;
      first.depth = depth;
      first.facing = min(fabs(flake.facing), 1.0);
      m = flake.m;
      break;
    }
  }
  if (!first.seen)
    return first;
  first.m = frame.along * m[0] + frame.across * m[1] + n * m[2];
  return first;
}

color shown_by(FirstFlake first, color reflectance, color slant)
{
  return min(reflectance / (1.0 - first.passed) * exponential((color(first.hiding) - slant) * first.depth), color(1.0));
}

int mirrors(Flakes flakes, FirstFlake first, Passage way)
{
  float inside = way.open ? cone_in_binder(flakes, way) : 0.0;
  if (!first.seen || !(inside > 0.0))
    return 0;
  vector off = first.m - way.mirror.flake_normal;
  return inner_product(off, off) < 4.0 * quarter_cone(inside, way);
}

float covers_more(Layer layer, Passage way)
{
  return min(way.mirror.g_view / layer.eta, 1.0) / way.cos_exit;
}

color flake_radiance(Layer layer, FirstFlake first, ExpectedSparkles expected, Passage way)
{
  float cos_alpha = way.mirror.cos_alpha;
  return shown_by(first, expected.reflectance, way.slant) *
         (expected.ceiling * expected.share * (cos_alpha / first.facing) * covers_more(layer, way));
}

ExpectedSparkles expect_close(Layer layer, Flakes flakes, FirstFlake first, ExpectedSparkles expected, Passage way)
{
  ExpectedSparkles close = expected;
  if (!(close.ceiling > 0.0))
    return close;
  float cos_alpha = way.mirror.cos_alpha;
  float cos_in = min(way.mirror.g_view / layer.eta, 1.0);
  float over_a_point = flakes.coverage * close.probability * (cos_alpha / cos_in);
  close.mean_count = min((1.0 - first.passed) * over_a_point, first.hiding) * mean_transmittance(first.hiding);
  close.slots = 1;
  close.ceiling = close.ceiling * covers_more(layer, way);
  return close;
}

// `firsts` arrive as no_flake().
void look_close(Layer layer, float library[], SurfacePoint surface, int frame, int seed,
                output FirstFlake firsts[SPECIES])
{
  float cos_view = min(inner_product(surface.n, surface.below), 1.0);
  if (layer.anchor != ANCHOR_SURFACE || !(cos_view > LEAST_COSINE))
    return;
  float g_view = eta_cos_refracted(cos_view, layer.eta);
  if (!(g_view > 0.0))
    return;
  vector inside = (surface.below + surface.n * (g_view - cos_view)) / layer.eta;
  OwnSpace own = surface.own;
  vector axes[3] = {own.x, own.y, own.z};
  LatticePlane plane = surface.plane;
  LatticePoint at;
  at.a = own.position[plane.u];
  at.b = own.position[plane.v];
  at.c = own.position[plane.w];
  at.face = plane.face;
  at.towards_a = axes[plane.u];
  at.towards_b = axes[plane.v];
  for (int i = 0; i < layer.species; ++i) {
    Flakes some = flakes_of(layer, i);
    float wanted = clamp(surface.footprint, 1e-20, 1e6) * layer.cell_share;
    float size = wanted / (some.flake_area * some.area_mean);
    if (!(surface.footprint > 0.0) || !(size < 2.0))
      continue;
    vector key = own_stream(layer, own, CLOSE_STREAM + i, frame, seed);
    firsts[i] = first_flake(layer, some, library, surface.n, inside, surface.cos_in, surface.areas[i], at, size, key);
  }
}
