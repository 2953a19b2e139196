// SPDX-License-Identifier: Apache-2.0
#include "flake_plane.h"

#include <numbers>

namespace metallic_paint::reference {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFlakesPerCell = 4;     // up to four times as many
constexpr double kMostPerSide = 0x1p26;  // pixels of a cell

// Box and Muller; at most sqrt(2 log 2^53) in size.
constexpr double kLargestDeviate = 8.6;
double normal_deviate(RandomStream& random) {
  const double radius = std::sqrt(-2 * std::log(random()));
  return radius * std::cos(2 * kPi * random());
}

double disc_area(const FlakeSpecies& flakes) {
  return kPi / 4 * square(flakes.flake_diameter_um * 1e-6);
}

}  // namespace

double largest_radius(const FlakeSpecies& flakes) {
  return std::sqrt(disc_area(flakes) * (1 + flakes.flake_area_spread * kLargestDeviate) / kPi);
}

double flakes_per_m2(const Paint& paint) {
  double sum = 0;
  for (int i = 0; i < kSpecies; ++i) sum += paint.species(i).flakes_per_mm2;
  return sum * 1e6;
}

Species::Species(const Population& some) : Population(some), mean_area(disc_area(flakes)) {}

double flake_area(const Species& species, RandomStream& random) {
  return species.mean_area *
         std::max(0.0, 1 + species.flakes.flake_area_spread * normal_deviate(random));
}

FlakePlane::FlakePlane(const Paint& paint, double footprint, std::size_t pixels, std::uint64_t seed)
    : thickness(paint.layer_thickness_um * 1e-6), pixel(std::sqrt(footprint)), seed_(seed) {
  double so_far = 0;
  for (const Population& some : populations(paint)) {
    species.emplace_back(some);
    widest_radius = std::max(widest_radius, largest_radius(some.flakes));
    so_far += some.flakes.flakes_per_mm2 * 1e6;
    species.back().up_to = so_far;
  }
  // Cells along a pixel, or pixels along a cell.
  const double density = flakes_per_m2(paint);
  const double ratio = std::sqrt(density * footprint / kFlakesPerCell);
  if (ratio >= 1) {
    cells_per_side = static_cast<std::int64_t>(ratio);
  } else {
    pixels_per_side = static_cast<std::int64_t>(std::ceil(1 / std::max(ratio, 1 / kMostPerSide)));
  }
  cell = pixel * static_cast<double>(pixels_per_side) / static_cast<double>(cells_per_side);
  no_flake_ = std::exp(-density * square(cell));
  const std::int64_t in_tile = pixels_per_side * pixels_per_side;
  tiles = (static_cast<std::int64_t>(pixels) + in_tile - 1) / in_tile;
  columns = static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(tiles))));
}

RandomStream FlakePlane::stream_of(Cell at) const {
  return RandomStream(seed_)
      .substream(static_cast<std::uint64_t>(at.x))
      .substream(static_cast<std::uint64_t>(at.y));
}

Flake FlakePlane::make_flake(const RandomStream& key, std::uint64_t index) const {
  RandomStream random = key.substream(index);
  const Species* some = species.data();
  if (species.size() > 1) {
    const double pick = random() * species.back().up_to;
    while (some != &species.back() && pick >= some->up_to) ++some;
  }
  const double x = random(), y = random(), depth = random();
  const Vec3<double> position{cell * x, cell * y, -thickness * depth};
  const Vec3<double> normal = some->normals.sample(random);
  return {some, position, depth, normal, random};
}

}  // namespace metallic_paint::reference
