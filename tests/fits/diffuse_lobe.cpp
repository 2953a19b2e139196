// SPDX-License-Identifier: Apache-2.0
//
// What core/diffuse_lobe.h errs: the mixture under light from all angles, beside the random walk's;
// and what a Lambertian lobe would. Fresh paints of core/mixture.h's law over any substrate, those
// among them that show mostly this lobe; lights across the plane of the view, where the glossy lobe
// is weak.
//
//   diffuse_lobe [PAINTS [PHOTONS [SEED]]]
#include <algorithm>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "mixture_scenes.h"

namespace {

using namespace core_tests;

constexpr double kSlants[] = {0, 45, 60, 75, 80, 85};

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5));
}

struct Seen {
  std::vector<double> ratio, lightness;  // mixture over the walk's; error in L* of the whole
};

void tell(const char* lobe, double slant, const Seen& seen) {
  std::printf("| %s, light at %g degrees | %.2f | %.2f | %.2f | %.1f | %.1f | %.1f |\n", lobe,
              slant, quantile(seen.ratio, 0.05), quantile(seen.ratio, 0.5),
              quantile(seen.ratio, 0.95), quantile(seen.lightness, 0.05),
              quantile(seen.lightness, 0.5), quantile(seen.lightness, 0.95));
}

}  // namespace

int main(int argc, char** argv) {
  const int paints = argc > 1 ? std::stoi(argv[1]) : 200;
  const std::size_t photons = argc > 2 ? std::stoul(argv[2]) : 30'000;
  const std::uint64_t seed = argc > 3 ? std::stoull(argv[3]) : std::random_device{}();
  Random random(seed);
  constexpr std::size_t kLights = std::size(kSlants);
  Seen lobe[kLights], lambertian[kLights];
  for (int found = 0; found < paints;) {
    SeenPaint seen = over_any_substrate(
        random, random.below(3) == 0 ? library_paint(random) : ordinary_paint(random));
    const double slants[] = {1, 0.966, 0.707};
    seen.cos_view = slants[random.below(3)];
    const Mixture<double> m =
        mixture(make_layer<double>(seen.paint), seen.substrate, seen.cos_view);
    if (!(m.diffuse.x > 0.02 && m.diffuse.x > 3 * m.glossy.x)) continue;
    ++found;
    reference::WalkScene scene = walk_scene(seen, photons, random.bits());
    for (const double slant : kSlants) {
      const double angle = slant * std::numbers::pi / 180;
      scene.detectors.push_back({0, std::sin(angle), std::cos(angle)});
    }
    const reference::WalkResult walked = reference::walk(scene);
    const GlossyLobe glossy(seen.cos_view, m.alpha);
    const Ramp<double> ramp = make_ramp(seen.paint.binder_ior);
    for (std::size_t i = 0; i < kLights; ++i) {
      const auto& brdf = walked.brdf[i];
      const double whole = std::numbers::pi * brdf.total.mean.x;
      const double single = std::numbers::pi * brdf.part[reference::single_flake].mean.x;
      const auto see = [&](Seen& to, double slanted) {
        const double shown = m.diffuse.x * slanted + m.glossy.x * glossy(scene.detectors[i]);
        to.ratio.push_back(shown / (whole - single));
        to.lightness.push_back(lightness(single + shown) - lightness(whole));
      };
      see(lobe[i], diffuse_factor(ramp, scene.detectors[i].z));
      see(lambertian[i], 1);
    }
  }
  std::printf("Seed %llu, %d paints.\n\n", static_cast<unsigned long long>(seed), paints);
  std::printf("| | 5 %% | median | 95 %% | L*, 5 %% | median | 95 %% |\n");
  std::printf("| --- | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  for (std::size_t i = 0; i < kLights; ++i) tell("this lobe", kSlants[i], lobe[i]);
  for (std::size_t i = 0; i < kLights; ++i) tell("a Lambertian one", kSlants[i], lambertian[i]);
}
