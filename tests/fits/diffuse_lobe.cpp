// SPDX-License-Identifier: Apache-2.0
//
// What core/diffuse_lobe.h errs: the mixture under light from all angles, beside the random walk's;
// and what a Lambertian lobe would. Fresh paints of core/mixture.h's law over any substrate, those
// among them that show mostly this lobe; lights across the plane of the view, where the glossy lobe
// is weak.
//
//   diffuse_lobe [PAINTS [PHOTONS [SEED]]]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "mixture_scenes.h"

namespace {

using namespace core_tests;

const std::vector<double> kSlants = {0, 45, 60, 75, 80, 85};

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5));
}

struct Seen {
  std::vector<double> ratio, lightness;  // mixture over the walk's; error in L* of the whole
};

void tell(const char* lobe, double slant, const Seen& seen) {
  const auto beyond = std::count_if(seen.ratio.begin(), seen.ratio.end(),
                                    [](double ratio) { return std::fabs(ratio - 1) > 0.1; });
  std::printf("| %s, light at %g degrees | %.2f | %.2f | %.2f | %.2f | %.1f | %.1f | %.1f |\n",
              lobe, slant, quantile(seen.ratio, 0.05), quantile(seen.ratio, 0.5),
              quantile(seen.ratio, 0.95),
              static_cast<double>(beyond) / static_cast<double>(seen.ratio.size()),
              quantile(seen.lightness, 0.05), quantile(seen.lightness, 0.5),
              quantile(seen.lightness, 0.95));
}

}  // namespace

int main(int argc, char** argv) {
  const int paints = argc > 1 ? std::stoi(argv[1]) : 200;
  const std::size_t photons = argc > 2 ? std::stoul(argv[2]) : 30'000;
  const std::uint64_t seed = argc > 3 ? std::stoull(argv[3]) : std::random_device{}();
  Random random(seed);
  std::vector<Seen> lobe(kSlants.size()), lambertian(kSlants.size());
  for (int found = 0; found < paints; ++found) {
    const SeenPaint seen = mostly_diffuse(random);
    const Mixture<double> m =
        mixture(make_layer<double>(seen.paint), seen.substrate, seen.cos_view);
    const Ramp<double> ramp = make_ramp(make_layer<double>(seen.paint));
    const std::vector<Slanted> all = under_slants(seen, kSlants, photons, random.bits());
    for (std::size_t i = 0; i < kSlants.size(); ++i) {
      const auto& [shown, walked, single] = all[i];
      const auto see = [&](Seen& to, double more) {
        to.ratio.push_back((shown + more) / walked);
        to.lightness.push_back(lightness(single + shown + more) - lightness(single + walked));
      };
      const double slanted = diffuse_factor(ramp, std::cos(kSlants[i] * std::numbers::pi / 180));
      see(lobe[i], 0);
      see(lambertian[i], m.diffuse.x * (1 - slanted));
    }
  }
  std::printf("Seed %llu, %d paints.\n\n", static_cast<unsigned long long>(seed), paints);
  std::printf("| | 5 %% | median | 95 %% | off by 0.1 | L*, 5 %% | median | 95 %% |\n");
  std::printf("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  for (std::size_t i = 0; i < kSlants.size(); ++i) tell("this lobe", kSlants[i], lobe[i]);
  for (std::size_t i = 0; i < kSlants.size(); ++i)
    tell("a Lambertian one", kSlants[i], lambertian[i]);
}
