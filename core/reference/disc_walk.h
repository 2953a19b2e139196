// SPDX-License-Identifier: Apache-2.0
//
// A virtual goniophotometer for finite flakes: photons walk through discs that lie as they lie, so
// that what hides a flake from the light may hide it from the observer as well. Any number of
// mirrorings; the random walk (random_walk.h) is the limit of flakes far smaller than the layer is
// thick.
//
// Frame, shares and parts are those of the walk. Lengths are in units of the layer's thickness, and
// each batch of photons has a layer of its own (disc_layer.h). Flakes are plane: flake_spread and
// diffraction do not matter here, nor do depth_model and radiometry.
//
// A mirror sends its light one way only, so light cannot be sent on from it to a detector. But in a
// Poisson process the sum over its flakes of anything is the integral over one more flake, put
// anywhere (Mecke 1967). So on each way of a photon one more flake is put, turned so that it
// mirrors to a random direction of the detector's cone, and dims the photon's ways before where it
// lies across them. What remains is light that one flake mirrored twice or more, at last the last
// time: that is counted in the cones. Substrate and pigment are joined to a direction of each cone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numbers>
#include <stop_token>
#include <vector>

#include "../paint.h"
#include "estimate.h"

namespace metallic_paint::reference {

struct DiscScene {
  Paint paint;                            // layer_thickness_um above 0
  Rgb<double> substrate{0.8, 0.8, 0.8};   // albedo of the Lambertian substrate, 0 to 1
  Vec3<double> light{0, 0, 1};            // unit, above the surface
  double light_radius = 0;                // angular: evenly bright, wholly above the surface, rad
  std::vector<Vec3<double>> detectors{};  // unit, at most 4096
  // Angular, of each: above 0 and at most 0.5 rad; wholly above the surface.
  double detector_radius = std::numbers::pi / 60;
  std::size_t photons = 1'000'000;  // from 2 to 1e12, and no more than a day's work (work.h)
  std::size_t layers = 64;          // independent, from 2 to 65536 and at most the photons
  // Side of the box that repeats itself, over the thickness or the widest flake, whichever is
  // larger: 2 to 1000. The box also holds 2048 flakes at least, and at most 1e7.
  double box = 6;
  // false: all that flakes send out is counted in the cones, and errors are several times as large.
  bool joined = true;
  std::uint64_t seed = 0;
};

// Errors are those among layers.
struct DiscResult {
  Estimate specular;      // mirrored by the binder's surface; exact for light without a radius
  ByComponent albedo;     // share that comes back, without the specular
  Estimate absorbed;      // share absorbed by flakes, binder and substrate
  Estimate truncated;     // share still under way after kMostScatterings
  std::size_t steps = 0;  // of all photons, from one event to the next
  // 1/sr, without the specular: the mean over the cones of light and detector, each by its
  // projected solid angle. So both may change places.
  std::vector<ByComponent> brdf;
};

// Throws std::invalid_argument with a sentence that names the field, its value and the allowed
// range.
void validate(const DiscScene& scene);

// On all cores; the result depends on the scene alone. Soon after `stop` is requested it comes back
// with a result that means nothing. 1e6 photons take a few seconds of a core.
DiscResult trace_discs(const DiscScene& scene, const std::stop_token& stop = {});

}  // namespace metallic_paint::reference
