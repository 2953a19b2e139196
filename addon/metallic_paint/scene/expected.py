# SPDX-License-Identifier: GPL-3.0-or-later
"""What the core foretells of a painted object: flakes and sparkles in a pixel, how bright."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ..native import core_lights, core_missing
from ..paint import Paint, core_paint
from .sight import Seen

_BRIGHT = 0.9  # quantile of a pixel's sparkles that stands for "where it sparkles most"


@dataclass(frozen=True)
class Expected:
    """What a pixel of a painted object holds, in the median of those that the camera sees."""

    flakes: float
    sparkles: float | None  # of all lights; None without the native module
    most_sparkles: float | None  # where it sparkles most
    in_picture: float | None  # sparkles of all its pixels
    brightness: float | None  # radiance of a pixel that sparkles, W/m²/sr


def expect(paint: Paint, seen: Seen, lamps: tuple[bpy.types.Object, ...]) -> Expected:
    per_m2 = 1e6 * sum(flakes.flakes_per_mm2 for flakes in paint.species)
    flakes = float(np.median(seen.footprint)) * per_m2
    if core_missing():
        return Expected(flakes, None, None, None, None)
    import metallic_paint_core as core

    slots = core_lights()[: len(lamps)]  # without the sun of a world
    if not slots:
        return Expected(flakes, 0.0, 0.0, 0.0, 0.0)
    given: dict[str, Any] = {
        "position": seen.position, "normal": seen.normal, "view": seen.view,
        "footprint": seen.footprint, "pixel": np.zeros((len(seen.footprint), 2), np.int32),
    }  # fmt: skip
    counts = np.zeros((len(seen.footprint), len(slots)))
    for species, each in enumerate(paint.species):
        if each.flakes_per_mm2 > 0:
            found = core.evaluate(core_paint(paint), slots, species=species, **given)
            counts += found["mean_count"]
    counts *= [not lamp.hide_render for lamp in lamps]  # as it may be at this frame
    total = counts.sum(axis=1)
    if not counts.any():
        return Expected(flakes, 0.0, 0.0, 0.0, 0.0)
    # A pixel's radiance for E = 1: that of one sparkle, or of so many as two deviations allow.
    mean, variance = (found[key].mean(axis=-1) for key in ("mean_radiance", "variance"))
    one = np.where(counts > 1e-6, mean / np.maximum(counts, 1e-6), 0)
    one = mean + paint.sparkle_contrast * (one - mean)
    bright = np.maximum(one, mean + 2 * np.sqrt(variance)) * _irradiances(lamps, seen)
    return Expected(
        flakes=flakes,
        sparkles=float(np.median(total)),
        most_sparkles=float(np.quantile(total, _BRIGHT)),
        in_picture=float(total.mean() * seen.pixels),
        brightness=float(np.quantile(bright.max(axis=1), _BRIGHT)),
    )


def _irradiances(lamps: tuple[bpy.types.Object, ...], seen: Seen) -> np.ndarray:
    """(n, lamps): of each lamp on a plane that faces it, W/m², without shadows and spots' edges."""
    columns = []
    for lamp in lamps:
        strength = lamp.data.energy * max(lamp.data.color) * 2**lamp.data.exposure
        if lamp.data.type == "SUN":
            columns.append(np.full(len(seen.footprint), strength))
            continue
        away = seen.position - np.array(lamp.matrix_world.translation)
        squared = np.maximum((away**2).sum(axis=1), 1e-8)
        if lamp.data.type == "AREA":
            facing = away @ -np.array(lamp.matrix_world.col[2].xyz.normalized())
            columns.append(strength / np.pi * np.maximum(facing, 0) / squared**1.5)
        else:
            columns.append(strength / (4 * np.pi * squared))
    return np.stack(columns, axis=1)
