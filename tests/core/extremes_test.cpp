// SPDX-License-Identifier: Apache-2.0
//
// Wherever a renderer may go, numbers stay finite and not negative, in double and in float, no
// operation is invalid, divides by zero or overflows, and limits are the right ones.
#include <cfenv>
#include <cmath>
#include <limits>
#include <vector>

#include "composition.h"
#include "diffuse_lobe.h"
#include "flake_brdf.h"
#include "flake_lobe.h"
#include "mixture.h"
#include "phong_lobe.h"
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
// Angles to the normal: along it, ordinary, 1e-9 rad and 1e-9 degrees off the surface, and as close
// to it as is seen.
constexpr double kCosines[] = {1, 0.5, 1e-4, 1e-9, 1.7453292519943295e-11, 1.8 * kLeastCosine};

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
  std::feclearexcept(FE_ALL_EXCEPT);
  const SurfacePoint<T> point = scene.point<T>();
  const auto expected = expect_sparkles(layer, point, scene.seen<T>());
  const Rgb<T> mean = mean_radiance(expected), variance = radiance_variance(expected);
  const auto drawn = draw_sparkles(expected, stream_key(1, 0, 2, 3));
  const auto all = sparkle_at(layer, point, pass_between(layer, point, scene.seen<T>()), 1, 2,
                              look_close(layer, point, 1, 2));
  const Mixture<T> scattered = mixture(layer, Rgb<T>{T(0.9), T(0.5), T(0.02)},
                                       std::max(dot(point.normal, point.view), T(0)));
  const T shine = highlight(point.normal, point.view, Vec3<T>(scene.light),
                            static_cast<T>(scene.light_sine) / 4, T(0.3), T(0.5));
  const Rgb<T> brdf =
      flake_brdf(layer, Vec3<T>(scene.normal), Vec3<T>(scene.view), Vec3<T>(scene.light));
  const auto lobe = sample_flake(layer, Vec3<T>(scene.normal), Vec3<T>(scene.view), T(0.7), T(0.3));
  const Ramp<T> ramp = make_ramp(layer);
  const T glossy =
      phong_albedo(seen_cosine(point.normal, point.view), glossy_exponent(scattered.alpha));
  const int raised = std::fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
  const char* type = sizeof(T) == 4 ? "float" : "double";
  ASSERT_EQ(raised, 0) << type << " floating-point exceptions " << raised << ' ' << scene;
  ASSERT_TRUE(sound(expected.mean_count)) << type << ' ' << expected.mean_count << ' ' << scene;
  ASSERT_TRUE(sound(expected.fill)) << type << ' ' << expected.fill << ' ' << scene;
  ASSERT_TRUE(sound(expected.ceiling)) << type << ' ' << expected.ceiling << ' ' << scene;
  ASSERT_TRUE(sound(expected.slant)) << type << ' ' << expected.slant.x << ' ' << scene;
  ASSERT_TRUE(sound(mean)) << type << " mean " << mean.x << ' ' << scene;
  ASSERT_TRUE(sound(variance)) << type << " variance " << variance.x << ' ' << scene;
  ASSERT_TRUE(sound(drawn.count)) << type << ' ' << drawn.count << ' ' << scene;
  ASSERT_TRUE(sound(drawn.radiance)) << type << " drawn " << drawn.radiance.x << ' ' << scene;
  ASSERT_LE(max_component(drawn.radiance), expected.ceiling) << type << ' ' << scene;
  ASSERT_TRUE(sound(all.radiance)) << type << " all " << all.radiance.x << ' ' << scene;
  ASSERT_TRUE(sound(all.mean_radiance)) << type << " all " << all.mean_radiance.x << ' ' << scene;
  ASSERT_TRUE(sound(scattered.diffuse)) << type << ' ' << scattered.diffuse.x << ' ' << scene;
  ASSERT_TRUE(sound(scattered.glossy)) << type << ' ' << scattered.glossy.x << ' ' << scene;
  ASSERT_TRUE(sound(scattered.returned)) << type << ' ' << scattered.returned.x << ' ' << scene;
  ASSERT_GE(scattered.exponent, T(1)) << type << ' ' << scene;
  ASSERT_LE(scattered.exponent, T(kMostExponent)) << type << ' ' << scene;
  ASSERT_GE(scattered.above, T(0.5)) << type << ' ' << scene;
  ASSERT_LE(scattered.above, T(1)) << type << ' ' << scene;
  ASSERT_LE(max_component(scattered.diffuse + scattered.glossy + scattered.returned), T(1))
      << type << ' ' << scene;
  ASSERT_TRUE(scattered.alpha > 0 && scattered.alpha <= 1) << type << ' ' << scattered.alpha;
  for (const Rgb<T>& colour : ramp.colours) {
    ASSERT_TRUE(sound(colour)) << type << ' ' << colour.x << ' ' << scene;
  }
  ASSERT_TRUE(sound(ramp.foot)) << type << ' ' << ramp.foot.x << ' ' << scene;
  ASSERT_TRUE(sound(glossy) && glossy > 0) << type << ' ' << glossy << ' ' << scene;
  ASSERT_TRUE(sound(shine)) << type << " highlight " << shine << ' ' << scene;
  ASSERT_TRUE(sound(lobe.weight)) << type << " lobe " << lobe.weight.x << ' ' << scene;
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
    for (int model = 0; model < 3; ++model) {
      for (double flakes : {1e-3, 3000.0, 1e9}) {
        TestScene scene;
        scene.paint.depth_model = static_cast<DepthModel>(model);
        scene.paint.flakes_per_mm2 = flakes;
        scene.paint.layer_thickness_um = depth > 0 ? 1000 : 0;
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
          for (int model = 0; model < 3; ++model) {
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

TEST(Extremes, LongRandomValidPaints) {
  Random random = fresh(50);
  for (int k = 0; k < 4'000 && !HasFatalFailure(); ++k) {
    TestScene scene;
    scene.paint = any_paint(random);
    scene.light_sine = random.below(4) == 0 ? 0 : random.log_uniform(1e-9, 1);
    scene.footprint = random.log_uniform(1e-30, 1e30);
    ASSERT_NO_THROW(validate(scene.paint)) << scene;
    expect_sound_everywhere(scene);
  }
}

// The four rounding modes move every last place: results that depend on them do so by their own
// rounding only (Kahan's test).
class RoundingModes : public testing::TestWithParam<int> {
 protected:
  void TearDown() override { std::fesetround(FE_TONEAREST); }
};

// |d ln P/d beta| at the scene's flake: what a rounding of the directions does to P.
double slope_of_density(const TestScene& scene) {
  const auto flakes = scene.layer<double>().flakes[0].orientation;
  const auto at = [&](double beta) {
    const double half = std::sin(beta / 2);
    return std::log(orientation_density(flakes, half * half));
  };
  const double step = 1e-3 * scene.paint.tilt;
  return std::fabs(at(scene.beta + step) - at(scene.beta)) / step;
}

template <class T>
void expect_stable(const std::string& type, int mode, double ulps) {
  Random random = same_scenes(51);
  Worst count, mean, variance;
  for (int k = 0; k < 3'000; ++k) {
    TestScene scene;
    scene.paint = random_paint(random);
    aim(scene, random, 3);
    scene.light_sine = rounded(random.log_uniform(1e-4, 0.3));
    set_count(scene, random.log_uniform(0.01, 1e4));
    scene = rounded(scene);
    const auto nearest = scene.expect<T>();
    std::fesetround(mode);
    const auto moved = scene.expect<T>();
    const T moved_mean = mean_radiance(moved).y, moved_variance = radiance_variance(moved).y;
    std::fesetround(FE_TONEAREST);
    // One more or less of a pixel's places is no rounding.
    if (moved.slots != nearest.slots) continue;
    const auto see = [&](Worst& worst, T a, T b) {
      const long double off = relative_error(a, b) / std::numeric_limits<T>::epsilon();
      worst.see(off / (1 + slope_of_density(scene)), scene);
    };
    see(count, moved.mean_count, nearest.mean_count);
    see(mean, moved_mean, mean_radiance(nearest).y);
    if (nearest.slots == 0) see(variance, moved_variance, radiance_variance(nearest).y);
  }
  count.expect_at_most(ulps, type + "_count");
  mean.expect_at_most(ulps, type + "_mean");
  variance.expect_at_most(2 * ulps, type + "_variance");
}

TEST_P(RoundingModes, MoveResultsByTheirRounding) {
  // 9 and 23 were the largest of 63 runs like this one. float: the directions' own rounding.
  expect_stable<double>("double", GetParam(), 16);
  expect_stable<float>("float", GetParam(), 40);
}

INSTANTIATE_TEST_SUITE_P(All, RoundingModes,
                         testing::Values(FE_DOWNWARD, FE_UPWARD, FE_TOWARDZERO));

// The paint face on: light, observer and flakes along the normal.
TestScene face_on() {
  TestScene scene;
  scene.normal = scene.view = scene.light = {0, 0, 1};
  scene.light_sine = 0.01;
  scene.footprint = 1e-4;
  scene.paint.flake_area_spread = 0;
  scene.paint.flake_spread = 0;
  return scene;
}

TEST(Limits, NothingPaintedShowsNothing) {
  TestScene scene = face_on();
  scene.paint.flakes_per_mm2 = 0;
  EXPECT_EQ(scene.expect<double>().mean_count, 0);
  EXPECT_EQ(mean_radiance(scene.expect<double>()).x, 0);
  scene = face_on();
  scene.footprint = 0;
  EXPECT_EQ(scene.expect<double>().mean_count, 0);
}

TEST(Limits, ThinLayersLetAllThroughAndThickOnesShowTheirTop) {
  TestScene scene = face_on();
  scene.paint.flakes_per_mm2 = 1e-3;
  const double clear = mean_radiance(scene.expect<double>()).x;
  // A = (1 - e^-x)/x with x = 2 H kappa: 1 - x/2 for small x, 1/x for large.
  for (double depth : {1e-16, 1e-12, 1e-8}) {
    scene.paint.layer_thickness_um = 1;
    scene.paint.binder_absorption_per_mm = {depth / 2 * 1e3, 0, 0};
    EXPECT_NEAR(mean_radiance(scene.expect<double>()).x / clear, 1 - depth / 2, 1e-15);
  }
  scene.paint.layer_thickness_um = 1e6;
  scene.paint.binder_absorption_per_mm = {500, 0, 0};
  EXPECT_NEAR(mean_radiance(scene.expect<double>()).x / clear, 1e-6, 1e-12);
}

TEST(Limits, LightOfNoSizeIsTheLimitOfSmallOnes) {
  TestScene scene = face_on();
  scene.paint.flake_spread = 0.005;
  scene.light_sine = 0;
  const auto none = scene.expect<double>();
  scene.light_sine = 1e-9;
  const auto small = scene.expect<double>();
  // epsilon^2 + Delta^2/eta^2.
  EXPECT_LE(relative_error(small.mean_count, none.mean_count), 1e-13);
  EXPECT_LE(relative_error(mean_radiance(small).x, mean_radiance(none).x), 1e-13);
  EXPECT_GT(none.mean_count, 0);
}

TEST(Limits, SpikeIsAMirrorOrNothing) {
  // Level flakes under a light of 3 degrees: all of them sparkle, or none.
  TestScene scene = face_on();
  scene.paint.tilt = 1e-6;
  scene.light_sine = 0.05;
  const double flakes = scene.paint.flakes_per_mm2 * 1e6 * scene.footprint;
  EXPECT_NEAR(scene.expect<double>().mean_count / flakes, 1, 1e-12);
  EXPECT_NEAR(static_cast<double>(scene.expect<float>().mean_count) / flakes, 1, 1e-4);
  // Turned by less than the light's radius it still holds the mirror direction, by more it does
  // not.
  for (double off : {0.04, 0.06}) {
    scene.light = spherical(off, 1);
    EXPECT_NEAR(scene.expect<double>().mean_count / flakes, off < 0.05 ? 1 : 0, 1e-12) << off;
    EXPECT_NEAR(static_cast<double>(scene.expect<float>().mean_count) / flakes, off < 0.05 ? 1 : 0,
                1e-4)
        << off;
  }
}

TEST(Limits, FlatOrientationIsEvenOverTheHalfSphere) {
  // P = 1, p = 1/2pi: a quarter cone of solid angle w holds w/2pi of the flakes.
  TestScene scene = face_on();
  scene.paint.tilt = 100;
  const double outside =
      4 * std::numbers::pi * static_cast<double>(scene.seen<double>().sin2_half_radius);
  const double inside = outside / (scene.paint.binder_ior * scene.paint.binder_ior);
  const double flakes = scene.paint.flakes_per_mm2 * 1e6 * scene.footprint;
  // To (pi/2)^2/(2 tilt^2), what the Gaussian still falls by.
  EXPECT_NEAR(scene.expect<double>().mean_count / (flakes * inside / (8 * std::numbers::pi)), 1,
              1.3e-4);
}

TEST(Limits, GrazingMeansFallWithTheSurfaceTransmittance) {
  // 1 - r and cos(theta') go to zero like the cosine; seen along the surface, E[T] = cos(theta') f
  // with f ~ (1 - r)/cos(theta_p): linear in both cosines.
  TestScene scene = face_on();
  const auto mean = [&](double view, double light) {
    scene.view = {std::sqrt((1 - view) * (1 + view)), 0, view};
    scene.light = {-std::sqrt((1 - light) * (1 + light)), 0, light};
    return mean_radiance(scene.expect<double>()).x;
  };
  EXPECT_NEAR(mean(1e-9, 0.5) / mean(1e-7, 0.5), 1e-2, 1e-7);
  EXPECT_NEAR(mean(0.5, 1e-9) / mean(0.5, 1e-7), 1e-4, 1e-9);
  EXPECT_NEAR(mean(1e-11, 1e-11) / mean(1e-9, 1e-9), 1e-6, 1e-11);
}

TEST(Limits, GrazingWithoutRefractionShowsTheTopmostFlakes) {
  // Along the surface A = (1 - e^-x)/x falls like 1/x, the cosine, and f like A/cos^2: cos f
  // stands.
  TestScene scene = face_on();
  scene.paint.binder_ior = 1;
  const auto brdf = [&](double cosine) {
    scene.view = {std::sqrt((1 - cosine) * (1 + cosine)), 0, cosine};
    scene.light = {-scene.view.x, 0, cosine};
    return flake_brdf(scene.layer<double>(), scene.normal, scene.view, scene.light).x * cosine;
  };
  EXPECT_NEAR(brdf(1e-9) / brdf(1e-6), 1, 1e-5);
  EXPECT_NEAR(brdf(1.7e-11) / brdf(1e-6), 1, 1e-5);
}

TEST(Limits, IndexOneIsTheLimitOfItsNeighbours) {
  TestScene scene = face_on();
  scene.view = spherical(0.7, 0);
  scene.light = spherical(0.6, 3);
  const auto at = [&](double eta) {
    scene.paint.binder_ior = eta;
    return mean_radiance(scene.expect<double>()).x;
  };
  EXPECT_NEAR(at(1 + 1e-12) / at(1), 1, 1e-10);
  EXPECT_NEAR(at(1 - 1e-12) / at(1), 1, 1e-10);
}

TEST(Limits, TotalReflectionShowsNothing) {
  TestScene scene = face_on();
  scene.paint.binder_ior = 0.5;
  scene.view = spherical(0.5236, 0);  // beyond asin(0.5)
  EXPECT_EQ(scene.expect<double>().mean_count, 0);
  EXPECT_EQ(scene.expect<float>().mean_count, 0);
}

TEST(Limits, ScenesOfAnyScaleAndPlaceLookTheSame) {
  // A point light and its pixel, scaled, and far from the origin: double resolves 1e-10 there.
  const auto seen = [](double scale, double away) {
    const Vec3<double> origin{away, -away, away};
    const Light<double> light{LightKind::positional, Vec3<double>{1, 2, 5} * scale + origin,
                              0.1 * scale};
    return see_light(light, Vec3<double>{0.3, 0.1, 0} * scale + origin);
  };
  const auto plain = seen(1, 0);
  for (double scale : {1e-6, 1e6}) {
    const auto scaled = seen(scale, 0);
    EXPECT_NEAR(static_cast<double>(scaled.direction.x - plain.direction.x), 0, 1e-15);
    EXPECT_NEAR(static_cast<double>(scaled.sin2_half_radius / plain.sin2_half_radius), 1, 1e-14);
  }
  const auto far = seen(1, 1e6);
  EXPECT_NEAR(static_cast<double>(far.direction.x - plain.direction.x), 0, 1e-10);
  EXPECT_NEAR(static_cast<double>(far.sin2_half_radius / plain.sin2_half_radius), 1, 1e-9);
  // Pixels and flakes scaled alike hold as many of them.
  TestScene scene = face_on();
  const double count = scene.expect<double>().mean_count;
  scene.paint.flakes_per_mm2 *= 1e4;
  scene.footprint *= 1e-4;
  EXPECT_NEAR(scene.expect<double>().mean_count / count, 1, 1e-14);
}

TEST(Limits, CountlessSparklesAreTheirMean) {
  TestScene scene = face_on();
  scene.paint.flakes_per_mm2 = 1e9;
  set_count(scene, 1e15);
  const auto expected = scene.expect<double>();
  const auto drawn = draw_sparkles(expected, stream_key(0, 0, 1, 2));
  const double deviation = std::sqrt(radiance_variance(expected).x) / mean_radiance(expected).x;
  EXPECT_LE(deviation, 1e-4);  // depths vary, hardly anything else
  EXPECT_NEAR(drawn.radiance.x / mean_radiance(expected).x, 1, 6 * deviation);
  set_count(scene, 1e-300);
  EXPECT_EQ(draw_sparkles(scene.expect<double>(), stream_key(0, 0, 1, 2)).count, 0);
}

}  // namespace
