// SPDX-License-Identifier: Apache-2.0
//
// Drawn sparkles against their closed form: z-tests over random paints, lights and pixels. Level
// 1e-6 for each test as a whole (Sidak's correction within), another seed in each run of --all.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "scenes.h"
#include "sparkles.h"
#include "support.h"

namespace {

using namespace core_tests;

struct Drawn {
  Moments count;
  std::array<Moments, 3> radiance;
  double largest = 0, least = 0, at_ceiling = 0;
};

template <class T>
Drawn draw(const TestScene& scene, const ExpectedSparkles<T>& expected, int n, int stream) {
  Drawn drawn;
  const Rgb<T> mean = mean_radiance(expected);
  drawn.count.centre = static_cast<double>(expected.mean_count);
  drawn.radiance[0].centre = static_cast<double>(mean.x);
  drawn.radiance[1].centre = static_cast<double>(mean.y);
  drawn.radiance[2].centre = static_cast<double>(mean.z);
  const HashWords key = stream_key(stream, 0, 1, static_cast<int>(run_seed()));
  const T spread = static_cast<T>(scene.paint.flake_area_spread);
  for (int i = 0; i < n; ++i) {
    const Sparkles<T> s = draw_sparkles(expected, spread, key, i % 1000 - 500, i / 1000);
    drawn.count.add(static_cast<double>(s.count));
    drawn.radiance[0].add(static_cast<double>(s.radiance.x));
    drawn.radiance[1].add(static_cast<double>(s.radiance.y));
    drawn.radiance[2].add(static_cast<double>(s.radiance.z));
    const T most = max_component(s.radiance);
    const T least = std::min(std::min(s.radiance.x, s.radiance.y), s.radiance.z);
    drawn.largest = std::max(drawn.largest, static_cast<double>(most / expected.ceiling));
    drawn.least = std::min(drawn.least, static_cast<double>(least));
    drawn.at_ceiling += most >= expected.ceiling ? 1 : 0;
  }
  return drawn;
}

// Whether the closed form, which knows no ceiling, leaves the sum room below it.
template <class T>
bool stays_below_ceiling(const ExpectedSparkles<T>& expected) {
  if (expected.slots == 1) return true;
  const T mean = max_component(mean_radiance(expected));
  const T deviation = std::sqrt(max_component(radiance_variance(expected)));
  return mean + 12 * deviation < expected.ceiling;
}

template <class T>
void expect_closed_form(const TestScene& scene, int stream, double threshold, Worst& worst,
                        Variances& variances) {
  const auto expected = scene.expect<T>();
  const double N = static_cast<double>(expected.mean_count);
  const int n = 40'000;  // 400 sparkles or more
  const Drawn drawn = draw(scene, expected, n, stream);
  const double root = std::sqrt(1.0 * n);
  const auto z_test = [&](const char* name, double found, double exact, double deviation) {
    const double z = deviation > 0 ? (found - exact) / deviation * root : 0;
    EXPECT_LT(std::fabs(z), threshold)
        << name << ": " << found << " for " << exact << ", z " << z << ", <N> " << N << ", slots "
        << expected.slots << ", fill " << expected.fill << '\n'
        << scene;
    worst.see(std::fabs(z), name, "stream", stream);
  };
  const double count_variance = expected.slots > 0 ? N * (1 - N / expected.slots) : N;
  z_test("count", drawn.count.mean(), N, std::sqrt(count_variance));
  std::ostringstream where;
  where << "<N> " << N << ", slots " << expected.slots << ", fill " << expected.fill << ' '
        << scene;
  variances.see(drawn.count.variance(), count_variance,
                fourth_moment_of_sum(N, expected.slots, 1, 1, 1, 1), n, where.str());
  const char* names[] = {"red", "green", "blue"};
  const Rgb<T> mean = mean_radiance(expected), variance = radiance_variance(expected);
  const T means[] = {mean.x, mean.y, mean.z}, second[] = {variance.x, variance.y, variance.z};
  const T slant[] = {expected.slant.x, expected.slant.y, expected.slant.z};
  const T mirror[] = {expected.mirror.x, expected.mirror.y, expected.mirror.z};
  const double left = static_cast<double>(fluctuation_left(expected));
  for (std::size_t c = 0; c < 3; ++c) {
    const Moments& m = drawn.radiance[c];
    const double v = static_cast<double>(second[c]);
    z_test(names[c], m.mean(), static_cast<double>(means[c]), std::sqrt(v));
    // Moments of what a sparkle adds, as the paint's contrast shows it.
    const auto moment = [&](int power) {
      const double fill = static_cast<double>(expected.fill);
      return static_cast<double>(
          independent::area_moment(scene.paint.flake_area_spread, power, fill) *
          independent::averaged(power * static_cast<long double>(slant[c]) -
                                (power - 1) * static_cast<long double>(expected.hidden)) *
          std::pow(static_cast<long double>(static_cast<double>(mirror[c]) * left / fill), power));
    };
    variances.see(
        m.variance(), v,
        fourth_moment_of_sum(N, expected.slots, moment(1), moment(2), moment(3), moment(4)), n,
        std::string(names[c]) + ' ' + where.str());
  }
  EXPECT_GE(drawn.least, 0) << scene;
  EXPECT_LE(drawn.largest, 1) << scene;
}

TEST(Draws, ContrastDrawsTheRadianceToItsMean) {
  Random random = fresh(44);
  Worst worst;
  int dark = 0;
  for (int k = 0; k < 400; ++k) {
    TestScene scene;
    scene.paint = random_paint(random);
    aim(scene, random, 2.5);
    scene.light_sine = random.log_uniform(1e-3, 0.2);
    set_count(scene, random.log_uniform(0.1, 2e5));  // also where it fades with the distance
    const double contrast = random.uniform(0, 1);
    const auto full = scene.expect<double>();
    if (!stays_below_ceiling(full)) continue;
    scene.paint.sparkle_contrast = contrast;
    const auto less = scene.expect<double>();
    const auto draw = [&](const ExpectedSparkles<double>& expected) {
      return draw_sparkles(expected, scene.paint.flake_area_spread, stream_key(0, 0, 0, 1), k, 2);
    };
    const auto all = draw(full), part = draw(less);
    EXPECT_EQ(part.count, all.count) << scene;
    const double mean = mean_radiance(full).y;
    const double blended = mean + contrast * (all.radiance.y - mean);
    worst.see(relative_error(part.radiance.y, blended), scene);
    EXPECT_NEAR(radiance_variance(less).y, contrast * contrast * radiance_variance(full).y,
                1e-12 * radiance_variance(full).y);
    dark += all.count == 0 && part.radiance.y > 0 ? 1 : 0;

    scene.paint.sparkle_contrast = 0;
    const auto none = draw(scene.expect<double>());
    EXPECT_EQ(none.count, std::floor(full.mean_count + 0.5));
    EXPECT_EQ(none.radiance.y, mean);
    EXPECT_EQ(radiance_variance(scene.expect<double>()).y, 0);
  }
  EXPECT_GT(dark, 10);
  worst.expect_at_most(1e-10);
}

TEST(Draws, CountAndRadianceHaveTheirMeanAndVariance) {
  Random random = fresh(45);
  Worst worst;
  Variances variances(4);
  const int scenes = 144;
  const double threshold = sidak_threshold(kFreshLevel, scenes * 4);
  for (int k = 0; k < scenes;) {
    TestScene scene;
    scene.paint = random_paint(random);
    // All eighteen combinations in turn.
    scene.paint.depth_model = static_cast<DepthModel>(k % 3);
    scene.paint.radiometry = static_cast<Radiometry>(k / 3 % 2);
    scene.paint.orientation = static_cast<Orientation>(k / 6 % 3);
    scene.paint.flake_area_spread = rounded(std::array{0.0, 0.3, 0.8, 2.0}[k / 18 % 4]);
    scene.paint.sparkle_contrast = k < scenes / 2 ? 1 : 0.4;
    aim(scene, random, 2.5);
    scene.light_sine = rounded(random.log_uniform(1e-3, 0.2));
    scene = rounded(scene);
    if (random.below(4) == 0) {
      // A pixel between a thousandth of a flake and ten flakes.
      scene.footprint =
          rounded(scene.layer<double>().flakes[0].flake_area * random.log_uniform(1e-3, 10));
    } else {
      set_count(scene, random.log_uniform(0.01, 3e4));
    }
    const auto expected = scene.expect<double>();
    // Rarer sparkles would need more draws than the test can afford.
    if (expected.mean_count < 0.01) continue;
    if (!stays_below_ceiling(expected)) continue;
    if (random.below(2) == 0) {
      expect_closed_form<double>(scene, k, threshold, worst, variances);
    } else {
      expect_closed_form<float>(scene, k, threshold, worst, variances);
    }
    ++k;
  }
  worst.expect_at_most(threshold, "largest_z_of_a_mean");
  variances.expect_chance();
}

TEST(Draws, EveryCountFromRareToCountlessHasItsMeanAndVariance) {
  Random random = fresh(46);
  Worst worst;
  Variances variances(4);
  const double counts[] = {0.01, 0.03, 0.0999, 0.11, 0.5, 1,   3,   10,  15,
                           17,   25,   31.9,   32.1, 50,  200, 1e3, 1e4, 3e4};
  const double threshold =
      sidak_threshold(kFreshLevel, 2 * 4 * static_cast<double>(std::size(counts)));
  int stream = 1000;
  for (double count : counts) {
    for (int published = 0; published < 2; ++published) {
      TestScene scene;
      do {
        scene.paint = random_paint(random);
        scene.paint.radiometry = static_cast<Radiometry>(published);
        scene.paint.flake_area_spread = rounded(random.uniform(0, 1));
        aim(scene, random, 2.5);
        scene.light_sine = 0.01;
        set_count(scene, count);
      } while (!stays_below_ceiling(scene.expect<double>()));
      expect_closed_form<double>(scene, ++stream, threshold, worst, variances);
    }
  }
  worst.expect_at_most(threshold, "largest_z_of_a_mean");
  variances.expect_chance();
}

TEST(Draws, SumOfManyIsNeverNegativeNorAboveTheCeiling) {
  Random random = fresh(42);
  for (int k = 0; k < 300; ++k) {
    TestScene scene;
    scene.paint = random_paint(random);
    scene.paint.flake_area_spread = rounded(random.log_uniform(0.1, 100));
    scene.paint.binder_absorption_per_mm = {0, 100, 1000};
    aim(scene, random, 4);
    scene.light_sine = random.log_uniform(1e-3, 1);
    set_count(scene, random.log_uniform(10, 1e4));
    const auto check = [&](const auto& expected, const Drawn& drawn) {
      EXPECT_GE(drawn.least, 0) << scene;
      EXPECT_LE(drawn.largest, 1) << scene << " <N> " << expected.mean_count;
    };
    const auto d = scene.expect<double>();
    check(d, draw(scene, d, 500, k));
    const auto f = scene.expect<float>();
    check(f, draw(scene, f, 500, k));
  }
}

TEST(Draws, CeilingCostsLittleOfTheMeanWhereFlakesJustFit) {
  // Two to fifteen places, flakes of 30 % spread: large ones together may exceed the mirror and are
  // cut, which the closed form does not know. The share of the mean that this takes, less five
  // standard errors of it, which one of the 54 exceeds by chance in one run of 60,000: nothing that
  // shows unless most places are taken.
  Worst sparse, dense;
  for (double places : {1.2, 2.001, 2.5, 3.001, 4.001, 6.001, 8.001, 12.001, 15.5}) {
    for (double share : {0.01, 0.05, 0.2, 0.5, 0.8, 0.95}) {
      TestScene scene;
      scene.paint.flake_area_spread = 0.3;
      scene.paint.flake_color = scene.paint.flake_edge_color = {0.9, 0.9, 0.9};
      scene.paint.depth_model = DepthModel::thinned;
      scene.normal = {0, 0, 1};
      scene.view = {0.5, 0, std::sqrt(0.75)};
      scene.light = {-0.5, 0, std::sqrt(0.75)};
      scene.light_sine = 0.02;
      scene.footprint = 1e-10;
      scene.footprint = places * 1e-10 / scene.expect<double>().fill;
      auto expected = scene.expect<double>();
      expected.mean_count = share * places;
      if (expected.mean_count > expected.slots) continue;  // overlapping: Poisson, see below
      const int n = share <= 0.05 ? 400'000 : 50'000;      // few of them sparkle
      const Drawn drawn = draw(scene, expected, n, static_cast<int>(places * 10));
      const double mean = mean_radiance(expected).x;
      const double error = drawn.radiance[0].error_of_mean() / mean;
      (share <= 0.05 ? sparse : dense)
          .see(std::max(0.0, 1 - drawn.radiance[0].mean() / mean - 5 * error), "places", places,
               "<N>/places", share, "cut", drawn.at_ceiling);
    }
  }
  sparse.expect_at_most(2e-3, "up_to_a_twentieth_taken");
  dense.expect_at_most(0.05, "up_to_all_taken");
}

TEST(Draws, OverlappingSparklesShowNoMoreThanTheMirror) {
  // More sparkles than places: the drawn mean falls short of the closed form, never beyond it.
  TestScene scene;
  scene.paint.flake_color = scene.paint.flake_edge_color = {1, 1, 1};
  scene.normal = scene.view = scene.light = {0, 0, 1};
  scene.light_sine = 0.5;
  scene.paint.flakes_per_mm2 = 1e6;
  scene.footprint = 1e-8;
  const auto expected = scene.expect<double>();
  ASSERT_GT(expected.mean_count * expected.area.mean, expected.fill) << "no overlap to test";
  const Drawn drawn = draw(scene, expected, 20'000, 5);
  EXPECT_LE(drawn.largest, 1);
  EXPECT_LE(drawn.radiance[0].mean(), mean_radiance(expected).x * 1.01);
}

TEST(Draws, ColoursOfOneSparkleFollowTheirOwnDepths) {
  // A single sparkle is dimmed by e^(-x u) in each colour with one depth u.
  Random random = fresh(43);
  for (int k = 0; k < 2'000; ++k) {
    ExpectedSparkles<double> expected;
    expected.mean_count = 0.5;
    expected.slots = 1;
    expected.fill = 100;
    expected.area = {1, 1, 1};
    expected.slant = {0, random.uniform(0.1, 2), random.uniform(2, 5)};
    expected.mirror = {1, 1, 1};
    expected.ceiling = 1;
    const auto drawn = draw_sparkles(expected, 0.0, stream_key(0, 0, k, 0), 3, 4);
    if (drawn.count == 0) continue;
    const double u_green = -std::log(drawn.radiance.y / drawn.radiance.x) / expected.slant.y;
    const double u_blue = -std::log(drawn.radiance.z / drawn.radiance.x) / expected.slant.z;
    EXPECT_NEAR(u_green, u_blue, 1e-9);
    EXPECT_GT(u_green, 0);
    EXPECT_LT(u_green, 1);
    EXPECT_DOUBLE_EQ(drawn.radiance.x, 0.01);
  }
}

TEST(Draws, SamePixelGivesTheSameSparkles) {
  Random random = fresh(44);
  TestScene scene;
  scene.paint = random_paint(random);
  aim(scene, random, 2);
  scene.light_sine = 0.05;
  set_count(scene, 5);
  const auto expected = scene.expect<float>();
  const float spread = static_cast<float>(scene.paint.flake_area_spread);
  int different = 0;
  for (int x = 0; x < 100; ++x) {
    const auto once = draw_sparkles(expected, spread, stream_key(0, 0, 1, 0), x, 7);
    const auto again = draw_sparkles(expected, spread, stream_key(0, 0, 1, 0), x, 7);
    EXPECT_EQ(once.count, again.count);
    EXPECT_EQ(once.radiance.x, again.radiance.x);
    const auto frame = draw_sparkles(expected, spread, stream_key(0, 0, 2, 0), x, 7);
    different += frame.radiance.x != once.radiance.x ? 1 : 0;
  }
  EXPECT_GT(different, 90) << "another frame, other sparkles";
}

}  // namespace
