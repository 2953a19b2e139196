// SPDX-License-Identifier: Apache-2.0
//
// Gauss-Legendre quadrature on [0, 1]. The shader carries the float rule as two arrays of numbers.
#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <numbers>
#include <type_traits>

#include "vector.h"

namespace metallic_paint {

template <class T>
inline constexpr int kGaussPoints = std::is_same_v<T, float> ? 12 : 64;

template <class T>
struct GaussRule {
  std::array<T, kGaussPoints<T>> node, weight;
};

// Nodes as roots of the Legendre polynomial by Newton's method, exact to rounding in T.
template <class T>
GaussRule<T> make_gauss_rule() {
  constexpr int n = kGaussPoints<T>;
  GaussRule<T> rule;
  for (int i = 0; i < n; ++i) {
    T x = std::cos(std::numbers::pi_v<T> * (i + T(0.75)) / (n + T(0.5)));
    T derivative = 1;
    for (int step = 0; step < 8; ++step) {
      T previous = 1, value = x;
      for (int k = 2; k <= n; ++k) {
        const T next = ((2 * k - 1) * x * value - (k - 1) * previous) / k;
        previous = value;
        value = next;
      }
      derivative = n * (x * value - previous) / (x * x - 1);
      x -= value / derivative;
    }
    rule.node[n - 1 - i] = (1 + x) / 2;
    rule.weight[n - 1 - i] = 1 / ((1 - x * x) * derivative * derivative);
  }
  return rule;
}

template <class T>
const GaussRule<T>& gauss_rule() {
  static const GaussRule<T> rule = make_gauss_rule<T>();
  return rule;
}
template <std::same_as<float> T>
const GaussRule<T>& gauss_rule() {
  static const GaussRule<T> rule = {
      {0.00921968288f, 0.0479413718f, 0.115048663f, 0.206341023f, 0.316084251f, 0.437383296f,
       0.562616704f, 0.683915749f, 0.793658977f, 0.884951337f, 0.952058628f, 0.990780317f},
      {0.0235876682f, 0.053469663f, 0.0800391643f, 0.101583713f, 0.116746268f, 0.124573523f,
       0.124573523f, 0.116746268f, 0.101583713f, 0.0800391643f, 0.053469663f, 0.0235876682f}};
  return rule;
}

}  // namespace metallic_paint
