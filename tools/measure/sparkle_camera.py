# SPDX-License-Identifier: Apache-2.0
"""A virtual camera over the paint, as effect instruments have one: sparkle and graininess.

Published of those instruments: the camera looks along the normal; for sparkle, lamps shine from
15°, 45° and 75°; for graininess, a white dome lights evenly. Sparkle area is the share of the
picture in spots strikingly brighter than their surroundings, sparkle intensity the spots' contrast
(so Burgos-Fernández et al., Coatings 10:320, 2020). How a maker turns pictures into grades is not
published; the numbers here are physical, to compare paints with each other.

Assumed: an ideal lens, the lamp's size, the pixel and the threshold below.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass

import metallic_paint_core as core
import numpy as np
from metallic_paint.paint import Paint, core_paint

from measure.goniophotometer import BATCHES, LUMINANCE, Measured, direction, jackknife, walks

LIGHTS = (15, 45, 75)  # degrees from the normal
LAMP_RADIUS = math.radians(1)  # assumed
CONTRAST = 1.0  # a sparkle is at least so much brighter than the background, relative to it: ours
# m, assumed: what the eye resolves, one minute of arc at 0.5 m.
PIXEL = 0.5 * math.radians(1 / 60)
DOME = 2 * math.pi  # sr


@dataclass(frozen=True)
class Sparkle:
    area: Measured  # share of the picture
    intensity: Measured  # mean contrast of the sparkles; NaN without any, or on black
    picture: np.ndarray  # (side, side, 3), reflectance factors


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


def sparkle_pictures(paint: Paint, light: float, side: int) -> Iterator[np.ndarray]:
    """Reflectance factors of the flakes in each pixel, (side, side, 3), batch by batch."""
    n = side * side
    up = np.tile(direction(0), (n, 1))
    lamp = core.Light(core.LightKind.parallel, direction(light), math.sin(LAMP_RADIUS))
    rows, columns = np.divmod(np.arange(n), side)
    for batch in range(BATCHES):
        drawn = core.evaluate(
            core_paint(paint), [lamp], position=np.zeros((n, 3)), normal=up, view=up,
            footprint=np.full(n, PIXEL**2), pixel=np.stack([columns + side * batch, rows], axis=1),
        )["radiance"]  # fmt: skip
        # A perfect diffuser under the lamp has the radiance cos(light)/pi.
        yield (np.pi / math.cos(light) * drawn).reshape(side, side, 3)


def sparkle(paint: Paint, light: float, background: np.ndarray, side: int) -> Sparkle:
    """background: (batches, 3), what the pictures, of side² pixels, show besides the flakes."""
    pictures = list(sparkle_pictures(paint, light, side))
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


def dome_luminance(paint: Paint, pixels: int, shadowing: str = "discs") -> np.ndarray:
    """Of the flakes in pixels under a dome of luminance 1, (batches, pixels).

    The flakes are traced one by one (core/reference/explicit_flakes.h), the lamp being the dome.
    """
    # Under an even dome the spread changes nothing.
    traced = core_paint(dataclasses.replace(paint, flake_spread=0, diffraction="none"))
    up = direction(0)
    batches = (
        core.explicit_flakes(
            traced, up, up, math.pi / 2, PIXEL**2, pixels // BATCHES, shadowing=shadowing, seed=seed
        )
        for seed in range(BATCHES)
    )
    return np.array([batch["radiance"] @ (DOME * LUMINANCE) for batch in batches])


def graininess(flakes: np.ndarray, background: np.ndarray) -> Measured:
    """Standard deviation of the luminance under the dome over its mean, at the eye's resolution.

    flakes: from dome_luminance; background: (batches, 3), what is seen besides single flakes.
    """
    even = background @ LUMINANCE

    def relative_deviation(kept: np.ndarray) -> np.ndarray:
        mean = flakes[kept].mean() + even[kept].mean()
        return np.array(flakes[kept].std() / mean if mean > 0 else math.nan)

    return jackknife(BATCHES, relative_deviation)
