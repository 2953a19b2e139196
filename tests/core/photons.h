// SPDX-License-Identifier: Apache-2.0
//
// What photons found against what is expected of them.
#pragma once

#include <cmath>
#include <numbers>
#include <string>

#include "reference/estimate.h"
#include "scenes.h"
#include "support.h"

namespace core_tests {

// Standard errors come from `batches` means: Student's deviate for the normal one, to first order
// in the degrees of freedom (Fisher's expansion).
inline double student_threshold(double tests, double batches = 256) {
  const double z = sidak_threshold(kFreshLevel, tests);
  return z * (1 + (z * z + 1) / (4 * (batches - 1)));
}

inline Vec3<double> direction(double degrees, double phi = 0) {
  return spherical(degrees * std::numbers::pi / 180, phi);
}

// The largest deviation in standard errors, beyond `slack`.
inline void see(Worst& worst, Rgb<double> value, Rgb<double> error, Rgb<double> expected,
                const std::string& where, Rgb<double> slack = {}) {
  for (int i = 0; i < 3; ++i) {
    const double a = channel(value, i), b = channel(expected, i);
    const double off = std::fabs(a - b) - channel(slack, i);
    if (off <= 1e-12) {
      worst.see(0, "at", where);
    } else {
      worst.see(off / channel(error, i), "at", where, "channel", i, "value", a, "expected", b);
    }
  }
}

// Likewise of two estimates; `slack` is a share of what is expected.
inline void see(Worst& worst, const reference::Estimate& value, const reference::Estimate& expected,
                const std::string& where, double slack = 0) {
  const Rgb<double> a = value.error, b = expected.error;
  see(worst, value.mean, {std::hypot(a.x, b.x), std::hypot(a.y, b.y), std::hypot(a.z, b.z)},
      expected.mean, where, map(expected.mean, [&](double v) { return slack * std::fabs(v); }));
}

}  // namespace core_tests
