// SPDX-License-Identifier: Apache-2.0
//
// A metallic paint as artists and presets state it: real units in the names, checked once, here.
// The parameters are those of osl/metallic_paint.osl, one for one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>

#include "sparkles.h"

namespace metallic_paint {

struct Paint {
  double flakes_per_mm2 = 3000;    // flakes per mm2 of painted surface (D H), 0 to 1e9
  double flake_diameter_um = 20;   // of a disc of the mean flake area, 1e-3 to 1e5 um
  double flake_area_spread = 0.3;  // standard deviation of the flake area over its mean, 0 to 100
  Orientation orientation = Orientation::gaussian;
  double tilt = 0.15;  // gaussian: radians, 1e-6 to 100; beckmann, ggx: roughness, 1e-6 to 1
  double flake_spread =
      0.005;  // angular radius by which a flake spreads light in the binder, 0 to 0.5 rad
  Rgb<double> flake_color{0.91, 0.92, 0.92};      // reflectance at normal incidence, 0 to 1
  Rgb<double> flake_edge_color{1, 1, 1};          // reflectance at grazing incidence, 0 to 1
  Rgb<double> flake_transmission{0, 0, 0};        // transmittance, 0 to 1 less either of them
  double binder_ior = 1.5;                        // relative to the surroundings, 0.1 to 10
  double layer_thickness_um = 30;                 // of the flake layer (H), 0 to 1e6 um
  Rgb<double> binder_absorption_per_mm{0, 0, 0};  // kappa, 0 to 1e6 1/mm
  double rayleigh_per_mm = 0;                     // c1, 0 to 1e6 1/mm
  DepthModel depth_model = DepthModel::attenuated;
  Radiometry radiometry = Radiometry::exact;
  int seed = 0;
  int frame = 0;
};

// Throws std::invalid_argument with a sentence that names the field, its value and the allowed
// range.
void validate(const Paint& paint);
void validate(const Light<double>& light);
void validate(const CoatingTable<double>& table);

// Likewise, for the arguments of single functions of the model.
void validate_count(double mean, double slots, double uniform);
void validate_probability(double probability);
void validate_cosine(double cos_theta);
void validate_eta(double eta);
void validate_beta(double beta);
void validate_direction(const std::string& field, std::size_t row, Vec3<double> direction);
void validate_int32(const std::string& field, std::size_t row, double value);

// The paint as the evaluation needs it; the operations are the shader's. `paint` must be valid.
template <class T>
Layer<T> make_layer(const Paint& paint) {
  Layer<T> layer;
  layer.areal_density = static_cast<T>(paint.flakes_per_mm2) * T(1e6);
  const T diameter = static_cast<T>(paint.flake_diameter_um) * T(1e-6);
  layer.flake_area = T(0.785398163397448309616L) * (diameter * diameter);
  layer.area_spread = static_cast<T>(paint.flake_area_spread);
  layer.area = area_moments(layer.area_spread);
  layer.coverage = layer.areal_density * layer.flake_area * layer.area.mean;
  layer.orientation = make_orientation(paint.orientation, static_cast<T>(paint.tilt));
  const T spread = static_cast<T>(paint.flake_spread);
  layer.flake_solid_angle = std::numbers::pi_v<T> * (spread * spread);
  layer.coating = {Rgb<T>(paint.flake_color), Rgb<T>(paint.flake_edge_color),
                   Rgb<T>(paint.flake_transmission)};
  layer.eta = static_cast<T>(paint.binder_ior);
  const T rayleigh = T(16.7551608191455638468L) * static_cast<T>(paint.rayleigh_per_mm);  // 16 pi/3
  layer.binder_depth = (Rgb<T>(paint.binder_absorption_per_mm) + grey(rayleigh)) *
                       (static_cast<T>(paint.layer_thickness_um) * T(0.001));
  layer.depth_model = paint.depth_model;
  layer.radiometry = paint.radiometry;
  return layer;
}

// The stream of deviates of a light slot (0-based) in this paint; one flake species so far.
inline HashWords paint_stream(const Paint& paint, int light) {
  return stream_key(light, 0, paint.frame, paint.seed);
}

}  // namespace metallic_paint
