// SPDX-License-Identifier: Apache-2.0
//
// What photons do alike in the references that follow them: they lose weight, and flakes, pigment
// and substrate send them on.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stop_token>
#include <string>
#include <vector>

#include "../paint.h"
#include "../validation.h"
#include "estimate.h"
#include "optics.h"
#include "random.h"

namespace metallic_paint::reference {

// Per solid angle, of light that the substrate sends to a direction in the binder.
inline double lambertian_phase(Vec3<double> o) { return o.z / std::numbers::pi; }

inline Vec3<double> sample_lambertian(RandomStream& random) {
  const double r2 = random(), phi = 2 * std::numbers::pi * random();
  const double r = std::sqrt(r2);
  return {r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - r2)};
}

// Per solid angle, of light that pigment turns by an angle of this cosine.
inline double rayleigh_phase(double cosine) {
  return 3 / (16 * std::numbers::pi) * (1 + cosine * cosine);
}

// By rejection: the most is at no turn.
inline Vec3<double> sample_rayleigh(Vec3<double> from, RandomStream& random) {
  Vec3<double> d;
  do {
    const double z = 2 * random() - 1, phi = 2 * std::numbers::pi * random();
    const double sine = std::sqrt((1 - z) * (1 + z));
    d = {sine * std::cos(phi), sine * std::sin(phi), z};
  } while (random() * 3 / (8 * std::numbers::pi) >= rayleigh_phase(dot(d, from)));
  return d;
}

// The sums of one batch of photons.
struct PhotonTally {
  std::array<Rgb<double>, kComponents> albedo{};
  Rgb<double> absorbed{}, truncated{};
  std::size_t photons = 0, steps = 0;
  std::vector<std::array<Rgb<double>, kComponents>> brdf;
};

// Of a walker, whose batch has this tally: the photon that is under way.
template <class Tally>
class Photon {
 protected:
  Photon(RandomStream random, std::size_t detectors) : random_(random) {
    tally_.brdf.resize(detectors);
  }

  void begin(Vec3<double> direction, Rgb<double> weight) {
    direction_ = direction;
    weight_ = weight;
    component_ = kNothing;
  }

  // From event to event, until `step` is false; false where that takes too many.
  template <class Step>
  bool ends(const std::stop_token& stop, const Step& step) {
    for (std::size_t i = 0; i < kMostScatterings; ++i) {
      ++tally_.steps;
      if (stop.stop_requested() || !step() || !survives()) return true;
    }
    tally_.truncated = tally_.truncated + weight_;
    return false;
  }

  // The rest is absorbed.
  void keep(Rgb<double> share) {
    tally_.absorbed = tally_.absorbed + weight_ * (grey(1.0) - share);
    weight_ = weight_ * share;
  }

  // What the photon's way becomes by one more scattering.
  int with(int scattering) const { return component_ == kNothing ? scattering : mixture; }

  // Either way at random, by the sum over the colours: that sum then stays the same.
  enum class Met { absorbed, mirrored, passed };
  Met meet(const FlakeSpecies& flakes, Vec3<double> normal) {
    const double cosine = dot(direction_, normal);
    const Rgb<double> mirrored = weight_ * flake_reflectance(flakes, std::abs(cosine));
    const Rgb<double> passed = weight_ * flake_transmittance(flakes, std::abs(cosine));
    tally_.absorbed = tally_.absorbed + (weight_ - mirrored - passed);
    const double mirrored_sum = mirrored.x + mirrored.y + mirrored.z;
    const double sum = mirrored_sum + (passed.x + passed.y + passed.z);
    if (!(sum > 0)) return Met::absorbed;
    const double probability = mirrored_sum / sum;
    if (random_() < probability) {
      weight_ = mirrored / probability;
      direction_ = direction_ - normal * (2 * cosine);
      return Met::mirrored;
    }
    weight_ = passed / (1 - probability);
    return Met::passed;
  }

  Tally tally_;
  RandomStream random_;
  Vec3<double> direction_{};
  Rgb<double> weight_{};
  int component_ = kNothing;

 private:
  static constexpr int kNothing = -1;
  // Below this weight a photon goes on with a probability in proportion to its weight.
  static constexpr double kRouletteWeight = 1e-3;

  bool survives() {
    const double largest = max_component(weight_);
    if (largest >= kRouletteWeight) return true;
    if (!(random_() * kRouletteWeight < largest)) return false;
    weight_ = weight_ * (kRouletteWeight / largest);
    return true;
  }
};

inline void require_detectors(std::size_t count) {
  constexpr std::size_t most = 4096;
  if (count > most) {
    reject("number of detectors", std::to_string(count), "at most " + std::to_string(most));
  }
}

}  // namespace metallic_paint::reference
