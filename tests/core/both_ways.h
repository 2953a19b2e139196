// SPDX-License-Identifier: Apache-2.0
//
// The integral that core/hot_spot.h fits, from the discs' overlap. For its test and its fit.
#pragma once

#include <cmath>

#include "independent.h"

namespace core_tests {

// O(u): what two discs of diameter 1 whose middles are u apart share, of the area of one.
inline independent::Real overlap(independent::Real u) {
  return u >= 1 ? 0 : 2 / independent::kPi * (std::acos(u) - u * std::sqrt(1 - u * u));
}

// The integral of P(z) over the layer, by two midpoint rules in one another.
inline independent::Real free_on_both_ways(independent::Real c, independent::Real w,
                                           independent::Real x) {
  using independent::Real;
  constexpr int kSteps = 4'000;
  Real shared = 0, sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const Real z = (i + Real(0.5)) / kSteps;
    const Real half = c * overlap(w * z) / kSteps / 2;
    sum += std::exp(shared + half - x * z) / kSteps;
    shared += 2 * half;
  }
  return sum;
}

}  // namespace core_tests
