// SPDX-License-Identifier: Apache-2.0
//
// The model of docs/model evaluated a second time, in long double and in its naive form: with
// angles, with their sines and cosines, and with integrals done numerically as they stand. Shares
// no code with core/; slow.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace independent {

using Real = long double;
inline constexpr Real kPi = 3.141592653589793238462643383279502884L;

// ---------------------------------------------------------------------------------------------
// Quadrature: tanh-sinh (Takahasi and Mori 1974), steps halved until the result stands. Indifferent
// to what happens at the ends; kinks inside belong between pieces.

struct TanhSinhLevel {
  std::vector<Real> end_distance, weight;  // of the nodes that this level adds, on [-1, 1]
};

inline const std::vector<TanhSinhLevel>& tanh_sinh_levels() {
  static const std::vector<TanhSinhLevel> levels = [] {
    std::vector<TanhSinhLevel> made;
    for (int k = 1; k <= 9; ++k) {
      const Real h = std::ldexp(1.0L, -k);
      TanhSinhLevel level;
      for (int i = 1;; i += k == 1 ? 1 : 2) {
        const Real t = h * static_cast<Real>(i);
        const Real u = kPi / 2 * std::sinh(t);
        const Real distance = 2 / (1 + std::exp(2 * u));
        const Real weight = kPi / 2 * std::cosh(t) / (std::cosh(u) * std::cosh(u));
        if (weight < 1e-24L) break;
        level.end_distance.push_back(distance);
        level.weight.push_back(weight);
      }
      made.push_back(level);
    }
    return made;
  }();
  return levels;
}

template <class F>
Real integrate(const F& f, Real from, Real to) {
  if (!(to > from)) return 0;
  const Real half = (to - from) / 2;
  Real sum = kPi / 2 * f(from + half);
  Real previous = 0, size = 0, h = 1;
  for (const TanhSinhLevel& level : tanh_sinh_levels()) {
    h /= 2;
    for (std::size_t i = 0; i < level.weight.size(); ++i) {
      const Real d = half * level.end_distance[i];
      sum += level.weight[i] * (f(from + d) + f(to - d));
    }
    size = std::fabs(sum * h);
    // The error is squared by each halving: 1e-11 between two levels leaves rounding only.
    if (std::fabs(sum * h - previous) <= 1e-11L * size) break;
    previous = sum * h;
  }
  return sum * h * half;
}

template <class F>
Real integrate(const F& f, std::vector<Real> edges) {
  std::sort(edges.begin(), edges.end());
  Real sum = 0;
  for (std::size_t i = 1; i < edges.size(); ++i) sum += integrate(f, edges[i - 1], edges[i]);
  return sum;
}

// ---------------------------------------------------------------------------------------------
// Vectors and directions.

struct Vector {
  Real x, y, z;
};
inline Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector operator*(Real s, Vector a) { return {s * a.x, s * a.y, s * a.z}; }
inline Real dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Real length(Vector a) { return std::sqrt(dot(a, a)); }
inline Vector cross(Vector a, Vector b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Real angle(Vector a, Vector b) { return std::atan2(length(cross(a, b)), dot(a, b)); }

// ---------------------------------------------------------------------------------------------
// The binder's surface.

inline Real refracted_angle(Real theta, Real eta) { return std::asin(std::sin(theta) / eta); }

// Fresnel's equations for unpolarised light.
inline Real fresnel_reflectance(Real theta, Real eta) {
  const Real in = std::cos(theta), through = std::cos(refracted_angle(theta, eta));
  const Real s = (in - eta * through) / (in + eta * through);
  const Real p = (eta * in - through) / (eta * in + through);
  return (s * s + p * p) / 2;
}

inline Vector refract(Vector direction, Vector normal, Real eta) {
  const Real theta = angle(direction, normal);
  const Real shift = std::cos(refracted_angle(theta, eta)) - std::cos(theta) / eta;
  return (1 / eta) * direction + shift * normal;
}

// ---------------------------------------------------------------------------------------------
// Orientation: the shapes of P(beta), 0 gaussian, 1 beckmann, 2 ggx, not normalised.

struct Flakes {
  int kind;
  Real tilt;
};

inline Real shape(Flakes flakes, Real beta) {
  const Real t2 = flakes.tilt * flakes.tilt;
  if (flakes.kind == 0) return std::exp(-beta * beta / (2 * t2));
  const Real s = std::sin(beta), c = std::cos(beta);
  if (flakes.kind == 1) {
    const Real slope = s / c;
    return slope * slope > 11000 * t2 ? 0 : std::exp(-slope * slope / t2) / (c * c * c * c);
  }
  const Real d = t2 * c * c + s * s;
  return 1 / (d * d);
}

// Ends of pieces of [0, pi/2] in which the shape is tame.
inline std::vector<Real> shape_edges(Flakes flakes) {
  std::vector<Real> edges{0, kPi / 2};
  const Real reach = flakes.kind == 2 ? 1e30L : 60 * flakes.tilt;
  for (Real edge = flakes.tilt; edge < kPi / 2 && edge < reach; edge *= 2) edges.push_back(edge);
  if (reach < kPi / 2) edges[1] = reach;
  return edges;
}

inline Real shape_norm(Flakes flakes) {
  return integrate([&](Real beta) { return shape(flakes, beta) * std::sin(beta); },
                   shape_edges(flakes));
}
inline Real mean_cosine(Flakes flakes, Real norm) {
  return integrate([&](Real b) { return shape(flakes, b) * std::sin(b) * std::cos(b); },
                   shape_edges(flakes)) /
         norm;
}

// integral of p(n_f) over the cap of angular radius rho about a direction at beta, in polar
// coordinates (r, psi) about that direction; its flakes above the horizon.
inline Real cap_probability(Flakes flakes, Real norm, Real beta, Real rho) {
  std::vector<Real> edges{0, rho};
  for (Real near : {beta - flakes.tilt, beta, beta + flakes.tilt}) {
    if (near > 0 && near < rho) edges.push_back(near);
  }
  const Real sum = integrate(
      [&](Real r) {
        const auto density = [&](Real psi) {
          const Real half = std::sin(psi / 2), apart = std::sin((beta - r) / 2);
          const Real y = apart * apart + std::sin(beta) * std::sin(r) * half * half;
          return y > 0.5L ? 0 : shape(flakes, 2 * std::asin(std::sqrt(y)));
        };
        return std::sin(r) * integrate(density, 0, kPi);
      },
      edges);
  return sum / (kPi * norm);
}

// integral of p(n_f) |v . n_f|^power over the half sphere of flake normals, polar axis = paint
// normal: <s>(theta) for power = 1.
inline Real mean_projected_area(Flakes flakes, Real norm, Real theta, int power = 1) {
  std::vector<Real> edges = shape_edges(flakes);
  // A cap about the normal that the plane of sight just touches.
  if (kPi / 2 - theta < *std::max_element(edges.begin(), edges.end())) {
    edges.push_back(kPi / 2 - theta);
  }
  const Real sum = integrate(
      [&](Real beta) {
        const Real a = std::cos(theta) * std::cos(beta), b = std::sin(theta) * std::sin(beta);
        const auto seen = [&](Real phi) {
          const Real x = std::fabs(a + b * std::cos(phi));
          return power == 1 ? x : x * x;
        };
        const Real horizon = a < b ? std::acos(-a / b) : kPi;
        const Real ring = integrate(seen, 0, horizon) + integrate(seen, horizon, kPi);
        return shape(flakes, beta) * std::sin(beta) * ring / kPi;
      },
      edges);
  return sum / norm;
}

// integral of p(n_f) |v . n_f| f(|v . n_f|), polar axis = v and x = |v . n_f| outermost, so that f
// may have kinks at `kinks`. A flake and its reverse are one, hence the density of |n . n_f|.
inline Real mean_transmitted_area(Flakes flakes, Real norm, Real theta,
                                  const std::function<Real(Real)>& f, std::vector<Real> kinks) {
  kinks.push_back(0);
  kinks.push_back(1);
  // Where the ring of constant x begins to touch the flakes' equator, and the peak of the shape.
  for (Real t : {std::sin(theta), std::cos(theta)}) kinks.push_back(t);
  const Real sum = integrate(
      [&](Real x) {
        const Real a = std::cos(theta) * x, b = std::sin(theta) * std::sqrt((1 - x) * (1 + x));
        const auto density = [&](Real phi) {
          return shape(flakes, std::acos(std::min<Real>(std::fabs(a + b * std::cos(phi)), 1)));
        };
        const Real equator = a < b ? std::acos(-a / b) : kPi;
        return x * f(x) * (integrate(density, 0, equator) + integrate(density, equator, kPi));
      },
      kinks);
  return sum / (kPi * norm);
}

// ---------------------------------------------------------------------------------------------
// Flake areas max(0, 1 + s w): E[min(X, cap)^power] as an integral over the normal deviate w.

inline Real area_moment(Real spread, int power, Real cap) {
  if (spread == 0) return std::pow(std::min<Real>(1, cap), power);
  const Real reach = 40;
  std::vector<Real> edges{-reach, -8, -3, 0, 3, 8, reach};
  for (Real x : {Real(0), cap}) {
    const Real w = (x - 1) / spread;
    if (std::fabs(w) < reach) edges.push_back(w);
  }
  return integrate(
      [&](Real w) {
        const Real x = std::min(std::max<Real>(0, 1 + spread * w), cap);
        return std::pow(x, power) * std::exp(-w * w / 2) / std::sqrt(2 * kPi);
      },
      edges);
}

// ---------------------------------------------------------------------------------------------
// Sparkles of one light in one pixel, per colour.

struct Colour {
  Real r, g, b;
  Real operator[](int i) const { return i == 0 ? r : i == 1 ? g : b; }
};

struct Scene {
  // Paint, SI
  Real flakes_per_m2, flake_area, area_spread;
  Flakes orientation;
  Real flake_spread;
  Colour normal_reflectance, grazing_reflectance, transmittance;
  Real eta, thickness;
  Colour absorption;
  Real rayleigh;
  bool thinned, correlated, published;
  // Geometry
  Vector normal, view, light;
  Real light_radius;  // Delta_a
  Real footprint;     // Sigma
};

struct Result {
  Real count;                              // <N>
  std::array<Real, 3> mean, second, brdf;  // E[T], E[sum of T_i^2], f
  std::array<Real, 3> depth;               // t H
  Real fill;                               // mean flake areas that fill the pixel
};

// (1 - e^-x)/x
inline Real averaged(Real x) { return x == 0 ? 1 : -std::expm1(-x) / x; }

// What the orientations contribute, to be shared by scenes with the same flakes and angles.
struct Orientations {
  Real norm, area_view, area_light;
  Real area_above;  // seen along the paint's normal
};
inline Orientations orientations(const Scene& scene) {
  const Real norm = shape_norm(scene.orientation);
  const auto area = [&](Vector v) {
    return mean_projected_area(scene.orientation, norm,
                               refracted_angle(angle(scene.normal, v), scene.eta));
  };
  return {norm, area(scene.view), area(scene.light), area(scene.normal)};
}

inline Result sparkles(const Scene& scene, const Orientations& known) {
  const Real theta = angle(scene.normal, scene.view), theta_l = angle(scene.normal, scene.light);
  const Real theta_p = refracted_angle(theta, scene.eta);
  const Real theta_lp = refracted_angle(theta_l, scene.eta);
  const Vector v = refract(scene.view, scene.normal, scene.eta);
  const Vector l = refract(scene.light, scene.normal, scene.eta);
  const Vector flake = v + l;
  const Real alpha = angle(flake, v), beta = angle(flake, scene.normal);
  const Real P = shape(scene.orientation, beta) / known.norm;

  const Real s1 = area_moment(scene.area_spread, 1, 1e30L);
  const Real coverage = scene.flakes_per_m2 * scene.flake_area * s1;  // D H <S>

  // The light's cone: outside, and inside with the flake's own spread.
  const Real radius = scene.light_radius;
  const Real outside = scene.published ? kPi * radius * radius
                                       : 4 * kPi * std::sin(radius / 2) * std::sin(radius / 2);
  const Real squeeze =
      std::cos(theta_l) / (scene.eta * scene.eta * std::cos(theta_lp));  // d inside/d outside
  const Real inside = outside * squeeze + kPi * scene.flake_spread * scene.flake_spread;
  const Real seen_outside = inside / squeeze;
  // A narrow cone of normals takes P at its centre, as in the paper; a wide one its integral.
  const Real quarter = inside / (4 * std::cos(alpha));
  const Real cap = 2 * std::asin(std::sqrt(std::min(quarter / (4 * kPi), Real(0.5))));
  const Real probability = scene.published || cap <= scene.orientation.tilt / 16
                               ? std::min(P * quarter / (2 * kPi), Real(1))
                               : cap_probability(scene.orientation, known.norm, beta, cap);

  const Real passed =
      (1 - fresnel_reflectance(theta, scene.eta)) * (1 - fresnel_reflectance(theta_l, scene.eta));
  const Real exit = scene.published ? std::cos(theta) : std::cos(theta_p);

  Result result;
  result.fill = scene.footprint * exit / (scene.flake_area * std::cos(alpha));
  const Real c1 = area_moment(scene.area_spread, 1, result.fill);
  const Real c2 = area_moment(scene.area_spread, 2, result.fill);
  // More flakes make up for the area that a small pixel cuts off.
  const Real flakes = scene.footprint * scene.flakes_per_m2 * probability * (s1 / c1);

  std::array<Real, 3> kept{};
  Real hidden = scene.correlated ? std::numeric_limits<Real>::infinity() : 0;
  for (int i = 0; i < 3; ++i) {
    const auto slanted = [&](Real projected, Real cosine) {
      const Real scattering = 16 * kPi / 3 * scene.rayleigh + scene.absorption[i];
      return (coverage * projected * (1 - scene.transmittance[i]) + scattering * scene.thickness) /
             cosine;
    };
    const auto at = static_cast<std::size_t>(i);
    result.depth[at] =
        slanted(known.area_view, std::cos(theta_p)) + slanted(known.area_light, std::cos(theta_lp));
    if (scene.correlated) {
      // Both ways leave the paint at points H times this far apart, for a flake on the ground.
      const Vector to_view = (1 / std::cos(theta_p)) * v, to_light = (1 / std::cos(theta_lp)) * l;
      const Vector between = to_view + -1 * to_light;
      const Real diameter = std::sqrt(4 * scene.flake_area / kPi);
      const Real widths = std::sqrt(dot(between, between)) * scene.thickness / diameter;
      const Real passing = scene.transmittance[i];
      const Real once = (1 - passing) * (1 - passing);
      const Real twice = (1 - passing * passing) * (1 - passing * passing);
      const Real shared = coverage * known.area_above * once;
      const Real y = widths / (1 + 0.0971L * result.depth[at]);
      const Real far = 1.8717L / (1 + 0.1464L * result.depth[at]);
      const Real share = (1 + 1.6392L * y) / (1 + 2.0389L * y + far * y * y);
      result.depth[at] -= shared * share;
      // Of two points of a disc, both free, as wide as those that hide it.
      const Real alone = 1 / (1 + 0.3259L + 0.8235L);
      const Real more = (1 - alone) * (0.74L + 0.45L * alone);
      const Real together = alone + more * share * (1 - share);
      const Real apart = 2 * once * (1 - share) + twice * share;
      hidden = std::min(hidden, together * coverage * known.area_above * apart);
    }
    kept[at] = averaged(result.depth[at]);
  }
  const Real most = *std::max_element(kept.begin(), kept.end());
  result.count = scene.thinned ? flakes * most : flakes;

  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const Real schlick = std::pow(1 - std::cos(alpha), 5.0L);
    const Real r_p = scene.normal_reflectance[i] +
                     (scene.grazing_reflectance[i] - scene.normal_reflectance[i]) * schlick;
    // T of one sparkle of unit relative area, before the layer dims it.
    const Real unit =
        passed * r_p * scene.flake_area * std::cos(alpha) / (seen_outside * scene.footprint * exit);
    const Real dimmed = scene.thinned ? kept[at] / most : kept[at];
    const Real dimmed_square =
        scene.thinned ? dimmed * dimmed : averaged(2 * result.depth[at] - hidden);
    result.mean[at] = result.count * unit * c1 * dimmed;
    result.second[at] = result.count * unit * unit * c2 * dimmed_square;
    result.brdf[at] = coverage * P / (2 * kPi) * r_p * kept[at] * passed /
                      (4 * scene.eta * scene.eta * exit * std::cos(theta_lp));
  }
  return result;
}

}  // namespace independent
