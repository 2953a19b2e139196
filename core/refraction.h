// SPDX-License-Identifier: Apache-2.0
//
// The binder's surface: Snell, Fresnel, and the transformation of cones (paper, 5.3.4).
#pragma once

#include <cmath>

#include "vector.h"

namespace metallic_paint {

// eta cos(theta_p), for the cosine outside and the relative index eta of the binder; negative
// squares, i.e. total reflection (eta < 1 only), give 0. With sin(theta) = eta sin(theta_p)
// (Snell), eta^2 cos^2(theta_p) = eta^2 - 1 + cos^2(theta); (eta - 1)(eta + 1) keeps its digits
// near eta = 1.
template <class T>
T eta_cos_refracted(T cos_theta, T eta) {
  const T square = (eta - 1) * (eta + 1) + cos_theta * cos_theta;
  return square > 0 ? std::sqrt(square) : T(0);
}

// 1 - r_eta(theta): the unpolarised transmittance of the surface, from Fresnel's T_s and T_p rather
// than as 1 - r, so that nothing cancels at grazing angles. g = eta_cos_refracted(cos_theta, eta).
template <class T>
T fresnel_transmittance(T cos_theta, T g, T eta) {
  const T s = cos_theta + g;
  const T p = eta * eta * cos_theta + g;
  if (s <= 0) return 0;  // grazing at eta = 1
  const T product = cos_theta * g;
  return 2 * product * (1 / (s * s) + eta * eta / (p * p));
}

// A unit vector that points away from the surface, refracted into the binder (paper, eq. 8):
// v = V/eta + n (cos(theta_p) - cos(theta)/eta).
template <class T>
Vec3<T> refract_direction(Vec3<T> direction, Vec3<T> normal, T cos_theta, T g, T eta) {
  return (direction + normal * (g - cos_theta)) / eta;
}

// d omega inside / d omega outside = cos(theta)/(eta^2 cos(theta_p)) (paper, eq. 7 squared).
template <class T>
T solid_angle_ratio(T cos_theta, T g, T eta) {
  return cos_theta / (eta * g);
}

}  // namespace metallic_paint
