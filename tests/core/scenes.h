// SPDX-License-Identifier: Apache-2.0
//
// Random paints under random lights, all of them ordinary, and their evaluation: by the core in any
// number type, and as the independent reference sees them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <ostream>
#include <string>
#include <type_traits>

#include "independent.h"
#include "paint.h"
#include "reference/transmitted_area.h"
#include "sparkles.h"
#include "support.h"

namespace core_tests {

using namespace metallic_paint;

// The independent formulas know the flake's own spread alone: what diffraction adds to it, and no
// more than that, is in paint_test.cpp. They know pixels alone: cells are in anchor_test.cpp.
inline Paint undiffracted() {
  Paint paint;
  paint.anchor = Anchor::pixel;
  paint.diffraction = Diffraction::none;
  paint.depth_model = DepthModel::attenuated;  // as the random walk is; others where they are meant
  return paint;
}

// A paint, a pixel of it and a light. Every number but the directions is a float.
struct TestScene {
  Paint paint = undiffracted();
  Vec3<double> normal, view, light;
  double light_sine = 0;  // of the angular radius
  double footprint = 0;
  double beta = 0;  // roughly, for messages

  template <class T>
  Layer<T> layer() const {
    return make_layer<T>(paint);
  }
  template <class T>
  SurfacePoint<T> point() const {
    return {{}, Vec3<T>(normal), Vec3<T>(view), static_cast<T>(footprint), 0, 0};
  }
  template <class T>
  SeenLight<T> seen() const {
    return see_light<T>({LightKind::parallel, Vec3<T>(light), static_cast<T>(light_sine)}, {});
  }
  template <class T>
  ExpectedSparkles<T> expect() const {
    return expect_sparkles(layer<T>(), point<T>(), seen<T>());
  }
};

// The sparkles of a light at a point, none of which is seen close up unless `firsts` says so.
template <class T>
PixelSparkles<T> sparkle_at(const Layer<T>& layer, const SurfacePoint<T>& point,
                            const Passage<T>& way, int frame = 0, int seed = 0,
                            const std::array<FirstFlake<T>, kSpecies>& firsts = {}) {
  return sparkle(layer, point, firsts, cell_of_counts(layer, point, firsts, frame, seed), way, 0,
                 frame, seed);
}

inline std::ostream& operator<<(std::ostream& out, const TestScene& s) {
  const Paint& p = s.paint;
  out.precision(9);
  return out << "[flakes/mm2 " << p.flakes_per_mm2 << ", diameter " << p.flake_diameter_um
             << " um, area spread " << p.flake_area_spread << ", orientation "
             << static_cast<int>(p.orientation) << ", tilt " << p.tilt << ", flake spread "
             << p.flake_spread << ", colour " << p.flake_color.x << ' ' << p.flake_color.y << ' '
             << p.flake_color.z << ", transmission " << p.flake_transmission.x << ", ior "
             << p.binder_ior << ", layer " << p.layer_thickness_um << " um, absorption "
             << p.binder_absorption_per_mm.x << ' ' << p.binder_absorption_per_mm.y << ' '
             << p.binder_absorption_per_mm.z << " /mm, rayleigh " << p.rayleigh_per_mm
             << " /mm, depth model " << static_cast<int>(p.depth_model) << ", radiometry "
             << static_cast<int>(p.radiometry) << ", contrast " << p.sparkle_contrast
             << ", cos view " << dot(s.normal, s.view) << ", cos light " << dot(s.normal, s.light)
             << ", beta " << s.beta << ", light sine " << s.light_sine << ", footprint "
             << s.footprint << " m2]";
}

inline Vec3<double> any_direction(Random& random) {
  const double z = random.uniform(-1, 1), phi = random.uniform(0, 2 * std::numbers::pi);
  const double sine = std::sqrt((1 - z) * (1 + z));
  return {sine * std::cos(phi), sine * std::sin(phi), z};
}

inline double rounded(double value) { return static_cast<double>(static_cast<float>(value)); }
inline Rgb<double> rounded(Rgb<double> v) { return {rounded(v.x), rounded(v.y), rounded(v.z)}; }

// Rounds the directions as well, so that float and double start alike.
inline TestScene rounded(TestScene scene) {
  scene.normal = rounded(scene.normal);
  scene.view = rounded(scene.view);
  scene.light = rounded(scene.light);
  return scene;
}

inline Paint random_paint(Random& random) {
  const auto colour = [&](double from, double to) {
    return Rgb<double>{random.uniform(from, to), random.uniform(from, to),
                       random.uniform(from, to)};
  };
  Paint paint = undiffracted();
  paint.flakes_per_mm2 = rounded(random.log_uniform(30, 30'000));
  // Coverages D H <S> from 0.003 to 3.
  const double coverage = random.log_uniform(0.003, 3);
  paint.flake_diameter_um =
      rounded(1e3 * std::sqrt(coverage / paint.flakes_per_mm2 * 4 / std::numbers::pi));
  paint.flake_area_spread = random.below(4) == 0 ? 0 : rounded(random.uniform(0, 0.8));
  paint.orientation = static_cast<Orientation>(random.below(3));
  paint.tilt = rounded(random.log_uniform(0.05, 0.5));
  paint.flake_spread = random.below(4) == 0 ? 0 : rounded(random.log_uniform(1e-3, 0.05));
  paint.flake_color = rounded(colour(0.3, 0.9));
  paint.flake_edge_color = rounded(colour(0.5, 1));
  paint.flake_transmission = random.below(2) == 0 ? Rgb<double>{} : rounded(colour(0, 0.1));
  paint.binder_ior = rounded(random.uniform(1.05, 2.2));
  paint.layer_thickness_um = rounded(random.log_uniform(3, 100));
  paint.binder_absorption_per_mm = random.below(2) == 0 ? Rgb<double>{} : rounded(colour(0, 30));
  paint.rayleigh_per_mm = random.below(2) == 0 ? 0 : rounded(random.uniform(0, 1));
  paint.depth_model = static_cast<DepthModel>(random.below(3));
  paint.radiometry = static_cast<Radiometry>(random.below(2));
  return paint;
}

// Every parameter anywhere in its allowed range.
inline Paint any_paint(Random& random) {
  Paint p;
  const auto colour = [&](double most) {
    return Rgb<double>{random.uniform(0, most), random.uniform(0, most), random.uniform(0, most)};
  };
  // First all that the table has, then what is to be otherwise.
  const auto anywhere_in = [&](auto& of) {
    return [&](const char*, auto member, const auto& range) {
      using Value = std::remove_cvref_t<decltype(of.*member)>;
      if constexpr (std::is_enum_v<Value>) {
        of.*member = static_cast<Value>(random.below(static_cast<int>(range.size())));
      } else if constexpr (std::is_same_v<Value, double>) {
        of.*member = random.log_uniform(std::max(range.least, 1e-9 * range.most), range.most);
      } else if constexpr (std::is_same_v<Value, Rgb<double>>) {
        of.*member = colour(range.most);
      }
    };
  };
  each_paint_parameter(anywhere_in(p));
  const auto fill = [&](FlakeSpecies& f) {
    each_flake_parameter(anywhere_in(f));
    f.flakes_per_mm2 = random.log_uniform(1e-6, 1e9);
    f.flake_diameter_um = random.log_uniform(1e-3, 1e5);
    f.flake_area_spread = random.below(3) == 0 ? 0 : random.log_uniform(1e-3, 100);
    f.orientation = static_cast<Orientation>(random.below(3));
    f.tilt = random.log_uniform(1e-6, f.orientation == Orientation::gaussian ? 100 : 1);
    f.flake_spread = random.below(3) == 0 ? 0 : random.log_uniform(1e-9, 0.5);
    f.flake_color = colour(0.5);
    f.flake_edge_color = colour(0.5);
    f.flake_transmission = colour(0.5);
    f.coating = static_cast<CoatingKind>(random.below(2) * random.below(kCoatingKinds));
    f.coating_nm = random.uniform(0, kMostCoatingNm);
  };
  fill(p);
  if (random.below(2) == 0) fill(p.more[0]);
  if (random.below(3) == 0) fill(p.more[1]);
  p.diffraction = static_cast<Diffraction>(random.below(2));
  p.binder_ior = random.log_uniform(0.1, 10);
  p.layer_thickness_um = random.log_uniform(1e-6, 1e6);
  p.binder_absorption_per_mm = colour(random.log_uniform(1e-9, 1e6));
  p.rayleigh_per_mm = random.below(2) == 0 ? 0 : random.log_uniform(1e-9, 1e6);
  p.depth_model = static_cast<DepthModel>(random.below(3));
  p.radiometry = static_cast<Radiometry>(random.below(2));
  p.composition = static_cast<Composition>(random.below(2));
  p.sparkle_contrast = random.below(3) == 0 ? random.uniform(0, 1) : random.below(2);
  p.substrate_color = colour(random.below(2));
  p.texture_contrast = random.below(2) * random.log_uniform(1e-9, 1);
  p.coat_roughness = random.below(2) * random.log_uniform(1e-9, 1);
  p.orange_peel = random.below(2) * random.log_uniform(1e-9, 1);
  p.orange_peel_mm = random.log_uniform(1e-3, 1e6);
  p.seed = static_cast<int>(random.bits());
  p.frame = static_cast<int>(random.bits());
  return p;
}

// Flakes of any coating of the library, `coverage` of them.
inline FlakeSpecies library_species(Random& random, double coverage, double tilt) {
  FlakeSpecies flakes;
  flakes.flake_diameter_um = random.log_uniform(5, 40);
  flakes.flake_area_spread = 0;
  flakes.flakes_per_mm2 =
      coverage * 4e6 / (std::numbers::pi * flakes.flake_diameter_um * flakes.flake_diameter_um);
  flakes.orientation = static_cast<Orientation>(random.below(3));
  flakes.tilt = tilt;
  flakes.coating = static_cast<CoatingKind>(1 + random.below(kCoatingKinds - 1));
  flakes.coating_nm = random.uniform(0, 200);
  return flakes;
}

// The layer's optical depth along a direction of the cosine cos_in in the binder, where the core's
// own takes four flakes for all that a ray meets.
inline Rgb<double> exact_slant_depth(const Layer<double>& layer, double cos_in) {
  Rgb<double> blocking{};
  for (int i = 0; i < layer.species; ++i) {
    const Flakes<double>& flakes = layer.flakes[static_cast<std::size_t>(i)];
    const Rgb<double> blocked =
        grey(mean_projected_area(flakes.orientation, cos_in)) -
        reference::mean_transmitted_area(flakes.orientation, flakes.coating, cos_in);
    blocking = blocking + blocked * flakes.coverage;
  }
  return slant_depth(blocking, layer.binder_depth, cos_in);
}

inline double channel(Rgb<double> c, int i) { return i == 0 ? c.x : i == 1 ? c.y : c.z; }

inline Vec3<double> spherical(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

// Turns the z axis into an oblique normal.
inline Vec3<double> turned(Vec3<double> v) {
  const double a = 0.7, b = 1.1;
  const Vec3<double> w{v.x * std::cos(a) + v.z * std::sin(a), v.y,
                       v.z * std::cos(a) - v.x * std::sin(a)};
  const Vec3<double> u{w.x * std::cos(b) - w.y * std::sin(b), w.x * std::sin(b) + w.y * std::cos(b),
                       w.z};
  return u / length(u);
}

// Aims the light by a flake of an angle that occurs: up to `tilts` times the tilt.
// `oblique` turns the scene, so that no coordinate is special.
inline void aim(TestScene& scene, Random& random, double tilts, bool oblique = true) {
  const double eta = scene.paint.binder_ior;
  for (;;) {
    const Vec3<double> view = spherical(random.uniform(0, 1.4), random.uniform(0, 6.28));
    const double beta = random.uniform(0, std::min(tilts * scene.paint.tilt, 1.2));
    const Vec3<double> flake = spherical(beta, random.uniform(0, 6.28));
    const Vec3<double> v{view.x / eta, view.y / eta, eta_cos_refracted(view.z, eta) / eta};
    const Vec3<double> l = flake * (2 * dot(flake, v)) - v;
    const Vec3<double> out{l.x * eta, l.y * eta, 0};
    const double sine = length(out);
    if (l.z <= 0 || sine > 0.98) continue;
    const Vec3<double> light{out.x, out.y, std::sqrt(1 - sine * sine)};
    const auto place = [&](Vec3<double> d) { return oblique ? turned(d) : d; };
    scene.normal = place({0, 0, 1});
    scene.view = place(view);
    scene.light = place(light);
    scene.beta = beta;
    return;
  }
}

// A pixel that a light and a paint give about `count` sparkles.
inline void set_count(TestScene& scene, double count) {
  scene.footprint = 1;
  const double per_area = scene.expect<double>().mean_count;
  // Beyond these sizes the core takes a pixel for one at the end.
  scene.footprint = rounded(std::clamp(count / per_area, 1e-20, 1e6));
}

inline independent::Scene reference_scene(const TestScene& s) {
  using independent::Colour;
  using Real = long double;
  const auto colour = [](Rgb<double> c) { return Colour{c.x, c.y, c.z}; };
  const auto vector = [](Vec3<double> v) { return independent::Vector{v.x, v.y, v.z}; };
  const Paint& p = s.paint;
  const Real diameter = static_cast<Real>(p.flake_diameter_um) * 1e-6L;
  return {.flakes_per_m2 = static_cast<Real>(p.flakes_per_mm2) * 1e6L,
          .flake_area = independent::kPi / 4 * diameter * diameter,
          .area_spread = p.flake_area_spread,
          .orientation = {static_cast<int>(p.orientation), p.tilt},
          .flake_spread = p.flake_spread,
          .normal_reflectance = colour(p.flake_color),
          .grazing_reflectance = colour(p.flake_edge_color),
          .transmittance = colour(p.flake_transmission),
          .eta = p.binder_ior,
          .thickness = static_cast<Real>(p.layer_thickness_um) * 1e-6L,
          .absorption = colour(p.binder_absorption_per_mm * 1e3),
          .rayleigh = static_cast<Real>(p.rayleigh_per_mm) * 1e3L,
          .thinned = p.depth_model == DepthModel::thinned,
          .correlated = p.depth_model == DepthModel::correlated,
          .published = p.radiometry == Radiometry::published,
          .normal = vector(s.normal),
          .view = vector(s.view),
          .light = vector(s.light),
          .light_radius = std::asin(static_cast<Real>(s.light_sine)),
          .footprint = s.footprint};
}

// Four rings about the mirror direction of the view, from the innermost.
inline std::size_t ring_of(const TestScene& scene, Vec3<double> light) {
  const Vec3<double> mirror = scene.normal * (2 * dot(scene.normal, scene.view)) - scene.view;
  const double c = dot(light, mirror);
  return c > 0.97 ? 0 : c > 0.85 ? 1 : c > 0.5 ? 2 : 3;
}

// Whether the light is so narrow against the tilt that P at its centre serves for all of it.
inline bool is_narrow(const TestScene& scene) {
  const auto mirror = mirror_between(scene.normal, scene.view, scene.light, scene.paint.binder_ior);
  const double sine = scene.light_sine, spread = scene.paint.flake_spread;
  const double outside = 2 * std::numbers::pi * sine * sine / (1 + std::sqrt(1 - sine * sine));
  const double inside =
      outside * solid_angle_ratio(mirror.cos_light, mirror.g_light, scene.paint.binder_ior) +
      std::numbers::pi * spread * spread;
  // The quarter cone's solid angle 4 pi sin^2(rho/2) = inside/(4 cos(alpha)).
  const double half = std::sqrt(inside / (16 * std::numbers::pi * mirror.cos_alpha));
  return 2 * std::asin(std::min(half, 1.0)) < kPointCap * scene.paint.tilt * (1 - 1e-12);
}

}  // namespace core_tests
