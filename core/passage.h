// SPDX-License-Identifier: Apache-2.0
//
// The way of a light through a point of the surface to the observer (paper, 5.3.1): refracted in
// and out, mirrored by a flake in between, dimmed by the layer. All species share it.
#pragma once

#include <algorithm>
#include <numbers>

#include "hot_spot.h"
#include "layer.h"
#include "light.h"
#include "orange_peel.h"
#include "outline.h"
#include "own_space.h"
#include "refraction.h"
#include "vector.h"

namespace metallic_paint {

// Where the paint is looked at. The view is a unit vector towards the observer.
template <class T>
struct SurfacePoint {
  Vec3<T> position, normal, view;
  T footprint;  // Sigma, area of the pixel's projection on the surface, m2
  int pixel_x, pixel_y;
  OwnSpace<T> own{};
  bool bends = false;       // whether a wave of the orange peel lies over it
  Vec3<T> waves{};          // what tilts normals there
  Vec3<T> wave{}, below{};  // its normal, and the view as under that
};

template <class T>
Vec3<T> view_below(const SurfacePoint<T>& point) {
  return point.bends ? point.below : point.view;
}

// The point with the wave of the paint's orange peel over it.
template <class T>
SurfacePoint<T> under_orange_peel(const Paint& paint, SurfacePoint<T> point) {
  if (!(paint.orange_peel > 0)) return point;
  point.bends = true;
  point.waves = waves_at(point.own.position, static_cast<T>(paint.orange_peel_mm) * T(0.001));
  point.wave = orange_peel(point.normal, point.waves, static_cast<T>(paint.orange_peel));
  point.below =
      through_wave(point.view, point.normal, point.wave, static_cast<T>(paint.binder_ior));
  return point;
}

// What the flakes of all species share: the way of a light through this point to the observer.
template <class T>
struct Passage {
  bool open = false;   // false: no flake can send this light to the observer
  bool given = false;  // the optical depth is: nothing is known of what hides a flake
  Mirror<Wide<T>> mirror{};
  Wide<T> inside{};        // the light's cone in the binder as the coat's roughness widens it, sr
  Wide<T> ratio{};         // of a smooth coat, over its cone outside
  Wide<T> surface{};       // transmittance of the surface, in and out
  T cos_exit{};            // cosine of the exit by which flakes cover the pixel
  T breadth{}, apart = 1;  // of the light
  Outline<T> outline{};    // of one that is flat
  Rgb<T> slant{};          // optical depth of the layer, there and back: t H
  BothWays<T> ways{};
};

// `slant` overrides the layer's own optical depth t H where it is given (validation against other
// codes).
template <class T>
Passage<T> pass_between(const Layer<T>& layer, const SurfacePoint<T>& point,
                        const SeenLight<T>& light, const Rgb<T>* slant = nullptr) {
  using W = Wide<T>;
  const W pi = std::numbers::pi_v<W>;
  Passage<T> way;
  const bool published = layer.radiometry == Radiometry::published;
  if (!light.visible || !(point.footprint > 0)) return way;
  const W eta = layer.eta;
  Vec3<W> direction = light.direction;
  if (point.bends) {
    direction = through_wave(direction, Vec3<W>(point.normal), Vec3<W>(point.wave), eta);
  }
  way.mirror = mirror_between(Vec3<W>(point.normal), Vec3<W>(view_below(point)), direction, eta);
  way.open = way.mirror.possible;  // a light or an observer below the surface: no sparkle
  if (!way.open) return way;
  const T cos_view_in = static_cast<T>(min(way.mirror.g_view / eta, W(1)));
  const T cos_light_in = static_cast<T>(min(way.mirror.g_light / eta, W(1)));
  way.cos_exit = published ? static_cast<T>(way.mirror.cos_view) : cos_view_in;
  way.breadth = light.breadth;
  way.apart = light.apart;

  // The light's cone in the binder (paper, eq. 7). Published: pi Delta_a^2; exact: the true solid
  // angle 4 pi sin^2(Delta_a/2).
  const W h = light.sin2_half_radius;
  const W outside = published ? pi * squared_angle(h) : 4 * pi * h;
  way.ratio = solid_angle_ratio(way.mirror.cos_light, way.mirror.g_light, eta);
  if (point.bends) {
    const W cosine = max(dot(Vec3<W>(point.wave), light.direction), W(0));
    const W g = eta_cos_refracted(cosine, eta);
    // The light is above the surface, and the wave neither turns its back on it nor mirrors all.
    way.open = cosine > 0 && g > 0 && dot(Vec3<W>(point.normal), light.direction) > W(kLeastCosine);
    if (!way.open) return way;
    way.ratio = solid_angle_ratio(cosine, g, eta);
  }
  way.inside = outside * way.ratio;
  if (light.radius > 0 && !published && !point.bends) {
    way.outline =
        outline_of(light, way.mirror, way.inside, Vec3<W>(point.normal), Vec3<W>(point.view), eta);
  }
  if (layer.haze > 0) {
    way.inside =
        way.inside +
        layer.haze * (solid_angle_of_facets(way.mirror.cos_view, way.mirror.g_view, eta) +
                      solid_angle_of_facets(way.mirror.cos_light, way.mirror.g_light, eta));
  }
  const T apart =
      ways_apart(point.normal, view_below(point), static_cast<T>(way.mirror.cos_view),
                 static_cast<T>(way.mirror.g_view), Vec3<T>(direction),
                 static_cast<T>(way.mirror.cos_light), static_cast<T>(way.mirror.g_light));
  if (slant != nullptr) {
    way.slant = *slant;
    way.given = true;
  } else {
    const Rgb<T> in = slant_depth_of(layer, cos_view_in), out = slant_depth_of(layer, cos_light_in);
    way.ways = both_ways(layer, in, out, apart);
    way.slant = there_and_back(layer, way.ways);
  }
  way.surface = fresnel_transmittance(way.mirror.cos_view, way.mirror.g_view, eta) *
                fresnel_transmittance(way.mirror.cos_light, way.mirror.g_light, eta);
  return way;
}

}  // namespace metallic_paint
