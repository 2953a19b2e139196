// SPDX-License-Identifier: Apache-2.0
//
// The sparkles of one light in one pixel. The paper, here and in all of core/, is
//   S. V. Ershov, A. B. Khodulev, K. V. Kolchin, "Simulation of sparkles in metallic paints",
//   Graphicon 1999; again in Computer Graphics & Geometry 2 (5), 2000.
// docs/model lists its symbols, and where each of its formulas stands.
//
// How many flakes of the pixel happen to mirror the light is a random count (paper, 5.3.5). Each
// sends radiance, told per unit of the light's irradiance on a plane normal to it: T = L/E_n. What
// no deviate touches comes first (`expect_sparkles`), with the mean and the variance in closed
// form; then the draw (`draw_sparkles`).
//
// A sparkling flake shows the light's own radiance E_n/Omega, dimmed by both passages of the
// surface, by its coating and by the layer above it, and covers the share S
// cos(alpha)/(cos(theta_p) Sigma) of the pixel. The flux written out, with I(1 - r')/cos(theta'_p)
// inside the binder and the exit cone transformed like the entry cone, gives the same. The paper's
// (9) and (1) have cos(theta) for cos(theta_p): Radiometry::published. With Omega the solid angle
// of the light seen from outside, E[T] = cos(theta') f with the reciprocal BRDF of the layer's
// single scattering
//   f = D H <S> p(n_f) r_p A (1 - r)(1 - r')/(4 eta^2 cos(theta_p) cos(theta'_p)).
// For lights wide against the flakes' tilt p(n_f) is its mean over a round cap of normals
// (`cap_probability`); the rest of f is that of the light's centre. The normals that mirror the
// light really fill an ellipse, unevenly, and f changes over the light: against the integral of f
// over the light's cone, for views and lights up to 60 degrees from the normal, lights of up to 0.3
// rad above the horizon, tilts of 0.05 to 0.5 and eta of 1.3 to 2.2, the mean errs by
//   quarter cone's radius, in tilts         up to 1/16    1/4     1      2
//   beta up to 3 tilts, root mean square       0.3 %      1 %    6 %   12 %
//   the same, worst of 22,000 scenes or more     2 %     10 %   49 %   83 %
//   beta up to 6 tilts, worst as a share of the mean
//   in the mirror direction                      2 %      8 %   20 %   35 %
// (tests/core/sparkles_test.cpp). The worst is found where few flakes are; a cap as wide as the
// ellipse along beta is no nearer. What it means for counts: tests/core/explicit_flakes_test.cpp.
#pragma once

#include <algorithm>
#include <array>

#include "anchor.h"
#include "close_up.h"
#include "draw.h"
#include "expected_sparkles.h"
#include "layer.h"
#include "passage.h"
#include "random.h"
#include "vector.h"

namespace metallic_paint {

// All species of a layer under one light in one pixel; those seen close up show the flake there is.
// Their sparkles are independent; together too they do not exceed the largest ceiling.
template <class T>
struct PixelSparkles {
  int slots = 0;  // of the first species' count
  T count{}, mean_count{};
  Rgb<T> radiance{}, mean_radiance{}, variance{};
};

// The cell of the surface whose species are counted, or the pixel, whose key is each light's own.
template <class T>
Cell<T> cell_of_counts(const Layer<T>& layer, const SurfacePoint<T>& point,
                       const std::array<FirstFlake<T>, kSpecies>& firsts, int frame, int seed) {
  if (layer.anchor == Anchor::pixel) return {point.footprint, {}};
  T least = 0;
  for (int i = 0; i < layer.species; ++i) {
    const Flakes<T>& flakes = layer.flakes[static_cast<std::size_t>(i)];
    if (firsts[static_cast<std::size_t>(i)].close || !(flakes.coverage > 0)) continue;
    least = max(least, flakes.flake_area * flakes.area_mean);
  }
  return find_cell(point, layer.cell_share, least,
                   own_stream(layer, point.own, kFlakeStream, frame, seed));
}

template <class T>
PixelSparkles<T> sparkle(const Layer<T>& layer, const SurfacePoint<T>& point,
                         const std::array<FirstFlake<T>, kSpecies>& firsts, const Cell<T>& cell,
                         const Passage<T>& way, int light, int frame, int seed) {
  PixelSparkles<T> all;
  HashKey key{};
  if (layer.anchor == Anchor::pixel) {
    key = pixel_key(stream_key(kFlakeStream, light, frame, seed), point.pixel_x, point.pixel_y, 0);
  } else if (way.open) {
    key = about_normal(cell.key, own_direction(point.own, Vec3<T>(way.mirror.flake_normal)),
                       static_cast<T>(quarter_cone(cone_in_binder(layer.flakes[0], way), way)));
  }
  const T left = layer.sparkle_contrast;
  T ceiling = 0;
  for (int i = 0; i < layer.species; ++i) {
    const std::size_t at = static_cast<std::size_t>(i);
    const Flakes<T>& flakes = layer.flakes[at];
    const FirstFlake<T>& first = firsts[at];
    ExpectedSparkles<T> expected =
        expect_sparkles(layer, flakes, first.close ? point.footprint : cell.area, way);
    const Rgb<T> mean = mean_radiance(expected);
    Sparkles<T> drawn;
    if (first.close) {
      all.variance = all.variance + flake_radiance_variance(layer, first, expected, way);
      if (left > 0 && mirrors(flakes, first, way)) {
        drawn.count = 1;
        drawn.radiance = flake_radiance(layer, first, expected, way) * left;
      }
      drawn.radiance = drawn.radiance + mean * (1 - left);
      expected = expect_close(layer, flakes, first, expected, way);
    } else {
      all.variance = all.variance + radiance_variance(expected, left);
      drawn = draw_sparkles(expected, key, left, kDeviatesOfSpecies * i);
    }
    if (i == 0) all.slots = expected.slots;
    all.count = all.count + drawn.count;
    all.mean_count = all.mean_count + expected.mean_count;
    all.radiance = all.radiance + drawn.radiance;
    all.mean_radiance = all.mean_radiance + mean;
    ceiling = max(ceiling, expected.ceiling);
  }
  all.radiance = map(all.radiance, [&](T t) { return min(t, ceiling); });
  return all;
}

}  // namespace metallic_paint
