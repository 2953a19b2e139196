# SPDX-License-Identifier: Apache-2.0
"""Difference images of ./paint verify."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO
from common import files

GAP = 8  # pixels between the panels


def write_comparison(path: Path, picture: np.ndarray, core: np.ndarray) -> None:
    """Side by side: Cycles, the core, and a hundred times their difference.

    Radiances (h, w, 3) with row 0 at the bottom, exposed so that the brightest thousandth of the
    lit pixels is white.
    """
    lit = core.max(axis=-1)[core.max(axis=-1) > 0]
    white = np.quantile(lit, 0.999) if lit.size else 1.0
    panels = [picture, core, 100 * np.abs(picture - core)]
    gap = np.full((picture.shape[0], GAP, 3), 0.5)
    row = np.concatenate(
        [panels[0] / white, gap, panels[1] / white, gap, panels[2] / white], axis=1
    )
    encoded = np.clip(row[::-1], 0, 1) ** (1 / 2.2)
    image = OpenImageIO.ImageBuf(np.ascontiguousarray(encoded, dtype=np.float32))
    with files.whole(path) as beside:
        if not image.write(str(beside), OpenImageIO.UINT8, "png"):
            raise OSError(f"{path} cannot be written: {image.geterror()}")
