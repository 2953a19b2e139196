// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

#include "random.h"

namespace metallic_paint::reference {

// Point i of a golden-angle spiral over the unit disc, turned and shifted at random so that each is
// uniform in its ring of equal area: means over the disc come out without bias.
class Spiral {
 public:
  Spiral(int points, RandomStream& random)
      : points_(points), shift_(random()), turn_(2 * std::numbers::pi * random()) {}
  double area_within(int i) const { return (i + shift_) / points_; }  // relative
  double angle(int i) const { return turn_ + kGoldenAngle * i; }

 private:
  static constexpr double kGoldenAngle = 2 * std::numbers::pi * (1 - 1 / std::numbers::phi);
  double points_, shift_, turn_;
};

}  // namespace metallic_paint::reference
