// SPDX-License-Identifier: Apache-2.0
//
// Close-ups (ours): where a cell of the surface anchor would hold about a flake or less, the flakes
// of a species are seen themselves: each of true size, place, tilt and depth, with an outline of
// its own, the upper over the lower, each a mirror of its own.
//
// The flakes of a species are a Poisson process over place, normal, area and depth. Space is cut
// into cells, columns of a lattice across the dominant axis of the normal; in a cell the flakes
// follow each other from the surface down by exponential steps of depth, each from the deviates of
// (cell, number). A cell is as wide as a flake can reach, so the 3 x 3 cells about a sample hold
// all that can cover it, and the search in a cell ends where it passes the best so far: its work is
// bounded however dense the paint.
//
// What a sample sees of a species is one flake over it, and nothing below. One that transmits t is
// passed over with the probability q = t^2, its own share of light on the ways there and back, by
// a deviate of the sample's place; what is seen shows 1/(1 - q) for it. So the samples of a pixel
// see flakes through others. At the depth z, a share of the layer, a flake is seen with the
// probability (1 - q) e^-bz: b = (1 - q) D H <S> <s>/cos(theta_p) is the mean number of flakes over
// a point that end the search. What they do not hide is left to the closed form, which has the way
// of the light, the other species and the binder: the flake is dimmed by e^-(x - b)z with x the
// optical depth there and back. So the mean is
//   integral over z of D H <S> ... r_p e^-bz e^-(x - b)z = D H <S> ... r_p (1 - e^-x)/x,
// `mean_radiance` of expect_sparkles and `sample_flake`'s of the lobe to the letter, for every
// coverage. q is that of the colour that passes least; another's flakes are the brighter with
// depth, up to what a mirror shows.
//
// Left out: the parallax of depth. A flake of the layer's ground is seen up to H tan(theta_p) from
// where it is drawn, 20 um under 25 um of lacquer at grazing angles, and as much between the eyes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "anchor.h"
#include "elementary.h"
#include "expected_sparkles.h"
#include "layer.h"
#include "optical_thickness.h"
#include "orientation.h"
#include "own_space.h"
#include "passage.h"
#include "random.h"
#include "vector.h"

namespace metallic_paint {

// Where a sample lies in a lattice of cells: two coordinates of the paint's own space, in metres,
// the one across them, the side of the sheet, and the directions in the world along which the two
// grow, of unit length.
template <class T>
struct LatticePoint {
  T a, b, c;
  int face;
  Vec3<T> towards_a, towards_b;
};

// The uppermost flake of a species over a sample.
template <class T>
struct FirstFlake {
  bool close = false;  // whether the species is seen so at all
  bool seen = false;
  Vec3<T> normal{};  // in the world
  T facing{};        // |v . m|
  T depth = 1;       // share of the layer
  T hiding{};        // b, the mean number of the species' flakes over a point that hide
  T passed{};        // q
};

// A flake's outline is an irregular hexagon of area 1, of which each flake has an image of its own:
// mirrored, sheared, stretched, turned with its tilt. 1 on the edge, and in proportion to (x, y).
template <class T>
T outline(T x, T y) {
  const T right =
      max(T(1.52605945L) * x + T(0.834011129L) * y, T(1.52605945L) * x - T(0.892467562L) * y);
  const T left =
      max(T(0.888914990L) * y - T(1.64512237L) * x, -(T(1.88381833L) * x + T(0.464797057L) * y));
  const T rest =
      max(T(0.310337949L) * x + T(1.92865169L) * y, T(0.0164892106L) * x - T(1.94948002L) * y);
  return max(max(right, left), rest);
}
inline constexpr double kMostStretch = 1.2;
inline constexpr double kMostShear = 0.3;
// No corner of any such image is farther from the middle.
inline constexpr double kOutlineReach = 0.8356;

// Flakes larger than this many deviations above the mean are cut there, and as many more drawn as
// make up for it: E[(X - cap)+] = spread (phi(2) - 2 (1 - Phi(2))).
inline constexpr double kMostDeviation = 2;
inline constexpr double kCutDeviation = 0.00849070261;

// The first of their streams of deviates, one a species.
inline constexpr int kCloseStream = 1;

// Cells of a sparse paint hold half a flake; and no more of a cell's flakes than this are looked
// at.
inline constexpr double kLeastInCell = 0.5;
inline constexpr int kMostInCell = 64;

// Columns of cells end after so many sides, so that two sheets of paint above each other differ.
inline constexpr double kCloseColumn = 256;

// Whether flakes are seen or counted is one decision over a square of so many flakes a side: a
// flake or a cell of the anchor that its border cuts shows part of its sparkle, which takes
// variance away.
inline constexpr double kBlockSide = 12;

// A view that runs flatter through the binder (an index below 1.03 has such) sees flakes that are
// cut at the neighbouring cells' ends.
inline constexpr double kFlattestView = 0.25;

// Flakes that let more than this pass are seen a little too often, and are the dimmer for it: the
// search stays short, and no sample outshines ten flakes.
inline constexpr double kMostPassed = 0.9;

// q.
template <class T>
T passed_over(const Flakes<T>& flakes) {
  const Rgb<T> t = usual_transmittance(flakes);
  const T least = min(min(t.x, t.y), t.z);
  return min(least * least, T(kMostPassed));
}

// A direction in the plane, by the turn u in (0, 1).
template <class T>
struct Turn {
  T cosine, sine;
};
template <class T>
Turn<T> turn_by(T u) {
  const T quarters = 4 * u;
  const T whole = floor(quarters);
  const T angle = (quarters - whole) * T(1.57079632679489661923L);
  const T c = cosine(angle), s = sine(angle);
  Turn<T> turn{c, s};
  if (whole == 1 || whole == 3) turn = {-s, c};
  if (whole >= 2) turn = {-turn.cosine, -turn.sine};
  return turn;
}

// Tangents of the surface that turn with it: the first is that of the lattice's own a. In them a
// vector d is (d . along, d . across), and a step of the lattice (da, db) is (da/a_along, (db -
// b_along da/a_along)/b_across).
template <class T>
struct TangentFrame {
  Vec3<T> along, across;
  T a_along, b_along, b_across;
};
template <class T>
TangentFrame<T> tangent_frame(Vec3<T> normal, const LatticePoint<T>& at) {
  TangentFrame<T> frame;
  const Vec3<T> along = at.towards_a - normal * dot(normal, at.towards_a);
  frame.a_along = length(along);
  frame.along = along / frame.a_along;
  frame.across = cross(normal, frame.along);
  frame.b_along = dot(at.towards_b, frame.along);
  frame.b_across = dot(at.towards_b, frame.across);
  return frame;
}

// One flake of a cell: its normal in the tangent frame, and whether it covers a sample.
template <class T>
struct DrawnFlake {
  Vec3<T> normal{};  // along, across, up
  T facing{};        // v . m
  bool covers = false;
};

// `off` is the way from the flake's centre to the sample, `inside` that to the observer, both in
// the tangent frame. `tilted` and `shaped` are the flake's own deviates.
template <class T>
DrawnFlake<T> draw_flake(const Flakes<T>& flakes, T most_weight, Vec3<T> off, Vec3<T> inside,
                         Deviates tilted, Deviates shaped) {
  DrawnFlake<T> flake;
  const SampledTilt<T> tilt = sample_tilt(flakes.orientation, static_cast<T>(tilted.x));
  if (static_cast<T>(tilted.y) * most_weight >= tilt.weight) return flake;
  const Turn<T> azimuth = turn_by(static_cast<T>(tilted.z));
  const T h = tilt.sin2_half_beta;
  const T cos_beta = 1 - 2 * h, sin_beta = 2 * sqrt(h * (1 - h));
  flake.normal = {sin_beta * azimuth.cosine, sin_beta * azimuth.sine, cos_beta};
  flake.facing = dot(flake.normal, inside);
  if (!(abs(flake.facing) > T(1e-6))) return flake;
  // Along v the sample d meets the flake's plane at d - v (d . m)/(v . m). In the plane's own
  // frame, the first axis up the tilt, that is (d_1 v_n, d_2 v . m - d_1 v_2 sin(beta))/(v . m).
  const T run = (off.x * azimuth.cosine + off.y * azimuth.sine) / flake.facing;
  const T aside = inside.y * azimuth.cosine - inside.x * azimuth.sine;
  const T most = T(kMostStretch), least = 1 / T(kMostStretch);
  const T stretch = least + (most - least) * static_cast<T>(shaped.y);
  const bool mirrored = shaped.z < 0.5f;
  const T shear = T(kMostShear) * (4 * static_cast<T>(shaped.z) - (mirrored ? 1 : 3));
  const T x = run * inside.z * stretch;
  const T y = (off.y * azimuth.cosine - off.x * azimuth.sine - run * (aside * sin_beta)) / stretch +
              shear * x;
  const T edge = outline(x, mirrored ? -y : y);
  T area = 1;
  if (flakes.area_spread > 0) {
    const T deviate = min(normal_quantile(static_cast<T>(shaped.x)), T(kMostDeviation));
    area = max(1 + flakes.area_spread * deviate, T(0));
  }
  flake.covers = edge * edge < area * flakes.flake_area;
  return flake;
}

// `inside` is the direction v to the observer in the binder, of cosine cos_in, `size` that of the
// anchor's cells in mean flake areas: cells of one flake or less are seen close up, of two or more
// in counts, between them some blocks are and some are not.
template <class T>
FirstFlake<T> first_flake(const Layer<T>& layer, const Flakes<T>& flakes, Vec3<T> normal,
                          Vec3<T> inside, T cos_in, const LatticePoint<T>& at, T size,
                          HashKey key) {
  FirstFlake<T> first;
  first.passed = passed_over(flakes);
  first.hiding = (1 - first.passed) *
                 (flakes.coverage * mean_projected_area(flakes.orientation, cos_in) / cos_in);
  if (!(first.hiding > 0)) return first;
  const T block = T(kBlockSide) * sqrt(flakes.flake_area);
  first.close = size < 1 + static_cast<T>(uniform_deviate(key.x + wrapped(floor(at.a / block)),
                                                          key.y + wrapped(floor(at.b / block)),
                                                          key.z, static_cast<float>(at.face)));
  if (!first.close) return first;
  const TangentFrame<T> frame = tangent_frame(normal, at);
  const Vec3<T> v{dot(inside, frame.along), dot(inside, frame.across), cos_in};

  // As many more flakes as their tilts' weights, `most` at most, and the cut of the areas take
  // away.
  const T most = most_tilt_weight(flakes.orientation);
  const T enlarged = flakes.area_mean / (flakes.area_mean - T(kCutDeviation) * flakes.area_spread);
  const T density = flakes.areal_density * enlarged * most;
  // The cell serves for every view: the flattest in the binder is that of the horizon.
  const T radius =
      T(kOutlineReach) * sqrt(flakes.flake_area * (1 + T(kMostDeviation) * flakes.area_spread));
  const T reach = radius / max(cos_in, T(kFlattestView));
  const T flattest =
      sqrt(max(1 - 1 / (layer.eta * layer.eta), T(kFlattestView) * T(kFlattestView)));
  const T side = max(radius / flattest, min(sqrt(T(kLeastInCell) / density), T(1)));
  const T in_cell = density * (side * side) / abs(frame.a_along * frame.b_across);

  const T x = clamp(at.a / side, T(-1e30), T(1e30));
  const T y = clamp(at.b / side, T(-1e30), T(1e30));
  const T column = floor(x), row = floor(y);
  const HashKey place{wrapped(floor((x - column) * T(4194304))),
                      wrapped(floor((y - row) * T(4194304))), 0};
  const float sheet = wrapped(floor(at.c / (T(kCloseColumn) * side)));
  Vec3<T> m{};
  for (int k = 0; k < 9; ++k) {
    const int of_nine = (k + 4) % 9;  // the sample's own first
    const T right = static_cast<T>(of_nine % 3 - 1), up = static_cast<T>(of_nine / 3 - 1);
    const HashKey cell = key + HashKey{wrapped(column + right), wrapped(row + up), sheet};
    const T from_x = x - column - right, from_y = y - row - up;
    const T gap = max(max(-from_x, from_x - 1), max(-from_y, from_y - 1));
    if (gap * side > reach) continue;
    T depth = 0;
    for (int number = 1; number <= kMostInCell; ++number) {
      const auto word = static_cast<float>(4 * (number + (kMostInCell + 1) * at.face) + 8);
      const Deviates u = uniform_deviates(cell, word);
      depth = depth - logarithm(static_cast<T>(u.x)) / in_cell;
      if (!(depth < first.depth)) break;
      const T da = (from_x - static_cast<T>(u.y)) * side / frame.a_along;
      const T db = ((from_y - static_cast<T>(u.z)) * side - frame.b_along * da) / frame.b_across;
      if (da * da + db * db > reach * reach) continue;
      const DrawnFlake<T> flake =
          draw_flake(flakes, most, {da, db, T(0)}, v, uniform_deviates(cell, word + 1),
                     uniform_deviates(cell, word + 2));
      if (!flake.covers) continue;
      if (first.passed > 0) {
        const HashKey here = hashed(cell, word + 3) + place;
        if (static_cast<T>(uniform_deviate(here.x, here.y, here.z, 0)) < first.passed) continue;
      }
      first.seen = true;
      first.depth = depth;
      first.facing = min(abs(flake.facing), T(1));
      m = flake.normal;
      break;
    }
  }
  if (!first.seen) return first;
  first.normal = frame.along * m.x + frame.across * m.y + normal * m.z;
  return first;
}

// What a flake of this reflectance shows of what it mirrors, through a layer of the optical depth x
// there and back.
template <class T>
Rgb<T> shown_by(const FirstFlake<T>& first, Rgb<T> reflectance, Rgb<T> slant) {
  const auto shown = [&](T r, T x) {
    return min(r / (1 - first.passed) * exponential((first.hiding - x) * first.depth), T(1));
  };
  return {shown(reflectance.x, slant.x), shown(reflectance.y, slant.y),
          shown(reflectance.z, slant.z)};
}

// Whether the flake that a sample sees mirrors a listed light: its normal lies within rho of n_f
// (paper, eq. 4).
template <class T>
bool mirrors(const Flakes<T>& flakes, const FirstFlake<T>& first, const Passage<T>& way) {
  const Wide<T> inside = way.open ? cone_in_binder(flakes, way) : 0;
  if (!first.seen || !(inside > 0)) return false;
  const Vec3<T> off = first.normal - Vec3<T>(way.mirror.flake_normal);
  return dot(off, off) < static_cast<T>(4 * quarter_cone(inside, way));
}

// The cosine of the view in the binder over that by which flakes cover the pixel: 1, but
// cos(theta_p)/cos(theta) in radiometry published, which sees each flake cover so much more.
template <class T>
T covers_more(const Layer<T>& layer, const Passage<T>& way) {
  return min(static_cast<T>(way.mirror.g_view) / layer.eta, T(1)) / way.cos_exit;
}

// T of a sample whose flake mirrors the light, whichever it is: that of a mirror. A sample is
// covered or not. So what published has a flake cover more, it shows more, beyond the mirror:
// otherwise the mean would not stay.
template <class T>
Rgb<T> flake_radiance(const Layer<T>& layer, const FirstFlake<T>& first,
                      const ExpectedSparkles<T>& expected, const Passage<T>& way) {
  const T cos_alpha = static_cast<T>(way.mirror.cos_alpha);
  return shown_by(first, expected.reflectance, way.slant) *
         (expected.ceiling * expected.share * (cos_alpha / first.facing) * covers_more(layer, way));
}

// What is expected of such samples, in place of counts: one flake or none, and how bright it can
// be. Over a point lie D H <S> Pr cos(alpha)/cos(theta_p) flakes that mirror the light. At the
// depth z a share (1 - q) e^-bz of them is seen, so the mean count is
//   integral over z of (1 - q) D H <S> Pr cos(alpha)/cos(theta_p) e^-bz,
// where b alone, of all normals, bounds what stands before e^-bz.
template <class T>
ExpectedSparkles<T> expect_close(const Layer<T>& layer, const Flakes<T>& flakes,
                                 const FirstFlake<T>& first, ExpectedSparkles<T> expected,
                                 const Passage<T>& way) {
  if (!(expected.ceiling > 0)) return expected;
  const T cos_alpha = static_cast<T>(way.mirror.cos_alpha);
  const T cos_in = min(static_cast<T>(way.mirror.g_view) / layer.eta, T(1));
  const T over_a_point = flakes.coverage * expected.probability * (cos_alpha / cos_in);
  expected.mean_count =
      min((1 - first.passed) * over_a_point, first.hiding) * mean_transmittance(first.hiding);
  expected.slots = 1;
  expected.ceiling = expected.ceiling * covers_more(layer, way);
  return expected;
}

// Var[T] of such samples: in E[T^2] stands e^-bz e^-2(x - b)z for e^-xz, and no T is above `most`.
// Lights narrow enough that cos(alpha) is the same for all that show them.
template <class T>
Rgb<T> flake_radiance_variance(const Layer<T>& layer, const FirstFlake<T>& first,
                               const ExpectedSparkles<T>& expected, const Passage<T>& way) {
  if (!(expected.ceiling > 0)) return {};
  const T most = expected.ceiling * expected.share * covers_more(layer, way);
  const T left = layer.sparkle_contrast;
  const auto variance = [&](T mean, T reflectance, T x) {
    const T y = 2 * x - first.hiding;
    const T fading = y == 0 ? T(1) : -std::expm1(-max(y, T(-80))) / y;
    const T square = mean * most * min(reflectance * fading / mean_transmittance(x), T(1));
    return max(square - mean * mean, T(0)) * (left * left);
  };
  const Rgb<T> mean = mean_radiance(expected), r = expected.reflectance / (1 - first.passed);
  return {variance(mean.x, r.x, way.slant.x), variance(mean.y, r.y, way.slant.y),
          variance(mean.z, r.z, way.slant.z)};
}

// What a sample sees of each species: those whose cells hold a flake or two at most.
template <class T>
std::array<FirstFlake<T>, kSpecies> look_close(const Layer<T>& layer, const SurfacePoint<T>& point,
                                               int frame, int seed) {
  std::array<FirstFlake<T>, kSpecies> firsts;
  const Vec3<T> view = view_below(point);
  const T cos_view = min(dot(point.normal, view), T(1));
  if (layer.anchor != Anchor::surface || !(cos_view > T(kLeastCosine))) return firsts;
  const T g_view = eta_cos_refracted(cos_view, layer.eta);
  if (!(g_view > 0)) return firsts;
  const Vec3<T> inside = (view + point.normal * (g_view - cos_view)) / layer.eta;
  const OwnSpace<T>& own = point.own;
  const T place[3] = {own.position.x, own.position.y, own.position.z};
  const Vec3<T> axes[3] = {own.x, own.y, own.z};
  const LatticePlane<T> plane = lattice_plane(own, point.normal);
  const LatticePoint<T> at{place[plane.u], place[plane.v], place[plane.w],
                           plane.face,     axes[plane.u],  axes[plane.v]};
  for (int i = 0; i < layer.species; ++i) {
    const Flakes<T>& flakes = layer.flakes[static_cast<std::size_t>(i)];
    const T wanted = clamp(point.footprint, T(1e-20), T(1e6)) * layer.cell_share;
    const T size = wanted / (flakes.flake_area * flakes.area_mean);
    if (!(point.footprint > 0) || !(size < 2)) continue;
    const HashKey key = own_stream(layer, own, kCloseStream + i, frame, seed);
    firsts[static_cast<std::size_t>(i)] = first_flake(layer, flakes, point.normal, inside,
                                                      min(g_view / layer.eta, T(1)), at, size, key);
  }
  return firsts;
}

}  // namespace metallic_paint
