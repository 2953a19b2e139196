// SPDX-License-Identifier: Apache-2.0
//
// The binder's surface: Snell, Fresnel, and the transformation of cones. See core/refraction.h for the derivations.
#pragma once

#include "elementary.h"

float eta_cos_refracted(float cos_theta, float eta)
{
  float square = (eta - 1.0) * (eta + 1.0) + cos_theta * cos_theta;
  return sqrt(max(square, 0.0));
}

float critical_cosine(float eta)
{
  return sqrt(max((eta - 1.0) * (eta + 1.0), 0.0)) / eta;
}

float fresnel_transmittance(float cos_theta, float g, float eta)
{
  float s = cos_theta + g;
  float p = eta * eta * cos_theta + g;
  if (s <= 0.0)
    return 0.0;
  return min(2.0 * ((cos_theta / s) * (g / s) + (eta * cos_theta / p) * (eta * g / p)), 1.0);
}

float solid_angle_ratio(float cos_theta, float g, float eta)
{
  return cos_theta / (eta * g);
}

float solid_angle_of_facets(float cos_theta, float g, float eta)
{
  return (g - cos_theta) * (g - cos_theta) / (eta * g);
}

#define LEAST_COSINE 1e-18

float seen_cosine(vector n, vector view)
{
  float cosine = min(inner_product(n, view), 1.0);
  if (cosine > LEAST_COSINE)
    return cosine;
  return 1e-4;
}

struct MirroringFlake {
  float s;
  float cos_alpha;
  float sin2_half_beta;
};

MirroringFlake mirroring_flake(vector tangent, float along, float eta)
{
  float tangent_square = inner_product(tangent, tangent);
  MirroringFlake flake;
  flake.s = sqrt(tangent_square + along * along);
  flake.cos_alpha = min(flake.s / (2.0 * eta), 1.0);
  flake.sin2_half_beta = min(tangent_square / (2.0 * flake.s * (flake.s + along)), 0.5);
  return flake;
}

struct Mirror {
  int possible;
  float cos_view;
  float cos_light;
  float g_view;
  float g_light;
  float cos_alpha;
  float sin2_half_beta;
  vector flake_normal;
};

Mirror mirror_between(vector n, vector view, vector light, float eta)
{
  Mirror mirror;
  mirror.possible = 0;
  mirror.cos_alpha = 1.0;
  mirror.sin2_half_beta = 0.0;
  mirror.flake_normal = n;
  mirror.g_view = 0.0;
  mirror.g_light = 0.0;
  mirror.cos_view = min(inner_product(n, view), 1.0);
  mirror.cos_light = min(inner_product(n, light), 1.0);
  if (!(mirror.cos_view > LEAST_COSINE) || !(mirror.cos_light > LEAST_COSINE))
    return mirror;
  mirror.g_view = eta_cos_refracted(mirror.cos_view, eta);
  mirror.g_light = eta_cos_refracted(mirror.cos_light, eta);
  if (!(mirror.g_view > 0.0) || !(mirror.g_light > 0.0))
    return mirror;
  vector tangent = (view + light) - n * (mirror.cos_view + mirror.cos_light);
  float along = mirror.g_view + mirror.g_light;
  MirroringFlake flake = mirroring_flake(tangent, along, eta);
  mirror.cos_alpha = flake.cos_alpha;
  mirror.sin2_half_beta = flake.sin2_half_beta;
  mirror.flake_normal = (tangent + n * along) * (1.0 / flake.s);
  mirror.possible = 1;
  return mirror;
}
