# SPDX-License-Identifier: Apache-2.0
"""Paints that differ from the default in what is varied."""

from __future__ import annotations

import dataclasses
import math

from metallic_paint.paint import Paint


def varied(count: int) -> list[Paint]:
    """Of other values, and no other structure."""
    shares = [(i + 1) / count for i in range(count)]
    return [
        Paint(
            tilt=0.1 + 0.1 * share, flakes_per_mm2=1000 + 4000 * share, seed=i,
            flake_color=(0.9, 0.5 + 0.4 * share, 0.9 - 0.5 * share),
        )
        for i, share in enumerate(shares)
    ]  # fmt: skip


def shrunk(flakes_per_m2: float) -> float:
    """Diameter of the flakes over the default's where as many cover the default's area."""
    return math.sqrt(Paint().flakes_per_mm2 * 1e6 / flakes_per_m2)


def of_flakes(flakes_per_m2: float) -> Paint:
    """The more flakes, the smaller; without diffraction, which would spread small ones' light."""
    paint = dataclasses.replace(Paint(), diffraction="none")
    return dataclasses.replace(
        paint,
        flakes_per_mm2=flakes_per_m2 / 1e6,
        flake_diameter_um=paint.flake_diameter_um * shrunk(flakes_per_m2),
    )
