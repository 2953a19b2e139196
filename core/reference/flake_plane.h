// SPDX-License-Identifier: Apache-2.0
//
// A plane of individual flakes. It is cut into square cells whose flakes are made from a hash of
// the cell whenever they are needed, so that it has no edge and is stored nowhere. All lengths in
// m.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "optics.h"
#include "population.h"
#include "random.h"

namespace metallic_paint::reference {

// Of any flake of the species.
double largest_radius(const FlakeSpecies& flakes);

double flakes_per_m2(const Paint& paint);

struct Species : Population {
  explicit Species(const Population& some);

  double mean_area;  // of the deviate before it is cut off at 0
  double up_to = 0;  // density of the flakes of this species and those before it, 1/m2
};

struct Cell {
  std::int64_t x, y;
};

struct Flake {
  const Species* species;
  Vec3<double> position;  // from the corner of its cell
  double depth;           // of its centre, 0 to 1 of the layer
  Vec3<double> normal;
  RandomStream rest;  // its area first, then whatever its tracing needs
};

double flake_area(const Species& species, RandomStream& random);

class FlakePlane {
 public:
  // The paint must outlive it.
  FlakePlane(const Paint& paint, double footprint, std::size_t pixels, std::uint64_t seed);

  // Calls visit(flake, index) for each flake of a cell.
  template <class Visit>
  void visit_cell(Cell cell, const Visit& visit) const;

  // Calls visit(flake, index, whether at home) for all flakes centred within `margin` of the
  // segment, seen from above, or leaves off when `stop` is requested. Positions count from the
  // corner of the cell `home`.
  template <class Visit>
  void visit_along(Cell home, Vec3<double> from, Vec3<double> way, double margin,
                   const std::stop_token& stop, const Visit& visit) const;

  std::vector<Species> species{};
  double thickness;
  double widest_radius = 0;  // of any flake
  // A tile is the work of one thread at a time: one pixel of many cells, or one cell of many
  // pixels.
  double pixel, cell;                // sides
  std::int64_t cells_per_side = 1;   // of a tile
  std::int64_t pixels_per_side = 1;  // of a tile
  std::int64_t tiles, columns;

 private:
  RandomStream stream_of(Cell cell) const;
  Flake make_flake(const RandomStream& cell, std::uint64_t index) const;

  std::uint64_t seed_;
  double no_flake_;  // probability of an empty cell
};

// Their number: as many uniform deviates as can be multiplied before the product falls below
// exp(-mean) (Knuth).
template <class Visit>
void FlakePlane::visit_cell(Cell at, const Visit& visit) const {
  const RandomStream key = stream_of(at);
  RandomStream random = key;
  std::uint64_t index = 0;
  for (double product = random(); product > no_flake_; product *= random()) {
    visit(make_flake(key, index), index);
    ++index;
  }
}

template <class Visit>
void FlakePlane::visit_along(Cell home, Vec3<double> from, Vec3<double> way, double margin,
                             const std::stop_token& stop, const Visit& visit) const {
  const auto cell_at = [&](double x) { return static_cast<std::int64_t>(std::floor(x / cell)); };
  const std::int64_t last = cell_at(std::max(from.y, from.y + way.y) + margin);
  for (std::int64_t row = cell_at(std::min(from.y, from.y + way.y) - margin); row <= last; ++row) {
    // The part of the segment within `margin` of this row.
    double begin = 0, end = 1;
    if (way.y != 0) {
      const double low = (static_cast<double>(row) * cell - margin - from.y) / way.y;
      const double high = (static_cast<double>(row + 1) * cell + margin - from.y) / way.y;
      begin = std::clamp(std::min(low, high), 0.0, 1.0);
      end = std::clamp(std::max(low, high), 0.0, 1.0);
    }
    const double x0 = from.x + way.x * begin, x1 = from.x + way.x * end;
    const std::int64_t right = cell_at(std::max(x0, x1) + margin);
    for (std::int64_t column = cell_at(std::min(x0, x1) - margin);
         column <= right && !stop.stop_requested(); ++column) {
      const Vec3<double> corner{static_cast<double>(column) * cell, static_cast<double>(row) * cell,
                                0};
      visit_cell({home.x + column, home.y + row}, [&](Flake flake, std::uint64_t index) {
        flake.position = flake.position + corner;
        visit(flake, index, column == 0 && row == 0);
      });
    }
  }
}

}  // namespace metallic_paint::reference
