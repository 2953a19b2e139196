// SPDX-License-Identifier: Apache-2.0
//
// How the layer dims light on its way (paper, 5.3.3): tau(theta) = D<S>(<s> - <t_p>) + (16 pi/3) c1
// + kappa per unit path. All that the model needs is H times that: D H <S>, the flakes' coverage,
// takes the place of D<S>.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "coating.h"
#include "orientation.h"
#include "refraction.h"

namespace metallic_paint {

// <t_p>(theta) = integral of p(n_f) |v . n_f| t_p(acos |v . n_f|): the part of a flake's mean
// projected area that its coating lets through; cosine in the binder. Over the azimuth the
// integrand is smooth on either side of v . n_f = 0; over beta both sides meet at 90 degrees -
// theta. double: relative error 1e-12, but for the kinks of a table of the coating: absolute 5e-6.
template <class T>
Rgb<T> mean_transmitted_area(const OrientationDensity<T>& density, const Coating<T>& coating,
                             T cos_theta) {
  if (coating.table == nullptr && coating.kind == CoatingKind::colors) {
    return coating.transmittance * mean_projected_area(density, cos_theta);
  }
  constexpr T pi = std::numbers::pi_v<T>;
  const GaussRule<T>& rule = gauss_rule<T>();
  const T sin_theta = std::sqrt((1 - cos_theta) * (1 + cos_theta));
  const T split = pi / 2 - arccosine(cos_theta);
  const T limit = orientation_reach(density);
  Rgb<T> sum{};
  const auto add_ring = [&](T beta, T weight) {
    const T a = cos_theta * std::cos(beta), b = sin_theta * std::sin(beta);
    const T sign_change = a < b ? std::acos(-a / b) : pi;
    const T half = std::sin(beta / 2);
    const T ring = weight * orientation_density(density, half * half) * std::sin(beta) / pi;
    const T pieces[3] = {0, sign_change, pi};
    for (int side = 0; side < 2; ++side) {
      const T from = pieces[side], width = pieces[side + 1] - from;
      if (width <= 0) continue;
      for (int j = 0; j < kGaussPoints<T>; ++j) {
        const T x = std::abs(a + b * std::cos(from + width * rule.node[j]));
        sum = sum + coating_transmittance(coating, x) * (ring * width * rule.weight[j] * x);
      }
    }
  };
  // In pieces that grow with beta, for the sharp shapes and the tail; one ends at the kink.
  // Within a piece clustered towards its beginning, for the root of beta - split.
  T from = 0;
  for (T edge = density.tilt; from < limit; edge = edge * 4) {
    const T end = std::min(edge, limit);
    const T pieces[3] = {from, std::clamp(split, from, end), end};
    for (int piece = 0; piece < 2; ++piece) {
      const T start = pieces[piece], width = pieces[piece + 1] - start;
      if (width <= 0) continue;
      for (int i = 0; i < kGaussPoints<T>; ++i) {
        const T x = rule.node[i];
        add_ring(start + width * x * x, rule.weight[i] * 2 * x * width);
      }
    }
    from = end;
  }
  return sum;
}

// <s> and <t_p> at cos(theta_p) = 0, 1/n, ..., 1, interpolated linearly, as the paper tabulates
// them. Largest absolute error of 256 intervals: 1.5e-5 for tilts from 0.15 on, 8e-5 from 0.03 on,
// 5e-4 for any (tests/core/optical_thickness_test.cpp).
inline constexpr int kProjectionIntervals = 256;

template <class T>
struct ProjectionTable {
  std::vector<Rgb<T>> blocked;  // <s> - <t_p>

  ProjectionTable(const OrientationDensity<T>& density, const Coating<T>& coating, int intervals) {
    for (int i = 0; i <= intervals; ++i) {
      const T cosine = static_cast<T>(i) / static_cast<T>(intervals);
      blocked.push_back(grey(mean_projected_area(density, cosine)) -
                        mean_transmitted_area(density, coating, cosine));
    }
  }
};

// <t_p>/<s> of a library coating (ours): the mean of t_p over the flakes that a ray meets, by four
// that stand for all. Gauss's two points in the deviate that draws the tilt, Chebyshev's two in the
// cosine of the azimuth, cos(45 degrees) either way; |v . n_f| weights each. Largest error of <t_p>
// for tilts up to 0.2 and 0.5, in directions that come in through a surface (cos(theta) >= 0.7): on
// mica 0.008 and 0.03, on silica 0.04 and 0.1; below it 0.025 and 0.11. The coating at the mean
// angle alone errs 0.2 and 0.33.
template <class T>
Rgb<T> mean_flake_transmittance(const OrientationDensity<T>& density, const Coating<T>& coating,
                                T cos_theta) {
  const T sin_theta = std::sqrt(std::max(1 - cos_theta, T(0)) * (1 + cos_theta));
  Rgb<T> sum{};
  T area = 0;
  for (int i = 0; i < 2; ++i) {
    const SampledTilt<T> tilt =
        sample_tilt(density, i == 0 ? T(0.211324865405187117745L) : T(0.788675134594812882255L));
    const T h = tilt.sin2_half_beta;
    const T a = cos_theta * (1 - 2 * h);
    // sin(beta) = 2 sqrt(h (1 - h))
    const T b = sin_theta * (T(1.41421356237309504880L) * std::sqrt(h * (1 - h)));
    for (int side = 0; side < 2; ++side) {
      const T cosine = std::abs(side == 0 ? a + b : a - b);
      const T weight = tilt.weight * cosine;
      sum = sum + coating_transmittance(coating, cosine) * weight;
      area = area + weight;
    }
  }
  return sum / area;
}

// rho(theta) = <s> - <t_p>: what a flake of unit area takes out of a beam, per colour.
template <class T>
Rgb<T> blocked_area(const OrientationDensity<T>& density, const Coating<T>& coating,
                    const ProjectionTable<T>* table, T cos_theta) {
  if (table != nullptr) return interpolate(table->blocked, cos_theta);
  const T area = mean_projected_area(density, cos_theta);
  if (coating.table == nullptr) {
    Rgb<T> passed{};
    if (coating.kind == CoatingKind::colors) {
      passed = coating.transmittance;
    } else if (is_clear(coating.kind)) {
      passed = mean_flake_transmittance(density, coating, cos_theta);
    }
    return (grey(T(1)) - passed) * area;
  }
  return grey(area) - mean_transmitted_area(density, coating, cos_theta);
}

// H tau(theta)/cos(theta): the optical depth of the whole layer along a slanted ray in the binder;
// blocking is D H <S> (<s> - <t_p>).
template <class T>
Rgb<T> slant_depth(Rgb<T> blocking, Rgb<T> binder_depth, T cos_theta) {
  return (blocking + binder_depth) / std::max(cos_theta, T(kLeastCosine));
}

}  // namespace metallic_paint
