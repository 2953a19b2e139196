// SPDX-License-Identifier: Apache-2.0
//
// The orientation of the flakes: P(beta), the density of the angle beta between flake normal and
// paint normal, with integral of P(beta) sin(beta) over [0, pi/2] equal to 1 (so p(n_f) = P/2pi per
// solid angle), and <s>, the mean projected area of a flake of unit area seen along a direction in
// the binder.
//
//   gaussian  P ~ exp(-beta^2/(2 tilt^2)), the paper's; tilt in radians
//   beckmann  P ~ exp(-tan^2(beta)/tilt^2)/cos^4(beta), tilt = the field's roughness alpha
//   ggx       P ~ 1/(tilt^2 + (1 - tilt^2) sin^2(beta))^2, likewise
//
// The field's microfacet densities are normalised per projected area; here flakes are counted, so
// the same shapes are normalised per flake. Dividing by <cos beta> turns one into the other.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <numbers>
#include <type_traits>
#include <vector>

#include "choices.h"
#include "elementary.h"
#include "quadrature.h"
#include "vector.h"

namespace metallic_paint {

template <class T>
struct OrientationDensity {
  Orientation kind;
  T tilt;
  T norm;       // integral of the shape times sin(beta)
  T mean_cos;   // <cos beta>
  T below = 1;  // gaussian: share of exp(-b^2/2s^2) b below 90 degrees, which `sample_tilt` draws
  T back_cosine = 1;  // gaussian: a direction of this cosine or a greater one meets no flake's back
};

// Beyond so many tilts a Gaussian is below rounding.
template <class T>
inline constexpr double kGaussianReach = std::is_same_v<T, float> ? 5.5 : 12;

// sum over n of (-y)^n/(2n+1)!!: Dawson's function, sqrt(2) F(sqrt(y/2))/sqrt(y). Error 4e-12 for
// y <= 0.32.
template <class T>
T dawson_series(T y) {
  return 1 -
         y / 3 *
             (1 - y / 5 * (1 - y / 7 * (1 - y / 9 * (1 - y / 11 * (1 - y / 13 * (1 - y / 15))))));
}

template <class T>
OrientationDensity<T> make_orientation(Orientation kind, T tilt) {
  if constexpr (!std::is_same_v<T, Wide<T>>) {
    const auto wide = make_orientation<Wide<T>>(kind, tilt);
    return {kind,
            tilt,
            static_cast<T>(wide.norm),
            static_cast<T>(wide.mean_cos),
            static_cast<T>(wide.below),
            static_cast<T>(wide.back_cosine)};
  }
  OrientationDensity<T> density{kind, tilt, 1, 1};
  const T square = tilt * tilt;
  if (kind == Orientation::gaussian) {
    const T half_pi = std::numbers::pi_v<T> / 2;
    density.below = 1 - exponential(T(-0.5) * half_pi * half_pi / square);
    density.back_cosine = sine(min(T(kGaussianReach<T>) * tilt, half_pi));
    if (std::is_same_v<T, float> && square <= T(0.08)) {
      // The upper limit pi/2 taken as infinity (the missing tail is under 2e-7):
      // integral of exp(-b^2/2s^2) sin(b) = s^2 dawson_series(s^2), with sin(2b)/2 for sin(b): y ->
      // 4y.
      density.norm = square * dawson_series(square);
      density.mean_cos = dawson_series(4 * square) / dawson_series(square);
      return density;
    }
    const GaussRule<T>& rule = gauss_rule<T>();
    const T limit = min(std::numbers::pi_v<T> / 2, T(kGaussianReach<T>) * tilt);
    T sum = 0, sum_cos = 0;
    for (int i = 0; i < kGaussPoints<T>; ++i) {
      const T beta = limit * rule.node[i];
      const T x = beta / tilt;
      const T term = rule.weight[i] * exponential(T(-0.5) * x * x) * sine(beta);
      sum = sum + term;
      sum_cos = sum_cos + term * cosine(beta);
    }
    density.norm = limit * sum;
    density.mean_cos = sum_cos / sum;
  } else if (kind == Orientation::beckmann) {
    // integral of D cos = tilt^2/2 and, by parts, norm = (tilt^2/2)(1 + tilt
    // M(sqrt(2)/tilt)/sqrt(2)).
    const T root_half = T(0.707106781186547524401L);
    density.mean_cos = 1 / (1 + root_half * tilt * mills_ratio(2 * root_half / tilt));
    density.norm = square / (2 * density.mean_cos);
  } else {
    // With w^2 = 1 - tilt^2: norm = (1/tilt^2 + artanh(w)/w)/2, integral of the shape times cos =
    // 1/(2 tilt^2).
    const T w2 = (1 - tilt) * (1 + tilt);
    T artanh_over_w = 1 + w2 * (T(1) / 3 + w2 * (T(1) / 5 + w2 * (T(1) / 7 + w2 / 9)));
    if (w2 > T(0.0025)) {
      const T w = sqrt(w2);
      artanh_over_w = logarithm((1 + w) / tilt) / w;
    }
    const T ratio = 1 + square * artanh_over_w;
    density.norm = ratio / (2 * square);
    density.mean_cos = 1 / ratio;
  }
  return density;
}

// P(beta) from sin^2(beta/2) in [0, 1/2], which keeps its digits where beta is small. In a type T
// wider than the density's own D, rounding in the exponent stays behind.
template <class T, class D>
T gaussian_density(const OrientationDensity<D>& density, T sin2_half_beta) {
  const T square = T(density.tilt) * T(density.tilt);
  return exponential(T(-0.5) * (squared_angle(sin2_half_beta) / square)) / density.norm;
}

// Of any shape.
template <class T, class D>
T orientation_density(const OrientationDensity<D>& density, T sin2_half_beta) {
  if (density.kind == Orientation::gaussian) return gaussian_density(density, sin2_half_beta);
  const T square = T(density.tilt) * T(density.tilt);
  const T cos_beta = 1 - 2 * sin2_half_beta;
  const T sin2 = 4 * sin2_half_beta * (1 - sin2_half_beta);
  if (density.kind == Orientation::beckmann) {
    const T cos2 = cos_beta * cos_beta;
    if (cos2 < T(1e-9)) return 0;
    return exponential(-(sin2 / cos2) / square) / (cos2 * cos2 * density.norm);
  }
  const T d = square + (1 - square) * sin2;
  return 1 / (d * d * density.norm);
}

// d ln P/d cos(beta): how fast the flakes grow fewer, (-dP/d beta)/(P sin(beta)).
template <class T>
T orientation_slope(const OrientationDensity<T>& density, T sin2_half_beta) {
  const T square = density.tilt * density.tilt;
  const T cos_beta = 1 - 2 * sin2_half_beta;
  const T sin2 = 4 * sin2_half_beta * (1 - sin2_half_beta);
  if (density.kind == Orientation::ggx) {
    return 4 * (1 - square) * cos_beta / (square + (1 - square) * sin2);
  }
  if (density.kind == Orientation::beckmann) {
    const T cosine = max(cos_beta, T(1e-3));
    return 2 / (cosine * cosine * cosine * square) - 4 / cosine;
  }
  // beta/sin(beta), 1 at a level flake.
  return sqrt(squared_angle(sin2_half_beta) / max(sin2, T(1e-30))) / square;
}

// One over that at a level flake, but for a small tilt's square: the variance of the tilt in a
// plane where most flakes are.
template <class T>
T core_variance(const OrientationDensity<T>& density) {
  const T square = density.tilt * density.tilt;
  if (density.kind == Orientation::ggx) return square / 4;
  if (density.kind == Orientation::beckmann) return square / 2;
  return square;
}

// Beyond this angle no flake is left but for rounding: exp(-12^2/2) (float: exp(-5.5^2/2)),
// exp(-6.5^2); ggx has its tail.
template <class T>
T orientation_reach(const OrientationDensity<T>& density) {
  const T all = std::numbers::pi_v<T> / 2;
  if (density.kind == Orientation::gaussian) return min(all, T(kGaussianReach<T>) * density.tilt);
  if (density.kind == Orientation::beckmann) return min(all, T(6.5) * density.tilt);
  return all;
}

// Caps up to this part of the tilt in radius take P at their centre: off by (rho^2/8)
// laplace(P)/P, 1e-3 at beta = 0 and 7e-3 at beta = 4 tilts for the Gaussian. A tilt above 1 rad
// counts as 1: the half sphere ends, however even P is.
inline constexpr double kPointCap = 1.0 / 16;

// Probability that a flake's normal lies in the cap of angular radius rho about a direction at beta
// from the paint normal; both as sin^2 of the half angle. 2 P(beta) sin^2(rho/2) for small caps;
// for caps as wide as the tilt the integral of P(b) sin(b) phi(b)/pi over the circles b about the
// paint normal, where phi is half the arc of the circle inside the cap, from the spherical triangle
// (beta, b, rho): sin^2(phi/2) = sin((b + rho - beta)/2) sin((beta + rho - b)/2)/(sin(beta)
// sin(b)). Pieces that grow with b serve sharp shapes and long tails; b = from + width x^2 (3 - 2x)
// makes the roots at both ends smooth.
template <class T, class D>
T cap_probability(const OrientationDensity<D>& density, T sin2_half_beta, T sin2_half_rho) {
  const T square = squared_angle(min(sin2_half_rho, T(0.5)));
  const T point_cap = T(kPointCap) * min(T(density.tilt), T(1));
  if (square <= point_cap * point_cap) {
    return 2 * orientation_density(density, sin2_half_beta) * sin2_half_rho;
  }
  const T pi = std::numbers::pi_v<T>;
  const T rho = sqrt(square);
  const T beta = sqrt(squared_angle(sin2_half_beta));
  const T sin_beta = sine(beta);
  const T whole = rho - beta;  // circles up to here lie inside the cap
  const GaussRule<T>& rule = gauss_rule<T>();
  T sum = 0;
  T from = max(-whole, T(0));
  // A Gaussian falls by exp(-reach^2/2) from there to sqrt(from^2 + reach^2), the others sooner or
  // not at all.
  const T reach = orientation_reach(density);
  const T end = min(min(beta + rho, pi / 2), sqrt(from * from + reach * reach));
  T edge = density.tilt;
  while (edge <= from) edge = edge * 4;
  while (from < end) {
    T to = min(edge, end);
    if (from < whole) to = min(to, whole);
    const T width = to - from;
    for (int i = 0; i < kGaussPoints<T>; ++i) {
      const T x = rule.node[i];
      const T b = from + width * (x * x * (3 - 2 * x));
      const T sin_half = sine(b / 2);
      const T sin_b = sine(b);
      T arc = 1;
      if (b > whole) {
        const T near = sine(max((b + whole) / 2, T(0)));
        const T far = sine(max((beta + rho - b) / 2, T(0)));
        const T y = near * far / (sin_beta * sin_b);
        if (y < 1) {
          const T nearer = sqrt(squared_angle(min(y, 1 - y))) / pi;
          arc = y < T(0.5) ? nearer : 1 - nearer;
        }
      }
      const T ring = rule.weight[i] * (6 * x * (1 - x)) * width * arc;
      sum = sum + ring * sin_b * orientation_density(density, sin_half * sin_half);
    }
    from = to;
    if (edge <= to) edge = edge * 4;
  }
  return min(sum, T(1));
}

// A random flake's tilt, for a uniform deviate u in (0, 1): not quite P(beta) sin(beta), so with
// the weight that makes up for it.
template <class T>
struct SampledTilt {
  T sin2_half_beta;
  T weight;  // P(beta) sin(beta) over the density it was drawn with
};

//   gaussian  up to 1/2: exp(-b^2/2s^2) b below 90 degrees; above: evenly over the half sphere
//   beckmann  the shape times cos(beta): exponential in tan^2(beta), weight <cos>/cos(beta)
//   ggx       in x = 1 - cos(beta) under 1/(a^2 + w x)^2, w = 1 - a^2, which is above the shape
//             1/(a^2 + w x (2 - x))^2, so that no weight passes 1/(a^2 norm) < 2
template <class T>
SampledTilt<T> sample_tilt(const OrientationDensity<T>& density, T u) {
  const T square = density.tilt * density.tilt;
  if (density.kind == Orientation::ggx) {
    const T w = (1 - density.tilt) * (1 + density.tilt);
    const T x = u * square / (1 - u * w);
    const T ratio = (square + w * x) / (square + w * x * (2 - x));
    return {x / 2, ratio * ratio / (density.norm * square)};
  }
  if (density.kind == Orientation::beckmann) {
    const T tan2 = square * -logarithm(u);
    const T cos_beta = 1 / sqrt(1 + tan2);
    // 1 - cos = sin^2/(1 + cos)
    return {T(0.5) * tan2 * cos_beta * cos_beta / (1 + cos_beta), density.mean_cos / cos_beta};
  }
  if (density.tilt > T(0.5)) return {u / 2, gaussian_density(density, u / 2)};
  const T beta = density.tilt * sqrt(-2 * logarithm(1 - u * density.below));
  const T half = sine(beta / 2);
  const T sinc = beta > 0 ? sine(beta) / beta : T(1);
  return {half * half, sinc * square * density.below / density.norm};
}

// The largest of these weights: that of a level flake, where the drawn tilts are too rare; of
// Beckmann's that at the tilt of which e^-16 of the flakes lie beyond.
template <class T>
T most_tilt_weight(const OrientationDensity<T>& density) {
  const T square = density.tilt * density.tilt;
  if (density.kind == Orientation::beckmann) return density.mean_cos * sqrt(1 + 16 * square);
  if (density.kind == Orientation::ggx) return 1 / (density.norm * square);
  if (density.tilt > T(0.5)) return 1 / density.norm;
  return square * density.below / density.norm;
}

// Gaussian only: the mean area that flakes tilted beyond 90 degrees from the direction show with
// their backs. Near the horizon at the elevation b0 = 90 degrees - theta only the tilt x towards
// the direction counts, a normal deviate, and the backs show sin(x - b0): with y = b0/tilt that is
// tilt (phi(y) - y Q(y)), phi and Q the normal density and its upper tail. A fit in b0 and tilt
// makes up for the curvature, and another one, times 1 - below, for the flakes that a normal
// deviate has beyond 90 degrees, where there are none (tests/fits/back_area.py). Absolute error
// 5e-7 (BackAreaHoldsItsStatedError, with rounding).
inline constexpr float kNarrowBack = 0.4f;
template <std::same_as<float> T>
T narrow_back_area(const OrientationDensity<T>& density, T b0) {
  const T s = density.tilt;
  const T c0 = 0.999948561f +
               s * (0.00132694806f + s * (-0.680161595f + s * (0.061232321f + s * 0.267149389f)));
  const T c1 = 0.00140373979f +
               s * (0.410378277f + s * (-0.00062495051f + s * (-0.265823483f + s * -0.132559106f)));
  const T c2 = -0.00404177979f +
               s * (0.326647073f + s * (-2.23132157f + s * (7.13950872f + s * -7.62903643f)));
  const T c3 = 0.480474234f + s * (-1.7636373f + s * (2.3438592f + s * -1.36711812f));
  const T c4 = -0.544060051f + s * (2.23223352f + s * -1.72242761f);
  const T c5 = 0.24584423f + s * -0.777165353f;
  const T curved =
      c0 + b0 * (c1 + b0 * (c2 + b0 * (c3 + b0 * (c4 + b0 * (c5 + b0 * 0.0480376258f)))));
  const T beyond = -0.109831154f + b0 * (-0.0525594763f + b0 * 0.0711019114f);
  const T y = b0 / s;
  return s * normal_density(y) * (1 - y * mills_ratio(y)) * curved + (1 - density.below) * beyond;
}

// For wider tilts, and exact: (1/pi) integral of P sin(b) (sqrt(B^2 - A^2) - A acos(A/B)) over b
// from b0, A = cos(theta) cos(b), B = sin(theta) sin(b). b = b0 + L x^2 makes the integrand smooth.
// float (12 points, tilts above kNarrowBack): absolute error 5e-7.
template <class T>
T gaussian_back_area(const OrientationDensity<T>& density, T cos_theta) {
  if (cos_theta >= density.back_cosine) return 0;
  const T b0 = std::numbers::pi_v<T> / 2 - arccosine(cos_theta);
  if constexpr (std::is_same_v<T, float>) {
    if (density.tilt <= kNarrowBack) return narrow_back_area(density, b0);
  }
  const T limit = min(std::numbers::pi_v<T> / 2, b0 + T(kGaussianReach<T>) * density.tilt);
  const GaussRule<T>& rule = gauss_rule<T>();
  const T sin_theta = sqrt((1 - cos_theta) * (1 + cos_theta));
  T sum = 0;
  for (int i = 0; i < kGaussPoints<T>; ++i) {
    const T x = rule.node[i];
    const T b = b0 + (limit - b0) * x * x;
    const T sin_b = sine(b);
    const T a = cos_theta * cosine(b);
    const T c = sin_theta * sin_b;
    if (a >= c) continue;
    const T back = sqrt((c - a) * (c + a)) - a * arccosine(a / c);
    const T tilts = b / density.tilt;
    sum = sum + rule.weight[i] * x * exponential(T(-0.5) * tilts * tilts) * sin_b * back;
  }
  return 2 * (limit - b0) * sum / (std::numbers::pi_v<T> * density.norm);
}

// <s>(theta) = integral of p(n_f) |v . n_f|, for the cosine in the binder, 0 to 1. Flakes seen from
// their front and from their back: <v . n_f> + 2 <(-v . n_f)+>. For the field's shapes the second
// part is Smith's masking integral in closed form (Walter 2007; Heitz 2014), cos(theta) (1 + 2
// Lambda) <cos beta>.
template <class T>
T mean_projected_area(const OrientationDensity<T>& density, T cos_theta) {
  const T front = cos_theta * density.mean_cos;
  if (density.kind == Orientation::gaussian) {
    return front + 2 * gaussian_back_area(density, cos_theta);
  }
  const T spread = density.tilt * sqrt((1 - cos_theta) * (1 + cos_theta));
  if (density.kind == Orientation::ggx) {
    return density.mean_cos * sqrt(cos_theta * cos_theta + spread * spread);
  }
  // Beckmann: 1 + 2 Lambda = erf(a) + exp(-a^2)/(a sqrt(pi)), a = cot(theta)/tilt.
  if (cos_theta > 6 * spread) return front;
  const T x = T(1.41421356237309504880L) * cos_theta / spread;  // sqrt(2) a
  const T tail = 2 * normal_density(x);
  const T edge = T(0.707106781186547524401L) * spread * tail;
  return density.mean_cos * (cos_theta * (1 - tail * mills_ratio(x)) + edge);
}

}  // namespace metallic_paint
