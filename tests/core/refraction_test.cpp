// SPDX-License-Identifier: Apache-2.0
//
// The binder's surface against Snell and Fresnel written with angles in long double.
#include "refraction.h"

#include <cmath>

#include "independent.h"
#include "scenes.h"
#include "support.h"

namespace {

using namespace metallic_paint;
using core_tests::Random;
using core_tests::relative_error;
using core_tests::same_scenes;
using core_tests::spherical;
using core_tests::ulps;
using core_tests::Worst;
using Real = long double;

constexpr double kIndices[] = {0.25, 0.5,  0.9,         0.999999,    1 - 1e-12, 1, 1 + 1e-12,
                               1.01, 1.33, 1.000000001, 1.499999999, 1.5,       2, 4};

// eta cos(theta_p) by angles; 0 in total reflection.
Real naive_g(double cos_theta, double eta) {
  const Real sine = std::sqrt((1 - Real(cos_theta)) * (1 + Real(cos_theta))) / eta;
  return sine < 1 ? eta * std::cos(std::asin(sine)) : 0;
}

// Fresnel's T_s and T_p of long double, from the cosine (an arccosine would blur grazing angles).
Real transmittance(Real cos_theta, Real eta) {
  const Real square = (eta - 1) * (eta + 1) + cos_theta * cos_theta;
  if (square <= 0) return 0;
  const Real cos_in = std::sqrt(square) / eta;
  const Real s = cos_theta + eta * cos_in, p = eta * cos_theta + cos_in;
  return cos_theta * eta * cos_in * (2 / (s * s) + 2 / (p * p));
}

TEST(Refraction, FollowsSnell) {
  Worst ordinary, critical;
  for (double eta : kIndices) {
    for (int i = 1; i <= 4000; ++i) {
      const double cosine = i / 4000.0;
      const Real exact = naive_g(cosine, eta);
      const double g = eta_cos_refracted(cosine, eta);
      if (exact == 0) {
        EXPECT_EQ(g, 0) << "eta " << eta << " cos " << cosine;
      } else if (exact > 0.05L) {
        ordinary.see(relative_error(g, exact), "eta", eta, "cos", cosine);
      } else {
        critical.see(std::fabs(g * g - exact * exact), "eta", eta, "cos", cosine);
      }
    }
  }
  ordinary.expect_at_most(3e-14, "relative");
  critical.expect_at_most(2e-16, "square_near_total_reflection");
}

TEST(Refraction, FresnelTransmittanceIsRightToTheLastPlaces) {
  Worst places, places_float, whole;
  for (double eta : kIndices) {
    for (int i = 1; i <= 4000; ++i) {
      const double cosine = i / 4000.0;
      const double g = eta_cos_refracted(cosine, eta);
      // Next to total reflection g itself is a small difference.
      if (g < 0.5 * cosine) continue;
      const double t = fresnel_transmittance(cosine, g, eta);
      places.see(ulps(t, transmittance(cosine, eta)), "eta", eta, "cos", cosine);
      whole.see(t, "eta", eta, "cos", cosine);
      if (std::fabs(eta - 1) < 1e-7 && eta != 1) continue;  // not a float
      const float eta_f = static_cast<float>(eta), cosine_f = static_cast<float>(cosine);
      const float g_f = eta_cos_refracted(cosine_f, eta_f);
      if (g_f < 0.5f * cosine_f) continue;
      places_float.see(
          ulps(fresnel_transmittance(cosine_f, g_f, eta_f), transmittance(cosine_f, eta_f)), "eta",
          eta, "cos", cosine);
    }
  }
  places.expect_at_most(5, "double_ulps");
  places_float.expect_at_most(5, "float_ulps");
  whole.expect_at_most(1 + 4e-16, "largest");
}

TEST(Refraction, FresnelTransmittanceAgreesWithOneMinusReflectance) {
  Worst worst;
  for (double eta : kIndices) {
    for (int i = 1; i < 1000; ++i) {
      const Real theta = independent::kPi / 2 * i / 1000;
      const double cosine = static_cast<double>(std::cos(theta));
      const double g = eta_cos_refracted(cosine, eta);
      if (g < 0.5 * cosine) continue;
      worst.see(std::fabs(fresnel_transmittance(cosine, g, eta) -
                          (1 - independent::fresnel_reflectance(theta, eta))),
                "eta", eta, "theta", theta);
    }
  }
  worst.expect_at_most(4e-15, "absolute");
}

TEST(Refraction, SurfaceOfEqualIndicesIsNotThere) {
  for (int i = 0; i <= 1000; ++i) {
    const double cosine = i / 1000.0;
    const double g = eta_cos_refracted(cosine, 1.0);
    EXPECT_DOUBLE_EQ(g, cosine);
    if (i == 0) continue;  // 0/0
    EXPECT_DOUBLE_EQ(fresnel_transmittance(cosine, g, 1.0), 1) << "cos " << cosine;
    EXPECT_DOUBLE_EQ(solid_angle_ratio(cosine, g, 1.0), 1) << "cos " << cosine;
  }
  EXPECT_EQ(fresnel_transmittance(0.0, 0.0, 1.0), 0);
}

TEST(Refraction, NearlyEqualIndicesReflectNearlyNothing) {
  for (double delta : {-1e-12, 1e-12}) {
    const double eta = 1 + delta;
    for (double cosine : {1.0, 0.5, 0.01}) {
      const double t = fresnel_transmittance(cosine, eta_cos_refracted(cosine, eta), eta);
      EXPECT_NEAR(t, 1, 1e-15) << "eta - 1 " << delta << " cos " << cosine;
    }
  }
}

TEST(Refraction, RareBinderReflectsTotallyBeyondItsCriticalAngle) {
  const double critical = std::sqrt(0.75);  // sin(theta) = eta = 1/2
  EXPECT_EQ(eta_cos_refracted(critical - 1e-6, 0.5), 0);
  EXPECT_GT(eta_cos_refracted(critical + 1e-6, 0.5), 0);
  EXPECT_EQ(fresnel_transmittance(critical - 1e-6, 0.0, 0.5), 0);
  EXPECT_LT(fresnel_transmittance(critical + 1e-9, eta_cos_refracted(critical + 1e-9, 0.5), 0.5),
            1e-3);
}

TEST(Refraction, NothingPassesAtGrazingIncidence) {
  for (double eta : {0.5, 1.1, 1.5, 4.0}) {
    const double g = eta_cos_refracted(0.0, eta);
    EXPECT_EQ(fresnel_transmittance(0.0, g, eta), 0) << "eta " << eta;
  }
  // First order: T -> 2 cos (1 + eta^2)/g for small cosines.
  Worst worst;
  for (double cosine : {1e-3, 1e-6, 1e-9, 1e-12}) {
    for (double eta : {1.1, 1.5, 4.0}) {
      const double g = eta_cos_refracted(cosine, eta);
      worst.see(
          relative_error(fresnel_transmittance(cosine, g, eta), 2 * cosine * (1 + eta * eta) / g) /
              cosine,
          "eta", eta, "cos", cosine);
      EXPECT_LE(ulps(fresnel_transmittance(cosine, g, eta), transmittance(cosine, eta)), 8);
    }
  }
  worst.expect_at_most(80, "per_cosine");
}

TEST(Refraction, NormalIncidenceOfGlassReflectsFourPerCent) {
  EXPECT_NEAR(fresnel_transmittance(1.0, 1.5, 1.5), 0.96, 1e-15);
  EXPECT_NEAR(fresnel_transmittance(1.0, 4.0, 4.0), 0.64, 1e-15);
}

TEST(Refraction, LightPassesBothWaysAlike) {
  // T(theta) from outside equals T(theta_p) from inside, where the relative index is 1/eta.
  Worst worst;
  for (double eta : {1.1, 1.5, 2.5}) {
    for (int i = 1; i <= 1000; ++i) {
      const double cosine = i / 1000.0;
      const double g = eta_cos_refracted(cosine, eta);
      const double inside = g / eta;
      const double back = fresnel_transmittance(inside, cosine / eta, 1 / eta);
      worst.see(relative_error(fresnel_transmittance(cosine, g, eta), back), "eta", eta, "cos",
                cosine);
    }
  }
  worst.expect_at_most(2e-15);
}

TEST(Refraction, MirrorLiesBetweenTheRefractedDirections) {
  Random random = same_scenes(1);
  Worst cosine, angle, float_cosine, float_angle;
  for (int i = 0; i < 20'000; ++i) {
    const double eta = random.uniform(0.5, 4);
    const auto direction = [&] {
      return spherical(random.uniform(0, 1.57), random.uniform(0, 6.28));
    };
    const Vec3<double> n{0, 0, 1}, v = direction(), l = direction();
    const auto mirror = mirror_between(n, v, l, eta);
    if (!(std::min(mirror.g_view, mirror.g_light) > 0.1 * eta)) continue;
    const auto refracted = [&](Vec3<double> d) {
      return independent::refract({d.x, d.y, d.z}, {0, 0, 1}, eta);
    };
    const independent::Vector in = refracted(v), half = in + refracted(l);
    const Real cos_alpha = std::cos(independent::angle(in, half));
    const Real half_beta = std::sin(independent::angle(half, {0, 0, 1}) / 2);
    cosine.see(std::fabs(mirror.cos_alpha - cos_alpha), "eta", eta, "view", v.z, "light", l.z);
    angle.see(std::fabs(std::sqrt(mirror.sin2_half_beta) - half_beta), "eta", eta, "view", v.z);
    const auto narrow = mirror_between<float>(Vec3<float>(n), Vec3<float>(v), Vec3<float>(l),
                                              static_cast<float>(eta));
    float_cosine.see(std::fabs(narrow.cos_alpha - cos_alpha), "eta", eta, "view", v.z);
    float_angle.see(std::fabs(std::sqrt(narrow.sin2_half_beta) - half_beta), "eta", eta);
  }
  cosine.expect_at_most(2e-15, "cos alpha, double");
  angle.expect_at_most(2e-15, "sin beta/2, double");
  float_cosine.expect_at_most(1e-6, "cos alpha, float");
  float_angle.expect_at_most(1e-6, "sin beta/2, float");
}

TEST(Refraction, SolidAngleRatioIsTheDerivativeOfSnellsLaw) {
  // d omega = sin(theta) d theta d phi: ratio = sin(theta_p)/sin(theta) d theta_p/d theta, the
  // derivative by Richardson's central difference in long double.
  Worst worst;
  for (double eta : {0.5, 0.9, 1.0, 1.1, 1.5, 4.0}) {
    for (int i = 1; i < 300; ++i) {
      const Real theta = 1.56L * i / 300;
      if (std::sin(theta) > 0.8L * eta) continue;
      const auto slope = [&](Real h) {
        return (independent::refracted_angle(theta + h, eta) -
                independent::refracted_angle(theta - h, eta)) /
               (2 * h);
      };
      const Real h = 1e-4L;
      const Real derivative = (4 * slope(h / 2) - slope(h)) / 3;
      const Real exact =
          std::sin(independent::refracted_angle(theta, eta)) / std::sin(theta) * derivative;
      const double cosine = static_cast<double>(std::cos(theta));
      worst.see(
          relative_error(solid_angle_ratio(cosine, eta_cos_refracted(cosine, eta), eta), exact),
          "eta", eta, "theta", theta);
    }
  }
  worst.expect_at_most(1e-12);
}

}  // namespace
