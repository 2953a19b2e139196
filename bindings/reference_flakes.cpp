// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <string>
#include <utility>

#include "module.h"
#include "reference/explicit_flakes.h"

namespace py = pybind11;
using namespace metallic_paint;
using reference::ExplicitResult;
using reference::ExplicitScene;
using reference::Shadowing;

namespace {

// The same memory as an array of doubles.
template <class T>
py::array_t<double> array_of(std::vector<T> values, const std::vector<py::ssize_t>& shape) {
  auto kept = std::make_unique<std::vector<T>>(std::move(values));
  const auto* first = reinterpret_cast<const double*>(kept->data());
  const py::capsule owner(kept.get(), [](void* all) { delete static_cast<std::vector<T>*>(all); });
  kept.release();
  return py::array_t<double>(shape, first, owner);
}

py::array_t<double> rgb(Rgb<double> value) {
  py::array_t<double> array(3);
  double* out = array.mutable_data();
  out[0] = value.x, out[1] = value.y, out[2] = value.z;
  return array;
}

py::dict explicit_flakes(py::handle paint, py::handle view, py::handle light,
                         py::handle light_radius, py::handle footprint, py::handle pixels,
                         py::handle shadowing, py::handle points, py::handle seed) {
  ExplicitScene scene;
  scene.paint = object_of<Paint>("paint", paint);
  scene.view = three_numbers("view", view);
  scene.light = three_numbers("light", light);
  scene.light_radius = from_python<double>("light_radius", light_radius, kNumber);
  scene.footprint = from_python<double>("footprint", footprint, kNumber);
  const int count = from_python<int>("pixels", pixels, kInt32);
  if (count < 0) reject("pixels", pixels, "from 1 to 2^24");
  scene.pixels = static_cast<std::size_t>(count);
  scene.shadowing = static_cast<Shadowing>(
      choice("shadowing", shadowing, {"none", "attenuated", "thinned", "discs"}));
  scene.points = from_python<int>("points", points, kInt32);
  scene.seed = static_cast<std::uint64_t>(from_python<int>("seed", seed, kInt32));
  ExplicitResult traced;
  interruptible([&](const std::stop_token& stop) { traced = trace_explicit_flakes(scene, stop); });
  static_assert(sizeof(Rgb<double>) == 3 * sizeof(double));
  const auto n = static_cast<py::ssize_t>(traced.count.size());
  py::dict all;
  all["count"] = array_of(std::move(traced.count), {n});
  all["radiance"] = array_of(std::move(traced.radiance), {n, 3});
  all["flakes"] = traced.flakes;
  all["sparkles"] = py::array_t<double>(kSpecies, traced.sparkles.data());
  all["mean_share"] = rgb(traced.mean_share);
  all["mean_square_share"] = rgb(traced.mean_square_share);
  return all;
}

}  // namespace

void bind_explicit_flakes(py::module_& module) {
  module.def(
      "explicit_flakes", &explicit_flakes, py::arg("paint"), py::arg("view"), py::arg("light"),
      py::arg("light_radius"), py::arg("footprint"), py::arg("pixels"), py::kw_only(),
      py::arg("shadowing") = "discs", py::arg("points") = 16, py::arg("seed") = 0,
      R"doc(Individual flakes, traced one by one: the brute force that the sparkles are measured against.

view, light (3,): unit vectors away from a plane paint with the normal +z. light_radius: angular,
outside the binder, 0 to pi/2 rad; above 0 unless every species has a spread. footprint: area of a
square pixel, 1e-20 to 1e6 m2. pixels: their number n, 1 to 2^24.
shadowing: what dims a sparkle besides the binder. "discs": the other flakes as they lie, at
`points` points (1 to 65536) of each flake that sparkles; "attenuated": their mean exp(-z t);
"thinned": the sparkle is there with that probability; "none": nothing.
seed: a 32-bit integer; the result is the same for it whatever the number of cores.
Returns a dict: count (n,), the sparkles of each pixel; radiance (n, 3), T per unit irradiance on a
plane normal to the light, 1/sr; flakes, how many were traced; sparkles (3,), the sum of count for
each species; mean_share and mean_square_share (3,), E[s] and E[s^2] over all sparkles, RGB, of the
share s that the shadowing leaves.
A scene of more than 1e12 steps, a day of one core, is refused. See core/reference.)doc");
}
