// SPDX-License-Identifier: Apache-2.0
//
// What the returning lobe of core/mixture.h errs: exp(c k) of core/hot_spot.h beside exp(c far) and
// the lobe, over lights of the whole hemisphere; beside it what k = 0 errs, and the best diffuse
// lobe. The light enters by its cosine times 1 - r; so errors are those of what is seen.
//
//   returning_fit [CASES [SEED]]
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

constexpr double kPi = std::numbers::pi;

struct Ray {
  Vec3<double> direction;
  double weight;  // by the cosine, of grazing light at least as of 8.6 degrees above the surface
};

std::vector<Ray> lights() {
  constexpr int kRings = 40, kSectors = 36;
  std::vector<Ray> all;
  for (int i = 0; i < kRings; ++i) {
    const double cosine = (i + 0.5) / kRings;
    for (int j = 0; j < kSectors; ++j) {
      all.push_back(
          {spherical(std::acos(cosine), 2 * kPi * (j + 0.5) / kSectors), std::max(cosine, 0.15)});
    }
  }
  return all;
}

// Mean and mean square of ln(found/wanted).
struct Error {
  double sum = 0, square = 0, weights = 0;
  std::vector<double> sizes{};
  void see(double ratio, double weight) {
    const double off = std::log(ratio);
    sum += weight * off;
    square += weight * off * off;
    weights += weight;
    sizes.push_back(std::fabs(off));
  }
  double mean() const { return sum / weights; }
  double about_mean() const { return square / weights - mean() * mean(); }
};

void tell(const char* name, double mean_square, std::vector<double> sizes) {
  std::sort(sizes.begin(), sizes.end());
  const auto at = [&](double share) {
    return sizes[static_cast<std::size_t>(share * static_cast<double>(sizes.size() - 1))];
  };
  std::printf("| %s | %.3f | %.3f | %.3f | %.3f |\n", name, std::sqrt(mean_square), at(0.5),
              at(0.95), at(1));
}

}  // namespace

int main(int argc, char** argv) {
  const int cases = argc > 1 ? std::stoi(argv[1]) : 1000;
  const std::uint64_t seed = argc > 2 ? std::stoull(argv[2]) : std::random_device{}();
  Random random(seed);
  const std::vector<Ray> all = lights();
  const Vec3<double> up{0, 0, 1};
  double lobe = 0, none = 0, flat = 0;
  std::vector<double> lobe_sizes, none_sizes, flat_sizes;
  for (int k = 0; k < cases; ++k) {
    Paint paint = undiffracted();
    paint.depth_model = DepthModel::correlated;
    paint.binder_ior = random.uniform(1.4, 1.7);
    paint.flake_diameter_um = paint.layer_thickness_um * random.log_uniform(0.1, 2);
    const double coverage = random.log_uniform(0.1, 2.5);
    paint.flakes_per_mm2 = coverage * 4e6 / (kPi * std::pow(paint.flake_diameter_um, 2));
    paint.flake_area_spread = 0;
    paint.orientation = Orientation::beckmann;
    paint.tilt = random.uniform(0.04, 0.35);
    const Layer<double> layer = make_layer<double>(paint);
    const double slant = random.uniform(0, 80 * kPi / 180), eta = layer.eta;
    const Vec3<double> view = spherical(slant, 0);
    const double g = eta_cos_refracted(view.z, eta), c = layer.shared_blocking.y;
    const DiffuseSurface<double> surface = diffuse_surface(eta);
    const Returning<double> back = returning(layer, surface, {c, c, c}, g / eta, view.z);
    const Vec3<double> axis = returning_normal(up, view);
    // Of a white substrate under flakes that lose nothing on the way to it.
    const double far = back.far.y / back.free.y, more = (std::exp(c) - far) * back.lobe;
    Error of_lobe, of_none;
    for (const Ray& light : all) {
      const Vec3<double> l = light.direction;
      const double g_light = eta_cos_refracted(l.z, eta);
      const double entered = l.z * fresnel_transmittance(l.z, g_light, eta) / (eta * eta * kPi);
      const double k_here =
          holes_in_common(layer, ways_apart(up, view, view.z, g, l, l.z, g_light));
      const double wanted = entered * std::exp(c * k_here);
      const double found = entered * far + more * phong_lobe(axis, view, l, back.exponent);
      of_lobe.see(found / wanted, light.weight);
      of_none.see(entered / wanted, light.weight);
    }
    lobe += of_lobe.square / of_lobe.weights / cases;
    none += of_none.square / of_none.weights / cases;
    flat += of_none.about_mean() / cases;
    lobe_sizes.insert(lobe_sizes.end(), of_lobe.sizes.begin(), of_lobe.sizes.end());
    none_sizes.insert(none_sizes.end(), of_none.sizes.begin(), of_none.sizes.end());
    for (const Ray& light : all) {
      const Vec3<double> l = light.direction;
      const double k_here = holes_in_common(
          layer, ways_apart(up, view, view.z, g, l, l.z, eta_cos_refracted(l.z, eta)));
      flat_sizes.push_back(std::fabs(c * k_here + of_none.mean()));
    }
  }
  std::printf("Seed %llu, %d cases.\n\n", static_cast<unsigned long long>(seed), cases);
  std::printf("| ln of what is seen over exp(c k) | root mean square | median | 95 %% | worst |\n");
  std::printf("| --- | ---: | ---: | ---: | ---: |\n");
  tell("diffuse and returning lobe", lobe, lobe_sizes);
  tell("the best diffuse lobe alone", flat, flat_sizes);
  tell("independent ways", none, none_sizes);
}
