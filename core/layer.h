// SPDX-License-Identifier: Apache-2.0
//
// The paint as the evaluation needs it: up to three species of flakes in a binder, and how the
// layer dims what passes it.
#pragma once

#include <array>
#include <cstddef>

#include "choices.h"
#include "coating.h"
#include "flake_area.h"
#include "optical_thickness.h"
#include "orientation.h"
#include "vector.h"

namespace metallic_paint {

// One species of flakes. SI units.
template <class T>
struct Flakes {
  T areal_density{};      // D H, flakes per m2 of paint
  T flake_area{};         // mean of the area's normal deviate, m2
  T area_spread{};        // its standard deviation over its mean
  AreaMoments<T> area{};  // moments of the area in units of flake_area
  T coverage{};           // D H <S>
  OrientationDensity<T> orientation{};
  T solid_angle{};  // pi epsilon^2: what the flake itself adds to the light's cone, sr in the
                    // binder
  Coating<T> coating{};
};

inline constexpr int kSpecies = 3;

// A paint as the evaluation needs it. SI units; made and checked by `make_layer` (paint.h).
//
// depth_model: with (attenuated), without (thinned) masking and shadowing (paper, 5.3.2). Which is
// right the paper left open: against discs that really hide each other (docs/accuracy) attenuated
// fluctuates more like them. The mean that both share takes the ways to observer and light for
// independent; where they run past the same flakes (light behind the observer, flakes as large as
// the layer is thick) the discs are brighter, up to twice at a coverage of 3.
//
// radiometry: published is the paper's formulas to the letter wherever its assumption holds, flakes
// far below the pixel. Where fewer than kPoissonSlots flakes fill the pixel, it too is kept below
// the mirror, by the same count and ceiling as exact.
template <class T>
struct Layer {
  std::array<Flakes<T>, kSpecies> flakes;
  int species;  // so many of them are in use
  T coverage;   // of all species together
  T eta;
  Rgb<T> binder_depth;  // H ((16 pi/3) c1 + kappa)
  T rayleigh_depth;     // H (16 pi/3) c1
  DepthModel depth_model;
  Radiometry radiometry;
  T sparkle_contrast;  // share of the sparkles' fluctuation that is shown
};

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
