// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <string_view>

#include "module.h"
#include "paint.h"

namespace py = pybind11;

namespace {

std::string shape_of(const py::array& array) {
  return py::str(array.attr("shape")).cast<std::string>();
}

[[noreturn]] void reject_shape(const char* field, const py::array& array,
                               const std::string& shape) {
  throw py::value_error(std::string(field) + " has the shape " + shape_of(array) +
                        ", but must be " + shape + ".");
}

}  // namespace

void reject(const std::string& field, py::handle value, const std::string& range) {
  const py::object brief = py::module_::import("reprlib").attr("repr")(value);
  throw py::value_error(field + " is " + brief.cast<std::string>() + ", but must be " + range +
                        ".");
}

Array<double> numbers(const char* field, py::handle value) {
  const py::array array = py::array::ensure(value);
  // bool, int, unsigned, float, and Python's own numbers: no complex ones, no texts.
  if (array && std::string_view("biufO").find(array.dtype().kind()) != std::string_view::npos) {
    if (const auto converted = Array<double>::ensure(array)) return converted;
  }
  reject(field, value, "an array of numbers");
}

Array<std::int32_t> whole_numbers(const char* field, py::handle value) {
  const Array<double> given = numbers(field, value);
  Array<std::int32_t> whole(std::vector<py::ssize_t>(given.shape(), given.shape() + given.ndim()));
  const py::ssize_t row_size =
      given.ndim() > 1 && given.size() > 0 ? given.size() / given.shape(0) : 1;
  std::int32_t* out = whole.mutable_data();
  for (py::ssize_t i = 0; i < given.size(); ++i) {
    const double number = given.data()[i];
    metallic_paint::validate_int32(field, static_cast<std::size_t>(i / row_size), number);
    out[i] = static_cast<std::int32_t>(number);
  }
  return whole;
}

void require_shape(const char* field, const py::array& array,
                   const std::vector<py::ssize_t>& shape) {
  if (std::vector<py::ssize_t>(array.shape(), array.shape() + array.ndim()) == shape) return;
  reject_shape(field, array, py::str(py::tuple(py::cast(shape))).cast<std::string>());
}

void require_one_dimension(const char* field, const py::array& array) {
  if (array.ndim() != 1) reject_shape(field, array, "one-dimensional, (n,)");
}

void require_rows_of_3(const char* field, const py::array& array) {
  if (array.ndim() != 2 || array.shape(1) != 3) reject_shape(field, array, "(n, 3)");
}

void require_broadcast(const char* fields, const std::vector<py::array>& arrays) {
  py::list shapes;
  for (const py::array& array : arrays) shapes.append(array.attr("shape"));
  try {
    py::module_::import("numpy").attr("broadcast_shapes")(*shapes);
  } catch (const py::error_already_set&) {
    throw py::value_error(std::string(fields) + " have the shapes " +
                          py::str(shapes).cast<std::string>() + ", but must fit one another");
  }
}
