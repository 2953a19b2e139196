// SPDX-License-Identifier: Apache-2.0
//
// The paint as the evaluation needs it: up to three species of flakes in a binder, and how the
// layer dims what passes it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>

#include "coating.h"
#include "flake_area.h"
#include "optical_thickness.h"
#include "orientation.h"
#include "parameters.h"
#include "refraction.h"
#include "vector.h"

namespace metallic_paint {

// One species of flakes. SI units.
template <class T>
struct Flakes {
  T areal_density{};  // D H, flakes per m2 of paint
  T flake_area{};     // mean of the area's normal deviate, m2
  T area_spread{};    // its standard deviation over its mean
  T area_mean{};      // mean of the area in units of flake_area
  T area_square{};    // mean of its square over the mean's
  T coverage{};       // D H <S>
  OrientationDensity<T> orientation{};
  T solid_angle{};  // pi epsilon^2: what the flake itself adds to the light's cone, sr in the
                    // binder
  Coating<T> coating{};
  T diameter{};  // m
};

// A paint as the evaluation needs it. SI units; made by `make_layer`.
//
// depth_model: with (attenuated), without (thinned) masking and shadowing (paper, 5.3.2). Which is
// right the paper left open: against discs that really hide each other (docs/accuracy) attenuated
// fluctuates more like them. The mean that both share takes the ways to observer and light for
// independent; where they run past the same flakes (light behind the observer, flakes as large as
// the layer is thick) the discs are brighter, up to twice at a coverage of 3. Correlated (ours,
// hot_spot.h) is attenuated with what both ways share.
//
// radiometry: published is the paper's formulas to the letter wherever its assumption holds, flakes
// far below the pixel. Where fewer than kPoissonSlots flakes fill the pixel, it too is kept below
// the mirror, by the same count and ceiling as exact; flakes seen close up are not (close_up.h).
template <class T>
struct Layer {
  std::array<Flakes<T>, kSpecies> flakes;
  int species;  // so many of them are in use
  T coverage;   // of all species together
  T eta;
  Rgb<T> binder_depth;  // H ((16 pi/3) c1 + kappa)
  T rayleigh_depth;     // H (16 pi/3) c1
  // Of hot_spot.h: c and b for each colour, and of each species its share of what all cover, its D
  // in m, H/D, and over D how far below the layer the substrate lies.
  Rgb<T> shared_blocking, blocking_again;
  std::array<T, kSpecies> hiding, diameters, thickness_in_flakes, gap_in_flakes;
  T haze;  // solid angle of tilts of the coat's facets, for each way through it
  DepthModel depth_model;
  Radiometry radiometry;
  T sparkle_contrast;  // share of the sparkles' fluctuation that is shown
  Anchor anchor;
  Instances instances;
  T cell_share;  // of a pixel's footprint that a cell of the surface has
};

// At normal incidence a plane mirror of area S turns a plane wave into one that has the brightness
// S/lambda^2 of its flux per steradian in the middle: that of a cone of solid angle lambda^2/S, pi
// epsilon^2 = lambda^2/(pi d^2/4). So epsilon = 2 lambda/(pi d), with lambda = 550 nm/eta in the
// binder; at most 0.5 rad, where d is no longer large against lambda.
template <class T>
T diffraction_spread(T diameter_um, T eta) {
  return min(T(0.350140874802169738692L) / (eta * diameter_um), T(0.5));  // 2 x 0.55/pi
}

template <class T>
Flakes<T> make_flakes(const FlakeSpecies& species, T eta, Diffraction diffraction) {
  Flakes<T> flakes;
  flakes.areal_density = static_cast<T>(species.flakes_per_mm2) * T(1e6);
  const T diameter_um = static_cast<T>(species.flake_diameter_um);
  const T diameter = diameter_um * T(1e-6);
  flakes.flake_area = T(0.785398163397448309616L) * (diameter * diameter);
  flakes.area_spread = static_cast<T>(species.flake_area_spread);
  flakes.area_mean = area_mean(flakes.area_spread);
  flakes.area_square = area_square(flakes.area_spread);
  flakes.coverage = flakes.areal_density * flakes.flake_area * flakes.area_mean;
  flakes.orientation = make_orientation(species.orientation, static_cast<T>(species.tilt));
  // Light that comes through the surface lies higher, and meets no flake's back.
  if (flakes.orientation.back_cosine <= critical_cosine(eta)) flakes.orientation.back_cosine = 0;
  const T spread = static_cast<T>(species.flake_spread);
  const T edge = diffraction == Diffraction::disc ? diffraction_spread(diameter_um, eta) : T(0);
  flakes.solid_angle = std::numbers::pi_v<T> * (spread * spread + edge * edge);
  flakes.coating = {Rgb<T>(species.flake_color), Rgb<T>(species.flake_edge_color),
                    Rgb<T>(species.flake_transmission)};
  flakes.coating.kind = species.coating;
  flakes.coating.thickness_nm = static_cast<T>(species.coating_nm);
  flakes.diameter = diameter;
  return flakes;
}

// t_p at some 25 degrees, as most light meets flakes.
template <class T>
Rgb<T> usual_transmittance(const Flakes<T>& flakes) {
  return coating_transmittance(flakes.coating, T(0.9));
}

// D H <S> <cos(beta)> (1 - t_p)^2.
template <class T>
Rgb<T> shared_blocking_of(const Flakes<T>& flakes, Rgb<T> transmitted) {
  const Rgb<T> kept = grey(T(1)) - transmitted;
  return kept * kept * (flakes.coverage * flakes.orientation.mean_cos);
}

// b has (1 - t_p^2)^2 - (1 - t_p)^2 in place of that square.
template <class T>
void add_blocking(Layer<T>& layer, const Flakes<T>& flakes) {
  const Rgb<T> transmitted = usual_transmittance(flakes);
  const Rgb<T> blocking = shared_blocking_of(flakes, transmitted);
  layer.shared_blocking = layer.shared_blocking + blocking;
  layer.blocking_again = layer.blocking_again + blocking * transmitted * (grey(T(2)) + transmitted);
}

// How far the lowest of these flakes reach below the layer, in which their centres lie. Of some
// thousands one has a sin(beta) of 2.5 sqrt(1 - <cos(beta)>^2).
template <class T>
T reach_below(const Flakes<T>& flakes) {
  const T mean_cos = flakes.orientation.mean_cos;
  const T sine = sqrt(max((1 - mean_cos) * (1 + mean_cos), T(0)));
  return flakes.diameter * min(T(1.25) * sine, T(0.5));
}

// The paint as the evaluation needs it; the operations are the shader's. `paint` must be valid.
template <class T>
Layer<T> make_layer(const Paint& paint) {
  Layer<T> layer;
  layer.eta = static_cast<T>(paint.binder_ior);
  layer.species = 1;
  layer.coverage = 0;
  layer.shared_blocking = layer.blocking_again = {};
  T gap = 0;
  for (int i = 0; i < kSpecies; ++i) {
    Flakes<T>& flakes = layer.flakes[static_cast<std::size_t>(i)];
    flakes = make_flakes(paint.species(i), layer.eta, paint.diffraction);
    if (flakes.areal_density > 0) layer.species = i + 1;
    layer.coverage += flakes.coverage;
    add_blocking(layer, flakes);
    if (flakes.coverage > 0) gap = max(gap, reach_below(flakes));
  }
  const T rayleigh = T(16.7551608191455638468L) * static_cast<T>(paint.rayleigh_per_mm);  // 16 pi/3
  const T thickness_mm = static_cast<T>(paint.layer_thickness_um) * T(0.001);
  layer.binder_depth = (Rgb<T>(paint.binder_absorption_per_mm) + grey(rayleigh)) * thickness_mm;
  layer.rayleigh_depth = rayleigh * thickness_mm;
  for (std::size_t i = 0; i < kSpecies; ++i) {
    layer.hiding[i] = 0;
    if (layer.coverage > 0) layer.hiding[i] = layer.flakes[i].coverage / layer.coverage;
    layer.diameters[i] = layer.flakes[i].diameter;
    layer.thickness_in_flakes[i] = thickness_mm * T(0.001) / layer.diameters[i];
    layer.gap_in_flakes[i] = gap / layer.diameters[i];
  }
  // Of two GGX densities convolved, those of the ways in and out, the peak is that of a disc of 3
  // pi alpha^2, 1.5 a way; their long tails take as much again from the flakes. The sparkles' mean
  // is then within 12 % of facets drawn one by one, up to a roughness of 0.5 and views of 60
  // degrees; seen as through a smooth coat up to 50 % off (Sparkles.ThroughARoughCoat).
  const T alpha = static_cast<T>(paint.coat_roughness) * static_cast<T>(paint.coat_roughness);
  layer.haze = 3 * std::numbers::pi_v<T> * (alpha * alpha);
  layer.depth_model = paint.depth_model;
  layer.radiometry = paint.radiometry;
  layer.sparkle_contrast = static_cast<T>(paint.sparkle_contrast);
  layer.anchor = paint.anchor;
  layer.instances = paint.instances;
  layer.cell_share = 1 / static_cast<T>(paint.cells_per_pixel);
  return layer;
}

// D H <S> (<s> - <t_p>) of all species: what the flakes take out of a beam, per colour, times its
// cosine in the binder.
template <class T>
Rgb<T> flake_blocking(const Layer<T>& layer, T cos_in) {
  Rgb<T> sum{};
  for (int i = 0; i < layer.species; ++i) {
    const Flakes<T>& flakes = layer.flakes[static_cast<std::size_t>(i)];
    sum = sum + blocked_area(flakes.orientation, flakes.coating, cos_in) * flakes.coverage;
  }
  return sum;
}

// The optical depth of the layer along view and light, given the cosines in the binder.
template <class T>
Rgb<T> slant_depth_of(const Layer<T>& layer, T cos_in) {
  return slant_depth(flake_blocking(layer, cos_in), layer.binder_depth, cos_in);
}

}  // namespace metallic_paint
