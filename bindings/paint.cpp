// SPDX-License-Identifier: Apache-2.0
#include "paint.h"

#include <pybind11/native_enum.h>
#include <pybind11/stl.h>

#include <array>
#include <type_traits>
#include <utility>
#include <vector>

#include "module.h"

namespace py = pybind11;
using metallic_paint::CoatingTable;
using metallic_paint::DepthModel;
using metallic_paint::Orientation;
using metallic_paint::Paint;
using metallic_paint::Radiometry;
using metallic_paint::Rgb;

namespace {

using Triple = std::array<double, 3>;

template <auto field>
void def_field(py::class_<Paint>& cls, const char* name, const char* range) {
  using T = std::remove_cvref_t<decltype(std::declval<Paint>().*field)>;
  cls.def_property(
      name, [](const Paint& p) { return p.*field; },
      [name, range](Paint& p, py::handle v) { p.*field = from_python<T>(name, v, range); });
}

// A colour field as a tuple of three floats.
template <Rgb<double> Paint::* field>
void def_colour(py::class_<Paint>& cls, const char* name) {
  cls.def_property(
      name, [](const Paint& p) { return py::make_tuple((p.*field).x, (p.*field).y, (p.*field).z); },
      [name](Paint& p, py::handle value) {
        const Triple v = from_python<Triple>(name, value, kThreeNumbers);
        p.*field = {v[0], v[1], v[2]};
      });
}

std::vector<Rgb<double>> colours(const char* field, py::handle value) {
  const Array<double> rows = numbers(field, value);
  require_rows_of_3(field, rows);
  std::vector<Rgb<double>> all;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    all.push_back({rows.at(i, 0), rows.at(i, 1), rows.at(i, 2)});
  }
  return all;
}

}  // namespace

void bind_paint(py::module_& module) {
  py::native_enum<Orientation>(
      module, "Orientation", "enum.IntEnum",
      R"doc(The shape of P(beta): the paper's Gaussian in beta, or the field's Beckmann and GGX.)doc")
      .value("gaussian", Orientation::gaussian)
      .value("beckmann", Orientation::beckmann)
      .value("ggx", Orientation::ggx)
      .finalize();
  py::native_enum<DepthModel>(
      module, "DepthModel", "enum.IntEnum",
      R"doc(With (attenuated) or without (thinned) masking and shadowing: paper, 5.3.2.)doc")
      .value("attenuated", DepthModel::attenuated)
      .value("thinned", DepthModel::thinned)
      .finalize();
  py::native_enum<Radiometry>(
      module, "Radiometry", "enum.IntEnum",
      R"doc(The energy-conserving derivation, or the paper's formulas to the letter.)doc")
      .value("exact", Radiometry::exact)
      .value("published", Radiometry::published)
      .finalize();

  py::class_<Paint> paint(
      module, "Paint",
      R"doc(A paint in real units; the defaults are the shader's. See struct Paint in core/paint.h.

Fields given as keywords are checked on construction, all fields again on use.)doc");
  paint
      .def(py::init([](const py::kwargs& fields) {
        py::object self = py::cast(Paint{});
        for (const auto& [name, value] : fields) {
          const py::object field = py::getattr(py::type::of<Paint>(), name, py::none());
          if (!PyObject_TypeCheck(field.ptr(), &PyProperty_Type)) {
            throw py::type_error("Paint has no field " + py::cast<std::string>(name));
          }
          self.attr(name) = value;
        }
        const Paint complete = self.cast<Paint>();
        metallic_paint::validate(complete);
        return complete;
      }))
      .def(
          "validate", [](const Paint& p) { metallic_paint::validate(p); },
          R"doc(Raises ValueError where a field is out of its range.)doc");
  def_field<&Paint::flakes_per_mm2>(paint, "flakes_per_mm2", kNumber);
  def_field<&Paint::flake_diameter_um>(paint, "flake_diameter_um", kNumber);
  def_field<&Paint::flake_area_spread>(paint, "flake_area_spread", kNumber);
  def_field<&Paint::orientation>(paint, "orientation", "Orientation.gaussian, .beckmann or .ggx");
  def_field<&Paint::tilt>(paint, "tilt", kNumber);
  def_field<&Paint::flake_spread>(paint, "flake_spread", kNumber);
  def_field<&Paint::binder_ior>(paint, "binder_ior", kNumber);
  def_field<&Paint::layer_thickness_um>(paint, "layer_thickness_um", kNumber);
  def_field<&Paint::rayleigh_per_mm>(paint, "rayleigh_per_mm", kNumber);
  def_field<&Paint::depth_model>(paint, "depth_model", "DepthModel.attenuated or .thinned");
  def_field<&Paint::radiometry>(paint, "radiometry", "Radiometry.exact or .published");
  def_field<&Paint::seed>(paint, "seed", kInt32);
  def_field<&Paint::frame>(paint, "frame", kInt32);
  def_colour<&Paint::flake_color>(paint, "flake_color");
  def_colour<&Paint::flake_edge_color>(paint, "flake_edge_color");
  def_colour<&Paint::flake_transmission>(paint, "flake_transmission");
  def_colour<&Paint::binder_absorption_per_mm>(paint, "binder_absorption_per_mm");

  py::class_<CoatingTable<double>>(
      module, "CoatingTable",
      R"doc(Reflectance and transmittance of a flake, RGB, at cos(alpha) = 0, 1/(n-1), ..., 1.

2 to 4096 rows, linear in between; each value and each sum of the two from 0 to 1.)doc")
      .def(py::init([](py::handle reflectance, py::handle transmittance) {
             const CoatingTable<double> table{colours("coating.reflectance", reflectance),
                                              colours("coating.transmittance", transmittance)};
             metallic_paint::validate(table);
             return table;
           }),
           py::arg("reflectance"), py::arg("transmittance"));
}
