// SPDX-License-Identifier: Apache-2.0
//
// Photons among finite flakes against what is known without them: energy, reciprocity, the random
// walk as the limit of small flakes, and the traced discs' single mirroring. Statistical tests have
// the level 1e-6 over all comparisons of a test, and other layers in each run of --all.
#include "reference/disc_walk.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "photons.h"
#include "reference/explicit_flakes.h"
#include "reference/random_walk.h"
#include "support.h"

namespace core_tests {
namespace {

using metallic_paint::FlakeSpecies;
using metallic_paint::grey;
using metallic_paint::Orientation;
using metallic_paint::Paint;
using metallic_paint::Rgb;
using metallic_paint::Vec3;
using metallic_paint::reference::ByComponent;
using metallic_paint::reference::DiscResult;
using metallic_paint::reference::DiscScene;
using metallic_paint::reference::Estimate;
namespace reference = metallic_paint::reference;

constexpr double kPi = std::numbers::pi;

// Flakes of the diameter (over the thickness) that cover so much; no spread of their areas.
void cover(FlakeSpecies& flakes, double thickness_um, double diameter, double coverage) {
  flakes.flake_diameter_um = diameter * thickness_um;
  flakes.flake_area_spread = 0;
  flakes.flakes_per_mm2 =
      coverage * 4e6 / (kPi * flakes.flake_diameter_um * flakes.flake_diameter_um);
}

// Two species in a coloured binder with pigment.
Paint full_paint(double diameter) {
  Paint paint;
  paint.layer_thickness_um = 40;
  cover(paint, 40, diameter, 0.7);
  paint.orientation = Orientation::ggx;
  paint.tilt = 0.5;
  paint.flake_color = {0.6, 0.75, 0.9};
  paint.flake_edge_color = {0.65, 0.75, 0.9};
  paint.flake_transmission = {0.3, 0.2, 0};
  FlakeSpecies& more = paint.more[0];
  cover(more, 40, diameter, 0.3);
  more.orientation = Orientation::gaussian;
  more.tilt = 0.4;
  more.flake_color = more.flake_edge_color = {0.9, 0.5, 0.3};
  paint.binder_ior = 1.5;
  paint.binder_absorption_per_mm = {0, 2, 5};
  paint.rayleigh_per_mm = 0.2;
  return paint;
}

// What both ways share falls with D/H (hot_spot.h), so the limit is reached along a line: twice the
// result of small flakes less that of flakes twice as wide.
TEST(DiscWalk, SmallFlakesWalkAtRandom) {
  constexpr double kDiameter = 0.03;
  DiscScene scene;
  scene.light = direction(50);
  scene.detectors = {direction(10, kPi), direction(40, kPi), direction(60, 1), direction(75, 2)};
  scene.detector_radius = 0.07;
  scene.photons = 30'000 / kFewer;
  scene.layers = 32;
  scene.box = 4;
  const auto at = [&](double diameter) {
    scene.paint = full_paint(diameter);
    ++scene.seed;
    return reference::trace_discs(scene);
  };
  scene.seed = run_seed();
  const DiscResult small = at(kDiameter), wide = at(2 * kDiameter);

  reference::WalkScene random;
  random.paint = scene.paint;
  random.substrate = scene.substrate;
  random.light = scene.light;
  random.detectors = scene.detectors;
  random.photons = scene.photons;
  random.seed = run_seed();
  const reference::WalkResult walked = reference::walk(random);

  const auto limit = [](const Estimate& a, const Estimate& b) {
    const auto both = [](double x, double y) { return std::hypot(2 * x, y); };
    return Estimate{
        a.mean * 2.0 - b.mean,
        {both(a.error.x, b.error.x), both(a.error.y, b.error.y), both(a.error.z, b.error.z)}};
  };
  Worst shares, seen;
  EXPECT_NEAR(small.specular.mean.x, walked.specular, 1e-12);
  see(shares, limit(small.absorbed, wide.absorbed), walked.absorbed, "absorbed");
  for (std::size_t c = 0; c <= reference::kComponents; ++c) {
    const auto of = [&](const ByComponent& all) {
      return c < reference::kComponents ? all.part[c] : all.total;
    };
    const std::string part = "part " + std::to_string(c);
    see(shares, limit(of(small.albedo), of(wide.albedo)), of(walked.albedo), part);
    for (std::size_t i = 0; i < scene.detectors.size(); ++i) {
      // The cone's mean differs from its middle by (radius^2/8) laplace(f): tilts of 0.4 in the
      // binder bend f, seen outside, by 1/(2 * 0.4)^2 or so.
      see(seen, limit(of(small.brdf[i]), of(wide.brdf[i])), of(walked.brdf[i]),
          part + " of detector " + std::to_string(i), 2e-3);
    }
  }
  const double parts = 3 * (reference::kComponents + 1);
  shares.expect_at_most(student_threshold(parts + 3, 32), "shares");
  seen.expect_at_most(student_threshold(parts * 4, 32), "seen");
}

// Each photon keeps its weight, however many flakes it meets.
TEST(DiscWalk, LosesNothingInAWhiteFurnace) {
  Random random = fresh(701);
  Worst worst;
  for (int k = 0; k < 40; ++k) {
    DiscScene scene;
    Paint& paint = scene.paint;
    paint.layer_thickness_um = random.log_uniform(5, 200);
    cover(paint, paint.layer_thickness_um, random.log_uniform(0.1, 8), random.log_uniform(0.02, 4));
    paint.flake_area_spread = random.uniform(0, 0.5);
    paint.orientation = static_cast<Orientation>(random.below(3));
    paint.tilt = random.log_uniform(0.01, 0.8);
    const double passed = random.below(2) == 0 ? 0 : random.uniform(0, 1);
    paint.flake_color = paint.flake_edge_color = grey(1 - passed);
    paint.flake_transmission = grey(passed);
    paint.binder_ior = random.uniform(1, 2);
    paint.rayleigh_per_mm = random.below(2) == 0 ? 0 : random.log_uniform(0.01, 3);
    scene.substrate = grey(1.0);
    scene.light = direction(random.uniform(0, 85));
    scene.light_radius = random.below(2) == 0 ? 0 : 0.05;
    scene.photons = 400;
    scene.layers = 2;
    scene.seed = random.bits();
    const DiscResult result = reference::trace_discs(scene);
    for (int i = 0; i < 3; ++i) {
      const double all = channel(result.specular.mean, i) + channel(result.albedo.total.mean, i);
      worst.see(std::fabs(all - 1), "scene", k);
      worst.see(std::fabs(channel(result.absorbed.mean, i)), "scene", k);
    }
  }
  worst.expect_at_most(1e-11);
}

// Flakes put on the ways against photons that happen to leave within the cones. Wide flakes mirror
// a photon twice, opaque ones hide its ways before.
TEST(DiscWalk, FlakesPutOnTheWaySendWhatIsCounted) {
  constexpr std::size_t kLayers = 96;
  Worst worst;
  const double diameters[] = {0.3, 1, 4};
  for (double diameter : diameters) {
    DiscScene scene;
    scene.paint = full_paint(diameter);
    scene.paint.flake_area_spread = 0.3;
    scene.paint.more[0].flakes_per_mm2 *= 3;
    scene.light = direction(35, kPi);
    scene.detectors = {direction(15), direction(65, 2)};
    scene.detector_radius = 0.2;
    scene.photons = 15'000 / kFewer;
    scene.layers = kLayers;
    scene.seed = run_seed();
    const DiscResult put = reference::trace_discs(scene);
    scene.joined = false;
    scene.photons *= 2;
    ++scene.seed;
    const DiscResult counted = reference::trace_discs(scene);
    for (std::size_t i = 0; i < scene.detectors.size(); ++i) {
      const std::string where =
          "D/H " + std::to_string(diameter) + " detector " + std::to_string(i);
      see(worst, put.brdf[i].total, counted.brdf[i].total, where);
      for (std::size_t c = 0; c < reference::kComponents; ++c) {
        see(worst, put.brdf[i].part[c], counted.brdf[i].part[c],
            where + ", part " + std::to_string(c));
      }
    }
  }
  worst.expect_at_most(student_threshold(3 * 4 * 2 * std::size(diameters), kLayers));
}

// Finite flakes of two species, cones of light and of view.
TEST(DiscWalk, LightAndDetectorMayChangePlaces) {
  constexpr std::size_t kLayers = 96;
  const std::vector<Vec3<double>> places{direction(20, 1), direction(50, 4), direction(75, 2.4)};
  DiscScene scene;
  scene.paint = full_paint(1);
  scene.detectors = places;
  scene.light_radius = scene.detector_radius = 0.12;
  scene.photons = 30'000 / kFewer;
  scene.layers = kLayers;
  std::vector<DiscResult> results;
  for (const Vec3<double>& light : places) {
    scene.light = light;
    scene.seed = run_seed() + results.size();
    results.push_back(reference::trace_discs(scene));
  }
  Worst worst;
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const ByComponent &a = results[i].brdf[j], &b = results[j].brdf[i];
      const std::string where = std::to_string(i) + " and " + std::to_string(j);
      see(worst, a.total, b.total, where);
      for (std::size_t c = 0; c < reference::kComponents; ++c) {
        see(worst, a.part[c], b.part[c], where + ", part " + std::to_string(c));
      }
    }
  }
  worst.expect_at_most(student_threshold(3 * 3 * 4, kLayers));
}

// One mirroring between discs, there by the points of each sparkling flake that are free both ways.
// There the light is a cone, E its irradiance on a plane normal to it; here it is the detector, by
// the reciprocity above: T 4 pi sin^2(r/2) = f pi sin^2(r) cos.
TEST(DiscWalk, SingleMirroringIsThatOfTracedDiscs) {
  constexpr std::size_t kLayers = 64, kPixels = 256;
  constexpr double kRadius = 0.06;
  const struct {
    double diameter, coverage, degrees, tilt;
  } cases[] = {
      {0.3, 0.5, 20, 0.02}, {1, 2, 20, 0.02}, {1, 1, 60, 0.02}, {3, 1, 40, 0.1}, {1, 3, 0, 0.4}};
  Worst worst;
  for (const auto& [diameter, coverage, degrees, tilt] : cases) {
    reference::ExplicitScene traced;
    Paint& paint = traced.paint;
    cover(paint, paint.layer_thickness_um, diameter, coverage);
    paint.tilt = tilt;
    paint.flake_spread = 0;
    paint.diffraction = metallic_paint::Diffraction::none;
    paint.flake_transmission = {};
    traced.view = direction(degrees);
    traced.light = direction(degrees, kPi);
    traced.light_radius = kRadius;
    traced.pixels = kPixels;
    // 40 flakes of each pixel sparkle or not.
    traced.footprint = 200 / (paint.flakes_per_mm2 * 1e6);
    traced.seed = run_seed();
    const reference::ExplicitResult flakes = reference::trace_explicit_flakes(traced);
    std::vector<Rgb<double>> pixels = flakes.radiance;
    Rgb<double> mean{}, square{};
    for (const Rgb<double>& pixel : pixels) mean = mean + pixel / double(kPixels);
    for (const Rgb<double>& pixel : pixels) square = square + (pixel - mean) * (pixel - mean);
    const Estimate expected{mean, map(square, [](double x) { return std::sqrt(x) / kPixels; })};

    DiscScene scene;
    scene.paint = paint;
    scene.light = traced.view;
    scene.detectors = {traced.light};
    scene.detector_radius = kRadius;
    scene.photons = 20'000 / kFewer;
    scene.layers = kLayers;
    scene.seed = run_seed();
    Estimate found = reference::trace_discs(scene).brdf[0].part[reference::single_flake];
    const double unit = std::pow(std::sin(kRadius) / (2 * std::sin(kRadius / 2)), 2) *
                        std::cos(degrees * kPi / 180);
    found = {found.mean * unit, found.error * unit};
    see(worst, found, expected,
        "D/H " + std::to_string(diameter) + " coverage " + std::to_string(coverage), 0.01);
  }
  worst.expect_at_most(student_threshold(3 * std::size(cases), kLayers));
}

// Of light that the substrate scatters straight back, exp(c k) times as much as by ways that share
// nothing (hot_spot.h): of level flakes but for tilts up to 0.2, also through two species. What the
// closed form errs is the scenes', and 4 of 50 runs of fresh ones err by more than the bar, by
// 0.059 at most. So these are the same in each run.
TEST(DiscWalk, TheSubstrateIsSeenByTheHolesItsLightComesBy) {
  Random random = same_scenes(1705);
  Worst worst;
  double most = 1;
  for (int k = 0; k < 6; ++k) {
    DiscScene scene;
    Paint& paint = scene.paint;
    paint.layer_thickness_um = 40;
    cover(paint, 40, random.log_uniform(0.15, 1.5), random.uniform(0.3, 1));
    paint.orientation = Orientation::beckmann;
    paint.tilt = random.uniform(0.05, 0.2);
    paint.flake_color = paint.flake_edge_color = {};
    if (k % 2 == 1) {
      FlakeSpecies& more = paint.more[0];
      more = paint;
      cover(more, 40, random.log_uniform(0.15, 1.5), 0.4);
    }
    scene.light = direction(40);
    scene.detectors = {direction(40), direction(20), direction(60), direction(0),
                       direction(40, kPi / 2)};
    scene.detector_radius = 0.02;
    scene.photons = 200'000;
    scene.layers = 128;
    scene.seed = random.bits();
    const DiscResult traced = reference::trace_discs(scene);
    reference::WalkScene apart{paint, scene.substrate, scene.light, scene.detectors, 200'000};
    const reference::WalkResult walked = reference::walk(apart);
    const auto layer = metallic_paint::make_layer<double>(paint);
    const auto inside = [&](Vec3<double> v) {
      return metallic_paint::eta_cos_refracted(v.z, layer.eta);
    };
    for (std::size_t i = 0; i < scene.detectors.size(); ++i) {
      const Vec3<double> view = scene.detectors[i];
      const double apart_by = metallic_paint::ways_apart(
          {0, 0, 1}, view, view.z, inside(view), scene.light, scene.light.z, inside(scene.light));
      const double more =
          std::exp(layer.shared_blocking.y * metallic_paint::holes_in_common(layer, apart_by));
      most = std::max(most, more);
      const Estimate& by_discs = traced.brdf[i].part[reference::substrate];
      const Estimate& by_walk = walked.brdf[i].part[reference::substrate];
      const double error =
          std::hypot(by_discs.error.y / by_discs.mean.y, by_walk.error.y / by_walk.mean.y);
      const double off = std::abs(by_walk.mean.y * more / by_discs.mean.y - 1);
      worst.see(std::max(off - 5 * error, 0.0), "off", off, "error", error, "more", more, "k", k,
                "i", i);
    }
  }
  worst.expect_at_most(0.05);
  EXPECT_GT(most, 1.5);
}

// Nothing but the substrate: Lambert's law under a smooth surface, in closed form.
TEST(DiscWalk, RepeatsItselfAndTakesNoFlakes) {
  DiscScene scene;
  scene.paint.flakes_per_mm2 = 0;
  scene.paint.binder_ior = 1;
  scene.detectors = {direction(30)};
  scene.photons = 20'000;
  scene.layers = 8;
  const DiscResult a = reference::trace_discs(scene), b = reference::trace_discs(scene);
  EXPECT_NEAR(a.brdf[0].total.mean.x, 0.8 / kPi, 1e-3);
  EXPECT_EQ(a.brdf[0].total.mean.x, b.brdf[0].total.mean.x);
  EXPECT_NEAR(a.albedo.part[reference::substrate].mean.x, 0.8, 1e-12);
  scene.paint.flakes_per_mm2 = 3000;
  const double before = reference::trace_discs(scene).albedo.total.mean.x;
  scene.seed = 1;
  EXPECT_NE(before, reference::trace_discs(scene).albedo.total.mean.x);
}

TEST(DiscWalk, ExtremePaintsGiveFiniteNumbers) {
  Random random = fresh(702);
  for (int k = 0; k < 60; ++k) {
    DiscScene scene;
    Paint& paint = scene.paint;
    const auto one_of = [&](std::vector<double> values) {
      return values[static_cast<std::size_t>(random.below(static_cast<int>(values.size())))];
    };
    paint.orientation = static_cast<Orientation>(random.below(3));
    paint.layer_thickness_um = one_of({1, 30, 1e3});
    cover(paint, paint.layer_thickness_um, one_of({0.3, 1, 100}), one_of({1e-9, 0.01, 1, 10}));
    paint.tilt = one_of({1e-6, 0.1, 1});
    paint.flake_area_spread = one_of({0, 1});
    paint.binder_ior = one_of({0.5, 1, 1 + 1e-9, 3});
    paint.binder_absorption_per_mm = grey(one_of({0, 1e6}));
    paint.rayleigh_per_mm = one_of({0, 1});
    scene.substrate = grey(one_of({0, 1}));
    scene.light = direction(one_of({0, 5, 45, 89.9}));
    scene.detectors = {direction(0), direction(88, 2)};
    scene.detector_radius = 0.02;
    scene.photons = 40;
    scene.layers = 2;
    scene.seed = random.bits();
    const DiscResult result = reference::trace_discs(scene);
    EXPECT_TRUE(std::isfinite(result.albedo.total.mean.x)) << "scene " << k;
    EXPECT_TRUE(std::isfinite(result.absorbed.mean.x)) << "scene " << k;
    for (const ByComponent& brdf : result.brdf) {
      EXPECT_TRUE(brdf.total.mean.x >= 0 && std::isfinite(brdf.total.mean.x)) << "scene " << k;
    }
  }
}

TEST(DiscWalk, RejectsScenesThatAreNone) {
  const auto expect_rejected = [](const std::string& field, const auto& change) {
    DiscScene scene;
    change(scene);
    try {
      reference::validate(scene);
      ADD_FAILURE() << field << " passed";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
    }
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  reference::validate(DiscScene{});
  expect_rejected("tilt", [](DiscScene& s) { s.paint.tilt = 0; });
  expect_rejected("layer_thickness_um", [](DiscScene& s) { s.paint.layer_thickness_um = 0; });
  expect_rejected("substrate.b", [=](DiscScene& s) { s.substrate.z = nan; });
  expect_rejected("light", [](DiscScene& s) { s.light = {0, 0, 2}; });
  expect_rejected("light.z", [](DiscScene& s) { s.light = {1, 0, 0}; });
  expect_rejected("light.z", [](DiscScene& s) { s.light = direction(89), s.light_radius = 0.1; });
  expect_rejected("light_radius", [=](DiscScene& s) { s.light_radius = nan; });
  expect_rejected("detector_radius", [](DiscScene& s) { s.detector_radius = 0; });
  expect_rejected("detectors[1].z", [](DiscScene& s) { s.detectors = {{0, 0, 1}, {0, 0, -1}}; });
  expect_rejected("number of detectors", [](DiscScene& s) { s.detectors.resize(4097, {0, 0, 1}); });
  expect_rejected("photons", [](DiscScene& s) { s.photons = 1; });
  expect_rejected("layers", [](DiscScene& s) { s.layers = 1; });
  expect_rejected("layers", [](DiscScene& s) { s.layers = 20, s.photons = 10; });
  expect_rejected("box", [](DiscScene& s) { s.box = 1; });
  expect_rejected("number of flakes", [](DiscScene& s) { s.paint.flakes_per_mm2 = 1e9; });
  expect_rejected("photons x ", [](DiscScene& s) { s.photons = 1'000'000'000'000; });
}

}  // namespace
}  // namespace core_tests
