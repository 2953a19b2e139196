// SPDX-License-Identifier: Apache-2.0
//
// The greatest of sparkles and the rest, and the highlight that it needs.
#include "composition.h"

#include <cmath>

#include "rough_surface.h"
#include "support.h"

namespace {

using namespace core_tests;
using namespace metallic_paint;

TEST(Composition, TheSumHasTheGreaterLuminance) {
  Random random = fresh(7);
  for (int i = 0; i < 1000; ++i) {
    const auto colour = [&] {
      return Rgb<double>{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
    };
    const Rgb<double> sparkles = colour() * random.log_uniform(1e-3, 1e3), base = colour();
    const Rgb<double> added = greatest(sparkles, base);
    EXPECT_GE(std::min({added.x, added.y, added.z}), 0);
    EXPECT_NEAR(luminance(base + added), std::max(luminance(base), luminance(sparkles)),
                1e-12 * luminance(base + added));
  }
  EXPECT_EQ(luminance(greatest<double>({}, {})), 0);
}

// The share of the light that the rough highlight sends back, twice: over the views, and over GGX's
// facet normals m (tan^2 = alpha^2 u/(1 - u)), which mirror G(view) G(light) (view . m)/(cos(light)
// cos(m)) each.
TEST(Composition, TheRoughHighlightReflectsWhatItsFacetsDo) {
  const Vec3<double> n{0, 0, 1}, light{0.2, 0, std::sqrt(0.96)};
  for (double alpha : {0.05, 0.2, 0.6}) {
    const int rows = 4000, columns = 100;
    const auto smith = [alpha](double c) {
      return 2 / (1 + std::sqrt(1 + alpha * alpha * (1 / (c * c) - 1)));
    };
    double by_view = 0, by_facet = 0;
    for (int i = 0; i < rows; ++i) {
      const double u = (i + 0.5) / rows;
      for (int j = 0; j < columns; ++j) {
        const double phi = 2 * std::numbers::pi * (j + 0.5) / columns;
        const auto towards = [&](double z) {
          const double sine = std::sqrt(1 - z * z);
          return Vec3<double>{sine * std::cos(phi), sine * std::sin(phi), z};
        };
        by_view += highlight(n, towards(u), light, 0.0, alpha, 1.0) * u;
        const Vec3<double> m = towards(1 / std::sqrt(1 + alpha * alpha * u / (1 - u)));
        const double facing = dot(m, light);
        const Vec3<double> view = m * (2 * facing) - light;
        if (facing > 0 && view.z > 0) {
          by_facet += smith(view.z) * smith(light.z) * facing / (light.z * m.z);
        }
      }
    }
    by_view *= 2 * std::numbers::pi / (rows * columns) / light.z;
    by_facet /= rows * columns;
    EXPECT_NEAR(by_view, by_facet, 2e-3) << alpha;
    EXPECT_LT(by_view, 1) << alpha;
  }
}

TEST(Composition, TheRoughCoatReflectsWhatItsFacetsDo) {
  for (double eta : {1.05, 1.2, 1.33, 1.5, 1.8, 2.4}) {
    double squares = 0;
    int cases = 0;
    for (double roughness : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1.0}) {
      for (double cosine : {0.02, 0.05, 0.1, 0.17, 0.3, 0.5, 0.7, 0.9, 1.0}) {
        const double facets = reflected_by_facets(cosine, roughness * roughness, eta);
        const double off = make_coat(cosine, roughness, eta).reflected - facets;
        EXPECT_LT(std::fabs(off), eta < 1.2 ? 0.09 : 0.035)
            << "eta " << eta << " roughness " << roughness << " cosine " << cosine;
        squares += off * off;
        ++cases;
      }
    }
    EXPECT_LT(std::sqrt(squares / cases), eta < 1.2 ? 0.02 : 0.01) << eta;
  }
}

TEST(Composition, TheCoatLosesNothing) {
  for (double eta : {0.5, 1.0, 1.5, 3.0}) {
    for (double roughness : {0.0, 0.01, 0.5, 1.0}) {
      for (double cosine : {1e-4, 0.1, 0.7, 1.0}) {
        const Coat<double> coat = make_coat(cosine, roughness, eta);
        const double passed = fresnel_transmittance(cosine, eta_cos_refracted(cosine, eta), eta);
        EXPECT_NEAR(coat.reflected + coat.rest * passed, 1, 1e-12);
        EXPECT_GE(coat.reflected, 0);
        EXPECT_LE(coat.reflected, 1);
        if (roughness == 0) {
          EXPECT_EQ(coat.rest, 1);
        }
      }
    }
  }
}

TEST(Composition, TheSmoothHighlightIsTheLightsDisc) {
  const Vec3<double> n{0, 0, 1}, view{0.6, 0, 0.8}, mirrored{-0.6, 0, 0.8};
  const double sin2_half = 1e-4;  // of an angular radius of 0.02
  // One over the solid angle of the disc, 2 pi (1 - cos).
  const double disc = 1 / (2 * std::numbers::pi * 2 * sin2_half);
  EXPECT_DOUBLE_EQ(highlight<double>(n, view, mirrored, sin2_half, 0, 0.04), 0.04 * disc);
  const Vec3<double> near{-0.6 * std::cos(0.019), 0.6 * std::sin(0.019), 0.8};
  EXPECT_GT(highlight<double>(n, view, near / length(near), sin2_half, 0, 0.04), 0);
  const Vec3<double> off{-0.6 * std::cos(0.05), 0.6 * std::sin(0.05), 0.8};
  EXPECT_EQ(highlight<double>(n, view, off / length(off), sin2_half, 0, 0.04), 0);
  // A smaller one is as large as the least image, and as bright in all; so is a point.
  const double least = 0.04 / (4 * std::numbers::pi * kLeastImage);
  EXPECT_NEAR(std::sqrt(kLeastImage), std::sin(std::numbers::pi / 180 / 4), 1e-5);
  EXPECT_DOUBLE_EQ(highlight<double>(n, view, mirrored, 5e-6, 0, 0.04), least);
  EXPECT_DOUBLE_EQ(highlight<double>(n, view, mirrored, 0, 0, 0.04), least);
  EXPECT_EQ(highlight<double>(n, view, {0.6, 0, -0.8}, sin2_half, 0.3, 0.04), 0);
}

TEST(Composition, TheSmoothHighlightFadesAtItsRimAndIsAsMuchInAll) {
  const Vec3<double> up{0, 0, 1};
  for (double sin2_half : {0.0, 5e-6, 1.9e-5, 2e-5, 1e-4, 1e-2}) {
    const double disc = std::max(sin2_half, kLeastImage);
    const double brightest = 1 / (4 * std::numbers::pi * disc);
    double sum = 0, before = brightest, steepest = 0;
    constexpr int kRings = 20000;
    const double ring = (disc + 2 * kLeastImage) / kRings;  // sin^2 of half the angle
    for (int i = 0; i < kRings; ++i) {
      const double h = ring * (i + 0.5);
      const double sine = 2 * std::sqrt(h * (1 - h));
      const double seen = highlight<double>(up, up, {sine, 0, 1 - 2 * h}, sin2_half, 0, 1.0);
      sum += seen * 4 * std::numbers::pi * ring;
      EXPECT_LE(seen, before * (1 + 1e-12));
      steepest = std::max(steepest, before - seen);
      before = seen;
    }
    EXPECT_NEAR(sum, 1, 1e-3) << sin2_half;
    EXPECT_EQ(before, 0);
    EXPECT_LE(steepest, brightest * (ring / (2 * kLeastImage)) * 1.01) << "a step " << sin2_half;
  }
}

}  // namespace
