// SPDX-License-Identifier: Apache-2.0
#include "random_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "../parallel.h"
#include "../validation.h"
#include "optics.h"
#include "photon.h"
#include "population.h"
#include "work.h"

namespace metallic_paint::reference {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kBatches = 256;
constexpr int kMostBins = 16384;

// Lengths in units of the layer's thickness.
struct Medium {
  std::vector<Population> flakes;
  double rayleigh;
  Rgb<double> absorption;
  double eta;

  explicit Medium(const Paint& paint)
      : flakes(populations(paint)),
        rayleigh(rayleigh_depth(paint)),
        absorption(absorption_depth(paint)),
        eta(paint.binder_ior) {}
};

// A direction outside as it is reached from inside.
struct Detector {
  Vec3<double> direction{};  // in the binder
  Rgb<double> slant{};       // optical depth of the whole layer on the way
  double reflectance = 1;    // of the surface
  // Per solid angle outside, flux W with phase function f gives W f T (1 - r) d omega_in/d
  // omega_out; the BRDF is that over cos(theta_out). From Snell, cos_in domega_in eta^2 = cos_out
  // domega_out: factor (1 - r)/(eta^2 cos_in). 0: no light gets there.
  double factor = 0;

  Detector(const Medium& medium, Vec3<double> outside) {
    direction = refracted(outside, medium.eta);
    const double cos_in = direction.z;
    if (cos_in == 0) return;
    reflectance = fresnel_reflectance(outside.z, cos_in, medium.eta);
    factor = (1 - reflectance) / (medium.eta * medium.eta * cos_in);
    // Flakes let their transmittance through.
    for (const Population& some : medium.flakes) {
      const double area = some.coverage * some.projected_area.at(cos_in);
      slant = slant + (grey(1.0) - some.mean_transmittance(cos_in)) * area;
    }
    slant = (slant + grey(medium.rayleigh) + medium.absorption) / cos_in;
  }
};

struct Tally : PhotonTally {
  std::size_t truncated_walks = 0;
  std::vector<Rgb<double>> bins;
};

class Walker : Photon<Tally> {
 public:
  Walker(const Medium& medium, const WalkScene& scene, const std::vector<Detector>& detectors,
         std::size_t batch, const std::stop_token& stop)
      : Photon(RandomStream(scene.seed).substream(batch), detectors.size()),
        medium_(medium),
        scene_(scene),
        detectors_(detectors),
        stop_(stop) {
    tally_.bins.resize(static_cast<std::size_t>(scene.theta_bins * scene.phi_bins));
  }

  // Photons that have passed the surface in the direction d; under total reflection d = 0.
  Tally walk(Vec3<double> d, std::size_t photons) {
    tally_.photons = photons;
    if (d.z == 0) return tally_;
    for (std::size_t i = 0; i < photons && !stop_.stop_requested(); ++i) walk(d);
    return tally_;
  }

 private:
  // One photon that has passed the surface in the direction d, weight 1.
  void walk(Vec3<double> d) {
    depth_ = 0;
    begin(d, grey(1.0));
    if (!ends(stop_, [this] { return step(); })) ++tally_.truncated_walks;
  }

  // To the next event; false where the photon ends.
  bool step() {
    const double cosine = std::max(std::abs(direction_.z), 1e-12);
    std::array<double, kSpecies> area{}, met{};  // <s>; D H <S> <s>, added up
    double flake_rate = 0;
    for (std::size_t i = 0; i < medium_.flakes.size(); ++i) {
      const Population& some = medium_.flakes[i];
      area[i] = some.projected_area.at(cosine);
      met[i] = flake_rate += some.coverage * area[i];
    }
    const double rate = flake_rate + medium_.rayleigh;
    const bool up = direction_.z > 0;
    const double to_boundary = (up ? depth_ : 1 - depth_) / cosine;
    // Absorption by weight: free paths are the same for all colours.
    const double free_path =
        rate > 0 ? -std::log1p(-random_()) / rate : std::numeric_limits<double>::infinity();
    if (max_component(medium_.absorption) > 0) {
      const double path = std::min(free_path, to_boundary);
      keep(map(medium_.absorption, [&](double k) { return std::exp(-k * path); }));
    }
    if (free_path >= to_boundary) return up ? meet_surface() : meet_substrate();
    depth_ = std::clamp(depth_ + (up ? -cosine : cosine) * free_path, 0.0, 1.0);
    const double event = random_() * rate;
    for (std::size_t i = 0; i < medium_.flakes.size(); ++i) {
      if (event < met[i]) return meet_flake(medium_.flakes[i], area[i]);
    }
    return meet_pigment();
  }

  bool meet_surface() {
    depth_ = 0;
    const double eta = medium_.eta;
    const double cos_out = refracted_cosine(direction_.z, 1 / eta);
    if (random_() < fresnel_reflectance(direction_.z, cos_out, 1 / eta)) {
      direction_.z = -direction_.z;
      return true;
    }
    auto& sum = tally_.albedo[static_cast<std::size_t>(component_)];
    sum = sum + weight_;
    if (!tally_.bins.empty()) {
      const auto bin = [](double x, int count) {
        return std::clamp(static_cast<int>(x * count), 0, count - 1);
      };
      const double turns = std::atan2(direction_.y, direction_.x) / (2 * kPi);
      const int row = bin(cos_out, scene_.theta_bins);
      const int column = bin(turns < 0 ? turns + 1 : turns, scene_.phi_bins);
      auto& cell = tally_.bins[static_cast<std::size_t>(row * scene_.phi_bins + column)];
      cell = cell + weight_;
    }
    return false;
  }

  bool meet_substrate() {
    depth_ = 1;
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

  // area: its species' <s> in the photon's direction.
  bool meet_flake(const Population& some, double area) {
    const int before = component_;
    component_ = with(single_flake);
    // Of the photons that meet a flake: the density p |v . n|/<s> of the normal half-way to o,
    // times d omega_n/d omega_o = 1/(4 |v . n|).
    see([&](Vec3<double> o) {
      const Vec3<double> sum = o - direction_;
      const double size = length(sum);
      if (!(size > 0)) return Rgb<double>{};
      return flake_reflectance(some.flakes, size / 2) *
             (some.normals.density(sum / size) / (4 * area));
    });
    const Met met = meet(some.flakes, some.normals.sample_met(direction_, random_));
    if (met == Met::passed) component_ = before;
    return met != Met::absorbed;
  }

  // Next-event estimate: the light that this scattering sends straight to each detector.
  template <class Phase>
  void see(const Phase& phase) {
    for (std::size_t i = 0; i < detectors_.size(); ++i) {
      const Detector& to = detectors_[i];
      if (!(to.factor > 0)) continue;
      const Rgb<double> kept = map(to.slant, [&](double x) { return std::exp(-x * depth_); });
      Rgb<double>& sum = tally_.brdf[i][static_cast<std::size_t>(component_)];
      sum = sum + weight_ * phase(to.direction) * kept * to.factor;
    }
  }

  const Medium& medium_;
  const WalkScene& scene_;
  const std::vector<Detector>& detectors_;
  const std::stop_token& stop_;
  double depth_ = 0;
};

void require_above(const std::string& field, double z) {
  if (!(z > 0)) reject(field + ".z", z, "above 0: above the surface");
}

}  // namespace

// Where nothing absorbs, even light from everywhere fills the layer evenly, eta^2 times as bright
// inside as outside; so a photon's mean way is eta^2 4 V/A, whatever scatters it (Blanco and
// Fournier 2003), and it meets surface and substrate eta^2 times each. In a layer without a bottom
// the probability of more than n events falls as 1/sqrt(n): up to the last of K they are some 4
// sqrt(K). Four times the mean over all directions leaves room for the longest of them.
double most_steps_of_a_photon(const Paint& paint) {
  double depth = rayleigh_depth(paint);
  for (int i = 0; i < kSpecies; ++i) depth += flake_coverage(paint.species(i));
  const double most = static_cast<double>(kMostScatterings);
  const double brighter = std::max(1.0, paint.binder_ior * paint.binder_ior);
  return std::min(most, 4 * brighter * std::min(4 * depth + 2, 4 * std::sqrt(most)));
}

void validate(const WalkScene& scene) {
  metallic_paint::validate(scene.paint);
  require_colour("substrate", scene.substrate, 1);
  require_unit("light", scene.light);
  require_above("light", scene.light.z);
  require_detectors(scene.detectors.size());
  for (std::size_t i = 0; i < scene.detectors.size(); ++i) {
    require_unit(at_row("detectors", i), scene.detectors[i]);
    require_above(at_row("detectors", i), scene.detectors[i].z);
  }
  if (scene.photons < 2 || scene.photons > 1'000'000'000'000) {
    reject("photons", std::to_string(scene.photons), "from 2 to 1e12");
  }
  const double steps = most_steps_of_a_photon(scene.paint);
  require_steps(
      "photons x (1 + number of detectors) x " + text(steps, 3) + " steps",
      static_cast<double>(scene.photons) * static_cast<double>(1 + scene.detectors.size()) * steps);
  const int theta = scene.theta_bins, phi = scene.phi_bins;
  if (theta == 0 && phi == 0) return;
  if (theta < 1 || phi < 1 || theta > kMostBins / phi) {
    reject("theta_bins x phi_bins", std::to_string(theta) + " x " + std::to_string(phi),
           "0 x 0 or from 1 to " + std::to_string(kMostBins) + " bins");
  }
}

WalkResult walk(const WalkScene& scene, const std::stop_token& stop) {
  validate(scene);
  const Medium medium(scene.paint);
  std::vector<Detector> detectors;
  for (const Vec3<double>& o : scene.detectors) detectors.emplace_back(medium, o / length(o));

  WalkResult result;
  const Detector entry(medium, scene.light / length(scene.light));
  const double entered = 1 - entry.reflectance;
  result.specular = entry.reflectance;

  const std::size_t batches = std::min(kBatches, scene.photons);
  std::vector<Tally> tallies(batches);
  const auto walk_batch = [&](std::size_t i) {
    const std::size_t photons = scene.photons * (i + 1) / batches - scene.photons * i / batches;
    tallies[i] = Walker(medium, scene, detectors, i, stop).walk(entry.direction * -1.0, photons);
  };
  parallel_for(batches, walk_batch, 1, stop);
  if (stop.stop_requested()) return result;

  const auto share = [&](const auto& value) { return estimate(tallies, entered, value); };
  result.albedo = by_component(tallies, entered, [](const Tally& t) { return t.albedo; });
  result.absorbed = share([](const Tally& t) { return t.absorbed; });
  result.truncated = share([](const Tally& t) { return t.truncated; });
  for (const Tally& tally : tallies) {
    result.truncated_walks += tally.truncated_walks;
    result.steps += tally.steps;
  }
  for (std::size_t i = 0; i < detectors.size(); ++i) {
    result.brdf.push_back(
        by_component(tallies, entered, [i](const Tally& t) { return t.brdf[i]; }));
  }
  for (std::size_t i = 0; i < tallies[0].bins.size(); ++i) {
    result.bins.push_back(share([i](const Tally& t) { return t.bins[i]; }));
  }
  return result;
}

}  // namespace metallic_paint::reference
