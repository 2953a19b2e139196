// SPDX-License-Identifier: Apache-2.0
//
// What the sparkles belong to: see core/anchor.h.
#pragma once

#include "layer.h"
#include "passage.h"
#include "random.h"

#define NORMAL_CELL 10.0
#define LONGEST_FOOTPRINT 0.01
#define LONGER 1.1
#define ROW 8.0
#define COLUMN 16.0

#define FLAKE_STREAM 0

struct Cell {
  float area;
  vector key;
};

vector own_stream(Layer layer, OwnSpace own, int kind, int frame, int seed)
{
  int instance = 0;
  if (layer.instances == INSTANCES_OWN)
    instance = own.instance;
  return stream_key(kind, instance, frame, seed);
}

struct Octave {
  int level;
  float side;
};

Octave octave_of(float size)
{
  Octave octave;
  octave.level = (int)clamp(logb(size), -60.0, 60.0);
  octave.side = exp2((float)octave.level);
  if (octave.side < size && octave.level < 60) {
    octave.level = octave.level + 1;
    octave.side = octave.side * 2.0;
  }
  return octave;
}

Octave settled(Octave given, float size, float u)
{
  Octave octave = given;
  if (!(u < 2.0 * size / given.side - 1.0)) {
    octave.level = given.level - 1;
    octave.side = given.side * 0.5;
  }
  return octave;
}

float lattice_word(int what, int level, int other_level, int face)
{
  return (float)(((what * 128 + level + 64) * 128 + other_level + 64) * 8 + face);
}

Cell find_cell(SurfacePoint surface, float share, float least, vector stream)
{
  OwnSpace own = surface.own;
  float cosine = inner_product(surface.n, surface.view);
  vector t = own_direction(own, surface.view - surface.n * cosine);

  LatticePlane plane = surface.plane;
  vector n = plane.n;
  float n_u = n[plane.u];
  float n_v = n[plane.v];
  float t_u = t[plane.u];
  float t_v = t[plane.v];
  float w = own.position[plane.w];
  float facing = clamp(fabs(n[plane.w]), 0.5, 1.0);

  float pixel = clamp(surface.footprint, 1e-20, 1e6) * share;
  float c = clamp(cosine, LONGEST_FOOTPRINT, 1.0);
  float round_part = pixel * c + least;
  float longer = pixel / c;
  float q_uu = round_part * (1.0 - n_u * n_u) + longer * (t_u * t_u);
  float q_vv = round_part * (1.0 - n_v * n_v) + longer * (t_v * t_v);
  float q_uv = longer * (t_u * t_v) - round_part * (n_u * n_v);
  float det = round_part + longer * (1.0 - cosine * cosine);
  float q_long = q_vv;
  float along = own.position[plane.v];
  float aside = own.position[plane.u];
  int along_u = q_uu > LONGER * q_vv;
  if (along_u) {
    q_long = q_uu;
    along = own.position[plane.u];
    aside = own.position[plane.v];
  }
  float sizes[2] = {sqrt(q_long), sqrt(round_part * (det / q_long)) * facing};

  float side[2] = {0.0, 0.0};
  int level[2] = {0, 0};
  float row = 0.0;
  float crosswise = aside / ROW;
  for (int i = 0; i < 2; ++i) {
    Octave parent = octave_of(sizes[i]);
    if (i == 0)
      row = floor(along / parent.side);
    float u = uniform_deviate(stream[0] + wrapped(floor(crosswise / parent.side)), stream[1] + wrapped(row), stream[2],
                      lattice_word(i + 1, level[0], parent.level, plane.face));
    Octave own_side = settled(parent, sizes[i], u);
    side[i] = own_side.side;
    level[i] = own_side.level;
    if (i == 0) {
      row = floor(along / side[0]);
      crosswise = aside - (along - (row + 0.5) * side[0]) * (q_uv / q_long);
    }
  }

  float place_u = floor(crosswise / side[1]);
  float place_v = row;
  int level_u = level[1];
  int level_v = level[0];
  if (along_u) {
    place_v = place_u;
    place_u = row;
    level_v = level_u;
    level_u = level[0];
  }
  Cell cell;
  cell.area = side[0] * side[1] / facing;
  float column = COLUMN * max(side[0], side[1]);
  vector at = vector(wrapped(place_u), wrapped(place_v), wrapped(floor(w / column)));
  cell.key = hashed(stream + at, lattice_word(0, level_u, level_v, plane.face));
  return cell;
}

float normal_place(float x, float side, float offset)
{
  return wrapped(floor(x / side + offset * 2.38418579e-7));
}

vector about_normal(vector cell, vector n, float sin2_half_rho)
{
  float radius = 2.0 * sqrt(sin2_half_rho);
  float side = clamp(NORMAL_CELL * radius, 1e-6, 2.0);
  Octave octave = settled(octave_of(side), side, uniform_deviate(cell[0], cell[1], cell[2], 0.0));
  vector at = vector(normal_place(n[0], octave.side, cell[0]), normal_place(n[1], octave.side, cell[1]),
                     normal_place(n[2], octave.side, cell[2]));
  return hashed(cell + at, (float)(octave.level + 64));
}
