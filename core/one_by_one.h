// SPDX-License-Identifier: Apache-2.0
//
// The paper's sum (step 4), sparkle after sparkle: what the draw is held against (draw.h).
#pragma once

#include "draw.h"
#include "expected_sparkles.h"
#include "random.h"
#include "vector.h"

namespace metallic_paint {

// T of n sparkles, with no ceiling.
template <class T>
Rgb<T> sum_one_by_one(const ExpectedSparkles<T>& expected, HashKey key, int n) {
  Rgb<T> sum{};
  for (int number = 0; number < n; ++number) {
    sum = sum + draw_sparkle(expected, uniform_deviates(key, static_cast<float>(number)));
  }
  return expected.mirror * sum;
}

}  // namespace metallic_paint
