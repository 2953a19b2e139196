# SPDX-License-Identifier: Apache-2.0
"""What one sees of the demo's car through its glass: lining, seats, dashboard, steering wheel."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from pictures.shapes import Array, add_grid, lathe, loft, plain_material, unit

SEAT = 0.36  # y of the front seats' middles
_TUB = ((0.745, 0.86), (0.70, 0.86), (0.66, 0.48))  # y and z of its section, from the belt down


def build(scene: bpy.types.Scene) -> None:
    cloth = plain_material("Cloth", (0.022, 0.021, 0.020), roughness=0.8)
    leather = plain_material("Leather", (0.30, 0.135, 0.060), roughness=0.45)

    def bar(
        name: str, along: Sequence[Sequence[float]], widths: float, heights: float,
        side: Sequence[float], surface: bpy.types.Material,
    ) -> None:  # fmt: skip
        n = len(along)
        add_grid(scene, name, loft(along, n * [widths], n * [heights], side), surface,
                 closed=(False, True))  # fmt: skip

    right = [(-y, z) for y, z in _TUB]
    section = np.array([*right, *_TUB[::-1]])
    x = np.linspace(-1.40, 0.55, 2)[:, None]
    tub = np.stack(np.broadcast_arrays(x, section[:, 0], section[:, 1]), -1)
    add_grid(scene, "Tub", tub, cloth)
    shelf = np.array([[(a, b, 0.87) for b in (-0.58, 0.58)] for a in (-1.62, -1.10)])
    add_grid(scene, "Shelf", shelf, cloth)
    across = [(0.50, y, 0.775 - 0.03 * (y / 0.7) ** 4) for y in np.linspace(-0.70, 0.70, 12)]
    bar("Dashboard", across, 0.52, 0.20, (1, 0, 0), cloth)
    for y in (-SEAT, SEAT):
        bar("Cushion", [(0.12, y, 0.56), (-0.15, y, 0.55), (-0.42, y, 0.52)], 0.50, 0.17,
            (0, 1, 0), leather)  # fmt: skip
        bar("Backrest", [(-0.38, y, 0.52), (-0.47, y, 0.74), (-0.56, y, 0.90), (-0.63, y, 1.03)],
            0.46, 0.15, (0, 1, 0), leather)  # fmt: skip
        bar("Headrest", [(-0.635, y, 1.05), (-0.655, y, 1.10), (-0.67, y, 1.17)], 0.25, 0.09,
            (0, 1, 0), leather)  # fmt: skip
    bar("Bench", [(-1.02, y, 0.78) for y in np.linspace(-0.60, 0.60, 8)], 0.16, 0.30,
        (1, 0, 0), leather)  # fmt: skip
    add_grid(scene, "Steering wheel", _steering_wheel(), cloth, closed=(True, True))


def _steering_wheel() -> Array:
    angle = np.linspace(0, 2 * np.pi, 17)[:-1]
    ring = lathe([(0.175 + 0.014 * np.cos(a), 0.014 * np.sin(a)) for a in angle], 64)
    axis = unit(np.array((-1.0, 0.0, 0.42)))
    axes = np.stack([np.cross(axis, (0, 1, 0)), axis, np.array((0.0, 1.0, 0.0))])
    return ring @ axes + np.array((0.17, SEAT, 0.87))
