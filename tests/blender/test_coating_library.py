# SPDX-License-Identifier: Apache-2.0
"""The coating library in the shader: bit for bit what the core reads from it."""

from __future__ import annotations

from pathlib import Path

import bpy
import metallic_paint_core as core
import numpy as np
import osl_probe
import pytest
from common.processes import ROOT
from metallic_paint import verify

pytestmark = pytest.mark.long

SIZE = 64

# Thickness from left to right, cosine upwards, from end to end.
PROBE = """#include "{osl}/coating.h"
shader probe(
  int Kind = 0,
  int Show = 0,
  float Library[] = {{
#include "{core}/coating_library.inc"
  }},
  output color Shown = 0.0)
{{
  point raster = transform("raster", P);
  int x = (int)floor(raster[0]), y = (int)floor(raster[1]);
  Coating coating;
  coating.normal_reflectance = color(0.1, 0.2, 0.3);
  coating.grazing_reflectance = color(0.4, 0.5, 0.6);
  coating.transmittance = color(0.15, 0.25, 0.35);
  coating.kind = Kind;
  coating.thickness_nm = x * 3.171875;
  float cosine = y / {last};
  if (Show == 2)
    Shown = color(coating.thickness_nm, cosine, 1.0);
  else if (Show == 1)
    Shown = coating_transmittance(coating, Library, cosine);
  else
    Shown = coating_reflectance(coating, Library, cosine);
}}
"""


@pytest.fixture
def probe(tmp_path: Path) -> tuple[bpy.types.Scene, bpy.types.ShaderNodeScript]:
    text = PROBE.format(osl=ROOT / "osl", core=ROOT / "core", last=f"{SIZE - 1}.0")
    return osl_probe.plane_that_shows(text, SIZE, tmp_path)


def shown(
    probe: tuple[bpy.types.Scene, bpy.types.ShaderNodeScript], kind: int, show: int
) -> np.ndarray:
    scene, node = probe
    node.inputs["Kind"].default_value = kind
    node.inputs["Show"].default_value = show
    return verify.render(scene).reshape(-1, 3)


def test_the_shader_reads_the_library_as_the_core_does(
    probe: tuple[bpy.types.Scene, bpy.types.ShaderNodeScript],
) -> None:
    nm, cosine, hit = shown(probe, 0, 2).T
    assert (hit == 1).all()
    for kind in range(1, 15):
        ours = core.library_coating([kind] * len(nm), nm, cosine)
        for show in (0, 1):
            np.testing.assert_array_equal(
                shown(probe, kind, show).astype(np.float32), ours[show], f"kind {kind}, {show}"
            )


def test_kind_0_is_the_paints_own_colours(
    probe: tuple[bpy.types.Scene, bpy.types.ShaderNodeScript],
) -> None:
    cosine = shown(probe, 0, 2)[:, 1:2]
    schlick = [0.1, 0.2, 0.3] + np.float64(0.3) * (1 - cosine) ** 5
    np.testing.assert_allclose(shown(probe, 0, 0), schlick, rtol=1e-6)
    np.testing.assert_array_equal(
        shown(probe, 0, 1), np.broadcast_to(np.float32([0.15, 0.25, 0.35]), (SIZE**2, 3))
    )
