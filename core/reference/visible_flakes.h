// SPDX-License-Identifier: Apache-2.0
//
// The flakes' normals for the brute-force references: density, mean projected area, and the normals
// that a ray meets. Of the core it takes the names of the orientations only (see orientation.h).
#pragma once

#include <cstdint>
#include <vector>

#include "orientation.h"
#include "vector.h"

namespace metallic_paint::reference {

// SplitMix64 (Steele, Lea and Flood 2014, Fast splittable pseudorandom number generators).
class UniformRandom {
 public:
  UniformRandom(std::uint64_t seed, std::uint64_t stream) : state_(mixed(mixed(seed) + stream)) {}

  // In [0, 1), 53 bits.
  double operator()() {
    state_ += 0x9e3779b97f4a7c15;
    return static_cast<double>(mixed(state_) >> 11) * 0x1p-53;
  }

 private:
  static std::uint64_t mixed(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};

class VisibleFlakes {
 public:
  VisibleFlakes(Orientation kind, double tilt);

  // p(n) = P(beta)/2pi, per solid angle; the paint normal is z. n and -n are the same flake.
  double density(Vec3<double> n) const;

  // <s> = integral of p(n) |v . n| over the half sphere: interpolated, relative error below 4e-6.
  double projected_area(double cos_theta) const;

  // A normal with density p(n) |v . n|/<s>, either of its two signs.
  Vec3<double> sample(Vec3<double> v, UniformRandom& random) const;

 private:
  double shape(double sin_beta, double cos_beta) const;

  Orientation kind_;
  double tilt_;
  double norm_ = 0;           // integral of the shape times sin(beta)
  std::vector<double> area_;  // <s> at the nodes of projected_area
};

}  // namespace metallic_paint::reference
