# SPDX-License-Identifier: Apache-2.0
"""Linear sRGB of reflectance spectra under D65, for the CIE 1931 observer; white is (1, 1, 1)."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ROWS = np.array(json.loads((Path(__file__).parent / "data" / "observer.json").read_text())["rows"])
WAVELENGTHS = _ROWS[:, 0]  # nm

# IEC 61966-2-1: chromaticities x, y of the primaries.
_PRIMARIES = np.array([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]])


def _weights() -> Array:
    """(wavelengths, 3): RGB = spectrum @ weights.

    The primaries' XYZ are scaled so that their sum is the XYZ of D65 itself, as our sum over
    wavelengths has it: each column then adds up to 1.
    """
    xyz = _ROWS[:, 1:4] * _ROWS[:, 4:5]
    primaries = np.column_stack([_PRIMARIES, 1 - _PRIMARIES.sum(axis=1)]).T
    scale = np.linalg.solve(primaries, xyz.sum(axis=0))
    return np.linalg.solve(primaries * scale, xyz.T).T


_WEIGHTS = _weights()


def linear_srgb(spectrum: Array) -> Array:
    """(..., 3) of spectra (wavelengths, ...); not clipped, so linear in the spectrum."""
    return np.moveaxis(np.tensordot(_WEIGHTS, spectrum, axes=(0, 0)), 0, -1)


def encoded_srgb(linear: Array) -> Array:
    """What a screen shows of linear values; IEC 61966-2-1."""
    x = np.clip(linear, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
