// SPDX-License-Identifier: Apache-2.0
//
// Brute force: individual flakes in a plane layer, traced one by one. What the closed model of
// core/sparkles.h is measured against; shares with it the parameters of the paint and no formula.
//
// The layer fills 0 >= z >= -H below the surface z = 0. Flakes are discs; their centres are uniform
// in the layer, as many of each species as a Poisson process gives. A flake sparkles if it mirrors
// the observer's ray, refracted into the binder, so that it meets the light after leaving the
// binder. With a spread > 0 (flake_spread and diffraction) the flake spreads the mirrored ray
// evenly over a disc of solid angle pi spread^2 in the binder and sparkles if that holds any of
// `points` points spread over the light.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "../paint.h"

namespace metallic_paint::reference {

// How the layer dims a sparkle. The binder's absorption and scattering always do.
enum class Shadowing {
  none = 0,        // by nothing else
  attenuated = 1,  // by the mean optical depth above the flake's centre, exp(-z t)
  thinned = 2,     // not at all, or whole: it survives with the probability exp(-z t) of the least
                   // absorbed colour, and the other colours are dimmed besides
  discs = 3        // by the other flakes, each a disc that transmits what its coating does
};

// With discs, `points` points of a sparkling flake are joined to the surface, towards observer and
// light, and each disc in between dims them. The lacquer covers all flakes, whose centres alone the
// layer holds (as in disc_layer.h): what of them sticks out of its top hides as the rest does.
struct ExplicitScene {
  Paint paint;               // depth_model, radiometry, seed and frame do not matter
  Vec3<double> view, light;  // unit, away from the paint (normal +z); below it nothing sparkles
  double light_radius = 0;   // angular, outside: 0 to pi/2 rad; not 0 where the spread is
  double footprint = 0;      // Sigma: the pixel is a square, and its flakes those centred in it, m2
  std::size_t pixels = 1;    // 1 to 2^24: half a gigabyte of results
  Shadowing shadowing = Shadowing::discs;
  int points = 16;  // on a flake and on the light, 1 to 65536
  std::uint64_t seed = 0;
};

struct ExplicitResult {
  std::vector<double> count;                // of sparkles, for each pixel
  std::vector<Rgb<double>> radiance;        // T, per unit irradiance normal to the light, 1/sr
  double flakes = 0;                        // traced in all pixels
  std::array<double, kSpecies> sparkles{};  // of each species in all pixels
  // Over all sparkles, each counted alike: E[s] and E[s^2] of the share s that `shadowing` leaves
  // of a sparkle (discs: of the binder's own losses nothing, s is the mean over the flake's
  // points). 0 without sparkles.
  Rgb<double> mean_share, mean_square_share;
};

// Throws std::invalid_argument with a sentence that names the field, its value and its range.
void validate(const ExplicitScene& scene);

// On all cores; the same for a seed whatever their number. Soon after `stop` is requested it comes
// back with a result that means nothing.
ExplicitResult trace_explicit_flakes(const ExplicitScene& scene, const std::stop_token& stop = {});

}  // namespace metallic_paint::reference
