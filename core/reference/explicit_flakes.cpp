// SPDX-License-Identifier: Apache-2.0
#include "explicit_flakes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "../parallel.h"
#include "../validation.h"
#include "flake_plane.h"
#include "optics.h"
#include "shadowing.h"
#include "view_and_light.h"
#include "work.h"

namespace metallic_paint::reference {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::int64_t kTilesAtOnce = 1 << 16;

struct Sums {
  double flakes = 0;
  std::array<double, kSpecies> sparkles{};
  Rgb<double> share{}, square_share{};
};

class Tracer {
 public:
  Tracer(const ExplicitScene& scene, const std::stop_token& stop)
      : scene_(scene),
        plane_(scene.paint, scene.footprint, scene.pixels, scene.seed),
        beams_(scene),
        stop_(stop),
        binder_depth_(absorption_depth(scene.paint) + grey(rayleigh_depth(scene.paint))) {
    const bool by_mean =
        scene.shadowing == Shadowing::attenuated || scene.shadowing == Shadowing::thinned;
    if (by_mean) mean_shadowing_.emplace(plane_, beams_);
  }

  ExplicitResult trace() const;

 private:
  void trace_tile(std::int64_t tile, ExplicitResult& result, Sums& sums) const;
  void trace_flake(Cell home, std::uint64_t index, Flake flake, std::size_t pixel,
                   ExplicitResult& result, Sums& sums) const;

  const ExplicitScene& scene_;
  FlakePlane plane_;
  ViewAndLight beams_;
  const std::stop_token& stop_;
  std::optional<MeanShadowing> mean_shadowing_;  // where it is by their mean
  Rgb<double> binder_depth_;                     // of the whole layer, straight down
};

void Tracer::trace_flake(Cell home, std::uint64_t index, Flake flake, std::size_t pixel,
                         ExplicitResult& result, Sums& sums) const {
  sums.flakes += 1;
  const double facing = dot(flake.normal, beams_.view_in);
  const Vec3<double> mirrored = flake.normal * (2 * facing) - beams_.view_in;
  if (mirrored.z <= 0) return;
  RandomStream random = flake.rest.substream(0);
  const LightMet met = meet_light(beams_, *flake.species, mirrored, random);
  if (!(met.received > 0)) return;

  const double area = flake_area(*flake.species, flake.rest);
  const double slant = 1 / beams_.view_in.z + 1 / met.towards.z;
  const auto dimmed = [&](Rgb<double> depth) {
    return map(depth, [&](double x) { return std::exp(-flake.depth * x); });
  };
  const Rgb<double> absorbed = binder_depth_ * slant;
  Rgb<double> share{1, 1, 1};  // without the binder's, for `none` and `discs`
  Rgb<double> binder = dimmed(absorbed);
  if (scene_.shadowing == Shadowing::discs) {
    share = visible_share(plane_, beams_.view_in, met.towards, home, index, flake, area,
                          scene_.points, random, stop_);
  } else if (mean_shadowing_) {
    share = dimmed(mean_shadowing_->depth(met.towards.z) + absorbed);
    binder = {1, 1, 1};
    if (scene_.shadowing == Shadowing::thinned) {
      const double most = max_component(share);
      if (random() >= most) return;
      share = share / most;
    }
  }
  // The flake covers S cos(alpha)/(cos(theta_p) Sigma) of the pixel.
  const double cos_alpha = std::abs(facing);
  const Rgb<double> coating = flake_reflectance(flake.species->flakes, cos_alpha);
  const double unit = beams_.view_transmittance * met.received * area * cos_alpha /
                      (beams_.view_in.z * scene_.footprint);
  result.count[pixel] += 1;
  result.radiance[pixel] = result.radiance[pixel] + coating * share * binder * unit;
  sums.sparkles[flake.species->index] += 1;
  sums.share = sums.share + share;
  sums.square_share = sums.square_share + share * share;
}

void Tracer::trace_tile(std::int64_t tile, ExplicitResult& result, Sums& sums) const {
  const std::int64_t side = plane_.pixels_per_side;
  const auto first_pixel = static_cast<std::size_t>(tile * side * side);
  const auto pixel_of = [&](const Flake& flake) {
    if (side == 1) return first_pixel;
    const auto place = [&](double x) {
      return std::min(static_cast<std::int64_t>(x / plane_.pixel), side - 1);
    };
    return first_pixel +
           static_cast<std::size_t>(place(flake.position.y) * side + place(flake.position.x));
  };
  const std::int64_t x = tile % plane_.columns * plane_.cells_per_side;
  const std::int64_t y = tile / plane_.columns * plane_.cells_per_side;
  for (std::int64_t row = 0; row < plane_.cells_per_side; ++row) {
    for (std::int64_t column = 0; column < plane_.cells_per_side; ++column) {
      if (stop_.stop_requested()) return;
      const Cell cell{x + column, y + row};
      plane_.visit_cell(cell, [&](const Flake& flake, std::uint64_t index) {
        const std::size_t pixel = pixel_of(flake);
        if (pixel < scene_.pixels) trace_flake(cell, index, flake, pixel, result, sums);
      });
    }
  }
}

ExplicitResult Tracer::trace() const {
  ExplicitResult result;
  result.count.resize(scene_.pixels);
  result.radiance.resize(scene_.pixels);
  if (!beams_.seen) return result;
  // Tiles are added up in their order, so that the cores, however many, round alike.
  Sums all;
  for (std::int64_t first = 0; first < plane_.tiles; first += kTilesAtOnce) {
    std::vector<Sums> sums(static_cast<std::size_t>(std::min(kTilesAtOnce, plane_.tiles - first)));
    const auto trace_one = [&](std::size_t i) {
      trace_tile(first + static_cast<std::int64_t>(i), result, sums[i]);
    };
    parallel_for(sums.size(), trace_one, 1, stop_);
    if (stop_.stop_requested()) break;
    for (const Sums& tile : sums) {
      all.flakes += tile.flakes;
      for (std::size_t i = 0; i < kSpecies; ++i) all.sparkles[i] += tile.sparkles[i];
      all.share = all.share + tile.share;
      all.square_share = all.square_share + tile.square_share;
    }
  }
  result.flakes = all.flakes;
  result.sparkles = all.sparkles;
  const double sparkles = all.sparkles[0] + all.sparkles[1] + all.sparkles[2];
  if (sparkles > 0) {
    result.mean_share = all.share / sparkles;
    result.mean_square_share = all.square_share / sparkles;
  }
  return result;
}

// ---------------------------------------------------------------------------------------------
// The work.

constexpr double kMostNear = 1e8;

// Centred near enough to a flake's ways to the observer and to the light to be looked at, in a
// layer of flakes of the largest size.
double flakes_on_both_ways(const ExplicitScene& scene, const ViewAndLight& beams) {
  if (scene.shadowing != Shadowing::discs) return 0;
  double widest = 0;
  for (int i = 0; i < kSpecies; ++i) {
    const FlakeSpecies& flakes = scene.paint.species(i);
    if (flakes.flakes_per_mm2 > 0) widest = std::max(widest, largest_radius(flakes));
  }
  const double thickness = scene.paint.layer_thickness_um * 1e-6;
  double area = 0;
  for (const double cosine : {beams.view_in.z, beams.least_cosine}) {
    const double farthest = 1e3 * (thickness + widest);  // as shadow() follows it
    const double sine = std::sqrt((1 - cosine) * (1 + cosine));
    const double sideways =
        std::min((thickness + 2 * widest) * sine / std::max(cosine, 1e-9), farthest);
    area += 4 * widest * (sideways + 4 * widest);
  }
  return flakes_per_m2(scene.paint) * area;
}

// On average. A flake's mirrored ray has the density p(n)/(4 cos(alpha)) per solid angle, and p is
// largest along the paint's normal.
double most_steps_of_a_flake(const ExplicitScene& scene, const ViewAndLight& beams, double near) {
  double sparkling = 0, spread = 0;
  for (const Population& some : populations(scene.paint)) {
    const double reach = some.spread + std::sqrt(beams.light_chord2);
    const double half = (std::acos(std::min(dot(beams.view_in, beams.light_in), 1.0)) + reach) / 2;
    const double cap = kPi * square(reach) / (4 * std::cos(std::min(half, kPi / 2)));
    const bool within = beams.eta >= 1 && beams.light_in.z > 0 && half < kPi / 2;
    sparkling =
        std::max(sparkling, within ? std::min(some.normals.density({0, 0, 1}) * cap, 1.0) : 1.0);
    spread = std::max(spread, some.spread);
  }
  const double met = spread > 0 ? beams.light_points : 1;
  const double shaded =
      scene.shadowing == Shadowing::discs ? scene.points + near * (1.0 + scene.points) : 0;
  return 1 + sparkling * (met + shaded);
}

}  // namespace

void validate(const ExplicitScene& scene) {
  metallic_paint::validate(scene.paint);
  require_unit("view", scene.view);
  require_unit("light", scene.light);
  require_range("light_radius", scene.light_radius, 0, kPi / 2, " rad");
  for (int i = 0; i < kSpecies; ++i) {
    const FlakeSpecies& flakes = scene.paint.species(i);
    if (i > 0 && !(flakes.flakes_per_mm2 > 0)) continue;
    const double width = scene.light_radius + flake_spread(scene.paint, flakes);
    if (!(width > 0)) reject("light_radius + flake_spread", width, "above 0 rad for each species");
  }
  require_range("footprint", scene.footprint, 1e-20, 1e6, " m2");
  const auto pixels = static_cast<double>(scene.pixels);
  require_range("pixels", pixels, 1, 0x1p24);
  require_range("points", scene.points, 1, 65536);
  const auto shadowing = static_cast<int>(scene.shadowing);
  if (shadowing < 0 || shadowing > 3) {
    reject("shadowing", shadowing, "0 (none), 1 (attenuated), 2 (thinned) or 3 (discs)");
  }
  const double flakes = flakes_per_m2(scene.paint) * scene.footprint * pixels;
  if (flakes > kMostSteps) {
    reject("number of flakes in all pixels", flakes, "at most " + text(kMostSteps));
  }
  const ViewAndLight beams(scene);
  if (!beams.seen) return;
  const double near = flakes_on_both_ways(scene, beams);
  if (near > kMostNear) {
    reject("number of flakes near a sparkle's way to the surface", near,
           "at most " + text(kMostNear) + " with the shadowing of discs");
  }
  const double each = most_steps_of_a_flake(scene, beams, near);
  require_steps("number of flakes in all pixels x " + text(each, 3) + " steps", flakes * each);
}

ExplicitResult trace_explicit_flakes(const ExplicitScene& scene, const std::stop_token& stop) {
  validate(scene);
  return Tracer(scene, stop).trace();
}

}  // namespace metallic_paint::reference
