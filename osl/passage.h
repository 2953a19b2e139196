// SPDX-License-Identifier: Apache-2.0
//
// The way of a light through a point of the surface to the observer: see core/passage.h.
#pragma once

#include "hot_spot.h"
#include "layer.h"
#include "light.h"
#include "orange_peel.h"
#include "outline.h"
#include "own_space.h"
#include "refraction.h"

struct SurfacePoint {
  point position;
  vector n;
  vector view;
  float footprint;
  // Towards the observer, under the surface:
  float cos_in;
  color areas;  // mean projected area of each species' flakes
  color slant;  // optical depth of the layer
  int pixel_x;
  int pixel_y;
  OwnSpace own;
  LatticePlane plane;  // of that and n
  int bends;  // whether a wave of the orange peel lies over it
  vector waves;  // what tilts normals there
  vector wave;  // its normal
  vector below;  // the view as under that
};

struct Passage {
  int open;
  Mirror mirror;
  float inside;
  float ratio;
  float surface_transmittance;
  float cos_exit;
  float breadth;
  float apart;
  Outline outline;
  color slant;
  BothWays ways;
};

// `flat`: whether any listed light is.
Passage pass_between(Layer layer, float library[], SurfacePoint surface, SeenLight light, int flat)
{
  Passage way;
  way.open = 0;
  way.inside = 0.0;
  way.ratio = 1.0;
  way.surface_transmittance = 0.0;
  way.cos_exit = 1.0;
  way.slant = color(0.0);
  way.breadth = light.breadth;
  way.apart = light.apart;
  way.mirror.possible = 0;
  way.outline.given = 0;
  if (!light.visible || !(surface.footprint > 0.0))
    return way;
  float eta = layer.eta;
  vector direction = light.direction;
  if (surface.bends)
    direction = through_wave(direction, surface.n, surface.wave, eta);
  way.mirror = mirror_between(surface.n, surface.below, direction, eta);
  way.open = way.mirror.possible;
  if (!way.open)
    return way;
  float cos_view_in = min(way.mirror.g_view / eta, 1.0);
  float cos_light_in = min(way.mirror.g_light / eta, 1.0);
  way.cos_exit = cos_view_in;
  if (layer.radiometry == RADIOMETRY_PUBLISHED)
    way.cos_exit = way.mirror.cos_view;

  float outside = 4.0 * M_PI * light.sin2_half_radius;
  if (layer.radiometry == RADIOMETRY_PUBLISHED)
    outside = M_PI * squared_angle(light.sin2_half_radius);
  way.ratio = solid_angle_ratio(way.mirror.cos_light, way.mirror.g_light, eta);
  if (surface.bends) {
    float cosine = max(inner_product(surface.wave, light.direction), 0.0);
    float g = eta_cos_refracted(cosine, eta);
    way.open = cosine > 0.0 && g > 0.0 && inner_product(surface.n, light.direction) > LEAST_COSINE;
    if (!way.open)
      return way;
    way.ratio = solid_angle_ratio(cosine, g, eta);
  }
  way.inside = outside * way.ratio;
  if (flat && light.radius > 0.0 && layer.radiometry == RADIOMETRY_EXACT && !surface.bends)
    way.outline = outline_of(light, way.mirror, way.inside, surface.n, surface.view, eta);
  if (layer.haze > 0.0)
    way.inside = way.inside + layer.haze * (solid_angle_of_facets(way.mirror.cos_view, way.mirror.g_view, eta) +
                                            solid_angle_of_facets(way.mirror.cos_light, way.mirror.g_light, eta));
  float apart = ways_apart(surface.n, surface.below, way.mirror.cos_view, way.mirror.g_view, direction,
                           way.mirror.cos_light, way.mirror.g_light);
  color out = slant_depth_of(layer, library, cos_light_in);
  way.ways = both_ways(layer, surface.slant, out, apart);
  way.slant = there_and_back(layer, way.ways);
  way.surface_transmittance = fresnel_transmittance(way.mirror.cos_view, way.mirror.g_view, eta) *
                              fresnel_transmittance(way.mirror.cos_light, way.mirror.g_light, eta);
  return way;
}
