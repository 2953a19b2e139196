// SPDX-License-Identifier: Apache-2.0
//
// The flakes' single scattering of light that has no sparkles: of the world, of area lights, of
// neighbours. It is the mean over random flakes. For each sample a renderer takes one flake, and
// looks along the direction that it mirrors to the observer.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "close_up.h"
#include "hot_spot.h"
#include "layer.h"
#include "smooth_part.h"

namespace metallic_paint {

// Between the ends of (0, 1), where rounding may put a share of an interval.
template <class T>
T inside_unit(T x) {
  return clamp(x, T(1e-7), T(1) - T(1e-7));
}

// A renderer samples its lamps by a cone of directions about a flake's mirror direction, the better
// the wider it is. Let x be the mirror direction of a random flake, of the density g, and let z be
// what a Gaussian of the variance t (in each direction) would have added to another direction c.
// Given x = c + z (Tweedie),
//   <c> = x + t grad ln g(x), var(c) = t (1 + t grad grad ln g(x)),
// and as a Gaussian is a mixture of discs about its middle (whose squared radius has the density
// r^2 exp(-r^2/2t)/(4 t^2)), x lies anywhere in such a disc about c: r^2 = |x - c|^2 - 2 t ln(u).
// So all of the disc may show what the flake at x would, and the mean stays: under a world of one
// radiance to the letter, else but for g's third derivatives. Nothing prefers one point of the
// disc, so where it may not be, as it holds a listed light or the horizon, the flake's own
// direction takes its place.
// t is this share of the variance of the mirror directions across the plane of view. A lamp's light
// is off by 2.2 % at most, 0.5 % in 95 % (48 paints under round lamps of 0.1 to 0.5 rad;
// tests/fits/lobe_spread.cpp). Twice that deviation has a quarter less noise, twice the error.
inline constexpr double kWideShare = 0.15;
// Most of sqrt(t): in rad, and for the horizon's sake in cosines of the view, or of the light that
// is mirrored most (`rise`) where a smooth part (smooth_part.h) shows the more of it.
inline constexpr double kWidestDeviation = 0.2;
inline constexpr double kToHorizon = 0.1, kToHorizonBeside = 0.2;
// Otherwise it is widened to a cone of this half-angle, in units of eta tilt (the tilt turns the
// mirror direction by 2 eta tilt), so that small lamps beyond the slots are met.
inline constexpr double kLobeSpread = 0.33;
inline constexpr double kWidestLobe = 0.1;

template <class T>
struct MirroredSample {
  Vec3<T> direction;        // outside, unit, away from the surface
  Rgb<T> weight{};          // what it shows of the radiance from there; 0 if it shows nothing
  T spread{};               // half-angle of the narrow cone about the direction that may show it
  T variance{};             // t; 0 where there is no wide cone
  Vec3<T> drift{};          // t grad ln g
  T along = 1, across = 1;  // sqrt(var(c)/t) in the plane of the normal and across it
  T density{};              // that drew it, 1/sr; 0 of a flake that is seen close up
  int species{};
};

// A flake's species is drawn by covered area, its normal m from p. The mirror law takes m to the
// light's direction in the binder, dw_m = dw/(4 |v . m|), and refraction takes that outside. So the
// direction outside has the density
//   q = p/(4 |v . m|) cos(theta')/(eta^2 cos(theta'_p)),
// and with the BRDF f of flake_brdf.h the sample's weight is
//   f cos(theta')/q = D H <S> |v . m|/cos(theta_p) r_p A (1 - r)(1 - r'), <S> over all species.
// Its gradient, for the wide cone, is that of ln p cos(theta')/cos(theta'_p). With n the paint's
// normal and L outside, l inside the direction of the light,
//   ln p moves by P . dm, P = (n - m cos(beta)) d ln p/d cos(beta), m by dl/(2 v . m) up to m
//   itself, l by dL_t/eta in the plane of the surface and -l_t . dL_t/(eta l_n) across it.
// The spread of a flake's own mirror image is left out. That shows where it is not narrow against
// the tilt: under the sun a spread of 0.1 rad at a tilt of 0.15 changes the mean by 3 %.
// Of a species that is seen close up the flake is the one that the sample sees (`firsts`, one for
// each species), or none; drawn with the probability of its species' share of the covered area.
// `rise` is the cosine of the light that is mirrored most, where a smooth part shows it; else 0. u
// and w are uniform deviates in (0, 1). Blender has the same mean but not the same bits: OSL's own
// sin and cos place the azimuth.
template <class T>
MirroredSample<T> sample_flake(const Layer<T>& layer, Vec3<T> normal, Vec3<T> view, T u, T w,
                               const FirstFlake<T>* firsts = nullptr, T rise = 0) {
  MirroredSample<T> sample{normal};
  const T eta = layer.eta;
  const T cos_view = min(dot(normal, view), T(1));
  if (!(cos_view > T(kLeastCosine))) return sample;
  const T g_view = eta_cos_refracted(cos_view, eta);
  if (!(g_view > 0)) return sample;
  const Vec3<T> v = (view + normal * (g_view - cos_view)) / eta;
  if (!(layer.coverage > 0)) return sample;

  // u picks the species, and what is left of it the tilt.
  T at = u * layer.coverage;
  std::size_t i = 0;
  while (i + 1 < static_cast<std::size_t>(layer.species) && at >= layer.flakes[i].coverage) {
    at = at - layer.flakes[i].coverage;
    ++i;
  }
  const Flakes<T>& flakes = layer.flakes[i];
  sample.species = static_cast<int>(i);
  const FirstFlake<T> first = firsts != nullptr ? firsts[i] : FirstFlake<T>{};
  if (first.close && !first.seen) return sample;
  Vec3<T> m = first.normal;
  SampledTilt<T> tilt{};
  if (first.close) {
    // The flake's own cone, pi epsilon^2, as it leaves the binder.
    sample.spread = min(eta * sqrt(flakes.solid_angle / std::numbers::pi_v<T>), T(kWidestLobe));
  } else {
    const T rest = layer.species > 1 ? inside_unit(at / max(flakes.coverage, T(1e-30))) : u;
    tilt = sample_tilt(flakes.orientation, rest);
    sample.spread = min(T(kLobeSpread) * (eta * flakes.orientation.tilt), T(kWidestLobe));
    const T h = tilt.sin2_half_beta;
    const T sin_beta = 2 * sqrt(h * (1 - h)), phi = 2 * std::numbers::pi_v<T> * w;
    // Any two directions across the normal.
    Vec3<T> across = abs(normal.x) < T(0.6) ? Vec3<T>{1, 0, 0} : Vec3<T>{0, 1, 0};
    across = across - normal * dot(normal, across);
    across = across / length(across);
    const Vec3<T> other = cross(normal, across);
    m = normal * (1 - 2 * h) + across * (sin_beta * std::cos(phi)) +
        other * (sin_beta * std::sin(phi));
  }

  const T facing = dot(m, v);
  const Vec3<T> l = m * (2 * facing) - v;
  const T along = dot(l, normal);
  if (!(along > 0)) return sample;  // deeper into the layer
  const Vec3<T> tangent = (l - normal * along) * eta;
  const T cos2_light = 1 - dot(tangent, tangent);
  if (!(cos2_light > 0)) return sample;  // total reflection
  const T cos_light = sqrt(cos2_light), g_light = eta * along;
  if (!(cos_light > T(kLeastCosine))) return sample;
  sample.direction = tangent + normal * cos_light;

  const T cos_alpha = min(abs(facing), T(1));
  const T cos_view_in = min(g_view / eta, T(1)), cos_light_in = min(along, T(1));
  const Rgb<T> slant =
      there_and_back(layer, slant_depth_of(layer, cos_view_in), slant_depth_of(layer, cos_light_in),
                     length(v / cos_view_in - l / along));
  const T exit = layer.radiometry == Radiometry::published ? cos_view : cos_view_in;
  // 1 - r goes to zero with the cosine of the exit, A with its inverse: neither overflows.
  const T through = fresnel_transmittance(cos_view, g_view, eta) / exit *
                    fresnel_transmittance(cos_light, g_light, eta);
  const Rgb<T> reflectance = coating_reflectance(flakes.coating, cos_alpha);
  if (first.close) {
    sample.weight = shown_by(first, reflectance, slant) *
                    (through * cos_view_in * (layer.coverage / flakes.coverage));
  } else {
    sample.weight = reflectance * (mean_transmittance(slant) * layer.coverage) *
                    (through * tilt.weight * cos_alpha);
    const T p = orientation_density(flakes.orientation, tilt.sin2_half_beta) / tilt.weight;
    sample.density = p * cos_light * flakes.coverage /
                     (8 * std::numbers::pi_v<T> * cos_alpha * eta * g_light * layer.coverage);
    const T turned = 2 * eta * cos_view_in;
    const T most =
        min(T(kWidestDeviation), rise > 0 ? T(kToHorizonBeside) * rise : T(kToHorizon) * cos_view);
    sample.variance =
        min(T(kWideShare) * turned * turned * core_variance(flakes.orientation), most * most);
    const T slope = orientation_slope(flakes.orientation, tilt.sin2_half_beta);
    const Vec3<T> pull = (normal - m * (1 - 2 * tilt.sin2_half_beta)) * (slope / (2 * facing));
    const Vec3<T> gradient = (pull - l * (dot(pull, normal) / along)) / eta +
                             tangent * (1 / (eta * eta * along * along) - 1 / cos2_light);
    sample.drift =
        (gradient - sample.direction * dot(gradient, sample.direction)) * sample.variance;
    const T along_turn = cos_light / (2 * eta * along), across_turn = 1 / (2 * eta * cos_alpha);
    const T bend = sample.variance * slope;
    sample.along = sqrt(max(1 - bend * along_turn * along_turn, T(0)));
    sample.across = sqrt(max(1 - bend * across_turn * across_turn, T(0)));
  }
  return sample;
}

// The unit vector across `direction` in the plane of the surface; 0 where that is the normal.
template <class T>
Vec3<T> level_across(Vec3<T> normal, Vec3<T> direction) {
  const Vec3<T> sideways = cross(normal, direction);
  const T sine = length(sideways);
  return sine > T(1e-6) ? sideways / sine : Vec3<T>{};
}

// A small share of what a flake shows beside a smooth part, or less than nothing, is given to the
// lobes instead (`give_to_lobes`): all light together stays. It moves, though: of 900 lamps 12 are
// off by more than 1 % of what flakes show of them, 95 % by up to 0.8 %, one by 1.8 %. With a share
// of 0.05 twice as many are, and noise under an HDRI is 2 % less.
inline constexpr double kGivenToLobe = 0.03;
// So many flakes a sample then, each of this part of the weight, their deviates evenly apart: a
// lamp that one cone misses is in another. A third takes 5 % more instructions and 2 to 3 % of the
// noise from silver balls under an HDRI and softboxes. Where the lobes lean away from a sun the
// flakes show more: there five in place of three take a quarter of the variance under a softbox.
inline constexpr int kFlakesBeside = 2, kFlakesLeaning = 5;

// Leaves of the sample what it shows beside the smooth part of its species, and returns what is
// given. The wide cone is that of what is left, r = f cos(theta') - g1 - g2: with k = g/r of each
// lobe and F and G the logarithms of f cos(theta') and g,
//   (ln r)' = F' + sum k (F' - G'),
//   (ln r)'' = F'' + sum (k (F'' - G'') - k (F' - G')^2) - (sum k (F' - G'))^2.
// Lobes that lean away from a light leave r a ridge there, narrower by sqrt(1 + k): beside them t
// is less by that. A lamp's light is then off as beside others, by 1.7 % at most in 95 % of 150 (by
// 2.6 % if t stays); with t less by 1 + k the noise is a sixth more.
template <class T>
Rgb<T> leave_beside(MirroredSample<T>& sample, const SmoothPart<T>& part, Vec3<T> normal,
                    Vec3<T> view) {
  if (!(sample.density > 0)) return {};
  const Rgb<T> whole = sample.weight;
  const Rgb<T> narrow =
      part.narrow.weight * (facets_show(part.narrow, sample.direction) / sample.density);
  const Rgb<T> wide =
      part.wide.weight * (facets_show(part.wide, sample.direction) / sample.density);
  const Rgb<T> all = whole - narrow - wide;
  T by_narrow = 0, by_wide = 0, after = 0;
  const auto left = [&](T rest, T from, T narrow_shows, T wide_shows) {
    if (!(rest > T(kGivenToLobe) * from)) return T(0);
    by_narrow = by_narrow + narrow_shows;
    by_wide = by_wide + wide_shows;
    after = after + rest;
    return rest;
  };
  sample.weight.x = left(all.x, whole.x, narrow.x, wide.x);
  sample.weight.y = left(all.y, whole.y, narrow.y, wide.y);
  sample.weight.z = left(all.z, whole.z, narrow.z, wide.z);
  const Rgb<T> given = all - sample.weight;
  if (!(after > 0 && sample.variance > 0)) return given;

  const T narrowed = sqrt(min(part.narrow.narrowed, part.wide.narrowed));
  const T t = sample.variance * narrowed;
  sample.variance = t;
  sample.drift = sample.drift * narrowed;
  const Vec3<T> across = level_across(normal, sample.direction);
  const Vec3<T> along = cross(sample.direction, across);
  T pull_along = 0, pull_across = 0;  // t sum k (F' - G')
  T bend_in = 0, bend_across = 0;     // t sum (k (F'' - G'') - k (F' - G')^2)
  const T f_along = (sample.along * sample.along - 1) * narrowed;
  const T f_across = (sample.across * sample.across - 1) * narrowed;
  const auto lobe = [&](const Facets<T>& facets, T k) {
    if (!(k > 0)) return;
    const FacetsFall<T> fall = facets_fall(facets, view, sample.direction);
    const Vec3<T> apart = sample.drift - fall.gradient * t;
    const T a = dot(apart, along), b = dot(apart, across);
    pull_along = pull_along + k * a;
    pull_across = pull_across + k * b;
    bend_in = bend_in + k * (f_along - t * bend_along(fall, along) - a * a / t);
    bend_across = bend_across + k * (f_across - t * bend_along(fall, across) - b * b / t);
  };
  lobe(part.narrow, by_narrow / after);
  lobe(part.wide, by_wide / after);
  sample.drift = sample.drift + along * pull_along + across * pull_across;
  sample.along = sqrt(max(1 + f_along + bend_in - pull_along * pull_along / t, T(0)));
  sample.across = sqrt(max(1 + f_across + bend_across - pull_across * pull_across / t, T(0)));
  return given;
}

// The lobes with what flakes have given them. Small shares are about the middle, where the lobes
// are nearest to f, so the narrow one takes them; too much they show at their sides, so that is the
// wide one's to lose, and the narrow one's only where the wide one has no more.
template <class T>
SmoothPart<T> give_to_lobes(SmoothPart<T> part, Rgb<T> more, Rgb<T> less) {
  const auto above = [](T x) { return max(x, T(0)); };
  const Rgb<T> rest = part.wide.weight + less;
  part.wide.weight = map(rest, above);
  part.narrow.weight = map(part.narrow.weight + more + least(rest, Rgb<T>{}), above);
  return part;
}

template <class T>
struct LobeCone {
  Vec3<T> direction;  // of its middle
  T half_angle{};     // 0: there is no such cone
};

// The wide cone about c, above the horizon. u, w and e are uniform deviates in (0, 1).
template <class T>
LobeCone<T> wide_cone(const MirroredSample<T>& sample, Vec3<T> normal, T u, T w, T e) {
  LobeCone<T> cone{sample.direction};
  const Vec3<T> across = level_across(normal, sample.direction);
  if (!(sample.variance > 0 && dot(across, across) > 0)) return cone;
  const Vec3<T> along = cross(sample.direction, across);
  const T off = sqrt(-2 * sample.variance * logarithm(u)), phi = 2 * std::numbers::pi_v<T> * w;
  const Vec3<T> middle = sample.direction + sample.drift +
                         along * (sample.along * off * std::cos(phi)) +
                         across * (sample.across * off * std::sin(phi));
  const Vec3<T> towards = middle / length(middle);
  const Vec3<T> chord = sample.direction - towards;
  // (2 sin(r/2))^2, in which discs on the sphere have the area of those in a plane.
  const T square = dot(chord, chord) - 2 * sample.variance * logarithm(e);
  const T half = T(0.5) * sqrt(square);
  if (!(square < 2 && 2 * half * sqrt(1 - half * half) < dot(towards, normal))) return cone;
  cone.direction = towards;
  cone.half_angle = 2 * std::asin(half);
  return cone;
}

}  // namespace metallic_paint
