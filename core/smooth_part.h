// SPDX-License-Identifier: Apache-2.0
//
// What flakes mirror of other light, as far as two lobes of microfacets show it.
//
// Random flakes (flake_lobe.h) are noise: of a wide lamp a renderer sees what one of their cones
// holds. Lobes of microfacets, together g, it samples evenly and by its lamps. So
//   f cos(theta') = g + (f cos(theta') - g):
// microfacets show g, and what a random flake shows is less by g over the density that drew it.
// Where that is less than nothing, g itself is less by as much, so all light together stays what it
// was; but for what g shows where hardly any flake is drawn (0.6 % of the paint at tilts above 0.3
// at most).
//
// Of the half vector h of view and light the slope to the surface is (v + l)_t/(cos + cos'), and
// that of the flake which mirrors them (v + l)_t/(g + g'), g = eta cos(theta_p). Near the mirror
// direction, where cos' = cos, facets of alpha0^2 = 2 var g^2/cos^2 mirror as the flakes do
// (`core_variance`). (1 - r') cos' falls to the horizon as cos'^2, hence in the plane of view by
// (x/cos)^2 and 2 x tan(theta), x from the mirror direction: the facets' normal turns from the
// horizon, and alpha is smaller.
//
// Over the other factors of that first guess, and over that in its middle, f falls with the slope
// more slowly than a Gaussian: for the half vector's slope is not the flake's. It is taken for
//   (1 - e) exp(-r^2/A) + e exp(-r^2/B),
// r over the alpha at which it has fallen to 1/e, B = kWider. So there
// (1 - e) exp(-1/A) + e exp(-1/B) = 1/e, which with f two alphas across the plane of view gives e
// and A. The wide lobe's own middle is where it shows f two alphas towards the observer; what it
// leaves of f in the middle and an alpha to each side is the narrow lobe's, a parabola's logarithm.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "expected_sparkles.h"
#include "hot_spot.h"
#include "layer.h"
#include "light.h"
#include "outline.h"

namespace metallic_paint {

template <class T>
struct Facets {
  Vec3<T> normal{}, along{}, across{};  // of the facets, and the directions of alpha_x and alpha_y
  T alpha_x{}, alpha_y{};
  T view_along{}, view_across{}, view_up{};  // of the view, by these three
  T view_masked{};                           // 1 + Lambda of the view, Smith's
  T narrowed = 1;                            // 1/(1 + k) of lean_lobe
  Rgb<T> weight{};                           // of the lobe; 0: there is none
};

template <class T>
struct SmoothPart {
  Facets<T> narrow, wide;
};

// Smith's Lambda of Beckmann's facets by (alpha tan(theta))^2, in the approximation of Walter
// (2007) that Cycles has.
template <class T>
T masking_lambda(T square) {
  if (square < T(0.39)) return 0;
  const T a = 1 / sqrt(square);
  return ((T(0.396) * a - T(1.259)) * a + 1) / ((T(2.181) * a + T(3.535)) * a);
}

// The square, of a direction that goes so far along, across and up.
template <class T>
T masking_square(const Facets<T>& facets, T along, T across, T up) {
  const T x = along * facets.alpha_x, y = across * facets.alpha_y;
  return (x * x + y * y) / max(up * up, T(1e-12));
}

// BRDF times cos(theta') of facets that reflect all, as Cycles evaluates them.
template <class T>
T facets_show(const Facets<T>& facets, Vec3<T> light) {
  const T up = dot(light, facets.normal);
  if (!(facets.view_up > 0 && up > 0)) return 0;
  const T along = dot(light, facets.along), across = dot(light, facets.across);
  const T masked = facets.view_masked + masking_lambda(masking_square(facets, along, across, up));
  const T half_along = facets.view_along + along, half_across = facets.view_across + across;
  const T half_up = facets.view_up + up;
  const T x = half_along / facets.alpha_x, y = half_across / facets.alpha_y;
  const T per_up2 = 1 / (half_up * half_up);
  const T per_cos2 = (half_along * half_along + half_across * half_across) * per_up2 + 1;
  return exponential(-(x * x + y * y) * per_up2) * per_cos2 * per_cos2 /
         (4 * std::numbers::pi_v<T> * facets.alpha_x * facets.alpha_y * facets.view_up * masked);
}

// How ln facets_show falls about a light, its masking left out. With x and y the slope of the half
// vector over alpha, it is -(x^2 + y^2) - 4 ln cos(h).
template <class T>
struct FacetsFall {
  Vec3<T> gradient;  // over the direction of the light
  Vec3<T> x, y;      // the gradients of x and y
};

template <class T>
FacetsFall<T> facets_fall(const Facets<T>& facets, Vec3<T> view, Vec3<T> light) {
  const Vec3<T> half = view + light;
  const T half_z = dot(half, facets.normal);
  const T x = dot(half, facets.along) / half_z, y = dot(half, facets.across) / half_z;
  FacetsFall<T> fall;
  fall.x = (facets.along - facets.normal * x) / (facets.alpha_x * half_z);
  fall.y = (facets.across - facets.normal * y) / (facets.alpha_y * half_z);
  fall.gradient = half * (4 / dot(half, half)) - facets.normal * (4 / half_z) -
                  fall.x * (2 * x / facets.alpha_x) - fall.y * (2 * y / facets.alpha_y);
  return fall;
}

// The second derivative along the unit tangent.
template <class T>
T bend_along(const FacetsFall<T>& fall, Vec3<T> tangent) {
  const T x = dot(fall.x, tangent), y = dot(fall.y, tangent);
  return -2 * (x * x + y * y);
}

// What f cos(theta') of one species has by the view alone.
template <class T>
struct FlakesSeen {
  Vec3<T> normal, tangent;  // of the surface; and what of the view lies along it
  T g;                      // eta cos(theta_p)
  T factor;                 // D H <S> (1 - r)/(8 pi g)
  Rgb<T> slant;             // optical depth towards the observer
};

template <class T>
FlakesSeen<T> flakes_seen(const Layer<T>& layer, const Flakes<T>& flakes, Vec3<T> normal,
                          Vec3<T> view, T cos_view, T g) {
  const T exit = layer.radiometry == Radiometry::published ? layer.eta * cos_view : g;
  return {normal, view - normal * cos_view, g,
          flakes.coverage * fresnel_transmittance(cos_view, g, layer.eta) /
              (8 * std::numbers::pi_v<T> * exit),
          slant_depth_of(layer, min(g / layer.eta, T(1)))};
}

// What is found in the lobe's middle and stands for all of it: the depth of the layer towards the
// light, and G, what both ways have in common.
template <class T>
struct MiddleOfLobe {
  Rgb<T> depth;  // at cos = 1
  Rgb<T> in_common;
};

template <class T>
MiddleOfLobe<T> middle_of_lobe(const Layer<T>& layer, const FlakesSeen<T>& seen, Vec3<T> light,
                               T cos_light) {
  const T g = eta_cos_refracted(cos_light, layer.eta);
  const T cos_in = min(g / layer.eta, T(1));
  const Rgb<T> slant = slant_depth_of(layer, cos_in);
  MiddleOfLobe<T> middle{slant * cos_in, {}};
  if (layer.depth_model == DepthModel::correlated) {
    const T apart = ways_apart(seen.normal, seen.tangent, T(0), seen.g, light, cos_light, g);
    middle.in_common = share_in_common(layer, both_ways(layer, seen.slant, slant, apart));
  }
  return middle;
}

// f cos(theta') (flake_brdf.h) for a light at this cosine.
template <class T>
Rgb<T> flakes_show(const Layer<T>& layer, const Flakes<T>& flakes, const FlakesSeen<T>& seen,
                   const MiddleOfLobe<T>& middle, Vec3<T> light, T cos_light) {
  const T g = eta_cos_refracted(cos_light, layer.eta);
  if (!(g > 0)) return {};
  const MirroringFlake<T> flake =
      mirroring_flake(seen.tangent + (light - seen.normal * cos_light), seen.g + g, layer.eta);
  Rgb<T> slant = seen.slant + middle.depth * (layer.eta / g);
  if (layer.depth_model == DepthModel::correlated) {
    slant = less_in_common(layer, slant, middle.in_common);
  }
  return coating_reflectance(flakes.coating, flake.cos_alpha) * mean_transmittance(slant) *
         (seen.factor * orientation_density(flakes.orientation, flake.sin2_half_beta) *
          fresnel_transmittance(cos_light, g, layer.eta) * cos_light / g);
}

// Facets whose normal has the slope towards the observer, who is so far along the surface and up.
template <class T>
Facets<T> facets_at(Vec3<T> normal, Vec3<T> towards, T slope, T x2, T y2, T sin_view, T cos_view) {
  const T cosine = 1 / sqrt(1 + slope * slope);
  Facets<T> facets;
  facets.normal = (normal + towards * slope) * cosine;
  facets.along = (towards - normal * slope) * cosine;
  facets.across = cross(normal, towards);
  facets.alpha_x = clamp(sqrt(x2), T(1e-3), T(1));
  facets.alpha_y = clamp(sqrt(y2), T(1e-3), T(1));
  facets.view_along = (sin_view - slope * cos_view) * cosine;
  facets.view_up = (cos_view + slope * sin_view) * cosine;
  facets.view_masked =
      1 + masking_lambda(masking_square(facets, facets.view_along, T(0), facets.view_up));
  return facets;
}

// The wide lobe's alpha^2 over that of both, the most of its share, and the most that its middle is
// aside, in alphas of the guess. Wider lobes or greater shares show more of GGX's flakes and pass f
// towards the horizon. None with an alpha^2 above kMostSquare, where two alphas are half the
// sphere.
inline constexpr double kWider = 2, kMostWide = 0.25, kMostAside = 0.4, kMostSquare = 0.5;
// Where the mirrored light stands at this cosine, opposite to the observer, the wide lobe shall
// have fallen to kAtHorizon of f in the middle: else it passes f there by up to 5 % of the middle,
// and no flake takes that back. So its alpha^2 is smaller in the plane of view, by this factor at
// most.
inline constexpr double kHorizon = 0.1, kAtHorizon = 0.01, kLeastAlong = 0.8;
// The factors of the guess are not the narrow lobe's: towards the horizon that shows more than it
// should beside the middle, and as it may not pass f, less everywhere. From this logarithm on it is
// fitted once more, at twice that wholly. Not without a wide lobe: then views within 18 degrees of
// the horizon would have lobes that pass f by 10 % of its light.
inline constexpr double kMostOff = 0.1;
// How far g may reach up to f in the middle, an alpha aside, and two. Chosen over random paints for
// the largest lobes that pass f by less than 1 % of its light in the median
// (tests/core/smooth_part_test.cpp).
inline constexpr double kHeight = 0.98, kHeightAside = 1.05, kHeightFar = 1.1;
// Lower where f is less like facets: of wide tilts, and with GGX's tail. As high, a lobe passes f
// there by several percent in some directions, and no flake takes that back: single lamps were up
// to 1.7 % of the flakes' light too bright, so lowered 0.8 %.
inline constexpr double kLower = 0.13, kLowerFrom = 0.15, kLowerRange = 0.1;
template <class T>
T lobe_height(const OrientationDensity<T>& density) {
  T wide = clamp((density.tilt - T(kLowerFrom)) / T(kLowerRange), T(0), T(1));
  if (density.kind == Orientation::ggx) wide = 1;
  return 1 - T(kLower) * wide;
}
// Nearer to the horizon f has no lobe that facets resemble: the least cosines of the view, and of
// the mirrored light an alpha aside. Of 2,400 random paints one lobe passed f by 4 % of its light
// at most, of others by 11 %; with 0.15 by up to 26 %.
inline constexpr double kLeastSmooth = 0.2, kLeastRise = 0.2;

// e, by f two alphas of the guess across the plane of view, at which r^2 = 4 fall, and by 1/A.
template <class T>
T share_of_wide(T far, T fall, T far_wide, T steep) {
  const T far_narrow = exponential(-4 * fall * steep);
  return clamp((far - far_narrow) / (far_wide - far_narrow), T(0), T(kMostWide));
}

// fall: -ln of f an alpha aside. Two steps from A = 1/1.2: e by f, A by e, e by f.
template <class T>
T wide_share(T far, T fall) {
  const T far_wide = exponential(-4 * fall / T(kWider));
  const T first = share_of_wide(far, fall, far_wide, T(1.2));
  const T near = T(0.367879441171442322L), near_wide = T(0.606530659712633424L);  // e^-1, e^-1/2
  return share_of_wide(far, fall, far_wide, -logarithm((near - first * near_wide) / (1 - first)));
}

template <class T>
SmoothPart<T> smooth_part(const Layer<T>& layer, const Flakes<T>& flakes, Vec3<T> normal,
                          Vec3<T> view) {
  const T cos_view = min(dot(normal, view), T(1));
  if (!(cos_view > T(kLeastSmooth)) || !(flakes.coverage > 0)) return {};
  const T g_view = eta_cos_refracted(cos_view, layer.eta);
  if (!(g_view > 0)) return {};
  const FlakesSeen<T> seen = flakes_seen(layer, flakes, normal, view, cos_view, g_view);

  // The first guess.
  const T sin_view = length(seen.tangent);
  Vec3<T> towards = seen.tangent;
  if (!(sin_view > T(1e-6))) {  // any direction does
    towards = abs(normal.x) < T(0.6) ? Vec3<T>{1, 0, 0} : Vec3<T>{0, 1, 0};
  }
  towards = towards - normal * dot(normal, towards);  // the tangent's rounding too
  towards = towards / length(towards);
  const T turned = g_view / cos_view;
  const T square = 2 * core_variance(flakes.orientation) * turned * turned;
  const T guessed_x2 = square / (1 + T(1.44) * square / (cos_view * cos_view));
  const T guessed_y2 = square / (1 + T(2.73) * square);
  const T slope = T(1.07) * guessed_x2 * sin_view / cos_view;
  const auto facets_of = [&](T by_slope, T x2, T y2) {
    return facets_at(normal, towards, by_slope, x2, y2, sin_view, cos_view);
  };
  const Facets<T> guess = facets_of(slope, guessed_x2, guessed_y2);

  // f in the middle, an alpha to each side and two to some; and over the guess's factors and over
  // itself in the middle.
  MiddleOfLobe<T> middle{};
  Vec3<T> light[6];
  Rgb<T> shown[6];
  T ratio[6];
  T per_middle = 1;
  bool is_far_seen = true;
  for (int i = 0; i < 6; ++i) {
    // Of the half vector in the guess's frame.
    const T x = i == 1   ? guess.alpha_x
                : i == 2 ? -guess.alpha_x
                : i == 4 ? 2 * guess.alpha_x
                         : T(0);
    const T y = i == 3 ? guess.alpha_y : i == 5 ? 2 * guess.alpha_y : T(0);
    const Vec3<T> half = guess.normal + guess.along * x + guess.across * y;
    const T steepness = 1 + x * x + y * y;  // 1 over the square of its cosine to the guess's normal
    const T twice = 2 * (guess.view_up + x * guess.view_along) / steepness;
    light[i] = half * twice - view;
    const T cos_light = min(dot(normal, light[i]), T(1));
    ratio[i] = 1;
    if (!(cos_light > T(kLeastRise))) {
      if (i < 4) return {};
      is_far_seen = false;
      continue;
    }
    if (i == 0) middle = middle_of_lobe(layer, seen, light[i], cos_light);
    shown[i] = flakes_show(layer, flakes, seen, middle, light[i], cos_light);
    const T masked =
        guess.view_masked + masking_lambda(masking_square(guess, x * twice - guess.view_along,
                                                          y * twice, twice - guess.view_up));
    const T whole = (shown[i].x + shown[i].y + shown[i].z) * masked / (steepness * steepness);
    if (i == 0) {
      if (!(whole > T(1e-30))) return {};
      per_middle = 1 / whole;
    } else {
      ratio[i] = clamp(whole * per_middle, T(1e-6), T(1e6));
    }
  }

  // The wide lobe.
  const T fall_x = clamp(T(-0.5) * logarithm(ratio[1] * ratio[2]), T(0.34), T(4));
  const T fall_y = clamp(-logarithm(ratio[3]), T(0.34), T(4));
  T wide_x2 = T(kWider) * (guess.alpha_x * guess.alpha_x) / fall_x;
  const T wide_y2 = T(kWider) * (guess.alpha_y * guess.alpha_y) / fall_y;
  T share = 0, aside = 0;
  if (is_far_seen && max(wide_x2, wide_y2) < T(kMostSquare)) {
    share = wide_share(ratio[5], fall_y);
    if (share > 0) {
      // That half vector's slope to the normal, away from the observer, and to the guess's.
      const T level = T(0.994987437106619954735L);  // sqrt(1 - kHorizon^2)
      const T from_normal = (level - sin_view) / (cos_view + T(kHorizon));
      const T horizon = (from_normal + slope) / (1 - from_normal * slope);
      const T fall = max(logarithm(share / T(kAtHorizon)), T(0.1));
      wide_x2 = max(min(wide_x2, horizon * horizon / fall), T(kLeastAlong) * wide_x2);
      const T lower = max(logarithm(share / ratio[4]), T(0));
      aside = clamp(2 * guess.alpha_x - sqrt(wide_x2 * lower), T(-kMostAside) * guess.alpha_x,
                    T(kMostAside) * guess.alpha_x);
    }
  }

  // The narrow lobe, of what that leaves.
  T left[4];
  for (int i = 0; i < 4; ++i) {
    T by_wide = 0;
    if (share > 0) {
      const T x = (i == 1 ? guess.alpha_x : i == 2 ? -guess.alpha_x : T(0)) - aside;
      const T y = i == 3 ? guess.alpha_y : T(0);
      by_wide = share * exponential(-(x * x / wide_x2 + y * y / wide_y2));
    }
    left[i] = max(clamp(ratio[i], T(2e-3), T(400)) - by_wide, T(1e-3));
  }
  T near = -logarithm(left[1] / left[0]), away = -logarithm(left[2] / left[0]);
  T side = -logarithm(left[3] / left[0]);
  SmoothPart<T> part;
  if (share > 0) part.wide = facets_of(slope + aside, wide_x2, wide_y2);
  T narrow_shows[6], wide_shows[6];
  const int points = share > 0 ? 6 : 4;
  for (int i = 0; i < points; ++i) {
    wide_shows[i] = share > 0 ? facets_show(part.wide, light[i]) : T(0);
  }
  for (int fit = 0; fit < 2; ++fit) {
    const T both = near + away;
    const T turn = clamp((away - near) / (2 * max(both, T(0.4))), T(-0.7), T(0.7));
    part.narrow = facets_of(max(slope + guess.alpha_x * turn, T(0)),
                            guess.alpha_x * guess.alpha_x / clamp(both / 2, T(0.34), T(6)),
                            guess.alpha_y * guess.alpha_y / clamp(side, T(0.34), T(6)));
    for (int i = 0; i < points; ++i) narrow_shows[i] = facets_show(part.narrow, light[i]);
    if (!(share > 0)) break;
    T off[4];
    for (int i = 0; i < 4; ++i) {
      const T wanted = (shown[i].x + shown[i].y + shown[i].z) * left[i] / ratio[i];
      off[i] = logarithm(max(narrow_shows[i], T(1e-30)) / max(wanted, T(1e-30)));
    }
    const T more = clamp((off[2] - off[0]) / T(kMostOff) - 1, T(0), T(1));
    if (!(more > 0)) break;
    near = near + more * (off[1] - off[0]);
    away = away + more * (off[2] - off[0]);
    side = side + more * (off[3] - off[0]);
  }

  // As high as f lets them be: first the wide lobe beside its share of the narrow one.
  const T highest = lobe_height(flakes.orientation);
  if (share > 0 && narrow_shows[0] > 0 && wide_shows[0] > 0) {
    const T unit_narrow = left[0] / narrow_shows[0], unit_wide = (1 - left[0]) / wide_shows[0];
    Rgb<T> most = grey(T(1e30));
    for (int i = 0; i < 6; ++i) {
      if (i > 0 && i < 4) continue;
      const T height = highest * (i == 0 ? T(kHeight) : T(kHeightFar)) * unit_wide /
                       (unit_narrow * narrow_shows[i] + unit_wide * wide_shows[i]);
      most = least(most, shown[i] * height);
    }
    part.wide.weight = most;
  }
  Rgb<T> most = grey(T(1e30));
  for (int i = 0; i < 4; ++i) {
    if (!(narrow_shows[i] > 0 && max_component(shown[i]) > 0)) continue;
    const T height = highest * (i == 0 ? T(kHeight) : T(kHeightAside));
    const Rgb<T> rest = shown[i] * height - part.wide.weight * wide_shows[i];
    most = least(most, map(rest, [&](T x) { return max(x, T(0)) / narrow_shows[i]; }));
  }
  if (most.x < T(1e30)) part.narrow.weight = most;
  return part;
}

// What both lobes show, by the weights that they have or are given.
template <class T>
Rgb<T> smooth_shows(const SmoothPart<T>& part, Vec3<T> light) {
  return part.narrow.weight * facets_show(part.narrow, light) +
         part.wide.weight * facets_show(part.wide, light);
}

// Listed lights shine on the lobes too. So what those show of a light is taken from its sparkles,
// as far as it sparkles there; of a wide light the mean over kOfEight: with four places flakes of
// GGX, tilted by 0.06, showed a lamp of half their reach 3 % too dark.
template <class T>
Rgb<T> smooth_sparkles(const Layer<T>& layer, const SmoothPart<T>* parts,
                       const SeenLight<T>& light) {
  std::array<Vec3<T>, 8> towards{Vec3<T>(light.direction)};
  std::array<T, 8> part{1};
  std::size_t points = 1;
  if (light.radius > 0) {
    points = 0;
    for (const long double radii : kOfEight) {
      const PointsWithin<T> within = points_within(light, radii, points > 0);
      for (std::size_t k = 0; k < 4; ++k) {
        towards[points] = Vec3<T>(within.towards[k]);
        part[points] = static_cast<T>(within.part[k]);
        ++points;
      }
    }
  }
  Rgb<T> sum{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(layer.species); ++i) {
    Rgb<T> shown{};
    T seen = 0;
    for (std::size_t k = 0; k < points; ++k) {
      seen = seen + part[k];
      shown = shown + smooth_shows(parts[i], towards[k]) * part[k];
    }
    const T share =
        sparkling_share(light.breadth, light.apart, turned_by(layer.flakes[i], layer.eta));
    sum = sum + shown * (share / seen);
  }
  return sum;
}

// Where a pixel has fewer sparkles than the lobes show, these lean away from the light, and are
// lowered by what they show of it still; where they show this share of what the diffuse lobe does
// (`diffuse`), a light shown twice is not seen.
inline constexpr double kShownTwice = 2e-3;

// What of the lobes may be shown beside these sparkles of one light.
template <class T>
Rgb<T> may_show(Rgb<T> lobes, Rgb<T> sparkles, Rgb<T> diffuse) {
  const auto share = [](T lobe, T sparkling, T around) {
    return min((sparkling + around * T(kShownTwice)) / max(lobe, T(1e-30)), T(1));
  };
  return {share(lobes.x, sparkles.x, diffuse.x), share(lobes.y, sparkles.y, diffuse.y),
          share(lobes.z, sparkles.z, diffuse.z)};
}

// How much less of the light, as a logarithm, the lobes are to show for their worst colour's sake.
// Little less is better got by lowering them: to lean takes more of the rest where the light is in
// their middle. More than the most lowers them besides.
inline constexpr double kLeastFall = 0.3, kMostFall = 10;

template <class T>
T fall_for(Rgb<T> may) {
  const T fall = -logarithm(clamp(min(may.x, min(may.y, may.z)), T(1e-6), T(1)));
  return fall < T(kLeastFall) ? T(0) : min(fall, T(kMostFall));
}

// Facets that show less of the light by exp(-fall). Of the slope of their half vectors, r over
// alpha, they have exp(-r^2); with the light at r = d in the direction s, these have of it
//   exp(-k (r . s + u)^2), k = fall/(d + u)^2:
// a Gaussian again, its middle aside by -u k/(1 + k) along s, and there narrower by sqrt(1 + k). It
// keeps exp(-u^2 k/(1 + k))/sqrt(1 + k) of the lobe's light: u = kLeanBack/(1 + d) keeps the most,
// to 0.02, of falls of 0.7 to 10. With a fall of 4 that is 0.2 at d = 0, half at d = 1, 0.8 at 3.
// The slopes are taken as if the normal did not lean, so the light is shown up to 1.2 times as much
// as wanted, and what masking hides ends elsewhere: of 5,200 lobes 95 % show up to 0.7 % of their
// light, one 7 %, where they showed less before.
inline constexpr double kLeanBack = 0.75;

template <class T>
Facets<T> lean_lobe(const Facets<T>& facets, Vec3<T> view, Vec3<T> light, T fall) {
  if (!(max_component(facets.weight) > 0 && facets.view_up > 0 && dot(light, facets.normal) > 0)) {
    return facets;
  }
  const Vec3<T> half = view + light;
  const T up = max(dot(half, facets.normal), T(1e-6));
  T x = dot(half, facets.along) / (up * facets.alpha_x);
  T y = dot(half, facets.across) / (up * facets.alpha_y);
  const T off = sqrt(x * x + y * y);
  const bool beside = off > T(1e-6);
  x = beside ? x / off : T(1);
  y = beside ? y / off : T(0);
  const T back = T(kLeanBack) / (1 + off);
  const T narrower = fall / ((off + back) * (off + back));
  const T aside = back * narrower / (1 + narrower);

  // The axes of 1/alpha^2, of which the greater's square root is `steep`.
  const T along2 = (1 + narrower * x * x) / (facets.alpha_x * facets.alpha_x);
  const T across2 = (1 + narrower * y * y) / (facets.alpha_y * facets.alpha_y);
  const T both = narrower * x * y / (facets.alpha_x * facets.alpha_y);
  const T apart = T(0.5) * (along2 - across2), radius = sqrt(apart * apart + both * both);
  const T steep = sqrt(T(0.5) * (along2 + across2) + radius), less = sqrt(1 + narrower);
  T axis_along = apart + radius, axis_across = both;
  if (apart < 0) {
    axis_along = both;
    axis_across = radius - apart;
  }
  if (!(radius > 0)) axis_along = 1;

  const Vec3<T> leaning = facets.normal - facets.along * (aside * x * facets.alpha_x) -
                          facets.across * (aside * y * facets.alpha_y);
  Facets<T> away;
  away.normal = leaning / length(leaning);
  const Vec3<T> axis = facets.along * axis_along + facets.across * axis_across;
  const Vec3<T> level = axis - away.normal * dot(axis, away.normal);
  away.along = level / length(level);
  away.across = cross(away.normal, away.along);
  away.alpha_x = clamp(1 / steep, T(1e-3), T(1));
  away.alpha_y = clamp(facets.alpha_x * facets.alpha_y * steep / less, T(1e-3), T(1));
  away.view_along = dot(view, away.along);
  away.view_across = dot(view, away.across);
  away.view_up = dot(view, away.normal);
  away.view_masked =
      1 + masking_lambda(masking_square(away, away.view_along, away.view_across, away.view_up));
  // By the masking of the view and 1/cos facets show more that are seen more obliquely: that is
  // taken back. Of what they show less, seen more steeply, flakes show the rest.
  const T seen = away.view_up * away.view_masked / (facets.view_up * facets.view_masked);
  away.narrowed = facets.narrowed / (1 + narrower);
  away.weight = facets.weight * (exponential(-aside * back) / less * clamp(seen, T(0), T(1)));
  return away;
}

template <class T>
SmoothPart<T> lean_away(const SmoothPart<T>& part, Vec3<T> view, Vec3<T> light, T fall) {
  return {lean_lobe(part.narrow, view, light, fall), lean_lobe(part.wide, view, light, fall)};
}

}  // namespace metallic_paint
