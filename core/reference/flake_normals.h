// SPDX-License-Identifier: Apache-2.0
//
// The flakes' normals for the references: density, mean projected area, and samples of them, of all
// flakes and of those that a ray meets. Of the core it takes the names of the orientations only
// (see orientation.h).
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "../orientation.h"
#include "../vector.h"
#include "random.h"

namespace metallic_paint::reference {

class FlakeNormals {
 public:
  FlakeNormals(Orientation kind, double tilt);

  // p(n) = P(beta)/2pi, per solid angle; the paint normal is z. n and -n are the same flake.
  double density(Vec3<double> n) const;

  // <s> = integral of p(n) |v . n| over the half sphere.
  double projected_area(double cos_theta) const;

  // Integral of p(n) |v . n| t(|v . n|), <t_p> for a coating that lets t through, by midpoints over
  // the azimuth: exact to 1e-4 for the coatings of the library.
  template <class Transmittance>
  Rgb<double> transmitted_area(double cos_theta, const Transmittance& t) const {
    constexpr int steps = 64;
    const double sin_theta = std::sqrt((1 - cos_theta) * (1 + cos_theta));
    Rgb<double> sum{};
    for (const Ring& ring : rings_) {
      for (int i = 0; i < steps; ++i) {
        const double turn = std::cos(std::numbers::pi * (i + 0.5) / steps);
        const double cosine =
            std::abs(cos_theta * ring.cos_beta + sin_theta * ring.sin_beta * turn);
        sum = sum + t(std::min(cosine, 1.0)) * (ring.share * cosine / steps);
      }
    }
    return sum;
  }

  // A normal with density p(n), above the horizon.
  Vec3<double> sample(RandomStream& random) const;

  // A normal with density p(n) |v . n|/<s>, either of its two signs.
  Vec3<double> sample_met(Vec3<double> v, RandomStream& random) const;

  double tilt() const { return tilt_; }

 private:
  double shape(double sin_beta, double cos_beta) const;

  Orientation kind_;
  double tilt_;
  double norm_ = 0;  // integral of the shape times sin(beta)
  struct Ring {
    double share, sin_beta, cos_beta;  // of all flakes
  };
  std::vector<Ring> rings_;
};

// <s> interpolated, relative error below 4e-6.
class ProjectedAreaTable {
 public:
  explicit ProjectedAreaTable(const FlakeNormals& normals);
  double at(double cos_theta) const;

 private:
  double w_;  // <s> bends where the cosine is about a tilt
  double step_;
  std::vector<double> value_;
};

}  // namespace metallic_paint::reference
