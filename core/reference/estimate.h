// SPDX-License-Identifier: Apache-2.0
//
// What the references that follow photons find: means with their errors, by what the photons met.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "../vector.h"

namespace metallic_paint::reference {

// Of one photon.
inline constexpr std::size_t kMostScatterings = 1'000'000;

// Mean and its standard error, from the means of batches (256 where nothing else is said).
struct Estimate {
  Rgb<double> mean{}, error{};
};

// What a photon met on its way, besides flakes that let it straight through.
enum Component {
  single_flake = 0,  // mirrored by one flake
  substrate = 1,     // scattered once by the substrate
  mixture = 2        // everything else
};
inline constexpr int kComponents = 3;

// total is the sum of the components, with its own error.
struct ByComponent {
  std::array<Estimate, kComponents> part;
  Estimate total;
};

// value(tally) summed over the batches, as a mean per photon times `scale`.
template <class Tally, class Value>
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

// Likewise of parts(tally), the sums of each component.
template <class Tally, class Parts>
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

}  // namespace metallic_paint::reference
