// SPDX-License-Identifier: Apache-2.0
//
// The coating of a flake: Schlick's metal and a transmittance that does not depend on the angle. See core/coating.h.
#pragma once

struct Coating {
  color normal_reflectance;
  color grazing_reflectance;
  color transmittance;
};

color coating_reflectance(Coating coating, float cos_alpha)
{
  float x = max(1.0 - cos_alpha, 0.0);
  float schlick = x * x * x * x * x;
  return coating.normal_reflectance + (coating.grazing_reflectance - coating.normal_reflectance) * schlick;
}
