// SPDX-License-Identifier: Apache-2.0
//
// The binder's surface: Snell, Fresnel, and the transformation of cones. See core/refraction.h for the derivations.
#pragma once

float eta_cos_refracted(float cos_theta, float eta)
{
  float square = (eta - 1.0) * (eta + 1.0) + cos_theta * cos_theta;
  if (square > 0.0)
    return sqrt(square);
  return 0.0;
}

float fresnel_transmittance(float cos_theta, float g, float eta)
{
  float s = cos_theta + g;
  float p = eta * eta * cos_theta + g;
  if (s <= 0.0)
    return 0.0;
  float product = cos_theta * g;
  return 2.0 * product * (1.0 / (s * s) + eta * eta / (p * p));
}

vector refract_direction(vector direction, vector n, float cos_theta, float g, float eta)
{
  return (direction + n * (g - cos_theta)) / eta;
}

float solid_angle_ratio(float cos_theta, float g, float eta)
{
  return cos_theta / (eta * g);
}
