// SPDX-License-Identifier: Apache-2.0
//
// What the whole paint errs beside finite flakes with all mirrorings (core/reference/disc_walk.h):
// flakes in their mean and the lobes of the mixture, without the surface's own highlight. Fresh
// paints of one or two species, light at 45 degrees and grazing; green.
//
//   finite_flakes [PAINTS [PHOTONS [SEED]]]; some seconds of a core for each paint
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "mixture_scenes.h"
#include "reference/disc_walk.h"
#include "whole_paint.h"

namespace {

using namespace core_tests;

constexpr double kPi = std::numbers::pi, kRadius = 0.1;
// What is traced with a greater relative error is left out.
constexpr double kMostNoise = 0.04;

struct Geometry {
  double light, view, azimuth;  // degrees; the light's azimuth is 0
};
// At 45 degrees the views 15, 45, 75 and 110 off the highlight; then what grazes.
constexpr Geometry kGeometries[] = {
    {45, 30, 180}, {45, 0, 0},   {45, 30, 0},   {45, 65, 0}, {45, 45, 90}, {80, 0, 0},
    {80, 45, 0},   {80, 45, 90}, {80, 45, 180}, {85, 0, 0},  {85, 45, 0},  {85, 45, 180},
};
constexpr std::size_t kGeometriesInAll = std::size(kGeometries);

Vec3<double> direction(double degrees, double azimuth) {
  return spherical(degrees * kPi / 180, azimuth * kPi / 180);
}

// Tilts, coverages and flakes as car paints have them, and beyond.
Paint random_layer(Random& random) {
  const auto colour = [&](double from) {
    return Rgb<double>{random.uniform(from, 1), random.uniform(from, 1), random.uniform(from, 1)};
  };
  Paint paint = undiffracted();
  paint.depth_model = DepthModel::correlated;
  paint.layer_thickness_um = random.uniform(10, 60);
  paint.binder_ior = random.uniform(1.4, 1.6);
  const int species = 1 + (random.below(3) == 0 ? 1 : 0);
  const double coverage = random.log_uniform(0.1, 3) / species;
  const auto flakes = [&](FlakeSpecies& some) {
    some.flake_diameter_um = paint.layer_thickness_um * random.log_uniform(0.1, 2);
    some.flake_area_spread = random.uniform(0, 0.3);
    some.flakes_per_mm2 = coverage * 4e6 / (kPi * some.flake_diameter_um * some.flake_diameter_um);
    some.orientation = static_cast<Orientation>(random.below(3));
    some.tilt = random.log_uniform(0.05, 0.4);
    some.flake_transmission = random.below(3) == 0 ? colour(0) * 0.8 : Rgb<double>{};
    const Rgb<double> most = grey(1.0) - some.flake_transmission;
    some.flake_color = most * colour(0.4);
    some.flake_edge_color = most * colour(0.7);
  };
  flakes(paint);
  if (species > 1) flakes(paint.more[0]);
  paint.binder_absorption_per_mm = colour(0) * (random.below(2) == 0 ? 0.0 : 10.0);
  paint.rayleigh_per_mm = random.below(3) == 0 ? random.log_uniform(0.03, 1) : 0;
  paint.substrate_color = grey(random.uniform(0, 0.9));
  return paint;
}

// f of the model over the detector's cone, by the projected solid angle; green.
struct Model {
  double single = 0, rest = 0;
};

Model modelled(const Paint& paint, Vec3<double> light, Vec3<double> view) {
  const Layer<double> layer = make_layer<double>(paint);
  const Vec3<double> up{0, 0, 1};
  const reference::Frame frame = reference::frame_of(view);
  constexpr int kPoints = 24;
  Model sum;
  double weights = 0;
  for (int i = 0; i < kPoints; ++i) {
    const double drop = 2 * std::pow(std::sin(kRadius / 2), 2) * (i + 0.5) / kPoints;
    const double sine = std::sqrt(drop * (2 - drop)), turn = i * 2.399963229728653;
    SurfacePoint<double> point{};
    point.normal = up;
    point.view = view * (1 - drop) + (frame.a * std::cos(turn) + frame.b * std::sin(turn)) * sine;
    const Stack<double> stack = make_stack(paint, layer, point, up);
    const double weight = point.view.z;
    sum.single += weight * stack.coat.rest * flake_brdf(layer, up, point.view, light).y;
    sum.rest += weight * stack.coat.rest * scattered_by(stack, point, light).y / light.z;
    weights += weight;
  }
  return {sum.single / weights, sum.rest / weights};
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5));
}

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

std::vector<double> sizes(std::vector<double> values) {
  for (double& value : values) value = std::fabs(value);
  return values;
}

void tell(const char* name, const Seen& seen) {
  const std::vector<double> size = sizes(seen.whole), single = sizes(seen.single);
  std::printf("| %s | %.3f | %.3f | %.3f | %.3f | %.1f | %.1f | %.3f | %.3f | %.3f | %.3f |\n",
              name, quantile(seen.whole, 0.5), quantile(size, 0.5), quantile(size, 0.95),
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
      reference::DiscScene scene;
      scene.paint = paint;
      scene.substrate = paint.substrate_color;
      const double slant = kGeometries[from].light;
      scene.light = direction(slant, 0);
      scene.detector_radius = kRadius;
      scene.photons = photons;
      scene.seed = random.bits();
      std::size_t to = from;
      for (; to < kGeometriesInAll && kGeometries[to].light == slant; ++to) {
        scene.detectors.push_back(direction(kGeometries[to].view, kGeometries[to].azimuth));
      }
      const reference::DiscResult traced = reference::trace_discs(scene);
      reference::WalkScene apart{paint, scene.substrate, scene.light, scene.detectors, photons};
      apart.seed = scene.seed;
      const reference::WalkResult walked = reference::walk(apart);
      for (std::size_t i = from; i < to; ++i) {
        const auto& brdf = traced.brdf[i - from];
        const Model model = modelled(paint, scene.light, scene.detectors[i - from]);
        const double whole = brdf.total.mean.y;
        const double single = brdf.part[reference::single_flake].mean.y;
        if (brdf.total.error.y > kMostNoise * whole) continue;
        const double off = (model.single + model.rest) / whole - 1;
        seen[i].whole.push_back(off);
        seen[i].lightness.push_back(
            std::fabs(lightness(kPi * (model.single + model.rest)) - lightness(kPi * whole)));
        seen[i].single.push_back((model.single - single) / whole);
        seen[i].rest.push_back(model.rest / (whole - single) - 1);
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
      "| light, view, azimuth between | median | size, median | 95 %% | worst | L*, 95 %% | L*, "
      "worst | single, 95 %% | rest, median | walk's rest, median | noise |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
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
