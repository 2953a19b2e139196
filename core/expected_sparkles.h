// SPDX-License-Identifier: Apache-2.0
//
// How many flakes of a pixel are expected to mirror a light, and what each of them shows:
// everything about the sparkles but the deviates, with the mean and the variance in closed form.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>

#include "flake_area.h"
#include "layer.h"
#include "optical_thickness.h"
#include "orientation.h"
#include "passage.h"
#include "vector.h"

namespace metallic_paint {

// Everything about the sparkles of a light in a pixel but the deviates.
template <class T>
struct ExpectedSparkles {
  T mean_count{};                   // <N>
  int slots{};                      // 0: Poisson; k: binomial with k places
  T fill{1};                        // mean flake areas that fill the pixel
  T area_spread{};                  // of a flake
  T area_mean{1};                   // of min(X, fill)
  T area_square{1};                 // E[X^2]/E[X]^2
  Rgb<T> slant{};                   // optical depth of the layer, there and back: x = t H
  T hidden{};                       // h: the part of it that takes flakes away whole
  Rgb<T> transmitted = grey(T(1));  // what it leaves on average of a beam to a random depth: A
  Rgb<T> reflectance{};             // r_p of a flake that sparkles
  Rgb<T> mirror{};                  // T of a pixel filled by an undimmed sparkle
  T ceiling{};                      // T of a pixel filled by a perfect mirror: nothing exceeds it
  T share{1};                       // of the light that sparkles: not what has melted of it
  T probability{};                  // Pr: that a flake mirrors the light
};

// Probability that a flake's normal lies within rho of a direction at beta from the paint normal.
// Published: P at the centre of the cone, as in the paper's eq. 4, but at most 1.
template <class T>
Wide<T> flake_probability(const OrientationDensity<T>& density, Radiometry radiometry,
                          Wide<T> sin2_half_beta, Wide<T> sin2_half_rho) {
  if (radiometry == Radiometry::exact) {
    return cap_probability(density, sin2_half_beta, sin2_half_rho);
  }
  return min(2 * orientation_density(density, sin2_half_beta) * sin2_half_rho, Wide<T>(1));
}

// A pixel that one flake can fill (ours). Where fewer than this many mean flakes fill the pixel,
// the count is binomial with as many places as flakes fit, so that the sum stays under the mirror's
// radiance with the same mean.
inline constexpr int kPoissonSlots = 16;

// No cone in the binder counts as less, in sr: 1/cone^2 stays a number. The mean is the same.
template <class T>
inline constexpr double kLeastCone = std::is_same_v<T, float> ? 1e-18 : 1e-100;

// The light in the binder as flakes see it that spread light themselves, sr: Delta_eff^2 = Delta^2
// + epsilon^2. 0 for a point light on perfect mirrors: no flake ever meets it.
template <class T>
Wide<T> cone_in_binder(const Flakes<T>& flakes, const Passage<T>& way) {
  using W = Wide<T>;
  const W inside = way.inside + flakes.solid_angle;
  if (!(inside > 0)) return 0;
  return max(inside, W(kLeastCone<T>) * max(way.ratio, W(1)));
}

// By how much the flakes' tilt turns what they mirror, outside.
template <class T>
T turned_by(const Flakes<T>& flakes, T eta) {
  return 2 * eta * flakes.orientation.tilt;
}

// At most.
template <class T>
T turned_by(const Layer<T>& layer) {
  T most = 0;
  for (int i = 0; i < layer.species; ++i) {
    const Flakes<T>& flakes = layer.flakes[static_cast<std::size_t>(i)];
    if (flakes.coverage > 0) most = max(most, turned_by(flakes, layer.eta));
  }
  return most;
}

// sin^2(rho/2) of the cone about n_f in which the normal of a sparkling flake lies (paper, eq. 4):
// 4 pi sin^2(rho/2) = inside/(4 cos(alpha)).
template <class T>
Wide<T> quarter_cone(Wide<T> inside, const Passage<T>& way) {
  return inside / (16 * std::numbers::pi_v<Wide<T>> * way.mirror.cos_alpha);
}

// The sparkles of one species through an open passage, given the light's cone in the binder and the
// probability that a flake mirrors it (paper, eq. 4).
template <class T>
ExpectedSparkles<T> expect_sparkles(const Layer<T>& layer, const Flakes<T>& flakes, T pixel_area,
                                    const Passage<T>& way, Wide<T> inside, T probability) {
  ExpectedSparkles<T> expected;
  expected.area_spread = flakes.area_spread;
  expected.area_square = flakes.area_square;
  expected.probability = probability;
  const T cos_alpha = static_cast<T>(way.mirror.cos_alpha);

  // T of a pixel that shows the light in a mirror, 1/Omega through the surface twice. Omega outside
  // that belongs to `inside` is inside/ratio.
  expected.ceiling = static_cast<T>(way.surface * way.ratio / inside);
  expected.reflectance = coating_reflectance(flakes.coating, cos_alpha);
  expected.share = sparkling_share(way.breadth, way.apart, turned_by(flakes, layer.eta));
  expected.mirror = expected.reflectance * (expected.ceiling * expected.share);
  // A = (1 - e^-tH)/tH.
  expected.slant = way.slant;
  if (!way.given) expected.hidden = hidden_whole(layer, flakes, way.slant, way.ways);
  expected.transmitted = mean_transmittance(expected.slant);

  // A flake shows min(S, area that fills the pixel); more flakes make up for what is cut off.
  // Smaller than an atom or larger than a town, a pixel looks like one of that size: the squares of
  // areas stay inside a float.
  const T footprint = clamp(pixel_area, T(1e-20), T(1e6));
  expected.fill = footprint * way.cos_exit / (flakes.flake_area * cos_alpha);
  expected.area_mean = capped_area_mean(flakes.area_spread, expected.fill, flakes.area_mean);
  T enlarged = 1;
  if (expected.area_mean < flakes.area_mean) enlarged = flakes.area_mean / expected.area_mean;
  // Paper, eq. 5 and step 7: <N> = Sigma D H Pr.
  expected.mean_count = flakes.areal_density * footprint * enlarged * probability;

  const T places = expected.fill / flakes.area_mean;
  if (places < T(kPoissonSlots)) expected.slots = static_cast<int>(max(places, T(1)));
  const T slots = static_cast<T>(expected.slots);
  // More sparkles than the pixel has places for (a light about as wide as the tilt, seen from near)
  // hide each other as wholes: thinned, whatever the depth model.
  const bool crowded = expected.slots > 0 && expected.mean_count > slots;
  if (layer.depth_model == DepthModel::thinned || crowded) {
    // Only the neither masked nor shadowed flakes count (paper, eq. 6), as many as the least
    // absorbed colour sees; what the other colours lose besides dims them all alike.
    const Rgb<T> transmitted = expected.transmitted;
    const T visible = max_component(transmitted);
    if (visible > 0) expected.mirror = expected.mirror * (transmitted / visible);
    expected.mean_count = expected.mean_count * visible;
    expected.slant = {};
    expected.hidden = 0;
    expected.transmitted = grey(T(1));
  }
  // Flakes that transmit hide too few: then every place is taken, and shows a share of them each.
  if (expected.slots > 0 && expected.mean_count > slots) {
    expected.mirror = expected.mirror * (expected.mean_count / slots);
    expected.mean_count = slots;
  }
  // The paper's Bernoulli rule (step 3).
  if (layer.radiometry == Radiometry::published && expected.slots == 0 &&
      expected.mean_count < T(0.1)) {
    expected.slots = 1;
  }
  return expected;
}

// The sparkles of one species.
template <class T>
ExpectedSparkles<T> expect_sparkles(const Layer<T>& layer, const Flakes<T>& flakes, T pixel_area,
                                    const Passage<T>& way) {
  const Wide<T> inside = way.open ? cone_in_binder(flakes, way) : 0;
  if (!(inside > 0)) return {};
  Wide<T> probability = flake_probability(flakes.orientation, layer.radiometry,
                                          way.mirror.sin2_half_beta, quarter_cone(inside, way));
  if (way.outline.given) {
    const Wide<T> factor =
        outline_factor(flakes.orientation, way.outline, way.mirror.sin2_half_beta,
                       quarter_cone(way.outline.inside, way));
    probability = min(probability * factor, Wide<T>(1));
  }
  return expect_sparkles(layer, flakes, pixel_area, way, inside, static_cast<T>(probability));
}

// Of one species, in one call.
template <class T>
ExpectedSparkles<T> expect_sparkles(const Layer<T>& layer, const SurfacePoint<T>& point,
                                    const SeenLight<T>& light, const Rgb<T>* slant = nullptr,
                                    std::size_t species = 0) {
  return expect_sparkles(layer, layer.flakes[species], point.footprint,
                         pass_between(layer, point, light, slant));
}

// Mean and mean square of what one sparkle adds, per colour, relative to a filled, undimmed pixel:
// Y = min(X, fill)/fill e^(-(x - h) u) with the probability e^(-h u), else 0, u uniform, x the
// optical depth. Of the square A(2 x - h) is left.
template <class T>
Rgb<T> mean_sparkle(const ExpectedSparkles<T>& expected) {
  return expected.transmitted * (expected.area_mean / expected.fill);
}
template <class T>
Rgb<T> mean_square_sparkle(const ExpectedSparkles<T>& expected) {
  const T square = capped_area_square(expected.area_spread, expected.fill);
  return mean_transmittance(expected.slant * T(2) - grey(expected.hidden)) *
         (square / expected.fill / expected.fill);
}

// E[T] = <N> E[Y] mirror: cos(theta') f for the exact radiometry.
template <class T>
Rgb<T> mean_radiance(const ExpectedSparkles<T>& expected) {
  return expected.mirror * (mean_sparkle(expected) * expected.mean_count);
}

// Var[T] = <N> E[Y^2] mirror^2, the compound Poisson law; less <N>^2 E[Y]^2/k for a binomial count.
// `contrast` (ours): the share of the fluctuation that the paint shows.
template <class T>
Rgb<T> radiance_variance(const ExpectedSparkles<T>& expected, T contrast = 1) {
  Rgb<T> variance = mean_square_sparkle(expected) * expected.mean_count;
  if (expected.slots > 0) {
    const Rgb<T> mean = mean_sparkle(expected) * expected.mean_count;
    variance = variance - mean * mean / static_cast<T>(expected.slots);
  }
  // One place always taken has no variance, which rounding may leave below 0.
  variance = map(variance, [&](T v) { return max(v, T(0)) * (contrast * contrast); });
  return expected.mirror * (expected.mirror * variance);
}

}  // namespace metallic_paint
