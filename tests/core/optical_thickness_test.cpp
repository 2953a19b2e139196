// SPDX-License-Identifier: Apache-2.0
//
// What the flakes take out of a beam: <t_p> by quadrature, and tau.
#include "optical_thickness.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "independent.h"
#include "reference/transmitted_area.h"
#include "support.h"

namespace {

using namespace metallic_paint;
using core_tests::relative_error;
using core_tests::Worst;
using reference::mean_transmitted_area;
using Real = long double;

constexpr Orientation kKinds[] = {Orientation::gaussian, Orientation::beckmann, Orientation::ggx};

// An interference-like coating: between 0 and 1, neither even nor monotone.
double ripples(double x) { return 0.5 + 0.4 * std::sin(6 * x + 0.3); }

// A curve that runs straight between its values f at x = 0, 1/(size-1), ..., 1.
template <class F>
auto polyline(int size, const F& f) {
  return [=](auto x) {
    using T = decltype(x);
    const int i = std::min(static_cast<int>(x * T(size - 1)), size - 2);
    const T share = x * T(size - 1) - T(i);
    return T(f(i / (size - 1.0))) * (1 - share) + T(f((i + 1) / (size - 1.0))) * share;
  };
}

// Transmittance f(x) in red, a half and a quarter of it in green and blue.
template <class F>
auto colours_of(const F& f) {
  return [=](double x) { return Rgb<double>{f(x), f(x) / 2, f(x) / 4}; };
}

TEST(Coating, SchlicksMetalRunsFromNormalToGrazingReflectance) {
  const Coating<double> coating{{0.9, 0.5, 0.2}, {1, 0.9, 0.8}, {}};
  EXPECT_DOUBLE_EQ(coating_reflectance(coating, 1.0).y, 0.5);
  EXPECT_DOUBLE_EQ(coating_reflectance(coating, 0.0).z, 0.8);
  EXPECT_DOUBLE_EQ(coating_reflectance(coating, 0.5).x, 0.9 + 0.1 / 32);
  EXPECT_DOUBLE_EQ(coating_reflectance(coating, 1.0000001).y, 0.5) << "a cosine rounded above 1";
}

TEST(Coating, EqualColoursAtBothEndsAreConstant) {
  const Coating<double> coating{{0.7, 0.5, 0.3}, {0.7, 0.5, 0.3}, {}};
  for (double x : {0.0, 0.3, 1.0}) EXPECT_EQ(coating_reflectance(coating, x).y, 0.5);
}

TEST(OpticalThickness, ReferenceAgreesWithItselfOverBothPolarAxes) {
  for (Orientation kind : kKinds) {
    for (Real tilt : {0.15L, 0.6L}) {
      const independent::Flakes flakes{static_cast<int>(kind), tilt};
      const Real norm = independent::shape_norm(flakes);
      for (Real theta : {0.4L, 1.2L}) {
        EXPECT_LE(relative_error(independent::mean_transmitted_area(flakes, norm, theta,
                                                                    [](Real x) { return x; }, {}),
                                 independent::mean_projected_area(flakes, norm, theta, 2)),
                  1e-12)
            << "kind " << flakes.kind << " tilt " << tilt << " theta " << theta;
      }
    }
  }
}

TEST(OpticalThickness, ConstantTransmittanceIsTakenOutOfTheProjectedArea) {
  for (Orientation kind : kKinds) {
    const auto density = make_orientation<double>(kind, 0.3);
    const Coating<double> coating{{}, {}, {0.1, 0.2, 0.7}};
    for (double cosine : {0.05, 0.5, 1.0}) {
      const double area = mean_projected_area(density, cosine);
      const Rgb<double> blocked = blocked_area(density, coating, cosine);
      EXPECT_NEAR(blocked.x, 0.9 * area, 1e-15);
      EXPECT_NEAR(blocked.y, 0.8 * area, 1e-15);
      EXPECT_NEAR(blocked.z, 0.3 * area, 1e-15);
      // The double integral comes to the same.
      const Rgb<double> integrated = mean_transmitted_area(density, coating, cosine);
      EXPECT_NEAR(integrated.z, 0.7 * area, 1e-12)
          << "kind " << static_cast<int>(kind) << " cos " << cosine;
    }
  }
}

TEST(OpticalThickness, TransmittedAreaOfLinearCoatingMatchesQuadrature) {
  // t(x) = x: no kink inside, <t_p> = integral of p x^2.
  Worst worst;
  for (Orientation kind : kKinds) {
    for (double tilt : {1e-3, 0.03, 0.1, 0.15, 0.3, 0.6, 1.0}) {
      const independent::Flakes flakes{static_cast<int>(kind), tilt};
      const Real norm = independent::shape_norm(flakes);
      const auto density = make_orientation<double>(kind, tilt);
      for (double cosine : {0.05, 0.3, 0.75, 1.0}) {
        const Real exact =
            independent::mean_projected_area(flakes, norm, std::acos(Real(cosine)), 2);
        const Rgb<double> area =
            mean_transmitted_area(density, colours_of([](double x) { return x; }), cosine);
        worst.see(relative_error(area.x, exact), "kind", flakes.kind, "tilt", tilt, "cos", cosine);
      }
    }
  }
  worst.expect_at_most(1e-12);
}

TEST(OpticalThickness, TransmittedAreaOfCoatingWithKinksMatchesQuadrature) {
  // Kinks cost the Gauss rule digits: largest error of <t_p>, absolute.
  for (const auto& [size, limit] : {std::pair{9, 5e-6}, std::pair{33, 5e-6}}) {
    const auto transmittance = polyline(size, ripples);
    std::vector<Real> kinks;
    for (int i = 1; i < size - 1; ++i) kinks.push_back(static_cast<Real>(i) / (size - 1));
    Worst worst;
    for (Orientation kind : kKinds) {
      for (double tilt : {0.15, 0.6}) {
        const independent::Flakes flakes{static_cast<int>(kind), tilt};
        const Real norm = independent::shape_norm(flakes);
        const auto density = make_orientation<double>(kind, tilt);
        for (double cosine : {0.3, 0.8}) {
          if (size > 9 && cosine > 0.5) continue;
          const Real exact = independent::mean_transmitted_area(
              flakes, norm, std::acos(Real(cosine)), transmittance, kinks);
          const Rgb<double> area =
              mean_transmitted_area(density, colours_of(transmittance), cosine);
          worst.see(std::fabs(area.x - exact), "kind", flakes.kind, "tilt", tilt, "cos", cosine);
          EXPECT_NEAR(area.z, area.x / 4, 1e-15);
        }
      }
    }
    worst.expect_at_most(limit, "polyline_of_" + std::to_string(size));
  }
}

TEST(OpticalThickness, FlatFlakesLetThroughTheirCosineTimesTheirTransmittance) {
  // tau = D<S>(1 - t_p(theta_p)) cos(theta_p) for small tilts; H tau/cos = coverage (1 - t_p).
  for (Orientation kind : {Orientation::gaussian, Orientation::beckmann}) {
    const double tilt = 1e-3;
    const auto density = make_orientation<double>(kind, tilt);
    for (double cosine : {0.1, 0.5, 0.9, 1.0}) {
      const Rgb<double> passed =
          mean_transmitted_area(density, colours_of([](double x) { return x / 2; }), cosine);
      EXPECT_NEAR(mean_projected_area(density, cosine) - passed.x, cosine * (1 - cosine / 2),
                  2 * tilt * tilt)
          << "kind " << static_cast<int>(kind) << " cos " << cosine;
      const Coating<double> half{{}, {}, grey(0.5)};
      const Rgb<double> depth = slant_depth(blocked_area(density, half, cosine) * 0.7, {}, cosine);
      EXPECT_NEAR(depth.x, 0.7 * 0.5, 2 * tilt * tilt / cosine);
    }
  }
}

TEST(OpticalThickness, BinderAddsItsDepthAlongTheSlantedPath) {
  const Rgb<double> depth = slant_depth(Rgb<double>{0.2, 0.4, 0.6}, {1, 2, 4}, 0.5);
  EXPECT_DOUBLE_EQ(depth.x, (0.2 + 1) / 0.5);
  EXPECT_DOUBLE_EQ(depth.z, (0.6 + 4) / 0.5);
  EXPECT_TRUE(std::isfinite(slant_depth(Rgb<double>{2, 2, 2}, {1, 1, 1}, 0.0).x));
}

}  // namespace
