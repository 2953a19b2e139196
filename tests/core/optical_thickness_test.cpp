// SPDX-License-Identifier: Apache-2.0
//
// What the flakes take out of a beam: <t_p> of a coating table, tau, and the table over the cosine.
#include "optical_thickness.h"

#include <cmath>
#include <vector>

#include "independent.h"
#include "support.h"

namespace {

using namespace metallic_paint;
using core_tests::relative_error;
using core_tests::Worst;
using Real = long double;

constexpr Orientation kKinds[] = {Orientation::gaussian, Orientation::beckmann, Orientation::ggx};

// Transmittance t(x) = f(x) over x = cos(alpha), in all colours alike but for a factor.
template <class T, class F>
CoatingTable<T> table_of(int size, const F& f) {
  CoatingTable<T> table;
  for (int i = 0; i < size; ++i) {
    const T value = static_cast<T>(f(static_cast<double>(i) / (size - 1)));
    table.transmittance.push_back({value, value / 2, value / 4});
    table.reflectance.push_back(grey(T(1) - value));
  }
  return table;
}

// An interference-like coating: between 0 and 1, neither even nor monotone.
double ripples(double x) { return 0.5 + 0.4 * std::sin(6 * x + 0.3); }

// The same table in long double, read by angle: cos -> linear interpolation.
Real lookup(const CoatingTable<double>& table, Real x) {
  const Real position = x * static_cast<Real>(table.transmittance.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(position), table.transmittance.size() - 2);
  const Real f = position - static_cast<Real>(i);
  return table.transmittance[i].x * (1 - f) + table.transmittance[i + 1].x * f;
}

TEST(Coating, TableIsInterpolatedLinearlyAndClamped) {
  const CoatingTable<double> table = table_of<double>(5, ripples);
  const Coating<double> coating{{}, {}, {}, &table};
  for (int i = 0; i < 5; ++i) {
    EXPECT_DOUBLE_EQ(coating_transmittance(coating, i / 4.0).x, ripples(i / 4.0));
    EXPECT_DOUBLE_EQ(coating_reflectance(coating, i / 4.0).y, 1 - ripples(i / 4.0));
  }
  EXPECT_DOUBLE_EQ(coating_transmittance(coating, 0.125).x, (ripples(0) + ripples(0.25)) / 2);
  EXPECT_DOUBLE_EQ(coating_transmittance(coating, 1.5).x, ripples(1));
  EXPECT_DOUBLE_EQ(coating_transmittance(coating, -0.5).x, ripples(0));
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
    const CoatingTable<double> table{{{}, {}}, {{0.1, 0.2, 0.7}, {0.1, 0.2, 0.7}}};
    const Coating<double> tabulated{{}, {}, {}, &table};
    for (double cosine : {0.05, 0.5, 1.0}) {
      const double area = mean_projected_area(density, cosine);
      const Rgb<double> t = mean_transmitted_area(density, coating, cosine);
      EXPECT_DOUBLE_EQ(t.x, 0.1 * area);
      EXPECT_DOUBLE_EQ(t.z, 0.7 * area);
      const Rgb<double> blocked = blocked_area<double>(density, coating, nullptr, cosine);
      EXPECT_NEAR(blocked.y, 0.8 * area, 1e-15);
      // A table of constants goes through the double integral to the same.
      const Rgb<double> integrated = mean_transmitted_area(density, tabulated, cosine);
      EXPECT_NEAR(integrated.z, 0.7 * area, 1e-12)
          << "kind " << static_cast<int>(kind) << " cos " << cosine;
    }
  }
}

TEST(OpticalThickness, TransmittedAreaOfLinearCoatingMatchesQuadrature) {
  // t(x) = x: no kink inside, <t_p> = integral of p x^2.
  const CoatingTable<double> table = table_of<double>(2, [](double x) { return x; });
  const Coating<double> coating{{}, {}, {}, &table};
  Worst worst;
  for (Orientation kind : kKinds) {
    for (double tilt : {1e-3, 0.03, 0.1, 0.15, 0.3, 0.6, 1.0}) {
      const independent::Flakes flakes{static_cast<int>(kind), tilt};
      const Real norm = independent::shape_norm(flakes);
      const auto density = make_orientation<double>(kind, tilt);
      for (double cosine : {0.05, 0.3, 0.75, 1.0}) {
        const Real exact =
            independent::mean_projected_area(flakes, norm, std::acos(Real(cosine)), 2);
        worst.see(relative_error(mean_transmitted_area(density, coating, cosine).x, exact), "kind",
                  flakes.kind, "tilt", tilt, "cos", cosine);
      }
    }
  }
  worst.expect_at_most(1e-12);
}

TEST(OpticalThickness, TransmittedAreaOfCoatingTableMatchesQuadrature) {
  // The table's own kinks cost the Gauss rule digits: largest error of <t_p>, absolute.
  for (const auto& [size, limit] : {std::pair{9, 5e-6}, std::pair{33, 5e-6}}) {
    const CoatingTable<double> table = table_of<double>(size, ripples);
    const Coating<double> coating{{}, {}, {}, &table};
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
              flakes, norm, std::acos(Real(cosine)), [&](Real x) { return lookup(table, x); },
              kinks);
          const Rgb<double> area = mean_transmitted_area(density, coating, cosine);
          worst.see(std::fabs(area.x - exact), "kind", flakes.kind, "tilt", tilt, "cos", cosine);
          EXPECT_NEAR(area.z, area.x / 4, 1e-15);
        }
      }
    }
    worst.expect_at_most(limit, "table_of_" + std::to_string(size));
  }
}

TEST(OpticalThickness, ProjectionTableHoldsItsStatedError) {
  const double from[] = {0.15, 0.03, 1e-6}, limit[] = {1.5e-5, 8e-5, 5e-4};
  Worst worst[3];
  for (Orientation kind : kKinds) {
    for (double tilt = 1e-6; tilt <= 1.05; tilt *= std::pow(10, 0.05)) {
      const auto density = make_orientation<double>(kind, std::min(tilt, 1.0));
      const Coating<double> coating{};  // opaque: <s>, the sharper of the two
      const ProjectionTable<double> table(density, coating, kProjectionIntervals);
      double error = 0, where = 0;
      for (int i = 0; i <= kProjectionIntervals * 8; ++i) {
        const double cosine = i / (kProjectionIntervals * 8.0);
        const double here = std::fabs(blocked_area(density, coating, &table, cosine).x -
                                      mean_projected_area(density, cosine));
        if (here > error) where = cosine;
        error = std::max(error, here);
      }
      for (int range = 0; range < 3; ++range) {
        if (tilt < from[range]) continue;
        worst[range].see(error, "kind", static_cast<int>(kind), "tilt", tilt, "cos", where);
      }
    }
  }
  for (int range = 0; range < 3; ++range) {
    worst[range].expect_at_most(limit[range], "tilt_from_" + std::to_string(from[range]));
  }
}

TEST(OpticalThickness, ProjectionTableKnowsTheCoating) {
  const auto density = make_orientation<double>(Orientation::gaussian, 0.2);
  const CoatingTable<double> coating_table = table_of<double>(17, ripples);
  const Coating<double> coating{{}, {}, {}, &coating_table};
  const ProjectionTable<double> table(density, coating, 32);
  Worst worst;
  for (double cosine : {0.02, 0.21, 0.47, 0.83, 0.99}) {
    const Rgb<double> exact = blocked_area<double>(density, coating, nullptr, cosine);
    const Rgb<double> tabulated = blocked_area(density, coating, &table, cosine);
    worst.see(std::fabs(tabulated.x - exact.x), "cos", cosine);
    worst.see(std::fabs(tabulated.z - exact.z), "cos", cosine);
    EXPECT_GE(exact.x, 0);
    EXPECT_LE(exact.z, 1);
  }
  worst.expect_at_most(2e-3, "32_intervals");
}

TEST(OpticalThickness, FlatFlakesTakeTheirCosineTimesWhatTheyDoNotLetThrough) {
  // tau = D<S>(1 - t_p(theta_p)) cos(theta_p) for small tilts; H tau/cos = coverage (1 - t_p).
  const CoatingTable<double> coating_table = table_of<double>(2, [](double x) { return x / 2; });
  const Coating<double> coating{{}, {}, {}, &coating_table};
  for (Orientation kind : {Orientation::gaussian, Orientation::beckmann}) {
    const double tilt = 1e-3;
    const auto density = make_orientation<double>(kind, tilt);
    for (double cosine : {0.1, 0.5, 0.9, 1.0}) {
      const Rgb<double> blocked = blocked_area<double>(density, coating, nullptr, cosine);
      EXPECT_NEAR(blocked.x, cosine * (1 - cosine / 2), 2 * tilt * tilt)
          << "kind " << static_cast<int>(kind) << " cos " << cosine;
      const Rgb<double> depth = slant_depth(blocked * 0.7, {}, cosine);
      EXPECT_NEAR(depth.x, 0.7 * (1 - cosine / 2), 2 * tilt * tilt / cosine);
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
