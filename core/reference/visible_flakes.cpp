// SPDX-License-Identifier: Apache-2.0
#include "reference/visible_flakes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace metallic_paint::reference {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kAreaIntervals = 1024;
constexpr int kBetaNodes = 1024;
// No sampler below draws a tan(beta), or for the gaussian a beta, beyond so many tilts: -log of a
// 53-bit uniform is at most 36.8, and sqrt(2 x 36.8) = 8.6.
constexpr double kReach = 9;

Vec3<double> around_z(double sin_beta, double cos_beta, double phi) {
  return {sin_beta * std::cos(phi), sin_beta * std::sin(phi), cos_beta};
}

// Mean of |a + b cos(phi)| over the azimuth.
double ring_mean(double a, double b) {
  if (a >= b) return a;
  return (2 / kPi) * (std::sqrt((b - a) * (b + a)) + a * std::asin(a / b));
}

}  // namespace

// P(beta) up to its norm.
double VisibleFlakes::shape(double sin_beta, double cos_beta) const {
  const double square = tilt_ * tilt_;
  if (kind_ == Orientation::gaussian) {
    const double beta = std::atan2(sin_beta, cos_beta);
    return std::exp(-beta * beta / (2 * square));
  }
  const double cos2 = cos_beta * cos_beta, sin2 = sin_beta * sin_beta;
  if (kind_ == Orientation::beckmann) {
    if (sin2 > 700 * square * cos2) return 0;
    return std::exp(-sin2 / (cos2 * square)) / (cos2 * cos2);
  }
  // Times tilt^4, so that the peak is 1 for any tilt.
  const double d = cos2 + sin2 / square;
  return 1 / (d * d);
}

// Both integrals over beta by the midpoint rule in psi, tan(beta) = w tan(psi) with w = tilt (at
// most 1): half of the nodes lie within a tilt.
VisibleFlakes::VisibleFlakes(Orientation kind, double tilt) : kind_(kind), tilt_(tilt) {
  struct Node {
    double weight, sin_beta, cos_beta;
  };
  const double w = std::min(tilt, 1.0);
  std::vector<Node> nodes;
  for (int i = 0; i < kBetaNodes; ++i) {
    const double step = kPi / 2 / kBetaNodes;
    const double psi = (i + 0.5) * step;
    const double x = std::cos(psi), y = w * std::sin(psi);
    const double sin_beta = y / std::hypot(x, y), cos_beta = x / std::hypot(x, y);
    const double d_beta = step * w / (x * x + y * y);
    const double weight = shape(sin_beta, cos_beta) * sin_beta * d_beta;
    if (weight > 0) nodes.push_back({weight, sin_beta, cos_beta});
    norm_ += weight;
  }
  // <s> bends where cos(theta) is about a tilt: u = cos (1 + w)/(cos + w) in even steps.
  for (int i = 0; i <= kAreaIntervals; ++i) {
    const double u = static_cast<double>(i) / kAreaIntervals;
    const double cos_theta = std::min(w * u / (1 + w - u), 1.0);
    const double sin_theta = std::sqrt((1 - cos_theta) * (1 + cos_theta));
    double sum = 0;
    for (const Node& node : nodes) {
      sum += node.weight * ring_mean(cos_theta * node.cos_beta, sin_theta * node.sin_beta);
    }
    area_.push_back(sum / norm_);
  }
}

double VisibleFlakes::density(Vec3<double> n) const {
  return shape(std::sqrt(n.x * n.x + n.y * n.y), std::abs(n.z)) / (2 * kPi * norm_);
}

// Linear in cos(theta), like <s> itself far from grazing, between the nodes.
double VisibleFlakes::projected_area(double cos_theta) const {
  const double w = std::min(tilt_, 1.0);
  const double u = cos_theta * (1 + w) / (cos_theta + w) * kAreaIntervals;
  const auto i = static_cast<std::size_t>(std::min(u, kAreaIntervals - 1.0));
  const double lower = static_cast<double>(i) / kAreaIntervals;
  // (cos - cos_i)/(cos_i+1 - cos_i) = (u - u_i)/(u_i+1 - u_i) (1 + w - u_i+1)/(1 + w - u).
  const double f = (u - static_cast<double>(i)) * (1 + w - lower - 1.0 / kAreaIntervals) /
                   (1 + w - u / kAreaIntervals);
  return area_[i] + (area_[i + 1] - area_[i]) * f;
}

Vec3<double> VisibleFlakes::sample(Vec3<double> v, UniformRandom& random) const {
  if (kind_ == Orientation::ggx) {
    // p(n) is the area per solid angle of its normals on the ellipsoid with axes 1, 1, tilt; what
    // is seen of it is even over its outline. Squeezed into a sphere: even over a disc (Walter et
    // al. 2015, The ellipsoid normal distribution function).
    Vec3<double> axis{tilt_ * v.x, tilt_ * v.y, v.z};
    axis = axis / length(axis);
    const Vec3<double> side = std::abs(axis.z) < 0.7 ? Vec3<double>{-axis.y, axis.x, 0}
                                                     : Vec3<double>{0, -axis.z, axis.y};
    const Vec3<double> t = side / length(side);
    const Vec3<double> b{axis.y * t.z - axis.z * t.y, axis.z * t.x - axis.x * t.z,
                         axis.x * t.y - axis.y * t.x};
    const double r2 = random(), phi = 2 * kPi * random();
    const Vec3<double> m =
        (t * std::cos(phi) + b * std::sin(phi)) * std::sqrt(r2) + axis * std::sqrt(1 - r2);
    const Vec3<double> n{tilt_ * m.x, tilt_ * m.y, m.z};
    return n / length(n);
  }
  // From P, kept with a probability in proportion to |v . n| <= cos(theta) + sin(beta).
  const double bound = std::min(std::abs(v.z) + kReach * tilt_, 1.0);
  for (;;) {
    double sin_beta, cos_beta, keep;
    if (kind_ == Orientation::gaussian) {
      // beta exp(-beta^2/2 tilt^2) on [0, pi/2], kept with sin(beta)/beta.
      const double mass = -std::expm1(-kPi * kPi / (8 * tilt_ * tilt_));
      const double beta = tilt_ * std::sqrt(-2 * std::log1p(-mass * random()));
      sin_beta = std::sin(beta), cos_beta = std::cos(beta);
      keep = beta > 0 ? sin_beta / beta : 1;
    } else {
      // With y = tan(beta)/tilt, P sin(beta) dbeta ~ y sqrt(1 + (tilt y)^2) exp(-y^2) dy, below
      // (y + tilt y^2) exp(-y^2), whose parts have the masses 1/2 and tilt sqrt(pi)/4; the second
      // is Maxwell's, the length of three normal deviates.
      const double maxwell = tilt_ * std::sqrt(kPi) / 2;
      double y2 = -std::log1p(-random());
      if (random() * (1 + maxwell) >= 1) {
        const double c = std::cos(2 * kPi * random());
        y2 -= std::log1p(-random()) * c * c;
      }
      const double tan_beta = tilt_ * std::sqrt(y2);
      cos_beta = 1 / std::sqrt(1 + tan_beta * tan_beta);
      sin_beta = tan_beta * cos_beta;
      keep = 1 / (cos_beta * (1 + tan_beta));
    }
    const Vec3<double> n = around_z(sin_beta, cos_beta, 2 * kPi * random());
    if (random() * bound < keep * std::abs(dot(v, n))) return n;
  }
}

}  // namespace metallic_paint::reference
