// SPDX-License-Identifier: Apache-2.0
//
// What the whole paint errs beside finite flakes with all mirrorings (core/reference/disc_walk.h):
// flakes in their mean and the lobes of the mixture, without the surface's own highlight. Fresh
// paints of one or two species, light at 45 degrees and grazing; green.
//
//   finite_flakes [PAINTS [PHOTONS [SEED]]]; some seconds of a core for each paint
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "finite_scenes.h"
#include "reference/random_walk.h"

namespace {

using namespace core_tests;

struct Seen {
  // Errors of the whole and of single flakes, over the whole; of the rest, over the rest, and that
  // of the walk's rest.
  std::vector<double> whole, single, rest, walked;
  std::vector<double> lightness, noise;  // error of L*; standard error of the whole, relative

  void add(const Seen& more) {
    const auto join = [](std::vector<double>& to, const std::vector<double>& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    join(whole, more.whole), join(single, more.single), join(rest, more.rest);
    join(walked, more.walked), join(lightness, more.lightness), join(noise, more.noise);
  }
};

void tell(const char* name, const Seen& seen) {
  const std::vector<double> size = sizes(seen.whole), single = sizes(seen.single);
  std::printf(
      "| %s | %.3f | %.2f | %.2f | %.3f | %.3f | %.1f | %.1f | %.3f | %.3f | %.3f | %.3f |\n", name,
      quantile(seen.whole, 0.5), within(size, 0.05), within(size, 0.1), quantile(size, 0.95),
      quantile(size, 1), quantile(seen.lightness, 0.95), quantile(seen.lightness, 1),
      quantile(single, 0.95), quantile(seen.rest, 0.5), quantile(seen.walked, 0.5),
      quantile(seen.noise, 0.5));
}

}  // namespace

int main(int argc, char** argv) {
  const int paints = argc > 1 ? std::stoi(argv[1]) : 100;
  const std::size_t photons = argc > 2 ? std::stoul(argv[2]) : 40'000;
  const std::uint64_t seed = argc > 3 ? std::stoull(argv[3]) : std::random_device{}();
  std::printf("Seed %llu, %d paints.\n\n", static_cast<unsigned long long>(seed), paints);
  Random random(seed);
  std::vector<Seen> seen(kGeometriesInAll);
  double worst = 0;
  std::string where;
  for (int k = 0; k < paints; ++k) {
    const Paint paint = random_layer(random);
    for (std::size_t from = 0; from < kGeometriesInAll;) {
      const double slant = kGeometries[from].light;
      const reference::DiscScene scene = scene_of(paint, slant, photons, random.bits());
      const std::size_t to = from + scene.detectors.size();
      const reference::DiscResult traced = reference::trace_discs(scene);
      reference::WalkScene apart{paint, scene.substrate, scene.light, scene.detectors, photons};
      apart.seed = scene.seed;
      const reference::WalkResult walked = reference::walk(apart);
      for (std::size_t i = from; i < to; ++i) {
        const auto& brdf = traced.brdf[i - from];
        const Vec3<double> view = scene.detectors[i - from];
        const double shown_single = single_of(paint, scene.light, view);
        const double shown_rest = rest_of(paint, scene.light, view);
        const double shown = shown_single + shown_rest;
        const double whole = brdf.total.mean.y;
        const double single = brdf.part[reference::single_flake].mean.y;
        if (brdf.total.error.y > kMostNoise * whole) continue;
        const double off = shown / whole - 1;
        seen[i].whole.push_back(off);
        seen[i].lightness.push_back(std::fabs(lightness(kPi * shown) - lightness(kPi * whole)));
        seen[i].single.push_back((shown_single - single) / whole);
        seen[i].rest.push_back(shown_rest / (whole - single) - 1);
        const auto& random_walk = walked.brdf[i - from];
        seen[i].walked.push_back(
            (random_walk.total.mean.y - random_walk.part[reference::single_flake].mean.y) /
                (whole - single) -
            1);
        seen[i].noise.push_back(brdf.total.error.y / whole);
        if (std::fabs(off) > worst) {
          worst = std::fabs(off);
          char text[300];
          std::snprintf(text, sizeof text,
                        "%+.2f of %.4f (error %.4f): light at %g, view at %g and %g degrees; "
                        "coverage %.2f, diameter over thickness %.2f, tilt %.2f, %d species, "
                        "substrate %.2f",
                        off, whole, brdf.total.error.y, slant, kGeometries[i].view,
                        kGeometries[i].azimuth, reference::flake_coverage(paint),
                        paint.flake_diameter_um / paint.layer_thickness_um, paint.tilt,
                        paint.more[0].flakes_per_mm2 > 0 ? 2 : 1, paint.substrate_color.y);
          where = text;
        }
      }
      from = to;
    }
    std::fprintf(stderr, "%d of %d\n", k + 1, paints);
  }
  std::printf(
      "| light, view, azimuth between | median | within 5 %% | within 10 %% | 95 %% | worst "
      "| L*, 95 %% | L*, worst | single, 95 %% | rest, median | walk's rest, median | noise |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  Seen all, steep;
  for (std::size_t i = 0; i < kGeometriesInAll; ++i) {
    const Geometry& at = kGeometries[i];
    char name[60];
    std::snprintf(name, sizeof name, "%g, %g, %g", at.light, at.view, at.azimuth);
    tell(name, seen[i]);
    all.add(seen[i]);
    if (at.light < 60) steep.add(seen[i]);
  }
  tell("light at 45", steep);
  tell("all", all);
  std::printf("\nWorst: %s.\n", where.c_str());
}
