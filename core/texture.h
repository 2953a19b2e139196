// SPDX-License-Identifier: Apache-2.0
//
// Regular texture (paper, 5.1 and 5.2): the light scattered several times fluctuates from pixel to
// pixel as c sqrt(Sigma_0/Sigma), c its relative deviation over the reference area Sigma_0 = 1 mm2.
#pragma once

#include <algorithm>
#include <cmath>

#include "anchor.h"
#include "elementary.h"
#include "light.h"
#include "random.h"

namespace metallic_paint {

// Pixels finer than the grain see no more contrast: the relative deviation ends at 1. The mean is
// kept, not a bound: single pixels of a bright paint may send back more than they receive.
template <class T>
T texture_deviation(T contrast, T footprint) {
  return min(contrast * T(0.001) / sqrt(max(footprint, T(1e-20))), T(1));
}

// A positive factor of mean 1 and that relative deviation d, from a standard normal deviate w: the
// lognormal e^(s w - s^2/2), s^2 = ln(1 + d^2). The paper's normal one falls below 0.
template <class T>
T texture_factor(T contrast, T footprint, T w) {
  const T deviation = texture_deviation(contrast, footprint);
  const T square = logarithm(1 + deviation * deviation);
  return exponential(sqrt(square) * w - T(0.5) * square);
}

// The stream of its deviates; those of the flakes' mean lobe, kLightSlots, lie between it and the
// lights'.
inline constexpr int kTextureStream = kLightSlots + 1;

template <class T>
T texture_deviate(HashKey key) {
  return normal_quantile(static_cast<T>(uniform_deviate(key.x, key.y, key.z, 0)));
}

// The factor of a pixel.
template <class T>
T pixel_texture(T contrast, T footprint, int pixel_x, int pixel_y, int frame, int seed) {
  return texture_factor(contrast, footprint,
                        texture_deviate<T>(pixel_key(stream_key(kTextureStream, 0, frame, seed),
                                                     pixel_x, pixel_y, 0)));
}

// The factor of the point's pixel, or of its cell of the surface.
template <class T>
T texture_at(const Layer<T>& layer, const SurfacePoint<T>& point, T contrast, int frame, int seed) {
  if (layer.anchor == Anchor::pixel) {
    return pixel_texture(contrast, point.footprint, point.pixel_x, point.pixel_y, frame, seed);
  }
  const Cell<T> cell = find_cell(point, layer.cell_share, T(0),
                                 own_stream(layer, point.own, kTextureStream, frame, seed));
  return texture_factor(contrast, cell.area, texture_deviate<T>(cell.key));
}

}  // namespace metallic_paint
