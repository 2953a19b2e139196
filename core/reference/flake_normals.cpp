// SPDX-License-Identifier: Apache-2.0
#include "flake_normals.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "optics.h"

namespace metallic_paint::reference {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kRings = 1024;
constexpr int kAreaIntervals = 256;
// No gaussian or beckmann sample lies beyond so many tilts: -log of a uniform is at most 53 log 2,
// whose double has the root 8.6.
constexpr double kReach = 9;

// Mean of |a + b cos(phi)| over the azimuth.
double ring_mean(double a, double b) {
  if (a >= b) return a;
  return (2 / kPi) * (std::sqrt((b - a) * (b + a)) + a * std::asin(a / b));
}

}  // namespace

// P(beta) up to its norm.
double FlakeNormals::shape(double sin_beta, double cos_beta) const {
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

// Integrals over beta by the midpoint rule in psi, tan(beta) = w tan(psi) with w = tilt (at most
// 1): half of the rings lie within a tilt.
FlakeNormals::FlakeNormals(Orientation kind, double tilt) : kind_(kind), tilt_(tilt) {
  const double w = std::min(tilt, 1.0), step = kPi / 2 / kRings;
  for (int i = 0; i < kRings; ++i) {
    const double psi = (i + 0.5) * step;
    const double x = std::cos(psi), y = w * std::sin(psi);
    const double sin_beta = y / std::hypot(x, y), cos_beta = x / std::hypot(x, y);
    const double d_beta = step * w / (x * x + y * y);
    const double share = shape(sin_beta, cos_beta) * sin_beta * d_beta;
    if (share > 0) rings_.push_back({share, sin_beta, cos_beta});
    norm_ += share;
  }
  for (Ring& ring : rings_) ring.share /= norm_;
}

double FlakeNormals::density(Vec3<double> n) const {
  return shape(std::sqrt(n.x * n.x + n.y * n.y), std::abs(n.z)) / (2 * kPi * norm_);
}

double FlakeNormals::projected_area(double cos_theta) const {
  const double sin_theta = std::sqrt((1 - cos_theta) * (1 + cos_theta));
  double sum = 0;
  for (const Ring& ring : rings_) {
    sum += ring.share * ring_mean(cos_theta * ring.cos_beta, sin_theta * ring.sin_beta);
  }
  return sum;
}

Vec3<double> FlakeNormals::sample(RandomStream& random) const {
  const auto at = [&](double sine, double cosine) {
    const double phi = 2 * kPi * random();
    return Vec3<double>{sine * std::cos(phi), sine * std::sin(phi), cosine};
  };
  if (kind_ == Orientation::gaussian) {
    // exp(-b^2/2s^2) sin(b): of deviates of exp(-b^2/2s^2) b below 90 degrees, sin(b)/b.
    const double below = -std::expm1(-kPi * kPi / (8 * tilt_ * tilt_));
    for (;;) {
      const double beta = tilt_ * std::sqrt(-2 * std::log1p(-below * random()));
      const double sine = std::sin(beta);
      if (random() * beta < sine) return at(sine, std::max(std::cos(beta), 0.0));
    }
  }
  if (kind_ == Orientation::beckmann) {
    // In t = tan^2(beta): exp(-t/a^2) sqrt(1 + t) = exp(-t (1/a^2 - 1/2)) [exp(-t/2) sqrt(1 + t)].
    const double rate = 1 / (tilt_ * tilt_) - 0.5;
    for (;;) {
      const double t = -std::log(random()) / rate;
      if (random() > std::exp(-0.5 * t) * std::sqrt(1 + t)) continue;
      return at(std::sqrt(t / (1 + t)), 1 / std::sqrt(1 + t));
    }
  }
  // In x = 1 - cos(beta): 1/(a^2 + w x(2 - x))^2, w = 1 - a^2, under 1/(a^2 + w x)^2, whose
  // integral is x/(a^2 (a^2 + w x)).
  const double a2 = tilt_ * tilt_, w = (1 - tilt_) * (1 + tilt_);
  for (;;) {
    const double u = random();
    const double x = u * a2 / (1 - u * w);
    const double ratio = (a2 + w * x) / (a2 + w * x * (2 - x));
    if (random() < ratio * ratio) return at(std::sqrt(x * (2 - x)), 1 - x);
  }
}

Vec3<double> FlakeNormals::sample_met(Vec3<double> v, RandomStream& random) const {
  if (kind_ == Orientation::ggx) {
    // p(n) is the area per solid angle of its normals on the ellipsoid with axes 1, 1, tilt; what
    // is seen of it is even over its outline. Squeezed into a sphere: even over a disc (Walter et
    // al. 2015, The ellipsoid normal distribution function).
    Vec3<double> axis{tilt_ * v.x, tilt_ * v.y, v.z};
    axis = axis / length(axis);
    const Frame frame = frame_of(axis);
    const double r2 = random(), phi = 2 * kPi * random();
    const Vec3<double> m = (frame.a * std::cos(phi) + frame.b * std::sin(phi)) * std::sqrt(r2) +
                           axis * std::sqrt(1 - r2);
    const Vec3<double> n{tilt_ * m.x, tilt_ * m.y, m.z};
    return n / length(n);
  }
  // Of all flakes, in proportion to |v . n| <= cos(theta) + sin(beta).
  const double bound = std::min(std::abs(v.z) + kReach * tilt_, 1.0);
  for (;;) {
    const Vec3<double> n = sample(random);
    if (random() * bound < std::abs(dot(v, n))) return n;
  }
}

// u = cos/(cos + w) in even steps, of <s>/(cos + w): far from grazing <s> ~ cos is then linear.
ProjectedAreaTable::ProjectedAreaTable(const FlakeNormals& normals)
    : w_(std::min(normals.tilt(), 1.0)), step_(1 / (1 + w_) / kAreaIntervals) {
  for (int i = 0; i <= kAreaIntervals; ++i) {
    const double u = step_ * i;
    const double cos_theta = std::min(w_ * u / (1 - u), 1.0);
    value_.push_back(normals.projected_area(cos_theta) / (cos_theta + w_));
  }
}

// The cubic through the nearest four nodes (Lagrange).
double ProjectedAreaTable::at(double cos_theta) const {
  const double position = cos_theta / (cos_theta + w_) / step_;
  const int first = std::clamp(static_cast<int>(position) - 1, 0, kAreaIntervals - 3);
  const double x = position - first;
  const double* y = &value_[static_cast<std::size_t>(first)];
  const double cubic = ((y[3] * x - y[0] * (x - 3)) * (x - 1) * (x - 2) +
                        3 * (y[1] * (x - 2) - y[2] * (x - 1)) * x * (x - 3)) /
                       6;
  return (cos_theta + w_) * cubic;
}

}  // namespace metallic_paint::reference
