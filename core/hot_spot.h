// SPDX-License-Identifier: Apache-2.0
//
// DepthModel::correlated (ours): what hides a flake from the observer often hides it from the light
// as well, which vegetation science calls the hot spot (Kuusk 1991). The paper, 5.3.3, takes the
// two ways for independent.
//
// Let discs of diameter D lie level in a layer of thickness H, their centres Poisson, c of them
// over each point. At the height h above a flake its two ways to the surface lie delta h apart,
//   delta = |tan(theta_p) - tan(theta'_p)|, the tangents as vectors in the plane.
// A disc that both ways meet hides once, not twice. Two discs of diameter D about points x apart
// share O(x/D) of their area, O(u) = (2/pi)(acos(u) - u sqrt(1 - u^2)). So from the depth z, a
// share of the layer, both ways are free with the probability
//   P(z) = exp(-x z + c z K(w z)),  K(y) = integral of O(y t) over t in [0, 1],  w = delta H/D,
// where x is the optical depth there and back. Tilted flakes have c = D H <S> <cos(beta)>, what
// either way meets where it meets no flake's back. A flake that transmits t is met twice by one
// ray: it shares (1 - t)^2. Of several species D is the mean over what they cover.
//
// Everything else takes an optical depth as before: the x' = x - c G(w, x) that leaves the same
// mean,
//   (1 - e^-x')/x' = integral of P(z) over z in [0, 1].
#pragma once

#include <algorithm>

#include "layer.h"
#include "optical_thickness.h"
#include "vector.h"

namespace metallic_paint {

// G(w, x), the share of c that counts, is 1 where both ways are one. It falls as 1 - 0.4 w for
// small w and x, as 0.42/(w <z>) for large w. Fitted to the integral: for c of 0.02 to 5, any w and
// x from 2 c to 2 c + 40 the mean is within 1.2 % (docs/fits.md).
template <class T>
T share_in_common(T w, T x) {
  const T y = w / (1 + T(0.0971) * x);
  return (1 + T(1.6392) * y) / (1 + y * (T(2.0389) + y * (T(1.8717) / (1 + T(0.1464) * x))));
}

// w of delta.
template <class T>
T flakes_apart(const Layer<T>& layer, T delta) {
  return min(delta * layer.thickness_in_flakes, T(1e9));
}

// x' of x and G. No more is shared than either way has: t_p at another angle may say otherwise.
template <class T>
Rgb<T> less_in_common(const Layer<T>& layer, Rgb<T> x, Rgb<T> share) {
  const Rgb<T> c = layer.shared_blocking;
  return x - Rgb<T>{min(c.x, x.x * T(0.5)), min(c.y, x.y * T(0.5)), min(c.z, x.z * T(0.5))} * share;
}

// The optical depth there and back of a light in the binder.
template <class T>
Rgb<T> there_and_back(const Layer<T>& layer, Rgb<T> view_slant, Rgb<T> light_slant, T delta) {
  const Rgb<T> x = view_slant + light_slant;
  if (layer.depth_model != DepthModel::correlated) return x;
  const T w = flakes_apart(layer, delta);
  return less_in_common(layer, x, map(x, [&](T depth) { return share_in_common(w, depth); }));
}

// delta of two unit vectors away from the surface, outside; g is eta times a cosine in the binder.
template <class T>
T ways_apart(Vec3<T> normal, Vec3<T> view, T cos_view, T g_view, Vec3<T> light, T cos_light,
             T g_light) {
  return length((view - normal * cos_view) / max(g_view, T(kLeastCosine)) -
                (light - normal * cos_light) / max(g_light, T(kLeastCosine)));
}

}  // namespace metallic_paint
