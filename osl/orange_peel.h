// SPDX-License-Identifier: Apache-2.0
//
// Orange peel: the waves that spraying leaves in the binder's surface. Their slope is Perlin noise of wavelength `size`. What
// they bend, and how, is derived in core/orange_peel.h.
#pragma once

#include "refraction.h"

// Of each channel of noise("perlin"). It is 0.982 times the sum over the 8 corners of a cell of f(x) f(y) f(z) g.d, with
// f(t) = 1 - 6 t^5 + 15 t^4 - 10 t^3, d the way from the corner and g random, each of its components of mean square 2/3. So the
// variance is 0.982^2 16 A^2 B, A and B the integrals of f^2 and of t^2 f^2 over [0, 1], 0.39177 and 0.029693: 0.2652^2. The
// slope shown is 2 % more than asked for.
#define PERLIN_DEVIATION 0.26
#define LEAST_HEIGHT 0.01  // the sine of how far above the horizon light leaves, unless the view is lower

// p, where the point lies in its own space, and `size` in m.
vector waves_at(point p, float size)
{
  return noise("perlin", p / size);
}

// The normal tilted by a slope whose root mean square is `slope`.
vector orange_peel(vector n, vector waves, float slope)
{
  vector across = waves - n * inner_product(n, waves);
  vector tilted = n + across * (slope / (1.41421356 * PERLIN_DEVIATION));
  return tilted / sqrt(inner_product(tilted, tilted));
}

// The coat's normal turned so that a mirror's light stays above the surface: what a wave sends down meets another that sends
// it up again.
vector above_surface(vector coat_n, vector n, vector view)
{
  vector mirrored = coat_n * (2.0 * inner_product(coat_n, view)) - view;
  float height = inner_product(mirrored, n);
  float least = clamp(inner_product(n, view), 0.0, LEAST_HEIGHT);
  if (height >= least)
    return coat_n;
  vector up = mirrored + n * (max(-height, least) - height);
  vector half = view + up / sqrt(inner_product(up, up));
  return half / sqrt(inner_product(half, half));
}

// d*. What an even surface would mirror back into the binder lies at its horizon.
vector through_wave(vector d, vector n, vector wave, float eta)
{
  float cosine = inner_product(wave, d);
  vector inside = d + wave * (eta_cos_refracted(cosine, eta) - cosine);
  vector along = inside - n * inner_product(n, inside);
  float least = clamp(inner_product(n, d), 0.0, LEAST_HEIGHT);
  float square = inner_product(along, along);
  float most = (1.0 - least) * (1.0 + least);
  if (square > most)
    along = along * sqrt(most / square);
  return along + n * max(sqrt(max(1.0 - square, 0.0)), least);
}

// The way back: d of d*, above the surface.
vector back_through_wave(vector d, vector n, vector wave, float eta)
{
  float cosine = inner_product(n, d);
  vector inside = d + n * (eta_cos_refracted(cosine, eta) - cosine);
  vector along = inside - wave * inner_product(wave, inside);
  float square = inner_product(along, along);
  if (square > 1.0)
    along = along / sqrt(square);
  vector out = along + wave * sqrt(max(1.0 - square, 0.0));
  float height = inner_product(n, out);
  float least = min(cosine, LEAST_HEIGHT);
  if (height >= least)
    return out;
  vector up = out + n * (max(-height, least) - height);
  return up / sqrt(inner_product(up, up));
}
