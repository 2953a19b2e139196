// SPDX-License-Identifier: Apache-2.0
//
// A function that Python calls with its arguments as they lie. pybind11's own way makes a text of
// each keyword and copies all of them at each call, which takes longer than a pixel.
#pragma once

#include <pybind11/pybind11.h>

#include <array>
#include <cstddef>
#include <initializer_list>
#include <string>

// The arguments of a function: the first ones by position or keyword, the rest by keyword only. One
// whose value is not given has to be.
template <std::size_t kArguments>
class Signature {
 public:
  struct Argument {
    const char* name;
    pybind11::handle otherwise{};
  };

  Signature(const char* function, std::size_t by_position, const Argument (&arguments)[kArguments])
      : function_(function), by_position_(by_position) {
    for (std::size_t i = 0; i < kArguments; ++i) {
      // Python's own keywords are interned too: the same text is the same object.
      names_[i] = PyUnicode_InternFromString(arguments[i].name);
      if (!names_[i]) throw pybind11::error_already_set();
      otherwise_[i] = arguments[i].otherwise;
    }
  }

  // As vectorcall gives them, each to its place.
  std::array<pybind11::handle, kArguments> arrange(PyObject* const* given, Py_ssize_t by_position,
                                                   PyObject* keywords) const {
    std::array<pybind11::handle, kArguments> found{};
    const auto count = static_cast<std::size_t>(by_position);
    if (count > by_position_) {
      fail("takes " + std::to_string(by_position_) + " arguments by position, but " +
           std::to_string(count) + " were given");
    }
    for (std::size_t i = 0; i < count; ++i) found[i] = given[i];
    const Py_ssize_t named = keywords == nullptr ? 0 : PyTuple_GET_SIZE(keywords);
    for (Py_ssize_t i = 0; i < named; ++i) {
      PyObject* keyword = PyTuple_GET_ITEM(keywords, i);
      pybind11::handle& place = found[place_of(keyword)];
      if (place) fail("was given '" + text(keyword) + "' twice");
      place = given[by_position + i];
    }
    for (std::size_t i = 0; i < kArguments; ++i) {
      if (!found[i]) found[i] = otherwise_[i];
      if (!found[i]) fail("lacks the argument '" + text(names_[i].ptr()) + "'");
    }
    return found;
  }

 private:
  std::size_t place_of(PyObject* keyword) const {
    for (std::size_t i = 0; i < kArguments; ++i) {
      if (names_[i].ptr() == keyword) return i;
    }
    for (std::size_t i = 0; i < kArguments; ++i) {
      if (PyUnicode_Compare(names_[i].ptr(), keyword) == 0) return i;
    }
    fail("has no argument '" + text(keyword) + "'");
  }
  static std::string text(PyObject* name) { return pybind11::str(name).cast<std::string>(); }
  [[noreturn]] void fail(const std::string& what) const {
    throw pybind11::type_error(std::string(function_) + " " + what + ".");
  }

  const char* function_;
  std::size_t by_position_;
  std::array<pybind11::handle, kArguments> names_, otherwise_;  // live as long as the module
};

// What work() returns, to Python; what it throws, as pybind11 would raise it.
template <class Work>
PyObject* returned_or_raised(const Work& work) {
  try {
    return work().release().ptr();
  } catch (pybind11::error_already_set& error) {
    error.restore();
  } catch (...) {
    pybind11::detail::try_translate_exceptions();
  }
  return nullptr;
}
