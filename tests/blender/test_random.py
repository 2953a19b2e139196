# SPDX-License-Identifier: Apache-2.0
"""The shader's deviates are the core's, bit by bit."""

from __future__ import annotations

from pathlib import Path

import metallic_paint_core as core
import numpy as np
import osl_probe
from metallic_paint import verify

OSL = Path(__file__).parents[2] / "osl"
SIZE = 256

# Whole numbers from 0 to 2^23, of which keys are made.
PROBE = f"""
#include "{OSL / "random.h"}"
shader probe(output color Shown = 0.0)
{{
  point raster = transform("raster", P);
  float x = floor(raster[0]), y = floor(raster[1]);
  Shown = color(uniform_deviates(vector(x * 32896.0, y, 8388608.0 - x), y * 32896.0));
}}
"""


def test_deviates_have_the_same_bits(tmp_path: Path) -> None:
    scene, _ = osl_probe.plane_that_shows(PROBE, SIZE, tmp_path)
    y, x = np.mgrid[0:SIZE, 0:SIZE].reshape(2, -1)
    noise = core.white_noise(np.stack([x * 32896, y, 2**23 - x], axis=-1), y * 32896)
    expected = np.clip(noise, 2.0**-33, 1 - 2.0**-24)
    np.testing.assert_array_equal(verify.render(scene).reshape(-1, 3), expected)
