// SPDX-License-Identifier: Apache-2.0
//
// The whole paint under uniform light: nothing is lost in a lossless paint, and the random walk
// agrees within the stated error.
#include "mixture.h"

#include <cfenv>
#include <cmath>
#include <vector>

#include "flake_lobe.h"
#include "reference/random_walk.h"
#include "scenes.h"
#include "support.h"

namespace {

using namespace core_tests;

template <class T>
Rgb<T> albedo_of(const Paint& paint, Rgb<double> substrate, double cos_view) {
  const Mixture<T> m = mixture(make_layer<T>(paint), Rgb<T>(substrate), static_cast<T>(cos_view));
  return m.diffuse + m.glossy;
}

double surface_of(const Paint& paint, double cos_view) {
  const double eta = paint.binder_ior;
  return 1 - fresnel_transmittance(cos_view, eta_cos_refracted(cos_view, eta), eta);
}

// E(v): the lobe that the shader renders, by the rectangle rule over its two deviates.
Rgb<double> single_scattering(const Paint& paint, double cos_view) {
  const Layer<double> layer = make_layer<double>(paint);
  const Vec3<double> view{std::sqrt(1 - cos_view * cos_view), 0, cos_view};
  constexpr int kTilts = 400, kAzimuths = 100;
  Rgb<double> sum{};
  for (int i = 0; i < kTilts; ++i) {
    for (int j = 0; j < kAzimuths; ++j) {
      sum = sum +
            sample_flake<double>(layer, {0, 0, 1}, view, (i + 0.5) / kTilts, (j + 0.5) / kAzimuths)
                .weight;
    }
  }
  return sum / double{kTilts * kAzimuths};
}

// Ordinary paints, as mixture.h states its error for.
Paint ordinary_paint(Random& random, bool lossless) {
  const auto colour = [&](double from, double to) {
    return Rgb<double>{random.uniform(from, to), random.uniform(from, to),
                       random.uniform(from, to)};
  };
  Paint paint = undiffracted();
  paint.flake_diameter_um = 10;
  paint.flake_area_spread = 0;
  paint.flakes_per_mm2 = random.log_uniform(0.05, 5) * 4e4 / std::numbers::pi;
  paint.orientation = static_cast<Orientation>(random.below(3));
  paint.tilt = random.log_uniform(0.02, 0.6);
  paint.binder_ior = random.uniform(1.33, 1.8);
  paint.layer_thickness_um = 100;
  // Metal or pearl.
  if (random.below(2) == 0) paint.flake_transmission = colour(0.05, 0.9);
  const Rgb<double> most = grey(1.0) - paint.flake_transmission;
  paint.flake_color = lossless ? most : most * colour(0.1, 1);
  paint.flake_edge_color = lossless ? most : most * colour(0.4, 1);
  if (!lossless && random.below(2) == 0) paint.binder_absorption_per_mm = colour(0, 10);
  if (random.below(3) == 0) paint.rayleigh_per_mm = random.log_uniform(0.03, 1);
  return paint;
}

// Likewise, of one to three species with coatings of the library.
Paint library_paint(Random& random) {
  Paint paint = ordinary_paint(random, false);
  const int used = 1 + random.below(3);
  const double coverage = random.log_uniform(0.05, 5) / used;
  const auto species = [&] {
    return library_species(random, coverage * random.uniform(0.5, 1.5),
                           random.log_uniform(0.02, 0.6));
  };
  static_cast<FlakeSpecies&>(paint) = species();
  for (int i = 1; i < used; ++i) paint.more[static_cast<std::size_t>(i - 1)] = species();
  return paint;
}

// r_s + E + M - 1 over a white substrate.
void see_furnace(Worst& worst, const Paint& paint, double cos_view) {
  const Rgb<double> e = single_scattering(paint, cos_view);
  const Rgb<double> m = albedo_of<double>(paint, grey(1.0), cos_view);
  const Rgb<double> all = grey(surface_of(paint, cos_view)) + e + m;
  TestScene scene;
  scene.paint = paint;
  for (double x : {all.x, all.y, all.z}) worst.see(std::fabs(x - 1), "cos view", cos_view, scene);
}

TEST(Mixture, ALosslessPaintReflectsEverything) {
  Random random(90);
  Worst worst;
  for (int i = 0; i < 100 / std::min(kFewer, 4); ++i) {
    const Paint paint = ordinary_paint(random, true);
    see_furnace(worst, paint, i % 4 == 0 ? 1 : random.uniform(0.05, 1));
  }
  worst.expect_at_most(0.01, "furnace");
}

// Titania on mica, and on silica, where what a pearl lets through changes faster with the angle
// than the two directions see that stand for all that leave.
TEST(Mixture, ALosslessPearlReflectsEverything) {
  Random random(95);
  Worst mica, silica;
  for (int i = 0; i < 90 / std::min(kFewer, 4); ++i) {
    Paint paint = library_paint(random);
    paint.binder_absorption_per_mm = {};
    const bool on_mica = i % 2 == 0;
    const auto pearl = [&](FlakeSpecies& flakes) {
      flakes.coating = on_mica                ? CoatingKind::tio2_on_mica
                       : random.below(2) == 0 ? CoatingKind::tio2_on_silica
                                              : CoatingKind::tio2_on_thin_silica;
    };
    pearl(paint);
    for (FlakeSpecies& more : paint.more) pearl(more);
    see_furnace(on_mica ? mica : silica, paint, i % 3 == 0 ? 1 : random.uniform(0.05, 1));
  }
  mica.expect_at_most(0.01, "mica");
  silica.expect_at_most(0.02, "silica");
}

template <class MakePaint>
void expect_the_walk(std::uint64_t seed, const MakePaint& make_paint) {
  Random random(seed);
  Worst worst;
  double sum = 0;
  int n = 0;
  const int paints = 60 / kFewer;
  // Three colours each; what the walk's own error may add.
  const double threshold = sidak_threshold(kLevel, 3.0 * paints);
  for (int i = 0; i < paints; ++i) {
    const Paint paint = make_paint(random);
    const double cos_view = i % 4 == 0 ? 1 : random.uniform(0.08, 1);
    reference::WalkScene scene;
    scene.paint = paint;
    const double bright = random.below(2) == 0 ? 1 : 0.2;
    scene.substrate = {bright * random.uniform(), bright * random.uniform(),
                       bright * random.uniform()};
    scene.light = {std::sqrt(1 - cos_view * cos_view), 0, cos_view};
    scene.photons = 100'000;
    scene.seed = static_cast<std::uint64_t>(i);
    const reference::Estimate walked = reference::walk(scene).albedo.total;
    const Rgb<double> found =
        single_scattering(paint, cos_view) + albedo_of<double>(paint, scene.substrate, cos_view);
    TestScene named;
    named.paint = paint;
    for (auto c : {&Rgb<double>::x, &Rgb<double>::y, &Rgb<double>::z}) {
      const double error = std::fabs(found.*c - walked.mean.*c);
      worst.see(error - threshold * walked.error.*c, "found", found.*c, "walked", walked.mean.*c,
                "substrate", scene.substrate.*c, "cos view", cos_view, named);
      sum += error;
      ++n;
    }
  }
  worst.expect_at_most(0.03, "largest");
  EXPECT_LE(sum / n, 0.003) << "mean error";
  ::testing::Test::RecordProperty("mean_error", std::to_string(sum / n));
}

TEST(Mixture, OfOrdinaryPaintsIsThatOfTheRandomWalk) {
  expect_the_walk(91, [](Random& random) { return ordinary_paint(random, false); });
}

TEST(Mixture, OfSeveralSpeciesOfTheLibraryIsThatOfTheRandomWalk) {
  expect_the_walk(96, library_paint);
}

// --- by angle --------------------------------------------------------------------------------

// pi f of GGX microfacets that reflect all they meet (Walter 2007, Smith's G of both directions
// together), scaled to the albedo 1 as Cycles does; the light is at azimuth 0 and v at pi.
class GlossyLobe {
 public:
  GlossyLobe(double cos_view, double alpha) : cos_view_(cos_view), square_(alpha * alpha) {
    // Over half vectors: cos(theta_h) D dw_h is uniform in u = D's integral from the pole.
    constexpr int kPolar = 120, kAzimuths = 60;
    double sum = 0;
    for (int i = 0; i < kPolar; ++i) {
      const double u = (i + 0.5) / kPolar;
      const double cos_half = 1 / std::sqrt(1 + square_ * u / (1 - u));
      const double sin_half = std::sqrt(1 - cos_half * cos_half);
      for (int j = 0; j < kAzimuths; ++j) {
        const double phi = 2 * std::numbers::pi * (j + 0.5) / kAzimuths;
        const double facing = cos_half * cos_view_ - sin_half * sine_of(cos_view_) * std::cos(phi);
        const double cos_light = 2 * facing * cos_half - cos_view_;
        if (facing > 0 && cos_light > 0) sum += visible(cos_light) * facing / cos_half;
      }
    }
    albedo_ = sum / (kPolar * kAzimuths) / cos_view_;
  }

  double operator()(Vec3<double> light) const {
    const Vec3<double> half = light + Vec3<double>{-sine_of(cos_view_), 0, cos_view_};
    const double cos_half = half.z / length(half);
    const double spread = cos_half * cos_half * (square_ - 1) + 1;
    return square_ / (spread * spread) * visible(light.z) / (4 * cos_view_ * light.z) / albedo_;
  }

 private:
  static double sine_of(double cosine) { return std::sqrt(1 - cosine * cosine); }
  double lambda(double c) const { return (std::sqrt(1 + square_ * (1 / (c * c) - 1)) - 1) / 2; }
  double visible(double cos_light) const { return 1 / (1 + lambda(cos_view_) + lambda(cos_light)); }

  double cos_view_, square_, albedo_ = 1;
};

// CIE 1976 of a reflectance factor.
double lightness(double y) {
  return y > 216.0 / 24389 ? 116 * std::cbrt(y) - 16 : 24389.0 / 27 * y;
}

struct LightnessError {
  double two_lobes, lambertian;
};

// Root mean square over the hemisphere, of single flakes and mixture together.
LightnessError lightness_error(const Paint& paint, double cos_view, std::uint64_t seed) {
  reference::WalkScene scene;
  scene.paint = paint;
  scene.substrate = grey(0.05);
  scene.light = {-std::sqrt(1 - cos_view * cos_view), 0, cos_view};
  for (double theta : {-75.0, -60.0, -45.0, -30.0, -15.0, 0.0, 15.0, 30.0, 45.0, 60.0, 75.0}) {
    const double angle = theta * std::numbers::pi / 180;
    scene.detectors.push_back({std::sin(angle), 0, std::cos(angle)});
    if (theta == 30 || theta == 60)
      scene.detectors.push_back({0, std::sin(angle), std::cos(angle)});
  }
  scene.photons = 100'000;
  scene.seed = seed;
  const reference::WalkResult walked = reference::walk(scene);
  const Mixture<double> m = mixture(make_layer<double>(paint), scene.substrate, cos_view);
  const GlossyLobe lobe(cos_view, m.alpha);
  LightnessError error{};
  for (std::size_t i = 0; i < scene.detectors.size(); ++i) {
    const double single = std::numbers::pi * walked.brdf[i].part[reference::single_flake].mean.x;
    const double wanted = lightness(std::numbers::pi * walked.brdf[i].total.mean.x);
    const double glossy = m.glossy.x * lobe(scene.detectors[i]);
    const double off = lightness(single + m.diffuse.x + glossy) - wanted;
    const double flat = lightness(single + m.diffuse.x + m.glossy.x) - wanted;
    error.two_lobes += off * off;
    error.lambertian += flat * flat;
  }
  const double n = static_cast<double>(scene.detectors.size());
  return {std::sqrt(error.two_lobes / n), std::sqrt(error.lambertian / n)};
}

TEST(Mixture, HasTheLightnessOfTheRandomWalkByAngle) {
  Random random(97);
  const int paints = 60 / kFewer;
  double two_lobes = 0, lambertian = 0, worst = 0;
  for (int i = 0; i < paints; ++i) {
    const Paint paint = ordinary_paint(random, false);
    const double cos_view = i % 3 == 0 ? 0.97 : i % 3 == 1 ? 0.7 : 0.35;
    const LightnessError error = lightness_error(paint, cos_view, static_cast<std::uint64_t>(i));
    two_lobes += error.two_lobes / paints;
    lambertian += error.lambertian / paints;
    worst = std::max(worst, error.two_lobes);
  }
  EXPECT_LE(two_lobes, 1.5);
  EXPECT_LE(worst, 16);
  EXPECT_GE(lambertian, 2 * two_lobes) << "one lobe would do";
  ::testing::Test::RecordProperty("mean", std::to_string(two_lobes));
  ::testing::Test::RecordProperty("lambertian", std::to_string(lambertian));
  ::testing::Test::RecordProperty("worst", std::to_string(worst));
}

// Half of the flakes twice are all of them.
TEST(Mixture, AddsTheSpecies) {
  Random random(94);
  Worst worst;
  for (int i = 0; i < 100; ++i) {
    const Paint whole = ordinary_paint(random, false);
    Paint halves = whole;
    halves.flakes_per_mm2 /= 2;
    halves.more[1] = halves;
    const Rgb<double> substrate{0.1, 0.5, 0.9};
    const double cos_view = random.uniform(0.05, 1);
    const Rgb<double> off = albedo_of<double>(whole, substrate, cos_view) -
                            albedo_of<double>(halves, substrate, cos_view);
    worst.see(std::max({std::fabs(off.x), std::fabs(off.y), std::fabs(off.z)}), "view", cos_view);
  }
  worst.expect_at_most(1e-14);
}

// No flakes, a clear binder: rho (1 - r_s)(1 - R_i)/(1 - rho R_i), with R_i by the midpoint rule.
TEST(Mixture, WithoutFlakesIsTheSubstrateUnderAClearCoat) {
  Worst worst;
  for (double eta : {0.7, 1.0, 1.33, 1.5, 2.4}) {
    double escaping = 0;
    constexpr int n = 100'000;
    for (int i = 0; i < n; ++i) {
      const double c = (i + 0.5) / n;
      const double g = eta_cos_refracted(c, 1 / eta);
      escaping += 2 * c / n * fresnel_transmittance(c, g, 1 / eta);
    }
    Paint paint = undiffracted();
    paint.flakes_per_mm2 = 0;
    paint.binder_ior = eta;
    for (double rho : {0.0, 0.3, 1.0}) {
      for (double cos_view : {1.0, 0.8}) {
        const double expected =
            rho * (1 - surface_of(paint, cos_view)) * escaping / (1 - rho * (1 - escaping));
        worst.see(std::fabs(albedo_of<double>(paint, grey(rho), cos_view).x - expected), "eta", eta,
                  "rho", rho, "cos view", cos_view);
      }
    }
  }
  worst.expect_at_most(1e-3);
}

TEST(Mixture, InFloatIsThatInDouble) {
  Random random(92);
  Worst worst;
  for (int i = 0; i < 3000; ++i) {
    const Paint paint = ordinary_paint(random, i % 2 == 0);
    const double cos_view = rounded(random.uniform(0.05, 1));
    const Rgb<double> wide = albedo_of<double>(paint, grey(0.5), cos_view);
    const Rgb<float> narrow = albedo_of<float>(paint, grey(0.5), cos_view);
    worst.see(max_component(map(wide - Rgb<double>(narrow), [](double x) { return std::fabs(x); })),
              "cos view", cos_view, "tilt", paint.tilt);
  }
  worst.expect_at_most(2e-5);
}

template <class T>
void expect_sound(const Paint& paint, Rgb<double> substrate, double cos_view) {
  std::feclearexcept(FE_ALL_EXCEPT);
  const Rgb<T> m = albedo_of<T>(paint, substrate, cos_view);
  const int raised = std::fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
  TestScene scene;
  scene.paint = paint;
  ASSERT_EQ(raised, 0) << sizeof(T) << " cos view " << cos_view << ' ' << scene;
  const T cosine = static_cast<T>(cos_view), eta = static_cast<T>(paint.binder_ior);
  const T entered = fresnel_transmittance(cosine, eta_cos_refracted(cosine, eta), eta);
  for (T x : {m.x, m.y, m.z}) {
    // Never more than has passed the surface, but for rounding.
    ASSERT_TRUE(x >= 0 && x <= entered * T(1 + 4e-6))
        << sizeof(T) << " M " << x << " cos view " << cos_view << ' ' << scene;
  }
}

TEST(Mixture, IsSoundForEveryValidPaint) {
  Random random(93);
  const auto end_or = [&](double least, double most, double usual) {
    const auto pick = random.below(3);
    return pick == 0 ? least : pick == 1 ? most : usual;
  };
  for (int i = 0; i < 20'000 / kFewer; ++i) {
    Paint paint = undiffracted();
    paint.flakes_per_mm2 = end_or(0, 1e9, random.log_uniform(1e-3, 1e6));
    paint.flake_diameter_um = end_or(1e-3, 1e5, random.log_uniform(0.1, 1e3));
    paint.flake_area_spread = end_or(0, 100, 0.3);
    paint.orientation = static_cast<Orientation>(random.below(3));
    const bool gaussian = paint.orientation == Orientation::gaussian;
    paint.tilt = end_or(1e-6, gaussian ? 100 : 1, random.log_uniform(1e-4, 1));
    paint.flake_transmission = grey(end_or(0, 1, random.uniform()));
    const double most = 1 - paint.flake_transmission.x;
    paint.flake_color = grey(end_or(0, most, most * random.uniform()));
    paint.flake_edge_color = grey(end_or(0, most, most * random.uniform()));
    // Every other paint is of one to three species of the library.
    for (int j = 0, used = random.below(2) == 0 ? 0 : 1 + random.below(3); j < used; ++j) {
      FlakeSpecies species = library_species(random, random.log_uniform(1e-3, 10), 1e-6);
      species.flakes_per_mm2 = end_or(0, 1e9, species.flakes_per_mm2);
      const double widest = species.orientation == Orientation::gaussian ? 100 : 1;
      species.tilt = end_or(1e-6, widest, random.log_uniform(1e-4, 1));
      species.coating_nm = end_or(0, 200, species.coating_nm);
      (j == 0 ? static_cast<FlakeSpecies&>(paint) : paint.more[static_cast<std::size_t>(j - 1)]) =
          species;
    }
    paint.binder_ior = end_or(0.1, 10, random.log_uniform(0.3, 3));
    if (random.below(4) == 0) paint.binder_ior = 1 + (random.below(2) == 0 ? 1e-7 : -1e-7);
    paint.layer_thickness_um = end_or(0, 1e6, 30);
    paint.binder_absorption_per_mm = {end_or(0, 1e6, 1), end_or(0, 1e6, 1), 0};
    paint.rayleigh_per_mm = end_or(0, 1e6, 0.1);
    const Rgb<double> substrate{end_or(0, 1, 0.5), end_or(0, 1, 0.5), 1};
    const double cosines[] = {1, random.uniform(), 1e-4, 1e-9, 1e-20};
    validate(paint);
    for (double cos_view : cosines) {
      expect_sound<double>(paint, substrate, cos_view);
      expect_sound<float>(paint, substrate, cos_view);
      if (HasFatalFailure()) return;
    }
  }
}

}  // namespace
