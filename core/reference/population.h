// SPDX-License-Identifier: Apache-2.0
//
// The flakes of a paint by species, as the references meet them.
#pragma once

#include <cstddef>
#include <vector>

#include "flake_normals.h"
#include "optics.h"

namespace metallic_paint::reference {

// The flakes of one species.
struct Population {
  std::size_t index;  // of the species in the paint
  const FlakeSpecies& flakes;
  double coverage, spread;
  FlakeNormals normals;
  ProjectedAreaTable projected_area;

  Population(const Paint& paint, std::size_t at)
      : index(at),
        flakes(paint.species(static_cast<int>(at))),
        coverage(flake_coverage(flakes)),
        spread(flake_spread(paint, flakes)),
        normals(flakes.orientation, flakes.tilt),
        projected_area(normals) {}

  // <t_p>/<s>: the mean transmittance of the flakes that a ray meets.
  Rgb<double> mean_transmittance(double cos_theta) const {
    if (!transmits_by_angle(flakes)) return flake_transmittance(flakes, 1);
    const Rgb<double> passed = normals.transmitted_area(
        cos_theta, [&](double cosine) { return flake_transmittance(flakes, cosine); });
    return passed / projected_area.at(cos_theta);
  }
};

// The species of which there are flakes; the first if there are none at all. The paint must outlive
// them.
inline std::vector<Population> populations(const Paint& paint) {
  std::vector<Population> all;
  for (std::size_t i = 0; i < kSpecies; ++i) {
    if (paint.species(static_cast<int>(i)).flakes_per_mm2 > 0) all.emplace_back(paint, i);
  }
  if (all.empty()) all.emplace_back(paint, 0);
  return all;
}

}  // namespace metallic_paint::reference
