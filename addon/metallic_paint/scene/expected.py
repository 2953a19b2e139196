# SPDX-License-Identifier: GPL-3.0-or-later
"""What the core foretells of a painted object: flakes and sparkles in a pixel, how bright."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ..native import core_lights, core_missing
from ..paint import Paint, core_paint
from . import sky
from .lights import LEAST_SQUARED_DISTANCE, irradiance
from .placed import Placed
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


def expect(
    scene: bpy.types.Scene, paint: Paint, seen: Seen, lights: tuple[Placed, ...]
) -> Expected:
    """The lights are those with a slot; the world's sun may have one after them."""
    per_m2 = 1e6 * sum(flakes.flakes_per_mm2 for flakes in paint.species)
    flakes = float(np.median(seen.footprint)) * per_m2
    if core_missing():
        return Expected(flakes, None, None, None, None)
    import metallic_paint_core as core

    slots = core_lights()
    if not slots:
        return Expected(flakes, 0.0, 0.0, 0.0, 0.0)
    given: dict[str, Any] = {
        "position": seen.position, "normal": seen.normal, "view": seen.view,
        "footprint": seen.footprint, "pixel": np.zeros((len(seen.footprint), 2), np.int32),
    }  # fmt: skip
    found = core.evaluate(core_paint(paint), slots, **given)
    counts = found["mean_count"]
    for slot, light in enumerate(lights):
        if light.lamp.hide_render:  # as it may be at this frame
            counts[:, slot] = 0
    total = counts.sum(axis=1)
    if not counts.any():
        return Expected(flakes, 0.0, 0.0, 0.0, 0.0)
    # A pixel's radiance for E = 1: that of one sparkle, or of so many as two deviations allow.
    mean, variance = (found[key].mean(axis=-1) for key in ("mean_radiance", "variance"))
    one = np.where(counts > 1e-6, mean / np.maximum(counts, 1e-6), 0)
    one = mean + paint.sparkle_contrast * (one - mean)
    irradiances = _irradiances(lights, seen)
    if len(slots) > len(lights):
        of_sun = np.full((len(one), 1), _irradiance_of_sun(scene))
        irradiances = np.concatenate([irradiances, of_sun], axis=1)
    bright = np.maximum(one, mean + 2 * np.sqrt(variance)) * irradiances
    return Expected(
        flakes=flakes,
        sparkles=float(np.median(total)),
        most_sparkles=float(np.quantile(total, _BRIGHT)),
        in_picture=float(total.mean() * seen.pixels),
        brightness=float(np.quantile(bright.max(axis=1), _BRIGHT)),
    )


def _irradiances(lights: tuple[Placed, ...], seen: Seen) -> np.ndarray:
    """(n, lights): of each on a plane that faces it, W/m², without shadows and spots' edges."""
    columns = []
    for light in lights:
        away = seen.position - np.array(light.matrix.translation)
        squared = np.maximum((away**2).sum(axis=1), LEAST_SQUARED_DISTANCE)
        column = irradiance(light.lamp.data, squared)
        if light.lamp.data.type == "AREA":
            facing = away @ -np.array(light.matrix.col[2].xyz.normalized())
            column *= np.maximum(facing, 0) / np.sqrt(squared)
        columns.append(column)
    return np.stack(columns, axis=1) if columns else np.zeros((len(seen.position), 0))


def _irradiance_of_sun(scene: bpy.types.Scene) -> float:
    """Of the world's; 0 where it is not known."""
    sun = sky.find(scene)
    if sun is None:
        return 0.0
    strength = sky.shown(sky.world_of(scene))[0].inputs["Strength"]
    return 0.0 if strength.is_linked else sun.irradiance * strength.default_value
