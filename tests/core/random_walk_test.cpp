// SPDX-License-Identifier: Apache-2.0
//
// The random walk against what is known without it: energy, reciprocity, closed forms, the core's
// single scattering, and its two estimators against each other. Statistical tests have the level
// 1e-6 over all comparisons of a test, and other photons in each run of --all.
#include "reference/random_walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "flake_brdf.h"
#include "independent.h"
#include "photons.h"
#include "quadrature.h"
#include "scenes.h"
#include "sparkles.h"
#include "support.h"

namespace core_tests {
namespace {

using metallic_paint::grey;
using metallic_paint::Orientation;
using metallic_paint::Paint;
using metallic_paint::Rgb;
using metallic_paint::Vec3;
using metallic_paint::reference::ByComponent;
using metallic_paint::reference::Estimate;
using metallic_paint::reference::WalkResult;
using metallic_paint::reference::WalkScene;
namespace walk_reference = metallic_paint::reference;

constexpr double kPi = std::numbers::pi;

std::string text(const Paint& p) {
  std::ostringstream out;
  out << "[flakes/mm2 " << p.flakes_per_mm2 << ", orientation " << static_cast<int>(p.orientation)
      << ", tilt " << p.tilt << ", transmission " << p.flake_transmission.x << ", ior "
      << p.binder_ior << ", rayleigh " << p.rayleigh_per_mm << "]";
  return out.str();
}

// Flakes that absorb nothing, of other colours in reflection and in transmission.
Paint lossless(Orientation orientation, double tilt, double eta, double rayleigh) {
  Paint paint;
  paint.orientation = orientation;
  paint.tilt = tilt;
  paint.binder_ior = eta;
  paint.rayleigh_per_mm = rayleigh;
  paint.flake_color = paint.flake_edge_color = {0.5, 0.75, 1};
  paint.flake_transmission = {0.5, 0.25, 0};
  return paint;
}

// A detector where a flake of the normal n sends the light that comes from l in the binder, if the
// mirrored ray leaves the paint.
void add_detector(WalkScene& scene, Vec3<double> n, Vec3<double> l) {
  const double eta = scene.paint.binder_ior;
  const Vec3<double> v = n * (2 * dot(n, l)) - l;
  const double sine = eta * std::hypot(v.x, v.y);
  if (v.z <= 0 || sine > 0.98) return;
  scene.detectors.push_back({eta * v.x, eta * v.y, std::sqrt(1 - sine * sine)});
}

double refracted(double cosine, double eta) {
  return std::sqrt(std::max((eta - 1) * (eta + 1) + cosine * cosine, 0.0)) / eta;
}

double transmittance(double cosine, double eta) {
  const double angle = std::acos(std::min(cosine, 1.0));
  if (std::sin(angle) >= eta) return 0;
  return static_cast<double>(1 - independent::fresnel_reflectance(angle, eta));
}

// -------------------------------------------------------------------------------------------------
// Energy.

TEST(RandomWalk, LosesNothingInAWhiteFurnace) {
  Worst worst;
  int kind = 0;
  for (const double eta : {0.5, 1.0, 1.0001, 1.5, 2.5, 4.0}) {
    for (const double degrees : {0.0, 25.0, 50.0, 75.0, 89.9}) {
      for (const double rayleigh : {0.0, 3.0}) {
        WalkScene scene;
        scene.paint = lossless(static_cast<Orientation>(kind++ % 3), 0.15, eta, rayleigh);
        scene.paint.flake_color = scene.paint.flake_edge_color = grey(0.75);
        scene.paint.flake_transmission = grey(0.25);
        scene.substrate = grey(1.0);
        scene.light = direction(degrees);
        scene.photons = 200;
        const WalkResult result = walk_reference::walk(scene);
        EXPECT_EQ(result.truncated_walks, 0U);
        for (int i = 0; i < 3; ++i) {
          const double all = result.specular + channel(result.albedo.total.mean, i);
          worst.see(std::abs(all - 1), "eta", eta, "degrees", degrees, "rayleigh", rayleigh);
          worst.see(std::abs(channel(result.absorbed.mean, i)), "eta", eta, "degrees", degrees);
        }
      }
    }
  }
  // Each photon keeps its weight but for the rounding of hundreds of multiplications.
  worst.expect_at_most(1e-12);
}

// Titania on mica and on silica, and a third that is neither: R + T = 1 at every angle. Which way a
// photon goes is drawn so that the sum over its colours stays; each colour does so on average.
TEST(RandomWalk, LosesNothingBetweenPearls) {
  Random random = fresh(12);
  Worst sums, colours;
  const int scenes = 24;
  for (int k = 0; k < scenes; ++k) {
    WalkScene scene;
    scene.paint =
        lossless(static_cast<Orientation>(k % 3), 0.15, random.uniform(1, 2), k % 4 == 0 ? 0.3 : 0);
    for (std::size_t i = 0; i < 2; ++i) {
      auto& pearl = scene.paint.more[i];
      pearl = library_species(random, random.log_uniform(0.1, 3), random.log_uniform(0.03, 0.5));
      pearl.coating =
          static_cast<metallic_paint::CoatingKind>(metallic_paint::kFirstPearl + random.below(3));
    }
    // Two species or three, in any places.
    if (k % 3 == 0) scene.paint.more[0].flakes_per_mm2 = 0;
    if (k % 3 == 1) scene.paint.flakes_per_mm2 = 0;
    scene.substrate = grey(1.0);
    scene.light = direction(random.uniform(0, 85));
    scene.photons = 10'000;
    scene.seed = run_seed() + static_cast<std::uint64_t>(k);
    const WalkResult result = walk_reference::walk(scene);
    EXPECT_EQ(result.truncated_walks, 0U);
    const Rgb<double> all = result.albedo.total.mean + grey(result.specular);
    sums.see(std::abs(all.x + all.y + all.z - 3), "scene", k);
    sums.see(max_component(result.absorbed.mean), "scene", k);
    see(colours, all, result.albedo.total.error, grey(1.0), text(scene.paint));
  }
  sums.expect_at_most(1e-11, "sums");
  colours.expect_at_most(student_threshold(3 * scenes), "colours");
}

// Integral of BRDF cos over the hemisphere, the light's weights being those of next-event
// estimation: nothing makes it 1 but right phase functions, solid angles and attenuations.
TEST(RandomWalk, LongDetectorsSeeAllOfAWhiteFurnace) {
  constexpr int kSectors = 16, kRuns = 64;
  const auto& rule = metallic_paint::gauss_rule<float>();  // 12 nodes suffice
  Worst worst;
  const double etas[5] = {0.7, 1, 1.5, 2.5, 4}, degrees[5] = {40, 0, 75, 89, 40};
  for (int k = 0; k < 5; ++k) {
    const double eta = etas[k];
    WalkScene scene;
    scene.paint = lossless(static_cast<Orientation>(k % 3), 0.5, eta, k % 2 == 0 ? 3 : 0);
    scene.substrate = grey(1.0);
    scene.light = direction(degrees[k]);
    scene.photons = 250;
    // cos(theta) dw = eta^2 cos(theta_p) dw_p (Snell); x^2 = (cos(theta_p) - critical)/(1 -
    // critical) makes the surface's transmittance smooth. Halves of the azimuth mirror each other.
    std::vector<double> weight;
    const double critical = eta > 1 ? std::sqrt(1 - 1 / (eta * eta)) : 0;
    for (int i = 0; i < metallic_paint::kGaussPoints<float>; ++i) {
      const double x = rule.node[static_cast<std::size_t>(i)];
      const double cos_in = critical + (1 - critical) * x * x;
      const double d_cos = 2 * (1 - critical) * x * rule.weight[static_cast<std::size_t>(i)];
      const double sine = eta * std::sqrt(1 - cos_in * cos_in);
      for (int j = 0; j < kSectors / 2; ++j) {
        const double phi = (j + 0.5) * 2 * kPi / kSectors;
        scene.detectors.push_back(
            {sine * std::cos(phi), sine * std::sin(phi), std::sqrt((1 - sine) * (1 + sine))});
        weight.push_back(eta * eta * cos_in * d_cos * 2 * (2 * kPi / kSectors));
      }
    }
    Rgb<double> sum{}, square{};
    double specular = 0;
    for (int run = 0; run < kRuns; ++run) {
      scene.seed = run_seed() + static_cast<std::uint64_t>(100 * k + run);
      const WalkResult result = walk_reference::walk(scene);
      Rgb<double> seen{};
      for (std::size_t i = 0; i < weight.size(); ++i) {
        seen = seen + result.brdf[i].total.mean * weight[i];
      }
      specular = result.specular;
      sum = sum + seen, square = square + seen * seen;
    }
    const Rgb<double> mean = sum / static_cast<double>(kRuns);
    const Rgb<double> error = map(square / static_cast<double>(kRuns) - mean * mean, [](double x) {
      return std::sqrt(std::max(x, 0.0) / (kRuns - 1));
    });
    see(worst, mean, error, grey(1 - specular), text(scene.paint));
    EXPECT_LE(max_component(error), 0.02);  // or the test would say little
  }
  worst.expect_at_most(student_threshold(5 * 3, kRuns));
}

TEST(RandomWalk, WhatDoesNotComeBackIsAbsorbed) {
  Worst worst;
  Random random = fresh(7);
  const int scenes = 12;
  for (int k = 0; k < scenes; ++k) {
    WalkScene scene;
    const double eta = random.uniform(0.8, 2), rayleigh = random.uniform(0, 1);
    scene.paint = lossless(static_cast<Orientation>(k % 3), 0.15, eta, rayleigh);
    scene.substrate = grey(1.0);
    if (k % 2 == 0) {
      scene.paint.flake_transmission = {0, 0.05, 0.1};
      scene.paint.flake_color = {0.9, 0.6, 0.3};
      scene.paint.flake_edge_color = {0.9, 0.8, 0.7};
      scene.paint.binder_absorption_per_mm = {0, 10, 50};
      scene.substrate = {0.9, 0.5, 0};
    }
    scene.light = direction(random.uniform(0, 50));
    scene.photons = 10'000;
    scene.seed = run_seed() + static_cast<std::uint64_t>(k);
    const WalkResult result = walk_reference::walk(scene);
    const Rgb<double> all = result.albedo.total.mean + result.absorbed.mean;
    // The error of a sum is at most the sum of the errors.
    see(worst, all, result.albedo.total.error + result.absorbed.error, grey(1 - result.specular),
        text(scene.paint));
  }
  worst.expect_at_most(student_threshold(3 * scenes));
}

TEST(RandomWalk, LightThatIsStillUnderWayIsCounted) {
  WalkScene scene;
  scene.paint.flakes_per_mm2 = 0;
  scene.paint.rayleigh_per_mm = 1e6;
  scene.paint.layer_thickness_um = 1e6;
  scene.paint.binder_ior = 10;
  scene.photons = 20;
  const WalkResult result = walk_reference::walk(scene);
  EXPECT_GT(result.truncated_walks, 0U);
  EXPECT_NEAR(result.truncated.mean.x / (1 - result.specular),
              static_cast<double>(result.truncated_walks) / 20, 1e-12);
  EXPECT_NEAR(result.specular + result.albedo.total.mean.x + result.truncated.mean.x, 1, 1e-12);
}

// -------------------------------------------------------------------------------------------------
// Closed forms.

// Only the substrate scatters: with Q = <T> and R = <r> of its light at the surface, there and
// back, the albedo is T e^(-k/c) rho Q (1 + rho R + ...) and its first term's BRDF rho/(pi eta^2) T
// T' e^(-k/c - k/c').
TEST(RandomWalk, SubstrateUnderAnAbsorbingBinder) {
  Worst worst, exact;
  const Rgb<double> rho{0.8, 1, 0.5};
  int tests = 0;
  for (const double eta : {0.7, 1.0, 1.5, 2.5}) {
    for (const double degrees : {0.0, 40.0, 80.0}) {
      // The dark binder brings every photon down to Russian roulette.
      const bool dark = degrees == 40;
      const Rgb<double> absorption = dark ? Rgb<double>{120, 150, 200} : Rgb<double>{0, 5, 40};
      WalkScene scene;
      scene.paint.flakes_per_mm2 = 0;
      scene.paint.binder_ior = eta;
      scene.paint.binder_absorption_per_mm = absorption;
      scene.substrate = rho;
      scene.light = direction(degrees);
      scene.detectors = {direction(20), direction(60, 2)};
      scene.photons = 50'000;
      scene.seed = run_seed() + static_cast<std::uint64_t>(tests++);
      const WalkResult result = walk_reference::walk(scene);

      const double entered = transmittance(scene.light.z, eta);
      const double cos_in = refracted(scene.light.z, eta);
      EXPECT_NEAR(result.specular, 1 - entered, 1e-12);
      Rgb<double> albedo{};
      double* const channels[3] = {&albedo.x, &albedo.y, &albedo.z};
      for (int i = 0; i < 3; ++i) {
        const double depth = channel(absorption, i) * 0.03;
        const auto over_cosines = [&](const std::function<long double(double)>& f) {
          const double critical = eta > 1 ? std::sqrt(1 - 1 / (eta * eta)) : 0;
          return static_cast<double>(independent::integrate(
              [&](independent::Real c) { return 2 * c * f(static_cast<double>(c)); },
              {0, critical, 1}));
        };
        const double out = over_cosines([&](double c) {
          return transmittance(refracted(c, 1 / eta), eta) * std::exp(-depth / c);
        });
        const double back = over_cosines([&](double c) {
          return (1 - transmittance(refracted(c, 1 / eta), eta)) * std::exp(-2 * depth / c);
        });
        const double r = channel(rho, i);
        if (entered > 0) {
          *channels[i] = entered * std::exp(-depth / cos_in) * r * out / (1 - r * back);
        }
        for (std::size_t d = 0; d < scene.detectors.size(); ++d) {
          const double cosine = scene.detectors[d].z, through = transmittance(cosine, eta);
          double brdf = 0;
          if (entered > 0 && through > 0) {
            brdf = r / (kPi * eta * eta) * entered * through *
                   std::exp(-depth / cos_in - depth / refracted(cosine, eta));
          }
          const auto& part = result.brdf[d].part;
          exact.see(std::abs(channel(part[walk_reference::substrate].mean, i) - brdf), "eta", eta,
                    "degrees", degrees);
          EXPECT_EQ(channel(part[walk_reference::single_flake].mean, i), 0);
        }
      }
      see(worst, result.albedo.total.mean, result.albedo.total.error, albedo,
          text(scene.paint) + " degrees " + std::to_string(degrees));
    }
  }
  worst.expect_at_most(student_threshold(3 * tests));
  exact.expect_at_most(1e-12, "direct");
}

// One flake, and one reflection by the substrate behind flakes, against the core.
TEST(RandomWalk, SingleScatteringIsTheCoresFlakeBrdf) {
  Worst flakes, direct;
  Random random = fresh(11);
  const int scenes = 45, detectors = 3;
  for (int k = 0; k < scenes; ++k) {
    WalkScene scene;
    Paint& paint = scene.paint;
    paint.orientation = static_cast<Orientation>(k % 3);
    paint.tilt = random.log_uniform(0.03, 0.6);
    paint.flakes_per_mm2 = 1000;
    const double coverage = random.log_uniform(0.1, 3);
    paint.flake_diameter_um = 1e3 * std::sqrt(coverage / 1000 * 4 / kPi);
    paint.flake_area_spread = random.uniform(0, 0.8);
    paint.flake_color = {0.3, 0.6, 0.85};
    paint.flake_edge_color = {0.5, 0.7, 0.9};
    if (k % 2 == 0) paint.flake_transmission = {0.5, 0.3, 0.1};
    paint.binder_ior = k % 5 == 0 ? random.uniform(0.7, 1) : random.uniform(1, 2.5);
    paint.binder_absorption_per_mm = {0, 10, 30};
    paint.rayleigh_per_mm = k % 4 == 0 ? 1 : 0;
    scene.substrate = {0.9, 0.5, 0.2};
    const double eta = paint.binder_ior;
    // Light and detectors by way of flakes that occur.
    const double limit = eta < 1 ? std::asin(eta) * 180 / kPi : 90;
    const auto outside = [&](double least) {
      return direction(random.uniform(least, 0.95 * limit), random.uniform(0, 2 * kPi));
    };
    scene.light = outside(0);
    const Vec3<double> l{scene.light.x / eta, scene.light.y / eta, refracted(scene.light.z, eta)};
    while (scene.detectors.size() < detectors) {
      const Vec3<double> n = direction(random.uniform(0, 2 * std::min(paint.tilt, 0.5)) * 180 / kPi,
                                       random.uniform(0, 2 * kPi));
      add_detector(scene, n, l);
    }
    scene.photons = 20'000;
    scene.seed = run_seed() + static_cast<std::uint64_t>(k);
    const WalkResult result = walk_reference::walk(scene);

    paint.depth_model = DepthModel::attenuated;
    const auto layer = metallic_paint::make_layer<double>(paint);
    for (std::size_t i = 0; i < detectors; ++i) {
      const Vec3<double> view = scene.detectors[i];
      const ByComponent& brdf = result.brdf[i];
      const auto& flake = brdf.part[walk_reference::single_flake];
      see(flakes, flake.mean, flake.error,
          metallic_paint::flake_brdf(layer, {0, 0, 1}, view, scene.light), text(paint));
      const Rgb<double> slant =
          metallic_paint::slant_depth_of(layer, refracted(view.z, eta)) +
          metallic_paint::slant_depth_of(layer, refracted(scene.light.z, eta));
      const double surface = transmittance(view.z, eta) * transmittance(scene.light.z, eta);
      const auto& back = brdf.part[walk_reference::substrate];
      see(direct, back.mean, back.error,
          scene.substrate * map(slant, [](double x) { return std::exp(-x); }) *
              (surface / (kPi * eta * eta)),
          text(paint));
    }
  }
  flakes.expect_at_most(student_threshold(2 * 3 * scenes * detectors), "flakes");
  direct.expect_at_most(student_threshold(2 * 3 * scenes * detectors), "substrate");
}

// Two or three species with coatings of the library. The core's optical depth lets four flakes
// stand for all that a ray meets; `exact` has all of them in its place, and the core itself is
// within what that does to (1 - e^-x)/x, whose logarithm has a slope of 1/2 at most.
TEST(RandomWalk, SingleScatteringOfSeveralSpeciesIsTheCoresFlakeBrdf) {
  using metallic_paint::CoatingKind;
  Worst exact, core;
  Random random = fresh(13);
  const int scenes = 40, detectors = 3;
  for (int k = 0; k < scenes; ++k) {
    WalkScene scene;
    Paint& paint = scene.paint;
    const auto tilt = [&] { return random.log_uniform(0.04, 0.5); };
    const auto coverage = [&] { return random.log_uniform(0.1, 1.5); };
    for (auto& more : paint.more) more = library_species(random, coverage(), tilt());
    static_cast<metallic_paint::FlakeSpecies&>(paint) = library_species(random, coverage(), tilt());
    if (k % 2 == 0) {
      paint.coating = CoatingKind::colors;
      paint.flake_color = {0.3, 0.6, 0.8};
      paint.flake_edge_color = {0.5, 0.7, 0.8};
      paint.flake_transmission = {0.5, 0.3, 0.1};
    }
    if (k % 3 == 0) paint.more[k % 2 == 0 ? 0 : 1].flakes_per_mm2 = 0;
    paint.binder_ior = random.uniform(1.41, 2);  // cosines from 0.7 in the binder
    paint.binder_absorption_per_mm = {0, 10, 30};
    paint.rayleigh_per_mm = k % 4 == 0 ? 1 : 0;
    scene.substrate = {};
    const double eta = paint.binder_ior;
    scene.light = direction(random.uniform(0, 80), random.uniform(0, 2 * kPi));
    const Vec3<double> l{scene.light.x / eta, scene.light.y / eta, refracted(scene.light.z, eta)};
    while (scene.detectors.size() < detectors) {
      const auto species = static_cast<int>(scene.detectors.size());
      const Vec3<double> n =
          direction(random.uniform(0, 2 * paint.species(species).tilt) * 180 / kPi,
                    random.uniform(0, 2 * kPi));
      add_detector(scene, n, l);
    }
    scene.photons = 20'000;
    scene.seed = run_seed() + static_cast<std::uint64_t>(k);
    const WalkResult result = walk_reference::walk(scene);

    paint.depth_model = DepthModel::attenuated;
    const auto layer = metallic_paint::make_layer<double>(paint);
    const auto mean = [](Rgb<double> x) {
      return map(x, [](double d) { return d > 0 ? -std::expm1(-d) / d : 1; });
    };
    for (std::size_t i = 0; i < detectors; ++i) {
      const Vec3<double> view = scene.detectors[i];
      const double cosines[2] = {refracted(view.z, eta), l.z};
      Rgb<double> depth{}, closed{};
      double slack = 0;
      for (double cosine : cosines) {
        depth = depth + exact_slant_depth(layer, cosine);
        closed = closed + metallic_paint::slant_depth_of(layer, cosine);
        for (int s = 0; s < metallic_paint::kSpecies; ++s) {
          const auto& flakes = layer.flakes[static_cast<std::size_t>(s)];
          const auto kind = flakes.coating.kind;
          if (!metallic_paint::is_clear(kind)) continue;
          const bool mica = kind == CoatingKind::tio2_on_mica || kind == CoatingKind::fe2o3_on_mica;
          const bool narrow = flakes.orientation.tilt <= 0.2;
          const double error = mica ? (narrow ? 0.008 : 0.03) : (narrow ? 0.04 : 0.1);
          slack += flakes.coverage * error / cosine / 2;
        }
      }
      const Rgb<double> brdf = metallic_paint::flake_brdf(layer, {0, 0, 1}, view, scene.light);
      const Rgb<double> expected =
          brdf * mean(depth) * map(mean(closed), [](double x) { return 1 / x; });
      const Estimate& flake = result.brdf[i].part[walk_reference::single_flake];
      see(exact, flake.mean, flake.error, expected, text(paint));
      for (int c = 0; c < 3; ++c) {
        core.see(
            std::abs(std::log(channel(expected, c) / channel(brdf, c))) / std::max(slack, 1e-12),
            "scene", k, "detector", i, "slack", slack);
      }
    }
  }
  exact.expect_at_most(student_threshold(3 * scenes * detectors), "exact");
  core.expect_at_most(1, "core");  // in units of the stated error
}

// f = s phase (1 - e^-t)/t T T'/(eta^2 c c') of single scattering, s the depth of the layer. More
// scatterings add less than 2 s (1 + ln(1/s)): an even spread of directions crosses the layer
// (twice, with internal reflection) along 1/c, hence the logarithm, and Rayleigh's phase function
// is at most 1.5 of the even one.
TEST(RandomWalk, ThinPigmentScattersOnce) {
  Worst worst;
  const double depth = 1e-3;
  const std::vector<double> angles{0, 1, 2, 3};
  for (const double eta : {1.0, 1.5}) {
    WalkScene scene;
    scene.paint.flakes_per_mm2 = 0;
    scene.paint.binder_ior = eta;
    scene.paint.layer_thickness_um = 1000;
    scene.paint.rayleigh_per_mm = depth * 3 / (16 * kPi);
    scene.substrate = {};
    scene.light = direction(60);
    for (const double phi : angles) scene.detectors.push_back(direction(70, phi));
    scene.photons = 4'000'000;
    scene.seed = run_seed();
    const WalkResult result = walk_reference::walk(scene);
    const double c_light = refracted(0.5, eta);
    for (std::size_t i = 0; i < angles.size(); ++i) {
      const Vec3<double> o = scene.detectors[i];
      const double c = refracted(o.z, eta);
      const double between =
          -((o.x * scene.light.x + o.y * scene.light.y) / (eta * eta) + c * c_light);
      const double t = depth * (1 / c + 1 / c_light);
      const double f = depth * 3 / (16 * kPi) * (1 + between * between) * -std::expm1(-t) / t *
                       transmittance(0.5, eta) * transmittance(o.z, eta) /
                       (eta * eta * c * c_light);
      const Estimate& found = result.brdf[i].total;
      see(worst, found.mean, found.error, grey(f), text(scene.paint),
          grey(3 * depth * (1 - std::log(depth)) * f));
      EXPECT_LE(found.error.x, 0.02 * f);
    }
  }
  worst.expect_at_most(student_threshold(2 * 4));
}

// -------------------------------------------------------------------------------------------------
// Consistency.

TEST(RandomWalk, LightAndDetectorMayChangePlaces) {
  Worst worst;
  const std::vector<Vec3<double>> places{direction(15, 1), direction(45, 4), direction(70, 2.4)};
  int tests = 0;
  for (const double eta : {0.95, 1.6}) {
    WalkScene scene;
    scene.paint = lossless(eta < 1 ? Orientation::ggx : Orientation::gaussian, 0.4, eta, 1);
    scene.paint.flake_color = {0.4, 0.7, 0.9};
    scene.paint.binder_absorption_per_mm = {0, 5, 10};
    scene.detectors = places;
    scene.photons = 40'000;
    std::vector<WalkResult> results;
    for (const Vec3<double>& light : places) {
      scene.light = light;
      scene.seed = run_seed() + static_cast<std::uint64_t>(tests) + results.size();
      results.push_back(walk_reference::walk(scene));
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const Estimate a = results[i].brdf[j].part[walk_reference::mixture];
        const Estimate b = results[j].brdf[i].part[walk_reference::mixture];
        const Rgb<double> error =
            map(a.error * a.error + b.error * b.error, [](double x) { return std::sqrt(x); });
        see(worst, a.mean, error, b.mean, text(scene.paint));
        tests += 3;
      }
    }
  }
  worst.expect_at_most(student_threshold(tests));
}

// The photons that leave through a bin, counted, and the same from detectors inside the bin.
void expect_detectors_agree_with_counts(WalkScene counted) {
  constexpr int kTheta = 3, kPhi = 6, kNodes = 3;
  const double node[kNodes] = {0.5 - std::sqrt(0.15), 0.5, 0.5 + std::sqrt(0.15)};  // Gauss
  const double weight[kNodes] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  WalkScene seen = counted;
  counted.theta_bins = kTheta, counted.phi_bins = kPhi;
  for (int i = 0; i < kTheta * kNodes; ++i) {
    for (int j = 0; j < kPhi * kNodes; ++j) {
      const double cosine = (i / kNodes + node[i % kNodes]) / kTheta;
      const double phi = 2 * kPi * (j / kNodes + node[j % kNodes]) / kPhi;
      const double sine = std::sqrt(1 - cosine * cosine);
      seen.detectors.push_back({sine * std::cos(phi), sine * std::sin(phi), cosine});
    }
  }
  seen.photons = counted.photons / 10;
  counted.seed = run_seed();
  seen.seed = counted.seed + 1;
  const WalkResult bins = walk_reference::walk(counted), detectors = walk_reference::walk(seen);
  std::vector<Estimate> expected(kTheta * kPhi);
  for (int i = 0; i < kTheta * kNodes; ++i) {
    for (int j = 0; j < kPhi * kNodes; ++j) {
      const auto at = static_cast<std::size_t>(i * kPhi * kNodes + j);
      const double solid_angle =
          2 * kPi / (kTheta * kPhi) * weight[i % kNodes] * weight[j % kNodes];
      Estimate& cell = expected[static_cast<std::size_t>(i / kNodes * kPhi + j / kNodes)];
      const Estimate& brdf = detectors.brdf[at].total;
      cell.mean = cell.mean + brdf.mean * (solid_angle * seen.detectors[at].z);
      // The detectors of a bin see much the same photons: their errors add up.
      cell.error = cell.error + brdf.error * (solid_angle * seen.detectors[at].z);
    }
  }
  Worst worst;
  Rgb<double> sum{};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Estimate& bin = bins.bins[i];
    const Rgb<double> error = map(bin.error * bin.error + expected[i].error * expected[i].error,
                                  [](double x) { return std::sqrt(x); });
    see(worst, bin.mean, error, expected[i].mean, "bin " + std::to_string(i));
    sum = sum + bin.mean;
  }
  worst.expect_at_most(student_threshold(3 * kTheta * kPhi));
  EXPECT_NEAR(sum.x, bins.albedo.total.mean.x, 1e-12);
  EXPECT_NEAR(sum.z, bins.albedo.total.mean.z, 1e-12);
}

TEST(RandomWalk, DetectorsAgreeWithCountedPhotonsAboutFlakes) {
  WalkScene scene;
  scene.paint = lossless(Orientation::beckmann, 0.6, 1.5, 0);
  scene.paint.flake_color = {0.4, 0.7, 0.9};
  scene.light = direction(40, 0.4);
  scene.photons = 150'000;
  expect_detectors_agree_with_counts(scene);
}

// Its phase function in full: no refraction, and nothing else that scatters.
TEST(RandomWalk, DetectorsAgreeWithCountedPhotonsAboutPigment) {
  WalkScene scene;
  scene.paint.flakes_per_mm2 = 0;
  scene.paint.binder_ior = 1;
  scene.paint.rayleigh_per_mm = 0.7;
  scene.substrate = {};
  scene.light = direction(60);
  scene.photons = 400'000;
  expect_detectors_agree_with_counts(scene);
}

TEST(RandomWalk, ComponentsAddUp) {
  WalkScene scene;
  scene.detectors = {direction(30)};
  scene.photons = 1000;
  const WalkResult result = walk_reference::walk(scene);
  for (const ByComponent& all : {result.albedo, result.brdf[0]}) {
    const Rgb<double> sum = all.part[0].mean + all.part[1].mean + all.part[2].mean;
    EXPECT_NEAR(sum.x, all.total.mean.x, 1e-13);
    for (const Estimate& part : all.part) EXPECT_GT(part.mean.x, 0);
  }
}

TEST(RandomWalk, RepeatsItselfBitForBit) {
  WalkScene scene;
  scene.detectors = {direction(30)};
  scene.photons = 5000;
  const WalkResult a = walk_reference::walk(scene), b = walk_reference::walk(scene);
  EXPECT_EQ(a.albedo.total.mean.x, b.albedo.total.mean.x);
  EXPECT_EQ(a.albedo.total.error.x, b.albedo.total.error.x);
  EXPECT_EQ(a.brdf[0].total.mean.x, b.brdf[0].total.mean.x);
  scene.seed = 1;
  EXPECT_NE(a.albedo.total.mean.x, walk_reference::walk(scene).albedo.total.mean.x);
}

// -------------------------------------------------------------------------------------------------
// Limits.

TEST(RandomWalk, TotalReflectionLetsNothingIn) {
  WalkScene scene;
  scene.paint.binder_ior = 0.5;
  scene.light = direction(60);
  scene.detectors = {direction(0)};
  const WalkResult result = walk_reference::walk(scene);
  EXPECT_EQ(result.specular, 1);
  EXPECT_EQ(result.albedo.total.mean.x, 0);
  EXPECT_EQ(result.brdf[0].total.mean.x, 0);
}

TEST(RandomWalk, ExtremePaintsGiveFiniteNumbers) {
  Random random = fresh(5);
  for (int k = 0; k < 60; ++k) {
    WalkScene scene;
    Paint& paint = scene.paint;
    const auto one_of = [&](std::vector<double> values) {
      return values[static_cast<std::size_t>(random.below(static_cast<int>(values.size())))];
    };
    paint.orientation = static_cast<Orientation>(random.below(3));
    const bool gaussian = paint.orientation == Orientation::gaussian;
    paint.tilt = one_of({1e-6, 0.1, gaussian ? 100.0 : 1.0});
    paint.flakes_per_mm2 = one_of({0, 1e-9, 3000, 1e9});
    paint.flake_diameter_um = one_of({1e-3, 20, 1e5});
    paint.flake_area_spread = one_of({0, 100});
    paint.flake_color = grey(one_of({0, 0.5}));
    paint.flake_transmission = grey(0.0);
    paint.flake_edge_color = grey(one_of({0, 0.5}));
    paint.binder_ior = one_of({0.1, 1, 1 + 1e-9, 10});
    paint.layer_thickness_um = one_of({0, 30, 1e6});
    paint.binder_absorption_per_mm = grey(one_of({1e-3, 1e6}));
    paint.rayleigh_per_mm = one_of({0, 1, 1e6});
    scene.substrate = grey(one_of({0, 1}));
    scene.light = direction(one_of({0, 5, 45, 89.99999}));
    scene.detectors = {direction(0), scene.light, direction(89.9999, 2)};
    scene.photons = 20;
    const WalkResult result = walk_reference::walk(scene);
    EXPECT_TRUE(std::isfinite(result.albedo.total.mean.x)) << text(paint);
    EXPECT_TRUE(std::isfinite(result.absorbed.mean.x)) << text(paint);
    EXPECT_TRUE(result.specular >= 0 && result.specular <= 1) << text(paint);
    for (const ByComponent& brdf : result.brdf) {
      EXPECT_TRUE(brdf.total.mean.x >= 0 && std::isfinite(brdf.total.mean.x)) << text(paint);
    }
  }
}

// Where nothing absorbs, photons walk longest. The bound is one of their mean: in a deep layer a
// few photons make most of the steps, so that 300 are far from it.
TEST(RandomWalk, PhotonsTakeNoMoreStepsThanTheirBound) {
  Random random = fresh(61);
  Worst worst;
  constexpr int kScenes = 40, kRuns = 30;
  for (int k = 0; k < kScenes; ++k) {
    WalkScene scene;
    Paint& paint = scene.paint;
    paint.orientation = static_cast<Orientation>(random.below(3));
    paint.tilt = random.log_uniform(0.01, 1);
    paint.flakes_per_mm2 = random.below(3) == 0 ? 0 : random.log_uniform(10, 1e5);
    paint.flake_color = paint.flake_edge_color = grey(1.0);
    paint.flake_transmission = grey(0.0);
    paint.binder_ior = random.below(3) == 0 ? random.uniform(0.5, 1) : random.uniform(1, 3);
    paint.rayleigh_per_mm = random.below(3) == 0 ? 0 : random.log_uniform(0.1, 1e6);
    scene.substrate = grey(1.0);
    scene.light = direction(random.uniform(0, 80));
    scene.photons = 10;
    const double most = walk_reference::most_steps_of_a_photon(paint);
    Moments above{most};
    for (int run = 0; run < kRuns; ++run) {
      scene.seed = random.bits();
      const auto steps = static_cast<double>(walk_reference::walk(scene).steps);
      above.add(steps / static_cast<double>(scene.photons));
    }
    const double mean = above.mean() - most;
    const double error = std::sqrt((above.variance() - mean * mean) / (kRuns - 1));
    worst.see(mean > 0 ? mean / error : 0, "at", text(paint));
  }
  worst.expect_at_most(student_threshold(kScenes, kRuns));
}

TEST(RandomWalk, RejectsScenesThatAreNone) {
  const auto expect_rejected = [](const std::string& field, const auto& change) {
    WalkScene scene;
    change(scene);
    try {
      walk_reference::validate(scene);
      ADD_FAILURE() << field << " passed";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
    }
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_rejected("tilt", [](WalkScene& s) { s.paint.tilt = 0; });
  expect_rejected("substrate.g", [](WalkScene& s) { s.substrate.y = 1.1; });
  expect_rejected("substrate.b", [=](WalkScene& s) { s.substrate.z = nan; });
  expect_rejected("light", [](WalkScene& s) { s.light = {0, 0, 2}; });
  expect_rejected("light.z", [](WalkScene& s) { s.light = {1, 0, 0}; });
  expect_rejected("detectors[1]", [](WalkScene& s) { s.detectors = {{0, 0, 1}, {0, 0, 3}}; });
  expect_rejected("detectors[1].z", [](WalkScene& s) { s.detectors = {{0, 0, 1}, {0, 0, -1}}; });
  expect_rejected("number of detectors", [](WalkScene& s) { s.detectors.resize(4097, {0, 0, 1}); });
  expect_rejected("photons", [](WalkScene& s) { s.photons = 1; });
  expect_rejected("photons x (1 + number of detectors) x ",
                  [](WalkScene& s) { s.photons = 1'000'000'000'000; });
  expect_rejected("photons x (1 + number of detectors) x ", [](WalkScene& s) {
    s.photons = 100'000'000;
    s.detectors.resize(4096, {0, 0, 1});
  });
  expect_rejected("photons x (1 + number of detectors) x ", [](WalkScene& s) {
    s.photons = 1'000'000'000;
    s.paint.rayleigh_per_mm = 1e6;
  });
  expect_rejected("theta_bins", [](WalkScene& s) { s.theta_bins = 4; });
  expect_rejected("theta_bins", [](WalkScene& s) { s.theta_bins = 4, s.phi_bins = -1; });
  expect_rejected("theta_bins", [](WalkScene& s) { s.theta_bins = s.phi_bins = 200; });
}

}  // namespace
}  // namespace core_tests
