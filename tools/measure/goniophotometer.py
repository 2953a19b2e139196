# SPDX-License-Identifier: Apache-2.0
"""A virtual multi-angle spectrophotometer: reflectance factors, CIELAB and flop index of a paint.

Geometry of ASTM E2194: light at 45°, detectors in its plane, their aspecular angle counted from
the mirror direction towards the normal and beyond it. Reflectance is that of the random walk
(core/reference/random_walk.h): whole paint, without the surface's mirror image of the lamp. Beams
are parallel and detectors points, where an instrument has apertures of some degrees.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import metallic_paint_core as core
import numpy as np
from metallic_paint.paint import Paint, core_paint

BATCHES = 16
LIGHT = math.radians(45)
CURVE = tuple(range(-40, 131, 5))  # aspecular, degrees
BLACK = 0.01  # L*: no instrument shows less
ANGLES = (-15, 15, 25, 45, 75, 110)  # of multi-angle instruments

# Linear sRGB to CIE XYZ (IEC 61966-2-1); its white, each row's sum, is D65 for the 2° observer.
TO_XYZ = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)  # fmt: skip
LUMINANCE = TO_XYZ[1]


@dataclass(frozen=True)
class Measured:
    """A value, or many, each with its standard error; NaN where there is nothing to measure."""

    value: np.ndarray
    error: np.ndarray


def jackknife(batches: int, statistic: Callable[[np.ndarray], np.ndarray]) -> Measured:
    """A statistic of all batches; its error from leaving out one at a time (Tukey 1958)."""
    every = np.arange(batches)
    without = np.array([statistic(every[every != i]) for i in every])
    return Measured(statistic(every), np.sqrt((batches - 1) * without.var(axis=0)))


def direction(angle: float) -> tuple[float, float, float]:
    """In the light's plane, at an angle (rad) from the normal to the mirror direction's side."""
    return math.sin(angle), 0.0, math.cos(angle)


def walks(
    paint: Paint, light: float, detectors: Sequence[float], photons: int
) -> Iterator[core.Walk]:
    """Independent walks, light and detectors at angles from the normal."""
    for seed in range(BATCHES):
        yield core.random_walk(
            core_paint(paint), direction(light), substrate=paint.substrate_color,
            detectors=[direction(angle) for angle in detectors], photons=photons // BATCHES,
            seed=seed,
        )  # fmt: skip


def aspecular_walks(paint: Paint, photons: int) -> Iterator[np.ndarray]:
    """Reflectance factors R = pi f along CURVE, (angles, 3), of one batch after the other."""
    detectors = [LIGHT - math.radians(angle) for angle in CURVE]
    for walk in walks(paint, -LIGHT, detectors, photons):
        yield np.pi * walk["brdf"]


def lab(rgb: np.ndarray) -> np.ndarray:
    """CIE 1976 L* a* b* of linear RGB; a perfect diffuser has L* = 100, a mirror more."""
    xyz = rgb @ (TO_XYZ / TO_XYZ.sum(axis=1, keepdims=True)).T
    d = 6 / 29
    # f less 4/29, so that black is exactly 0.
    f = np.where(xyz > d**3, np.cbrt(xyz) - 4 / 29, xyz / (3 * d * d))
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116 * y, 500 * (x - y), 200 * (y - z)], axis=-1)


def flop_index(l15: float, l45: float, l110: float) -> float:
    """2.69 (L*15 - L*110)^1.11 / L*45^0.86 (D. H. Alman of DuPont, 1987, as instruments have it).

    0 for a paint that is no darker at 110°; NaN for one that is black at 45° but not at 15°.
    """
    difference = max(l15 - l110, 0.0)
    if difference == 0:
        return 0.0
    return 2.69 * difference**1.11 / l45**0.86 if l45 > BLACK else math.nan


@dataclass(frozen=True)
class Goniogram:
    reflectance: Measured  # (angles of CURVE, 3)
    lab: Measured  # likewise
    flop_index: Measured


def goniogram(batches: np.ndarray) -> Goniogram:
    """From the batches' reflectance factors (batches, angles of CURVE, 3)."""

    def lab_of(kept: np.ndarray) -> np.ndarray:
        return lab(batches[kept].mean(axis=0))

    def flop_of(kept: np.ndarray) -> np.ndarray:
        lightness = lab_of(kept)[:, 0]
        return np.array(flop_index(*(lightness[CURVE.index(angle)] for angle in (15, 45, 110))))

    count = len(batches)
    return Goniogram(
        jackknife(count, lambda kept: batches[kept].mean(axis=0)),
        jackknife(count, lab_of),
        jackknife(count, flop_of),
    )
