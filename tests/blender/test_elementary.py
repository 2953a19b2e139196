# SPDX-License-Identifier: Apache-2.0
"""What the shader takes for exact of OSL's functions is exact in this Blender."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import osl_probe
import pytest
from metallic_paint import verify

pytestmark = pytest.mark.long

SIZE = 64

# k from -126 to 126; m, in [1, 2), is drawn from the pixel, its ends included.
PROBE = """
shader probe(output color Shown = 0.0)
{
  point raster = transform("raster", P);
  int at = (int)floor(raster[0]) + 64 * (int)floor(raster[1]);
  int k = at % 253 - 126;
  float m = 1.0 + (at / 253) * 0.0624999925494;
  Shown = color(exp2((float)k), logb(m * exp2((float)k)) + 128.0, m);
}
"""


def test_powers_of_two_and_their_logarithms_are_exact(tmp_path: Path) -> None:
    scene, _ = osl_probe.plane_that_shows(PROBE, SIZE, tmp_path)
    power, logarithm, m = verify.render(scene).reshape(-1, 3).T.astype(np.float64)
    assert m.min() == 1
    assert 1.999999 < m.max() < 2
    k = np.round(np.log2(power))
    assert set(k) == set(range(-126, 127))
    np.testing.assert_array_equal(power, np.exp2(k))
    np.testing.assert_array_equal(logarithm, k + 128)
