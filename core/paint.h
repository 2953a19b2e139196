// SPDX-License-Identifier: Apache-2.0
//
// From a metallic paint as artists and presets state it (parameters.h) to what the evaluation
// needs.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>

#include "layer.h"
#include "light.h"
#include "parameters.h"
#include "random.h"
#include "vector.h"

namespace metallic_paint {

// Throws std::invalid_argument with a sentence that names the field, its value and the allowed
// range.
void validate(const Paint& paint);
void validate(const Light<double>& light);

// Likewise, for the arguments of single functions of the model.
void validate_count(double mean, double slots, double uniform);
void validate_probability(double probability);
void validate_cosine(double cos_theta);
void validate_eta(double eta);
void validate_beta(double beta);
void validate_direction(const std::string& field, std::size_t row, Vec3<double> direction);
void validate_int32(const std::string& field, std::size_t row, double value);

// At normal incidence a plane mirror of area S turns a plane wave into one that has the brightness
// S/lambda^2 of its flux per steradian in the middle: that of a cone of solid angle lambda^2/S, pi
// epsilon^2 = lambda^2/(pi d^2/4). So epsilon = 2 lambda/(pi d), with lambda = 550 nm/eta in the
// binder; at most 0.5 rad, where d is no longer large against lambda.
template <class T>
T diffraction_spread(T diameter_um, T eta) {
  return std::min(T(0.350140874802169738692L) / (eta * diameter_um), T(0.5));  // 2 x 0.55/pi
}

template <class T>
Flakes<T> make_flakes(const FlakeSpecies& species, T eta, Diffraction diffraction) {
  Flakes<T> flakes;
  flakes.areal_density = static_cast<T>(species.flakes_per_mm2) * T(1e6);
  const T diameter_um = static_cast<T>(species.flake_diameter_um);
  const T diameter = diameter_um * T(1e-6);
  flakes.flake_area = T(0.785398163397448309616L) * (diameter * diameter);
  flakes.area_spread = static_cast<T>(species.flake_area_spread);
  flakes.area = area_moments(flakes.area_spread);
  flakes.coverage = flakes.areal_density * flakes.flake_area * flakes.area.mean;
  flakes.orientation = make_orientation(species.orientation, static_cast<T>(species.tilt));
  const T spread = static_cast<T>(species.flake_spread);
  const T edge = diffraction == Diffraction::disc ? diffraction_spread(diameter_um, eta) : T(0);
  flakes.solid_angle = std::numbers::pi_v<T> * (spread * spread + edge * edge);
  flakes.coating = {Rgb<T>(species.flake_color), Rgb<T>(species.flake_edge_color),
                    Rgb<T>(species.flake_transmission)};
  flakes.coating.kind = species.coating;
  flakes.coating.thickness_nm = static_cast<T>(species.coating_nm);
  return flakes;
}

// The paint as the evaluation needs it; the operations are the shader's. `paint` must be valid.
template <class T>
Layer<T> make_layer(const Paint& paint) {
  Layer<T> layer;
  layer.eta = static_cast<T>(paint.binder_ior);
  layer.species = 1;
  layer.coverage = 0;
  for (int i = 0; i < kSpecies; ++i) {
    Flakes<T>& flakes = layer.flakes[static_cast<std::size_t>(i)];
    flakes = make_flakes(paint.species(i), layer.eta, paint.diffraction);
    if (flakes.areal_density > 0) layer.species = i + 1;
    layer.coverage += flakes.coverage;
  }
  const T rayleigh = T(16.7551608191455638468L) * static_cast<T>(paint.rayleigh_per_mm);  // 16 pi/3
  const T thickness_mm = static_cast<T>(paint.layer_thickness_um) * T(0.001);
  layer.binder_depth = (Rgb<T>(paint.binder_absorption_per_mm) + grey(rayleigh)) * thickness_mm;
  layer.rayleigh_depth = rayleigh * thickness_mm;
  layer.depth_model = paint.depth_model;
  layer.radiometry = paint.radiometry;
  layer.sparkle_contrast = static_cast<T>(paint.sparkle_contrast);
  return layer;
}

// The stream of deviates of a light slot and a species (both 0-based) in this paint.
inline HashWords paint_stream(const Paint& paint, int light, int species = 0) {
  return stream_key(light, species, paint.frame, paint.seed);
}

}  // namespace metallic_paint
