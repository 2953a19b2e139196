// SPDX-License-Identifier: Apache-2.0
//
// What flakes let through, whatever their coating, by quadrature.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "../coating.h"
#include "../orientation.h"
#include "../quadrature.h"
#include "../vector.h"

namespace metallic_paint::reference {

// <t_p>(theta) = integral of p(n_f) |v . n_f| t_p(acos |v . n_f|): the part of a flake's mean
// projected area that its coating lets through; cosine in the binder. Over the azimuth the
// integrand is smooth on either side of v . n_f = 0; over beta both sides meet at 90 degrees -
// theta. double: relative error 1e-12, but for kinks of t_p: absolute 5e-6. transmittance(x):
// Rgb<T> at cos(alpha) = x.
template <class T, class Transmittance>
Rgb<T> mean_transmitted_area(const OrientationDensity<T>& density,
                             const Transmittance& transmittance, T cos_theta) {
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
        sum = sum + transmittance(x) * (ring * width * rule.weight[j] * x);
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

// Of a coating of the model.
template <class T>
Rgb<T> mean_transmitted_area(const OrientationDensity<T>& density, const Coating<T>& coating,
                             T cos_theta) {
  return mean_transmitted_area(
      density, [&](T x) { return coating_transmittance(coating, x); }, cos_theta);
}

}  // namespace metallic_paint::reference
