// SPDX-License-Identifier: Apache-2.0
//
// The whole paint's answer for a pixel: the coat over the flakes over what is scattered several
// times,
//   coat.reflected shine + coat.rest (sparkles + lobe + diffuse + glossy + returned),
// as the shader adds its closures. The sparkles are those of the listed lights, the lobe is the
// flakes' mean under all other light; closures stand here for what Cycles makes of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "composition.h"
#include "diffuse_lobe.h"
#include "facet_lobe.h"
#include "flake_brdf.h"
#include "flake_lobe.h"
#include "layer.h"
#include "light.h"
#include "mixture.h"
#include "orange_peel.h"
#include "paint.h"
#include "passage.h"
#include "phong_lobe.h"
#include "sparkles.h"
#include "texture.h"
#include "vector.h"

namespace metallic_paint {

// What no light has a part in.
template <class T>
struct Stack {
  SurfacePoint<T> at{};  // with the orange peel
  Coat<T> coat{};
  Vec3<T> coat_normal{};
  T coat_alpha{};  // of the coat's facets; 0: a mirror
  T facets{};      // reflectance of each facet
  Composition composition{};
  Rgb<T> diffuse{}, glossy{}, returned{};  // albedos of the mixture's lobes, textured
  T alpha = 1;                             // of the glossy one
  T exponent = 1;                          // of the returning one
  T glossy_exponent = 1;                   // of the glossy one
  Ramp<T> ramp{};                          // of the diffuse one
  T texture = 1;
  // 1 over their albedo: what scales the lobes of coat and mixture to reflect all.
  T coat_scale{}, glossy_scale{};
  T returned_scale = 1;  // likewise over the share of the returning lobe above the surface
};

// `coat_normal`: of the binder's surface, before the orange peel.
template <class T>
Stack<T> make_stack(const Paint& paint, const Layer<T>& layer, const SurfacePoint<T>& point,
                    Vec3<T> coat_normal) {
  Stack<T> stack;
  const T cos_view = seen_cosine(point.normal, point.view);
  const T roughness = static_cast<T>(paint.coat_roughness);
  stack.coat = make_coat(cos_view, roughness, layer.eta);
  stack.coat_alpha = roughness * roughness;
  stack.facets = facet_reflectance(cos_view, roughness, layer.eta);
  stack.composition = paint.composition;
  if (paint.composition == Composition::published && stack.coat_alpha > 0) {
    stack.coat.reflected = stack.facets;
  }
  // A coat whose normal is bent reflects elsewhere, and as much; so it lets as much through.
  stack.at = under_orange_peel(paint, point);
  T cos_below = cos_view;
  if (stack.at.bends) {
    cos_below = seen_cosine(point.normal, stack.at.below);
    const auto passed = [&](T cosine) {
      return fresnel_transmittance(cosine, eta_cos_refracted(cosine, layer.eta), layer.eta);
    };
    stack.coat.rest = stack.coat.rest * (passed(cos_view) / max(passed(cos_below), T(1e-20)));
  }
  stack.coat_normal = coat_normal;
  if (paint.orange_peel > 0) {
    stack.coat_normal = orange_peel(coat_normal, stack.at.waves, static_cast<T>(paint.orange_peel));
  }
  if (dot(stack.coat_normal, point.normal) < T(0.999999)) {
    stack.coat_normal = above_surface(stack.coat_normal, point.normal, point.view);
  }
  const Mixture<T> scattered = mixture(layer, Rgb<T>(paint.substrate_color), cos_below);
  stack.diffuse = scattered.diffuse;
  stack.glossy = scattered.glossy;
  stack.returned = scattered.returned;
  stack.alpha = scattered.alpha;
  stack.exponent = scattered.exponent;
  stack.returned_scale = 1 / scattered.above;
  stack.glossy_exponent = glossy_exponent(scattered.alpha);
  stack.glossy_scale = 1 / phong_albedo(cos_view, stack.glossy_exponent);
  stack.ramp = make_ramp(layer);
  // What the sparkles outshine is Lambertian, as published.
  if (paint.composition == Composition::published) {
    stack.diffuse = stack.diffuse + stack.glossy + stack.returned;
    stack.glossy = {};
    stack.returned = {};
  }
  if (paint.texture_contrast > 0) {
    stack.texture =
        texture_at(layer, point, static_cast<T>(paint.texture_contrast), paint.frame, paint.seed);
  }
  // The sparkles were compared with the highlight of single facets, which are not scaled.
  const T cos_coat = min(dot(stack.coat_normal, point.view), T(1));
  if (stack.coat_alpha > 0 && cos_coat > 0) {
    stack.coat_scale = 1;
    if (paint.composition == Composition::exact) {
      stack.coat_scale = 1 / facet_lobe_albedo(cos_coat, stack.coat_alpha);
    }
  }
  stack.diffuse = stack.diffuse * stack.texture;
  stack.glossy = stack.glossy * stack.texture;
  stack.returned = stack.returned * stack.texture;
  return stack;
}

// About it the returning lobe mirrors the view: near the view, leaning to the normal.
template <class T>
Vec3<T> returning_normal(Vec3<T> normal, Vec3<T> view) {
  const Vec3<T> sum = view + normal * T(kLean);
  return sum * (1 / length(sum));
}

// f cos(theta') of the diffuse, the glossy and the returning lobe, 1/sr. As published the diffuse
// one is Lambertian.
template <class T>
Rgb<T> scattered_by(const Stack<T>& stack, const SurfacePoint<T>& point, Vec3<T> light) {
  const T cos_light = max(dot(point.normal, light), T(0));
  Rgb<T> shape = grey(cos_light);
  if (stack.composition == Composition::exact) shape = ramp_at(stack.ramp, cos_light);
  const T lobe =
      phong_lobe(point.normal, point.view, light, stack.glossy_exponent) * stack.glossy_scale;
  const T returned =
      phong_lobe(returning_normal(point.normal, point.view), point.view, light, stack.exponent) *
      stack.returned_scale;
  return stack.diffuse * (shape / std::numbers::pi_v<T>)+stack.glossy * lobe +
         stack.returned * returned;
}

// coat.reflected shine: the coat's highlight per unit of the irradiance on a plane normal to the
// light, whose radius counts where the coat is a mirror.
template <class T>
T coat_shine(const Stack<T>& stack, const SurfacePoint<T>& point, Vec3<T> light,
             T sin2_half_radius) {
  if (!(stack.coat_alpha > 0)) {
    return highlight(stack.coat_normal, point.view, light, sin2_half_radius, T(0),
                     stack.coat.reflected);
  }
  if (!(dot(point.normal, light) > 0)) return 0;
  return stack.coat.reflected * stack.coat_scale *
         facet_lobe(stack.coat_normal, point.view, light, stack.coat_alpha);
}

// What a pixel shows of one listed light, per unit of its irradiance on a plane normal to it, 1/sr.
template <class T>
struct Shade {
  Rgb<T> sparkles{};   // as they join the rest: of Composition::published, what they outshine it by
  Rgb<T> scattered{};  // by the mixture's lobes
  T shine{};           // of the coat
  Rgb<T> radiance{};   // shine + coat.rest (sparkles + scattered)
};

// `sparkles`: the radiance T of this light's sparkles, drawn or in the mean.
template <class T>
Shade<T> shade(const Stack<T>& stack, const SurfacePoint<T>& point, const SeenLight<T>& light,
               Rgb<T> sparkles) {
  const Vec3<T> direction(light.direction);
  const T sin2_half_radius = static_cast<T>(light.sin2_half_radius);
  Shade<T> found;
  found.scattered = scattered_by(stack, point, direction);
  found.shine = coat_shine(stack, point, direction, sin2_half_radius);
  found.sparkles = sparkles;
  if (stack.composition == Composition::published) {
    const T cos_light = max(dot(point.normal, direction), T(0));
    const T outshone = highlight(stack.coat_normal, point.view, direction, sin2_half_radius,
                                 stack.coat_alpha, stack.facets);
    found.sparkles = greatest(sparkles, stack.diffuse * (cos_light / std::numbers::pi_v<T>)+grey(
                                                            outshone / stack.coat.rest));
  }
  found.radiance = grey(found.shine) + (found.sparkles + found.scattered) * stack.coat.rest;
  return found;
}

// f cos(theta') of the paint under any other light, 1/sr: the flakes in their mean. A coat without
// roughness is a mirror besides, of the reflectance coat.reflected about coat_normal.
template <class T>
Rgb<T> reflectance(const Layer<T>& layer, const Stack<T>& stack, const SurfacePoint<T>& point,
                   Vec3<T> light) {
  const T cos_light = dot(point.normal, light);
  if (!(cos_light > 0)) return {};
  Vec3<T> below = light;
  T flux = cos_light;  // of the light in the binder, that of the solid angle outside
  if (stack.at.bends) {
    below = through_wave(light, point.normal, stack.at.wave, layer.eta);
    const T cosine = max(dot(stack.at.wave, light), T(0)), even = dot(point.normal, below);
    const T g = eta_cos_refracted(cosine, layer.eta);
    flux = g > 0 ? cosine * eta_cos_refracted(even, layer.eta) / g : T(0);
  }
  const Rgb<T> lobe = flake_brdf(layer, point.normal, view_below(stack.at), below) * flux;
  const T shine = stack.coat_alpha > 0 ? coat_shine(stack, point, light, T(0)) : T(0);
  return grey(shine) + (lobe + scattered_by(stack, point, light)) * stack.coat.rest;
}

// E: the integral of flake_brdf cos(theta') over the lights, by flakes that stand for all. Their
// two deviates are Fibonacci's lattice: near the normal all flakes beyond some tilt mirror under
// the critical angle, and a grid's rows lie on either side of it as a whole. Error 2e-4 at most
// (300 paints of one to three species, tilts to 1, IOR to 2.5, against 317811 points: 1.1e-4).
template <class T>
Rgb<T> flake_albedo(const Layer<T>& layer, Vec3<T> normal, Vec3<T> view) {
  constexpr int points = 10946, generator = 6765;
  Rgb<T> sum{};
  for (int i = 0; i < points; ++i) {
    const T tilt = (static_cast<T>(i) + T(0.5)) / points;
    const T azimuth = (static_cast<T>(i * generator % points) + T(0.5)) / points;
    sum = sum + sample_flake(layer, normal, view, tilt, azimuth).weight;
  }
  return sum / T(points);
}

// The radiance of the paint under a world of radiance 1: r_s + E + M in a smooth coat.
template <class T>
Rgb<T> directional_albedo(const Layer<T>& layer, const Stack<T>& stack,
                          const SurfacePoint<T>& point) {
  T reflected = stack.coat.reflected;
  if (stack.composition == Composition::published && stack.coat_alpha > 0) {
    const T cosine = clamp(dot(stack.coat_normal, point.view), T(0), T(1));
    reflected = cosine > 0 ? reflected * facet_lobe_albedo(cosine, stack.coat_alpha) : T(0);
  }
  const Rgb<T> below = flake_albedo(layer, point.normal, view_below(stack.at)) + stack.diffuse +
                       stack.glossy + stack.returned;
  return grey(reflected) + below * stack.coat.rest;
}

}  // namespace metallic_paint
