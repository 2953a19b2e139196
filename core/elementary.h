// SPDX-License-Identifier: Apache-2.0
//
// Elementary functions that give the same numbers in C++ and in OSL.
//
// Blender's OSL has fast, approximate exp, expm1 and acos (measured: expm1(1e-6) is 1.3 % wrong).
// So the float versions here are written from + - * /, sqrt and powers of two, in OSL exp2 and logb
// (exact in Blender: tests/blender/test_elementary.py), operation for operation as in
// osl/elementary.h; every wider type goes to the standard library and
// is the reference they are measured against (tests/core/elementary_test.cpp measures every error
// stated below).
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <limits>
#include <numbers>

#include "vector.h"

namespace metallic_paint {

// e^x. float: relative error 3e-7 for |x| <= 87; 0 below -87, e^87 above 87.
template <class T>
T exponential(T x) {
  return std::exp(x);
}

// ln x for x > 0. float: relative error 2.5e-7, also next to x = 1, for normal numbers below 2^127.
template <class T>
T logarithm(T x) {
  return std::log(x);
}

// sin x and cos x for 0 <= x <= pi/2. float: absolute error 2e-7.
template <class T>
T sine(T x) {
  return std::sin(x);
}
template <class T>
T cosine(T x) {
  return std::cos(x);
}

// arccos x for 0 <= x <= 1. float: relative error 3e-7.
template <class T>
T arccosine(T x) {
  return std::acos(x);
}

// The squared angle x^2 whose y = sin^2(x/2), for 0 <= y <= 1/2. Never passes through cos x, which
// has lost half its digits where x is small. float: relative error 2e-7.
template <class T>
T squared_angle(T y) {
  const T x = 2 * std::asin(sqrt(y));
  return x * x;
}

// (1 - e^-x)/x for x >= 0, and 1 at x = 0: the mean of e^(-x u) over u uniform in [0, 1].
// float: relative error 3e-7.
template <class T>
T mean_transmittance(T x) {
  return x > 0 ? -std::expm1(-x) / x : T(1);
}

// Mills ratio of the normal distribution, (1 - Phi(x))/phi(x), for x >= 0.
// float: relative error 5e-7 for x <= 17, absolute error 1e-5 beyond. double: relative error 3e-14.
template <class T>
T mills_ratio(T x) {
  if (x > 12) {
    // Continued fraction 1/(x + 1/(x + 2/(x + 3/(x + ...)))): converged to the last digit from x
    // = 12.
    T tail = x;
    for (int k = 60; k >= 1; --k) tail = x + k / tail;
    return 1 / tail;
  }
  const T half_pi = std::numbers::pi_v<T> / 2;
  return sqrt(half_pi) * std::exp(x * x / 2) * std::erfc(x / std::numbers::sqrt2_v<T>);
}

// 2^k for whole k from -126 to 127; and x = m 2^k for normal x, with whole k and m in [1, 2).
inline float power_of_two(float k) {
  return std::bit_cast<float>((static_cast<int>(k) + 127) << 23);
}
inline float binary_exponent(float x) { return std::logb(x); }
inline float significand(float x) {
  return std::bit_cast<float>((std::bit_cast<int>(x) & 0x7fffff) | 0x3f800000);
}

template <std::same_as<float> T>
T exponential(T x) {
  if (x < -87.0f) return 0.0f;
  x = min(x, 87.0f);
  // x = k ln 2 + r with ln 2 in two parts, so that r keeps its digits.
  const T k = floor(x * 1.44269504f + 0.5f);
  const T r = (x - k * 0.693145752f) - k * 1.42860677e-6f;
  const T e_r =
      1.0f + r * (1.0f + r * (0.499999911f +
                              r * (0.166664198f + r * (0.0416682251f + r * (0.00837482233f +
                                                                            r * 0.00138368341f)))));
  return e_r * power_of_two(k);
}

template <std::same_as<float> T>
T logarithm(T x) {
  // x = m 2^e with m in [1/sqrt 2, sqrt 2].
  T e = binary_exponent(x);
  T m = significand(x);
  if (m >= 1.41421356f) {
    m *= 0.5f;
    e += 1.0f;
  }
  const T s = (m - 1.0f) / (m + 1.0f);
  const T z = s * s;
  const T ln_m = s * (2.0f + z * (0.666668177f + z * (0.399746835f + z * 0.299286366f)));
  return e * 0.693147181f + ln_m;
}

template <std::same_as<float> T>
T sine(T x) {
  const T z = x * x;
  return x * (1.0f + z * (-0.166666672f +
                          z * (0.00833333097f + z * (-0.000198408321f +
                                                     z * (2.75239722e-6f + z * -2.38683491e-8f)))));
}

template <std::same_as<float> T>
T cosine(T x) {
  const T z = x * x;
  return 1.0f + z * (-0.5f +
                     z * (0.0416666679f +
                          z * (-0.00138888846f +
                               z * (2.48010401e-5f + z * (-2.75246975e-7f + z * 1.99078687e-9f)))));
}

template <std::same_as<float> T>
T arccosine(T x) {
  const T a =
      1.57079625f +
      x * (-0.2145987f +
           x * (0.0889773071f +
                x * (-0.0501641743f +
                     x * (0.0308627058f +
                          x * (-0.0170450341f + x * (0.00663856883f + x * -0.00125344284f))))));
  return sqrt(1.0f - x) * a;
}

template <std::same_as<float> T>
T squared_angle(T y) {
  // arcsin^2(sqrt y)/y is analytic in y: no square root, no loss near 0.
  const T q =
      1.0f +
      y * (0.333333671f +
           y * (0.177756384f +
                y * (0.114809297f +
                     y * (0.0748232305f +
                          y * (0.10653042f + y * (-0.138072118f +
                                                  y * (0.50241071f + y * (-0.609925389f +
                                                                          y * 0.436604947f))))))));
  return 4.0f * y * q;
}

template <std::same_as<float> T>
T mean_transmittance(T x) {
  if (x < 1.0f) {
    return 1.0f + x * (-0.5f + x * (0.166666493f +
                                    x * (-0.0416653343f +
                                         x * (0.00832814351f +
                                              x * (-0.00137776637f +
                                                   x * (0.000184942284f + x * -1.59309293e-5f))))));
  }
  return (1.0f - exponential(-x)) / x;
}

template <std::same_as<float> T>
T mills_ratio(T x) {
  const T t = 3.0f / (3.0f + x);
  return 9.77922355e-6f +
         t * (0.333045393f +
              t * (0.336978942f +
                   t * (0.270209223f +
                        t * (0.338728666f +
                             t * (-0.213797688f +
                                  t * (0.655997455f +
                                       t * (-0.768586218f +
                                            t * (0.365994066f + t * -0.0652654618f))))))));
}

// Density and distribution function of the normal deviate; the latter of a deviate and its density.
template <class T>
T normal_density(T x) {
  return T(0.398942280401432677939946L) * exponential(-T(0.5) * x * x);
}
template <class T>
T normal_cdf(T x, T density) {
  const T tail = density * mills_ratio(abs(x));
  return x < 0 ? tail : 1 - tail;
}
template <class T>
T normal_cdf(T x) {
  return normal_cdf(x, normal_density(x));
}

// The normal deviate whose distribution function is u, 0 < u <= 1; finite at u = 1.
// Wichura 1988, algorithm AS 241 (PPND16): relative error 1e-16 in exact arithmetic. float: a fit
// in sqrt(-ln u), error 1e-6, of a deviate above 1 relative. Probabilities near 0 keep all their
// digits, those near 1 only what 1 - u has kept.
template <class T>
T normal_quantile(T u) {
  const T q = u - T(0.5);
  if (abs(q) <= T(0.425)) {
    const T r = T(0.180625) - q * q;
    const T num = ((((((T(2509.0809287301226727L) * r + T(33430.575583588128105L)) * r +
                       T(67265.770927008700853L)) *
                          r +
                      T(45921.953931549871457L)) *
                         r +
                     T(13731.693765509461125L)) *
                        r +
                    T(1971.5909503065514427L)) *
                       r +
                   T(133.14166789178437745L)) *
                      r +
                  T(3.387132872796366608L);
    const T den = ((((((T(5226.495278852854561L) * r + T(28729.085735721942674L)) * r +
                       T(39307.89580009271061L)) *
                          r +
                      T(21213.794301586595867L)) *
                         r +
                     T(5394.1960214247511077L)) *
                        r +
                    T(687.1870074920579083L)) *
                       r +
                   T(42.313330701600911252L)) *
                      r +
                  1;
    return q * num / den;
  }
  const T tail = q < 0 ? u : max(1 - u, std::numeric_limits<T>::epsilon() / 4);
  const T r = sqrt(-logarithm(tail));
  T x;
  if (r <= 5) {
    const T s = r - T(1.6);
    const T num = ((((((T(7.7454501427834140764e-4L) * s + T(0.0227238449892691845833L)) * s +
                       T(0.24178072517745061177L)) *
                          s +
                      T(1.27045825245236838258L)) *
                         s +
                     T(3.64784832476320460504L)) *
                        s +
                    T(5.7694972214606914055L)) *
                       s +
                   T(4.6303378461565452959L)) *
                      s +
                  T(1.42343711074968357734L);
    const T den = ((((((T(1.05075007164441684324e-9L) * s + T(5.475938084995344946e-4L)) * s +
                       T(0.0151986665636164571966L)) *
                          s +
                      T(0.14810397642748007459L)) *
                         s +
                     T(0.68976733498510000455L)) *
                        s +
                    T(1.6763848301838038494L)) *
                       s +
                   T(2.05319162663775882187L)) *
                      s +
                  1;
    x = num / den;
  } else {
    const T s = r - 5;
    const T num = ((((((T(2.01033439929228813265e-7L) * s + T(2.71155556874348757815e-5L)) * s +
                       T(0.0012426609473880784386L)) *
                          s +
                      T(0.026532189526576123093L)) *
                         s +
                     T(0.29656057182850489123L)) *
                        s +
                    T(1.7848265399172913358L)) *
                       s +
                   T(5.4637849111641143699L)) *
                      s +
                  T(6.6579046435011037772L);
    const T den = ((((((T(2.04426310338993978564e-15L) * s + T(1.4215117583164458887e-7L)) * s +
                       T(1.8463183175100546818e-5L)) *
                          s +
                      T(7.868691311456132591e-4L)) *
                         s +
                     T(0.0148753612908506148525L)) *
                        s +
                    T(0.13692988092273580531L)) *
                       s +
                   T(0.59983220655588793769L)) *
                      s +
                  1;
    x = num / den;
  }
  return q < 0 ? -x : x;
}

template <std::same_as<float> T>
T normal_quantile(T u) {
  const T tail = u < 0.5f ? u : max(1.0f - u, T(2.98023224e-8f));
  const T s = sqrt(-logarithm(tail)) - 0.832554638f;
  const T x = s * (2.08690047f + s * (3.06331158f + s * (1.21001446f + s * 0.121097498f))) /
              (1.0f + s * (1.69982719f + s * (0.786421716f + s * 0.0855965614f)));
  return u < 0.5f ? -x : x;
}

// Of each component.
template <class T>
Rgb<T> mean_transmittance(Rgb<T> x) {
  return map(x, [](T of_one) { return mean_transmittance(of_one); });
}

}  // namespace metallic_paint
