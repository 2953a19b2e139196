// SPDX-License-Identifier: Apache-2.0
#include "disc_walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "../parallel.h"
#include "../validation.h"
#include "disc_layer.h"
#include "flake_plane.h"
#include "optics.h"
#include "photon.h"
#include "population.h"
#include "random_walk.h"
#include "work.h"

namespace metallic_paint::reference {
namespace {

constexpr double kPi = std::numbers::pi;
// A way that is flatter ends at surface or substrate as if it had this slope.
constexpr double kLeastSlope = 1e-6;
constexpr double kLeastFlakes = 2048, kMostFlakes = 1e7;

// Directions within an angle of a unit vector, outside.
struct Cone {
  Vec3<double> axis;
  double radius;

  // Evenly by solid angle.
  Vec3<double> sample(RandomStream& random) const {
    const double drop = 2 * square(std::sin(radius / 2)) * random();  // 1 - cosine
    const double sine = std::sqrt(drop * (2 - drop)), phi = 2 * kPi * random();
    const Frame frame = frame_of(axis);
    return axis * (1 - drop) + (frame.a * std::cos(phi) + frame.b * std::sin(phi)) * sine;
  }
  double solid_angle() const { return 4 * kPi * square(std::sin(radius / 2)); }
  // Integral of cos(theta) over a cone that lies above the horizon.
  double projected_solid_angle() const { return kPi * square(std::sin(radius)) * axis.z; }
};

struct Medium {
  std::vector<Species> flakes{};
  double thickness_um, rayleigh;
  Rgb<double> absorption;
  double eta, side;
  Cone light;
  std::vector<Cone> detectors{};

  explicit Medium(const DiscScene& scene);
};

// The side of the box. A species of no flakes has no part in it.
double box_side(const DiscScene& scene) {
  const double thickness_m = scene.paint.layer_thickness_um * 1e-6;
  double widest = 0;
  for (int i = 0; i < kSpecies; ++i) {
    const FlakeSpecies& flakes = scene.paint.species(i);
    if (flakes.flakes_per_mm2 > 0) widest = std::max(widest, 2 * largest_radius(flakes));
  }
  const double side = scene.box * std::max(1.0, widest / thickness_m);
  const double density = flakes_per_m2(scene.paint) * square(thickness_m);
  return density > 0 ? std::max(side, std::sqrt(kLeastFlakes / density)) : side;
}

Vec3<double> unit(Vec3<double> v) { return v / length(v); }

Medium::Medium(const DiscScene& scene)
    : thickness_um(scene.paint.layer_thickness_um),
      rayleigh(rayleigh_depth(scene.paint)),
      absorption(absorption_depth(scene.paint)),
      eta(scene.paint.binder_ior),
      side(box_side(scene)),
      light{unit(scene.light), scene.light_radius} {
  for (const Population& some : populations(scene.paint)) flakes.emplace_back(some);
  for (const Vec3<double>& o : scene.detectors) {
    detectors.push_back({unit(o), scene.detector_radius});
  }
}

struct Tally : PhotonTally {
  Rgb<double> specular{};
};

// The part of a way from `z` with this slope that lies in the layer itself, by its distances.
struct Stretch {
  double enter, leave;
  Stretch(double z, double slope, double end) {
    const double a = -z / slope, b = (-1 - z) / slope;
    enter = std::max(std::min(a, b), 0.0);
    leave = std::max(std::min(std::max(a, b), end), enter);
  }
  double until(double distance) const { return std::clamp(distance, enter, leave) - enter; }
};

class Walker : Photon<Tally> {
 public:
  Walker(const Medium& medium, const DiscScene& scene, std::size_t batch,
         const std::stop_token& stop)
      : Photon(RandomStream(scene.seed).substream(batch), medium.detectors.size()),
        medium_(medium),
        scene_(scene),
        stop_(stop),
        layer_(medium.flakes, medium.thickness_um, medium.side, random_.substream(0)) {}

  Tally walk(std::size_t photons) {
    tally_.photons = photons;
    for (std::size_t i = 0; i < photons && !stop_.stop_requested(); ++i) walk();
    return tally_;
  }

 private:
  // One photon, from outside.
  void walk() {
    // Of an evenly bright cone by the projected solid angle.
    Vec3<double> from = medium_.light.axis;
    if (medium_.light.radius > 0) {
      do from = medium_.light.sample(random_);
      while (random_() * std::min(medium_.light.axis.z + medium_.light.radius, 1.0) > from.z);
    }
    const Vec3<double> inside = refracted(from, medium_.eta);
    const double mirrored = fresnel_reflectance(from.z, inside.z, medium_.eta);
    tally_.specular = tally_.specular + grey(mirrored);
    if (inside.z == 0) return;
    begin(inside * -1.0, grey(1 - mirrored));
    position_ = {layer_.side * random_(), layer_.side * random_(), layer_.top};
    way_.clear();
    mirrors_.clear();
    place_ = position_;
    last_ = kNoDisc;
    ends(stop_, [this] { return step(); });
  }

  // How far it is to surface or substrate.
  double to_boundary(Vec3<double> from, Vec3<double> d) const {
    const double height = d.z > 0 ? layer_.top - from.z : from.z - layer_.bottom;
    return std::max(height, 0.0) / std::max(std::abs(d.z), kLeastSlope);
  }

  static Stretch in_layer(Vec3<double> from, Vec3<double> d, double end) {
    return {from.z, std::copysign(std::max(std::abs(d.z), kLeastSlope), d.z), end};
  }

  // To the next event; false where the photon ends.
  bool step() {
    const double end = to_boundary(position_, direction_);
    const Stretch stretch = in_layer(position_, direction_, end);
    double limit = end;
    if (medium_.rayleigh > 0) {
      const double free_path = -std::log1p(-random_()) / medium_.rayleigh;
      if (free_path < stretch.leave - stretch.enter) limit = stretch.enter + free_path;
    }
    const DiscLayer::Hit hit = layer_.first(position_, direction_, limit, last_);
    const double way = hit.disc != nullptr ? hit.distance : limit;
    if (scene_.joined) put_flake(stretch, way);
    way_.push_back({place_, direction_, way});
    place_ = place_ + direction_ * way;
    // Absorption by weight: free paths are the same for all colours.
    if (max_component(medium_.absorption) > 0) {
      const double path = stretch.until(way);
      keep(map(medium_.absorption, [&](double k) { return std::exp(-k * path); }));
    }
    position_ = layer_.wrapped(position_ + direction_ * way);
    position_.z = std::clamp(position_.z, layer_.bottom, layer_.top);
    if (hit.disc != nullptr) return meet_flake(*hit.disc);
    last_ = kNoDisc;
    if (limit < end) return meet_pigment();
    return direction_.z > 0 ? meet_surface() : meet_substrate();
  }

  bool meet_surface() {
    position_.z = layer_.top;
    const double eta = medium_.eta;
    const double cos_out = refracted_cosine(direction_.z, 1 / eta);
    if (random_() < fresnel_reflectance(direction_.z, cos_out, 1 / eta)) {
      direction_.z = -direction_.z;
      return true;
    }
    const auto part = static_cast<std::size_t>(component_);
    tally_.albedo[part] = tally_.albedo[part] + weight_;
    if (!joined_) {
      const Vec3<double> out{direction_.x * eta, direction_.y * eta, cos_out};
      for (std::size_t i = 0; i < medium_.detectors.size(); ++i) {
        const Cone& to = medium_.detectors[i];
        const Vec3<double> off = out - to.axis;
        if (dot(off, off) > 4 * square(std::sin(to.radius / 2))) continue;
        Rgb<double>& sum = tally_.brdf[i][part];
        sum = sum + weight_ / to.projected_solid_angle();
      }
    }
    return false;
  }

  bool meet_substrate() {
    position_.z = layer_.bottom;
    keep(scene_.substrate);
    component_ = with(substrate);
    see(lambertian_phase);
    direction_ = sample_lambertian(random_);
    return true;
  }

  bool meet_pigment() {
    component_ = mixture;
    see([this](Vec3<double> o) { return rayleigh_phase(dot(o, direction_)); });
    direction_ = sample_rayleigh(direction_, random_);
    return true;
  }

  bool meet_flake(const Disc& disc) {
    last_ = disc.index;
    const Met met = meet(medium_.flakes[disc.species].flakes, disc.normal);
    if (met == Met::mirrored) {
      direction_ = unit(direction_);
      component_ = with(single_flake);
      joined_ = scene_.joined && std::ranges::find(mirrors_, disc.index) == mirrors_.end();
      mirrors_.push_back(disc.index);
    }
    return met != Met::absorbed;
  }

  // A direction of a detector's cone as it is reached from inside.
  struct Exit {
    Vec3<double> direction{};  // in the binder
    // As of a detector of the walk, (1 - r)/(eta^2 cos_in), over the cone by cos(theta); 0: no
    // light gets there.
    double factor = 0;
  };
  Exit exit_to(const Cone& to) {
    const Vec3<double> out = to.sample(random_), in = refracted(out, medium_.eta);
    if (!(in.z > 0)) return {};
    const double passed = 1 - fresnel_reflectance(out.z, in.z, medium_.eta);
    return {in, passed / (medium_.eta * medium_.eta * in.z) * out.z * to.solid_angle() /
                    to.projected_solid_angle()};
  }

  // What is left of light on its way from a point of the box to the surface.
  Rgb<double> left_on_way(Vec3<double> from, Vec3<double> d) const {
    const double end = to_boundary(from, d);
    const double path = in_layer(from, d, end).until(end);
    Rgb<double> kept = map(medium_.absorption + grey(medium_.rayleigh),
                           [&](double k) { return std::exp(-k * path); });
    layer_.each(from, d, end, kNoDisc, [&](const Disc& disc) {
      kept = kept * transmittance(disc, d);
      return max_component(kept) > 0;
    });
    return kept;
  }

  Rgb<double> transmittance(const Disc& disc, Vec3<double> d) const {
    return flake_transmittance(medium_.flakes[disc.species].flakes, std::abs(dot(disc.normal, d)));
  }

  // The light that this scattering sends straight to a point of each cone.
  template <class Phase>
  void see(const Phase& phase) {
    joined_ = true;
    for (std::size_t i = 0; i < medium_.detectors.size(); ++i) {
      const Exit exit = exit_to(medium_.detectors[i]);
      if (!(exit.factor > 0)) continue;
      Rgb<double>& sum = tally_.brdf[i][static_cast<std::size_t>(component_)];
      sum = sum + weight_ * left_on_way(position_, exit.direction) *
                      (phase(exit.direction) * exit.factor);
    }
  }

  // One more flake of each species on the photon's way, before it is gone. Per length of the way
  // and per solid angle of their normals D S p(n) |d . n| flakes are met (D, S per thickness); per
  // solid angle of what they mirror, D S p(n)/4. The photon meets the flake in any of its points.
  void put_flake(const Stretch& stretch, double way) {
    const double at = way * random_();
    const double path = stretch.until(at);
    const Rgb<double> here =
        weight_ * map(medium_.absorption, [&](double k) { return std::exp(-k * path); });
    const Vec3<double> point = place_ + direction_ * at;
    for (std::size_t i = 0; i < medium_.detectors.size(); ++i) {
      const Exit exit = exit_to(medium_.detectors[i]);
      if (!(exit.factor > 0)) continue;
      const Vec3<double> sum = exit.direction - direction_;
      const double size = length(sum);
      if (!(size > 0)) continue;
      const Vec3<double> normal = sum / size;
      const Frame frame = frame_of(normal);
      Rgb<double> mirrored{};
      for (std::size_t k = 0; k < medium_.flakes.size(); ++k) {
        const Species& some = medium_.flakes[k];
        const double density = some.normals.density(normal) / 4;
        if (!(density > 0)) continue;
        const double area = flake_area(some, random_);  // m2
        const double radius = std::sqrt(area / kPi) * 1e6 / medium_.thickness_um;
        const double from_centre = radius * std::sqrt(random_()), turn = 2 * kPi * random_();
        const Vec3<double> centre =
            point - (frame.a * std::cos(turn) + frame.b * std::sin(turn)) * from_centre;
        if (centre.z > 0 || centre.z < -1) continue;
        const Disc disc{centre, normal, radius * radius, static_cast<std::uint32_t>(k), kNoDisc};
        Rgb<double> kept = flake_reflectance(some.flakes, size / 2) *
                           (some.flakes.flakes_per_mm2 * 1e6 * area * density);
        for (const Way& before : way_) {
          const double met = DiscLayer::distance_to(disc, before.from, before.direction);
          if (met > 0 && met < before.length) kept = kept * transmittance(disc, before.direction);
        }
        mirrored = mirrored + kept;
      }
      if (!(max_component(mirrored) > 0)) continue;
      Rgb<double>& seen = tally_.brdf[i][static_cast<std::size_t>(with(single_flake))];
      seen = seen + here * mirrored * left_on_way(layer_.wrapped(point), exit.direction) *
                        (way * exit.factor);
    }
  }

  const Medium& medium_;
  const DiscScene& scene_;
  const std::stop_token& stop_;
  DiscLayer layer_;
  Vec3<double> position_{};
  Vec3<double> place_{};  // the position, not in the box but where the photon began
  struct Way {
    Vec3<double> from, direction;
    double length;
  };
  std::vector<Way> way_{};                // from event to event, by place
  std::vector<std::uint32_t> mirrors_{};  // the discs that mirrored the photon
  // Whether what the last scattering sends out is joined to the detectors: it is not counted
  // besides. What the surface sends back is scattered again before it leaves.
  bool joined_ = false;
  std::uint32_t last_ = kNoDisc;  // the disc that the photon comes from
};

void require_cone(const std::string& field, const Vec3<double>& axis, double radius) {
  require_unit(field, axis);
  const double height = std::asin(std::clamp(axis.z / length(axis), -1.0, 1.0));
  if (!(height > 0 && height >= radius)) {
    reject(field + ".z", axis.z, "such that the cone about it lies above the surface");
  }
}

void require_whole(const std::string& field, double value, double least, double most) {
  if (value < least || value > most) {
    reject(field, text(value), "from " + text(least) + " to " + text(most));
  }
}

}  // namespace

void validate(const DiscScene& scene) {
  metallic_paint::validate(scene.paint);
  const double thickness = scene.paint.layer_thickness_um;
  if (!(thickness > 0)) reject("layer_thickness_um", thickness, "above 0 for finite flakes");
  require_colour("substrate", scene.substrate, 1);
  require_range("light_radius", scene.light_radius, 0, 0.5, " rad");
  require_cone("light", scene.light, scene.light_radius);
  require_detectors(scene.detectors.size());
  require_range("detector_radius", scene.detector_radius, 0, 0.5, " rad");
  if (!(scene.detector_radius > 0)) {
    reject("detector_radius", scene.detector_radius, "above 0 rad");
  }
  for (std::size_t i = 0; i < scene.detectors.size(); ++i) {
    require_cone(at_row("detectors", i), scene.detectors[i], scene.detector_radius);
  }
  const auto photons = static_cast<double>(scene.photons);
  require_whole("photons", photons, 2, 1e12);
  require_whole("layers", static_cast<double>(scene.layers), 2, std::min(photons, 65536.0));
  require_range("box", scene.box, 2, 1000);
  const double flakes = flakes_per_m2(scene.paint) * square(thickness * 1e-6 * box_side(scene));
  if (flakes > kMostFlakes) {
    reject("number of flakes in the box", text(flakes, 3), "at most " + text(kMostFlakes));
  }
  const double steps = most_steps_of_a_photon(scene.paint);
  require_steps("photons x (1 + number of detectors) x " + text(steps, 3) + " steps + flakes",
                photons * static_cast<double>(1 + scene.detectors.size()) * steps +
                    flakes * static_cast<double>(scene.layers));
}

DiscResult trace_discs(const DiscScene& scene, const std::stop_token& stop) {
  validate(scene);
  const Medium medium(scene);
  std::vector<Tally> tallies(scene.layers);
  const auto walk_batch = [&](std::size_t i) {
    const auto until = [&](std::size_t batches) {
      return static_cast<std::size_t>(static_cast<double>(scene.photons) *
                                      static_cast<double>(batches) /
                                      static_cast<double>(scene.layers));
    };
    tallies[i] = Walker(medium, scene, i, stop).walk(until(i + 1) - until(i));
  };
  parallel_for(scene.layers, walk_batch, 1, stop);
  DiscResult result;
  if (stop.stop_requested()) return result;
  const auto share = [&](const auto& value) { return estimate(tallies, 1, value); };
  result.specular = share([](const Tally& t) { return t.specular; });
  result.absorbed = share([](const Tally& t) { return t.absorbed; });
  result.truncated = share([](const Tally& t) { return t.truncated; });
  result.albedo = by_component(tallies, 1, [](const Tally& t) { return t.albedo; });
  for (std::size_t i = 0; i < medium.detectors.size(); ++i) {
    result.brdf.push_back(by_component(tallies, 1, [i](const Tally& t) { return t.brdf[i]; }));
  }
  for (const Tally& tally : tallies) result.steps += tally.steps;
  return result;
}

}  // namespace metallic_paint::reference
