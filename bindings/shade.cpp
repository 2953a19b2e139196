// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "batch.h"
#include "module.h"
#include "places.h"
#include "validation.h"
#include "whole_paint.h"

namespace py = pybind11;
using namespace metallic_paint;

namespace {

// Places, and the normals of the coat there.
struct CoatedPlaces : Places {
  py::array coat_normal;

  CoatedPlaces(const Places& places, py::handle coat_normals)
      : Places(places),
        coat_normal(coat_normals.is_none() ? normal
                                           : singles_or_doubles("coat_normal", coat_normals)) {
    require_shape("coat_normal", coat_normal, {size(), 3});
    validate(batch());
    for (std::size_t i = 0; i < static_cast<std::size_t>(size()); ++i) {
      const Vec3<double> bent = coat(i);
      const double square = dot(bent, bent);
      if (!(square == 0 || is_unit(square))) require_unit(at_row("coat_normal", i), bent);
    }
  }

  SurfacePoint<double> point(std::size_t i) const { return point_at<double>(batch(), i); }
  Vec3<double> coat(std::size_t i) const { return vector_at<double>(column_of(coat_normal), i); }
  bool has_surface(std::size_t i) const {
    const SurfacePoint<double> at = point(i);
    return length(at.normal) > 0 && length(at.view) > 0 && length(coat(i)) > 0;
  }
};

void store(double* array, std::size_t i, Rgb<double> value) {
  array[3 * i] = value.x;
  array[3 * i + 1] = value.y;
  array[3 * i + 2] = value.z;
}

py::array_t<double> zeros(const std::vector<py::ssize_t>& shape) {
  py::array_t<double> array(shape);
  std::fill_n(array.mutable_data(), array.size(), 0.0);
  return array;
}

py::dict shade_pixels(py::handle one_paint, py::handle some_lights, py::handle position,
                      py::handle normal, py::handle view, py::handle footprint, py::handle pixel,
                      py::handle own_position, py::handle own_axes, py::handle instance,
                      py::handle coat_normal) {
  const Paint& given = object_of<Paint>("paint", one_paint);
  const std::vector<Light<double>> lights = lights_of(some_lights);
  const CoatedPlaces places(
      Places(position, normal, view, footprint, pixel, own_position, own_axes, instance),
      coat_normal);
  const std::shared_ptr<const PreparedPaint> prepared = prepared_paint(given);
  const Paint& paint = prepared->paint;
  const py::ssize_t n = places.size(), m = static_cast<py::ssize_t>(lights.size());
  const std::vector<py::ssize_t> each{n, m, 3};
  py::array_t<double> radiance = zeros(each), mean = zeros(each), sparkles = zeros(each),
                      scattered = zeros(each), shine = zeros({n, m}), reflected = zeros({n}),
                      rest = zeros({n}), diffuse = zeros({n, 3}), glossy = zeros({n, 3}),
                      returned = zeros({n, 3}), alpha = zeros({n}), texture = zeros({n}),
                      bent = zeros({n, 3});
  double *to_radiance = radiance.mutable_data(), *to_mean = mean.mutable_data(),
         *to_sparkles = sparkles.mutable_data(), *to_scattered = scattered.mutable_data(),
         *to_shine = shine.mutable_data(), *to_reflected = reflected.mutable_data(),
         *to_rest = rest.mutable_data(), *to_diffuse = diffuse.mutable_data(),
         *to_glossy = glossy.mutable_data(), *to_returned = returned.mutable_data(),
         *to_alpha = alpha.mutable_data(), *to_texture = texture.mutable_data(),
         *to_bent = bent.mutable_data();
  interruptible([&](const std::stop_token& stop) {
    const Layer<double> layer = layer_under(prepared->as_double, places.batch());
    const double turned = turned_by(layer);
    const auto shade_one = [&](std::size_t i) {
      if (!places.has_surface(i)) return;
      const SurfacePoint<double> point = places.point(i);
      const Stack<double> stack = make_stack(paint, layer, point, places.coat(i));
      to_reflected[i] = stack.coat.reflected;
      to_rest[i] = stack.coat.rest;
      to_alpha[i] = stack.alpha;
      to_texture[i] = stack.texture;
      store(to_diffuse, i, stack.diffuse);
      store(to_glossy, i, stack.glossy);
      store(to_returned, i, stack.returned);
      store(to_bent, i, stack.coat_normal);
      const SlotView<double> slots = view_slots(lights, point, turned);
      const auto firsts = look_close(layer, stack.at, paint.frame, paint.seed);
      const auto cell = cell_of_counts(layer, stack.at, firsts, paint.frame, paint.seed);
      std::array<PixelSparkles<double>, kLightSlots> drawn;
      for (std::size_t k = 0; k < lights.size(); ++k) {
        const int leader = slots.leader[k];
        if (leader < 0) continue;
        // The leader comes first: a light of its group shows the same sparkles.
        const auto lead = static_cast<std::size_t>(leader);
        if (lead == k) {
          drawn[k] =
              sparkle(layer, stack.at, firsts, cell, pass_between(layer, stack.at, slots.seen[k]),
                      leader, paint.frame, paint.seed);
        }
        const auto found = shade(stack, point, slots.seen[k], drawn[lead].radiance);
        const std::size_t at = i * lights.size() + k;
        to_shine[at] = found.shine;
        store(to_sparkles, at, found.sparkles);
        store(to_scattered, at, found.scattered);
        store(to_radiance, at, found.radiance);
        store(to_mean, at, shade(stack, point, slots.seen[k], drawn[lead].mean_radiance).radiance);
      }
    };
    parallel_for(static_cast<std::size_t>(n), shade_one, 1024, stop);
  });
  py::dict all;
  all["radiance"] = radiance;
  all["mean_radiance"] = mean;
  all["sparkles"] = sparkles;
  all["scattered"] = scattered;
  all["shine"] = shine;
  all["coat_reflected"] = reflected;
  all["coat_rest"] = rest;
  all["coat_normal"] = bent;
  all["diffuse"] = diffuse;
  all["glossy"] = glossy;
  all["returned"] = returned;
  all["alpha"] = alpha;
  all["texture"] = texture;
  return all;
}

py::dict reflect_light(py::handle one_paint, py::handle directions, py::handle position,
                       py::handle normal, py::handle view, py::handle footprint, py::handle pixel,
                       py::handle own_position, py::handle own_axes, py::handle instance,
                       py::handle coat_normal) {
  const CoatedPlaces places(
      Places(position, normal, view, footprint, pixel, own_position, own_axes, instance),
      coat_normal);
  const Paint& given = object_of<Paint>("paint", one_paint);
  const Array<double> light = numbers("light", directions);
  require_rows_of_3("light", light);
  const std::shared_ptr<const PreparedPaint> prepared = prepared_paint(given);
  const Paint& paint = prepared->paint;
  const auto towards = [&light](std::size_t k) {
    const double* v = light.data() + 3 * k;
    return Vec3<double>{v[0], v[1], v[2]};
  };
  const py::ssize_t n = places.size(), m = light.shape(0);
  const auto lights = static_cast<std::size_t>(m);
  for (std::size_t k = 0; k < lights; ++k) validate_direction("light", k, towards(k));
  py::array_t<double> reflectances = zeros({n, m, 3}), mirror = zeros({n}), albedo = zeros({n, 3});
  double *to_reflectance = reflectances.mutable_data(), *to_mirror = mirror.mutable_data(),
         *to_albedo = albedo.mutable_data();
  interruptible([&](const std::stop_token& stop) {
    const Layer<double> layer = layer_under(prepared->as_double, places.batch());
    const auto reflect_one = [&](std::size_t i) {
      if (!places.has_surface(i)) return;
      const SurfacePoint<double> point = places.point(i);
      const Stack<double> stack = make_stack(paint, layer, point, places.coat(i));
      if (!(stack.coat_alpha > 0)) to_mirror[i] = stack.coat.reflected;
      store(to_albedo, i, directional_albedo(layer, stack, point));
      for (std::size_t k = 0; k < lights; ++k) {
        store(to_reflectance, i * lights + k, reflectance(layer, stack, point, towards(k)));
      }
    };
    parallel_for(static_cast<std::size_t>(n), reflect_one, 1, stop);
  });
  py::dict all;
  all["reflectance"] = reflectances;
  all["mirror"] = mirror;
  all["albedo"] = albedo;
  return all;
}

}  // namespace

void bind_shade(py::module_& module) {
  module.def("shade", &shade_pixels, py::arg("paint"), py::arg("lights"), py::kw_only(),
             py::arg("position"), py::arg("normal"), py::arg("view"), py::arg("footprint"),
             py::arg("pixel"), py::arg("own_position") = py::none(),
             py::arg("own_axes") = py::none(), py::arg("instance") = py::none(),
             py::arg("coat_normal") = py::none(),
             R"doc(The whole paint under up to 8 listed lights in n pixels, on all cores.

Places as in evaluate; coat_normal (n, 3): unit normals of the coat where they are others, before
the orange peel, whose waves are fixed to the own space.

A dict. Over pixels and lights, per unit of the light's irradiance on a plane normal to it, 1/sr:
sparkles (n, m, 3), as Composition joins them; scattered (n, m, 3), the mixture's lobes;
shine (n, m), the coat's; radiance = shine + coat_rest (sparkles + scattered), and mean_radiance,
the same with the sparkles' mean. 0 where a light is below the surface. A light is narrow against
the lobes; its radius counts where a coat without roughness mirrors it.
Over pixels: coat_reflected, coat_rest, texture and alpha (n,), diffuse, glossy and returned (n, 3),
the albedos of the mixture's lobes with the texture, alpha the glossy one's roughness; coat_normal
(n, 3), with the orange peel.)doc");
  module.def("reflectance", &reflect_light, py::arg("paint"), py::arg("light"), py::kw_only(),
             py::arg("position"), py::arg("normal"), py::arg("view"), py::arg("footprint"),
             py::arg("pixel"), py::arg("own_position") = py::none(),
             py::arg("own_axes") = py::none(), py::arg("instance") = py::none(),
             py::arg("coat_normal") = py::none(),
             R"doc(The whole paint under light that is not listed: world, area lights, neighbours.

light (m, 3): unit vectors towards it; places as in shade.

A dict: reflectance (n, m, 3), f cos(theta'), 1/sr, times radiance and solid angle what that light
adds, with the flakes in their mean; mirror (n,), what a coat without roughness reflects besides, as
a mirror about shade's coat_normal; albedo (n, 3), the radiance under a world of radiance 1, to
0.003 the integral of both.)doc");
}
