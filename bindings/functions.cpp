// SPDX-License-Identifier: Apache-2.0
#include "module.h"
#include "paint.h"

namespace py = pybind11;
using namespace metallic_paint;

// The pieces of the model, element by element over arrays that broadcast.
void bind_functions(py::module_& module) {
  module.def(
      "hash_words",
      [](const Array<std::int32_t>& x, const Array<std::int32_t>& y, int light, int species,
         int frame, int seed, int draw) {
        if (x.size() != y.size()) throw py::value_error("x and y must have the same size");
        const HashWords key = stream_key(light, species, frame, seed);
        py::array_t<std::uint32_t> words({x.size(), py::ssize_t{4}});
        for (py::ssize_t i = 0; i < x.size(); ++i) {
          const HashWords w = draw_words(key, x.data()[i], y.data()[i], draw);
          std::uint32_t* row = words.mutable_data(i, 0);
          row[0] = w.x, row[1] = w.y, row[2] = w.z, row[3] = w.w;
        }
        return words;
      },
      py::arg("x"), py::arg("y"), py::kw_only(), py::arg("light") = 0, py::arg("species") = 0,
      py::arg("frame") = 0, py::arg("seed") = 0, py::arg("draw") = 0,
      R"doc(The four random words (n, 4) of draw number `draw` at pixels (x, y), any 32-bit integers.)doc");
  module.def("count_deviate", py::vectorize(&count_deviate<double>), py::arg("mean"),
             py::arg("slots"), py::arg("uniform"),
             R"doc(The count of sparkles for a uniform deviate in (0, 1].

slots = 0: Poisson; slots = k: binomial with k places and the same mean.)doc");
  module.def("normal_quantile", py::vectorize(&normal_quantile<double>), py::arg("probability"),
             R"doc(The standard normal deviate at a probability in (0, 1].)doc");
  module.def(
      "fresnel_transmittance", py::vectorize([](double cos_theta, double eta) {
        return fresnel_transmittance(cos_theta, eta_cos_refracted(cos_theta, eta), eta);
      }),
      py::arg("cos_theta"), py::arg("eta"),
      R"doc(1 - r_eta: unpolarised transmittance at the outside cosine, 0 under total reflection.)doc");
  module.def(
      "orientation_density",
      [](const Paint& paint, const Array<double>& beta) {
        metallic_paint::validate(paint);
        const auto density = make_orientation(paint.orientation, paint.tilt);
        return py::vectorize([&](double angle) {
          const double half = std::sin(angle / 2);
          return orientation_density(density, half * half);
        })(beta);
      },
      py::arg("paint"), py::arg("beta"),
      R"doc(P(beta) of the paint's flakes, beta in rad, 0 to pi/2; P sin(beta) integrates to 1.)doc");
  module.def(
      "mean_projected_area",
      [](const Paint& paint, const Array<double>& cos_theta) {
        metallic_paint::validate(paint);
        const auto density = make_orientation(paint.orientation, paint.tilt);
        return py::vectorize([&](double cosine) { return mean_projected_area(density, cosine); })(
            cos_theta);
      },
      py::arg("paint"), py::arg("cos_theta"),
      R"doc(<s>, the mean projected area of a flake of unit area along a ray of that cosine (binder).)doc");
  module.def(
      "flake_brdf",
      [](const Paint& paint, const Array<double>& normal, const Array<double>& view,
         const Array<double>& light) {
        metallic_paint::validate(paint);
        for (const auto* array : {&normal, &view, &light}) {
          if (array->ndim() != 2 || array->shape(1) != 3 || array->shape(0) != normal.shape(0)) {
            throw py::value_error("normal, view and light must all have the shape (n, 3)");
          }
        }
        const Layer<double> layer = make_layer<double>(paint);
        py::array_t<double> brdf({normal.shape(0), py::ssize_t{3}});
        const auto row = [](const Array<double>& a, py::ssize_t i) {
          return Vec3<double>{a.at(i, 0), a.at(i, 1), a.at(i, 2)};
        };
        for (py::ssize_t i = 0; i < normal.shape(0); ++i) {
          const Rgb<double> f = flake_brdf(layer, row(normal, i), row(view, i), row(light, i));
          double* out = brdf.mutable_data(i, 0);
          out[0] = f.x, out[1] = f.y, out[2] = f.z;
        }
        return brdf;
      },
      py::arg("paint"), py::arg("normal"), py::arg("view"), py::arg("light"),
      R"doc(The mean of the sparkles as a BRDF, 1/sr: (n, 3) from unit vectors (n, 3).)doc");
}
