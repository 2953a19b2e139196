// SPDX-License-Identifier: Apache-2.0
//
// How much a reference may be asked for.
#pragma once

#include <string>

#include "../validation.h"

namespace metallic_paint::reference {

// A step is a flake made or passed by, a point of it, a photon's event or a detector that it may
// reach: 20 to 150 ns of a core (measured on an x86 of 2020). So the most is a day of one core, an
// hour of a large machine.
inline constexpr double kMostSteps = 1e12;

// factors: what the steps are the product of, by the fields that decide it.
inline void require_steps(const std::string& factors, double steps) {
  if (steps <= kMostSteps) return;
  reject(factors, text(steps, 3), "at most " + text(kMostSteps) + ", a day of one core");
}

}  // namespace metallic_paint::reference
