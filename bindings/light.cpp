// SPDX-License-Identifier: Apache-2.0
#include "light.h"

#include <pybind11/native_enum.h>
#include <pybind11/stl.h>

#include <array>
#include <string>
#include <vector>

#include "module.h"
#include "paint.h"
#include "validation.h"

namespace py = pybind11;
using metallic_paint::Light;
using metallic_paint::LightKind;

std::vector<Light<double>> lights_of(py::handle value) {
  if (!PySequence_Check(value.ptr())) reject_type("lights", value, "a sequence of Light");
  const auto given = py::reinterpret_borrow<py::sequence>(value);
  if (given.size() > metallic_paint::kLightSlots) {
    throw py::value_error("lights holds " + std::to_string(given.size()) +
                          ", but must hold at most " + std::to_string(metallic_paint::kLightSlots));
  }
  std::vector<Light<double>> lights;
  lights.reserve(given.size());
  for (std::size_t i = 0; i < given.size(); ++i) {
    const py::object light = given[i];
    lights.push_back(object_of<Light<double>>(metallic_paint::at_row("lights", i), light));
  }
  return lights;
}

namespace {

Light<double> make_light(py::handle kind, py::handle vector, py::handle size, py::handle facing) {
  static const std::string kinds = "a LightKind: " + one_of(metallic_paint::kLightKindWords);
  const Light<double> light{
      from_python<LightKind>("light.kind", kind, kinds.c_str()),
      three_numbers("light.vector", vector), from_python<double>("light.size", size, kNumber),
      facing.is_none() ? metallic_paint::Vec3<double>{} : three_numbers("light.facing", facing)};
  metallic_paint::validate(light);
  return light;
}

py::tuple tuple_of(const metallic_paint::Vec3<double>& v) { return py::make_tuple(v.x, v.y, v.z); }

py::tuple fields_of(const Light<double>& light) {
  return py::make_tuple(light.kind, tuple_of(light.vector), light.size, tuple_of(light.facing));
}

}  // namespace

void bind_light(py::module_& module) {
  py::class_<Light<double>>(
      module, "Light",
      R"doc(A light that sparkles, as a slot of the shader holds it (paper, 5.3.5).

kind: a LightKind. parallel: vector points to the light (any length above 0, at most 1e30 in each
axis), size is the sine of its angular radius, 0 to 1; sky: the same of the sun in a world.
positional: vector is the centre and size the radius, in scene units, 0 to 1e30. area: flat and seen
from the side that facing points to; size is the radius of a disc of its area, facing is as long as
its farthest point is from the centre.)doc")
      .def(py::init(&make_light), py::arg("kind"), py::arg("vector"), py::arg("size"),
           py::arg("facing") = py::none())
      .def_readonly("kind", &Light<double>::kind)
      .def_property_readonly("vector", [](const Light<double>& l) { return tuple_of(l.vector); })
      .def_readonly("size", &Light<double>::size)
      .def_property_readonly("facing", [](const Light<double>& l) { return tuple_of(l.facing); })
      .def(
          "__eq__",
          [](const Light<double>& one, const Light<double>& other) {
            return fields_of(one).equal(fields_of(other));
          },
          py::is_operator())
      .def("__hash__", [](const Light<double>& light) { return py::hash(fields_of(light)); })
      .def(py::pickle(&fields_of, [](const py::tuple& all) {
        return make_light(all[0], all[1], all[2], all[3]);
      }));
}
