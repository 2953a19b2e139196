// SPDX-License-Identifier: Apache-2.0
//
// One file per subject; the functions here are listed in the order of the data's way through the
// model.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <stop_token>
#include <string>
#include <type_traits>
#include <vector>

#include "layer.h"
#include "light.h"
#include "parameters.h"
#include "vector.h"

void bind_paint(pybind11::module_& module);
void bind_light(pybind11::module_& module);
void bind_evaluate(pybind11::module_& module);
void bind_shade(pybind11::module_& module);
void bind_functions(pybind11::module_& module);
void bind_explicit_flakes(pybind11::module_& module);
void bind_reference_walk(pybind11::module_& module);

// Calls work(stop) without the interpreter's lock, and stops it when a signal's handler raises, as
// that of Ctrl-C does: that exception comes out of here once no thread is left (interrupt.cpp).
// Work that is done before anyone could press a key is `brief`, and does without a thread of its
// own, which takes longer than a pixel.
void interruptible(const std::function<void(const std::stop_token&)>& work, bool brief = false);

// A contiguous array of T.
template <class T>
using Array = pybind11::array_t<T, pybind11::array::c_style | pybind11::array::forcecast>;

// What comes in from Python (input.cpp). Values are rejected by a ValueError, arguments of a wrong
// class by a TypeError, with a sentence that names the argument, what was given and what it must
// be.
inline constexpr const char* kInt32 = "a whole number from -2^31 to 2^31 - 1";
inline constexpr const char* kNumber = "a number";
inline constexpr const char* kThreeNumbers = "three numbers";

[[noreturn]] void reject(const std::string& field, pybind11::handle value,
                         const std::string& range);
[[noreturn]] void reject_type(const std::string& argument, pybind11::handle value,
                              const std::string& wanted);

// Numbers are booleans, whole numbers and floats of any precision and byte order, and Python's own
// kinds of number, as float64; nothing masked, nothing complex, no None and no texts.
double number(const std::string& field, pybind11::handle value, const char* range = kNumber);
metallic_paint::Vec3<double> three_numbers(const char* field, pybind11::handle value);
Array<double> numbers(const char* field, pybind11::handle value,
                      const char* range = "an array of numbers");
Array<std::int32_t> whole_numbers(const char* field, pybind11::handle value);

// Likewise, but floats in single precision stay as they are.
pybind11::array singles_or_doubles(const char* field, pybind11::handle value);

// a, b or c
std::string one_of(const auto& words) {
  std::string all = words.front();
  for (std::size_t i = 1; i < words.size(); ++i) {
    all += (i + 1 < words.size() ? ", " : " or ") + std::string(words[i]);
  }
  return all;
}

// The place among the names of the one that `value` is.
std::size_t choice(const char* field, pybind11::handle value,
                   std::initializer_list<const char*> names);

void require_shape(const char* field, const pybind11::array& array,
                   std::initializer_list<pybind11::ssize_t> shape);
void require_one_dimension(const char* field, const pybind11::array& array);
void require_rows_of_3(const char* field, const pybind11::array& array);
// In the shape to which all of them broadcast.
std::vector<Array<double>> broadcast(const char* fields, const std::vector<Array<double>>& arrays);

template <class T>
T from_python(const char* field, pybind11::handle value, const char* range) {
  if constexpr (std::is_same_v<T, double>) {
    return number(field, value, range);
  } else if constexpr (std::is_same_v<T, std::array<double, 3>>) {
    const metallic_paint::Vec3<double> v = three_numbers(field, value);
    return {v.x, v.y, v.z};
  } else {
    // pybind11 would cut off the fraction of what is neither an int nor a float.
    if (std::is_integral_v<T> && PyIndex_Check(value.ptr()) == 0) reject(field, value, range);
    try {
      return value.cast<T>();
    } catch (const pybind11::cast_error&) {
      reject(field, value, range);
    }
  }
}

// The object of the core behind an argument; it lives as long as Python's.
template <class Class>
const Class& object_of(const std::string& argument, pybind11::handle value) {
  pybind11::detail::make_caster<Class> caster;
  if (caster.load(value, false)) return caster;
  const auto name = pybind11::type::of<Class>().attr("__name__").template cast<std::string>();
  reject_type(argument, value, "a " + name);
}

// A paint that has passed validate(), and its layers in the shader's precision and in the
// reference's (paint.cpp).
struct PreparedPaint {
  metallic_paint::Paint paint;
  metallic_paint::Layer<float> as_float;
  metallic_paint::Layer<double> as_double;
};
std::shared_ptr<const PreparedPaint> prepared_paint(const metallic_paint::Paint& paint);

// At most kLightSlots objects Light (light.cpp).
std::vector<metallic_paint::Light<double>> lights_of(pybind11::handle value);
