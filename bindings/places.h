// SPDX-License-Identifier: Apache-2.0
//
// The arguments that say where a paint is looked at, alike in all functions over pixels.
#pragma once

#include <optional>

#include "batch.h"
#include "module.h"

inline metallic_paint::Column column_of(const pybind11::array& singles_or_doubles) {
  if (singles_or_doubles.itemsize() == sizeof(float)) {
    return static_cast<const float*>(singles_or_doubles.data());
  }
  return static_cast<const double*>(singles_or_doubles.data());
}

inline metallic_paint::Column column_of(const std::optional<pybind11::array>& array) {
  return array ? column_of(*array) : metallic_paint::Column();
}

struct Places {
  pybind11::array position, normal, view, footprint;
  Array<std::int32_t> pixel;
  std::optional<pybind11::array> own_position, own_axes;
  std::optional<Array<std::int32_t>> instance;

  // The last three may be None. Values are checked by validate(batch()).
  Places(pybind11::handle positions, pybind11::handle normals, pybind11::handle views,
         pybind11::handle footprints, pybind11::handle pixels, pybind11::handle own_positions,
         pybind11::handle axes, pybind11::handle instances)
      : position(singles_or_doubles("position", positions)),
        normal(singles_or_doubles("normal", normals)),
        view(singles_or_doubles("view", views)),
        footprint(singles_or_doubles("footprint", footprints)),
        pixel(whole_numbers("pixel", pixels)) {
    if (!own_positions.is_none()) own_position = singles_or_doubles("own_position", own_positions);
    if (!axes.is_none()) own_axes = singles_or_doubles("own_axes", axes);
    if (!instances.is_none()) instance = whole_numbers("instance", instances);
    require_one_dimension("footprint", footprint);
    const pybind11::ssize_t n = size();
    require_shape("position", position, {n, 3});
    require_shape("normal", normal, {n, 3});
    require_shape("view", view, {n, 3});
    require_shape("pixel", pixel, {n, 2});
    if (own_position) require_shape("own_position", *own_position, {n, 3});
    if (own_axes) require_shape("own_axes", *own_axes, {n, 3, 3});
    if (instance) require_shape("instance", *instance, {n});
  }

  pybind11::ssize_t size() const { return footprint.shape(0); }

  metallic_paint::PixelBatch batch(metallic_paint::Column slant = {}) const {
    return {static_cast<std::size_t>(size()),
            column_of(position),
            column_of(normal),
            column_of(view),
            column_of(footprint),
            pixel.data(),
            column_of(own_position),
            column_of(own_axes),
            instance ? instance->data() : nullptr,
            slant};
  }
};
