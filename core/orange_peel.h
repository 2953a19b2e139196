// SPDX-License-Identifier: Apache-2.0
//
// Orange peel (ours): the waves that spraying leaves in the binder's surface. Their slope is Perlin
// noise of wavelength `size`; they bend the highlight, and the light on its ways to the flakes and
// back, by a third of their slope in the binder. Both ways pass the same wave, which is far longer
// than the layer is deep.
//
// A wave of the normal w sends a direction d of the outside into the binder by Snell's law about w:
//   eta d_p = d + w (g - c), c = d . w, g = eta cos in the binder.
// An even surface of the normal n would take another direction d* to the same d_p: its part along
// the surface is that of eta d_p, by Snell's law about n. So what lies under the surface is asked
// as through an even one, for d* in the place of d, and every law of it stands: radiance in the
// binder over eta^2 is the same outside. Of a lamp's solid angle the binder holds c/(eta g). What
// the surface lets through is left as much as an even one's: the light's that of d*, the view's
// that of d itself (`make_stack`), so nothing is gained or lost.
#pragma once

#include <algorithm>
#include <cmath>

#include "noise.h"
#include "refraction.h"
#include "vector.h"

namespace metallic_paint {

// Of each channel of perlin_noise, measured over 1e6 points.
inline constexpr double kPerlinDeviation = 0.26;
// The sine of how far above the horizon light leaves, unless the view is lower.
inline constexpr double kLeastHeight = 0.01;

// p, where the point lies in its own space, and `size` in m.
template <class T>
Vec3<T> waves_at(Vec3<T> p, T size) {
  return perlin_noise(p / size);
}

// The normal tilted by a slope whose root mean square is `slope`.
template <class T>
Vec3<T> orange_peel(Vec3<T> normal, Vec3<T> waves, T slope) {
  const Vec3<T> across = waves - normal * dot(normal, waves);
  const Vec3<T> tilted =
      normal + across * (slope / (T(1.41421356237309504880L) * T(kPerlinDeviation)));
  return tilted / length(tilted);
}

// The coat's normal turned so that a mirror's light stays above the surface: what a wave sends down
// meets another that sends it up again.
template <class T>
Vec3<T> above_surface(Vec3<T> coat_normal, Vec3<T> normal, Vec3<T> view) {
  const Vec3<T> mirrored = coat_normal * (2 * dot(coat_normal, view)) - view;
  const T height = dot(mirrored, normal);
  const T least = clamp(dot(normal, view), T(0), T(kLeastHeight));
  if (height >= least) return coat_normal;
  const Vec3<T> up = mirrored + normal * (max(-height, least) - height);
  const Vec3<T> half = view + up / length(up);
  return half / length(half);
}

// d*. What an even surface would mirror back into the binder lies at its horizon.
template <class T>
Vec3<T> through_wave(Vec3<T> d, Vec3<T> normal, Vec3<T> wave, T eta) {
  const T cosine = dot(wave, d);
  const Vec3<T> inside = d + wave * (eta_cos_refracted(cosine, eta) - cosine);
  Vec3<T> along = inside - normal * dot(normal, inside);
  const T least = clamp(dot(normal, d), T(0), T(kLeastHeight));
  const T square = dot(along, along), most = (1 - least) * (1 + least);
  if (square > most) along = along * sqrt(most / square);
  return along + normal * max(sqrt(max(1 - square, T(0))), least);
}

// The way back: d of d*, above the surface.
template <class T>
Vec3<T> back_through_wave(Vec3<T> d, Vec3<T> normal, Vec3<T> wave, T eta) {
  const T cosine = dot(normal, d);
  const Vec3<T> inside = d + normal * (eta_cos_refracted(cosine, eta) - cosine);
  Vec3<T> along = inside - wave * dot(wave, inside);
  const T square = dot(along, along);
  if (square > 1) along = along / sqrt(square);
  const Vec3<T> out = along + wave * sqrt(max(1 - square, T(0)));
  const T height = dot(normal, out), least = min(cosine, T(kLeastHeight));
  if (height >= least) return out;
  const Vec3<T> up = out + normal * (max(-height, least) - height);
  return up / length(up);
}

}  // namespace metallic_paint
