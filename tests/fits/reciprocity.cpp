// SPDX-License-Identifier: Apache-2.0
//
// What the whole paint lacks in reciprocity: light and view change places. Its albedos depend on
// the view alone, the shapes of its lobes on the light; flakes in their mean are reciprocal. Fresh
// paints of core/mixture.h's law over any substrate, pairs of directions of all azimuths whose
// cosines are even from 0.08 to 1; red.
//
//   reciprocity [PAINTS [SEED]]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "mixture_scenes.h"
#include "whole_paint.h"

namespace {

using namespace core_tests;

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5));
}

Vec3<double> direction(Random& random) {
  return spherical(std::acos(random.uniform(0.08, 1)), random.uniform(0, 2 * std::numbers::pi));
}

// f of the whole and of all but single flakes.
struct Seen {
  double whole, rest;
};

Seen seen(const Paint& paint, const Layer<double>& layer, Vec3<double> view, Vec3<double> light) {
  const Vec3<double> up{0, 0, 1};
  SurfacePoint<double> point{};
  point.normal = up;
  point.view = view;
  const Stack<double> stack = make_stack(paint, layer, point, up);
  const double rest = stack.coat.rest * scattered_by(stack, point, light).x / light.z;
  return {rest + stack.coat.rest * flake_brdf(layer, up, view, light).x, rest};
}

void tell(const char* name, const std::vector<double>& off) {
  std::printf("| %s | %.3f | %.3f | %.3f | %.2f |\n", name, quantile(off, 0.5), quantile(off, 0.9),
              quantile(off, 0.95), quantile(off, 1));
}

}  // namespace

int main(int argc, char** argv) {
  const int paints = argc > 1 ? std::stoi(argv[1]) : 1000;
  const std::uint64_t seed = argc > 2 ? std::stoull(argv[2]) : std::random_device{}();
  constexpr int kPairs = 20;
  std::printf("Seed %llu, %d paints, %d pairs of directions each.\n\n",
              static_cast<unsigned long long>(seed), paints, kPairs);
  std::printf("| ln of f over f with light and view changed | median | 90 %% | 95 %% | worst |\n");
  std::printf("| --- | ---: | ---: | ---: | ---: |\n");
  for (const DepthModel model : {DepthModel::correlated, DepthModel::attenuated}) {
    Random random(seed);
    std::vector<double> whole, rest;
    for (int k = 0; k < paints; ++k) {
      SeenPaint some = over_any_substrate(random, ordinary_paint(random));
      some.paint.depth_model = model;
      some.paint.substrate_color = some.substrate;
      const Layer<double> layer = make_layer<double>(some.paint);
      for (int i = 0; i < kPairs; ++i) {
        const Vec3<double> a = direction(random), b = direction(random);
        const Seen there = seen(some.paint, layer, a, b), back = seen(some.paint, layer, b, a);
        if (!(there.rest > 1e-4 && back.rest > 1e-4)) continue;  // as good as black
        whole.push_back(std::fabs(std::log(there.whole / back.whole)));
        rest.push_back(std::fabs(std::log(there.rest / back.rest)));
      }
    }
    const bool correlated = model == DepthModel::correlated;
    tell(correlated ? "correlated: whole paint" : "attenuated: whole paint", whole);
    tell(correlated ? "correlated: without single flakes" : "attenuated: without single flakes",
         rest);
  }
}
