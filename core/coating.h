// SPDX-License-Identifier: Apache-2.0
//
// The coating of a flake: reflectance r_p(alpha) and transmittance t_p(alpha), RGB, at the angle
// alpha on the flake.
#pragma once

#include <algorithm>
#include <vector>

#include "vector.h"

namespace metallic_paint {

// Values at cos(alpha) = 0, 1/(n-1), ..., 1, interpolated linearly.
template <class T>
struct CoatingTable {
  std::vector<Rgb<T>> reflectance, transmittance;
};

template <class T>
Rgb<T> interpolate(const std::vector<Rgb<T>>& values, T cosine) {
  const T position = std::clamp(cosine, T(0), T(1)) * static_cast<T>(values.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(position), values.size() - 2);
  const T f = position - static_cast<T>(i);
  return values[i] * (1 - f) + values[i + 1] * f;
}

// Schlick's metal with a transmittance that does not depend on the angle; equal colours at normal
// and grazing incidence give a constant coating. A table, where there is one, replaces them (core
// only).
template <class T>
struct Coating {
  Rgb<T> normal_reflectance, grazing_reflectance, transmittance;
  const CoatingTable<T>* table = nullptr;
};

template <class T>
Rgb<T> coating_reflectance(const Coating<T>& coating, T cos_alpha) {
  if (coating.table != nullptr) return interpolate(coating.table->reflectance, cos_alpha);
  const T x = std::max(1 - cos_alpha, T(0));
  const T schlick = x * x * x * x * x;
  return coating.normal_reflectance +
         (coating.grazing_reflectance - coating.normal_reflectance) * schlick;
}

template <class T>
Rgb<T> coating_transmittance(const Coating<T>& coating, T cos_alpha) {
  if (coating.table != nullptr) return interpolate(coating.table->transmittance, cos_alpha);
  return coating.transmittance;
}

}  // namespace metallic_paint
