// SPDX-License-Identifier: Apache-2.0
//
// The coating of a flake: Schlick's metal, or a kind of the library. See core/coating.h.
//
// The library is a parameter of the shader, float CoatingLibrary[] = {coating_library.inc}, handed down as an argument:
// OSL keeps such an array as one constant, while an array of a function is filled again at each call.
#pragma once

#include "choices.h"

#define COATING_FIRST_PEARL COATING_TIO2_ON_MICA
#define COATING_FIRST_IRON COATING_FE2O3_ON_MICA
#define COATING_KINDS 15

#define COATING_NODES 13
#define COATING_ROWS 41
#define MOST_COATING_NM 200.0

struct Coating {
  color normal_reflectance;
  color grazing_reflectance;
  color transmittance;
  int kind;
  float thickness_nm;
};

int is_clear(int kind)
{
  return kind >= COATING_FIRST_PEARL && kind != COATING_FE2O3_ON_ALUMINIUM;
}

int is_on_silica(int kind)
{
  return kind == COATING_TIO2_ON_SILICA || kind == COATING_TIO2_ON_THIN_SILICA || kind == COATING_FE2O3_ON_SILICA;
}

int coating_row(int kind)
{
  if (kind < COATING_FIRST_PEARL)
    return kind - 1;
  return COATING_FIRST_PEARL - 1 + (kind - COATING_FIRST_PEARL) * COATING_ROWS;
}

color coating_node(float library[], int at)
{
  return color(library[at], library[at + 1], library[at + 2]);
}

color interpolate_library(float library[], int first_row, float thickness_nm, float cosine)
{
  float row = clamp(thickness_nm, 0.0, MOST_COATING_NM) * 0.2;
  int i = min((int)row, COATING_ROWS - 2);
  float v = row - i;
  float c = clamp(cosine, 0.0, 1.0);
  float node = max(6.0 * c, 24.0 * c - 12.0);
  int j = min((int)node, COATING_NODES - 2);
  float w = node - j;
  int at = 3 * ((first_row + i) * COATING_NODES + j);
  int below = at + 3 * COATING_NODES;
  return (coating_node(library, at) * (1.0 - w) + coating_node(library, at + 3) * w) * (1.0 - v) +
         (coating_node(library, below) * (1.0 - w) + coating_node(library, below + 3) * w) * v;
}

color coating_reflectance(Coating coating, float library[], float cos_alpha)
{
  color reflected = color(0.0);
  if (coating.kind > COATING_COLORS) {
    float thickness = 0.0;
    if (coating.kind >= COATING_FIRST_PEARL)
      thickness = coating.thickness_nm;
    reflected = interpolate_library(library, coating_row(coating.kind), thickness, cos_alpha);
  }
  else {
    float x = max(1.0 - cos_alpha, 0.0);
    float schlick = x * x * x * x * x;
    reflected = coating.normal_reflectance + (coating.grazing_reflectance - coating.normal_reflectance) * schlick;
  }
  return reflected;
}

color coating_transmittance(Coating coating, float library[], float cos_alpha)
{
  color passed = coating.transmittance;
  if (is_clear(coating.kind)) {
    int absorbing = coating.kind >= COATING_FIRST_IRON;
    int row = coating_row(coating.kind);
    if (absorbing)
      row = row + (COATING_KINDS - COATING_FIRST_IRON) * COATING_ROWS;
    color value = interpolate_library(library, row, coating.thickness_nm, cos_alpha);
    passed = value;
    if (!absorbing)
      passed = color(1.0) - value;
  }
  else if (coating.kind != COATING_COLORS)
    passed = color(0.0);
  return passed;
}
