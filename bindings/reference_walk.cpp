// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "module.h"
#include "reference/random_walk.h"

namespace py = pybind11;
using namespace metallic_paint;
using reference::ByComponent;
using reference::Estimate;

namespace {

// Estimates as the arrays `name` and `name`_error of the shape (*shape, 3).
void store(py::dict& all, const std::string& name, const std::vector<Estimate>& values,
           std::vector<py::ssize_t> shape) {
  shape.push_back(3);
  py::array_t<double> mean(shape), error(shape);
  double *to_mean = mean.mutable_data(), *to_error = error.mutable_data();
  for (const Estimate& value : values) {
    for (const double x : {value.mean.x, value.mean.y, value.mean.z}) *to_mean++ = x;
    for (const double x : {value.error.x, value.error.y, value.error.z}) *to_error++ = x;
  }
  all[name.c_str()] = mean;
  all[(name + "_error").c_str()] = error;
}

void store(py::dict& all, const std::string& name, const std::vector<ByComponent>& values,
           const std::vector<py::ssize_t>& shape) {
  const auto store_each = [&](const std::string& suffix, const auto& pick) {
    std::vector<Estimate> picked;
    for (const ByComponent& value : values) picked.push_back(pick(value));
    store(all, name + suffix, picked, shape);
  };
  const auto part = [](reference::Component c) {
    return [c](const ByComponent& value) { return value.part[c]; };
  };
  store_each("", [](const ByComponent& value) { return value.total; });
  store_each("_single_flake", part(reference::single_flake));
  store_each("_substrate", part(reference::substrate));
  store_each("_mixture", part(reference::mixture));
}

py::dict random_walk(py::handle paint, py::handle light, py::handle substrate, py::handle detectors,
                     py::handle photons, py::handle theta_bins, py::handle phi_bins,
                     py::handle seed) {
  reference::WalkScene scene;
  scene.paint = object_of<Paint>("paint", paint);
  scene.light = three_numbers("light", light);
  scene.substrate = three_numbers("substrate", substrate);
  if (!detectors.is_none()) {
    const Array<double> rows = numbers("detectors", detectors);
    require_rows_of_3("detectors", rows);
    for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
      scene.detectors.push_back({rows.at(i, 0), rows.at(i, 1), rows.at(i, 2)});
    }
  }
  scene.photons = from_python<std::uint64_t>("photons", photons, "a whole number from 2 to 1e12");
  scene.theta_bins = from_python<int>("theta_bins", theta_bins, kInt32);
  scene.phi_bins = from_python<int>("phi_bins", phi_bins, kInt32);
  scene.seed = from_python<std::uint64_t>("seed", seed, "a whole number from 0 to 2^64 - 1");

  reference::WalkResult result;
  interruptible([&](const std::stop_token& stop) { result = reference::walk(scene, stop); });
  py::dict all;
  all["specular"] = result.specular;
  store(all, "albedo", std::vector<ByComponent>{result.albedo}, {});
  store(all, "absorbed", std::vector<Estimate>{result.absorbed}, {});
  store(all, "truncated", std::vector<Estimate>{result.truncated}, {});
  all["truncated_walks"] = result.truncated_walks;
  store(all, "brdf", result.brdf, {static_cast<py::ssize_t>(result.brdf.size())});
  store(all, "bins", result.bins, {scene.theta_bins, scene.phi_bins});
  return all;
}

}  // namespace

void bind_reference_walk(py::module_& module) {
  module.def(
      "random_walk", &random_walk, py::arg("paint"), py::arg("light"), py::kw_only(),
      py::arg("substrate") = py::make_tuple(0.8, 0.8, 0.8), py::arg("detectors") = py::none(),
      py::arg("photons") = 1'000'000, py::arg("theta_bins") = 0, py::arg("phi_bins") = 0,
      py::arg("seed") = 0,
      R"doc(Photons walked through the whole paint: the brute force that mixture and BRDF are measured against.

light (3,) and detectors (n, 3), at most 4096: unit vectors away from the surface, of the normal +z.
substrate (3,): albedo of the Lambertian substrate, RGB from 0 to 1. photons: 2 to 1e12. theta_bins
x phi_bins: at most 16384, or both 0. seed: 0 to 2^64 - 1; the result depends on the arguments
alone. Flakes, Rayleigh scattering, absorption, the substrate and the smooth surface of the binder
(Fresnel, from both sides) act as often as a photon meets them; see core/reference/random_walk.h.

Returns a dict of RGB arrays, each X with its standard error X_error (from batch means). Shares are
of the flux that falls on the surface:
albedo (3,): comes back, without the surface's own reflection, which is `specular`, a float;
absorbed (3,); truncated (3,): still under way after 1e6 events, on `truncated_walks` photons;
brdf (n, 3): towards each detector, 1/sr, without the specular (next-event estimation);
bins (theta_bins, phi_bins, 3): comes back into even steps of cos(theta) from 0 to 1 and of phi
from 0 to 2 pi (counted photons; their sum is the albedo).
albedo and brdf are the sum of X_single_flake (mirrored by one flake and nothing else),
X_substrate (scattered once by the substrate and by nothing else) and X_mixture (the rest); flakes
that let light straight through do not count as scattering.
A scene of more than 1e12 steps, a day of one core, is refused.)doc");
}
