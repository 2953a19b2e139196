// SPDX-License-Identifier: Apache-2.0
//
// What a rough surface reflects, integrated over its facets: for the test of the coat's fits and
// for tests/fits/facet_fit.cpp.
#pragma once

#include <cmath>
#include <numbers>

#include "refraction.h"
#include "vector.h"

namespace core_tests {

using namespace metallic_paint;

// The share of the light that GGX's facets reflect, each at its own angle, by their normals m
// (tan^2 = alpha^2 u/(1 - u)) weighted as above: single scattering.
inline double reflected_by_facets(double cosine, double alpha, double eta, int rows = 500,
                                  int columns = 500) {
  const Vec3<double> light{std::sqrt(1 - cosine * cosine), 0, cosine};
  const auto smith = [alpha](double c) {
    return 2 / (1 + std::sqrt(1 + alpha * alpha * (1 / (c * c) - 1)));
  };
  double sum = 0;
  for (int i = 0; i < rows; ++i) {
    const double u = (i + 0.5) / rows;
    const double z = 1 / std::sqrt(1 + alpha * alpha * u / (1 - u)), sine = std::sqrt(1 - z * z);
    for (int j = 0; j < columns; ++j) {
      const double phi = 2 * std::numbers::pi * (j + 0.5) / columns;
      const double facing = sine * std::cos(phi) * light.x + z * light.z;
      const double out = 2 * facing * z - light.z;
      if (!(facing > 0 && out > 0)) continue;
      const double fresnel = 1 - fresnel_transmittance(facing, eta_cos_refracted(facing, eta), eta);
      sum += fresnel * smith(out) * smith(light.z) * facing / (light.z * z);
    }
  }
  return sum / (rows * columns);
}

}  // namespace core_tests
