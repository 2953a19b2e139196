// SPDX-License-Identifier: Apache-2.0
//
// A layer of individual flakes that rays are followed through: discs in a box that repeats itself
// sideways. Lengths in units of the layer's thickness.
//
// The centres are a Poisson process, uniform in 0 >= z >= -1; areas and normals are the paint's. No
// disc is cut: the surface lies at `top`, right above the highest, and the substrate at `bottom`,
// right below the lowest. So a ray that crosses the layer meets as many flakes as the paint says;
// but wide tilted flakes set surface and substrate off, and what the ways to the substrate and back
// share is less by that.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "flake_plane.h"
#include "random.h"

namespace metallic_paint::reference {

struct Disc {
  Vec3<double> centre, normal;
  double radius2;
  std::uint32_t species, index;  // of the population; of the disc in the layer
};

inline constexpr std::uint32_t kNoDisc = std::numeric_limits<std::uint32_t>::max();

class DiscLayer {
 public:
  // thickness_um: above 0, of what is 1 here; side: of the box, wider than any disc.
  DiscLayer(const std::vector<Species>& flakes, double thickness_um, double side,
            RandomStream random);

  struct Hit {
    const Disc* disc = nullptr;
    double distance = 0;
  };

  // The first disc but `skipped` that a ray meets before `limit`. from: in the box, x and y from 0
  // to `side`; the way must not leave bottom and top.
  Hit first(Vec3<double> from, Vec3<double> direction, double limit, std::uint32_t skipped) const;

  // Calls meet(disc) for each that the ray meets before `limit`, nearer ones first but for those of
  // a cell, until it returns false.
  template <class Meet>
  void each(Vec3<double> from, Vec3<double> direction, double limit, std::uint32_t skipped,
            const Meet& meet) const;

  // Into the box.
  Vec3<double> wrapped(Vec3<double> p) const {
    return {p.x - side * std::floor(p.x / side), p.y - side * std::floor(p.y / side), p.z};
  }

  double side, top = 0, bottom = -1;

  // Where the ray meets the disc; infinity if it does not.
  static double distance_to(const Disc& disc, Vec3<double> from, Vec3<double> direction) {
    constexpr double never = std::numeric_limits<double>::infinity();
    const double slope = dot(disc.normal, direction);
    if (slope == 0) return never;
    const Vec3<double> to_centre = disc.centre - from;
    const double distance = dot(disc.normal, to_centre) / slope;
    const Vec3<double> miss = to_centre - direction * distance;
    return dot(miss, miss) <= disc.radius2 ? distance : never;
  }

 private:
  // Visits the cells along a ray, in order, until visit(discs, from, begin, end) returns false:
  // `from` is the ray's origin in the frame of the cell's discs, which lie in the cell from the
  // distance `begin` to `end` (Amanatides and Woo 1987).
  template <class Visit>
  void walk_cells(Vec3<double> from, Vec3<double> direction, double limit,
                  const Visit& visit) const;

  int columns_ = 1, floors_ = 1;    // cells along x and y; along z
  double width_ = 0, height_ = 0;   // of a cell
  std::vector<std::size_t> begin_;  // of each cell's discs, and the end of the last one's
  std::vector<Disc> discs_;         // of cell after cell: each in all that it reaches into
};

template <class Visit>
void DiscLayer::walk_cells(Vec3<double> from, Vec3<double> direction, double limit,
                           const Visit& visit) const {
  struct Axis {
    int at, step;
    double next, each;  // distance of the next wall; from wall to wall
  };
  const auto axis = [](double x, double d, double size, int count) {
    const int at = std::clamp(static_cast<int>(x / size), 0, count - 1);
    if (d == 0) return Axis{at, 0, std::numeric_limits<double>::infinity(), 0};
    const int wall = d > 0 ? at + 1 : at;
    return Axis{at, d > 0 ? 1 : -1, (wall * size - x) / d, size / std::abs(d)};
  };
  Axis x = axis(from.x, direction.x, width_, columns_);
  Axis y = axis(from.y, direction.y, width_, columns_);
  Axis z = axis(from.z - bottom, direction.z, height_, floors_);
  // Through a wall of the box, into its other side.
  const auto cross = [&](Axis& a, double& origin) {
    a.next += a.each;
    a.at += a.step;
    if (a.at < 0 || a.at >= columns_) {
      a.at -= a.step * columns_;
      origin -= a.step * side;
    }
  };
  for (double begin = 0;;) {
    const double end = std::max(begin, std::min({x.next, y.next, z.next, limit}));
    const auto cell = (static_cast<std::size_t>(z.at) * static_cast<std::size_t>(columns_) +
                       static_cast<std::size_t>(y.at)) *
                          static_cast<std::size_t>(columns_) +
                      static_cast<std::size_t>(x.at);
    const std::span<const Disc> discs(discs_.data() + begin_[cell],
                                      begin_[cell + 1] - begin_[cell]);
    if (!visit(discs, from, begin, end) || !(end < limit)) return;
    begin = end;
    if (x.next <= y.next && x.next <= z.next) {
      cross(x, from.x);
    } else if (y.next <= z.next) {
      cross(y, from.y);
    } else {
      z.next += z.each;
      z.at += z.step;
      if (z.at < 0 || z.at >= floors_) return;
    }
  }
}

template <class Meet>
void DiscLayer::each(Vec3<double> from, Vec3<double> direction, double limit, std::uint32_t skipped,
                     const Meet& meet) const {
  walk_cells(from, direction, limit,
             [&](std::span<const Disc> discs, Vec3<double> origin, double begin, double end) {
               for (const Disc& disc : discs) {
                 if (disc.index == skipped) continue;
                 const double distance = distance_to(disc, origin, direction);
                 if (distance >= begin && distance < end && !meet(disc)) return false;
               }
               return true;
             });
}

}  // namespace metallic_paint::reference
