// SPDX-License-Identifier: Apache-2.0
//
// The model against individually traced flakes, and the tracer against what is known exactly.
#include "reference/explicit_flakes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "independent.h"
#include "paint.h"
#include "reference/optics.h"
#include "scenes.h"
#include "support.h"

namespace {

using namespace core_tests;
using metallic_paint::reference::ExplicitResult;
using metallic_paint::reference::ExplicitScene;
using metallic_paint::reference::Shadowing;
using metallic_paint::reference::trace_explicit_flakes;

constexpr double kPi = std::numbers::pi;

// All comparisons of a test: each a standard normal deviate if the model is right.
class Comparisons {
 public:
  Variances variances{2};  // of count and radiance

  template <class Named>
  void see(const std::string& what, double z, const Named& where) {
    Kind& kind = kinds_[what];
    kind.count += 1;
    kind.square += z * z;
    if (std::isnan(kind.worst) || std::fabs(z) <= std::fabs(kind.worst)) return;  // NaN: the worst
    kind.worst = z;
    std::ostringstream text;
    text << where;
    kind.where = text.str();
  }
  void expect_chance() {
    double count = 0;
    for (const auto& [what, kind] : kinds_) count += kind.count;
    ASSERT_GT(count, 0);
    const double threshold = sidak_threshold(kFreshLevel, count);
    for (const auto& [what, kind] : kinds_) {
      EXPECT_LE(std::fabs(kind.worst), threshold) << what << " at " << kind.where;
      std::ostringstream text;
      text.precision(3);
      text << "worst " << kind.worst << " of " << threshold << ", root mean square "
           << std::sqrt(kind.square / kind.count) << ", comparisons " << kind.count;
      ::testing::Test::RecordProperty(what, text.str());
    }
    if (variances.seen() > 0) variances.expect_chance();
  }

 private:
  struct Kind {
    double count = 0, square = 0, worst = 0;
    std::string where;
  };
  std::map<std::string, Kind> kinds_;
};

// ---------------------------------------------------------------------------------------------
// The model.

// In which of its sizes the light is what a sparkle needs.
enum class Cone { light, flake, both };

struct ModelScene {
  TestScene scene;
  Cone cone;
};

constexpr double kFlakes = 5e5;  // traced in each scene

// Expected in a scene whose variances are judged.
constexpr double kLeastSparkles = 400;

// A random paint and light that the model is made for, of which a hundred flakes sparkle at least.
// `from`, `to`: the radius of the quarter cone of flake normals, in tilts.
ModelScene random_model_scene(Random& random, double from, double to, double widest_light) {
  for (;;) {
    ModelScene made;
    TestScene& s = made.scene;
    Paint& paint = s.paint;
    paint = random_paint(random);
    paint.radiometry = Radiometry::exact;
    if (paint.depth_model == DepthModel::correlated) paint.depth_model = DepthModel::attenuated;
    paint.flake_edge_color = paint.flake_edge_color * 0.9;  // leaves room for the transmission
    paint.flake_area_spread = random.below(4) == 0 ? 0 : random.uniform(0, 0.6);
    paint.binder_ior = random.below(6) == 0 ? random.uniform(0.8, 1) : random.uniform(1, 2.2);
    if (paint.depth_model == DepthModel::thinned) {
      // What colours lose differently has the model's mean alone.
      paint.binder_absorption_per_mm = grey(paint.binder_absorption_per_mm.x);
      paint.flake_transmission = grey(paint.flake_transmission.x);
    }
    made.cone = static_cast<Cone>(random.below(3));

    // A flake that occurs, and the light that it mirrors.
    s.normal = {0, 0, 1};
    const Vec3<double> view = spherical(random.uniform(0, 1.2), random.uniform(0, 2 * kPi));
    s.beta = random.uniform(0, 1.5 * paint.tilt);
    const Vec3<double> flake = spherical(s.beta, random.uniform(0, 2 * kPi));
    const double eta = paint.binder_ior;
    const double g = std::sqrt(std::max(eta * eta - 1 + view.z * view.z, 0.0));
    const Vec3<double> v{view.x / eta, view.y / eta, g / eta};
    const Vec3<double> l = flake * (2 * dot(flake, v)) - v;
    const double sine = eta * std::hypot(l.x, l.y);
    // Far enough from grazing for the cone to stay round.
    if (v.z < 0.3 || l.z < 0.3 || sine > 0.9) continue;
    s.view = view;
    s.light = {eta * l.x, eta * l.y, std::sqrt(1 - sine * sine)};

    const double cone = 2 * dot(flake, v) * paint.tilt * random.log_uniform(from, to);
    const double squeeze = std::sqrt(s.light.z / (eta * eta * l.z));
    const double of_light = made.cone == Cone::light  ? 1
                            : made.cone == Cone::both ? random.uniform(0.3, 0.9)
                                                      : 0;
    const double radius = cone * of_light / squeeze;
    paint.flake_spread = cone * std::sqrt(1 - of_light * of_light);
    if (radius > widest_light || paint.flake_spread > 0.5) continue;
    s.light_sine = std::sin(radius);
    s.footprint = 1;
    const double sparkles = kFlakes * s.expect<double>().mean_count / (paint.flakes_per_mm2 * 1e6);
    if (sparkles < 100) continue;
    // A hundred pixels or more, each of many flakes.
    set_count(s, random.log_uniform(0.05, std::min(5.0, sparkles / 100)));
    const auto expected = s.expect<double>();
    if (expected.slots != 0 || expected.slant.x > 4) continue;
    return made;
  }
}

ExplicitScene explicit_scene(const TestScene& s, std::uint64_t seed) {
  ExplicitScene scene;
  scene.paint = s.paint;
  scene.view = s.view;
  scene.light = s.light;
  scene.light_radius = std::asin(s.light_sine);
  scene.footprint = s.footprint;
  scene.pixels =
      static_cast<std::size_t>(std::ceil(kFlakes / (s.paint.flakes_per_mm2 * 1e6 * s.footprint)));
  scene.shadowing =
      s.paint.depth_model == DepthModel::thinned ? Shadowing::thinned : Shadowing::attenuated;
  scene.seed = seed;
  return scene;
}

// About their known mean.
template <class F>
Moments moments(double mean, std::size_t size, const F& value) {
  Moments m{mean};
  for (std::size_t i = 0; i < size; ++i) m.add(value(i));
  return m;
}

void compare_radiances(Comparisons& comparisons, const ModelScene& made,
                       const ExplicitResult& traced) {
  const auto expected = made.scene.expect<double>();
  const Moments m = moments(mean_radiance(expected).y, traced.radiance.size(),
                            [&](std::size_t i) { return traced.radiance[i].y; });
  comparisons.see("mean radiance", (m.mean() - m.centre) / m.error_of_mean(), made.scene);
  if (made.cone == Cone::both || expected.mean_count * m.n < kLeastSparkles) return;
  // The fourth moment of the law: one found beside so few sparkles is small where the variance is.
  const auto moment = [&](int power) {
    return static_cast<double>(
        independent::area_moment(made.scene.paint.flake_area_spread, power, expected.fill) *
        independent::averaged(power * expected.slant.y - (power - 1) * expected.hidden) *
        std::pow(expected.mirror.y / expected.fill, power));
  };
  const double fourth =
      fourth_moment_of_sum(expected.mean_count, 0, moment(1), moment(2), moment(3), moment(4));
  comparisons.variances.see(m.variance(), radiance_variance(expected).y, fourth, m.n, made.scene);
}

void compare_counts(Comparisons& comparisons, const ModelScene& made,
                    const ExplicitResult& traced) {
  // Light and flake together: the model has one disc of their joint solid angle, the flakes have a
  // disc blurred by another. The same mean radiance, other counts.
  if (made.cone == Cone::both) return;
  const double n = static_cast<double>(traced.count.size());
  const double mean = made.scene.expect<double>().mean_count;
  const Moments m =
      moments(mean, traced.count.size(), [&](std::size_t i) { return traced.count[i]; });
  comparisons.see("mean count", (m.mean() - mean) / std::sqrt(mean / n), made.scene);
  if (mean * n >= kLeastSparkles) {
    comparisons.variances.see(m.variance(), mean, fourth_moment_of_sum(mean, 0, 1, 1, 1, 1), n,
                              made.scene);
  }
  std::vector<double> expected;
  const int most = static_cast<int>(mean + 10 * std::sqrt(mean) + 20);
  for (int k = 0; k <= most; ++k) {
    expected.push_back(n * std::exp(k * std::log(mean) - mean - std::lgamma(k + 1.0)));
  }
  std::vector<double> observed(expected.size());
  for (double k : traced.count) {
    observed[std::min(static_cast<std::size_t>(k), observed.size() - 1)] += 1;
  }
  comparisons.see("count distribution", chi_square_z(observed, expected), made.scene);
}

struct Means {
  double count = 0, radiance = 0;  // of a pixel
};
Means means(const ExplicitResult& traced) {
  const auto n = static_cast<double>(traced.count.size());
  Means m;
  for (double count : traced.count) m.count += count / n;
  for (const Rgb<double>& radiance : traced.radiance) m.radiance += radiance.y / n;
  return m;
}

// Relative errors of all scenes together, weighted by their precision.
struct Pooled {
  double weight = 0, sum = 0;
  void see(double relative_error, double variance) {
    weight += 1 / variance;
    sum += relative_error / variance;
  }
  void expect_at_most(double bias, const std::string& name) const {
    const double error = 1 / std::sqrt(weight);
    EXPECT_LE(std::fabs(sum / weight), bias + sidak_threshold(kFreshLevel, 2) * error) << name;
    std::ostringstream text;
    text << sum / weight << ", standard error " << error;
    ::testing::Test::RecordProperty(name, text.str());
  }
};

TEST(ExplicitFlakes, ModelHasTheirCountsAndRadiancesForNarrowCones) {
  Random random = fresh(100);
  Comparisons comparisons;
  Pooled pooled_count, pooled_radiance;
  for (int k = 0; k < 200 / kFewer; ++k) {
    const ModelScene made = random_model_scene(random, 1.0 / 32, 1.0 / 16, 0.05);
    const ExplicitResult traced = trace_explicit_flakes(explicit_scene(made.scene, random.bits()));
    compare_counts(comparisons, made, traced);
    compare_radiances(comparisons, made, traced);

    const auto expected = made.scene.expect<double>();
    const auto n = static_cast<double>(traced.count.size());
    const auto [count, radiance] = means(traced);
    const double mean = mean_radiance(expected).y;
    pooled_radiance.see(radiance / mean - 1, radiance_variance(expected).y / (mean * mean * n));
    if (made.cone == Cone::both) continue;
    pooled_count.see(count / expected.mean_count - 1, 1 / (expected.mean_count * n));
  }
  comparisons.expect_chance();
  // Over a quarter cone of radius r the density p of the normals means p + r^2/8 of its Laplacian:
  // at the peak of ggx -8/tilt^2, for r = tilt/16 1/256; no shape is more curved.
  pooled_count.expect_at_most(1.0 / 256, "all counts");
  pooled_radiance.expect_at_most(1.0 / 256, "all radiances");
}

// Two or three species, most of a coating of the library, under one light.
TEST(ExplicitFlakes, LongModelHasTheCountsAndRadiancesOfSeveralSpecies) {
  Random random = fresh(103);
  Comparisons comparisons;
  for (int k = 0; k < 60 / kFewer;) {
    ModelScene made = random_model_scene(random, 1.0 / 32, 1.0 / 16, 0.05);
    TestScene& s = made.scene;
    Paint& paint = s.paint;
    if (random.below(2) == 0) {
      paint.coating = static_cast<CoatingKind>(1 + random.below(kCoatingKinds - 1));
      paint.coating_nm = random.uniform(0, 200);
    }
    const int used = 1 + random.below(3);  // of `more`: the first, the second or both
    for (int i = 0; i < 2; ++i) {
      if ((used >> i & 1) == 0) continue;
      // The cone stays narrow against the tilt.
      const double tilt = std::min(paint.tilt * random.log_uniform(1, 3), 0.6);
      FlakeSpecies& more = paint.more[static_cast<std::size_t>(i)];
      more = library_species(random, 1, tilt);
      more.flake_spread = paint.flake_spread;
      more.flake_area_spread = random.uniform(0, 0.6);
      more.flakes_per_mm2 = paint.flakes_per_mm2 * random.log_uniform(0.3, 3);
      more.flake_diameter_um = paint.flake_diameter_um * random.uniform(0.5, 1.2);
    }
    const Layer<double> layer = s.layer<double>();
    const auto mirror = mirror_between(s.normal, s.view, s.light, paint.binder_ior);
    const Rgb<double> slant = exact_slant_depth(layer, mirror.g_view / paint.binder_ior) +
                              exact_slant_depth(layer, mirror.g_light / paint.binder_ior);
    if (slant.x > 6) continue;
    double density = 0;
    for (int i = 0; i < kSpecies; ++i) density += paint.species(i).flakes_per_mm2 * 1e6;
    ExplicitScene scene = explicit_scene(s, random.bits());
    scene.pixels = static_cast<std::size_t>(std::ceil(kFlakes / (density * s.footprint)));
    const ExplicitResult traced = trace_explicit_flakes(scene);

    const auto n = static_cast<double>(scene.pixels);
    double radiance = 0;
    bool of_many = true;
    for (std::size_t i = 0; i < kSpecies; ++i) {
      const auto expected = expect_sparkles(layer, s.point<double>(), s.seen<double>(), &slant, i);
      radiance += mean_radiance(expected).y;
      of_many = of_many && expected.slots == 0;
      const double count = expected.mean_count * n;
      if (made.cone == Cone::both) continue;
      if (count == 0) {
        EXPECT_EQ(traced.sparkles[i], 0);
      } else if (count > 25) {
        comparisons.see("count of species " + std::to_string(i),
                        (traced.sparkles[i] - count) / std::sqrt(count), s);
      }
    }
    if (!of_many) continue;
    ++k;
    const Moments m = moments(radiance, traced.radiance.size(),
                              [&](std::size_t i) { return traced.radiance[i].y; });
    comparisons.see("mean radiance", (m.mean() - m.centre) / m.error_of_mean(), s);
  }
  comparisons.expect_chance();
}

// Up to twice the tilt, where the model rounds the ellipse of normals to a disc of its solid angle
// and takes T where the light's centre meets a flake.
TEST(ExplicitFlakes, LongModelIsWithinSomePerCentForWideCones) {
  Random random = fresh(101);
  struct Band {
    double from, to, count, radiance;  // cone in tilts; relative errors of all scenes together
    double one;  // of one scene besides chance: the worst that sparkles.h states
  };
  const double threshold = sidak_threshold(kFreshLevel, 3 * 2 * 25);
  for (const Band& band : {Band{1.0 / 16, 0.25, 0.01, 0.01, 0.09}, Band{0.25, 1, 0.03, 0.03, 0.52},
                           Band{1, 2, 0.08, 0.1, 0.49}}) {
    Worst counts, radiances;
    Pooled all_counts, all_radiances;
    for (int k = 0; k < 25 / std::min(kFewer, 3);) {  // a third of the scenes have no count
      ModelScene made = random_model_scene(random, band.from, band.to, 0.3);
      made.scene.paint.depth_model = DepthModel::attenuated;
      // A binder, and a light that does not set.
      if (made.scene.paint.binder_ior < 1.3) continue;
      if (std::asin(made.scene.light.z) < std::asin(made.scene.light_sine)) continue;
      ++k;
      const ExplicitResult traced =
          trace_explicit_flakes(explicit_scene(made.scene, random.bits()));
      const auto expected = made.scene.expect<double>();
      const auto n = static_cast<double>(traced.count.size());
      const auto [count, radiance] = means(traced);
      const double mean = mean_radiance(expected).y;
      // Of a single scene chance may explain a deviation of 3 to 18 %, of all together far less.
      const auto see = [&](Worst& worst, Pooled& all, double ratio, double variance) {
        const double by_chance = threshold * std::sqrt(variance / n);
        worst.see(std::max(std::fabs(ratio - 1) - by_chance, 0.0), made.scene);
        all.see(ratio - 1, variance / n);
      };
      see(radiances, all_radiances, radiance / mean, radiance_variance(expected).y / (mean * mean));
      if (made.cone == Cone::both) continue;
      see(counts, all_counts, count / expected.mean_count, 1 / expected.mean_count);
    }
    const std::string cone = "cone_to_" + std::to_string(band.to) + "_tilts";
    counts.expect_at_most(band.one, "count_" + cone);
    radiances.expect_at_most(band.one, "radiance_" + cone);
    all_counts.expect_at_most(band.count, "all_counts_" + cone);
    all_radiances.expect_at_most(band.radiance, "all_radiances_" + cone);
  }
}

// ---------------------------------------------------------------------------------------------
// The discs.

// Level flakes under a light in the mirror direction: all of them sparkle.
ExplicitScene level_scene(double theta_in, double coverage) {
  ExplicitScene scene;
  scene.paint = undiffracted();
  scene.paint.tilt = 1e-6;
  scene.paint.flake_spread = 0;
  scene.paint.flake_area_spread = 0;
  scene.paint.flakes_per_mm2 = coverage / (kPi / 4 * 400e-6);
  const double sine = scene.paint.binder_ior * std::sin(theta_in);
  scene.view = {sine, 0, std::sqrt(1 - sine * sine)};
  scene.light = {-sine, 0, scene.view.z};
  scene.light_radius = 0.01;
  scene.footprint = 4e-8;
  scene.pixels = 4;
  scene.points = 4;
  return scene;
}

// What is seen and lit of level discs of radius r, cover C and transmission t, H deep. A disc d
// above a point lies in the way to the observer, to the light, or in both, which are 2 d tan(theta)
// apart; discs in the ways are a Poisson process: E[product of t] = exp(-integral of (1 - t) over
// single and (1 - t^2) over double hits).
struct Level {
  double coverage, radius, t;
};
double level_share(const std::vector<Level>& species, double depth, double theta) {
  // Common area of two unit discs 2x apart, relative to one.
  const auto common = [](double x) {
    return x >= 1 ? 0 : 2 / kPi * (std::acos(x) - x * std::sqrt((1 - x) * (1 + x)));
  };
  constexpr int kSteps = 20'000;
  double share = 0, dimming = 0;
  for (int i = 0; i < kSteps; ++i) {
    double step = 0;
    for (const auto& [coverage, radius, t] : species) {
      const double both = common((i + 0.5) / kSteps * depth * std::tan(theta) / radius);
      step += coverage / kSteps * ((1 - t) * 2 * (1 - both) + (1 - t * t) * both);
    }
    share += std::exp(-(dimming + step / 2)) / kSteps;
    dimming += step;
  }
  return share;
}

TEST(ExplicitFlakes, LevelDiscsHideEachOtherAsAPoissonProcessOfDiscs) {
  // Face to face observer and light look past the same flakes: e^-zt, not e^-2zt.
  Random random = fresh(102);
  Comparisons comparisons;
  for (double theta : {0.0, 0.15, 0.6}) {
    for (double coverage : {0.3, 2.0}) {
      for (double t : {0.0, 0.4}) {
        ExplicitScene scene = level_scene(theta, coverage);
        scene.paint.flake_transmission = grey(t);
        scene.paint.flake_color = scene.paint.flake_edge_color = grey(0.5);
        // Neighbours share what hides them: the scatter between separate patches is the error.
        constexpr std::size_t kPatches = 40;
        const double exact =
            level_share({{coverage, 10, t}}, scene.paint.layer_thickness_um, theta);
        const Moments m = moments(exact, kPatches, [&](std::size_t) {
          scene.seed = random.bits();
          return trace_explicit_flakes(scene).mean_share.y;
        });
        std::ostringstream where;
        where << "angle " << theta << ", coverage " << coverage << ", transmission " << t
              << ", share " << m.mean() << " of " << exact << ", error " << m.error_of_mean();
        comparisons.see("share", (m.mean() - exact) / m.error_of_mean(), where.str());
      }
    }
  }
  comparisons.expect_chance();
}

// Level discs of two sizes, metal and pearl: what hides is both, each letting through what its
// coating does at the angle of the ways, and the two dimmings multiply for every sparkle alike.
TEST(ExplicitFlakes, LevelDiscsOfTwoSpeciesHideEachOther) {
  Random random = fresh(104);
  Comparisons comparisons;
  for (double theta : {0.1, 0.6}) {
    for (CoatingKind kind : {CoatingKind::tio2_on_silica, CoatingKind::fe2o3_on_mica}) {
      ExplicitScene scene = level_scene(theta, 0.7);
      FlakeSpecies& pearl = scene.paint.more[1];
      pearl = scene.paint;
      pearl.coating = kind;
      pearl.coating_nm = 85;
      pearl.flake_diameter_um = 12;
      pearl.flakes_per_mm2 = 1.1 / (kPi / 4 * 144e-6);
      const double c = std::cos(theta);
      const Rgb<double> t = reference::library_transmittance(kind, 85, c);
      constexpr std::size_t kPatches = 40;
      const double depth = scene.paint.layer_thickness_um;
      const double exact = level_share({{0.7, 10, 0}, {1.1, 6, t.y}}, depth, theta);
      const Moments m = moments(exact, kPatches, [&](std::size_t) {
        scene.seed = random.bits();
        return trace_explicit_flakes(scene).mean_share.y;
      });
      std::ostringstream where;
      where << "angle " << theta << ", transmission " << t.y << ", share " << m.mean() << " of "
            << exact << ", error " << m.error_of_mean();
      comparisons.see("share", (m.mean() - exact) / m.error_of_mean(), where.str());
    }
  }
  comparisons.expect_chance();
}

TEST(ExplicitFlakes, DiscsDimSparklesAndLeaveTheirNumber) {
  ExplicitScene scene = level_scene(0.3, 1);
  scene.paint.tilt = 0.2;
  scene.light_radius = 0.1;
  const ExplicitResult shadowed = trace_explicit_flakes(scene);
  scene.shadowing = Shadowing::none;
  const ExplicitResult free = trace_explicit_flakes(scene);
  EXPECT_EQ(shadowed.flakes, free.flakes);
  EXPECT_EQ(shadowed.count, free.count);
  EXPECT_EQ(free.mean_share.x, 1);
  EXPECT_LT(shadowed.mean_share.x, 0.9);
  for (std::size_t i = 0; i < scene.pixels; ++i) {
    EXPECT_LE(shadowed.radiance[i].x, free.radiance[i].x) << "pixel " << i;
  }
}

// ---------------------------------------------------------------------------------------------
// The tracer.

TEST(ExplicitFlakes, PixelsHoldTheFlakesOfTheirArea) {
  // From a hundredth of a flake to a hundred thousand, over and under the cell of the tracer.
  Comparisons comparisons;
  for (double flakes : {0.01, 0.7, 15.0, 17.0, 300.0, 1e5}) {
    ExplicitScene scene = level_scene(0, 1);
    scene.seed = run_seed();
    scene.shadowing = Shadowing::none;
    scene.footprint = flakes / (scene.paint.flakes_per_mm2 * 1e6);
    scene.pixels = static_cast<std::size_t>(std::clamp(2e5 / flakes, 3.0, 1e6));
    const ExplicitResult traced = trace_explicit_flakes(scene);
    const auto n = static_cast<double>(scene.pixels);
    const Moments count =
        moments(flakes, scene.pixels, [&](std::size_t i) { return traced.count[i]; });
    EXPECT_NEAR(count.mean() * n, traced.flakes, 1e-6 * traced.flakes) << "all of them sparkle";
    comparisons.see("mean", (count.mean() - flakes) / std::sqrt(flakes / n), flakes);
    if (n < 100) continue;  // three pixels have no variance to speak of
    comparisons.variances.see(count.variance(), flakes, fourth_moment_of_sum(flakes, 0, 1, 1, 1, 1),
                              n, flakes);
  }
  comparisons.expect_chance();
}

TEST(ExplicitFlakes, ASeedRepeatsItself) {
  ExplicitScene scene = level_scene(0.3, 1);
  scene.paint.tilt = 0.2;
  scene.light_radius = 0.1;
  const ExplicitResult first = trace_explicit_flakes(scene), again = trace_explicit_flakes(scene);
  EXPECT_EQ(first.count, again.count);
  EXPECT_EQ(first.mean_square_share.z, again.mean_square_share.z);
  scene.seed = 1;
  EXPECT_NE(trace_explicit_flakes(scene).count, first.count);
}

TEST(ExplicitFlakes, NothingSparklesBelowTheHorizonOrWithoutFlakes) {
  ExplicitScene scene = level_scene(0.3, 1);
  const auto sum = [](const ExplicitScene& s) {
    const ExplicitResult traced = trace_explicit_flakes(s);
    double all = traced.mean_share.x;
    for (std::size_t i = 0; i < s.pixels; ++i) all += traced.count[i] + traced.radiance[i].x;
    return all;
  };
  EXPECT_GT(sum(scene), 0);
  for (double side : {-1.0, 1.0}) {
    ExplicitScene below = scene;
    (side < 0 ? below.view : below.light).z *= -1;
    EXPECT_EQ(sum(below), 0);
  }
  ExplicitScene reflected = scene;
  reflected.paint.binder_ior = 0.2;
  EXPECT_EQ(sum(reflected), 0);
  scene.paint.flakes_per_mm2 = 0;
  EXPECT_EQ(sum(scene), 0);
}

TEST(ExplicitFlakes, BadScenesAreRejectedByName) {
  const auto expect_message = [](const std::string& field,
                                 const std::function<void(ExplicitScene&)>& spoil) {
    ExplicitScene scene = level_scene(0.3, 1);
    spoil(scene);
    try {
      trace_explicit_flakes(scene);
      ADD_FAILURE() << field << " was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_EQ(std::string(error.what()).find(field), 0u) << error.what();
    }
  };
  const double nan = std::nan("");
  expect_message("tilt", [](auto& s) { s.paint.tilt = -1; });
  expect_message("length of view", [](auto& s) { s.view.x = 2; });
  expect_message("length of light", [&](auto& s) { s.light.x = nan; });
  expect_message("light_radius", [](auto& s) { s.light_radius = 2; });
  expect_message("light_radius", [&](auto& s) { s.light_radius = nan; });
  expect_message("light_radius + flake_spread", [](auto& s) { s.light_radius = 0; });
  expect_message("footprint", [](auto& s) { s.footprint = 0; });
  expect_message("pixels", [](auto& s) { s.pixels = 0; });
  expect_message("points", [](auto& s) { s.points = 0; });
  expect_message("shadowing", [](auto& s) { s.shadowing = static_cast<Shadowing>(4); });
  expect_message("number of flakes in all pixels", [](auto& s) { s.footprint = 1e6; });
  expect_message("pixels is 16777217, but must be from 1 to 16777216",
                 [](auto& s) { s.pixels = (1 << 24) + 1; });
  // Steps that all flakes take together: many by their number, their points or their neighbours.
  const auto expect_work = [&](const std::function<void(ExplicitScene&)>& spoil) {
    expect_message("number of flakes in all pixels x ", spoil);
  };
  expect_work([](auto& s) { s.footprint = 50, s.paint.flake_spread = 0.3; });
  expect_work([](auto& s) { s.footprint = 1e-3, s.points = 65536; });
  expect_message("number of flakes near", [](auto& s) {
    s.paint.flakes_per_mm2 = 1e9;
    s.paint.layer_thickness_um = 1e6;
    s.footprint = 1e-12;
  });
}

}  // namespace
