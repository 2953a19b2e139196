// SPDX-License-Identifier: Apache-2.0
#include "paint.h"

#include <pybind11/native_enum.h>
#include <pybind11/stl.h>

#include <array>
#include <type_traits>
#include <utility>
#include <vector>

#include "module.h"
#include "validation.h"

namespace py = pybind11;
using metallic_paint::Composition;
using metallic_paint::DepthModel;
using metallic_paint::Diffraction;
using metallic_paint::FlakeSpecies;
using metallic_paint::Orientation;
using metallic_paint::Paint;
using metallic_paint::Radiometry;
using metallic_paint::Rgb;

namespace {

using Triple = std::array<double, 3>;

template <auto field, class Class>
void def_field(Class& cls, const char* name, const char* range) {
  using C = typename Class::type;
  using T = std::remove_cvref_t<decltype(std::declval<C>().*field)>;
  cls.def_property(
      name, [](const C& c) { return c.*field; },
      [name, range](C& c, py::handle v) { c.*field = from_python<T>(name, v, range); });
}

// A colour field as a tuple of three floats.
template <auto field, class Class>
void def_colour(Class& cls, const char* name) {
  using C = typename Class::type;
  cls.def_property(
      name, [](const C& c) { return py::make_tuple((c.*field).x, (c.*field).y, (c.*field).z); },
      [name](C& c, py::handle value) {
        const Triple v = from_python<Triple>(name, value, kThreeNumbers);
        c.*field = {v[0], v[1], v[2]};
      });
}

// An object of that class with these fields.
template <class C>
C from_keywords(const py::kwargs& fields) {
  py::object self = py::cast(C{});
  const py::object type = py::type::of<C>();
  for (const auto& [name, value] : fields) {
    const py::object field = py::getattr(type, name, py::none());
    if (!PyObject_TypeCheck(field.ptr(), &PyProperty_Type)) {
      throw py::type_error(py::cast<std::string>(type.attr("__name__")) + " has no field " +
                           py::cast<std::string>(name));
    }
    self.attr(name) = value;
  }
  return self.cast<C>();
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

  py::native_enum<Composition>(
      module, "Composition", "enum.IntEnum",
      R"doc(Sparkles add to the paint's other light, or a pixel takes the brighter of both.)doc")
      .value("exact", Composition::exact)
      .value("published", Composition::published)
      .finalize();
  py::native_enum<Diffraction>(
      module, "Diffraction", "enum.IntEnum",
      R"doc(What a flake's edge adds to its spread: nothing, or the diffraction by a disc.)doc")
      .value("none", Diffraction::none)
      .value("disc", Diffraction::disc)
      .finalize();

  py::class_<FlakeSpecies> species(
      module, "FlakeSpecies",
      R"doc(One species of flakes, in real units: see struct FlakeSpecies in core/paint.h.

The fields are checked when a Paint is.)doc");
  species.def(py::init(&from_keywords<FlakeSpecies>));
  def_field<&FlakeSpecies::flakes_per_mm2>(species, "flakes_per_mm2", kNumber);
  def_field<&FlakeSpecies::flake_diameter_um>(species, "flake_diameter_um", kNumber);
  def_field<&FlakeSpecies::flake_area_spread>(species, "flake_area_spread", kNumber);
  def_field<&FlakeSpecies::orientation>(species, "orientation",
                                        "Orientation.gaussian, .beckmann or .ggx");
  def_field<&FlakeSpecies::tilt>(species, "tilt", kNumber);
  def_field<&FlakeSpecies::flake_spread>(species, "flake_spread", kNumber);
  def_colour<&FlakeSpecies::flake_color>(species, "flake_color");
  def_colour<&FlakeSpecies::flake_edge_color>(species, "flake_edge_color");
  def_colour<&FlakeSpecies::flake_transmission>(species, "flake_transmission");
  species.def_property(
      "coating", [](const FlakeSpecies& f) { return static_cast<int>(f.coating); },
      [](FlakeSpecies& f, py::handle value) {
        const int kind = from_python<int>("coating", value, "a whole number from 0 to 14");
        metallic_paint::require_coating("coating", kind, 0);
        f.coating = static_cast<metallic_paint::CoatingKind>(kind);
      });
  def_field<&FlakeSpecies::coating_nm>(species, "coating_nm", kNumber);

  py::class_<Paint, FlakeSpecies> paint(
      module, "Paint",
      R"doc(A paint in real units; the defaults are the shader's, but without diffraction. See struct
Paint in core/paint.h.

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
  def_field<&Paint::more>(paint, "more", "two FlakeSpecies");
  def_field<&Paint::diffraction>(paint, "diffraction", "Diffraction.none or .disc");
  def_field<&Paint::binder_ior>(paint, "binder_ior", kNumber);
  def_field<&Paint::layer_thickness_um>(paint, "layer_thickness_um", kNumber);
  def_field<&Paint::rayleigh_per_mm>(paint, "rayleigh_per_mm", kNumber);
  def_field<&Paint::depth_model>(paint, "depth_model", "DepthModel.attenuated or .thinned");
  def_field<&Paint::radiometry>(paint, "radiometry", "Radiometry.exact or .published");
  def_field<&Paint::composition>(paint, "composition", "Composition.exact or .published");
  def_field<&Paint::sparkle_contrast>(paint, "sparkle_contrast", kNumber);
  def_colour<&Paint::substrate_color>(paint, "substrate_color");
  def_field<&Paint::texture_contrast>(paint, "texture_contrast", kNumber);
  def_field<&Paint::coat_roughness>(paint, "coat_roughness", kNumber);
  def_field<&Paint::orange_peel>(paint, "orange_peel", kNumber);
  def_field<&Paint::orange_peel_mm>(paint, "orange_peel_mm", kNumber);
  def_field<&Paint::seed>(paint, "seed", kInt32);
  def_field<&Paint::frame>(paint, "frame", kInt32);
  def_colour<&Paint::binder_absorption_per_mm>(paint, "binder_absorption_per_mm");
}
