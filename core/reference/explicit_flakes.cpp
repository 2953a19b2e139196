// SPDX-License-Identifier: Apache-2.0
#include "explicit_flakes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>

#include "../batch.h"

namespace metallic_paint::reference {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kGoldenAngle = 2 * kPi * (1 - 1 / std::numbers::phi);

using Vector = Vec3<double>;
using Colour = Rgb<double>;

constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15u;  // 2^64/phi, odd: Weyl's sequence

std::uint64_t mixed(std::uint64_t word) {
  word = (word ^ (word >> 30)) * 0xbf58476d1ce4e5b9u;
  word = (word ^ (word >> 27)) * 0x94d049bb133111ebu;
  return word ^ (word >> 31);
}

// Box and Muller; at most sqrt(2 log 2^53) in size.
constexpr double kLargestDeviate = 8.6;
double normal_deviate(Stream& random) {
  const double radius = std::sqrt(-2 * std::log(random.uniform()));
  return radius * std::cos(2 * kPi * random.uniform());
}

// E[max(0, 1 + s w)] = Phi(1/s) + s phi(1/s).
double mean_relative_area(double s) {
  if (s == 0) return 1;
  return std::erfc(-1 / (s * std::numbers::sqrt2)) / 2 +
         s * std::exp(-0.5 / (s * s)) / std::sqrt(2 * kPi);
}

// Two vectors that stand on a unit vector and on each other.
struct Frame {
  Vector a, b;
};
Frame frame_of(Vector n) {
  const Vector far = std::abs(n.x) < 0.6 ? Vector{1, 0, 0} : Vector{0, 1, 0};
  Vector a = far - n * dot(n, far);
  a = a / length(a);
  return {a, {n.y * a.z - n.z * a.y, n.z * a.x - n.x * a.z, n.x * a.y - n.y * a.x}};
}

// Point i of a golden-angle spiral over the unit disc, turned and shifted at random so that each is
// uniform in its ring of equal area: means over the disc come out without bias.
class Spiral {
 public:
  Spiral(int points, Stream& random)
      : points_(points), shift_(random.uniform()), turn_(2 * kPi * random.uniform()) {}
  double area_within(int i) const { return (i + shift_) / points_; }  // relative
  double angle(int i) const { return turn_ + kGoldenAngle * i; }

 private:
  double points_, shift_, turn_;
};

// ---------------------------------------------------------------------------------------------
// The surface of the binder.

double square(double x) { return x * x; }
double horizontal_square(Vector d) { return d.x * d.x + d.y * d.y; }

// Snell: the horizontal part of a direction shrinks by `ratio`; false under total reflection.
bool refract(Vector from, double ratio, Vector& to) {
  to = {from.x * ratio, from.y * ratio, 0};
  const double sine2 = horizontal_square(to);
  if (!(from.z > 0) || sine2 >= 1) return false;
  to.z = std::sqrt(1 - sine2);
  return true;
}

// 1 - r of unpolarised light (Fresnel), for the cosines outside and inside.
double surface_transmittance(double outside, double inside, double eta) {
  const double s = (outside - eta * inside) / (outside + eta * inside);
  const double p = (eta * outside - inside) / (eta * outside + inside);
  return 1 - (s * s + p * p) / 2;
}

// ---------------------------------------------------------------------------------------------
// The mean projected area of a flake of unit area, by the angle in the binder.

// P(beta), but for a factor.
double relative_density(Orientation orientation, double tilt, double beta) {
  if (orientation == Orientation::gaussian) return std::exp(-0.5 * square(beta / tilt));
  const double c2 = square(std::cos(beta)), s2 = square(std::sin(beta));
  if (orientation == Orientation::beckmann) {
    return c2 > 1e-12 ? std::exp(-s2 / (c2 * tilt * tilt)) / (c2 * c2) : 0;
  }
  return 1 / square(tilt * tilt * c2 + s2);
}

// <|v . n_f|>. The mean of |a + b cos(phi)| over the azimuth is |a| if a >= b, otherwise (2/pi)
// (sqrt(b^2 - a^2) + a asin(a/b)). Simpson's rule over beta = tilt sinh(x), for peak and tail.
double mean_projected_area(const Paint& paint, double theta) {
  constexpr int kSteps = 1024;
  const double last = std::asinh(kPi / 2 / paint.tilt);
  double sum = 0, norm = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = last * i / kSteps;
    const double beta = std::min(paint.tilt * std::sinh(x), kPi / 2);
    const double a = std::cos(theta) * std::cos(beta), b = std::sin(theta) * std::sin(beta);
    const double mean =
        a >= b ? a : 2 / kPi * (std::sqrt((b - a) * (b + a)) + a * std::asin(a / b));
    const double weight = (i == 0 || i == kSteps ? 1
                           : i % 2 == 1          ? 4
                                                 : 2) *
                          std::cosh(x) * std::sin(beta) *
                          relative_density(paint.orientation, paint.tilt, beta);
    sum += weight * mean;
    norm += weight;
  }
  return sum / norm;
}

// Tabulated over the angles in the binder under which the light can be seen.
class ProjectedArea {
 public:
  ProjectedArea(const Paint& paint, double from, double to) : from_(from) {
    step_ = std::max(to - from, 1e-6) / kIntervals;
    for (int i = 0; i <= kIntervals; ++i) {
      value_[static_cast<std::size_t>(i)] = mean_projected_area(paint, from_ + step_ * i);
    }
  }
  double at(double theta) const {
    const double position = std::clamp((theta - from_) / step_, 0.0, double{kIntervals});
    const auto i = std::min(static_cast<std::size_t>(position), std::size_t{kIntervals - 1});
    return value_[i] + (position - static_cast<double>(i)) * (value_[i + 1] - value_[i]);
  }

 private:
  static constexpr int kIntervals = 64;
  double from_, step_;
  std::array<double, kIntervals + 1> value_;
};

// ---------------------------------------------------------------------------------------------
// The plane of flakes. It is cut into square cells whose flakes are made from a hash of the cell
// whenever they are needed. A tile is the work of one thread at a time: one pixel of many cells, or
// one cell of many pixels.

constexpr double kFlakesPerCell = 4;     // up to four times as many
constexpr double kMostPerSide = 0x1p26;  // pixels of a cell

struct Cell {
  std::int64_t x, y;
};

struct Flake {
  Vector position;  // from the corner of its cell
  double depth;     // of its centre, 0 to 1 of the layer
  Vector normal;
  Stream rest;  // its area first, then whatever its tracing needs
};

// A scene as the tracing needs it, SI.
struct Plane {
  explicit Plane(const ExplicitScene& scene);

  const ExplicitScene& scene;
  double thickness;
  double disc_area, largest_radius;  // of the mean deviate; of any flake
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
  double reach2 = 4;              // no farther from light_in does a flake meet it, chord
  Colour binder_depth{};          // of the whole layer, straight down
  Colour blocking{};              // D H <S> (1 - t)
};

double flake_area(const Plane& plane, Stream& random) {
  return plane.disc_area *
         std::max(0.0, 1 + plane.scene.paint.flake_area_spread * normal_deviate(random));
}

Plane::Plane(const ExplicitScene& given) : scene(given) {
  const Paint& paint = scene.paint;
  const double density = paint.flakes_per_mm2 * 1e6;  // per m2
  thickness = paint.layer_thickness_um * 1e-6;
  disc_area = kPi / 4 * square(paint.flake_diameter_um * 1e-6);
  largest_radius = std::sqrt(disc_area * (1 + paint.flake_area_spread * kLargestDeviate) / kPi);

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
  seen = light.z > 0 && refract(view, 1 / eta, view_in);
  if (seen) view_transmittance = surface_transmittance(view.z, view_in.z, eta);
  light_chord2 = square(2 * std::sin(scene.light_radius / 2));
  light_solid_angle = kPi * light_chord2;  // 4 pi sin^2(radius/2)
  // Refraction into a denser binder brings directions closer together.
  if (eta >= 1 && refract(light, 1 / eta, light_in)) {
    reach2 = square(paint.flake_spread + std::sqrt(light_chord2)) * (1 + 1e-9);
  }
  const double scattering = 16 * kPi / 3 * paint.rayleigh_per_mm;
  binder_depth = map(paint.binder_absorption_per_mm,
                     [&](double kappa) { return (kappa + scattering) * 1e3 * thickness; });
  const double coverage = density * disc_area * mean_relative_area(paint.flake_area_spread);
  blocking = map(paint.flake_transmission, [&](double t) { return coverage * (1 - t); });
}

Stream stream_of(const Plane& plane, Cell cell) {
  std::uint64_t word = mixed(plane.scene.seed + kGolden);
  word = mixed((word ^ static_cast<std::uint64_t>(cell.x)) + kGolden);
  return {mixed((word ^ static_cast<std::uint64_t>(cell.y)) + kGolden)};
}

Flake make_flake(const Plane& plane, Stream cell, std::uint64_t index) {
  Stream random{mixed(cell.state ^ (kGolden * (index + 1)))};
  Flake flake;
  flake.position.x = plane.cell * random.uniform();
  flake.position.y = plane.cell * random.uniform();
  flake.depth = random.uniform();
  flake.position.z = -plane.thickness * flake.depth;
  const Tilt tilt = sample_tilt(plane.scene.paint.orientation, plane.scene.paint.tilt, random);
  const double azimuth = 2 * kPi * random.uniform();
  flake.normal = {tilt.sine * std::cos(azimuth), tilt.sine * std::sin(azimuth), tilt.cosine};
  flake.rest = random;
  return flake;
}

// Calls visit(flake, index) for each flake of a cell. Their number: as many uniform deviates as can
// be multiplied before the product falls below exp(-mean) (Knuth).
template <class Visit>
void visit_cell(const Plane& plane, Cell cell, const Visit& visit) {
  const Stream key = stream_of(plane, cell);
  Stream random = key;
  std::uint64_t index = 0;
  for (double product = random.uniform(); product > plane.no_flake; product *= random.uniform()) {
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
LightMet meet_light(const Plane& plane, Vector mirrored, Stream& random) {
  const double eta = plane.scene.paint.binder_ior;
  const double spread = plane.scene.paint.flake_spread;
  LightMet met;
  if (spread == 0) {
    // The light's own radiance, 1/Omega.
    Vector out;
    if (!refract(mirrored, eta, out)) return met;
    const Vector off = out - plane.light;
    if (dot(off, off) > plane.light_chord2) return met;
    met.received = surface_transmittance(out.z, mirrored.z, eta) / plane.light_solid_angle;
    met.towards = mirrored;
    return met;
  }
  // The integral of 1/Omega over those directions of the light within the flake's own disc, divided
  // by its solid angle pi spread^2; d omega inside/outside = cos/(eta^2 cos_p). A cap of that solid
  // angle holds what is within a chord of `spread`.
  const Vector off = mirrored - plane.light_in;
  if (dot(off, off) > plane.reach2) return met;
  const Frame frame = frame_of(plane.light);
  const int points = plane.light_chord2 > 0 ? plane.scene.points : 1;
  const Spiral spiral(points, random);
  for (int i = 0; i < points; ++i) {
    const double x = spiral.area_within(i) * plane.light_chord2 / 2;  // 1 - cos
    const double radius = std::sqrt(x * (2 - x)), angle = spiral.angle(i);
    const Vector point = plane.light * (1 - x) + frame.a * (radius * std::cos(angle)) +
                         frame.b * (radius * std::sin(angle));
    Vector in;
    if (!refract(point, 1 / eta, in)) continue;
    const Vector away = in - mirrored;
    if (dot(away, away) > spread * spread) continue;
    met.received += surface_transmittance(point.z, in.z, eta) * point.z / (eta * eta * in.z) /
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
  const double limit = 1e3 * (plane.thickness + plane.largest_radius);
  const double sideways = std::sqrt(horizontal_square(direction));
  double full = deepest / direction.z;
  if (sideways * full > limit) full = limit / sideways;
  const double margin = radius + plane.largest_radius;
  const Colour transmission = plane.scene.paint.flake_transmission;
  visit_along(plane, home, own.position, direction * full, margin,
              [&](const Flake& other, std::uint64_t index, bool at_home) {
                if (at_home && index == own_index) return;
                Stream rest = other.rest;
                const double radius2 = flake_area(plane, rest) / kPi;
                // Too far from the middle of the beam, whatever the disc's tilt.
                const Vector between = other.position - own.position;
                const double along = std::clamp(dot(between, direction), 0.0, full);
                const Vector off = between - direction * along;
                if (dot(off, off) > square(std::sqrt(radius2) + radius)) return;
                const double slope = dot(other.normal, direction);
                if (slope == 0) return;
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
                     double area, Vector towards_light, Stream& random) {
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
  double flakes = 0, sparkles = 0;
  Colour share{}, square_share{};
};

struct MeanDepth {
  double view;  // <s>/cos
  ProjectedArea light;
};

// The angle in the binder of the light's nearest or farthest edge.
double edge_angle(const Plane& plane, double theta) {
  const double sine = std::sin(std::clamp(theta, 0.0, kPi / 2)) / plane.scene.paint.binder_ior;
  return std::asin(std::min(sine, 1.0));
}

MeanDepth mean_depth(const Plane& plane) {
  const Paint& paint = plane.scene.paint;
  const double theta = std::acos(std::min(plane.light.z, 1.0)), radius = plane.scene.light_radius;
  return {mean_projected_area(paint, std::acos(std::min(plane.view_in.z, 1.0))) / plane.view_in.z,
          {paint, edge_angle(plane, theta - radius), edge_angle(plane, theta + radius)}};
}

void trace_tile(const Plane& plane, const MeanDepth& mean, std::int64_t tile,
                ExplicitResult& result, Sums& sums) {
  const ExplicitScene& scene = plane.scene;
  const Paint& paint = scene.paint;
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
    Stream random{mixed(flake.rest.state)};
    const LightMet met = meet_light(plane, mirrored, random);
    if (!(met.received > 0)) return;

    const double area = flake_area(plane, flake.rest);
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
      const double angle = std::acos(std::min(met.towards.z, 1.0));
      const double projected = mean.view + mean.light.at(angle) / met.towards.z;
      share = dimmed(plane.blocking * projected + absorbed);
      binder = {1, 1, 1};
      if (scene.shadowing == Shadowing::thinned) {
        const double most = max_component(share);
        if (random.uniform() >= most) return;
        share = share / most;
      }
    }
    // Schlick's coating; the flake covers S cos(alpha)/(cos(theta_p) Sigma) of the pixel.
    const double cos_alpha = std::min(std::abs(facing), 1.0);
    const double edge = std::pow(1 - cos_alpha, 5);
    const Colour coating = paint.flake_color * (1 - edge) + paint.flake_edge_color * edge;
    const double unit = plane.view_transmittance * met.received * area * cos_alpha /
                        (plane.view_in.z * scene.footprint);
    result.count[pixel] += 1;
    result.radiance[pixel] = result.radiance[pixel] + coating * share * binder * unit;
    sums.sparkles += 1;
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

void require(bool holds, const std::string& field, double value, const std::string& range) {
  if (holds) return;
  std::ostringstream sentence;
  sentence.precision(9);
  sentence << field << " is " << value << ", but must be " << range;
  throw std::invalid_argument(sentence.str());
}

}  // namespace

std::uint64_t Stream::next() { return mixed(state += kGolden); }

double Stream::uniform() { return (static_cast<double>(next() >> 12) + 0.5) * 0x1p-52; }

Tilt sample_tilt(Orientation orientation, double tilt, Stream& random) {
  if (orientation == Orientation::gaussian) {
    // exp(-b^2/2s^2) sin(b): of deviates of exp(-b^2/2s^2) b below 90 degrees, sin(b)/b.
    const double below = -std::expm1(-0.5 * square(kPi / 2 / tilt));
    for (;;) {
      const double beta = tilt * std::sqrt(-2 * std::log1p(-below * random.uniform()));
      const double sine = std::sin(beta);
      if (random.uniform() * beta < sine) return {sine, std::max(std::cos(beta), 0.0)};
    }
  }
  if (orientation == Orientation::beckmann) {
    // In t = tan^2(beta): exp(-t/a^2) sqrt(1 + t) = exp(-t (1/a^2 - 1/2)) [exp(-t/2) sqrt(1 + t)].
    const double rate = 1 / (tilt * tilt) - 0.5;
    for (;;) {
      const double t = -std::log(random.uniform()) / rate;
      if (random.uniform() > std::exp(-0.5 * t) * std::sqrt(1 + t)) continue;
      return {std::sqrt(t / (1 + t)), 1 / std::sqrt(1 + t)};
    }
  }
  // In x = 1 - cos(beta): 1/(a^2 + w x(2 - x))^2, w = 1 - a^2, under 1/(a^2 + w x)^2, whose
  // integral is x/(a^2 (a^2 + w x)).
  const double a2 = tilt * tilt, w = (1 - tilt) * (1 + tilt);
  for (;;) {
    const double u = random.uniform();
    const double x = u * a2 / (1 - u * w);
    const double ratio = (a2 + w * x) / (a2 + w * x * (2 - x));
    if (random.uniform() < ratio * ratio) return {std::sqrt(x * (2 - x)), 1 - x};
  }
}

void validate(const ExplicitScene& scene) {
  metallic_paint::validate(scene.paint);
  const auto require_unit = [](const std::string& field, Vector v) {
    const double size = length(v);
    require(std::abs(size - 1) < 1e-3, "length of " + field, size, "1 to a thousandth");
  };
  require_unit("view", scene.view);
  require_unit("light", scene.light);
  const double radius = scene.light_radius;
  require(radius >= 0 && radius <= kPi / 2, "light_radius", radius, "from 0 to pi/2 rad");
  const double width = radius + scene.paint.flake_spread;
  require(width > 0, "light_radius + flake_spread", width, "above 0 rad");
  require(scene.footprint >= 1e-20 && scene.footprint <= 1e6, "footprint", scene.footprint,
          "from 1e-20 to 1e6 m2");
  const auto pixels = static_cast<double>(scene.pixels);
  require(pixels >= 1 && pixels <= 0x1p26, "pixels", pixels, "from 1 to 2^26");
  require(scene.points >= 1 && scene.points <= 65536, "points", scene.points, "from 1 to 65536");
  const auto shadowing = static_cast<int>(scene.shadowing);
  require(shadowing >= 0 && shadowing <= 3, "shadowing", shadowing,
          "0 (none), 1 (attenuated), 2 (thinned) or 3 (discs)");
  const double density = scene.paint.flakes_per_mm2 * 1e6;
  const double flakes = density * scene.footprint * pixels;
  require(flakes <= 1e12, "number of flakes in all pixels", flakes, "at most 1e12");
  if (scene.shadowing != Shadowing::discs) return;
  const Plane plane(scene);
  const double beam =
      plane.seen ? plane.thickness * std::sqrt(horizontal_square(plane.view_in)) / plane.view_in.z
                 : 0;
  const double near = density * 4 * plane.largest_radius * (beam + 4 * plane.largest_radius);
  require(near <= 1e8, "number of flakes near a sparkle's way to the surface", near,
          "at most 1e8 with the shadowing of discs");
}

ExplicitResult trace_explicit_flakes(const ExplicitScene& scene) {
  validate(scene);
  ExplicitResult result;
  result.count.resize(scene.pixels);
  result.radiance.resize(scene.pixels);
  const Plane plane(scene);
  if (!plane.seen) return result;
  const MeanDepth mean = mean_depth(plane);
  std::vector<Sums> sums(static_cast<std::size_t>(plane.tiles));
  parallel_for(
      sums.size(),
      [&](std::size_t tile) {
        trace_tile(plane, mean, static_cast<std::int64_t>(tile), result, sums[tile]);
      },
      1);
  Sums all;
  for (const Sums& tile : sums) {
    all.flakes += tile.flakes;
    all.sparkles += tile.sparkles;
    all.share = all.share + tile.share;
    all.square_share = all.square_share + tile.square_share;
  }
  result.flakes = all.flakes;
  if (all.sparkles > 0) {
    result.mean_share = all.share / all.sparkles;
    result.mean_square_share = all.square_share / all.sparkles;
  }
  return result;
}

}  // namespace metallic_paint::reference
