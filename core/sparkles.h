// SPDX-License-Identifier: Apache-2.0
//
// The sparkles of one light in one pixel (paper, 5.3.5): how many flakes happen to mirror the
// light, and the radiance they send, per unit of the light's irradiance on a plane normal to it: T
// = L/E_n. What no deviate touches comes first
// (`expect_sparkles`), then the draw (`draw_sparkles`), and the draw's mean and variance in closed
// form.
//
// A sparkling flake shows the light's own radiance E_n/Omega, dimmed by both passages of the
// surface, by its coating and by the layer above it, and covers the share S
// cos(alpha)/(cos(theta_p) Sigma) of the pixel. The flux written out, with I(1 - r')/cos(theta'_p)
// inside the binder and the exit cone transformed like the entry cone, gives the same. The paper's
// (9) and (1) have cos(theta) for cos(theta_p): Radiometry::published. With Omega the solid angle
// of the light seen from outside, E[T] = cos(theta') f with the reciprocal BRDF of the layer's
// single scattering
//   f = D H <S> p(n_f) r_p A (1 - r)(1 - r')/(4 eta^2 cos(theta_p) cos(theta'_p)).
// For lights wide against the flakes' tilt p(n_f) is its mean over the light's cone
// (`cap_probability`), and so is that of f. Against explicit flakes, eta >= 1.3
// (tests/core/explicit_flakes_test.cpp), the mean of random scenes is within 1 % while the quarter
// cone's radius is below a quarter of the tilt, 3 % up to the tilt, 10 % up to twice the tilt.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "coating.h"
#include "flake_area.h"
#include "light.h"
#include "optical_thickness.h"
#include "orientation.h"
#include "poisson.h"
#include "random.h"
#include "refraction.h"
#include "vector.h"

namespace metallic_paint {

// With, without masking and shadowing (paper, 5.3.2). Which is right the paper left open: against
// discs that really hide each other (docs/accuracy) attenuated fluctuates more like them. The mean
// that both share takes the ways to observer and light for independent; where they run past the
// same flakes (light behind the observer, flakes as large as the layer is thick) the discs are
// brighter, up to twice at a coverage of 3.
enum class DepthModel { attenuated = 0, thinned = 1 };
// published: the paper's formulas to the letter wherever its assumption holds, flakes far below the
// pixel. Where fewer than kPoissonSlots flakes fill the pixel, it too is kept below the mirror, by
// the same count and ceiling as exact.
enum class Radiometry { exact = 0, published = 1 };

// One species of flakes. SI units.
template <class T>
struct Flakes {
  T areal_density{};      // D H, flakes per m2 of paint
  T flake_area{};         // mean of the area's normal deviate, m2
  T area_spread{};        // its standard deviation over its mean
  AreaMoments<T> area{};  // moments of the area in units of flake_area
  T coverage{};           // D H <S>
  OrientationDensity<T> orientation{};
  T solid_angle{};  // pi epsilon^2: what the flake itself adds to the light's cone, sr in the
                    // binder
  Coating<T> coating{};
  // The paper's tables, in place of the exact functions where they are given.
  const OrientationTable<T>* orientation_table = nullptr;  // P(beta)
  const ProjectionTable<T>* projection_table = nullptr;    // <s> - <t_p>
};

inline constexpr int kSpecies = 3;

// A paint as the evaluation needs it. SI units; made and checked by `make_layer` (paint.h).
template <class T>
struct Layer {
  std::array<Flakes<T>, kSpecies> flakes;
  int species;  // so many of them are in use
  T coverage;   // of all species together
  T eta;
  Rgb<T> binder_depth;  // H ((16 pi/3) c1 + kappa)
  T rayleigh_depth;     // H (16 pi/3) c1
  DepthModel depth_model;
  Radiometry radiometry;
  T sparkle_contrast;  // share of the sparkles' fluctuation that is shown
};

// Where the paint is looked at. The view is a unit vector towards the observer.
template <class T>
struct SurfacePoint {
  Vec3<T> position, normal, view;
  T footprint;  // Sigma, area of the pixel's projection on the surface, m2
  int pixel_x, pixel_y;
};

// Everything about the sparkles of a light in a pixel but the deviates.
template <class T>
struct ExpectedSparkles {
  T mean_count{};         // <N>
  int slots{};            // 0: Poisson; k: binomial with k places
  T fill{1};              // mean flake areas that fill the pixel
  AreaMoments<T> area{};  // moments of min(X, fill)
  Rgb<T> slant{};         // optical depth of the layer, there and back: t H
  Rgb<T> mirror{};        // T of a pixel filled by an undimmed sparkle
  T ceiling{};            // T of a pixel filled by a perfect mirror: nothing exceeds it
  T contrast{1};          // share of the fluctuation that the paint shows
};

template <class T>
struct Sparkles {
  T count{};
  Rgb<T> radiance{};  // T
};

// P(beta) of the flakes.
template <class T>
Wide<T> flake_density(const Flakes<T>& flakes, Wide<T> sin2_half_beta) {
  if (flakes.orientation_table == nullptr) {
    return orientation_density(flakes.orientation, sin2_half_beta);
  }
  return flakes.orientation_table->at(static_cast<T>(sin2_half_beta));
}

// Probability that a flake's normal lies within rho of a direction at beta from the paint normal.
// Published: P at the centre of the cone, as in the paper's eq. 4, but at most 1.
template <class T>
Wide<T> flake_probability(const Flakes<T>& flakes, Radiometry radiometry, Wide<T> sin2_half_beta,
                          Wide<T> sin2_half_rho) {
  if (radiometry == Radiometry::exact && flakes.orientation_table == nullptr) {
    return cap_probability(flakes.orientation, sin2_half_beta, sin2_half_rho);
  }
  return std::min(2 * flake_density(flakes, sin2_half_beta) * sin2_half_rho, Wide<T>(1));
}

// D H <S> (<s> - <t_p>) of all species: what the flakes take out of a beam, per colour, times its
// cosine in the binder.
template <class T>
Rgb<T> flake_blocking(const Layer<T>& layer, T cos_in) {
  Rgb<T> sum{};
  for (int i = 0; i < layer.species; ++i) {
    const Flakes<T>& flakes = layer.flakes[static_cast<std::size_t>(i)];
    sum = sum + blocked_area(flakes.orientation, flakes.coating, flakes.projection_table, cos_in) *
                    flakes.coverage;
  }
  return sum;
}

// The optical depth of the layer along view and light, given the cosines in the binder.
template <class T>
Rgb<T> slant_depth_of(const Layer<T>& layer, T cos_in) {
  return slant_depth(flake_blocking(layer, cos_in), layer.binder_depth, cos_in);
}

// What the flakes of all species share: the way of a light through this point to the observer.
template <class T>
struct Passage {
  bool open = false;  // false: no flake can send this light to the observer
  Mirror<Wide<T>> mirror{};
  Wide<T> inside{}, ratio{};  // the light's cone in the binder, sr; that over its cone outside
  Wide<T> surface{};          // transmittance of the surface, in and out
  T cos_exit{};               // cosine of the exit by which flakes cover the pixel
  Rgb<T> slant{};             // optical depth of the layer, there and back: t H
};

// `slant` overrides the layer's own optical depth t H where it is given (validation against other
// codes).
template <class T>
Passage<T> pass_between(const Layer<T>& layer, const SurfacePoint<T>& point,
                        const SeenLight<T>& light, const Rgb<T>* slant = nullptr) {
  using W = Wide<T>;
  constexpr W pi = std::numbers::pi_v<W>;
  Passage<T> way;
  const bool published = layer.radiometry == Radiometry::published;
  if (!light.visible || !(point.footprint > 0)) return way;
  const W eta = layer.eta;
  way.mirror = mirror_between(Vec3<W>(point.normal), Vec3<W>(point.view), light.direction, eta);
  way.open = way.mirror.possible;  // a light or an observer below the surface: no sparkle
  if (!way.open) return way;
  const T cos_view_in = static_cast<T>(std::min(way.mirror.g_view / eta, W(1)));
  const T cos_light_in = static_cast<T>(std::min(way.mirror.g_light / eta, W(1)));
  way.cos_exit = published ? static_cast<T>(way.mirror.cos_view) : cos_view_in;

  // The light's cone in the binder (paper, eq. 7). Published: pi Delta_a^2; exact: the true solid
  // angle 4 pi sin^2(Delta_a/2).
  const W h = light.sin2_half_radius;
  const W outside = published ? pi * squared_angle(h) : 4 * pi * h;
  way.ratio = solid_angle_ratio(way.mirror.cos_light, way.mirror.g_light, eta);
  way.inside = outside * way.ratio;
  way.slant = slant != nullptr
                  ? *slant
                  : slant_depth_of(layer, cos_view_in) + slant_depth_of(layer, cos_light_in);
  way.surface = fresnel_transmittance(way.mirror.cos_view, way.mirror.g_view, eta) *
                fresnel_transmittance(way.mirror.cos_light, way.mirror.g_light, eta);
  return way;
}

// A pixel that one flake can fill (ours). Where fewer than this many mean flakes fill the pixel,
// the count is binomial with as many places as flakes fit, so that the sum stays under the mirror's
// radiance with the same mean.
inline constexpr int kPoissonSlots = 16;

// No cone in the binder counts as less, in sr: 1/cone^2 stays a number. The mean is the same.
template <class T>
inline constexpr double kLeastCone = 1e-100;
template <>
inline constexpr double kLeastCone<float> = 1e-18;

// The sparkles of one species.
template <class T>
ExpectedSparkles<T> expect_sparkles(const Layer<T>& layer, const Flakes<T>& flakes, T pixel_area,
                                    const Passage<T>& way) {
  using W = Wide<T>;
  constexpr W pi = std::numbers::pi_v<W>;
  ExpectedSparkles<T> expected;
  expected.contrast = layer.sparkle_contrast;
  if (!way.open) return expected;
  const T cos_alpha = static_cast<T>(way.mirror.cos_alpha);

  // Delta_eff^2 = Delta^2 + epsilon^2
  W inside = way.inside + flakes.solid_angle;
  if (!(inside > 0)) return expected;  // a point light on perfect mirrors: no flake ever meets it
  inside = std::max(inside, W(kLeastCone<T>) * std::max(way.ratio, W(1)));

  // Probability that a flake's normal lies in the quarter cone about n_f (paper, eq. 4).
  const T probability =
      static_cast<T>(flake_probability(flakes, layer.radiometry, way.mirror.sin2_half_beta,
                                       inside / (16 * pi * way.mirror.cos_alpha)));

  // T of a pixel that shows the light in a mirror, 1/Omega through the surface twice. Omega outside
  // that belongs to `inside` is inside/ratio.
  expected.ceiling = static_cast<T>(way.surface * way.ratio / inside);
  expected.mirror = coating_reflectance(flakes.coating, cos_alpha) * expected.ceiling;
  // What the layer leaves on average of a beam to a random depth is A = (1 - e^-tH)/tH.
  expected.slant = way.slant;

  // A flake shows min(S, area that fills the pixel); more flakes make up for what is cut off.
  // Smaller than an atom or larger than a town, a pixel looks like one of that size: the squares of
  // areas stay inside a float.
  const T footprint = std::clamp(pixel_area, T(1e-20), T(1e6));
  expected.fill = footprint * way.cos_exit / (flakes.flake_area * cos_alpha);
  expected.area = capped_area_moments(flakes.area_spread, expected.fill, flakes.area);
  T enlarged = 1;
  if (expected.area.mean < flakes.area.mean) enlarged = flakes.area.mean / expected.area.mean;
  // Paper, eq. 5 and step 7: <N> = Sigma D H Pr.
  expected.mean_count = flakes.areal_density * footprint * enlarged * probability;

  const T places = expected.fill / flakes.area.mean;
  if (places < T(kPoissonSlots)) expected.slots = static_cast<int>(std::max(places, T(1)));
  const T slots = static_cast<T>(expected.slots);
  // More sparkles than the pixel has places for (a light about as wide as the tilt, seen from near)
  // hide each other as wholes: thinned, whatever the depth model.
  const bool crowded = expected.slots > 0 && expected.mean_count > slots;
  if (layer.depth_model == DepthModel::thinned || crowded) {
    // Only the neither masked nor shadowed flakes count (paper, eq. 6), as many as the least
    // absorbed colour sees; what the other colours lose besides dims them all alike.
    const Rgb<T> transmitted = map(expected.slant, [](T x) { return mean_transmittance(x); });
    const T visible = max_component(transmitted);
    if (visible > 0) expected.mirror = expected.mirror * (transmitted / visible);
    expected.mean_count = expected.mean_count * visible;
    expected.slant = {};
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

// Of one species, in one call.
template <class T>
ExpectedSparkles<T> expect_sparkles(const Layer<T>& layer, const SurfacePoint<T>& point,
                                    const SeenLight<T>& light, const Rgb<T>* slant = nullptr,
                                    std::size_t species = 0) {
  return expect_sparkles(layer, layer.flakes[species], point.footprint,
                         pass_between(layer, point, light, slant));
}

// Mean and mean square of what one sparkle adds, per colour, relative to a filled, undimmed pixel:
// Y = min(X, fill)/fill e^(-x u), u uniform, x the optical depth.
template <class T>
Rgb<T> mean_sparkle(const ExpectedSparkles<T>& expected) {
  const T share = expected.area.mean / expected.fill;
  return map(expected.slant, [&](T x) { return share * mean_transmittance(x); });
}
template <class T>
Rgb<T> mean_square_sparkle(const ExpectedSparkles<T>& expected) {
  const T share = expected.area.square / expected.fill / expected.fill;
  return map(expected.slant, [&](T x) { return share * mean_transmittance(2 * x); });
}

// E[T] = <N> E[Y] mirror: cos(theta') f for the exact radiometry.
template <class T>
Rgb<T> mean_radiance(const ExpectedSparkles<T>& expected) {
  return expected.mirror * (mean_sparkle(expected) * expected.mean_count);
}

// The share that is left of the radiance's fluctuation about its mean: the paint's contrast (ours),
// and less from afar. From so far that it is below one step of 8 bits, 1/256, the mean takes the
// place of the draw; on the way there, from twice that variance on, it fades.
inline constexpr int kFarCount = 65536;
template <class T>
T fluctuation_left(const ExpectedSparkles<T>& expected) {
  if (!(expected.mean_count > T(kFarCount / 2))) return expected.contrast;
  // mean^2/variance, of the colour that fluctuates most
  const Rgb<T> mean = mean_sparkle(expected), square = mean_square_sparkle(expected);
  T least = expected.mean_count;
  const auto add = [&](T m, T q) {
    if (q > 0) least = std::min(least, expected.mean_count * (m * m / q));
  };
  add(mean.x, square.x);
  add(mean.y, square.y);
  add(mean.z, square.z);
  return expected.contrast * std::clamp(2 - least / T(kFarCount / 2), T(0), T(1));
}

// Var[T] = <N> E[Y^2] mirror^2, the compound Poisson law; less <N>^2 E[Y]^2/k for a binomial count.
// Of both, what is left of the fluctuation, squared.
template <class T>
Rgb<T> radiance_variance(const ExpectedSparkles<T>& expected) {
  const T left = fluctuation_left(expected);
  Rgb<T> variance = mean_square_sparkle(expected) * expected.mean_count;
  if (expected.slots > 0) {
    const Rgb<T> mean = mean_sparkle(expected) * expected.mean_count;
    variance = variance - mean * mean / static_cast<T>(expected.slots);
  }
  // One place always taken has no variance, which rounding may leave below 0.
  variance = map(variance, [](T v) { return std::max(v, T(0)); });
  return expected.mirror * (expected.mirror * (variance * (left * left)));
}

// So many sparkles of a pixel are drawn one by one.
inline constexpr int kDrawnSparkles = 16;

// One sparkle's Y: its area by the words x and y, its depth by the word z.
template <class T>
Rgb<T> draw_sparkle(const ExpectedSparkles<T>& expected, T area_spread, HashWords words) {
  T area = 1;
  if (area_spread > 0) {
    area = std::max(1 + area_spread * normal_quantile(uniform_48<T>(words.x, words.y)), T(0));
  }
  const T share = std::min(area, expected.fill) / expected.fill;
  const T depth = uniform_23<T>(words.z);
  return map(expected.slant, [&](T x) { return x > 0 ? share * exponential(-x * depth) : share; });
}

// The sum of `count` sparkles in a colour of optical depth x, relative to a filled, undimmed pixel,
// from a normal deviate w as w + c (w^2 - 1): with the exact mean, variance and skewness of the sum
// given the count (Cornish and Fisher's first term). The skewness g of that deviate is (6 c +
// 8 c^3)/(1 + 2 c^2)^(3/2); two steps solve for c to 1 % of g while c <= 1/4.
template <class T>
T sum_of_many(const ExpectedSparkles<T>& expected, T x, T count, T w) {
  // Moments of a sparkle relative to its mean share of the pixel.
  const T mean_area = expected.area.mean;
  const T share = mean_area / expected.fill;
  const T m1 = mean_transmittance(x);
  const T m2 = expected.area.square / (mean_area * mean_area) * mean_transmittance(2 * x);
  const T m3 = expected.area.cube / (mean_area * mean_area * mean_area) * mean_transmittance(3 * x);
  const T variance = m2 - m1 * m1;
  if (!(variance > m2 * T(1e-5))) return share * m1 * count;  // equal flakes: their count
  const T spread = std::sqrt(variance * count);
  const T skewness = (m3 - 3 * m2 * m1 + 2 * m1 * m1 * m1) / (variance * spread);
  T c = std::clamp(skewness / 6, T(-0.25), T(0.25));
  for (int i = 0; i < 2; ++i) {
    const T q = 1 + 2 * c * c;
    c = std::clamp(skewness * q * std::sqrt(q) / (6 + 8 * c * c), T(-0.25), T(0.25));
  }
  return share * (m1 * count + spread * (w + c * (w * w - 1)) / std::sqrt(1 + 2 * c * c));
}

// The count and the radiance of this pixel. Up to kDrawnSparkles sparkles are drawn one by one;
// above, their sum is.
template <class T>
Sparkles<T> draw_sparkles(const ExpectedSparkles<T>& expected, T area_spread, HashWords key,
                          int pixel_x, int pixel_y) {
  Sparkles<T> sparkles;
  if (!(expected.mean_count > 0)) return sparkles;
  const T left = fluctuation_left(expected);
  // No pixel outshines the light in a mirror (ours).
  const auto bounded = [&](Rgb<T> radiance) {
    return map(radiance, [&](T t) { return std::min(std::max(t, T(0)), expected.ceiling); });
  };
  if (!(left > 0)) {
    return {std::floor(expected.mean_count + T(0.5)), bounded(mean_radiance(expected))};
  }
  const HashWords words = draw_words(key, pixel_x, pixel_y, 0);
  const T count =
      count_deviate(expected.mean_count, expected.slots, uniform_48<T>(words.x, words.y));
  sparkles.count = count;

  Rgb<T> sum{};
  if (count <= T(kDrawnSparkles)) {
    const int n = static_cast<int>(count);
    for (int i = 1; i <= n; ++i) {
      sum = sum + draw_sparkle(expected, area_spread, draw_words(key, pixel_x, pixel_y, i));
    }
  } else {
    const T w = normal_quantile(uniform_48<T>(words.z, words.w));
    sum = map(expected.slant, [&](T x) { return sum_of_many(expected, x, count, w); });
  }
  if (left < 1) {
    const Rgb<T> mean = mean_sparkle(expected) * expected.mean_count;
    sum = mean + (sum - mean) * left;
  }
  sparkles.radiance = bounded(expected.mirror * sum);
  return sparkles;
}

// All species of a layer under one light in one pixel. Their sparkles are independent; together
// too they do not outshine the light in a mirror.
template <class T>
struct PixelSparkles {
  std::array<ExpectedSparkles<T>, kSpecies> expected{};
  std::array<T, kSpecies> count{};
  Rgb<T> radiance{}, mean_radiance{}, variance{};  // of all species
};

template <class T>
PixelSparkles<T> sparkle(const Layer<T>& layer, const SurfacePoint<T>& point, const Passage<T>& way,
                         int light, int frame, int seed) {
  PixelSparkles<T> all;
  T ceiling = 0;
  for (int i = 0; i < layer.species; ++i) {
    const std::size_t at = static_cast<std::size_t>(i);
    const Flakes<T>& flakes = layer.flakes[at];
    const ExpectedSparkles<T> expected = expect_sparkles(layer, flakes, point.footprint, way);
    const Sparkles<T> drawn =
        draw_sparkles(expected, flakes.area_spread, stream_key(light, i, frame, seed),
                      point.pixel_x, point.pixel_y);
    all.expected[at] = expected;
    all.count[at] = drawn.count;
    all.radiance = all.radiance + drawn.radiance;
    all.mean_radiance = all.mean_radiance + mean_radiance(expected);
    all.variance = all.variance + radiance_variance(expected);
    ceiling = std::max(ceiling, expected.ceiling);
  }
  all.radiance = map(all.radiance, [&](T t) { return std::min(t, ceiling); });
  return all;
}

// The mean as a BRDF (1/sr): single scattering by the flakes under light of any size and kind,
//   f = D H <S> p(n_f) r_p A (1 - r)(1 - r')/(4 eta^2 cos(theta_p) cos(theta'_p)),
// published: times cos(theta_p)/cos(theta), which is not reciprocal. Unit vectors, all pointing
// away from the surface; 0 where one of them lies below it.
template <class T>
Rgb<T> flake_brdf(const Layer<T>& layer, Vec3<T> normal, Vec3<T> view, Vec3<T> light) {
  using W = Wide<T>;
  const W eta = layer.eta;
  const Mirror<W> mirror = mirror_between(Vec3<W>(normal), Vec3<W>(view), Vec3<W>(light), eta);
  if (!mirror.possible) return {};
  const Rgb<T> slant = slant_depth_of(layer, static_cast<T>(std::min(mirror.g_view / eta, W(1)))) +
                       slant_depth_of(layer, static_cast<T>(std::min(mirror.g_light / eta, W(1))));
  const W exit = layer.radiometry == Radiometry::published ? eta * mirror.cos_view : mirror.g_view;
  const W surface = fresnel_transmittance(mirror.cos_view, mirror.g_view, eta) *
                    fresnel_transmittance(mirror.cos_light, mirror.g_light, eta);
  Rgb<T> sum{};
  for (int i = 0; i < layer.species; ++i) {
    const Flakes<T>& flakes = layer.flakes[static_cast<std::size_t>(i)];
    const W p = flake_density(flakes, mirror.sin2_half_beta) / (2 * std::numbers::pi_v<W>);
    sum = sum + coating_reflectance(flakes.coating, static_cast<T>(mirror.cos_alpha)) *
                    static_cast<T>(flakes.coverage * p * surface / (4 * exit * mirror.g_light));
  }
  return sum * map(slant, [](T x) { return mean_transmittance(x); });
}

}  // namespace metallic_paint
