// SPDX-License-Identifier: Apache-2.0
#include "paint.h"

#include <pybind11/native_enum.h>
#include <pybind11/stl.h>

#include <array>

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

// A colour field as a tuple of three floats.
template <Rgb<double> Paint::* field>
void def_colour(py::class_<Paint>& cls, const char* name) {
  cls.def_property(
      name, [](const Paint& p) { return py::make_tuple((p.*field).x, (p.*field).y, (p.*field).z); },
      [](Paint& p, Triple v) { p.*field = {v[0], v[1], v[2]}; });
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
          if (!py::hasattr(self, name)) {
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
          R"doc(Raises ValueError where a field is out of its range.)doc")
      .def_readwrite("flakes_per_mm2", &Paint::flakes_per_mm2)
      .def_readwrite("flake_diameter_um", &Paint::flake_diameter_um)
      .def_readwrite("flake_area_spread", &Paint::flake_area_spread)
      .def_readwrite("orientation", &Paint::orientation)
      .def_readwrite("tilt", &Paint::tilt)
      .def_readwrite("flake_spread", &Paint::flake_spread)
      .def_readwrite("binder_ior", &Paint::binder_ior)
      .def_readwrite("layer_thickness_um", &Paint::layer_thickness_um)
      .def_readwrite("rayleigh_per_mm", &Paint::rayleigh_per_mm)
      .def_readwrite("depth_model", &Paint::depth_model)
      .def_readwrite("radiometry", &Paint::radiometry)
      .def_readwrite("seed", &Paint::seed)
      .def_readwrite("frame", &Paint::frame);
  def_colour<&Paint::flake_color>(paint, "flake_color");
  def_colour<&Paint::flake_edge_color>(paint, "flake_edge_color");
  def_colour<&Paint::flake_transmission>(paint, "flake_transmission");
  def_colour<&Paint::binder_absorption_per_mm>(paint, "binder_absorption_per_mm");

  py::class_<CoatingTable<double>>(
      module, "CoatingTable",
      R"doc(Reflectance and transmittance of a flake, RGB, at cos(alpha) = 0, 1/(n-1), ..., 1.

2 to 4096 rows, linear in between; each value and each sum of the two from 0 to 1.)doc")
      .def(py::init([](const std::vector<Triple>& reflectance,
                       const std::vector<Triple>& transmittance) {
             CoatingTable<double> table;
             for (const Triple& r : reflectance) table.reflectance.push_back({r[0], r[1], r[2]});
             for (const Triple& t : transmittance)
               table.transmittance.push_back({t[0], t[1], t[2]});
             metallic_paint::validate(table);
             return table;
           }),
           py::arg("reflectance"), py::arg("transmittance"));
}
