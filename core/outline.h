// SPDX-License-Identifier: Apache-2.0
//
// The outline of a flat light in the domain of normals (ours). The flakes that mirror it to the
// observer are as many as
//   integral over the light's directions l of p(n_f(l)) J(l), J = (dw_in/dw_out)/(4 cos(alpha)).
// The cap about the n_f of the light's middle, with that J for all of it, has the right size; but
// the rim of a wide light is refracted otherwise than its middle, so that its image is an ellipse,
// uneven, about another centre: the cap errs by up to 10 % at a half-angle of 15 degrees. Four
// places of the light have the second moments of the whole disc, and four normals those of the
// cap; the quotient of both sums of p corrects the cap's own integral. It leaves 1 % at 15 degrees.
#pragma once

#include <array>

#include "light.h"
#include "orientation.h"
#include "refraction.h"
#include "vector.h"

namespace metallic_paint {

template <class T>
struct Outline {
  bool given = false;
  std::array<Wide<T>, 4> sin2_half_beta{};  // of the flakes that mirror these places
  std::array<Wide<T>, 4> weight{};          // how many directions and flakes these stand for
  Wide<T> inside{};                         // the light's cone in the binder, sr
};

// Four places of a disc, so many radii off its middle. Its mean square there is a quarter of the
// radius squared along each axis: that of four places at kOfFour. More is in eight at kOfEight,
// Gauss's two points of the square of the radius, the outer four between the directions of the
// inner. Seen from a distance of 1 a place at q shows cos/q^3 of its area.
inline constexpr long double kOfFour = 0.707106781186547524401L;
inline constexpr long double kOfEight[] = {0.459700843380983L, 0.888073833977115L};

template <class T>
struct PointsWithin {
  std::array<Vec3<Wide<T>>, 4> towards;  // unit
  std::array<Wide<T>, 4> part;           // 1/q^3
};

template <class T>
PointsWithin<T> points_within(const SeenLight<T>& light, long double radii, bool between = false) {
  using W = Wide<T>;
  // Two axes across its normal (Duff et al. 2017).
  const Vec3<W> m = light.facing;
  const W sign = m.z < 0 ? W(-1) : W(1);
  const W a = -1 / (sign + m.z);
  const W b = m.x * m.y * a;
  const W off = W(radii) * light.radius;
  Vec3<W> u = Vec3<W>{1 + sign * m.x * m.x * a, sign * b, -(sign * m.x)} * off;
  Vec3<W> v = Vec3<W>{b, sign + m.y * m.y * a, -m.y} * off;
  if (between) {
    const W half = W(kOfFour);
    const Vec3<W> turned = (u + v) * half;
    v = (v - u) * half;
    u = turned;
  }
  const Vec3<W> middle = light.direction;
  PointsWithin<T> points{{middle + u, middle - u, middle + v, middle - v}, {}};
  for (std::size_t i = 0; i < 4; ++i) {
    Vec3<W>& at = points.towards[i];
    const W square = dot(at, at);
    const W distance = sqrt(square);
    points.part[i] = 1 / (square * distance);
    at = at * (1 / distance);
  }
  return points;
}

// Of a flat light.
template <class T>
Outline<T> outline_of(const SeenLight<T>& light, const Mirror<Wide<T>>& middle, Wide<T> inside,
                      Vec3<Wide<T>> normal, Vec3<Wide<T>> view, Wide<T> eta) {
  using W = Wide<T>;
  Outline<T> outline;
  outline.given = true;
  outline.inside = inside;
  const PointsWithin<T> within = points_within(light, kOfFour);
  W seen = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    seen = seen + within.part[i];
    const Mirror<W> mirror = mirror_between(normal, view, within.towards[i], eta);
    if (!mirror.possible) continue;
    outline.sin2_half_beta[i] = mirror.sin2_half_beta;
    outline.weight[i] = within.part[i] * solid_angle_ratio(mirror.cos_light, mirror.g_light, eta) /
                        mirror.cos_alpha;
  }
  const W whole =
      seen * solid_angle_ratio(middle.cos_light, middle.g_light, eta) / middle.cos_alpha;
  for (std::size_t i = 0; i < 4; ++i) outline.weight[i] = outline.weight[i] / whole;
  return outline;
}

// By how much more flakes mirror it than lie in the cap of sin^2(rho/2) about beta; in float 1
// where neither has any. Where few flakes are, the quotient of their tails says nothing: within a
// factor of 2 the cap is trusted.
template <class D>
Wide<D> outline_factor(const OrientationDensity<D>& density, const Outline<D>& outline,
                       Wide<D> middle, Wide<D> sin2_half_rho) {
  using T = Wide<D>;
  T found = 0;
  for (int i = 0; i < 4; ++i) {
    if (outline.weight[i] > 0) {
      found = found + outline.weight[i] * orientation_density(density, outline.sin2_half_beta[i]);
    }
  }
  // cos(b) = cos(beta) cos(r) +- sin(beta) sin(r), and cos(beta) cos(r) aside, r = rho/sqrt(2).
  const T r = T(0.5) * sin2_half_rho;
  const T aside = middle + r - 2 * middle * r;
  const T along = 2 * sqrt(middle * (1 - middle) * r * (1 - r));
  T even = 0;
  if (aside < T(0.5)) even = even + 2 * orientation_density(density, aside);
  if (aside + along < T(0.5)) even = even + orientation_density(density, aside + along);
  if (aside - along < T(0.5)) {
    even = even + orientation_density(density, max(aside - along, T(0)));
  }
  if (!(even > 0)) return 1;
  return clamp(found / (T(0.25) * even), T(0.5), T(2));
}

}  // namespace metallic_paint
