// SPDX-License-Identifier: Apache-2.0
#include "explicit_flakes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "../parallel.h"
#include "../validation.h"
#include "optics.h"
#include "population.h"
#include "random.h"

namespace metallic_paint::reference {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kGoldenAngle = 2 * kPi * (1 - 1 / std::numbers::phi);

using Vector = Vec3<double>;
using Colour = Rgb<double>;

// Box and Muller; at most sqrt(2 log 2^53) in size.
constexpr double kLargestDeviate = 8.6;
double normal_deviate(RandomStream& random) {
  const double radius = std::sqrt(-2 * std::log(random()));
  return radius * std::cos(2 * kPi * random());
}

// Point i of a golden-angle spiral over the unit disc, turned and shifted at random so that each is
// uniform in its ring of equal area: means over the disc come out without bias.
class Spiral {
 public:
  Spiral(int points, RandomStream& random)
      : points_(points), shift_(random()), turn_(2 * kPi * random()) {}
  double area_within(int i) const { return (i + shift_) / points_; }  // relative
  double angle(int i) const { return turn_ + kGoldenAngle * i; }

 private:
  double points_, shift_, turn_;
};

double square(double x) { return x * x; }
double horizontal_square(Vector d) { return d.x * d.x + d.y * d.y; }

// ---------------------------------------------------------------------------------------------
// The plane of flakes. It is cut into square cells whose flakes are made from a hash of the cell
// whenever they are needed. A tile is the work of one thread at a time: one pixel of many cells, or
// one cell of many pixels.

constexpr double kFlakesPerCell = 4;     // up to four times as many
constexpr double kMostPerSide = 0x1p26;  // pixels of a cell
constexpr int kCosineSteps = 32;         // over the light

struct Cell {
  std::int64_t x, y;
};

struct Species;

struct Flake {
  const Species* species;
  Vector position;  // from the corner of its cell
  double depth;     // of its centre, 0 to 1 of the layer
  Vector normal;
  RandomStream rest;  // its area first, then whatever its tracing needs
};

// Of the mean deviate, m2.
double disc_area(const FlakeSpecies& flakes) {
  return kPi / 4 * square(flakes.flake_diameter_um * 1e-6);
}

// Of any of these flakes, m.
double largest_radius(const FlakeSpecies& flakes) {
  return std::sqrt(disc_area(flakes) * (1 + flakes.flake_area_spread * kLargestDeviate) / kPi);
}

// Flakes of a species, SI.
struct Species : Population {
  explicit Species(const Population& some) : Population(some), area(disc_area(flakes)) {}

  double area;        // of the mean deviate
  double up_to = 0;   // density of the flakes of this species and those before it, 1/m2
  double reach2 = 4;  // no farther from light_in does a flake meet it, chord
  // Mean transmittance towards the observer, and towards the light at even steps of the cosine;
  // only where it depends on the angle.
  Colour passed_to_view{};
  std::vector<Colour> passed_to_light{};
};

// A scene as the tracing needs it, SI.
struct Plane {
  explicit Plane(const ExplicitScene& scene);

  const ExplicitScene& scene;
  std::vector<Species> species{};
  double thickness;
  double widest_radius = 0;          // of any flake
  double pixel, cell;                // sides
  std::int64_t cells_per_side = 1;   // of a tile
  std::int64_t pixels_per_side = 1;  // of a tile
  std::int64_t tiles, columns;
  double no_flake;                // probability of an empty cell
  Vector view{}, light{};         // unit, outside
  Vector view_in{}, light_in{};   // in the binder
  bool seen = false;              // whether the observer sees into the binder
  double view_transmittance = 0;  // of the surface
  double light_chord2;            // square of the chord of the light's radius
  double light_solid_angle;       // outside
  double least_cosine;            // of the light in the binder
  double most_cosine;
  Colour binder_depth{};  // of the whole layer, straight down
};

double flake_area(const Species& species, RandomStream& random) {
  return species.area *
         std::max(0.0, 1 + species.flakes.flake_area_spread * normal_deviate(random));
}

double flakes_per_m2(const Paint& paint) {
  double sum = 0;
  for (int i = 0; i < kSpecies; ++i) sum += paint.species(i).flakes_per_mm2;
  return sum * 1e6;
}

Plane::Plane(const ExplicitScene& given) : scene(given) {
  const Paint& paint = scene.paint;
  const double density = flakes_per_m2(paint);
  thickness = paint.layer_thickness_um * 1e-6;
  double so_far = 0;
  for (const Population& some : populations(paint)) {
    species.emplace_back(some);
    widest_radius = std::max(widest_radius, largest_radius(some.flakes));
    so_far += some.flakes.flakes_per_mm2 * 1e6;
    species.back().up_to = so_far;
  }

  pixel = std::sqrt(scene.footprint);
  // Cells along a pixel, or pixels along a cell.
  const double ratio = std::sqrt(density * scene.footprint / kFlakesPerCell);
  if (ratio >= 1) {
    cells_per_side = static_cast<std::int64_t>(ratio);
  } else {
    pixels_per_side = static_cast<std::int64_t>(std::ceil(1 / std::max(ratio, 1 / kMostPerSide)));
  }
  cell = pixel * static_cast<double>(pixels_per_side) / static_cast<double>(cells_per_side);
  no_flake = std::exp(-density * square(cell));
  const auto pixels = static_cast<std::int64_t>(scene.pixels);
  const std::int64_t in_tile = pixels_per_side * pixels_per_side;
  tiles = (pixels + in_tile - 1) / in_tile;
  columns = static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(tiles))));

  const double eta = paint.binder_ior;
  view = scene.view / length(scene.view);
  light = scene.light / length(scene.light);
  view_in = refracted(view, eta);
  seen = light.z > 0 && view_in.z > 0;
  view_transmittance = 1 - fresnel_reflectance(view.z, view_in.z, eta);
  light_chord2 = square(2 * std::sin(scene.light_radius / 2));
  light_solid_angle = kPi * light_chord2;  // 4 pi sin^2(radius/2)
  // Refraction into a denser binder brings directions closer together.
  light_in = refracted(light, eta);
  if (eta >= 1 && light_in.z > 0) {
    for (Species& some : species) {
      some.reach2 = square(some.spread + std::sqrt(light_chord2)) * (1 + 1e-9);
    }
  }
  binder_depth = absorption_depth(paint) + grey(rayleigh_depth(paint));

  const double angle = std::acos(std::min(light.z, 1.0));
  const double from = std::min(angle + scene.light_radius, kPi / 2);
  least_cosine = refracted_cosine(std::cos(from), eta);
  most_cosine = refracted_cosine(std::cos(std::max(angle - scene.light_radius, 0.0)), eta);
  const bool by_depth =
      scene.shadowing == Shadowing::attenuated || scene.shadowing == Shadowing::thinned;
  if (!by_depth || !seen) return;
  for (Species& some : species) {
    if (!transmits_by_angle(some.flakes)) continue;
    some.passed_to_view = some.mean_transmittance(view_in.z);
    for (int i = 0; i <= kCosineSteps; ++i) {
      some.passed_to_light.push_back(
          some.mean_transmittance(least_cosine + (most_cosine - least_cosine) * i / kCosineSteps));
    }
  }
}

// Optical depth of the whole layer by its flakes, to the observer and to the light.
Colour flake_depth(const Plane& plane, double cos_light) {
  Colour sum{};
  for (const Species& some : plane.species) {
    const double to_view = some.projected_area.at(plane.view_in.z) / plane.view_in.z;
    const double to_light = some.projected_area.at(cos_light) / cos_light;
    if (some.passed_to_light.empty()) {
      sum = sum + (grey(1.0) - flake_transmittance(some.flakes, 1)) * some.coverage *
                      (to_view + to_light);
      continue;
    }
    const double width = std::max(plane.most_cosine - plane.least_cosine, 1e-12);
    const double place =
        std::clamp((cos_light - plane.least_cosine) / width, 0.0, 1.0) * kCosineSteps;
    const int below = std::min(static_cast<int>(place), kCosineSteps - 1);
    const Colour* node = &some.passed_to_light[static_cast<std::size_t>(below)];
    const Colour passed = node[0] + (node[1] - node[0]) * (place - below);
    sum = sum + ((grey(1.0) - some.passed_to_view) * to_view + (grey(1.0) - passed) * to_light) *
                    some.coverage;
  }
  return sum;
}

RandomStream stream_of(const Plane& plane, Cell cell) {
  return RandomStream(plane.scene.seed)
      .substream(static_cast<std::uint64_t>(cell.x))
      .substream(static_cast<std::uint64_t>(cell.y));
}

Flake make_flake(const Plane& plane, const RandomStream& cell, std::uint64_t index) {
  RandomStream random = cell.substream(index);
  const Species* species = plane.species.data();
  if (plane.species.size() > 1) {
    const double pick = random() * plane.species.back().up_to;
    while (species != &plane.species.back() && pick >= species->up_to) ++species;
  }
  const double x = random(), y = random(), depth = random();
  const Vector position{plane.cell * x, plane.cell * y, -plane.thickness * depth};
  const Vector normal = species->normals.sample(random);
  return {species, position, depth, normal, random};
}

// Calls visit(flake, index) for each flake of a cell. Their number: as many uniform deviates as can
// be multiplied before the product falls below exp(-mean) (Knuth).
template <class Visit>
void visit_cell(const Plane& plane, Cell cell, const Visit& visit) {
  const RandomStream key = stream_of(plane, cell);
  RandomStream random = key;
  std::uint64_t index = 0;
  for (double product = random(); product > plane.no_flake; product *= random()) {
    visit(make_flake(plane, key, index), index);
    ++index;
  }
}

// ---------------------------------------------------------------------------------------------
// One flake.

struct LightMet {
  double received = 0;  // per unit irradiance normal to the light and sr, through the surface
  Vector towards{};     // the light in the binder
};

// What a flake without losses would show that mirrors the observer's ray into `mirrored`.
LightMet meet_light(const Plane& plane, const Species& species, Vector mirrored,
                    RandomStream& random) {
  const double eta = plane.scene.paint.binder_ior;
  const double spread = species.spread;
  LightMet met;
  if (spread == 0) {
    // The light's own radiance, 1/Omega.
    const Vector out = refracted(mirrored, 1 / eta);
    if (out.z == 0) return met;
    const Vector off = out - plane.light;
    if (dot(off, off) > plane.light_chord2) return met;
    met.received = (1 - fresnel_reflectance(out.z, mirrored.z, eta)) / plane.light_solid_angle;
    met.towards = mirrored;
    return met;
  }
  // The integral of 1/Omega over those directions of the light within the flake's own disc, divided
  // by its solid angle pi spread^2; d omega inside/outside = cos/(eta^2 cos_p). A cap of that solid
  // angle holds what is within a chord of `spread`.
  const Vector off = mirrored - plane.light_in;
  if (dot(off, off) > species.reach2) return met;
  const Frame frame = frame_of(plane.light);
  const int points = plane.light_chord2 > 0 ? plane.scene.points : 1;
  const Spiral spiral(points, random);
  for (int i = 0; i < points; ++i) {
    const double x = spiral.area_within(i) * plane.light_chord2 / 2;  // 1 - cos
    const double radius = std::sqrt(x * (2 - x)), angle = spiral.angle(i);
    const Vector point = plane.light * (1 - x) + frame.a * (radius * std::cos(angle)) +
                         frame.b * (radius * std::sin(angle));
    const Vector in = refracted(point, eta);
    if (in.z == 0) continue;
    const Vector away = in - mirrored;
    if (dot(away, away) > spread * spread) continue;
    met.received += (1 - fresnel_reflectance(point.z, in.z, eta)) * point.z / (eta * eta * in.z) /
                    (kPi * spread * spread * points);
    met.towards = met.towards + in;
  }
  if (met.received > 0) met.towards = met.towards / length(met.towards);
  return met;
}

// Calls visit(flake, index, at home) for all flakes centred within `margin` of the segment, seen
// from above. Positions count from the corner of the cell `home`.
template <class Visit>
void visit_along(const Plane& plane, Cell home, Vector from, Vector way, double margin,
                 const Visit& visit) {
  const auto cell_at = [&](double x) {
    return static_cast<std::int64_t>(std::floor(x / plane.cell));
  };
  const std::int64_t last = cell_at(std::max(from.y, from.y + way.y) + margin);
  for (std::int64_t row = cell_at(std::min(from.y, from.y + way.y) - margin); row <= last; ++row) {
    // The part of the segment within `margin` of this row.
    double begin = 0, end = 1;
    if (way.y != 0) {
      const double low = (static_cast<double>(row) * plane.cell - margin - from.y) / way.y;
      const double high = (static_cast<double>(row + 1) * plane.cell + margin - from.y) / way.y;
      begin = std::clamp(std::min(low, high), 0.0, 1.0);
      end = std::clamp(std::max(low, high), 0.0, 1.0);
    }
    const double x0 = from.x + way.x * begin, x1 = from.x + way.x * end;
    const std::int64_t right = cell_at(std::max(x0, x1) + margin);
    for (std::int64_t column = cell_at(std::min(x0, x1) - margin); column <= right; ++column) {
      const Vector corner{static_cast<double>(column) * plane.cell,
                          static_cast<double>(row) * plane.cell, 0};
      visit_cell(plane, {home.x + column, home.y + row}, [&](Flake flake, std::uint64_t index) {
        flake.position = flake.position + corner;
        visit(flake, index, column == 0 && row == 0);
      });
    }
  }
}

struct DiscPoint {
  Vector position;
  Colour visible;
};

// Dims each point of a flake by the discs between it and the surface along `direction`. A way is
// followed sideways for a thousand layers at most.
void shadow(const Plane& plane, Cell home, std::uint64_t own_index, const Flake& own, double radius,
            Vector direction, std::vector<DiscPoint>& points) {
  const double deepest = -own.position.z + radius;
  const double limit = 1e3 * (plane.thickness + plane.widest_radius);
  const double sideways = std::sqrt(horizontal_square(direction));
  double full = deepest / direction.z;
  if (sideways * full > limit) full = limit / sideways;
  const double margin = radius + plane.widest_radius;
  visit_along(plane, home, own.position, direction * full, margin,
              [&](const Flake& other, std::uint64_t index, bool at_home) {
                if (at_home && index == own_index) return;
                RandomStream rest = other.rest;
                const double radius2 = flake_area(*other.species, rest) / kPi;
                // Too far from the middle of the beam, whatever the disc's tilt.
                const Vector between = other.position - own.position;
                const double along = std::clamp(dot(between, direction), 0.0, full);
                const Vector off = between - direction * along;
                if (dot(off, off) > square(std::sqrt(radius2) + radius)) return;
                const double slope = dot(other.normal, direction);
                if (slope == 0) return;
                const Colour transmission =
                    flake_transmittance(other.species->flakes, std::abs(slope));
                for (DiscPoint& point : points) {
                  const Vector to_centre = other.position - point.position;
                  const double distance = dot(other.normal, to_centre) / slope;
                  if (!(distance > 0 && point.position.z + distance * direction.z < 0)) continue;
                  const Vector miss = to_centre - direction * distance;
                  if (dot(miss, miss) <= radius2) point.visible = point.visible * transmission;
                }
              });
}

// The part of a flake that is seen and lit, averaged over points of its disc.
Colour visible_share(const Plane& plane, Cell home, std::uint64_t index, const Flake& flake,
                     double area, Vector towards_light, RandomStream& random) {
  const double radius = std::sqrt(area / kPi);
  const Frame frame = frame_of(flake.normal);
  const Spiral spiral(plane.scene.points, random);
  std::vector<DiscPoint> points;
  for (int i = 0; i < plane.scene.points; ++i) {
    const double r = radius * std::sqrt(spiral.area_within(i)), angle = spiral.angle(i);
    points.push_back(
        {flake.position + frame.a * (r * std::cos(angle)) + frame.b * (r * std::sin(angle)),
         {1, 1, 1}});
  }
  shadow(plane, home, index, flake, radius, plane.view_in, points);
  shadow(plane, home, index, flake, radius, towards_light, points);
  Colour sum{};
  for (const DiscPoint& point : points) sum = sum + point.visible;
  return sum / static_cast<double>(plane.scene.points);
}

// ---------------------------------------------------------------------------------------------
// All flakes.

struct Sums {
  double flakes = 0;
  std::array<double, kSpecies> sparkles{};
  Colour share{}, square_share{};
};

void trace_tile(const Plane& plane, std::int64_t tile, ExplicitResult& result, Sums& sums) {
  const ExplicitScene& scene = plane.scene;
  const auto first_pixel =
      static_cast<std::size_t>(tile * plane.pixels_per_side * plane.pixels_per_side);
  const auto trace = [&](Cell home, Flake flake, std::uint64_t index) {
    std::size_t pixel = first_pixel;
    if (plane.pixels_per_side > 1) {
      const auto place = [&](double x) {
        return std::min(static_cast<std::int64_t>(x / plane.pixel), plane.pixels_per_side - 1);
      };
      pixel += static_cast<std::size_t>(place(flake.position.y) * plane.pixels_per_side +
                                        place(flake.position.x));
      if (pixel >= scene.pixels) return;
    }
    sums.flakes += 1;
    const double facing = dot(flake.normal, plane.view_in);
    const Vector mirrored = flake.normal * (2 * facing) - plane.view_in;
    if (mirrored.z <= 0) return;
    RandomStream random = flake.rest.substream(0);
    const LightMet met = meet_light(plane, *flake.species, mirrored, random);
    if (!(met.received > 0)) return;

    const double area = flake_area(*flake.species, flake.rest);
    const double slant = 1 / plane.view_in.z + 1 / met.towards.z;
    const auto dimmed = [&](Colour depth) {
      return map(depth, [&](double x) { return std::exp(-flake.depth * x); });
    };
    const Colour absorbed = plane.binder_depth * slant;
    Colour share{1, 1, 1};  // without the binder's, for `none` and `discs`
    Colour binder = dimmed(absorbed);
    if (scene.shadowing == Shadowing::discs) {
      share = visible_share(plane, home, index, flake, area, met.towards, random);
    } else if (scene.shadowing != Shadowing::none) {
      share = dimmed(flake_depth(plane, met.towards.z) + absorbed);
      binder = {1, 1, 1};
      if (scene.shadowing == Shadowing::thinned) {
        const double most = max_component(share);
        if (random() >= most) return;
        share = share / most;
      }
    }
    // The flake covers S cos(alpha)/(cos(theta_p) Sigma) of the pixel.
    const double cos_alpha = std::abs(facing);
    const Colour coating = flake_reflectance(flake.species->flakes, cos_alpha);
    const double unit = plane.view_transmittance * met.received * area * cos_alpha /
                        (plane.view_in.z * scene.footprint);
    result.count[pixel] += 1;
    result.radiance[pixel] = result.radiance[pixel] + coating * share * binder * unit;
    sums.sparkles[flake.species->index] += 1;
    sums.share = sums.share + share;
    sums.square_share = sums.square_share + share * share;
  };
  const std::int64_t x = tile % plane.columns * plane.cells_per_side;
  const std::int64_t y = tile / plane.columns * plane.cells_per_side;
  for (std::int64_t row = 0; row < plane.cells_per_side; ++row) {
    for (std::int64_t column = 0; column < plane.cells_per_side; ++column) {
      const Cell cell{x + column, y + row};
      visit_cell(plane, cell,
                 [&](const Flake& flake, std::uint64_t index) { trace(cell, flake, index); });
    }
  }
}

}  // namespace

void validate(const ExplicitScene& scene) {
  metallic_paint::validate(scene.paint);
  require_unit("view", scene.view);
  require_unit("light", scene.light);
  require_range("light_radius", scene.light_radius, 0, kPi / 2, " rad");
  double widest = 0;
  for (int i = 0; i < kSpecies; ++i) {
    const FlakeSpecies& flakes = scene.paint.species(i);
    if (i > 0 && !(flakes.flakes_per_mm2 > 0)) continue;
    widest = std::max(widest, largest_radius(flakes));
    const double width = scene.light_radius + flake_spread(scene.paint, flakes);
    if (!(width > 0)) reject("light_radius + flake_spread", width, "above 0 rad for each species");
  }
  require_range("footprint", scene.footprint, 1e-20, 1e6, " m2");
  const auto pixels = static_cast<double>(scene.pixels);
  require_range("pixels", pixels, 1, 0x1p26);
  require_range("points", scene.points, 1, 65536);
  const auto shadowing = static_cast<int>(scene.shadowing);
  if (shadowing < 0 || shadowing > 3) {
    reject("shadowing", shadowing, "0 (none), 1 (attenuated), 2 (thinned) or 3 (discs)");
  }
  const double density = flakes_per_m2(scene.paint);
  const double flakes = density * scene.footprint * pixels;
  if (flakes > 1e12) reject("number of flakes in all pixels", flakes, "at most 1e12");
  if (scene.shadowing != Shadowing::discs) return;
  const Vector view_in = refracted(scene.view, scene.paint.binder_ior);
  const double beam = view_in.z > 0 ? scene.paint.layer_thickness_um * 1e-6 *
                                          std::sqrt(horizontal_square(view_in)) / view_in.z
                                    : 0;
  const double near = density * 4 * widest * (beam + 4 * widest);
  if (near > 1e8) {
    reject("number of flakes near a sparkle's way to the surface", near,
           "at most 1e8 with the shadowing of discs");
  }
}

ExplicitResult trace_explicit_flakes(const ExplicitScene& scene) {
  validate(scene);
  ExplicitResult result;
  result.count.resize(scene.pixels);
  result.radiance.resize(scene.pixels);
  const Plane plane(scene);
  if (!plane.seen) return result;
  std::vector<Sums> sums(static_cast<std::size_t>(plane.tiles));
  parallel_for(
      sums.size(),
      [&](std::size_t tile) {
        trace_tile(plane, static_cast<std::int64_t>(tile), result, sums[tile]);
      },
      1);
  Sums all;
  for (const Sums& tile : sums) {
    all.flakes += tile.flakes;
    for (std::size_t i = 0; i < kSpecies; ++i) all.sparkles[i] += tile.sparkles[i];
    all.share = all.share + tile.share;
    all.square_share = all.square_share + tile.square_share;
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

}  // namespace metallic_paint::reference
