// SPDX-License-Identifier: Apache-2.0
//
// How the layer dims light on its way: see core/optical_thickness.h.
#pragma once

#include "coating.h"
#include "orientation.h"
#include "refraction.h"

color blocked_area(OrientationDensity density, Coating coating, float cos_theta)
{
  float area = mean_projected_area(density, cos_theta);
  return (color(1.0) - coating.transmittance) * area;
}

color slant_depth(color blocking, color binder_depth, float cos_theta)
{
  return (blocking + binder_depth) / max(cos_theta, LEAST_COSINE);
}
