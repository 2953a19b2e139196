// SPDX-License-Identifier: Apache-2.0
//
// A virtual goniophotometer: photons walk through the whole paint, one scattering after the other,
// with nothing approximated but the number of photons. The layer is the model's (flakes without
// correlation, smooth surface); the code shares none of the model's formulas.
//
// Frame: paint normal = z; light and detectors are unit vectors that point away from the surface,
// outside it. All shares are of the flux that falls on the surface, so they do not depend on the
// strength of the light. Paint::flake_spread, diffraction, depth_model and
// radiometry do not matter here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "../paint.h"
#include "estimate.h"

namespace metallic_paint::reference {

struct WalkScene {
  Paint paint;
  Rgb<double> substrate{0.8, 0.8, 0.8};   // albedo of the Lambertian substrate, 0 to 1
  Vec3<double> light{0, 0, 1};            // above the surface
  std::vector<Vec3<double>> detectors{};  // above the surface, at most 4096
  std::size_t photons = 1'000'000;        // from 2 to 1e12, and no more than a day's work (work.h)
  // The light that comes back, by direction: even steps in cos(theta) from 0 to 1 and in phi from 0
  // to 2 pi; at most 16384 bins. Both zero: none.
  int theta_bins = 0, phi_bins = 0;
  std::uint64_t seed = 0;
};

struct WalkResult {
  double specular = 0;              // mirrored by the binder's surface
  ByComponent albedo;               // share that comes back, without the specular
  Estimate absorbed;                // share absorbed by flakes, binder and substrate
  Estimate truncated;               // share still under way after kMostScatterings, and
  std::size_t truncated_walks = 0;  // the photons that carried it
  std::size_t steps = 0;            // of all photons, from one event to the next
  std::vector<ByComponent> brdf;    // 1/sr, towards each detector, without the specular
  std::vector<Estimate> bins;       // share that comes back into each bin, row by row of theta
};

// An upper bound for the steps from event to event that a photon takes on average.
double most_steps_of_a_photon(const Paint& paint);

// Throws std::invalid_argument with a sentence that names the field, its value and the allowed
// range.
void validate(const WalkScene& scene);

// On all cores; the result depends on the scene alone. Soon after `stop` is requested it comes back
// with a result that means nothing.
WalkResult walk(const WalkScene& scene, const std::stop_token& stop = {});

}  // namespace metallic_paint::reference
