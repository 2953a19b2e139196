// SPDX-License-Identifier: Apache-2.0
#include "reference/random_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "batch.h"
#include "reference/visible_flakes.h"

namespace metallic_paint::reference {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kBatches = 256;
// Below this weight a photon goes on with a probability in proportion to its weight.
constexpr double kRouletteWeight = 1e-3;
constexpr std::size_t kMostDetectors = 4096;
constexpr int kMostBins = 16384;

// cos of the refracted angle from sin^2 + cos^2 = 1 and Snell, eta^2 cos^2(t) = (eta^2 - 1) +
// cos^2(i); 0 under total reflection. eta: of the far side relative to the near side.
double refracted_cosine(double cos_i, double eta) {
  const double square = (eta - 1) * (eta + 1) + cos_i * cos_i;
  return square > 0 ? std::min(std::sqrt(square) / eta, 1.0) : 0;
}

// Fresnel's reflectance for unpolarised light.
double fresnel_reflectance(double cos_i, double cos_t, double eta) {
  if (cos_t <= 0) return 1;
  const double s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  const double p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  return (s * s + p * p) / 2;
}

// Lengths in units of the layer's thickness.
struct Medium {
  VisibleFlakes flakes;
  Rgb<double> flake_color, flake_edge_color, flake_transmission;
  double coverage;         // D <S> H
  double rayleigh;         // (16 pi/3) c1 H
  Rgb<double> absorption;  // kappa H
  double eta;

  explicit Medium(const Paint& paint)
      : flakes(paint.orientation, paint.tilt),
        flake_color(paint.flake_color),
        flake_edge_color(paint.flake_edge_color),
        flake_transmission(paint.flake_transmission),
        eta(paint.binder_ior) {
    const double thickness_mm = paint.layer_thickness_um * 1e-3;
    rayleigh = 16 * kPi / 3 * paint.rayleigh_per_mm * thickness_mm;
    absorption = paint.binder_absorption_per_mm * thickness_mm;
    // Mean of max(0, 1 + s w) over standard normal deviates w.
    const double s = paint.flake_area_spread;
    double mean_area = 1;
    if (s > 0) {
      mean_area = std::erfc(-1 / (s * std::sqrt(2.0))) / 2 +
                  s * std::exp(-1 / (2 * s * s)) / std::sqrt(2 * kPi);
    }
    const double diameter_mm = paint.flake_diameter_um * 1e-3;
    coverage = paint.flakes_per_mm2 * kPi / 4 * diameter_mm * diameter_mm * mean_area;
  }

  // Schlick.
  Rgb<double> reflectance(double cos_alpha) const {
    const double x = std::max(1 - cos_alpha, 0.0);
    return flake_color + (flake_edge_color - flake_color) * (x * x * x * x * x);
  }
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
    const double cos_in = refracted_cosine(outside.z, medium.eta);
    if (cos_in <= 0) return;
    direction = {outside.x / medium.eta, outside.y / medium.eta, cos_in};
    reflectance = fresnel_reflectance(outside.z, cos_in, medium.eta);
    factor = (1 - reflectance) / (medium.eta * medium.eta * cos_in);
    // Flakes let their transmittance through.
    const double area = medium.coverage * medium.flakes.projected_area(cos_in);
    slant = ((grey(1.0) - medium.flake_transmission) * area + grey(medium.rayleigh) +
             medium.absorption) /
            cos_in;
  }
};

// The sums of one batch of photons.
struct Tally {
  std::array<Rgb<double>, kComponents> albedo{};
  Rgb<double> absorbed{}, truncated{};
  std::size_t photons = 0, truncated_walks = 0;
  std::vector<std::array<Rgb<double>, kComponents>> brdf;
  std::vector<Rgb<double>> bins;
};

class Walker {
 public:
  Walker(const Medium& medium, const WalkScene& scene, const std::vector<Detector>& detectors,
         std::size_t batch)
      : medium_(medium), scene_(scene), detectors_(detectors), random_(scene.seed, batch) {
    tally_.brdf.resize(detectors.size());
    tally_.bins.resize(static_cast<std::size_t>(scene.theta_bins * scene.phi_bins));
  }

  // Photons that have passed the surface in the direction d; under total reflection d = 0.
  Tally walk(Vec3<double> d, std::size_t photons) {
    tally_.photons = photons;
    if (d.z == 0) return tally_;
    for (std::size_t i = 0; i < photons; ++i) walk(d);
    return tally_;
  }

 private:
  // One photon that has passed the surface in the direction d, weight 1.
  void walk(Vec3<double> d) {
    depth_ = 0;
    direction_ = d;
    weight_ = grey(1.0);
    component_ = kNothing;
    for (std::size_t i = 0; i < kMostScatterings; ++i) {
      if (!step() || !survives()) return;
    }
    tally_.truncated = tally_.truncated + weight_;
    ++tally_.truncated_walks;
  }

  // To the next event; false where the photon ends.
  bool step() {
    const double cosine = std::max(std::abs(direction_.z), 1e-12);
    const double area = medium_.flakes.projected_area(cosine);
    const double flake_rate = medium_.coverage * area;
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
    return random_() * rate < flake_rate ? meet_flake(area) : meet_pigment();
  }

  // The rest is absorbed.
  void keep(Rgb<double> share) {
    tally_.absorbed = tally_.absorbed + weight_ * (grey(1.0) - share);
    weight_ = weight_ * share;
  }

  bool survives() {
    const double largest = max_component(weight_);
    if (largest >= kRouletteWeight) return true;
    if (!(random_() * kRouletteWeight < largest)) return false;
    weight_ = weight_ * (kRouletteWeight / largest);
    return true;
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
    see([](Vec3<double> o) { return grey(o.z / kPi); });
    const double r2 = random_(), phi = 2 * kPi * random_();
    const double r = std::sqrt(r2);
    direction_ = {r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - r2)};
    return true;
  }

  // Rayleigh.
  bool meet_pigment() {
    component_ = mixture;
    const auto phase = [this](Vec3<double> o) {
      const double cosine = dot(o, direction_);
      return 3 / (16 * kPi) * (1 + cosine * cosine);
    };
    see([&](Vec3<double> o) { return grey(phase(o)); });
    Vec3<double> d;
    do {
      const double z = 2 * random_() - 1, phi = 2 * kPi * random_();
      const double sine = std::sqrt((1 - z) * (1 + z));
      d = {sine * std::cos(phi), sine * std::sin(phi), z};
    } while (random_() * 3 / (8 * kPi) >= phase(d));
    direction_ = d;
    return true;
  }

  // area: <s> of the photon's direction.
  bool meet_flake(double area) {
    const int before = component_;
    component_ = with(single_flake);
    // Of the photons that meet a flake: the density p |v . n|/<s> of the normal half-way to o,
    // times d omega_n/d omega_o = 1/(4 |v . n|).
    see([&](Vec3<double> o) {
      const Vec3<double> sum = o - direction_;
      const double size = length(sum);
      if (!(size > 0)) return Rgb<double>{};
      return medium_.reflectance(size / 2) * (medium_.flakes.density(sum / size) / (4 * area));
    });
    const Vec3<double> n = medium_.flakes.sample(direction_, random_);
    const double cosine = dot(direction_, n);
    const Rgb<double> mirrored = weight_ * medium_.reflectance(std::abs(cosine));
    const Rgb<double> passed = weight_ * medium_.flake_transmission;
    tally_.absorbed = tally_.absorbed + (weight_ - mirrored - passed);
    // Either way at random, by the sum over the colours: that sum then stays the same.
    const double mirrored_sum = mirrored.x + mirrored.y + mirrored.z;
    const double sum = mirrored_sum + (passed.x + passed.y + passed.z);
    if (!(sum > 0)) return false;
    const double probability = mirrored_sum / sum;
    if (random_() < probability) {
      weight_ = mirrored / probability;
      direction_ = direction_ - n * (2 * cosine);
    } else {
      weight_ = passed / (1 - probability);
      component_ = before;
    }
    return true;
  }

  // What the photon's way becomes by one more scattering.
  int with(int scattering) const { return component_ == kNothing ? scattering : mixture; }

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

  static constexpr int kNothing = -1;

  const Medium& medium_;
  const WalkScene& scene_;
  const std::vector<Detector>& detectors_;
  Tally tally_;
  UniformRandom random_;
  double depth_ = 0;
  Vec3<double> direction_{};
  Rgb<double> weight_{};
  int component_ = kNothing;
};

// value(tally) summed over the batches, as a mean per photon times `scale`.
template <class Value>
Estimate estimate(const std::vector<Tally>& tallies, double scale, const Value& value) {
  Rgb<double> sum{}, square{};
  double photons = 0;
  for (const Tally& tally : tallies) {
    sum = sum + value(tally);
    photons += static_cast<double>(tally.photons);
  }
  const Rgb<double> mean = sum / photons;
  for (const Tally& tally : tallies) {
    const Rgb<double> off = value(tally) / static_cast<double>(tally.photons) - mean;
    square = square + off * off;
  }
  const double n = static_cast<double>(tallies.size());
  return {mean * scale,
          map(square, [&](double x) { return scale * std::sqrt(x / (n * (n - 1))); })};
}

template <class Parts>
ByComponent by_component(const std::vector<Tally>& tallies, double scale, const Parts& parts) {
  ByComponent all;
  for (std::size_t c = 0; c < kComponents; ++c) {
    all.part[c] = estimate(tallies, scale, [&](const Tally& t) { return parts(t)[c]; });
  }
  all.total = estimate(tallies, scale, [&](const Tally& t) {
    const auto& part = parts(t);
    return part[single_flake] + part[substrate] + part[mixture];
  });
  return all;
}

[[noreturn]] void reject(const std::string& field, const std::string& value,
                         const std::string& range) {
  throw std::invalid_argument(field + " is " + value + ", but must be " + range);
}

void require_above(const std::string& field, double z) {
  if (!(z > 0)) reject(field + ".z", std::to_string(z), "above 0: above the surface");
}

}  // namespace

void validate(const WalkScene& scene) {
  metallic_paint::validate(scene.paint);
  const double albedo[3] = {scene.substrate.x, scene.substrate.y, scene.substrate.z};
  for (int i = 0; i < 3; ++i) {
    if (albedo[i] >= 0 && albedo[i] <= 1) continue;
    reject(std::string("substrate.") + "rgb"[i], std::to_string(albedo[i]), "from 0 to 1");
  }
  validate_direction("light", 0, scene.light);
  require_above("light", scene.light.z);
  if (scene.detectors.size() > kMostDetectors) {
    reject("number of detectors", std::to_string(scene.detectors.size()),
           "at most " + std::to_string(kMostDetectors));
  }
  for (std::size_t i = 0; i < scene.detectors.size(); ++i) {
    validate_direction("detectors", i, scene.detectors[i]);
    require_above("detectors[" + std::to_string(i) + "]", scene.detectors[i].z);
  }
  if (scene.photons < 2 || scene.photons > 1'000'000'000'000) {
    reject("photons", std::to_string(scene.photons), "from 2 to 1e12");
  }
  const int theta = scene.theta_bins, phi = scene.phi_bins;
  if (theta == 0 && phi == 0) return;
  if (theta < 1 || phi < 1 || theta > kMostBins / phi) {
    reject("theta_bins x phi_bins", std::to_string(theta) + " x " + std::to_string(phi),
           "0 x 0 or from 1 to " + std::to_string(kMostBins) + " bins");
  }
}

WalkResult walk(const WalkScene& scene) {
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
  parallel_for(
      batches,
      [&](std::size_t i) {
        const std::size_t photons = scene.photons * (i + 1) / batches - scene.photons * i / batches;
        tallies[i] = Walker(medium, scene, detectors, i).walk(entry.direction * -1.0, photons);
      },
      1);

  const auto share = [&](const auto& value) { return estimate(tallies, entered, value); };
  result.albedo = by_component(tallies, entered, [](const Tally& t) { return t.albedo; });
  result.absorbed = share([](const Tally& t) { return t.absorbed; });
  result.truncated = share([](const Tally& t) { return t.truncated; });
  for (const Tally& tally : tallies) result.truncated_walks += tally.truncated_walks;
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
