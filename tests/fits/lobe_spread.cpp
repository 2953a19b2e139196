// SPDX-License-Identifier: Apache-2.0
//
// What kWideShare of core/flake_lobe.h errs: a flake's mirror direction is widened to a cone.
// lobe_spread [SEED] compares what the cones show of round lamps with what plain mirror directions
// do, and these with the BRDF's own integral; likewise the cones beside a smooth part, over the
// light of both, as it is and leaning away from a sun. A table on the output; five minutes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "flake_brdf.h"
#include "mixture_scenes.h"

namespace {

using namespace core_tests;

constexpr int kCases = 48, kSamples = 1 << 22;

struct Lamp {
  Vec3<double> towards;
  double cos_radius;
  bool holds(Vec3<double> d) const { return dot(d, towards) > cos_radius; }
};

// A unit vector at the angle with this cosine from `axis`.
Vec3<double> about(Vec3<double> axis, double cosine, double phi) {
  Vec3<double> across = std::fabs(axis.x) < 0.6 ? Vec3<double>{1, 0, 0} : Vec3<double>{0, 1, 0};
  across = across - axis * dot(axis, across);
  across = across / length(across);
  const Vec3<double> other{axis.y * across.z - axis.z * across.y,
                           axis.z * across.x - axis.x * across.z,
                           axis.x * across.y - axis.y * across.x};
  const double sine = std::sqrt(std::max(1 - cosine * cosine, 0.0));
  return axis * cosine + across * (sine * std::cos(phi)) + other * (sine * std::sin(phi));
}

// What a lamp of radiance 1 shows, by the BRDF.
double exact(const Layer<double>& layer, Vec3<double> view, const Lamp& lamp) {
  constexpr int n = 200;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double cosine = 1 - (1 - lamp.cos_radius) * (i + 0.5) / n;
      const Vec3<double> d = about(lamp.towards, cosine, 2 * std::numbers::pi * (j + 0.5) / n);
      if (d.z > 0) sum += flake_brdf(layer, {0, 0, 1}, view, d).y * d.z;
    }
  }
  return sum * 2 * std::numbers::pi * (1 - lamp.cos_radius) / (n * n);
}

// Likewise by flakes' mirror directions, and by their wide cones: of all that they mirror, or of
// what a smooth part leaves. The deviates are Kronecker's, from the plastic number's kin, and where
// they need not be the same random ones.
std::array<double, 2> by_flakes(const Layer<double>& layer, Vec3<double> view, const Lamp& lamp,
                                const SmoothPart<double>* part, Random& random) {
  constexpr double kStep[] = {0.8566748838545029, 0.7338918566271260, 0.6287067210378087,
                              0.5385972572236101};
  double plain = 0, widened = 0;
  for (int i = 0; i < kSamples; ++i) {
    double at[4];
    for (int k = 0; k < 4; ++k) at[k] = std::fmod((i + 0.5) * kStep[k], 1.0);
    const Vec3<double> normal{0, 0, 1};
    MirroredSample<double> sample =
        sample_flake(layer, normal, view, inside_unit(at[0]), at[1],
                     static_cast<FirstFlake<double>*>(nullptr), part != nullptr ? part->rise : 0.0);
    if (part != nullptr) leave_beside(sample, *part, normal, view);
    if (!(sample.weight.y > 0)) continue;
    const LobeCone<double> cone =
        wide_cone(sample, normal, inside_unit(at[2]), at[3], inside_unit(random.uniform()));
    const double half = std::sin(cone.half_angle / 2);
    const Vec3<double> towards = about(cone.direction, 1 - 2 * half * half * random.uniform(),
                                       2 * std::numbers::pi * random.uniform());
    if (lamp.holds(sample.direction)) plain += sample.weight.y / kSamples;
    if (lamp.holds(towards)) widened += sample.weight.y / kSamples;
  }
  return {plain, widened};
}

void tell(const std::string& name, std::vector<double> errors) {
  std::sort(errors.begin(), errors.end());
  const auto at = [&](double share) {
    return errors[static_cast<std::size_t>(share * static_cast<double>(errors.size() - 1))];
  };
  std::printf("| %s | %.2g | %.2g | %.2g |\n", name.c_str(), at(1), at(0.95), at(0.5));
}

}  // namespace

int main(int argc, char** argv) {
  std::random_device system;
  const std::uint64_t seed = argc > 1 ? std::stoull(argv[1]) : system();
  std::printf(
      "Seed %llu, %d lamps of radii from 0.1 to 0.5 rad about a flake's mirror direction.\n\n",
      static_cast<unsigned long long>(seed), kCases);
  std::printf("| relative error of a lamp's light | largest | 95 %% | median |\n");
  std::printf("| --- | ---: | ---: | ---: |\n");
  std::vector<double> plain, wide, left, leaning;
  Random random(seed);
  for (int i = 0; i < kCases; ++i) {
    const Paint paint = ordinary_paint(random);
    const Layer<double> layer = make_layer<double>(paint);
    const double cos_view = random.uniform(0.3, 1);
    const Vec3<double> view{std::sqrt(1 - cos_view * cos_view), 0, cos_view};
    Lamp lamp{{0, 0, 0}, std::cos(random.log_uniform(0.1, 0.5))};
    const auto above_the_horizon = [&] {
      Vec3<double> towards{};
      do {
        towards =
            sample_flake(layer, {0, 0, 1}, view, random.uniform(), random.uniform()).direction;
      } while (!(towards.z > 0.3 && towards.z < 1));
      return towards;
    };
    lamp.towards = above_the_horizon();
    const auto [by_mirrors, by_cones] = by_flakes(layer, view, lamp, nullptr, random);
    plain.push_back(std::fabs(by_mirrors / exact(layer, view, lamp) - 1));
    wide.push_back(std::fabs(by_cones / by_mirrors - 1));
    SmoothPart<double> part = smooth_part(layer, layer.flakes[0], {0, 0, 1}, view);
    const auto error_beside = [&, of = by_mirrors] {
      const auto [left_to_mirrors, left_to_cones] = by_flakes(layer, view, lamp, &part, random);
      return std::fabs(left_to_cones - left_to_mirrors) / of;
    };
    left.push_back(error_beside());
    const Vec3<double> sun = above_the_horizon();
    const double fall = random.log_uniform(kLeastFall, kMostFall);
    part = lean_away(part, view, sun, fall);
    leaning.push_back(error_beside());
    if ((i + 1) % 20 == 0) std::fprintf(stderr, "%d of %d lamps\n", i + 1, kCases);
  }
  tell("mirror directions, off the BRDF's integral", plain);
  tell("wide cones, off the mirror directions", wide);
  tell("wide cones beside a smooth part, of the light of both", left);
  tell("wide cones beside a smooth part that leans away from a sun, likewise", leaning);
}
