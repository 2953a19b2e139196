// SPDX-License-Identifier: Apache-2.0
//
// The coating of a flake: reflectance r_p(alpha) and transmittance t_p(alpha), RGB, at the angle
// alpha on the flake.
#pragma once

#include <algorithm>
#include <cstddef>

#include "choices.h"
#include "vector.h"

namespace metallic_paint {

// What a flake is made of. colors: Schlick's metal of the paint's own colours; the others have
// measured indices and stand in the library. The thickness in nm is that of the pearls' coating, on
// either face; a metal has none.
inline constexpr int kCoatingKinds = static_cast<int>(kCoatingKindWords.size());
inline constexpr double kMostCoatingNm = 200;

// tools/coatings/table.py --library: rows of kCoatingNodes colours over the angle; a row of
// reflectances for each metal, then kCoatingRows of them, 5 nm apart, for each pearl; at last the
// transmittances of Fe2O3 on mica and on silica likewise. Titania, mica and silica absorb nothing,
// so there t = 1 - r; nothing passes a metal. Four digits: the model's data, the same for every T.
// Between its rows and nodes a value errs by up to 0.05 at alpha below 45 degrees (metals 3e-4,
// pearls on mica 0.04), beyond by up to 0.25 on mica and 0.56 on silica, whose orders turn over
// quickly there (tests/python/test_coatings.py).
inline constexpr int kCoatingNodes = 13;
inline constexpr int kCoatingRows = 41;
inline constexpr double kCoatingLibrary[] = {
#include "coating_library.inc"
};
inline constexpr int kFirstPearl = static_cast<int>(CoatingKind::tio2_on_mica);
inline constexpr int kPearls = kCoatingKinds - kFirstPearl;
inline constexpr int kFirstIron = static_cast<int>(CoatingKind::fe2o3_on_mica);

// Whether flakes let light through, and how much depends on the angle.
inline bool is_clear(CoatingKind kind) {
  return static_cast<int>(kind) >= kFirstPearl && kind != CoatingKind::fe2o3_on_aluminium;
}

// Whether the film's colours turn over within the angles of one flake's lobe: silica is as thick as
// a wave, and even, where mica adds no colour.
inline bool is_on_silica(CoatingKind kind) {
  return kind == CoatingKind::tio2_on_silica || kind == CoatingKind::tio2_on_thin_silica ||
         kind == CoatingKind::fe2o3_on_silica;
}

// First row of a kind's reflectances.
inline int coating_row(int kind) {
  return kind < kFirstPearl ? kind - 1 : kFirstPearl - 1 + (kind - kFirstPearl) * kCoatingRows;
}

template <class T>
Rgb<T> coating_node(int at) {
  const double* rgb = kCoatingLibrary + at;
  return {static_cast<T>(rgb[0]), static_cast<T>(rgb[1]), static_cast<T>(rgb[2])};
}

// Bilinear in the thickness and in the cosine, whose nodes lie 1/24 apart where light reaches
// flakes through a surface (alpha <= 42 degrees for a binder of 1.5), and 1/6 below 2/3.
template <class T>
Rgb<T> interpolate_library(int first_row, T thickness_nm, T cosine) {
  const T row = clamp(thickness_nm, T(0), T(kMostCoatingNm)) * T(0.2);
  const int i = min(static_cast<int>(row), kCoatingRows - 2);
  const T v = row - static_cast<T>(i);
  const T c = clamp(cosine, T(0), T(1));
  const T node = max(6 * c, 24 * c - 12);
  const int j = min(static_cast<int>(node), kCoatingNodes - 2);
  const T w = node - static_cast<T>(j);
  const int at = 3 * ((first_row + i) * kCoatingNodes + j);
  const int below = at + 3 * kCoatingNodes;
  return (coating_node<T>(at) * (1 - w) + coating_node<T>(at + 3) * w) * (1 - v) +
         (coating_node<T>(below) * (1 - w) + coating_node<T>(below + 3) * w) * v;
}

// Of kind colors: Schlick's metal with a transmittance that does not depend on the angle; equal
// colours at normal and grazing incidence give a constant coating.
template <class T>
struct Coating {
  Rgb<T> normal_reflectance, grazing_reflectance, transmittance;
  CoatingKind kind = CoatingKind::colors;
  T thickness_nm = 0;
};

template <class T>
Rgb<T> coating_reflectance(const Coating<T>& coating, T cos_alpha) {
  const int kind = static_cast<int>(coating.kind);
  if (kind > 0) {
    // A metal's only row is met at 0 nm.
    const T thickness = kind < kFirstPearl ? T(0) : coating.thickness_nm;
    return interpolate_library(coating_row(kind), thickness, cos_alpha);
  }
  const T x = max(1 - cos_alpha, T(0));
  const T schlick = x * x * x * x * x;
  return coating.normal_reflectance +
         (coating.grazing_reflectance - coating.normal_reflectance) * schlick;
}

template <class T>
Rgb<T> coating_transmittance(const Coating<T>& coating, T cos_alpha) {
  const int kind = static_cast<int>(coating.kind);
  if (kind == 0) return coating.transmittance;
  if (!is_clear(coating.kind)) return {};
  const bool absorbing = kind >= kFirstIron;
  const int row = coating_row(kind) + (absorbing ? (kCoatingKinds - kFirstIron) * kCoatingRows : 0);
  const Rgb<T> value = interpolate_library(row, coating.thickness_nm, cos_alpha);
  return absorbing ? value : grey(T(1)) - value;
}

}  // namespace metallic_paint
