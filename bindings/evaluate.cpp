// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "batch.h"
#include "fast_call.h"
#include "module.h"
#include "places.h"
#include "validation.h"

namespace py = pybind11;
using namespace metallic_paint;

namespace {

constexpr std::array kResults{"leader",   "slots",         "mean_count", "count",
                              "radiance", "mean_radiance", "variance"};

// An array that lies in `memory`, of so many of these dimensions.
template <class Number>
py::object part_of(const py::array& memory, Number* first, std::array<py::ssize_t, 3> shape,
                   int dimensions) {
  const py::detail::npy_api& numpy = py::detail::npy_api::get();
  PyObject* part = numpy.PyArray_NewFromDescr_(
      numpy.PyArray_Type_, py::dtype::of<Number>().release().ptr(), dimensions, shape.data(),
      nullptr, first,
      py::detail::npy_api::NPY_ARRAY_C_CONTIGUOUS_ | py::detail::npy_api::NPY_ARRAY_ALIGNED_ |
          py::detail::npy_api::NPY_ARRAY_WRITEABLE_,
      nullptr);
  if (part == nullptr) throw py::error_already_set();
  py::object held = py::reinterpret_steal<py::object>(part);
  if (numpy.PyArray_SetBaseObject_(part, memory.inc_ref().ptr()) != 0) {
    throw py::error_already_set();
  }
  return held;
}

py::dict evaluate(py::handle one_paint, py::handle some_lights, py::handle positions,
                  py::handle normals, py::handle views, py::handle footprints, py::handle pixels,
                  py::handle own_positions, py::handle own_axes, py::handle instances,
                  py::handle slant_depths, py::handle precision) {
  const Paint& paint = object_of<Paint>("paint", one_paint);
  const std::vector<Light<double>> lights = lights_of(some_lights);
  const bool is_float = choice("precision", precision, {"float", "double"}) == 0;
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
  const py::ssize_t all_lights = n * slots;
  const py::array_t<double> memory(12 * all_lights);
  double* rest = const_cast<double*>(memory.data());
  const auto next = [&](py::ssize_t numbers) { return std::exchange(rest, rest + numbers); };
  double *radiance = next(3 * all_lights), *mean_radiance = next(3 * all_lights),
         *variance = next(3 * all_lights), *count = next(all_lights),
         *mean_count = next(all_lights);
  auto* leader = reinterpret_cast<std::int32_t*>(rest);
  std::int32_t* count_slots = leader + all_lights;
  const PixelBatch batch = places.batch(column_of(slant_depth));
  const PixelResults results{leader,   count_slots,   mean_count, count,
                             radiance, mean_radiance, variance};
  const auto evaluate_in = [&](const auto& layer, const std::stop_token& stop) {
    evaluate_pixels(prepared->paint, layer, lights, batch, results, stop);
  };
  // With three species some 30 ms: not worth a thread that looks for signals.
  const bool brief = std::max(n, all_lights) <= (is_float ? 1 << 15 : 1 << 11);
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
  // The names as Python has its own keywords: looked up without being made or compared.
  static const std::array names = [] {
    std::array<PyObject*, 7> interned{};
    std::transform(kResults.begin(), kResults.end(), interned.begin(), PyUnicode_InternFromString);
    return interned;
  }();
  py::dict all;
  std::size_t at = 0;
  const auto give = [&](auto* first, int dimensions) {
    const py::object part = part_of(memory, first, {n, slots, 3}, dimensions);
    if (PyDict_SetItem(all.ptr(), names[at++], part.ptr()) != 0) throw py::error_already_set();
  };
  give(leader, 2);
  give(count_slots, 2);
  give(mean_count, 2);
  give(count, 2);
  give(radiance, 3);
  give(mean_radiance, 3);
  give(variance, 3);
  return all;
}

PyObject* call_evaluate(PyObject*, PyObject* const* given, Py_ssize_t by_position,
                        PyObject* keywords) {
  return returned_or_raised([&] {
    static const Signature<12> signature("evaluate", 2,
                                         {{"paint"},
                                          {"lights"},
                                          {"position"},
                                          {"normal"},
                                          {"view"},
                                          {"footprint"},
                                          {"pixel"},
                                          {"own_position", Py_None},
                                          {"own_axes", Py_None},
                                          {"instance", Py_None},
                                          {"slant_depth", Py_None},
                                          {"precision", PyUnicode_InternFromString("double")}});
    const auto arguments = signature.arrange(given, by_position, keywords);
    return std::apply(evaluate, arguments);
  });
}

}  // namespace

void bind_evaluate(py::module_& module) {
  static PyMethodDef definition{
      "evaluate", reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(call_evaluate)),
      METH_FASTCALL | METH_KEYWORDS,
      R"doc(evaluate(paint, lights, *, position, normal, view, footprint, pixel, own_position=None, own_axes=None, instance=None, slant_depth=None, precision='double')

The sparkles of m lights, at most 8, in n pixels (paper, 5.3; derivation: core/expected_sparkles.h).

position (n, 3): in scene units, at most 1e30; normal and view (n, 3): unit vectors, view towards
the observer; zero for a pixel without surface. footprint (n,): area of the pixel's projection on
the surface, 0 to 1e30 m2. pixel (n, 2): whole coordinates x and y, 32-bit.
own_position (n, 3): where the points lie in the object's own space, m, at most 1e30. If it is not
given, sparkles belong to the pixels, whatever the Anchor. own_axes (n, 3, 3): that space's axes x, y, z as unit vectors of the world; the
world's own if not given. instance (n,): tells copies of an object apart, 32-bit; 0 if not given.
With Anchor pixel the deviates depend on pixel, light number, paint.frame and paint.seed alone; with
Anchor surface, whose counts are those of the cell in which the point lies, on its place and
half-way direction in the own space, instance, paint.frame and paint.seed.
slant_depth (n, m, 3): 0 to 1e30, in place of the layer's own optical depth on the ways to observer
and light, tau(view) H/cos + tau(light) H/cos. precision: "float" repeats the shader operation by
operation; "double" is the reference.

Returns a dict over pixels and lights: leader (n, m), the light whose cone and sparkles this one
shares, -1 if it is below the surface; slots (n, m) of the first species' count (0 Poisson, k
binomial); mean_count and count (n, m) of the sparkles of all species: of a species seen close up,
whether the flake there mirrors the light, and how probable that is; radiance, mean_radiance and
variance (n, m, 3) of all species, per unit of the light's irradiance on a plane normal to it: 1/sr,
and its square for the variance.
The arrays share one piece of memory, which any of them keeps.
mean_radiance is cos(theta') flake_brdf while the cone of flake normals that see the light is
narrower than tilt/16; for wider lights P(beta) is averaged over that cone.)doc"};
  const auto function = py::reinterpret_steal<py::object>(
      PyCFunction_NewEx(&definition, nullptr, py::object(module.attr("__name__")).ptr()));
  if (!function) throw py::error_already_set();
  module.attr("evaluate") = function;
}
