# SPDX-License-Identifier: Apache-2.0
"""A virtual camera over the paint, as effect instruments have one: sparkle and graininess.

Published of those instruments: the camera looks along the normal; for sparkle, lamps shine from
15°, 45° and 75°; for graininess, a white dome lights evenly. Terms as in ASTM E284: sparkle area
is the share of the picture in spots strikingly brighter than their surroundings, sparkle intensity
the contrast of the spots. How a maker turns them into grades is not published; the numbers here
are physical and compare paints with each other, not with an instrument's display.

Assumed: ideal lens (pixels without blur); the lamp's size, the pixel and the threshold below.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import metallic_paint_core as core
import numpy as np
from goniophotometer import BATCHES, LUMINANCE, Measured, direction, jackknife, walks
from metallic_paint.paint import Paint, core_paint

LIGHTS = (15, 45, 75)  # degrees from the normal
LAMP_RADIUS = math.radians(1)  # assumed
PIXEL = 40e-6  # m, assumed: about the size of the flakes
SIDE = 256  # pixels of a batch's picture
CONTRAST = 1.0  # a sparkle is at least so much brighter than the background, relative to it: ours
# What the eye resolves: one minute of arc at 0.5 m.
GRAIN = 0.5 * math.radians(1 / 60)
DOME = 2 * math.pi  # sr


@dataclass(frozen=True)
class Sparkle:
    area: Measured  # share of the picture
    intensity: Measured  # mean contrast of the sparkles; NaN without any, or on black
    picture: np.ndarray  # (SIDE, SIDE, 3), reflectance factors


@dataclass(frozen=True)
class NormalWalk:
    """What the camera sees besides single flakes: even, by reciprocity from light at the normal."""

    under_lamps: np.ndarray  # (batches, LIGHTS, 3), reflectance factors
    under_dome: np.ndarray  # (batches, 3)


def normal_walk(paint: Paint, photons: int) -> NormalWalk:
    under_lamps, under_dome = [], []
    for walk in walks(paint, 0.0, [math.radians(a) for a in LIGHTS], photons):
        under_lamps.append(np.pi * (walk["brdf_substrate"] + walk["brdf_mixture"]))
        under_dome.append(walk["albedo_substrate"] + walk["albedo_mixture"])
    return NormalWalk(np.array(under_lamps), np.array(under_dome))


def sparkle_pictures(paint: Paint, light: float) -> Iterator[np.ndarray]:
    """Reflectance factors of the flakes in each pixel, (SIDE, SIDE, 3), batch by batch."""
    n = SIDE * SIDE
    up = np.tile(direction(0), (n, 1))
    lamp = core.Light(core.LightKind.parallel, direction(light), math.sin(LAMP_RADIUS))
    rows, columns = np.divmod(np.arange(n), SIDE)
    for batch in range(BATCHES):
        drawn = core.evaluate(
            core_paint(paint), [lamp], position=np.zeros((n, 3)), normal=up, view=up,
            footprint=np.full(n, PIXEL**2), pixel=np.stack([columns + SIDE * batch, rows], axis=1),
        )["radiance"]  # fmt: skip
        # A perfect diffuser under the lamp has the radiance cos(light)/pi.
        yield (np.pi / math.cos(light) * drawn).reshape(SIDE, SIDE, 3)


def sparkle(paint: Paint, light: float, background: np.ndarray) -> Sparkle:
    """background: (batches, 3), what the picture shows besides the flakes."""
    pictures = list(sparkle_pictures(paint, light))
    flakes = np.array([picture @ LUMINANCE for picture in pictures])
    even = background @ LUMINANCE

    def area_and_intensity(kept: np.ndarray) -> np.ndarray:
        luminance = flakes[kept] + even[kept].mean()
        surroundings = np.median(luminance)
        sparkling = luminance[luminance > (1 + CONTRAST) * surroundings]
        area = sparkling.size / luminance.size
        if not (sparkling.size and surroundings > 0):
            return np.array([area, math.nan])
        return np.array([area, sparkling.mean() / surroundings - 1])

    both = jackknife(BATCHES, area_and_intensity)
    area, intensity = (Measured(both.value[i], both.error[i]) for i in range(2))
    return Sparkle(area, intensity, pictures[0] + background.mean(axis=0))


def graininess(paint: Paint, background: np.ndarray, pixels: int) -> Measured:
    """Standard deviation of the luminance under the dome over its mean, at the eye's resolution.

    The flakes are traced one by one as discs that hide each other (core/reference/
    explicit_flakes.h), the lamp being the whole dome; background: (batches, 3), even.
    """
    traced = core_paint(paint, flake_spread=0)  # under an even dome the spread changes nothing
    luminance = np.array(
        [
            core.explicit_flakes(
                traced, direction(0), direction(0), math.pi / 2, GRAIN**2, pixels // BATCHES,
                seed=seed,
            )["radiance"] @ (DOME * LUMINANCE)
            for seed in range(BATCHES)
        ]
    )  # fmt: skip
    even = background @ LUMINANCE

    def relative_deviation(kept: np.ndarray) -> np.ndarray:
        mean = luminance[kept].mean() + even[kept].mean()
        return np.array(luminance[kept].std() / mean if mean > 0 else math.nan)

    return jackknife(BATCHES, relative_deviation)
