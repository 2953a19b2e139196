// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <vector>

#include "batch.h"
#include "module.h"

namespace py = pybind11;
using namespace metallic_paint;

namespace {

py::dict evaluate(const Paint& paint, const std::vector<Light<double>>& lights,
                  py::handle positions, py::handle normals, py::handle views, py::handle footprints,
                  py::handle pixels, py::handle slant_depths, const std::string& precision,
                  py::handle species_index) {
  if (lights.size() > kLightSlots) {
    throw py::value_error("lights holds " + std::to_string(lights.size()) +
                          ", but must hold at most " + std::to_string(kLightSlots));
  }
  if (precision != "float" && precision != "double") {
    throw py::value_error("precision is '" + precision + "', but must be 'float' or 'double'");
  }
  const int species = from_python<int>("species", species_index, kInt32);
  if (species < 0 || species >= kSpecies) {
    throw py::value_error("species is " + std::to_string(species) + ", but must be from 0 to " +
                          std::to_string(kSpecies - 1));
  }
  const Array<double> position = numbers("position", positions);
  const Array<double> normal = numbers("normal", normals);
  const Array<double> view = numbers("view", views);
  const Array<double> footprint = numbers("footprint", footprints);
  const Array<std::int32_t> pixel = whole_numbers("pixel", pixels);
  std::optional<Array<double>> slant_depth;
  if (!slant_depths.is_none()) slant_depth = numbers("slant_depth", slant_depths);
  require_one_dimension("footprint", footprint);
  const py::ssize_t n = footprint.shape(0);
  const py::ssize_t slots = static_cast<py::ssize_t>(lights.size());
  require_shape("position", position, {n, 3});
  require_shape("normal", normal, {n, 3});
  require_shape("view", view, {n, 3});
  require_shape("pixel", pixel, {n, 2});
  if (slant_depth) require_shape("slant_depth", *slant_depth, {n, slots, 3});
  metallic_paint::validate(paint);

  py::array_t<std::int32_t> leader({n, slots}), places({n, slots});
  py::array_t<double> count({n, slots}), mean_count({n, slots});
  py::array_t<double> radiance({n, slots, py::ssize_t{3}}),
      mean_radiance({n, slots, py::ssize_t{3}}), variance({n, slots, py::ssize_t{3}});
  const PixelBatch batch{static_cast<std::size_t>(n),
                         position.data(),
                         normal.data(),
                         view.data(),
                         footprint.data(),
                         pixel.data(),
                         slant_depth ? slant_depth->data() : nullptr};
  const PixelResults results{leader.mutable_data(),     places.mutable_data(),
                             mean_count.mutable_data(), count.mutable_data(),
                             radiance.mutable_data(),   mean_radiance.mutable_data(),
                             variance.mutable_data()};
  {
    const py::gil_scoped_release released;
    metallic_paint::validate(batch, lights.size());
    const auto at = static_cast<std::size_t>(species);
    if (precision == "float") {
      evaluate_pixels<float>(paint, lights, at, batch, results);
    } else {
      evaluate_pixels<double>(paint, lights, at, batch, results);
    }
  }
  py::dict all;
  all["leader"] = leader;
  all["slots"] = places;
  all["mean_count"] = mean_count;
  all["count"] = count;
  all["radiance"] = radiance;
  all["mean_radiance"] = mean_radiance;
  all["variance"] = variance;
  return all;
}

}  // namespace

void bind_evaluate(py::module_& module) {
  module.def("evaluate", &evaluate, py::arg("paint"), py::arg("lights"), py::kw_only(),
             py::arg("position"), py::arg("normal"), py::arg("view"), py::arg("footprint"),
             py::arg("pixel"), py::arg("slant_depth") = py::none(), py::arg("precision") = "double",
             py::arg("species") = 0,
             R"doc(The sparkles of up to 8 lights in n pixels, on all cores.

position (n, 3) in scene units; normal and view (n, 3), unit, view towards the observer, zero
for a pixel without surface; footprint (n,), the area of the pixel's projection on the surface
in m2; pixel (n, 2), whole pixel coordinates x and y. The deviates depend on pixel, light
number, species, paint.frame and paint.seed alone.
slant_depth (n, m, 3) replaces the layer's own optical depth tau(view) H/cos + tau(light) H/cos.
"float" repeats the shader operation by operation; "double" is the reference.

A dict over pixels and lights: leader, the light whose cone and sparkles this one shares, -1 if
it is below the surface; mean_count, slots (0 Poisson, k binomial) and count of the sparkles of
the flake species asked for; radiance, its mean and variance (n, m, 3), of all species, per unit of
the light's irradiance on a plane normal to it, 1/sr.
mean_radiance is cos(theta') flake_brdf while the cone of flake normals that see the light is
narrower than tilt/16; for wider lights P(beta) is averaged over that cone.)doc");
}
