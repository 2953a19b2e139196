// SPDX-License-Identifier: Apache-2.0
#include "paint.h"

#include <pybind11/native_enum.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <type_traits>

#include "module.h"
#include "validation.h"

namespace py = pybind11;
using metallic_paint::FlakeSpecies;
using metallic_paint::Paint;
using metallic_paint::Range;
using metallic_paint::Rgb;

namespace {

std::string between(const Range& range) {
  return " from " + metallic_paint::text(range.least) + " to " + metallic_paint::text(range.most) +
         range.unit;
}

// What a field takes beyond the range, which validate() holds it to: how it goes in and out, and
// what else it would have to be.
template <class Value>
struct Field;

template <>
struct Field<double> {
  static std::string must_be(const Range& range) { return "a number" + between(range); }
  static double to_python(double value) { return value; }
  static double from(const char* name, py::handle value, const std::string& must, const Range&) {
    if (PyBool_Check(value.ptr())) reject(name, value, must);
    return from_python<double>(name, value, must.c_str());
  }
};

template <>
struct Field<int> {
  static std::string must_be(const Range&) { return kInt32; }
  static int to_python(int value) { return value; }
  static int from(const char* name, py::handle value, const std::string& must, const Range&) {
    if (PyBool_Check(value.ptr())) reject(name, value, must);
    return from_python<int>(name, value, must.c_str());
  }
};

template <>
struct Field<Rgb<double>> {
  static std::string must_be(const Range& range) { return "three numbers" + between(range); }
  static py::tuple to_python(const Rgb<double>& c) { return py::make_tuple(c.x, c.y, c.z); }
  static Rgb<double> from(const char* name, py::handle value, const std::string& must,
                          const Range&) {
    const auto channels = from_python<std::array<py::object, 3>>(name, value, must.c_str());
    std::array<double, 3> v{};
    for (std::size_t i = 0; i < 3; ++i) {
      try {
        if (PyBool_Check(channels[i].ptr())) reject(name, value, must);
        v[i] = number(name, channels[i], must.c_str());
      } catch (const py::value_error&) {  // shows all three
        reject(name, value, must);
      }
    }
    return {v[0], v[1], v[2]};
  }
};

// A choice is given by its enumerator, its word or its number.
template <class Choice>
  requires std::is_enum_v<Choice>
struct Field<Choice> {
  static std::string must_be(const auto& words) { return one_of(words); }
  static Choice to_python(Choice value) { return value; }
  static Choice from(const char* name, py::handle value, const std::string& must,
                     const auto& words) {
    if (py::isinstance<py::str>(value)) {
      const auto found = std::find(words.begin(), words.end(), value.cast<std::string>());
      if (found == words.end()) reject(name, value, must);
      return static_cast<Choice>(found - words.begin());
    }
    try {
      return value.cast<Choice>();
    } catch (const py::cast_error&) {
    }
    // Other choices are whole numbers too.
    const py::object any_choice = py::module_::import("enum").attr("Enum");
    if (PyBool_Check(value.ptr()) || py::isinstance(value, any_choice)) reject(name, value, must);
    const int number = from_python<int>(name, value, must.c_str());
    if (number < 0 || number >= static_cast<int>(words.size())) reject(name, value, must);
    return static_cast<Choice>(number);
  }
};

// Of a visitor of the parameters of C: gives the class a property for each.
template <class C, class Class>
auto properties_of(Class& cls) {
  return [&cls](const char* name, auto member, const auto& range) {
    using Value = std::remove_cvref_t<decltype(std::declval<C>().*member)>;
    cls.def_property(
        name, [member](const C& c) { return Field<Value>::to_python(c.*member); },
        [name, member, range, must = Field<Value>::must_be(range)](C& c, py::handle value) {
          c.*member = Field<Value>::from(name, value, must, range);
        });
  };
}

template <class C>
bool is_field(py::handle name) {
  const py::object attribute = py::getattr(py::type::of<C>(), name, py::none());
  return PyObject_TypeCheck(attribute.ptr(), &PyProperty_Type) != 0;
}

// An object of that class with these fields.
template <class C>
C from_keywords(const py::kwargs& fields) {
  py::object self = py::cast(C{});
  const py::object type = py::type::of<C>();
  for (const auto& [name, value] : fields) {
    if (!is_field<C>(name)) {
      throw py::type_error(py::cast<std::string>(type.attr("__name__")) + " has no field " +
                           py::cast<std::string>(name));
    }
    self.attr(name) = value;
  }
  return self.cast<C>();
}

// Equal is what has the same fields; copies and pickles hold all of them by name.
template <class C>
void bind_as_value(auto& cls) {
  cls.def("__eq__", [](const C& one, py::handle other) {
    // A paint is more than its first species.
    const bool comparable =
        py::isinstance<C>(other) && py::isinstance<Paint>(other) == std::is_same_v<C, Paint>;
    if (!comparable) return py::reinterpret_borrow<py::object>(Py_NotImplemented);
    return py::object(py::bool_(one == other.cast<const C&>()));
  });
  const auto fields_of = [](const py::object& self) {
    py::dict fields;
    for (const py::handle name : py::module_::import("builtins").attr("dir")(py::type::of<C>())) {
      if (is_field<C>(name)) fields[name] = self.attr(name);
    }
    return fields;
  };
  cls.def(py::pickle(fields_of, [](const py::dict& fields) {
    return from_keywords<C>(py::reinterpret_borrow<py::kwargs>(fields));
  }));
}

}  // namespace

// The interpreter's lock guards the one that was prepared last: call after call mostly has the
// same.
std::shared_ptr<const PreparedPaint> prepared_paint(const Paint& paint) {
  static std::shared_ptr<const PreparedPaint> last;
  if (last == nullptr || !(last->paint == paint)) {
    metallic_paint::validate(paint);
    last = std::make_shared<const PreparedPaint>(
        PreparedPaint{paint, metallic_paint::make_layer<float>(paint),
                      metallic_paint::make_layer<double>(paint)});
  }
  return last;
}

void bind_paint(py::module_& module) {
  metallic_paint::each_choice(
      [&module](const char* name, auto choice, const auto& words, const char* explanation) {
        using Choice = decltype(choice);
        py::native_enum<Choice> type(module, name, "enum.IntEnum", explanation);
        for (std::size_t i = 0; i < words.size(); ++i) {
          std::string word = words[i];
          std::replace(word.begin(), word.end(), '-', '_');
          type.value(word.c_str(), static_cast<Choice>(i));
        }
        type.finalize();
      });

  py::class_<FlakeSpecies> species(
      module, "FlakeSpecies",
      R"doc(One species of flakes, in real units: see struct FlakeSpecies in core/parameters.h.

The fields are checked when a Paint is. A choice takes its word, too.)doc");
  species.def(py::init(&from_keywords<FlakeSpecies>));
  metallic_paint::each_flake_parameter(properties_of<FlakeSpecies>(species));
  bind_as_value<FlakeSpecies>(species);

  py::class_<Paint, FlakeSpecies> paint(
      module, "Paint",
      R"doc(A paint in real units, with the shader's defaults. See struct Paint in core/parameters.h.

Its own flakes are the first species; more holds the two others. Fields given as keywords are
checked on construction, all fields again on use.)doc");
  paint
      .def(py::init([](const py::kwargs& fields) {
        const Paint complete = from_keywords<Paint>(fields);
        metallic_paint::validate(complete);
        return complete;
      }))
      .def(
          "validate", [](const Paint& p) { metallic_paint::validate(p); },
          R"doc(Raises ValueError where a field is out of its range.)doc");
  metallic_paint::each_paint_parameter(properties_of<Paint>(paint));
  properties_of<Paint>(paint)("frame", &Paint::frame, Range{});
  paint.def_property(
      "more", [](const Paint& p) { return p.more; },
      [](Paint& p, py::handle value) {
        p.more = from_python<decltype(p.more)>("more", value, "two FlakeSpecies");
      });
  bind_as_value<Paint>(paint);
}
