// SPDX-License-Identifier: Apache-2.0
//
// A light's sparkles as light that a renderer can gather (ours): a cone of directions about the
// mirror of the view, of half-angle rho, that shows the radiance T E_n under a light of normal
// irradiance E_n anywhere in it. The cone holds its light and no other; it is the renderer that
// lights, colours and shadows.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace metallic_paint {

// Cycles drops closures whose weight averages below 1e-5: cones are widened to stay above.
inline constexpr double kLeastWeight = 1.1e-5;
// Wide enough for a renderer's own angles; narrower where the light's T is so great that the cone
// would show more of a white world than a mirror does.
inline constexpr double kNarrowCone = 0.02;
// Wider cones would keep dimmer sparkles, but a cone also reflects what else lies in it: of a world
// of radiance 1, 5e-4 of the sparkles of a sun of 3 W/m2 on average (measured), more in dim pixels.
inline constexpr double kWidestCone = 0.5;

// Half-angle for a T of that average: wide enough for twice the least weight, within the bounds. In
// Blender asin is an approximation.
template <class T>
T cone_half_angle(T average, T least, T most) {
  constexpr T pi = std::numbers::pi_v<T>;
  const T share = 2 * T(kLeastWeight) / (4 * pi * max(average, T(1e-30)));
  const T wanted = 2 * std::asin(sqrt(min(share, T(0.5))));
  const T mirror = 2 * std::asin(sqrt(1 / (4 * pi * max(average, T(1)))));
  const T rho = clamp(max(wanted, min(T(kNarrowCone), mirror)), least, max(most, least));
  return min(rho, max(T(kWidestCone), least));
}

template <class T>
T cone_solid_angle(T rho) {
  const T s = std::sin(T(0.5) * rho);
  return 4 * std::numbers::pi_v<T> * s * s;
}

// Where even the widest cone stays below the least weight, the closure is kept with this
// probability, at the least weight, so that the mean stands; 1 or more where it is kept for sure.
template <class T>
T cone_roulette(T average, T solid_angle) {
  return average * solid_angle / T(kLeastWeight);
}

}  // namespace metallic_paint
