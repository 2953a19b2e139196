// SPDX-License-Identifier: Apache-2.0
#include "disc_layer.h"

#include <numbers>

namespace metallic_paint::reference {
namespace {

// As many uniform deviates as can be multiplied before the product falls below exp(-mean) (Knuth),
// a part of the mean after the other.
std::size_t poisson_deviate(double mean, RandomStream& random) {
  constexpr double most = 500;
  std::size_t count = 0;
  for (; mean > 0; mean -= most) {
    const double least = std::exp(-std::min(mean, most));
    for (double product = random(); product > least; product *= random()) ++count;
  }
  return count;
}

}  // namespace

DiscLayer::DiscLayer(const std::vector<Species>& flakes, double thickness_um, double box,
                     RandomStream random)
    : side(box) {
  std::vector<Disc> all;
  double widest = 0;
  for (std::size_t i = 0; i < flakes.size(); ++i) {
    const Species& some = flakes[i];
    const double to_layer = 1e6 / thickness_um;  // from metres
    const double density = some.flakes.flakes_per_mm2 * 1e6 / (to_layer * to_layer);
    for (std::size_t left = poisson_deviate(density * side * side, random); left > 0; --left) {
      const Vec3<double> centre{side * random(), side * random(), -random()};
      const Vec3<double> normal = some.normals.sample(random);
      const double radius2 = flake_area(some, random) / std::numbers::pi * to_layer * to_layer;
      const double reach = std::sqrt(radius2 * std::max(1 - normal.z * normal.z, 0.0));
      top = std::max(top, centre.z + reach);
      bottom = std::min(bottom, centre.z - reach);
      widest = std::max(widest, 2 * std::sqrt(radius2));
      all.push_back({centre, normal, radius2, static_cast<std::uint32_t>(i),
                     static_cast<std::uint32_t>(all.size())});
    }
  }
  // Cells of about one centre each, none much smaller than a disc.
  const double count = static_cast<double>(std::max<std::size_t>(all.size(), 1));
  const double thick = top - bottom;
  width_ = std::max(std::cbrt(thick * side * side / count), widest / 2);
  if (width_ > thick) width_ = std::max(side / std::sqrt(count), widest / 2);
  columns_ = std::max(static_cast<int>(side / width_), 1);
  floors_ = std::max(static_cast<int>(thick / width_), 1);
  width_ = side / columns_;
  height_ = thick / floors_;

  // All cells that a disc reaches into: `visit` gets the cell and the disc in its frame.
  const auto spread = [&](const auto& visit) {
    constexpr double slack = 1e-9;  // rounding
    const auto cell_at = [](double x, double size) {
      return static_cast<int>(std::floor(x / size));
    };
    for (const Disc& disc : all) {
      const auto reach = [&](double component) {
        return std::sqrt(disc.radius2 * std::max(1 - component * component, 0.0)) + slack * width_;
      };
      const double rx = reach(disc.normal.x), ry = reach(disc.normal.y), rz = reach(disc.normal.z);
      const int low = std::clamp(cell_at(disc.centre.z - rz - bottom, height_), 0, floors_ - 1);
      const int high = std::clamp(cell_at(disc.centre.z + rz - bottom, height_), 0, floors_ - 1);
      for (int y = cell_at(disc.centre.y - ry, width_); y <= cell_at(disc.centre.y + ry, width_);
           ++y) {
        const int box_y = cell_at(y, columns_);
        for (int x = cell_at(disc.centre.x - rx, width_); x <= cell_at(disc.centre.x + rx, width_);
             ++x) {
          const int box_x = cell_at(x, columns_);
          Disc copy = disc;
          copy.centre.x -= side * box_x;
          copy.centre.y -= side * box_y;
          for (int z = low; z <= high; ++z) {
            const auto n = static_cast<std::size_t>(columns_);
            visit(
                (static_cast<std::size_t>(z) * n + static_cast<std::size_t>(y - box_y * columns_)) *
                        n +
                    static_cast<std::size_t>(x - box_x * columns_),
                copy);
          }
        }
      }
    }
  };
  const auto cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(columns_) *
                     static_cast<std::size_t>(floors_);
  begin_.assign(cells + 1, 0);
  spread([&](std::size_t cell, const Disc&) { ++begin_[cell + 1]; });
  for (std::size_t i = 0; i < cells; ++i) begin_[i + 1] += begin_[i];
  discs_.resize(begin_[cells]);
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  spread([&](std::size_t cell, const Disc& disc) { discs_[next[cell]++] = disc; });
}

DiscLayer::Hit DiscLayer::first(Vec3<double> from, Vec3<double> direction, double limit,
                                std::uint32_t skipped) const {
  Hit hit;
  walk_cells(from, direction, limit,
             [&](std::span<const Disc> discs, Vec3<double> origin, double begin, double end) {
               for (const Disc& disc : discs) {
                 if (disc.index == skipped) continue;
                 const double distance = distance_to(disc, origin, direction);
                 if (!(distance >= begin && distance < end)) continue;
                 hit = {&disc, distance};
                 end = distance;
               }
               return hit.disc == nullptr;
             });
  return hit;
}

}  // namespace metallic_paint::reference
