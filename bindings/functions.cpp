// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <array>
#include <numbers>
#include <vector>

#include "flake_brdf.h"
#include "mixture.h"
#include "module.h"
#include "paint.h"
#include "poisson.h"
#include "random.h"
#include "texture.h"
#include "validation.h"

namespace py = pybind11;
using namespace metallic_paint;

namespace {

// Calls work(i) for each i below n without the interpreter's lock. Few are done before anyone could
// press a key.
void each_element(py::ssize_t n, const auto& work) {
  const auto until_stopped = [&](const std::stop_token& stop) {
    for (py::ssize_t i = 0; i < n && !stop.stop_requested(); ++i) work(i);
  };
  interruptible(until_stopped, n <= 1 << 10);
}

// f(i) in the shape of an array; of one without dimensions a number.
py::object each_result(const Array<double>& shape, const auto& f) {
  py::array_t<double> results(
      std::vector<py::ssize_t>(shape.shape(), shape.shape() + shape.ndim()));
  double* to = results.mutable_data();
  each_element(results.size(), [&](py::ssize_t i) { to[i] = f(i); });
  return shape.ndim() == 0 ? py::object(py::float_(*to)) : results;
}

}  // namespace

// The pieces of the model, element by element over arrays that broadcast.
void bind_functions(py::module_& module) {
  module.def(
      "white_noise",
      [](py::handle positions, py::handle ws) {
        const Array<double> position = numbers("position", positions), w = numbers("w", ws);
        require_rows_of_3("position", position);
        require_shape("w", w, {position.shape(0)});
        py::array_t<double> colours({position.shape(0), py::ssize_t{3}});
        double* to = colours.mutable_data();
        each_element(position.shape(0), [&](py::ssize_t i) {
          const double* at = position.data() + 3 * i;
          const auto x = static_cast<float>(at[0]), y = static_cast<float>(at[1]),
                     z = static_cast<float>(at[2]), word = static_cast<float>(w.data()[i]);
          double* out = to + 3 * i;
          out[0] = hash_value(x, y, z, word);
          out[1] = hash_value(z, x, word, y);
          out[2] = hash_value(word, z, y, x);
        });
        return colours;
      },
      py::arg("position"), py::arg("w"),
      R"doc(The Color of Blender's White Noise node in 4D, of which all deviates are made (core/random.h).

position (n, 3), w (n,): numbers, as single floats. Returns float64 (n, 3) from 0 to 1.)doc");
  module.def(
      "count_deviate",
      [](py::handle mean, py::handle slots, py::handle uniform) {
        const auto all = broadcast(
            "mean, slots and uniform",
            {numbers("mean", mean), numbers("slots", slots), numbers("uniform", uniform)});
        const double *m = all[0].data(), *k = all[1].data(), *u = all[2].data();
        return each_result(all[0], [&](py::ssize_t i) {
          const double one_mean = m[i], one_slots = k[i], one_uniform = u[i];
          validate_count(one_mean, one_slots, one_uniform);
          return draw_count(one_mean, static_cast<int>(one_slots), one_uniform).number;
        });
      },
      py::arg("mean"), py::arg("slots"), py::arg("uniform"),
      R"doc(How many sparkles a pixel has, for a uniform deviate (paper, step 3; law: core/poisson.h).

mean: expected count, from 0, infinity included; slots: 0 for a Poisson count, 1 to 16 for a
binomial one of as many places; uniform: above 0, at most 1. Up to a mean of 2 the count is exact
but for more than 6 sparkles, above it a rounded normal deviate with the law's skewness. The three
broadcast. Returns whole float64 numbers of the common shape; they fall as uniform rises.)doc");
  module.def(
      "normal_quantile",
      [](py::handle probability) {
        const Array<double> all = numbers("probability", probability);
        return each_result(all, [&](py::ssize_t i) {
          const double p = all.data()[i];
          validate_probability(p);
          return normal_quantile(p);
        });
      },
      py::arg("probability"), R"doc(The standard normal deviate x with Phi(x) = probability.

probability: above 0, at most 1, of any shape. Returns float64 of that shape; finite for 1 as well.)doc");
  module.def(
      "fresnel_transmittance",
      [](py::handle cos_theta, py::handle eta) {
        const auto all =
            broadcast("cos_theta and eta", {numbers("cos_theta", cos_theta), numbers("eta", eta)});
        const double *cosines = all[0].data(), *etas = all[1].data();
        return each_result(all[0], [&](py::ssize_t i) {
          const double cosine = cosines[i], one_eta = etas[i];
          validate_cosine(cosine);
          validate_eta(one_eta);
          return fresnel_transmittance(cosine, eta_cos_refracted(cosine, one_eta), one_eta);
        });
      },
      py::arg("cos_theta"), py::arg("eta"),
      R"doc(1 - r_eta, the unpolarised transmittance of the binder's surface (Fresnel).

cos_theta: cosine outside the binder, 0 to 1; eta: index of the binder relative to the outside, 0.1
to 10. The two broadcast. Returns float64 from 0 (total reflection) to 1.)doc");
  module.def(
      "orientation_density",
      [](py::handle one_paint, py::handle beta) {
        const Paint& paint = object_of<Paint>("paint", one_paint);
        metallic_paint::validate(paint);
        const auto density = make_orientation(paint.orientation, paint.tilt);
        const Array<double> angles = numbers("beta", beta);
        return each_result(angles, [&](py::ssize_t i) {
          const double angle = angles.data()[i];
          validate_beta(angle);
          const double half = std::sin(angle / 2);
          return orientation_density(density, half * half);
        });
      },
      py::arg("paint"), py::arg("beta"),
      R"doc(P(beta), the density of the tilt of the flakes of a paint's first species (paper, 5.3.1).

beta: angle between a flake's normal and the paint's, 0 to pi/2 rad, of any shape. Returns float64
of that shape, 1/rad; P(beta) sin(beta) integrates to 1 over beta.)doc");
  module.def(
      "mean_projected_area",
      [](py::handle one_paint, py::handle cos_theta) {
        const Paint& paint = object_of<Paint>("paint", one_paint);
        metallic_paint::validate(paint);
        const auto density = make_orientation(paint.orientation, paint.tilt);
        const Array<double> cosines = numbers("cos_theta", cos_theta);
        return each_result(cosines, [&](py::ssize_t i) {
          const double cosine = cosines.data()[i];
          validate_cosine(cosine);
          return mean_projected_area(density, cosine);
        });
      },
      py::arg("paint"), py::arg("cos_theta"),
      R"doc(<s>, the mean projected area of a flake of unit area along a ray (paper, 5.3.3).

cos_theta: cosine of the ray to the paint's normal, in the binder, 0 to 1, of any shape. Returns
float64 of that shape, 0 to 1, for the flakes of the paint's first species.)doc");
  module.def(
      "flake_brdf",
      [](py::handle one_paint, py::handle normals, py::handle views, py::handle lights) {
        const Paint& paint = object_of<Paint>("paint", one_paint);
        metallic_paint::validate(paint);
        const Array<double> normal = numbers("normal", normals), view = numbers("view", views),
                            light = numbers("light", lights);
        require_rows_of_3("normal", normal);
        require_shape("view", view, {normal.shape(0), 3});
        require_shape("light", light, {normal.shape(0), 3});
        const Layer<double> layer = make_layer<double>(paint);
        py::array_t<double> brdf({normal.shape(0), py::ssize_t{3}});
        double* to = brdf.mutable_data();
        const auto unit = [](const char* field, const Array<double>& a, py::ssize_t i) {
          const double* row = a.data() + 3 * i;
          const Vec3<double> direction{row[0], row[1], row[2]};
          validate_direction(field, static_cast<std::size_t>(i), direction);
          return direction;
        };
        each_element(normal.shape(0), [&](py::ssize_t i) {
          const Vec3<double> n = unit("normal", normal, i), v = unit("view", view, i),
                             l = unit("light", light, i);
          const Rgb<double> f = flake_brdf(layer, n, v, l);
          double* out = to + 3 * i;
          out[0] = f.x, out[1] = f.y, out[2] = f.z;
        });
        return brdf;
      },
      py::arg("paint"), py::arg("normal"), py::arg("view"), py::arg("light"),
      R"doc(The mean of the sparkles as a BRDF, of all species; derivation: core/flake_brdf.h.

normal, view, light (n, 3): unit vectors, view and light away from the surface. Returns (n, 3), RGB
in 1/sr; 0 where view or light is below the surface.)doc");
  module.def(
      "library_coating",
      [](py::handle kinds, py::handle thickness_nm, py::handle cos_alpha) {
        const Array<std::int32_t> kind = whole_numbers("coating", kinds);
        const Array<double> nm = numbers("coating_nm", thickness_nm),
                            cosine = numbers("cos_alpha", cos_alpha);
        const py::ssize_t size = kind.size();
        require_shape("coating", kind, {size});
        require_shape("coating_nm", nm, {size});
        require_shape("cos_alpha", cosine, {size});
        py::array_t<float> colours({py::ssize_t{2}, size, py::ssize_t{3}});
        float* to = colours.mutable_data();
        each_element(size, [&](py::ssize_t i) {
          // Each is read once: whoever has the lock now may write to it.
          const int one_kind = kind.data()[i];
          const double one_nm = nm.data()[i], one_cosine = cosine.data()[i];
          require_library_coating("coating", one_kind, one_nm);
          require_range(at_row("cos_alpha", static_cast<std::size_t>(i)), one_cosine, 0, 1);
          Coating<float> coating{};
          coating.kind = static_cast<CoatingKind>(one_kind);
          coating.thickness_nm = static_cast<float>(one_nm);
          const auto c = static_cast<float>(one_cosine);
          const Rgb<float> both[2] = {coating_reflectance(coating, c),
                                      coating_transmittance(coating, c)};
          for (py::ssize_t j = 0; j < 2; ++j) {
            float* out = to + 3 * (j * size + i);
            out[0] = both[j].x, out[1] = both[j].y, out[2] = both[j].z;
          }
        });
        return colours;
      },
      py::arg("coating"), py::arg("coating_nm"), py::arg("cos_alpha"),
      R"doc(Reflectance and transmittance of the library's coatings, as the shader has them.

coating (n,): 1 to 14, CoatingKind in core/coating.h; coating_nm (n,): thickness of a pearl's film,
0 to 200 nm, of no effect on a metal; cos_alpha (n,): cosine of the ray to the flake's normal, in
the binder, 0 to 1. Returns float32 (2, n, 3): reflectance, then transmittance, RGB from 0 to 1.)doc");
  module.def(
      "pixel_texture",
      [](py::handle contrasts, py::handle footprints, py::handle xs, py::handle ys,
         py::handle frames, py::handle seeds) {
        const double contrast = from_python<double>("contrast", contrasts, kNumber);
        require_range("contrast", contrast, 0, 1);
        const Array<double> footprint = numbers("footprint", footprints);
        const Array<std::int32_t> x = whole_numbers("x", xs), y = whole_numbers("y", ys);
        require_one_dimension("footprint", footprint);
        require_shape("x", x, {footprint.size()});
        require_shape("y", y, {footprint.size()});
        const int frame = from_python<int>("frame", frames, kInt32);
        const int seed = from_python<int>("seed", seeds, kInt32);
        py::array_t<float> factor(footprint.size());
        float* to = factor.mutable_data();
        each_element(footprint.size(), [&](py::ssize_t i) {
          const double area = footprint.data()[i];
          require_range(at_row("footprint", static_cast<std::size_t>(i)), area, 0, 1e30, " m2");
          to[i] = pixel_texture(static_cast<float>(contrast), static_cast<float>(area), x.data()[i],
                                y.data()[i], frame, seed);
        });
        return factor;
      },
      py::arg("contrast"), py::arg("footprint"), py::arg("x"), py::arg("y"), py::kw_only(),
      py::arg("frame") = 0, py::arg("seed") = 0,
      R"doc(The factor by which light scattered several times varies from pixel to pixel (paper, 5.1 and 5.2).

contrast: relative standard deviation over 1 mm2, 0 to 1; footprint (n,): area of the pixel on the
surface, 0 to 1e30 m2; x, y (n,): whole pixel coordinates; frame and seed: 32-bit integers. Returns
float32 (n,), as the shader has it, with a mean of 1.)doc");
  module.def(
      "mixture",
      [](py::handle one_paint, py::handle substrates, py::handle cos_view) {
        const Paint& paint = object_of<Paint>("paint", one_paint);
        metallic_paint::validate(paint);
        const Rgb<double> substrate = three_numbers("substrate", substrates);
        require_colour("substrate", substrate, 1);
        const Layer<double> layer = make_layer<double>(paint);
        const Array<double> cosines = numbers("cos_view", cos_view);
        std::vector<py::ssize_t> shape(cosines.shape(), cosines.shape() + cosines.ndim());
        py::array_t<double> alpha(shape), exponent(shape), above(shape);
        shape.push_back(3);
        py::array_t<double> diffuse(shape), glossy(shape), returned(shape);
        double *to_diffuse = diffuse.mutable_data(), *to_glossy = glossy.mutable_data(),
               *to_returned = returned.mutable_data(), *to_alpha = alpha.mutable_data(),
               *to_exponent = exponent.mutable_data(), *to_above = above.mutable_data();
        each_element(cosines.size(), [&](py::ssize_t i) {
          const double cosine = cosines.data()[i];
          require_range("cos_view", cosine, 0, 1);
          const Mixture<double> m = mixture(layer, substrate, cosine);
          for (const double x : {m.diffuse.x, m.diffuse.y, m.diffuse.z}) *to_diffuse++ = x;
          for (const double x : {m.glossy.x, m.glossy.y, m.glossy.z}) *to_glossy++ = x;
          for (const double x : {m.returned.x, m.returned.y, m.returned.z}) *to_returned++ = x;
          to_alpha[i] = m.alpha;
          to_exponent[i] = m.exponent;
          to_above[i] = m.above;
        });
        py::dict found;
        found["diffuse"] = diffuse;
        found["glossy"] = glossy;
        found["returned"] = returned;
        found["alpha"] = alpha;
        found["exponent"] = exponent;
        found["above"] = above;
        return found;
      },
      py::arg("paint"), py::arg("substrate"), py::arg("cos_view"),
      R"doc(What neither the binder's surface nor a single flake reflects, as three lobes (fit: core/mixture.h).

substrate (3,): albedo of the Lambertian substrate, RGB from 0 to 1; cos_view (...): cosines of the
view outside the binder, 0 to 1. Returns a dict: diffuse (..., 3), the albedo of the diffuse lobe,
of substrate and pigment; glossy (..., 3), that of a lobe about the mirror direction, of several
flakes; returned (..., 3), that of a lobe about the view, of what leaves by the hole among
the flakes that it came in by; alpha (...), the roughness of the glossy lobe, which is cos^n with n =
(1/alpha^2 - 1)/2; exponent (...) of the returning one, and above (...), its share above the surface.)doc");
}
