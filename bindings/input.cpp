// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <algorithm>
#include <string_view>

#include "module.h"
#include "paint.h"
#include "validation.h"

namespace py = pybind11;

namespace {

std::string type_name(py::handle value) {
  return py::type::handle_of(value).attr("__name__").cast<std::string>();
}

std::string shape_of(const py::array& array) {
  return py::str(array.attr("shape")).cast<std::string>();
}

[[noreturn]] void reject_shape(const char* field, const py::array& array,
                               const std::string& shape) {
  throw py::value_error(std::string(field) + " has the shape " + shape_of(array) +
                        ", but must be " + shape + ".");
}

constexpr int kDeepestList = 64;  // numpy's arrays have no more dimensions; a list may hold itself

bool holds_masked(py::handle value, py::handle masked_array, int depth = 0) {
  if (py::isinstance(value, masked_array)) return true;
  const bool is_list = py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value);
  if (!is_list || depth == kDeepestList) return false;
  const auto list = py::reinterpret_borrow<py::sequence>(value);
  return std::any_of(list.begin(), list.end(), [&](py::handle inner) {
    return holds_masked(inner, masked_array, depth + 1);
  });
}

// numpy would take what lies behind a mask for numbers.
void reject_masked(const std::string& field, py::handle value) {
  if (!holds_masked(value, py::module_::import("numpy.ma").attr("MaskedArray"))) return;
  reject(field, value,
         "without a mask: numpy.ma.filled puts numbers in the place of what it hides");
}

// Whether it can be taken as it lies: numpy's own class, without a mask, and contiguous.
template <class T>
bool is_array_of(py::handle value) {
  const auto* own_class =
      reinterpret_cast<const PyTypeObject*>(py::detail::npy_api::get().PyArray_Type_);
  return Py_TYPE(value.ptr()) == own_class && Array<T>::check_(value);
}

// Booleans, whole numbers and floats; not complex numbers, texts or dates.
bool is_numeric(const py::dtype& type) {
  return std::string_view("biuf").find(type.kind()) != std::string_view::npos;
}

// Whether numpy's or a number's own error tells of the value, not of memory or an interruption.
bool is_about_value(const py::error_already_set& error) {
  return error.matches(PyExc_TypeError) || error.matches(PyExc_ValueError) ||
         error.matches(PyExc_OverflowError);
}

// float() of numpy's own numbers drops imaginary parts and reads texts.
bool is_odd_number_of_numpy(py::handle value) {
  const py::module_ numpy = py::module_::import("numpy");
  if (!py::isinstance(value, numpy.attr("generic")) && !py::isinstance<py::array>(value)) {
    return false;
  }
  const py::array array = numpy.attr("asarray")(value);
  return array.ndim() > 0 || !is_numeric(array.dtype());
}

// The core names an element by its row; a single number has none but the first.
py::ssize_t elements_of_row(const py::array& array) {
  return array.ndim() > 1 && array.size() > 0 ? array.size() / array.shape(0) : 1;
}

std::vector<py::ssize_t> dimensions(const py::array& array) {
  return {array.shape(), array.shape() + array.ndim()};
}

// Element by element: numpy would make nan of None and read the numbers that texts spell.
Array<double> numbers_of_objects(const char* field, const py::array& objects) {
  Array<double> all(dimensions(objects));
  const py::ssize_t row_size = elements_of_row(objects);
  py::ssize_t i = 0;
  for (const py::handle object : objects.attr("flat")) {
    const auto row = static_cast<std::size_t>(i / row_size);
    all.mutable_data()[i++] =
        number(metallic_paint::at_row(field, row), object, "a number up to 1.8e308");
  }
  return all;
}

}  // namespace

void reject(const std::string& field, py::handle value, const std::string& range) {
  std::string brief;
  try {
    brief = py::module_::import("reprlib").attr("repr")(value).cast<std::string>();
  } catch (const py::error_already_set&) {  // Python writes no whole number of 4301 digits
    brief = "of the type " + type_name(value);
  }
  throw py::value_error(field + " is " + brief + ", but must be " + range + ".");
}

double number(const std::string& field, py::handle value, const char* range) {
  if (PyFloat_Check(value.ptr()) != 0) return PyFloat_AS_DOUBLE(value.ptr());
  reject_masked(field, value);
  if (is_odd_number_of_numpy(value)) reject(field, value, range);
  const double given = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred() == nullptr) return given;
  const py::error_already_set error;
  if (is_about_value(error)) reject(field, value, range);
  throw error;
}

Array<double> numbers(const char* field, py::handle value, const char* range) {
  if (is_array_of<double>(value)) return py::reinterpret_borrow<Array<double>>(value);
  reject_masked(field, value);
  try {
    const py::array array(py::reinterpret_borrow<py::object>(value));
    if (is_numeric(array.dtype())) return Array<double>(array);
    if (array.dtype().kind() == 'O') {
      if (array.ndim() > 0) return numbers_of_objects(field, array);
      Array<double> one(std::vector<py::ssize_t>{});
      *one.mutable_data() = number(field, value, range);
      return one;
    }
  } catch (const py::error_already_set& error) {
    if (!is_about_value(error)) throw;
  }
  reject(field, value, range);
}

metallic_paint::Vec3<double> three_numbers(const char* field, py::handle value) {
  const Array<double> v = numbers(field, value, kThreeNumbers);
  if (v.ndim() != 1 || v.size() != 3) reject(field, value, kThreeNumbers);
  return {v.at(0), v.at(1), v.at(2)};
}

py::array singles_or_doubles(const char* field, py::handle value) {
  if (is_array_of<float>(value)) return py::reinterpret_borrow<py::array>(value);
  return numbers(field, value);
}

Array<std::int32_t> whole_numbers(const char* field, py::handle value) {
  if (is_array_of<std::int32_t>(value)) return py::reinterpret_borrow<Array<std::int32_t>>(value);
  const Array<double> given = numbers(field, value);
  Array<std::int32_t> whole(dimensions(given));
  const py::ssize_t row_size = elements_of_row(given);
  std::int32_t* out = whole.mutable_data();
  for (py::ssize_t i = 0; i < given.size(); ++i) {
    const double element = given.data()[i];
    metallic_paint::validate_int32(field, static_cast<std::size_t>(i / row_size), element);
    out[i] = static_cast<std::int32_t>(element);
  }
  return whole;
}

std::size_t choice(const char* field, py::handle value, std::initializer_list<const char*> names) {
  std::string all;
  for (const auto* name = names.begin(); name != names.end(); ++name) {
    if (PyUnicode_Check(value.ptr()) != 0 &&
        PyUnicode_CompareWithASCIIString(value.ptr(), *name) == 0) {
      return static_cast<std::size_t>(name - names.begin());
    }
    all += (name == names.begin() ? "'" : name + 1 < names.end() ? "', '" : "' or '");
    all += *name;
  }
  reject(field, value, all + "'");
}

void require_shape(const char* field, const py::array& array,
                   std::initializer_list<py::ssize_t> shape) {
  if (std::equal(shape.begin(), shape.end(), array.shape(), array.shape() + array.ndim())) return;
  const std::vector<py::ssize_t> all = shape;
  reject_shape(field, array, py::str(py::tuple(py::cast(all))).cast<std::string>());
}

void require_one_dimension(const char* field, const py::array& array) {
  if (array.ndim() != 1) reject_shape(field, array, "one-dimensional, (n,)");
}

void require_rows_of_3(const char* field, const py::array& array) {
  if (array.ndim() != 2 || array.shape(1) != 3) reject_shape(field, array, "(n, 3)");
}

std::vector<Array<double>> broadcast(const char* fields, const std::vector<Array<double>>& arrays) {
  py::list given, shapes;
  for (const Array<double>& array : arrays) {
    given.append(array);
    shapes.append(array.attr("shape"));
  }
  py::object views;
  try {
    views = py::module_::import("numpy").attr("broadcast_arrays")(*given);
  } catch (const py::error_already_set& error) {
    if (!is_about_value(error)) throw;
    throw py::value_error(std::string(fields) + " have the shapes " +
                          py::str(shapes).cast<std::string>() + ", but must fit one another");
  }
  std::vector<Array<double>> contiguous;
  for (const py::handle view : views) {
    contiguous.emplace_back(py::reinterpret_borrow<py::object>(view));
  }
  return contiguous;
}

void reject_type(const std::string& argument, py::handle value, const std::string& wanted) {
  throw py::type_error(argument + " is of the type " + type_name(value) + ", but must be " +
                       wanted + ".");
}
