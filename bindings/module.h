// SPDX-License-Identifier: Apache-2.0
//
// One file per subject; the functions here are listed in the order of the data's way through the
// model.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

void bind_paint(pybind11::module_& module);
void bind_light(pybind11::module_& module);
void bind_evaluate(pybind11::module_& module);
void bind_shade(pybind11::module_& module);
void bind_functions(pybind11::module_& module);
void bind_explicit_flakes(pybind11::module_& module);
void bind_reference_walk(pybind11::module_& module);

// A contiguous array of T.
template <class T>
using Array = pybind11::array_t<T, pybind11::array::c_style | pybind11::array::forcecast>;

// What comes in from Python (input.cpp). All of these throw ValueError with a sentence that names
// the field, its value and what it must be.
[[noreturn]] void reject(const std::string& field, pybind11::handle value,
                         const std::string& range);
Array<double> numbers(const char* field, pybind11::handle value);
Array<std::int32_t> whole_numbers(const char* field, pybind11::handle value);
void require_shape(const char* field, const pybind11::array& array,
                   const std::vector<pybind11::ssize_t>& shape);
void require_one_dimension(const char* field, const pybind11::array& array);
void require_rows_of_3(const char* field, const pybind11::array& array);
void require_broadcast(const char* fields, const std::vector<pybind11::array>& arrays);

template <class T>
T from_python(const char* field, pybind11::handle value, const char* range) {
  // pybind11 would cut off the fraction of what is neither an int nor a float.
  if (std::is_integral_v<T> && PyIndex_Check(value.ptr()) == 0) reject(field, value, range);
  try {
    return value.cast<T>();
  } catch (const pybind11::cast_error&) {
    reject(field, value, range);
  }
}

inline constexpr const char* kInt32 = "a whole number from -2^31 to 2^31 - 1";
inline constexpr const char* kNumber = "a number";
inline constexpr const char* kThreeNumbers = "three numbers";
