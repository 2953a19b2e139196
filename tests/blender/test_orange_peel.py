# SPDX-License-Identifier: Apache-2.0
"""Orange peel: Blender's Perlin noise is the core's."""

from __future__ import annotations

from pathlib import Path

import metallic_paint_core as core
import numpy as np
import osl_probe
from common.processes import ROOT
from metallic_paint import verify

SIZE = 128
SLOPE = 0.2

# Another place in each pixel, on either side of the lattice's planes and far from its origin.
PROBE = """#include "{osl}/orange_peel.h"
shader probe(int Show = 0, output color Shown = 0.0)
{{
  point raster = transform("raster", P);
  float x = floor(raster[0]), y = floor(raster[1]);
  point p = point(0.1875 * x - 12.03125, 0.15625 * y - 9.015625, 0.03125 * x - 0.0625 * y + 0.5);
  if (x > 100.0)
    p = p * 64.0;
  if (Show == 1)
    Shown = 0.5 + 0.5 * color(orange_peel(vector(0.0, 0.0, 1.0), waves_at(p, 1.0), {slope}));
  else
    Shown = color(p + point(4096.0));
}}
"""


def test_the_waves_are_the_cores(tmp_path: Path) -> None:
    text = PROBE.format(osl=ROOT / "osl", slope=SLOPE)
    scene, node = osl_probe.plane_that_shows(text, SIZE, tmp_path)
    p = verify.render(scene).reshape(-1, 3).astype(float) - 4096
    node.inputs["Show"].default_value = 1
    shown = 2 * verify.render(scene).reshape(-1, 3).astype(float) - 1
    n, up = len(p), np.broadcast_to([0.0, 0.0, 1.0], p.shape)
    found = core.shade(
        core.Paint(orange_peel=SLOPE, orange_peel_mm=1.0),
        [],
        position=np.zeros((n, 3)),
        normal=up,
        view=up,
        footprint=np.full(n, 1e-6),
        pixel=np.zeros((n, 2), dtype=np.int32),
        own_position=p * 1e-3,
    )["coat_normal"]
    assert shown[:, :2].std() > 0.1, "there are waves"
    # The same gradients at every corner; what is left is rounding, in single precision.
    np.testing.assert_allclose(shown, found, rtol=0, atol=1e-6)
