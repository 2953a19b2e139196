// SPDX-License-Identifier: Apache-2.0
//
// Wherever a renderer may go, numbers stay finite and not negative: in double and in float.
#include <cmath>
#include <limits>
#include <vector>

#include "scenes.h"
#include "sparkles.h"
#include "support.h"

namespace {

using namespace core_tests;

template <class T>
bool sound(T value) {
  return std::isfinite(value) && value >= 0;
}
template <class T>
bool sound(Rgb<T> c) {
  return sound(c.x) && sound(c.y) && sound(c.z);
}

constexpr double kEtas[] = {0.5, 0.999999, 1 - 1e-12, 1, 1 + 1e-12, 1.5, 4};
// Angles to the normal: along it, ordinary, 1e-9 rad and 1e-9 degrees off the surface.
constexpr double kCosines[] = {1, 0.5, 1e-4, 1e-9, 1.7453292519943295e-11};

Vec3<double> direction(double cosine, double phi) {
  const double sine = std::sqrt((1 - cosine) * (1 + cosine));
  return {sine * std::cos(phi), sine * std::sin(phi), cosine};
}

// Calls visit(scene) for every pair of directions.
template <class Visit>
void for_directions(TestScene scene, const Visit& visit) {
  scene.normal = {0, 0, 1};
  for (double view : kCosines) {
    for (double light : kCosines) {
      for (double phi : {0.0, 1.0, 3.14159265358979}) {
        scene.view = direction(view, 0);
        scene.light = direction(light, phi);
        visit(scene);
      }
    }
  }
}

template <class T>
void expect_sound(const TestScene& scene, const Layer<T>& layer) {
  const auto expected = expect_sparkles(layer, scene.point<T>(), scene.seen<T>());
  const Rgb<T> mean = mean_radiance(expected), variance = radiance_variance(expected);
  const auto drawn = draw_sparkles(expected, layer.area_spread, stream_key(1, 0, 2, 3), 5, 7);
  const Rgb<T> brdf =
      flake_brdf(layer, Vec3<T>(scene.normal), Vec3<T>(scene.view), Vec3<T>(scene.light));
  const char* type = sizeof(T) == 4 ? "float" : "double";
  ASSERT_TRUE(sound(expected.mean_count)) << type << ' ' << expected.mean_count << ' ' << scene;
  ASSERT_TRUE(sound(expected.fill)) << type << ' ' << expected.fill << ' ' << scene;
  ASSERT_TRUE(sound(expected.ceiling)) << type << ' ' << expected.ceiling << ' ' << scene;
  ASSERT_TRUE(sound(expected.slant)) << type << ' ' << expected.slant.x << ' ' << scene;
  ASSERT_TRUE(sound(mean)) << type << " mean " << mean.x << ' ' << scene;
  ASSERT_TRUE(sound(variance)) << type << " variance " << variance.x << ' ' << scene;
  ASSERT_TRUE(sound(drawn.count)) << type << ' ' << drawn.count << ' ' << scene;
  ASSERT_TRUE(sound(drawn.radiance)) << type << " drawn " << drawn.radiance.x << ' ' << scene;
  ASSERT_LE(max_component(drawn.radiance), expected.ceiling) << type << ' ' << scene;
  ASSERT_TRUE(sound(brdf)) << type << ' ' << brdf.x << ' ' << scene;
}

void expect_sound_everywhere(TestScene scene) {
  const auto wide = scene.layer<double>();
  const auto narrow = scene.layer<float>();
  for_directions(scene, [&](const TestScene& s) {
    if (testing::Test::HasFatalFailure()) return;
    expect_sound(s, wide);
    expect_sound(s, narrow);
  });
}

TEST(Extremes, IndicesLightsAndDirections) {
  for (double eta : kEtas) {
    for (double light : {0.0, 1e-9, 1e-4, 0.3, 1.0}) {
      for (double spread : {0.0, 0.005, 0.5}) {
        for (int kind = 0; kind < 3; ++kind) {
          for (double tilt : {1e-6, 0.15, 1.0, 100.0}) {
            if (kind > 0 && tilt > 1) continue;
            TestScene scene;
            scene.paint.binder_ior = eta;
            scene.paint.flake_spread = spread;
            scene.paint.orientation = static_cast<Orientation>(kind);
            scene.paint.tilt = tilt;
            scene.paint.radiometry = static_cast<Radiometry>(kind % 2);
            scene.light_sine = light;
            scene.footprint = 1e-8;
            expect_sound_everywhere(scene);
          }
        }
      }
    }
  }
}

TEST(Extremes, OpticalDepths) {
  for (double depth : {0.0, 1e-16, 1e-8, 1.0, 80.0, 1e6}) {
    for (int model = 0; model < 2; ++model) {
      for (double flakes : {1e-3, 3000.0, 1e9}) {
        TestScene scene;
        scene.paint.depth_model = static_cast<DepthModel>(model);
        scene.paint.flakes_per_mm2 = flakes;
        scene.paint.layer_thickness_um = 1000;
        scene.paint.binder_absorption_per_mm = {0, depth / 2, depth};
        scene.light_sine = 0.01;
        scene.footprint = 1e-6;
        expect_sound_everywhere(scene);
      }
    }
  }
}

TEST(Extremes, Footprints) {
  for (double footprint : {1e-30, 1e-20, 1e-15, 1e-12, 1e-6, 1.0, 1e6, 1e12, 1e20, 1e30}) {
    for (double spread : {0.0, 0.3, 100.0}) {
      for (double diameter : {1e-3, 20.0, 1e5}) {
        for (double flakes : {1e-3, 1e9}) {
          for (int model = 0; model < 2; ++model) {
            TestScene scene;
            scene.paint.depth_model = static_cast<DepthModel>(model);
            scene.paint.flake_area_spread = spread;
            scene.paint.flake_diameter_um = diameter;
            scene.paint.flakes_per_mm2 = flakes;
            scene.light_sine = 0.01;
            scene.footprint = footprint;
            expect_sound_everywhere(scene);
          }
        }
      }
    }
  }
}

TEST(Extremes, RandomValidPaints) {
  // Every parameter anywhere in its allowed range.
  Random random(50);
  for (int k = 0; k < 4'000 && !HasFatalFailure(); ++k) {
    TestScene scene;
    Paint& p = scene.paint;
    const auto colour = [&](double most) {
      return Rgb<double>{random.uniform(0, most), random.uniform(0, most), random.uniform(0, most)};
    };
    p.flakes_per_mm2 = random.log_uniform(1e-6, 1e9);
    p.flake_diameter_um = random.log_uniform(1e-3, 1e5);
    p.flake_area_spread = random.below(3) == 0 ? 0 : random.log_uniform(1e-3, 100);
    p.orientation = static_cast<Orientation>(random.below(3));
    p.tilt = random.log_uniform(1e-6, p.orientation == Orientation::gaussian ? 100 : 1);
    p.flake_spread = random.below(3) == 0 ? 0 : random.log_uniform(1e-9, 0.5);
    p.flake_color = colour(0.5);
    p.flake_edge_color = colour(0.5);
    p.flake_transmission = colour(0.5);
    p.binder_ior = random.log_uniform(0.1, 10);
    p.layer_thickness_um = random.log_uniform(1e-6, 1e6);
    p.binder_absorption_per_mm = colour(random.log_uniform(1e-9, 1e6));
    p.rayleigh_per_mm = random.below(2) == 0 ? 0 : random.log_uniform(1e-9, 1e6);
    p.depth_model = static_cast<DepthModel>(random.below(2));
    p.radiometry = static_cast<Radiometry>(random.below(2));
    scene.light_sine = random.below(4) == 0 ? 0 : random.log_uniform(1e-9, 1);
    scene.footprint = random.log_uniform(1e-30, 1e30);
    ASSERT_NO_THROW(validate(p)) << scene;
    expect_sound_everywhere(scene);
  }
}

}  // namespace
