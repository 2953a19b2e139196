// SPDX-License-Identifier: Apache-2.0
//
// How the flakes of a plane dim one of them, on the way from it to the observer and to the light.
#pragma once

#include <stop_token>
#include <vector>

#include "flake_plane.h"
#include "view_and_light.h"

namespace metallic_paint::reference {

// By their mean: the optical depth of the whole layer on both ways together.
class MeanShadowing {
 public:
  MeanShadowing(const FlakePlane& plane, const ViewAndLight& beams);
  Rgb<double> depth(double cos_light) const;  // the cosine of the light in the binder

 private:
  // The mean transmittance of a species towards the observer, and towards the light at even steps
  // of the cosine; only where it depends on the angle.
  struct Passed {
    Rgb<double> to_view{};
    std::vector<Rgb<double>> to_light{};
  };

  const FlakePlane& plane_;
  const ViewAndLight& beams_;
  std::vector<Passed> passed_;  // for each species
};

// By the others as they lie, each a disc: the share of a flake of that area that is seen and lit,
// as a mean over `points` points of it. home, index: where it is in the plane.
Rgb<double> visible_share(const FlakePlane& plane, Vec3<double> view_in, Vec3<double> towards_light,
                          Cell home, std::uint64_t index, const Flake& flake, double area,
                          int points, RandomStream& random, const std::stop_token& stop);

}  // namespace metallic_paint::reference
