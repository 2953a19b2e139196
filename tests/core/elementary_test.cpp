// SPDX-License-Identifier: Apache-2.0
//
// Every error stated in core/elementary.h, measured over the whole range of the function.
#include "elementary.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "independent.h"
#include "support.h"

namespace {

using namespace metallic_paint;
using core_tests::relative_error;
using core_tests::Worst;

// Calls visit(x) for positive floats from `from` to `to`: each one, or every stride-th.
template <class Visit>
void for_floats(float from, float to, std::uint32_t stride, const Visit& visit) {
  const auto end = std::bit_cast<std::uint32_t>(to);
  for (auto bits = std::bit_cast<std::uint32_t>(from); bits < end; bits += stride) {
    visit(std::bit_cast<float>(bits));
  }
  visit(to);
}

// (1 - Phi(x))/phi(x) as an integral: of e^(-x t - t^2/2) over t > 0.
long double mills_by_quadrature(long double x) {
  const long double end = 12 / std::fmax(x, 1.0L) * 4;
  return independent::integrate([&](long double t) { return std::exp(-t * (x + t / 2)); },
                                {0, end / 16, end / 4, end});
}

// The w with Phi(w) = u, by bisection of erfc in long double.
long double quantile_by_bisection(long double u) {
  long double low = -40, high = 40;
  for (int i = 0; i < 110; ++i) {
    const long double middle = (low + high) / 2;
    const long double root_half = 0.70710678118654752440084L;
    // Phi(middle) < u, each tail by the erfc that is small there.
    const bool below = u < 0.5L ? 0.5L * std::erfc(-middle * root_half) < u
                                : 0.5L * std::erfc(middle * root_half) > 1 - u;
    (below ? low : high) = middle;
  }
  return (low + high) / 2;
}

TEST(Elementary, FloatExponentialHoldsItsStatedError) {
  Worst worst;
  for (int i = 0; i <= 4'000'000; ++i) {
    const float x = static_cast<float>(-87.0 + 174.0 * i / 4'000'000);
    worst.see(relative_error(exponential(x), std::exp(static_cast<double>(x))), "x", x);
  }
  worst.expect_at_most(3e-7);
}

TEST(Elementary, ExponentialAtTheEndsOfItsRange) {
  EXPECT_EQ(exponential(0.0f), 1.0f);
  EXPECT_EQ(exponential(-1000.0f), 0.0f);
  EXPECT_EQ(exponential(-std::numeric_limits<float>::infinity()), 0.0f);
  EXPECT_EQ(exponential(-87.5f), 0.0f);
  EXPECT_GE(exponential(-87.0f), std::numeric_limits<float>::min()) << "denormal";
  EXPECT_LE(relative_error(exponential(87.0f), std::exp(87.0)), 3e-7);
  EXPECT_EQ(exponential(1000.0f), exponential(87.0f));
  EXPECT_EQ(exponential(std::numeric_limits<float>::infinity()), exponential(87.0f));
  EXPECT_EQ(exponential(1e-30f), 1.0f);
}

TEST(Elementary, FloatExponentialNeverDecreases) {
  // Up to the rounding of its last places.
  Worst drop;
  float previous = 0;
  for (int i = 0; i <= 4'000'000; ++i) {
    const float x = static_cast<float>(-90.0 + 180.0 * i / 4'000'000);
    const float value = exponential(x);
    drop.see(value < previous ? (previous - value) / previous : 0.0f, "x", x);
    previous = value;
  }
  drop.expect_at_most(3e-7);
}

TEST(Elementary, FloatLogarithmHoldsItsStatedError) {
  Worst worst;
  const auto see = [&](float x) {
    if (x == 1) return;
    worst.see(relative_error(logarithm(x), std::log(static_cast<double>(x))), "x", x);
  };
  for_floats(std::numeric_limits<float>::min(), std::numeric_limits<float>::max(), 997, see);
  for_floats(0.7f, 1.5f, 3, see);
  worst.expect_at_most(2.5e-7);
  EXPECT_EQ(logarithm(1.0f), 0.0f);
}

TEST(Elementary, FloatSineAndCosineHoldTheirStatedErrors) {
  Worst sine_error, cosine_error, sine_relative;
  const double half_pi = 1.57079632679489662;
  for (int i = 0; i <= 4'000'000; ++i) {
    const float x = static_cast<float>(half_pi * i / 4'000'000);
    const double exact = std::sin(static_cast<double>(x));
    sine_error.see(std::fabs(sine(x) - exact), "x", x);
    if (i > 0) sine_relative.see(relative_error(sine(x), exact), "x", x);
    cosine_error.see(std::fabs(cosine(x) - std::cos(static_cast<double>(x))), "x", x);
  }
  sine_error.expect_at_most(2e-7, "sine");
  sine_relative.expect_at_most(2e-7, "sine_relative");
  cosine_error.expect_at_most(2e-7, "cosine");
  EXPECT_EQ(sine(0.0f), 0.0f);
  EXPECT_EQ(cosine(0.0f), 1.0f);
}

TEST(Elementary, FloatArccosineHoldsItsStatedError) {
  Worst worst;
  const auto see = [&](float x) {
    if (x < 1) worst.see(relative_error(arccosine(x), std::acos(static_cast<double>(x))), "x", x);
  };
  for (int i = 0; i <= 4'000'000; ++i) see(static_cast<float>(i / 4e6));
  for_floats(0.99f, 1.0f, 1, see);
  worst.expect_at_most(3e-7);
  EXPECT_EQ(arccosine(1.0f), 0.0f);
}

TEST(Elementary, FloatSquaredAngleHoldsItsStatedError) {
  Worst worst;
  const auto see = [&](float y) {
    const double x = 2 * std::asin(std::sqrt(static_cast<double>(y)));
    worst.see(relative_error(squared_angle(y), x * x), "y", y);
  };
  for (int i = 1; i <= 4'000'000; ++i) see(static_cast<float>(0.5 * i / 4e6));
  for_floats(1e-30f, 1e-3f, 9973, see);
  worst.expect_at_most(2e-7);
  EXPECT_EQ(squared_angle(0.0f), 0.0f);
}

TEST(Elementary, MeanTransmittanceHoldsItsStatedError) {
  Worst narrow, wide;
  const auto see = [&](float x) {
    const long double exact = -std::expm1(-static_cast<long double>(x)) / x;
    narrow.see(relative_error(mean_transmittance(x), exact), "x", x);
    wide.see(relative_error(mean_transmittance(static_cast<double>(x)), exact), "x", x);
  };
  for (int i = 1; i <= 1'000'000; ++i) see(static_cast<float>(100.0 * i / 1e6));
  for_floats(1e-30f, 1e30f, 9973, see);
  narrow.expect_at_most(3e-7, "float");
  wide.expect_at_most(5e-16, "double");
  EXPECT_EQ(mean_transmittance(0.0f), 1.0f);
  EXPECT_EQ(mean_transmittance(0.0), 1.0);
  EXPECT_EQ(mean_transmittance(1e-300), 1.0);
  EXPECT_EQ(mean_transmittance(std::numeric_limits<double>::infinity()), 0.0);
  EXPECT_EQ(mean_transmittance(std::numeric_limits<float>::infinity()), 0.0f);
}

TEST(Elementary, MillsRatioHoldsItsStatedErrors) {
  Worst narrow, far, wide;
  for (int i = 0; i <= 20'000; ++i) {
    const float x = static_cast<float>(40.0 * i / 20'000);
    const long double exact = mills_by_quadrature(x);
    wide.see(relative_error(mills_ratio(static_cast<double>(x)), exact), "x", x);
    if (x <= 17) narrow.see(relative_error(mills_ratio(x), exact), "x", x);
    if (x > 17) far.see(std::fabs(mills_ratio(x) - exact), "x", x);
  }
  for (float x = 40; x < 1e9f; x *= 1.1f) {
    const long double exact = mills_by_quadrature(x);
    wide.see(relative_error(mills_ratio(static_cast<double>(x)), exact), "x", x);
    far.see(std::fabs(mills_ratio(x) - exact), "x", x);
  }
  narrow.expect_at_most(5e-7, "float_to_17");
  far.expect_at_most(1e-5, "float_beyond_absolute");
  wide.expect_at_most(3e-14, "double");
  EXPECT_LE(relative_error(mills_ratio(0.0), std::sqrt(independent::kPi / 2)), 4e-16);
}

TEST(Elementary, NormalDensityAndDistributionFunction) {
  Worst density, narrow_density, tail, narrow_tail, absolute, narrow_absolute;
  for (int i = 0; i <= 200'000; ++i) {
    const float x = static_cast<float>(-12.0 + 24.0 * i / 200'000);
    const long double X = x;
    const long double exact = std::exp(-X * X / 2) / std::sqrt(2 * independent::kPi);
    const long double cdf = std::erfc(-X / std::sqrt(2.0L)) / 2;
    const double d = x;
    density.see(relative_error(normal_density(d), exact), "x", x);
    narrow_density.see(relative_error(normal_density(x), exact) / (1 + X * X / 2), "x", x);
    absolute.see(std::fabs(normal_cdf(d) - cdf), "x", x);
    narrow_absolute.see(std::fabs(normal_cdf(x) - cdf), "x", x);
    if (x < 0) tail.see(relative_error(normal_cdf(d), cdf), "x", x);
    if (x < 0) narrow_tail.see(relative_error(normal_cdf(x), cdf) / (1 + X * X / 2), "x", x);
  }
  density.expect_at_most(1e-15, "density");
  tail.expect_at_most(3e-14, "tail");
  absolute.expect_at_most(3e-16, "cdf");
  // The exponent x^2/2 of a float is known to 6e-8 of itself.
  narrow_density.expect_at_most(3e-7, "float_density");
  narrow_tail.expect_at_most(6e-7, "float_tail");
  narrow_absolute.expect_at_most(3e-7, "float_cdf");
}

TEST(Elementary, NormalQuantileHoldsItsStatedErrors) {
  Worst narrow, wide;
  const auto see = [&](float u) {
    const long double exact = quantile_by_bisection(u);
    const long double error = std::fabs(normal_quantile(u) - exact);
    narrow.see(error / std::fmax(std::fabs(exact), 1.0L), "u", u);
    if (std::fabs(exact) > 0.01L) {
      wide.see(relative_error(normal_quantile(static_cast<double>(u)), exact), "u", u);
    }
  };
  for (int i = 1; i < 20'000; ++i) see(static_cast<float>(i / 20'000.0));
  for (float u = 1e-37f; u < 0.1f; u *= 1.01f) see(u);
  narrow.expect_at_most(1e-6, "float");
  wide.expect_at_most(1e-15, "double");
}

TEST(Elementary, NormalQuantileNearOneKeepsWhatTheComplementHasKept) {
  Worst narrow, wide;
  for (int k = 3; k <= 24; ++k) {
    const float u = 1 - std::ldexp(1.0f, -k);
    narrow.see(relative_error(normal_quantile(u), quantile_by_bisection(u)), "k", k);
  }
  for (int k = 3; k <= 52; ++k) {
    const double u = 1 - std::ldexp(1.0, -k);
    wide.see(relative_error(normal_quantile(u), quantile_by_bisection(u)), "k", k);
  }
  narrow.expect_at_most(1e-6, "float");
  wide.expect_at_most(1e-15, "double");
}

TEST(Elementary, NormalQuantileIsFiniteAndMonotoneUpToOne) {
  EXPECT_EQ(normal_quantile(0.5f), 0.0f);
  EXPECT_EQ(normal_quantile(0.5), 0.0);
  EXPECT_GT(normal_quantile(1.0f), normal_quantile(1 - 0x1p-24f));
  EXPECT_LT(normal_quantile(1.0f), 5.6f);
  EXPECT_GT(normal_quantile(1.0), normal_quantile(1 - 0x1p-53));
  EXPECT_LT(normal_quantile(1.0), 8.4);
  // The smallest deviates that uniform_48 gives: no sum of sparkles is drawn below -8 deviations.
  EXPECT_GT(normal_quantile(0x1p-49f), -8.0f);
  EXPECT_GT(normal_quantile(0x1p-49), -8.0);
  Worst drop;
  float previous = -100;
  for_floats(0x1p-49f, 1.0f, 997, [&](float u) {
    const float value = normal_quantile(u);
    drop.see(std::fmax(previous - value, 0.0f), "u", u);
    previous = value;
  });
  drop.expect_at_most(3e-6);
}

}  // namespace
