// SPDX-License-Identifier: Apache-2.0
//
// What the sparkles belong to. Anchor::pixel is the paper's (5.3.5): every pixel has deviates of
// its own. Anchor::surface (ours) gives them to cells of the paint, which ride on the surface. A
// sample takes those of the cell in which its own point lies; the renderer's samples are then the
// filter, in every camera, mirror and blur.
//
// The flakes are a Poisson process over places and normals. So counts in cells that do not overlap
// are independent, each Poisson with the mean of its own area (or binomial where few flakes fill
// it): all that holds of a pixel in expected_sparkles.h holds of a cell.
//
// A cell is a column over a parallelogram of the plane across that axis of the own space which is
// nearest to the normal: a surface cuts the column in the parallelogram's area over |n_axis|. Its
// length along one axis and its width along the other are powers of two, so that they stay while
// the footprint changes. Each parent is kept whole or halved by a deviate of its own against the
// share that the footprint asks for: one by one the cells give way to larger or smaller ones, and
// at every time a point lies in exactly one. How far a cell leans follows the footprint.
//
// Within a cell the flakes' normals have cells as well. A sample takes those about n_f, the normal
// that mirrors the light; neither the light's number nor the pixel's counts. So two lights from one
// direction light the same flakes, and a flake that turns away and back flashes again.
#pragma once

#include <algorithm>
#include <cmath>

#include "layer.h"
#include "own_space.h"
#include "passage.h"
#include "random.h"
#include "vector.h"

namespace metallic_paint {

// The side of a cell of normals, in radii of the cone of normals that sparkle. A turn by a quarter
// of a radius keeps 96 % of the flakes lit (real ones: 84 %), a few cones make a new set.
inline constexpr double kNormalCell = 10;

// The footprint is as long as at this cosine where the view is lower.
inline constexpr double kLongestFootprint = 0.01;

// A footprint is long along v unless it is so much longer along u, as the squares of its lengths:
// round ones, of which rounding would decide, stay with v.
inline constexpr double kLonger = 1.1;

// The length of a row of cells side by side, in lengths of one cell.
inline constexpr double kRow = 8;

// Columns end after so many sides, so that two sheets of paint above each other differ.
inline constexpr double kColumn = 16;

// The stream of the flakes' deviates, beside those in close_up.h and texture.h.
inline constexpr int kFlakeStream = 0;

template <class T>
struct Cell {
  T area{};       // of the surface in it, m2
  HashKey key{};  // of its deviates
};

// What tells the flakes of one object, or the texture of it, from others.
template <class T>
HashKey own_stream(const Layer<T>& layer, const OwnSpace<T>& own, int kind, int frame, int seed) {
  return stream_key(kind, layer.instances == Instances::own ? own.instance : 0, frame, seed);
}

// The octave in which a size lies: side/2 < size <= side = 2^level.
template <class T>
struct Octave {
  int level = 0;
  T side = 1;
};

template <class T>
Octave<T> octave_of(T size) {
  Octave<T> octave;
  octave.level = clamp(std::ilogb(size), -60, 60);
  octave.side = std::ldexp(T(1), octave.level);
  if (octave.side < size && octave.level < 60) {
    octave.level = octave.level + 1;
    octave.side = octave.side * 2;
  }
  return octave;
}

// An octave's side, or the half of it: by the deviate u, so that it is `size` on average.
template <class T>
Octave<T> settled(Octave<T> octave, T size, float u) {
  if (static_cast<T>(u) < 2 * size / octave.side - 1) return octave;
  return {octave.level - 1, octave.side * T(0.5)};
}

// A hash's word, below 2^20, for what a deviate decides (0 to 2), the levels of a lattice and the
// side of the sheet.
inline float lattice_word(int what, int level, int other_level, int face) {
  return static_cast<float>(((what * 128 + level + 64) * 128 + other_level + 64) * 8 + face);
}

// The cell in which a point lies; `share` of the pixel's footprint is a cell's area, but it is not
// smaller than `least`, m2.
//
// A pixel is as wide as high across the view. With n the normal, c = cos(theta) and t = V - c n,
// its footprint Sigma on the surface is the ellipse of the square form Sigma (c (1 - n n) + t t/c);
// on the plane across an axis that is the part q there. The larger of q_uu and q_vv tells the axis
// along which the footprint is long, here v. It leans across that axis by the slope q_uv/q_vv, and
// so do the cells, each about its own middle: what leans is in pixels a rectangle of the sides
// u sqrt(q_vv/det q) and v/sqrt(q_vv). det q is that of the form on the surface, (Sigma c)(Sigma c
// + Sigma t t/c), times n_w^2. A cell turns with the view, and keeps its place and its flakes.
template <class T>
Cell<T> find_cell(const SurfacePoint<T>& point, T share, T least, HashKey stream) {
  const OwnSpace<T>& own = point.own;
  const T cosine = dot(point.normal, point.view);
  const Vec3<T> t = own_direction(own, point.view - point.normal * cosine);

  const LatticePlane<T> plane = lattice_plane(own, point.normal);
  const T normal[3] = {plane.n.x, plane.n.y, plane.n.z}, across[3] = {t.x, t.y, t.z};
  const T place[3] = {own.position.x, own.position.y, own.position.z};
  const T n_u = normal[plane.u], n_v = normal[plane.v];
  const T t_u = across[plane.u], t_v = across[plane.v];
  const T w = place[plane.w];
  const T facing = clamp(abs(normal[plane.w]), T(0.5), T(1));

  const T pixel = clamp(point.footprint, T(1e-20), T(1e6)) * share;
  const T c = clamp(cosine, T(kLongestFootprint), T(1));
  const T round_part = pixel * c + least;
  const T longer = pixel / c;
  const T q_uu = round_part * (1 - n_u * n_u) + longer * (t_u * t_u);
  const T q_vv = round_part * (1 - n_v * n_v) + longer * (t_v * t_v);
  const T q_uv = longer * (t_u * t_v) - round_part * (n_u * n_v);
  const T det = round_part + longer * (1 - cosine * cosine);  // over round_part n_w^2
  T q_long = q_vv, along = place[plane.v], aside = place[plane.u];
  const bool along_u = q_uu > T(kLonger) * q_vv;
  if (along_u) {
    q_long = q_uu;
    along = place[plane.u];
    aside = place[plane.v];
  }
  const T sizes[2] = {sqrt(q_long), sqrt(round_part * (det / q_long)) * facing};

  // First the length, of a row of some cells side by side: so long as its deviate says. In it the
  // cells stand straight, and each is halved across by its own deviate or not.
  T side[2], row = 0, crosswise = aside / T(kRow);
  int level[2] = {0, 0};
  for (int i = 0; i < 2; ++i) {
    const Octave<T> parent = octave_of(sizes[i]);
    if (i == 0) row = floor(along / parent.side);
    const float u =
        uniform_deviate(stream.x + wrapped(floor(crosswise / parent.side)), stream.y + wrapped(row),
                        stream.z, lattice_word(i + 1, level[0], parent.level, plane.face));
    const Octave<T> own_side = settled(parent, sizes[i], u);
    side[i] = own_side.side;
    level[i] = own_side.level;
    if (i == 0) {
      row = floor(along / side[0]);
      crosswise = aside - (along - (row + T(0.5)) * side[0]) * (q_uv / q_long);
    }
  }

  T place_u = floor(crosswise / side[1]), place_v = row;
  int level_u = level[1], level_v = level[0];
  if (along_u) {
    place_v = place_u;
    place_u = row;
    level_v = level_u;
    level_u = level[0];
  }
  Cell<T> cell;
  cell.area = side[0] * side[1] / facing;
  const T column = T(kColumn) * max(side[0], side[1]);
  const HashKey at{wrapped(place_u), wrapped(place_v), wrapped(floor(w / column))};
  cell.key = hashed(stream + at, lattice_word(0, level_u, level_v, plane.face));
  return cell;
}

// The deviates of a cell's flakes whose normals are about n, n_f in the own space. sin2_half_rho:
// of the cone of normals that sparkle, whose radius as a chord is 2 sin(rho/2). Every cell has
// offsets of its own: else all flakes along a curve would change at once.
template <class T>
HashKey about_normal(HashKey cell, Vec3<T> n, T sin2_half_rho) {
  const T radius = 2 * sqrt(sin2_half_rho);
  const T side = clamp(T(kNormalCell) * radius, T(1e-6), T(2));
  const Octave<T> octave =
      settled(octave_of(side), side, uniform_deviate(cell.x, cell.y, cell.z, 0));
  const auto place = [&](T x, float offset) {
    return wrapped(floor(x / octave.side + static_cast<T>(offset) * T(0x1p-22)));
  };
  return hashed(cell + HashKey{place(n.x, cell.x), place(n.y, cell.y), place(n.z, cell.z)},
                static_cast<float>(octave.level + 64));
}

}  // namespace metallic_paint
