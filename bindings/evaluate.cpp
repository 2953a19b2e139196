// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batch.h"
#include "module.h"
#include "places.h"
#include "validation.h"

namespace py = pybind11;
using namespace metallic_paint;

namespace {

py::dict evaluate(py::handle one_paint, py::handle some_lights, py::handle positions,
                  py::handle normals, py::handle views, py::handle footprints, py::handle pixels,
                  py::handle own_positions, py::handle own_axes, py::handle instances,
                  py::handle slant_depths, py::handle precision, py::handle species_index) {
  const Paint& paint = object_of<Paint>("paint", one_paint);
  const std::vector<Light<double>> lights = lights_of(some_lights);
  const bool is_float = choice("precision", precision, {"float", "double"}) == 0;
  const int species = from_python<int>("species", species_index, kInt32);
  if (species < 0 || species >= kSpecies) {
    throw py::value_error("species is " + std::to_string(species) + ", but must be from 0 to " +
                          std::to_string(kSpecies - 1));
  }
  const Places places(positions, normals, views, footprints, pixels, own_positions, own_axes,
                      instances);
  std::optional<py::array> slant_depth;
  if (!slant_depths.is_none()) slant_depth = singles_or_doubles("slant_depth", slant_depths);
  const py::ssize_t n = places.size();
  const py::ssize_t slots = static_cast<py::ssize_t>(lights.size());
  if (slant_depth) require_shape("slant_depth", *slant_depth, {n, slots, 3});
  const std::shared_ptr<const PreparedPaint> prepared = prepared_paint(paint);

  // In one piece of memory. Seven pieces go back to the system after each call, which then takes as
  // long to give them anew as a float batch to fill them.
  const py::ssize_t lights_of_all = n * slots;
  const py::array_t<double> memory(12 * lights_of_all);
  double* rest = const_cast<double*>(memory.data());
  const auto colours = [&] {
    return py::array_t<double>({n, slots, py::ssize_t{3}},
                               std::exchange(rest, rest + 3 * lights_of_all), memory);
  };
  const auto counts = [&] {
    return py::array_t<double>({n, slots}, std::exchange(rest, rest + lights_of_all), memory);
  };
  py::array_t<double> radiance = colours(), mean_radiance = colours(), variance = colours(),
                      count = counts(), mean_count = counts();
  auto* rest_for_ints = reinterpret_cast<std::int32_t*>(rest);
  py::array_t<std::int32_t> leader({n, slots}, rest_for_ints, memory),
      count_slots({n, slots}, rest_for_ints + lights_of_all, memory);
  const PixelBatch batch = places.batch(column_of(slant_depth));
  const PixelResults results{leader.mutable_data(),     count_slots.mutable_data(),
                             mean_count.mutable_data(), count.mutable_data(),
                             radiance.mutable_data(),   mean_radiance.mutable_data(),
                             variance.mutable_data()};
  const auto evaluate_in = [&](const auto& layer, const std::stop_token& stop) {
    evaluate_pixels(prepared->paint, layer, lights, static_cast<std::size_t>(species), batch,
                    results, stop);
  };
  const bool brief = n <= 256;  // with eight lights and three species a fraction of a second
  interruptible(
      [&](const std::stop_token& stop) {
        metallic_paint::validate(batch, lights.size());
        if (is_float) {
          evaluate_in(prepared->as_float, stop);
        } else {
          evaluate_in(prepared->as_double, stop);
        }
      },
      brief);
  py::dict all;
  all["leader"] = leader;
  all["slots"] = count_slots;
  all["mean_count"] = mean_count;
  all["count"] = count;
  all["radiance"] = radiance;
  all["mean_radiance"] = mean_radiance;
  all["variance"] = variance;
  return all;
}

}  // namespace

void bind_evaluate(py::module_& module) {
  module.def(
      "evaluate", &evaluate, py::arg("paint"), py::arg("lights"), py::kw_only(),
      py::arg("position"), py::arg("normal"), py::arg("view"), py::arg("footprint"),
      py::arg("pixel"), py::arg("own_position") = py::none(), py::arg("own_axes") = py::none(),
      py::arg("instance") = py::none(), py::arg("slant_depth") = py::none(),
      py::arg("precision") = "double", py::arg("species") = 0,
      R"doc(The sparkles of m lights, at most 8, in n pixels (paper, 5.3; derivation: core/expected_sparkles.h).

position (n, 3): in scene units, at most 1e30; normal and view (n, 3): unit vectors, view towards
the observer; zero for a pixel without surface. footprint (n,): area of the pixel's projection on
the surface, 0 to 1e30 m2. pixel (n, 2): whole coordinates x and y, 32-bit.
own_position (n, 3): where the points lie in the object's own space, m, at most 1e30. If it is not
given, sparkles belong to the pixels, whatever the Anchor. own_axes (n, 3, 3): that space's axes x, y, z as unit vectors of the world; the
world's own if not given. instance (n,): tells copies of an object apart, 32-bit; 0 if not given.
With Anchor pixel the deviates depend on pixel, light number, species, paint.frame and paint.seed
alone; with Anchor surface, whose counts are those of the cell in which the point lies, on its place
and half-way direction in the own space, instance, species, paint.frame and paint.seed.
slant_depth (n, m, 3): 0 to 1e30, in place of the layer's own optical depth on the ways to observer
and light, tau(view) H/cos + tau(light) H/cos. precision: "float" repeats the shader operation by
operation; "double" is the reference. species: 0 to 2, whose counts are asked for.

Returns a dict over pixels and lights: leader (n, m), the light whose cone and sparkles this one
shares, -1 if it is below the surface; mean_count, slots (0 Poisson, k binomial) and count (n, m) of
the sparkles of the species asked for; radiance, mean_radiance and variance (n, m, 3), of all
species, per unit of the light's irradiance on a plane normal to it: 1/sr, and its square for the
variance.
The arrays share one piece of memory, which any of them keeps.
mean_radiance is cos(theta') flake_brdf while the cone of flake normals that see the light is
narrower than tilt/16; for wider lights P(beta) is averaged over that cone.)doc");
}
