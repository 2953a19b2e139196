// SPDX-License-Identifier: Apache-2.0
//
// Flakes seen themselves: their law, their outlines, and that their mean is the closed form's.
#include "close_up.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "flake_lobe.h"
#include "scenes.h"
#include "sparkles.h"
#include "support.h"
#include "whole_paint.h"

namespace {

using namespace core_tests;

constexpr double kPi = std::numbers::pi;

// The axes of an own space anywhere in the world.
struct OwnAxes {
  Vec3<double> axis[3];
};
OwnAxes any_axes(Random& random) {
  const Vec3<double> x = any_direction(random);
  Vec3<double> y = cross(x, any_direction(random));
  y = y / length(y);
  return {{x, y, cross(x, y)}};
}

// The two axes across the one that lies nearest to the normal, at a place within some metres.
LatticePoint<double> lattice_across(const OwnAxes& own, Vec3<double> normal, Random& random) {
  int dominant = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::fabs(dot(own.axis[i], normal)) > std::fabs(dot(own.axis[dominant], normal))) {
      dominant = i;
    }
  }
  return {random.uniform(-3, 3),        random.uniform(-3, 3),
          random.uniform(-3, 3),        dominant + 3 * random.below(2),
          own.axis[(dominant + 1) % 3], own.axis[(dominant + 2) % 3]};
}

// The way v to the observer in the binder.
// To an observer who sees the surface at this cosine at least.
Vec3<double> view_above(Random& random, Vec3<double> normal, double least) {
  Vec3<double> view;
  do view = any_direction(random);
  while (dot(view, normal) < least);
  return view;
}

template <class T>
Vec3<T> view_inside(const Layer<T>& layer, Vec3<T> normal, Vec3<T> view) {
  const T cosine = std::min(dot(normal, view), T(1));
  return (view + normal * (eta_cos_refracted(cosine, layer.eta) - cosine)) / layer.eta;
}

HashKey key_of(Random& random) {
  const auto word = [&] { return static_cast<float>(random.below(1 << 22)); };
  const float x = word(), y = word();
  return {x, y, word()};
}

// A species of this coverage, D H <S>.
void set_coverage(FlakeSpecies& species, double coverage) {
  const double share = area_mean(species.flake_area_spread);
  species.flakes_per_mm2 = rounded(
      coverage / share / (kPi / 4 * species.flake_diameter_um * species.flake_diameter_um) * 1e6);
}

// Paints of one to three species, some of them pearls, of a coverage of 0.02 to 3 in all.
Paint close_paint(Random& random) {
  Paint paint = random_paint(random);
  paint.binder_ior = rounded(random.uniform(1.2, 2));
  const int species = 1 + random.below(3);
  const double coverage = random.log_uniform(0.02, 3);
  for (int i = 0; i < species; ++i) {
    FlakeSpecies some = random_paint(random);
    if (random.below(3) == 0) {
      // r = 1 - t: nothing is lost.
      some.flake_transmission = rounded(Rgb<double>{
          random.uniform(0.1, 0.9), random.uniform(0.1, 0.9), random.uniform(0.1, 0.9)});
      some.flake_color = grey(1.0) - some.flake_transmission;
      some.flake_edge_color = some.flake_color;
    }
    some.flake_edge_color = some.flake_color;
    some.flake_diameter_um = rounded(random.log_uniform(8, 200));
    set_coverage(some, coverage / species);
    (i == 0 ? static_cast<FlakeSpecies&>(paint) : paint.more[static_cast<std::size_t>(i - 1)]) =
        some;
  }
  return paint;
}

// What is left of a test's scenes: each a standard normal deviate if the model is right.
class Comparisons {
 public:
  template <class Named>
  void see(double z, const Named& where) {
    ++count_;
    square_ += z * z;
    if (std::fabs(z) <= std::fabs(worst_)) return;
    worst_ = z;
    std::ostringstream text;
    text << where;
    where_ = text.str();
  }
  void expect_chance() const {
    ASSERT_GT(count_, 0);
    EXPECT_LE(std::fabs(worst_), sidak_threshold(kFreshLevel, count_)) << where_;
    EXPECT_LE(chi_square_z(square_, count_), sidak_threshold(kFreshLevel, 1));
    ::testing::Test::RecordProperty("worst_z", std::to_string(worst_));
    ::testing::Test::RecordProperty("all_z", std::to_string(chi_square_z(square_, count_)));
  }

 private:
  double count_ = 0, square_ = 0, worst_ = 0;
  std::string where_;
};

double z_of(const Moments& found, double expected) {
  return (found.mean() - expected) / found.error_of_mean();
}

TEST(CloseUp, OutlinesHaveAreaOneAndNoCornerBeyondTheirReach) {
  // The polygon that outline() = 1 bounds, by its distance in many directions.
  constexpr int steps = 100'000;
  double area = 0;
  const auto edge = [](int k) {
    const double phi = 2 * kPi * k / steps;
    const double out = 1 / outline(std::cos(phi), std::sin(phi));
    return Vec3<double>{out * std::cos(phi), out * std::sin(phi), 0};
  };
  double farthest = 0;
  for (int k = 0; k < steps; ++k) {
    const Vec3<double> p = edge(k), q = edge(k + 1);
    area += (p.x * q.y - p.y * q.x) / 2;
    for (const double stretch : {1 / kMostStretch, kMostStretch}) {
      for (const double shear : {-kMostShear, kMostShear}) {
        farthest = std::max(farthest, std::hypot(p.x / stretch, (p.y - shear * p.x) * stretch));
      }
    }
  }
  EXPECT_NEAR(area, 1, 1e-7);
  EXPECT_LE(farthest, kOutlineReach);
  EXPECT_GE(farthest, 0.999 * kOutlineReach);
}

TEST(CloseUp, APointIsCoveredAsOftenAsThePoissonLawSays) {
  // Seen is 1 - e^-b, and of the depth of what is seen E[z; seen] = (1 - (1 + b) e^-b)/b: places,
  // areas, tilts and outlines together give each flake the area S |v . m|/cos(theta_p).
  Random random(run_seed());
  Comparisons seen, depths;
  for (int k = 0; k < 200 / kFewer; ++k) {
    TestScene scene;
    scene.paint = close_paint(random);
    const Layer<double> layer = make_layer<double>(scene.paint);
    scene.normal = any_direction(random);
    const OwnAxes own = any_axes(random);
    scene.view = view_above(random, scene.normal, 0.02);
    const Vec3<double> inside = view_inside(layer, scene.normal, scene.view);
    const auto i = static_cast<std::size_t>(random.below(layer.species));
    Moments covered, depth;
    double b = 0;
    for (int draw = 0; draw < 20'000; ++draw) {
      const auto first =
          first_flake(layer, layer.flakes[i], scene.normal, inside, dot(inside, scene.normal),
                      lattice_across(own, scene.normal, random), 0.0, key_of(random));
      b = first.hiding;
      covered.add(first.seen ? 1 : 0);
      depth.add(first.seen ? first.depth : 0);
    }
    scene.light = scene.normal;
    seen.see(z_of(covered, -std::expm1(-b)), scene);
    depths.see(z_of(depth, (1 - (1 + b) * std::exp(-b)) / b), scene);
  }
  seen.expect_chance();
  depths.expect_chance();
}

TEST(CloseUp, TheMeanOfTheSparklesIsTheClosedForms) {
  // For every radiometry, depth model, coverage and angle; of each scene one colour.
  Random random(run_seed() + 1);
  Comparisons means, squares, counts;
  for (int k = 0; k < 150 / kFewer;) {
    TestScene scene;
    scene.paint = close_paint(random);
    aim(scene, random, 3);
    // Squares and counts of every other scene. Of lights wide against the tilt P and cos(alpha) are
    // those of the centre.
    const bool squared = k % 2 == 0;
    if (squared) scene.paint.radiometry = Radiometry::exact;
    scene.light_sine = rounded(random.log_uniform(0.01, squared ? 0.05 : 0.5));
    scene.footprint = 1;
    const Layer<double> layer = make_layer<double>(scene.paint);
    const SurfacePoint<double> point = scene.point<double>();
    const SeenLight<double> light = scene.seen<double>();
    const Passage<double> way = pass_between(layer, point, light);
    const auto i = static_cast<std::size_t>(random.below(layer.species));
    const Flakes<double>& flakes = layer.flakes[i];
    const auto expected = expect_sparkles(layer, flakes, point.footprint, way);
    double mean = channel(mean_radiance(expected), k % 3);
    if (scene.paint.radiometry == Radiometry::published) {
      // Published takes P at the centre of the cone, however wide it is; flakes lie all over it.
      const auto inside = cone_in_binder(flakes, way);
      const auto probability = [&](Radiometry radiometry) {
        return flake_probability(flakes.orientation, radiometry, way.mirror.sin2_half_beta,
                                 quarter_cone(inside, way));
      };
      mean *=
          static_cast<double>(probability(Radiometry::exact) / probability(Radiometry::published));
    }
    // So many samples that about 1,000 show the light.
    const double draws = 1'000 * channel(expected.mirror, k % 3) / mean;
    if (!(draws < 200'000)) continue;
    const OwnAxes own = any_axes(random);
    const Vec3<double> inside = view_inside(layer, scene.normal, scene.view);
    Moments found, square, count;
    double variance = 0, mean_count = 0;
    std::array<FirstFlake<double>, kSpecies> firsts;
    for (FirstFlake<double>& other : firsts) other.close = true;  // and nothing seen of them
    while (found.n < draws) {
      firsts[i] = first_flake(layer, flakes, scene.normal, inside, dot(inside, scene.normal),
                              lattice_across(own, scene.normal, random), 0.0, key_of(random));
      double shown = 0, one = 0;
      if (mirrors(flakes, firsts[i], way)) {
        const auto all = sparkle_at(layer, point, way, 0, 0, firsts);
        shown = channel(all.radiance, k % 3);
        one = all.count;
        variance = channel(flake_radiance_variance(layer, firsts[i], expected, way), k % 3);
        mean_count = all.mean_count;
      }
      found.add(shown);
      square.add(shown * shown);
      count.add(one);
    }
    means.see(z_of(found, mean), scene);
    ++k;
    if (!squared) continue;
    squares.see(z_of(square, variance + mean * mean), scene);
    counts.see(z_of(count, mean_count), scene);
  }
  means.expect_chance();
  squares.expect_chance();
  counts.expect_chance();
}

TEST(CloseUp, FlakesThatTransmitAreSeenThrough) {
  // Samples within a thousandth of a flake have the same flakes over them. A share q of them passes
  // the uppermost over, whichever colour passes more.
  Random random(run_seed() + 4);
  Comparisons shares;
  for (int k = 0; k < 40 / kFewer; ++k) {
    TestScene scene;
    scene.paint = close_paint(random);
    for (int i = 1; i < kSpecies; ++i) scene.paint.more[static_cast<std::size_t>(i - 1)] = {};
    const double t = rounded(random.uniform(0.1, 0.9));
    scene.paint.coating = CoatingKind::colors;
    scene.paint.flake_transmission = {t, rounded(random.uniform(t, 1)), t};
    scene.paint.flake_color = scene.paint.flake_edge_color = {};
    const Layer<double> layer = make_layer<double>(scene.paint);
    scene.normal = any_direction(random);
    const OwnAxes own = any_axes(random);
    scene.view = view_above(random, scene.normal, 0.2);
    const Vec3<double> inside = view_inside(layer, scene.normal, scene.view);
    Moments uppermost;
    for (int spot = 0; spot < 20'000 && uppermost.n < 2'000; ++spot) {
      const LatticePoint<double> at = lattice_across(own, scene.normal, random);
      const HashKey key = key_of(random);
      const auto look = [&] {
        LatticePoint<double> near = at;
        near.a += 1e-3 * layer.flakes[0].diameter * random.uniform();
        near.b += 1e-3 * layer.flakes[0].diameter * random.uniform();
        return first_flake(layer, layer.flakes[0], scene.normal, inside, dot(inside, scene.normal),
                           near, 0.0, key)
            .depth;
      };
      double least = 1;  // the uppermost's, which 80 looks miss with a probability below 1e-7
      for (int place = 0; place < 80; ++place) least = std::min(least, look());
      for (int place = 0; place < 10 && least < 1; ++place) uppermost.add(look() <= least ? 1 : 0);
    }
    scene.light = scene.normal;
    shares.see(z_of(uppermost, 1 - t * t), scene);
  }
  shares.expect_chance();
}

TEST(CloseUp, TheMeanOfTheLobeIsTheClosedForms) {
  Random random(run_seed() + 2);
  Comparisons means;
  for (int k = 0; k < 200 / kFewer; ++k) {
    TestScene scene;
    scene.paint = close_paint(random);
    const Layer<double> layer = make_layer<double>(scene.paint);
    scene.normal = any_direction(random);
    scene.view = view_above(random, scene.normal, 0.02);
    const OwnAxes own = any_axes(random);
    const Vec3<double> inside = view_inside(layer, scene.normal, scene.view);
    const double expected = channel(flake_albedo(layer, scene.normal, scene.view), k % 3);
    Moments found;
    for (int draw = 0; draw < 20'000; ++draw) {
      std::array<FirstFlake<double>, kSpecies> firsts;
      for (std::size_t i = 0; i < static_cast<std::size_t>(layer.species); ++i) {
        // The last of several as in counts, to see them side by side.
        if (i == 2) continue;
        firsts[i] =
            first_flake(layer, layer.flakes[i], scene.normal, inside, dot(inside, scene.normal),
                        lattice_across(own, scene.normal, random), 0.0, key_of(random));
      }
      const auto sample = sample_flake(layer, scene.normal, scene.view, random.uniform(),
                                       random.uniform(), firsts.data());
      found.add(channel(sample.weight, k % 3));
    }
    scene.light = scene.normal;
    means.see((found.mean() - expected) / std::hypot(found.error_of_mean(), 3e-4 * expected),
              scene);
  }
  means.expect_chance();
}

TEST(CloseUp, TheMeanStaysFromFlakesToCounts) {
  // Samples anywhere on a surface whose cells grow from a quarter of a flake to four.
  Random random(run_seed() + 3);
  Comparisons means;
  for (int k = 0; k < 40 / kFewer;) {
    TestScene scene;
    scene.paint = close_paint(random);
    scene.paint.anchor = Anchor::surface;
    scene.paint.radiometry = Radiometry::exact;
    aim(scene, random, 2);
    scene.light_sine = rounded(random.log_uniform(0.05, 0.5));
    const Layer<double> layer = make_layer<double>(scene.paint);
    const Flakes<double>& flakes = layer.flakes[0];
    const double size = random.log_uniform(0.25, 4);
    scene.footprint = size * flakes.flake_area * flakes.area_mean / layer.cell_share;
    SurfacePoint<double> point = scene.point<double>();
    const OwnAxes own = any_axes(random);
    point.own.x = own.axis[0];
    point.own.y = own.axis[1];
    point.own.z = own.axis[2];
    const Passage<double> way = pass_between(layer, point, scene.seen<double>());
    const auto of_first = expect_sparkles(layer, flakes, scene.footprint, way);
    // So many samples that about 400 show the light.
    const double draws = 400 * of_first.mirror.y / mean_radiance(of_first).y;
    if (!(draws < 15'000)) continue;
    Moments found;
    double mean = 0;
    while (found.n < draws) {
      point.own.position = {random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)};
      const int seed = static_cast<int>(random.bits());
      const auto all = sparkle_at(layer, point, way, 0, seed, look_close(layer, point, 0, seed));
      found.add(all.radiance.y);
      mean = all.mean_radiance.y;
    }
    means.see(z_of(found, mean), scene);
    ++k;
  }
  means.expect_chance();
}

}  // namespace
