// SPDX-License-Identifier: Apache-2.0
//
// The optics that the references share; of the core they take parameters and vectors only.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "../paint.h"

namespace metallic_paint::reference {

inline double square(double x) { return x * x; }

// ---------------------------------------------------------------------------------------------
// The surface of the binder. eta: of the far side relative to the near side.

// From sin^2 + cos^2 = 1 and Snell, eta^2 cos^2(t) = (eta^2 - 1) + cos^2(i); 0 under total
// reflection and from behind.
inline double refracted_cosine(double cos_i, double eta) {
  const double square = (eta - 1) * (eta + 1) + cos_i * cos_i;
  return cos_i > 0 && square > 0 ? std::min(std::sqrt(square) / eta, 1.0) : 0;
}

// The horizontal part of a direction shrinks by eta (Snell); 0 where the cosine is.
inline Vec3<double> refracted(Vec3<double> d, double eta) {
  const double cosine = refracted_cosine(d.z, eta);
  return cosine > 0 ? Vec3<double>{d.x / eta, d.y / eta, cosine} : Vec3<double>{};
}

// Fresnel's reflectance for unpolarised light.
inline double fresnel_reflectance(double cos_i, double cos_t, double eta) {
  if (cos_t <= 0) return 1;
  const double s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  const double p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  return (s * s + p * p) / 2;
}

// ---------------------------------------------------------------------------------------------
// The layer, by its optical depths straight down.

// E[max(0, 1 + s w)] = Phi(1/s) + s phi(1/s), w a standard normal deviate.
inline double mean_relative_area(double s) {
  if (s == 0) return 1;
  return std::erfc(-1 / (s * std::numbers::sqrt2)) / 2 +
         s * std::exp(-0.5 / (s * s)) / std::sqrt(2 * std::numbers::pi);
}

// D H <S>
inline double flake_coverage(const FlakeSpecies& flakes) {
  const double diameter_mm = flakes.flake_diameter_um * 1e-3;
  return flakes.flakes_per_mm2 * (std::numbers::pi / 4 * diameter_mm * diameter_mm) *
         mean_relative_area(flakes.flake_area_spread);
}

// (16 pi/3) c1 H
inline double rayleigh_depth(const Paint& paint) {
  return 16 * std::numbers::pi / 3 * paint.rayleigh_per_mm * (paint.layer_thickness_um * 1e-3);
}

// kappa H
inline Rgb<double> absorption_depth(const Paint& paint) {
  return paint.binder_absorption_per_mm * (paint.layer_thickness_um * 1e-3);
}

// The library's numbers (core/coating_library.inc, laid out as tools/coatings/table.py writes
// them), read by the cosines of their nodes: a row of 13 colours for each of 8 metals, 41 rows 5 nm
// apart for each of 6 pearls, and the transmittances of Fe2O3 on mica and silica. kind and nm: as
// in CoatingKind, not 0; kind is that of the reflectances, or 15 and 16 for these transmittances.
inline Rgb<double> library_colour(int kind, double nm, double cos_alpha) {
  constexpr int nodes = 13, rows = 41, metals = 8;
  static const std::vector<double> numbers{
#include "../coating_library.inc"
  };
  static const std::vector<double> cosines{0,        1 / 6.,   1 / 3.,   1 / 2.,   16 / 24.,
                                           17 / 24., 18 / 24., 19 / 24., 20 / 24., 21 / 24.,
                                           22 / 24., 23 / 24., 1};
  const auto above = std::upper_bound(cosines.begin() + 1, cosines.end() - 1, cos_alpha);
  const double share = (cos_alpha - above[-1]) / (above[0] - above[-1]);
  const auto node = static_cast<int>(above - cosines.begin());
  const auto at_row = [&](int row) {
    const double* high = &numbers[static_cast<std::size_t>(3 * (nodes * row + node))];
    const double* low = high - 3;
    return Rgb<double>{low[0] + share * (high[0] - low[0]), low[1] + share * (high[1] - low[1]),
                       low[2] + share * (high[2] - low[2])};
  };
  if (kind <= metals) return at_row(kind - 1);
  const int thinner = std::min(static_cast<int>(std::floor(nm / 5)), rows - 2);
  const int row = metals + rows * (kind - metals - 1) + thinner;
  const Rgb<double> below = at_row(row);
  return below + (at_row(row + 1) - below) * (nm / 5 - thinner);
}

inline Rgb<double> library_reflectance(CoatingKind kind, double nm, double cos_alpha) {
  return library_colour(static_cast<int>(kind), nm, cos_alpha);
}

inline Rgb<double> library_transmittance(CoatingKind kind, double nm, double cos_alpha) {
  switch (kind) {
    case CoatingKind::tio2_on_mica:
    case CoatingKind::tio2_on_silica:
    case CoatingKind::tio2_on_thin_silica:
      return grey(1.0) - library_reflectance(kind, nm, cos_alpha);
    case CoatingKind::fe2o3_on_mica:
      return library_colour(15, nm, cos_alpha);
    case CoatingKind::fe2o3_on_silica:
      return library_colour(16, nm, cos_alpha);
    default:
      return {};
  }
}

// Schlick, or the library; cos_alpha from 0 to 1 but for rounding.
inline Rgb<double> flake_reflectance(const FlakeSpecies& flakes, double cos_alpha) {
  if (flakes.coating != CoatingKind::colors) {
    return library_reflectance(flakes.coating, flakes.coating_nm, std::min(cos_alpha, 1.0));
  }
  const double x = std::max(1 - cos_alpha, 0.0);
  return flakes.flake_color + (flakes.flake_edge_color - flakes.flake_color) * (x * x * x * x * x);
}

inline Rgb<double> flake_transmittance(const FlakeSpecies& flakes, double cos_alpha) {
  if (flakes.coating == CoatingKind::colors) return flakes.flake_transmission;
  return library_transmittance(flakes.coating, flakes.coating_nm, std::min(cos_alpha, 1.0));
}

// Whether that depends on the angle: the pearls but Fe2O3 on aluminium.
inline bool transmits_by_angle(const FlakeSpecies& flakes) {
  return flakes.coating >= CoatingKind::tio2_on_mica &&
         flakes.coating <= CoatingKind::fe2o3_on_silica;
}

// ---------------------------------------------------------------------------------------------

// The flakes' own spread, waviness and diffraction together. By a disc of diameter d the middle of
// a plane wave is (pi d^2/4)/lambda^2 bright per steradian, which an even cone of solid angle
// lambda^2/(pi d^2/4) has too; its radius is lambda/pi over d/2.
inline double flake_spread(const Paint& paint, const FlakeSpecies& flakes) {
  if (paint.diffraction == Diffraction::none) return flakes.flake_spread;
  const double wavelength_um = 0.55 / paint.binder_ior;
  const double radius = wavelength_um / std::numbers::pi / (flakes.flake_diameter_um / 2);
  return std::hypot(flakes.flake_spread, std::min(radius, 0.5));
}

// Two unit vectors that stand on a unit vector and on each other.
struct Frame {
  Vec3<double> a, b;
};
inline Frame frame_of(Vec3<double> n) {
  const Vec3<double> side =
      std::abs(n.z) < 0.7 ? Vec3<double>{-n.y, n.x, 0} : Vec3<double>{0, -n.z, n.y};
  const Vec3<double> a = side / length(side);
  return {a, {n.y * a.z - n.z * a.y, n.z * a.x - n.x * a.z, n.x * a.y - n.y * a.x}};
}

}  // namespace metallic_paint::reference
