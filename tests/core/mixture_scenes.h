// SPDX-License-Identifier: Apache-2.0
//
// The paints that core/mixture.h states its errors for, and both sides of the comparison: r_s, E
// and M of the model, and the random walk. For the tests and for tests/fits/mixture_error.cpp.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "diffuse_lobe.h"
#include "mixture.h"
#include "reference/optics.h"
#include "reference/random_walk.h"
#include "scenes.h"
#include "whole_paint.h"

namespace core_tests {

template <class T>
Rgb<T> albedo_of(const Paint& paint, Rgb<double> substrate, double cos_view) {
  const Mixture<T> m = mixture(make_layer<T>(paint), Rgb<T>(substrate), static_cast<T>(cos_view));
  return m.diffuse + m.glossy + m.returned;
}

inline double surface_of(const Paint& paint, double cos_view) {
  const double eta = paint.binder_ior;
  return 1 - fresnel_transmittance(cos_view, eta_cos_refracted(cos_view, eta), eta);
}

// E(v): the lobe that the shader renders.
inline Rgb<double> single_scattering(const Paint& paint, double cos_view) {
  const Vec3<double> view{std::sqrt(1 - cos_view * cos_view), 0, cos_view};
  return flake_albedo(make_layer<double>(paint), {0, 0, 1}, view);
}

// One species of metal or pearl in its own colours, over any substrate.
inline Paint ordinary_paint(Random& random, bool lossless = false) {
  const auto colour = [&](double from, double to) {
    return Rgb<double>{random.uniform(from, to), random.uniform(from, to),
                       random.uniform(from, to)};
  };
  Paint paint = undiffracted();
  paint.flake_diameter_um = 10;
  paint.flake_area_spread = 0;
  paint.flakes_per_mm2 = random.log_uniform(0.05, 5) * 4e4 / std::numbers::pi;
  paint.orientation = static_cast<Orientation>(random.below(3));
  paint.tilt = random.log_uniform(0.02, 0.6);
  paint.binder_ior = random.uniform(1.33, 1.8);
  paint.layer_thickness_um = 100;
  // Metal or pearl.
  if (random.below(2) == 0) paint.flake_transmission = colour(0.05, 0.9);
  const Rgb<double> most = grey(1.0) - paint.flake_transmission;
  paint.flake_color = lossless ? most : most * colour(0.1, 1);
  paint.flake_edge_color = lossless ? most : most * colour(0.4, 1);
  if (!lossless && random.below(2) == 0) paint.binder_absorption_per_mm = colour(0, 10);
  if (random.below(3) == 0) paint.rayleigh_per_mm = random.log_uniform(0.03, 1);
  return paint;
}

// Likewise, of one to three species with coatings of the library.
inline Paint library_paint(Random& random) {
  Paint paint = ordinary_paint(random);
  const int used = 1 + random.below(3);
  const double coverage = random.log_uniform(0.05, 5) / used;
  const auto species = [&] {
    return library_species(random, coverage * random.uniform(0.5, 1.5),
                           random.log_uniform(0.02, 0.6));
  };
  static_cast<FlakeSpecies&>(paint) = species();
  for (int i = 1; i < used; ++i) paint.more[static_cast<std::size_t>(i - 1)] = species();
  return paint;
}

// Pearls on silica turn over quickly with the angle, and err most.
inline bool has_silica(const Paint& paint) {
  for (int i = 0; i < kSpecies; ++i) {
    const FlakeSpecies& flakes = paint.species(i);
    if (is_on_silica(flakes.coating) && flakes.flakes_per_mm2 > 0) return true;
  }
  return false;
}

// Likewise lossless, all of titania on mica, or all on silica.
inline Paint lossless_pearl(Random& random, bool on_mica) {
  Paint paint = library_paint(random);
  paint.binder_absorption_per_mm = {};
  const auto pearl = [&](FlakeSpecies& flakes) {
    flakes.coating = on_mica                ? CoatingKind::tio2_on_mica
                     : random.below(2) == 0 ? CoatingKind::tio2_on_silica
                                            : CoatingKind::tio2_on_thin_silica;
  };
  pearl(paint);
  for (FlakeSpecies& more : paint.more) pearl(more);
  return paint;
}

// A paint over a substrate, seen under uniform light.
struct SeenPaint {
  Paint paint;
  Rgb<double> substrate;
  double cos_view;
};

// One view in four is along the normal.
inline SeenPaint over_any_substrate(Random& random, const Paint& paint) {
  const double cos_view = random.below(4) == 0 ? 1 : random.uniform(0.08, 1);
  const double bright = random.below(2) == 0 ? 1 : 0.2;
  const double r = random.uniform(), g = random.uniform(), b = random.uniform();
  return {paint, Rgb<double>{r, g, b} * bright, cos_view};
}

inline SeenPaint over_white(Random& random, const Paint& paint) {
  return {paint, grey(1.0), random.below(4) == 0 ? 1 : random.uniform(0.05, 1)};
}

// A view near the normal, one aslant or one near grazing.
inline SeenPaint over_black(Random& random, const Paint& paint) {
  const int slant = random.below(3);
  return {paint, grey(0.05), slant == 0 ? 0.97 : slant == 1 ? 0.7 : 0.35};
}

// Likewise of Depth Model correlated: discs of 0.05 to 2 of the layer's thickness, no pigment.
inline SeenPaint correlated(Random& random, SeenPaint seen) {
  Paint& paint = seen.paint;
  paint.depth_model = DepthModel::correlated;
  paint.layer_thickness_um = paint.flake_diameter_um / random.log_uniform(0.05, 2);
  paint.rayleigh_per_mm = 0;
  return seen;
}

// What r_s + E + M is off 1, in the worst colour.
inline double furnace_error(const SeenPaint& seen) {
  const Rgb<double> sum = grey(surface_of(seen.paint, seen.cos_view)) +
                          single_scattering(seen.paint, seen.cos_view) +
                          albedo_of<double>(seen.paint, seen.substrate, seen.cos_view);
  return max_component(map(sum - grey(1.0), [](double x) { return std::fabs(x); }));
}

// Of these most of the mixture is the diffuse lobe's.
inline SeenPaint mostly_diffuse(Random& random) {
  for (;;) {
    SeenPaint seen = over_any_substrate(
        random, random.below(3) == 0 ? library_paint(random) : ordinary_paint(random));
    const double slants[] = {1, 0.966, 0.707};
    seen.cos_view = slants[random.below(3)];
    const Mixture<double> m =
        mixture(make_layer<double>(seen.paint), seen.substrate, seen.cos_view);
    if (m.diffuse.x > 0.02 && m.diffuse.x > 3 * m.glossy.x) return seen;
  }
}

// Of these most of the mixture is the glossy lobe's.
inline bool is_shiny(const Paint& paint) {
  return paint.rayleigh_per_mm == 0 && paint.tilt < 0.3 && reference::flake_coverage(paint) > 1;
}

inline reference::WalkScene walk_scene(const SeenPaint& seen, std::size_t photons,
                                       std::uint64_t seed) {
  reference::WalkScene scene;
  scene.paint = seen.paint;
  scene.substrate = seen.substrate;
  scene.light = {-std::sqrt(1 - seen.cos_view * seen.cos_view), 0, seen.cos_view};
  scene.photons = photons;
  scene.seed = seed;
  return scene;
}

// E + M.
inline reference::Estimate walked_albedo(const SeenPaint& seen, std::size_t photons,
                                         std::uint64_t seed) {
  return reference::walk(walk_scene(seen, photons, seed)).albedo.total;
}

// --- by angle --------------------------------------------------------------------------------

// pi f of the glossy lobe, scaled to the albedo 1 by an integral of its own; the light is at
// azimuth pi.
class GlossyLobe {
 public:
  GlossyLobe(double cos_light, double alpha)
      : exponent_(glossy_exponent(alpha)),
        mirrored_(std::sqrt(1 - cos_light * cos_light), 0, cos_light) {
    // cos^n about the mirror image is uniform in u = its integral from the pole.
    constexpr int kPolar = 120, kAzimuths = 60;
    double sum = 0;
    for (int i = 0; i < kPolar; ++i) {
      const double cosine = std::pow((i + 0.5) / kPolar, 1 / (exponent_ + 1));
      const double sine = std::sqrt(1 - cosine * cosine);
      for (int j = 0; j < kAzimuths; ++j) {
        const double phi = 2 * std::numbers::pi * (j + 0.5) / kAzimuths;
        sum += std::max(cosine * cos_light - sine * mirrored_.x * std::cos(phi), 0.0);
      }
    }
    albedo_ = sum / (kPolar * kAzimuths);
  }

  double operator()(Vec3<double> view) const {
    const double along = dot(mirrored_, view);
    return along > 0 ? (exponent_ + 1) / 2 * std::pow(along, exponent_) / albedo_ : 0;
  }

 private:
  double exponent_;
  Vec3<double> mirrored_;
  double albedo_ = 1;
};

// CIE 1976 of a reflectance factor.
inline double lightness(double y) {
  return y > 216.0 / 24389 ? 116 * std::cbrt(y) - 16 : 24389.0 / 27 * y;
}

// Eleven directions in the plane of incidence, two across.
inline constexpr int kDirections = 13;
inline std::vector<Vec3<double>> directions() {
  std::vector<Vec3<double>> all;
  for (double theta : {-75.0, -60.0, -45.0, -30.0, -15.0, 0.0, 15.0, 30.0, 45.0, 60.0, 75.0}) {
    const double angle = theta * std::numbers::pi / 180;
    all.push_back({std::sin(angle), 0, std::cos(angle)});
    if (theta == 30 || theta == 60) all.push_back({0, std::sin(angle), std::cos(angle)});
  }
  return all;
}

// Reflectance factors of the walk in red, towards each direction.
struct ByAngle {
  std::array<double, kDirections> single, whole;
};

inline ByAngle walked_by_angle(const SeenPaint& seen, std::size_t photons, std::uint64_t seed) {
  reference::WalkScene scene = walk_scene(seen, photons, seed);
  scene.detectors = directions();
  const reference::WalkResult walked = reference::walk(scene);
  ByAngle factors{};
  for (std::size_t i = 0; i < kDirections; ++i) {
    const reference::ByComponent& brdf = walked.brdf[i];
    factors.single[i] = std::numbers::pi * brdf.part[reference::single_flake].mean.x;
    factors.whole[i] = std::numbers::pi * brdf.total.mean.x;
  }
  return factors;
}

// pi f of the diffuse lobe for the albedo 1, in red.
inline double diffuse_factor(const Ramp<double>& ramp, double cos_light) {
  return ramp_at(ramp, cos_light).x / cos_light;
}

// What the diffuse and the glossy lobe show of lights across the plane of the view, over what the
// walk does, without single flakes; in red.
struct Slanted {
  double shown, walked, single;  // reflectance factors
  double ratio() const { return shown / walked; }
};

inline std::vector<Slanted> under_slants(const SeenPaint& seen, const std::vector<double>& degrees,
                                         std::size_t photons, std::uint64_t seed) {
  const Mixture<double> m = mixture(make_layer<double>(seen.paint), seen.substrate, seen.cos_view);
  reference::WalkScene scene = walk_scene(seen, photons, seed);
  for (const double slant : degrees) {
    const double angle = slant * std::numbers::pi / 180;
    scene.detectors.push_back({0, std::sin(angle), std::cos(angle)});
  }
  const reference::WalkResult walked = reference::walk(scene);
  const GlossyLobe glossy(seen.cos_view, m.alpha);
  const Ramp<double> ramp = make_ramp(make_layer<double>(seen.paint));
  std::vector<Slanted> all;
  for (std::size_t i = 0; i < degrees.size(); ++i) {
    const Vec3<double> light = scene.detectors[i];
    const double shown = m.diffuse.x * diffuse_factor(ramp, light.z) + m.glossy.x * glossy(light);
    const double whole = std::numbers::pi * walked.brdf[i].total.mean.x;
    const double single = std::numbers::pi * walked.brdf[i].part[reference::single_flake].mean.x;
    all.push_back({shown, whole - single, single});
  }
  return all;
}

// Of single flakes and mixture together, the root mean square over the directions; and what it
// would be with one diffuse lobe for all of the mixture.
struct LightnessError {
  double two_lobes, diffuse;
};

inline LightnessError lightness_error(const SeenPaint& seen, const Mixture<double>& m,
                                      const ByAngle& walked) {
  const std::vector<Vec3<double>> views = directions();
  const GlossyLobe lobe(seen.cos_view, m.alpha);
  const Ramp<double> ramp = make_ramp(make_layer<double>(seen.paint));
  LightnessError error{};
  for (std::size_t i = 0; i < kDirections; ++i) {
    const double wanted = lightness(walked.whole[i]);
    const double slanted = diffuse_factor(ramp, views[i].z);
    const double matt = walked.single[i] + m.diffuse.x * slanted;
    const double off = lightness(matt + m.glossy.x * lobe(views[i])) - wanted;
    const double flat = lightness(matt + m.glossy.x * slanted) - wanted;
    error.two_lobes += off * off / kDirections;
    error.diffuse += flat * flat / kDirections;
  }
  return {std::sqrt(error.two_lobes), std::sqrt(error.diffuse)};
}

}  // namespace core_tests
