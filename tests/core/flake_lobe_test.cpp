// SPDX-License-Identifier: Apache-2.0
//
// One random flake for each sample has the mean of the flakes' BRDF.
#include "flake_lobe.h"

#include <array>
#include <cmath>

#include "flake_brdf.h"
#include "scenes.h"
#include "support.h"

namespace {

using namespace core_tests;

TEST(FlakeLobe, SampledTiltsHaveTheMomentsOfP) {
  Worst worst;
  for (int kind = 0; kind < 3; ++kind) {
    for (double tilt : {0.01, 0.15, 0.49, 0.51, 1.0, 100.0}) {
      if (kind > 0 && tilt > 1) continue;
      const auto density = make_orientation<double>(static_cast<Orientation>(kind), tilt);
      // The mean over u of weight and of weight cos(beta), by the rectangle rule.
      constexpr int n = 400'000;
      double one = 0, cosine = 0;
      for (int i = 0; i < n; ++i) {
        const auto sampled = sample_tilt(density, (i + 0.5) / n);
        one += sampled.weight / n;
        cosine += sampled.weight * (1 - 2 * sampled.sin2_half_beta) / n;
      }
      worst.see(std::fabs(one - 1), "kind", kind, "tilt", tilt, "norm");
      worst.see(std::fabs(cosine / density.mean_cos - 1), "kind", kind, "tilt", tilt, "mean");
    }
  }
  worst.expect_at_most(1e-4);  // the rule's error at Beckmann's tail
}

// In (0, 1), exact in float.
template <class T>
T deviate(Random& random) {
  return (static_cast<T>(random.below(1 << 23)) + T(0.5)) * T(0x1p-23);
}

// A random direction of the flake's wide cone, or its own where it has none.
template <class T>
Vec3<double> shown_from(const MirroredSample<T>& sample, Vec3<T> normal, Random& random) {
  const T u = deviate<T>(random), w = deviate<T>(random), e = deviate<T>(random);
  const LobeCone<T> cone = wide_cone(sample, normal, u, w, e);
  const Vec3<double> axis(cone.direction);
  const Vec3<double> some = std::fabs(axis.x) < 0.6 ? Vec3<double>{1, 0, 0} : Vec3<double>{0, 1, 0};
  Vec3<double> across = cross(axis, some);
  across = across / length(across);
  const double half = std::sin(static_cast<double>(cone.half_angle) / 2);
  const double h = half * half * random.uniform(), phi = 2 * std::numbers::pi * random.uniform();
  const Vec3<double> off = across * std::cos(phi) + cross(axis, across) * std::sin(phi);
  return axis * (1 - 2 * h) + off * (2 * std::sqrt(h * (1 - h)));
}

// Sums over caps of directions against the BRDF's integral over them; of the wide cones they may be
// off by that share.
template <class T>
void expect_brdf(std::uint64_t stream, double bias = 0) {
  Random random = fresh(stream);
  Worst worst;
  int judged = 0;
  constexpr int kScenes = 24, kSamples = 60'000, kCaps = 3;
  const double threshold = sidak_threshold(kFreshLevel, kScenes * (kCaps + 1));
  for (int k = 0; k < kScenes; ++k) {
    TestScene scene;
    scene.paint = random_paint(random);
    scene.paint.radiometry = static_cast<Radiometry>(k % 2);
    aim(scene, random, 2);
    const auto layer = scene.layer<double>();
    // Rings about the mirror direction, and everything.
    const Vec3<double> mirror = scene.normal * (2 * dot(scene.normal, scene.view)) - scene.view;
    const std::array<double, kCaps + 2> edges{1, 0.97, 0.85, 0.5, -1};
    std::array<double, kCaps + 1> sum{}, square{};
    const auto sampled_layer = scene.layer<T>();
    for (int i = 0; i < kSamples; ++i) {
      const auto sample = sample_flake<T>(sampled_layer, Vec3<T>(scene.normal), Vec3<T>(scene.view),
                                          deviate<T>(random), deviate<T>(random));
      Vec3<double> shown(sample.direction);
      if (bias > 0) shown = shown_from(sample, Vec3<T>(scene.normal), random);
      const double c = dot(shown, mirror);
      for (std::size_t cap = 0; cap + 1 < edges.size(); ++cap) {
        if (c > edges[cap] || c <= edges[cap + 1]) continue;
        const auto weight = static_cast<double>(sample.weight.y);
        sum[cap] += weight / kSamples;
        square[cap] += weight * weight / kSamples;
      }
    }
    // The integral over the half sphere by the midpoint rule.
    std::array<double, kCaps + 1> exact{};
    constexpr int n = 500;
    for (int a = 0; a < n; ++a) {
      const double cosine = std::sqrt((a + 0.5) / n), sine = std::sqrt(1 - cosine * cosine);
      for (int b = 0; b < n; ++b) {
        const double phi = 2 * std::numbers::pi * (b + 0.5) / n;
        const Vec3<double> light = turned({sine * std::cos(phi), sine * std::sin(phi), cosine});
        const double f = flake_brdf(layer, scene.normal, scene.view, light).y;
        const double c = dot(light, mirror);
        for (std::size_t cap = 0; cap + 1 < edges.size(); ++cap) {
          // cos d omega = pi d(cos^2) d phi/2 pi
          if (c <= edges[cap] && c > edges[cap + 1]) exact[cap] += f * std::numbers::pi / (n * n);
        }
      }
    }
    for (std::size_t cap = 0; cap < exact.size(); ++cap) {
      // Rule and sampling: 2e-3 for the rule (the ring's ragged edge in 500 x 500 cells).
      const double error = std::sqrt((square[cap] - sum[cap] * sum[cap]) / kSamples) +
                           (2e-3 + bias) * exact[cap] / threshold;
      // Rings of fewer than 100 samples' worth have no normal mean.
      if (sum[cap] * sum[cap] * kSamples <= 100 * square[cap]) continue;
      ++judged;
      worst.see(std::fabs(sum[cap] - exact[cap]) / error, "ring", cap, "sampled", sum[cap], "exact",
                exact[cap], scene);
    }
  }
  EXPECT_GE(judged, kScenes * 3);
  worst.expect_at_most(threshold);
}

TEST(FlakeLobe, LongSamplesHaveTheMeanOfTheBrdfInDouble) { expect_brdf<double>(80); }
TEST(FlakeLobe, SamplesHaveTheMeanOfTheBrdfInFloat) { expect_brdf<float>(81); }
TEST(FlakeLobe, SoHaveWideConesButForASmallShare) { expect_brdf<double>(82, 0.03); }
TEST(FlakeLobe, SoHaveTheyInFloat) { expect_brdf<float>(83, 0.03); }

// Of what a smooth part leaves, over rings about the mirror direction: the wide cones beside the
// flakes' own directions.
TEST(FlakeLobe, WideConesShowWhatASmoothPartLeavesWhereItIs) {
  Random random = fresh(85);
  Worst worst;
  constexpr int kScenes = 24, kSamples = 60'000;
  // Of a ring's light, as of all that flakes mirror. More, but never four times as much, in two
  // rings of 25,000: far from the mirror direction of tilts above 0.3, where third derivatives
  // count.
  constexpr double kBias = 0.03, kFarBias = 0.12;
  int beyond = 0;
  const double threshold = sidak_threshold(kFreshLevel, kScenes * 4);
  for (int k = 0; k < kScenes;) {
    TestScene scene;
    scene.paint = random_paint(random);
    aim(scene, random, 2);
    const auto layer = scene.layer<double>();
    const auto part = smooth_part(layer, layer.flakes[0], scene.normal, scene.view);
    if (!(part.narrow.weight.y > 0)) continue;
    ++k;
    std::array<double, 4> whole{}, own{}, square{}, wide{};
    for (int i = 0; i < kSamples; ++i) {
      auto sample =
          sample_flake(layer, scene.normal, scene.view, inside_unit(random.uniform()),
                       random.uniform(), static_cast<FirstFlake<double>*>(nullptr), part.rise);
      const std::size_t at = ring_of(scene, sample.direction);
      whole[at] += sample.weight.y / kSamples;
      leave_beside(sample, part, scene.normal, scene.view);
      own[at] += sample.weight.y / kSamples;
      square[at] += sample.weight.y * sample.weight.y / kSamples;
      const std::size_t shown = ring_of(scene, shown_from(sample, scene.normal, random));
      wide[shown] += sample.weight.y / kSamples;
      square[shown] += sample.weight.y * sample.weight.y / kSamples;
    }
    for (std::size_t ring = 0; ring < 4; ++ring) {
      if (square[ring] * 100 >= own[ring] * own[ring] * kSamples) continue;
      // Both sums' errors; that they share their flakes makes their difference less.
      const double error = std::sqrt(square[ring] / kSamples);
      const double off = std::fabs(wide[ring] - own[ring]);
      if (off > threshold * error + kBias * whole[ring]) ++beyond;
      worst.see(off / (error + kFarBias * whole[ring] / threshold), "ring", ring, "wide",
                wide[ring], "own", own[ring], "whole", whole[ring], scene);
    }
  }
  EXPECT_LE(beyond, 1);
  worst.expect_at_most(threshold);
}

// Above the horizon, and as likely about any of its points.
TEST(FlakeLobe, AWideConeHoldsItsFlakesDirectionAndNothingBelowTheHorizon) {
  Random random = fresh(84);
  int wide = 0;
  for (int k = 0; k < 20'000; ++k) {
    TestScene scene;
    scene.paint = random_paint(random);
    aim(scene, random, 2);
    const auto layer = scene.layer<double>();
    const auto sample =
        sample_flake(layer, scene.normal, scene.view, random.uniform(), random.uniform());
    const auto cone =
        wide_cone(sample, scene.normal, random.uniform(), random.uniform(), random.uniform());
    if (!(cone.half_angle > 0)) continue;
    ++wide;
    const double off = std::acos(std::min(dot(cone.direction, sample.direction), 1.0));
    ASSERT_LE(off, cone.half_angle + 1e-7) << scene;
    ASSERT_LE(std::sin(cone.half_angle), dot(cone.direction, scene.normal) + 1e-12) << scene;
  }
  EXPECT_GT(wide, 5'000);
}

}  // namespace
