// SPDX-License-Identifier: Apache-2.0
//
// A lobe of microfacets shows a part of what flakes mirror, and random flakes the rest.
#include "smooth_part.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "flake_brdf.h"
#include "flake_lobe.h"
#include "scenes.h"
#include "support.h"

namespace {

using namespace core_tests;

struct Shares {
  double shown = 0;   // of f cos(theta') by the lobe
  double beyond = 0;  // what the lobe shows too much, likewise
};

constexpr int kRings = 80;

template <class Visit>
void over_half_sphere(const Visit& visit) {
  for (int a = 0; a < kRings; ++a) {
    const double cosine = (a + 0.5) / kRings, sine = std::sqrt(1 - cosine * cosine);
    for (int b = 0; b < 2 * kRings; ++b) {
      const double phi = std::numbers::pi * (b + 0.5) / kRings;
      visit(turned({sine * std::cos(phi), sine * std::sin(phi), cosine}), cosine);
    }
  }
}

// A paint of one species, seen from where it has a smooth part.
TestScene smooth_scene(Random& random, Orientation orientation) {
  TestScene scene;
  do {
    scene.paint = random_paint(random);
    scene.paint.orientation = orientation;
    aim(scene, random, 2);
  } while (!(dot(scene.normal, scene.view) > kLeastSmooth));
  return scene;
}

Shares shares(const TestScene& scene) {
  const auto layer = scene.layer<double>();
  const auto part = smooth_part(layer, layer.flakes[0], scene.normal, scene.view);
  Shares sum;
  double all = 0;
  over_half_sphere([&](Vec3<double> light, double cosine) {
    const double f = flake_brdf(layer, scene.normal, scene.view, light).y * cosine;
    const double g = part.weight.y > 0 ? part.weight.y * facets_show(part, scene.view, light) : 0;
    all += f;
    sum.shown += std::min(f, g);
    sum.beyond += std::max(g - f, 0.0);
  });
  if (!(all > 0)) return {1, 0};
  return {sum.shown / all, sum.beyond / all};
}

void expect_shares(std::uint64_t stream, Orientation orientation, double median, double beyond) {
  Random random = fresh(stream);
  std::vector<double> shown;
  Worst worst;
  for (int k = 0; k < 40; ++k) {
    const TestScene scene = smooth_scene(random, orientation);
    const Shares found = shares(scene);
    shown.push_back(found.shown);
    worst.see(found.beyond, "shown", found.shown, scene);
  }
  std::sort(shown.begin(), shown.end());
  EXPECT_GT(shown[shown.size() / 2], median);
  worst.expect_at_most(beyond);
}

// Above f it is where f bends, at the horizon and about the middle.
TEST(SmoothPart, ShowsMostOfWhatGaussianFlakesMirrorAndHardlyMore) {
  expect_shares(90, Orientation::gaussian, 0.75, 0.012);
}
TEST(SmoothPart, ShowsMostOfWhatBeckmannsFlakesMirrorAndHardlyMore) {
  expect_shares(91, Orientation::beckmann, 0.75, 0.012);
}
TEST(SmoothPart, ShowsMuchOfWhatGgxFlakesMirrorAndHardlyMore) {
  expect_shares(92, Orientation::ggx, 0.5, 0.012);
}

// The lobe and what it leaves the flakes, over rings about the mirror direction.
TEST(SmoothPart, WithWhatItLeavesTheFlakesIsTheBrdf) {
  Random random = fresh(93);
  Worst worst;
  constexpr int kScenes = 24, kSamples = 60'000;
  const std::array<double, 5> edges{1.1, 0.97, 0.85, 0.5, -1.1};
  const double threshold = sidak_threshold(kFreshLevel, kScenes * 4);
  for (int k = 0; k < kScenes; ++k) {
    const TestScene scene = smooth_scene(random, static_cast<Orientation>(k % 3));
    const auto layer = scene.layer<double>();
    const auto part = smooth_part(layer, layer.flakes[0], scene.normal, scene.view);
    const Vec3<double> mirror = scene.normal * (2 * dot(scene.normal, scene.view)) - scene.view;
    const auto ring_of = [&](Vec3<double> light) {
      std::size_t ring = 0;
      while (dot(light, mirror) <= edges[ring + 1]) ++ring;
      return ring;
    };
    std::array<double, 4> exact{}, lobe{}, sum{}, square{};
    over_half_sphere([&](Vec3<double> light, double cosine) {
      const double area = std::numbers::pi / (kRings * kRings);
      exact[ring_of(light)] += flake_brdf(layer, scene.normal, scene.view, light).y * cosine * area;
      if (part.weight.y > 0) {
        lobe[ring_of(light)] += part.weight.y * facets_show(part, scene.view, light) * area;
      }
    });
    for (int i = 0; i < kSamples; ++i) {
      const auto sample =
          sample_flake(layer, scene.normal, scene.view, random.uniform(), random.uniform());
      const double left = beside(sample, part, scene.view).y;
      sum[ring_of(sample.direction)] += left / kSamples;
      square[ring_of(sample.direction)] += left * left / kSamples;
    }
    const double all = exact[0] + exact[1] + exact[2] + exact[3];
    for (std::size_t ring = 0; ring < 4; ++ring) {
      if (square[ring] * 100 > sum[ring] * sum[ring] * kSamples) continue;
      // The rule's error, and what the lobe may show too much.
      const double error = std::sqrt((square[ring] - sum[ring] * sum[ring]) / kSamples) +
                           (4e-3 * exact[ring] + 0.012 * all) / threshold;
      worst.see(std::fabs(lobe[ring] + sum[ring] - exact[ring]) / error, "ring", ring, "found",
                lobe[ring] + sum[ring], "exact", exact[ring], scene);
    }
  }
  worst.expect_at_most(threshold);
}

}  // namespace
