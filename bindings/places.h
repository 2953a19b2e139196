// SPDX-License-Identifier: Apache-2.0
//
// The arguments that say where a paint is looked at, alike in all functions over pixels.
#pragma once

#include <optional>

#include "batch.h"
#include "module.h"

struct Places {
  Array<double> position, normal, view, footprint;
  Array<std::int32_t> pixel;
  std::optional<Array<double>> own_position, own_axes;
  std::optional<Array<std::int32_t>> instance;

  // The last three may be None. Values are checked by validate(batch()).
  Places(pybind11::handle positions, pybind11::handle normals, pybind11::handle views,
         pybind11::handle footprints, pybind11::handle pixels, pybind11::handle own_positions,
         pybind11::handle axes, pybind11::handle instances)
      : position(numbers("position", positions)),
        normal(numbers("normal", normals)),
        view(numbers("view", views)),
        footprint(numbers("footprint", footprints)),
        pixel(whole_numbers("pixel", pixels)) {
    if (!own_positions.is_none()) own_position = numbers("own_position", own_positions);
    if (!axes.is_none()) own_axes = numbers("own_axes", axes);
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

  metallic_paint::PixelBatch batch(const double* slant = nullptr) const {
    return {static_cast<std::size_t>(size()),
            position.data(),
            normal.data(),
            view.data(),
            footprint.data(),
            pixel.data(),
            own_position ? own_position->data() : nullptr,
            own_axes ? own_axes->data() : nullptr,
            instance ? instance->data() : nullptr,
            slant};
  }
};
