// SPDX-License-Identifier: Apache-2.0
//
// One file per subject; the functions here are listed in the order of the data's way through the
// model.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

void bind_paint(pybind11::module_& module);
void bind_light(pybind11::module_& module);
void bind_evaluate(pybind11::module_& module);
void bind_functions(pybind11::module_& module);

// Any array-like of numbers, seen as a contiguous array of T.
template <class T>
using Array = pybind11::array_t<T, pybind11::array::c_style | pybind11::array::forcecast>;
