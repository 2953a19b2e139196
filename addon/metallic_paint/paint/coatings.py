# SPDX-License-Identifier: GPL-3.0-or-later
"""The library of coatings (core/coating.h), as numbers and as an image for nodes."""

from __future__ import annotations

from functools import cache

import bpy
import numpy as np

from . import shader
from .parameters import COATINGS, Color, Flakes

TABLE = "Metallic Paint Coatings"  # the image
_MARK = "metallic_paint"

NODES, ROWS, NM_PER_ROW = 13, 41, 5  # angles in a row, and rows of a pearl
FIRST_PEARL = COATINGS.index("tio2-on-mica")
FIRST_IRON = COATINGS.index("fe2o3-on-mica")
LAST_IRON = COATINGS.index("fe2o3-on-silica")  # of those that let light through
_WITHIN = 6  # the angle of this number and the next ones: up to 41 degrees
TRANSMITTANCES = (len(COATINGS) - FIRST_IRON) * ROWS  # so many rows above the reflectances


def table() -> bpy.types.Image:
    """A pixel for each angle and row, packed into the file."""
    for image in bpy.data.images:
        if _MARK in image and image.library is None:
            return image
    values = _values()
    rows, nodes, _ = values.shape
    image = bpy.data.images.new(TABLE, nodes, rows, float_buffer=True, is_data=True)
    pixels = np.ones((rows, nodes, 4), np.float32)
    pixels[:, :, :3] = values
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    image[_MARK] = 1
    return image


def means(flakes: Flakes) -> tuple[np.ndarray, Color]:
    """Reflectance and transmittance, the mean over the angles within a binder of index 1.5."""
    kind = COATINGS.index(flakes.coating)
    if kind == 0:
        return np.array(flakes.flake_color), flakes.flake_transmission
    row, nm = kind - 1, 0.0
    if kind >= FIRST_PEARL:
        row, nm = FIRST_PEARL - 1 + (kind - FIRST_PEARL) * ROWS, flakes.coating_nm / NM_PER_ROW
    reflectance = _at(row, nm)
    if FIRST_PEARL <= kind < FIRST_IRON:
        return reflectance, tuple(1 - reflectance)
    if FIRST_IRON <= kind <= LAST_IRON:
        return reflectance, tuple(_at(row + TRANSMITTANCES, nm))
    return reflectance, (0.0, 0.0, 0.0)


def _at(first_row: int, further: float) -> np.ndarray:
    below = min(int(further), ROWS - 2)
    part = further - below
    rows = _values()[first_row + below : first_row + below + 2, _WITHIN:].mean(1)
    return rows[0] if part == 0 else (1 - part) * rows[0] + part * rows[1]


@cache
def _values() -> np.ndarray:
    files = (folder.parent / "core" / "coating_library.inc" for folder in shader.FOLDERS)
    text = next(file for file in files if file.is_file()).read_text(encoding="utf-8")
    numbers = [float(each) for each in text.replace("\n", " ").split(",") if each.strip()]
    return np.array(numbers).reshape(-1, NODES, 3)
