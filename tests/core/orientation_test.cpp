// SPDX-License-Identifier: Apache-2.0
//
// How flakes are tilted and how much of them is seen, against independent quadrature.
#include "orientation.h"

#include <cmath>
#include <vector>

#include "independent.h"
#include "support.h"

namespace {

using namespace metallic_paint;
using core_tests::Random;
using core_tests::relative_error;
using core_tests::same_scenes;
using core_tests::Worst;
using Real = long double;

constexpr Orientation kKinds[] = {Orientation::gaussian, Orientation::beckmann, Orientation::ggx};

independent::Flakes flakes(Orientation kind, Real tilt) { return {static_cast<int>(kind), tilt}; }

// Every tilt that a paint may have: 1e-6 to 100 rad, or a roughness up to 1, all of them floats.
std::vector<float> tilts(Orientation kind, int per_decade) {
  std::vector<float> made;
  const double most = kind == Orientation::gaussian ? 2 : 0;
  for (int i = 0; i <= (6 + most) * per_decade; ++i) {
    made.push_back(static_cast<float>(std::pow(10.0, -6 + static_cast<double>(i) / per_decade)));
  }
  for (float t : {0.1f, 0.15f, 0.2828427f, 0.282843f, 0.283f, 0.3f, 0.4f, 0.41f, 0.9f, 0.99f,
                  0.998f, 0.99874f, 0.99875f, 0.999f, 0.9999f, 1.0f}) {
    made.push_back(t);
  }
  return made;
}

TEST(Orientation, NormMakesDensityTimesSineIntegrateToOne) {
  Worst wide, narrow, mean_cos, narrow_mean_cos;
  for (Orientation kind : kKinds) {
    for (float tilt : tilts(kind, 20)) {
      const Real norm = independent::shape_norm(flakes(kind, tilt));
      const Real cosine = independent::mean_cosine(flakes(kind, tilt), norm);
      const auto d = make_orientation<double>(kind, tilt);
      const auto f = make_orientation<float>(kind, tilt);
      const int k = static_cast<int>(kind);
      wide.see(relative_error(d.norm, norm), "kind", k, "tilt", tilt);
      narrow.see(relative_error(f.norm, norm), "kind", k, "tilt", tilt);
      mean_cos.see(relative_error(d.mean_cos, cosine), "kind", k, "tilt", tilt);
      narrow_mean_cos.see(relative_error(f.mean_cos, cosine), "kind", k, "tilt", tilt);
    }
  }
  wide.expect_at_most(1e-12, "double");
  narrow.expect_at_most(1e-6, "float");
  mean_cos.expect_at_most(1e-12, "double_mean_cos");
  narrow_mean_cos.expect_at_most(1e-6, "float_mean_cos");
}

TEST(Orientation, DensityIntegratesToOne) {
  // The density itself, as the paint evaluates it, times sin(beta).
  Worst wide;
  for (Orientation kind : kKinds) {
    for (float tilt : tilts(kind, 3)) {
      const auto density = make_orientation<double>(kind, tilt);
      const Real sum = independent::integrate(
          [&](Real beta) {
            const Real half = std::sin(beta / 2);
            const double y = static_cast<double>(std::min<Real>(half * half, 0.5L));
            return orientation_density(density, y) * std::sin(beta);
          },
          independent::shape_edges(flakes(kind, tilt)));
      wide.see(std::fabs(sum - 1), "kind", static_cast<int>(kind), "tilt", tilt);
    }
  }
  wide.expect_at_most(1e-12, "double");
}

TEST(Orientation, DensityIsTheStatedShape) {
  Worst wide, narrow;
  for (Orientation kind : kKinds) {
    for (float tilt : {1e-6f, 1e-3f, 0.03f, 0.1f, 0.3f, 0.6f, 1.0f}) {
      const auto d = make_orientation<double>(kind, tilt);
      const auto f = make_orientation<float>(kind, tilt);
      const Real norm = independent::shape_norm(flakes(kind, tilt));
      for (int i = 0; i <= 200; ++i) {
        const Real aimed = std::min<Real>(6 * static_cast<Real>(tilt), 1.55L) * i / 200;
        const float y = static_cast<float>(std::sin(aimed / 2) * std::sin(aimed / 2));
        const Real beta = 2 * std::asin(std::sqrt(static_cast<Real>(y)));
        const Real exact = independent::shape(flakes(kind, tilt), beta) / norm;
        if (exact < 1e-290L) continue;
        // What a rounding of beta^2/tilt^2 does to the exponential.
        const Real condition =
            1 + (kind == Orientation::ggx ? 0 : std::pow(std::tan(beta) / tilt, 2));
        const int k = static_cast<int>(kind);
        wide.see(relative_error(orientation_density(d, static_cast<double>(y)), exact) / condition,
                 "kind", k, "tilt", tilt, "beta", beta);
        if (exact < 1e-30L) continue;
        narrow.see(relative_error(orientation_density(f, y), exact) / condition, "kind", k, "tilt",
                   tilt, "beta", beta);
      }
    }
  }
  wide.expect_at_most(1e-12, "double");
  narrow.expect_at_most(2e-6, "float");
}

TEST(Orientation, DawsonSeriesHoldsItsStatedError) {
  Worst worst;
  for (int i = 1; i <= 320; ++i) {
    const Real y = i * 0.001L;
    // integral of exp(-b^2/2s^2) sin(b) over [0, infinity) is s^2 times the series in y = s^2.
    const Real s = std::sqrt(y);
    const Real exact =
        independent::integrate([&](Real b) { return std::exp(-b * b / (2 * y)) * std::sin(b); },
                               {0, s, 2 * s, 4 * s, 8 * s, 12 * s}) /
        y;
    worst.see(std::fabs(dawson_series(static_cast<double>(y)) - exact), "y", y);
  }
  worst.expect_at_most(4e-12);
}

TEST(Orientation, LongProjectedAreaMatchesQuadratureOverAllFlakes) {
  Worst wide, narrow, extreme;
  for (Orientation kind : kKinds) {
    for (float tilt : {1e-6f, 1e-4f, 0.01f, 0.03f, 0.08f, 0.15f, 0.25f, 0.29f, 0.4f, 0.6f, 0.8f,
                       1.0f, 3.0f, 100.0f}) {
      if (kind != Orientation::gaussian && tilt > 1) continue;
      const Real norm = independent::shape_norm(flakes(kind, tilt));
      const auto d = make_orientation<double>(kind, tilt);
      const auto f = make_orientation<float>(kind, tilt);
      for (float cosine : {0.0f, 1e-6f, 0.01f, 0.03f, 0.1f, 0.35f, 0.7f, 0.95f, 1.0f}) {
        const Real exact =
            independent::mean_projected_area(flakes(kind, tilt), norm, std::acos(Real(cosine)));
        const int k = static_cast<int>(kind);
        // The ordinary range: flakes of visible tilt, not seen edge-on.
        (tilt < 0.01f ? extreme : wide)
            .see(relative_error(mean_projected_area(d, static_cast<double>(cosine)), exact), "kind",
                 k, "tilt", tilt, "cos", cosine);
        narrow.see(std::fabs(mean_projected_area(f, cosine) - exact), "kind", k, "tilt", tilt,
                   "cos", cosine);
      }
    }
  }
  wide.expect_at_most(1e-12, "double");
  extreme.expect_at_most(1e-9, "double_tilt_to_1e-6");
  narrow.expect_at_most(1e-6, "float_absolute");
}

TEST(Orientation, FloatProjectedAreaFollowsDoubleEverywhere) {
  // Denser than quadrature allows: float against the double that the test above has checked.
  Worst worst;
  for (Orientation kind : kKinds) {
    for (float tilt : tilts(kind, 40)) {
      const auto d = make_orientation<double>(kind, tilt);
      const auto f = make_orientation<float>(kind, tilt);
      for (int i = 0; i <= 200; ++i) {
        const float cosine = static_cast<float>(i / 200.0);
        worst.see(std::fabs(mean_projected_area(f, cosine) -
                            mean_projected_area(d, static_cast<double>(cosine))),
                  "kind", static_cast<int>(kind), "tilt", tilt, "cos", cosine);
      }
    }
  }
  worst.expect_at_most(1e-6);
}

TEST(Orientation, BackAreaHoldsItsStatedError) {
  Worst worst;
  for (float tilt : tilts(Orientation::gaussian, 40)) {
    const auto d = make_orientation<double>(Orientation::gaussian, tilt);
    const auto f = make_orientation<float>(Orientation::gaussian, tilt);
    for (int i = 0; i <= 400; ++i) {
      const float cosine = static_cast<float>(i / 400.0);
      worst.see(std::fabs(gaussian_back_area(f, cosine) -
                          gaussian_back_area(d, static_cast<double>(cosine))),
                "tilt", tilt, "cos", cosine);
    }
  }
  worst.expect_at_most(5e-7);
}

TEST(Orientation, SeenAlongTheNormalTheProjectedAreaIsTheMeanCosine) {
  for (Orientation kind : kKinds) {
    for (float tilt : tilts(kind, 2)) {
      const auto density = make_orientation<double>(kind, tilt);
      EXPECT_NEAR(mean_projected_area(density, 1.0), density.mean_cos, 1e-15)
          << "kind " << static_cast<int>(kind) << " tilt " << tilt;
      const auto narrow = make_orientation<float>(kind, tilt);
      EXPECT_NEAR(mean_projected_area(narrow, 1.0f), narrow.mean_cos, 1e-7f)
          << "kind " << static_cast<int>(kind) << " tilt " << tilt;
    }
  }
}

TEST(Orientation, FlakesInAllDirectionsShowHalfTheirArea) {
  // P = 1: the widest Gaussian, and GGX of roughness 1.
  const auto gaussian = make_orientation<double>(Orientation::gaussian, 1e6);
  const auto ggx = make_orientation<double>(Orientation::ggx, 1.0);
  for (double cosine : {0.0, 1e-9, 0.3, 0.8, 1.0}) {
    EXPECT_NEAR(mean_projected_area(gaussian, cosine), 0.5, 1e-12) << "cos " << cosine;
    EXPECT_NEAR(mean_projected_area(ggx, cosine), 0.5, 1e-15) << "cos " << cosine;
  }
  EXPECT_NEAR(mean_projected_area(make_orientation<float>(Orientation::gaussian, 100), 0.3f), 0.5f,
              1e-5f);
}

TEST(Orientation, FlakesThatLieFlatShowTheCosine) {
  for (Orientation kind : kKinds) {
    const auto density = make_orientation<double>(kind, 1e-6);
    for (double cosine : {0.01, 0.1, 0.5, 1.0}) {
      EXPECT_NEAR(mean_projected_area(density, cosine), cosine, 1e-10)
          << "kind " << static_cast<int>(kind);
    }
  }
}

TEST(Orientation, ProjectedAreaIsAShareNotBelowThatOfTheFronts) {
  for (Orientation kind : kKinds) {
    for (float tilt : tilts(kind, 5)) {
      const auto density = make_orientation<float>(kind, tilt);
      for (int i = 0; i <= 100; ++i) {
        const float cosine = static_cast<float>(i) / 100;
        const float area = mean_projected_area(density, cosine);
        EXPECT_GE(area, 0) << "kind " << static_cast<int>(kind) << " tilt " << tilt << " cos "
                           << cosine;
        EXPECT_LE(area, 1 + 1e-6f)
            << "kind " << static_cast<int>(kind) << " tilt " << tilt << " cos " << cosine;
        // What the fronts show less what the backs do: |x| >= x.
        EXPECT_GE(area, cosine * density.mean_cos - 1e-6f)
            << "kind " << static_cast<int>(kind) << " tilt " << tilt << " cos " << cosine;
      }
    }
  }
}

// sin^2 of half the angle
double half_square(double angle) { return std::pow(std::sin(angle / 2), 2); }

TEST(CapProbability, MatchesAnIndependentIntegral) {
  Random random = same_scenes(14);
  Worst wide, narrow;
  for (int k = 0; k < 240; ++k) {
    const auto kind = static_cast<Orientation>(k % 3);
    const float tilt = static_cast<float>(random.log_uniform(0.01, 1));
    // Caps from the narrowest that are integrated to half a radian; centres inside and outside.
    const double rho = std::min(random.log_uniform(kPointCap, 5) * tilt, 0.5);
    if (rho <= kPointCap * tilt * 1.001) continue;
    const double beta = random.uniform(0, std::min(rho + 4 * tilt, 1.5 - rho));
    const float b = static_cast<float>(half_square(beta)), r = static_cast<float>(half_square(rho));
    const independent::Flakes flakes{k % 3, tilt};
    const Real exact = independent::cap_probability(flakes, independent::shape_norm(flakes),
                                                    2 * std::asin(std::sqrt(static_cast<Real>(b))),
                                                    2 * std::asin(std::sqrt(static_cast<Real>(r))));
    if (exact < 1e-30L) continue;
    const auto error = [&](auto found) { return relative_error(found, exact); };
    wide.see(error(cap_probability<double>(make_orientation<double>(kind, tilt), b, r)), "kind",
             k % 3, "tilt", tilt, "beta", beta, "rho", rho);
    if (exact < 1e-7L) continue;
    narrow.see(error(cap_probability<float>(make_orientation<float>(kind, tilt), b, r)), "kind",
               k % 3, "tilt", tilt, "beta", beta, "rho", rho);
  }
  wide.expect_at_most(1e-12, "double");
  narrow.expect_at_most(1e-3, "float");  // 3e-4 is the largest of seven runs
}

TEST(CapProbability, OfASpikeIsOneInsideAndNothingOutside) {
  for (Orientation kind : {Orientation::gaussian, Orientation::beckmann, Orientation::ggx}) {
    // Of a ggx spike less than tilt^2/d^2 lies farther out than d.
    for (double rho : {0.01, 0.1, 0.5}) {
      const auto density = make_orientation<double>(kind, 1e-6);
      const auto single = make_orientation<float>(kind, 1e-6f);
      for (double beta : {0.0, 1e-9, 0.5 * rho, 0.99 * rho}) {
        const double b = half_square(beta), r = half_square(rho);
        const double far = std::max(1e-7, std::pow(1e-6 / (rho - beta), 2));
        EXPECT_NEAR(cap_probability(density, b, r), 1, far) << beta << ' ' << rho;
        const float found = cap_probability(single, static_cast<float>(b), static_cast<float>(r));
        EXPECT_NEAR(found, 1, 1e-4) << beta << ' ' << rho;
      }
      for (double beta : {1.01 * rho, 2 * rho}) {
        const double b = half_square(beta), r = half_square(rho);
        const double far = std::pow(1e-6 / (beta - rho), 2);
        EXPECT_NEAR(cap_probability(density, b, r), 0, far) << beta << ' ' << rho;
        const float found = cap_probability(single, static_cast<float>(b), static_cast<float>(r));
        EXPECT_NEAR(found, 0, far) << beta << ' ' << rho;
      }
    }
  }
}

TEST(CapProbability, OfNarrowCapsIsTheDensityAtTheirCentre) {
  Random random = same_scenes(15);
  Worst jump;
  for (int k = 0; k < 3'000; ++k) {
    const auto kind = static_cast<Orientation>(k % 3);
    const double tilt = random.log_uniform(1e-3, 1);
    const auto density = make_orientation<double>(kind, tilt);
    const double b = half_square(random.uniform(0, 4) * std::min(tilt, 0.15));
    // Where flakes are too rare to matter, Beckmann's falls off faster than any cap is narrow.
    if (orientation_density(density, b) < 1e-4 * orientation_density(density, 0.0)) continue;
    const double below = half_square(kPointCap * tilt * (1 - 1e-9));
    const double above = half_square(kPointCap * tilt * (1 + 1e-9));
    EXPECT_EQ(cap_probability(density, b, below), 2 * orientation_density(density, b) * below);
    jump.see(relative_error(cap_probability(density, b, below), cap_probability(density, b, above)),
             "kind", k % 3, "tilt", tilt, "b", b);
  }
  // (rho^2/8) laplace(P)/P at rho = tilt/16: 7/1000 for a Gaussian at 4 tilts, and twice the
  // curvature for Beckmann's, whose tilt is sqrt(2) standard deviations.
  jump.expect_at_most(0.035);
}

}  // namespace
