# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks a picture of the paint against the core, pixel by pixel.

The core repeats the shader's computation in float from the places where each pixel looks
(probe.py), and must find the same counts and radiances. The lit picture is checked too: where
Cycles lights a cone of radiance 1, the picture is the light's irradiance E, and the sparkles must
be T E.

Every array here is (height, width, ...) with row 0 at the bottom, as the shader counts pixels.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from .probe import Geometry

if TYPE_CHECKING:
    from metallic_paint_core._native import Light, Paint, Pixels

# Cycles drops closures below this weight; the shader keeps them by chance (osl/cones.h).
LEAST_WEIGHT = 1.1e-5

# Relative error that float rounding may leave in <N>, which holds the exponential of up to -87, in
# float's range, which some 16 roundings of 2^-24 move by 8e-5.
MEAN_ROUNDING = 1e-4
CELL_ROUNDING = 3e-6  # of a cell's share of its parent, as a change of the footprint

MOST_RADIANCE_ERROR = 1e-2  # relative, of the worst pixel
MOST_STACK_ERROR = 1e-3  # of an albedo or a roughness: a quarter of one step of 8 bits


@dataclass(frozen=True)
class Comparison:
    """How a light's sparkles in the picture agree with the core's."""

    pixels: int  # with paint in them
    same_count: int
    at_pixel_edge: int  # another count, because the sample lies on a pixel's edge within rounding
    at_threshold: int  # another count, because <N> lies on a step of the draw within rounding
    unexplained: int
    radiance_error: np.ndarray  # relative, of the pixels with the same count and any radiance
    by_chance: np.ndarray  # (h, w) bool: so dim that Cycles would drop them, kept by lot instead


def predict(
    paint: Paint,
    slots: list[Light],
    geometry: Geometry,
    precision: Literal["float", "double"],
) -> Pixels:
    """The core's values for the pixels with paint: arrays (pixels, lights, ...)."""
    import metallic_paint_core as core

    return core.evaluate(paint, slots, **geometry.places(), precision=precision)


def compare(
    paint: Paint,
    slots: list[Light],
    geometry: Geometry,
    predicted: Pixels,
    light: int,
    leader: int,
    count: np.ndarray,
    cone: np.ndarray,
    picture: np.ndarray,
    irradiance: np.ndarray,
) -> Comparison:
    """Judges images (h, w[, 3]) against the core's prediction.

    picture and irradiance are lit by the lamp of the slot `light`; count and cone are those of the
    slot that leads it: itself, unless another light is too close by.

    With Anchor surface the core is given all that the shader draws from, so no count has an excuse.
    """
    import metallic_paint_core as core

    hit = geometry.hit
    by_pixels = paint.anchor == core.Anchor.pixel
    shifted = (geometry.pixel[hit] != geometry.own_pixel()[hit]).any(axis=-1)
    at_edge = by_pixels & shifted & _near_edge(geometry.raster[hit])
    found = count[hit]
    same = found == predicted["count"][:, leader]
    step = ~at_edge & (by_pixels and _near_threshold(paint, slots, geometry, leader, found))

    per_irradiance = predicted["radiance"][:, light]
    radiance = per_irradiance * irradiance[hit]
    lit = same & (radiance.max(axis=-1) > 0)
    by_chance = lit & (per_irradiance.mean(axis=-1) * cone[hit] < LEAST_WEIGHT)
    lit &= ~by_chance
    chance = np.zeros_like(hit)
    chance[hit] = by_chance
    error = np.abs(picture[hit][lit] - radiance[lit]).max(axis=-1) / radiance[lit].max(axis=-1)
    return Comparison(
        pixels=len(found),
        same_count=int(same.sum()),
        at_pixel_edge=int((~same & at_edge).sum()),
        at_threshold=int((~same & step).sum()),
        unexplained=int((~same & ~at_edge & ~step).sum()),
        radiance_error=error,
        by_chance=chance,
    )


def stack_error(paint: Paint, geometry: Geometry, shown: dict[str, np.ndarray]) -> np.ndarray:
    """How far what lies under the sparkles is from the core's, (h, w), 0 where no paint is.

    shown: pictures (h, w, 3) of the lobes' albedos "diffuse", "glossy" and "returned", of the
    glossy one's roughness "alpha" and of the "texture" that is in the albedos.
    """
    import metallic_paint_core as core

    hit = geometry.hit
    places = geometry.places() | {"pixel": geometry.pixel[hit]}
    errors = []
    # In double: whether a cell of the surface is whole or halved may hang on the shader's rounding.
    for by in (1, 1 - CELL_ROUNDING, 1 + CELL_ROUNDING):
        expected = core.shade(paint, [], **(places | {"footprint": by * places["footprint"]}))
        error = np.zeros(int(hit.sum()))
        for name, picture in shown.items():
            wanted = expected[name]  # type: ignore[literal-required]
            if wanted.ndim == 1:
                wanted = wanted[:, None]
            # A texture multiplies: what it errs counts by the light that it scales.
            scale = np.maximum(np.abs(wanted), 1) if name == "texture" else 1
            off = (np.abs(picture[hit] - wanted) / scale).max(axis=-1)
            error = np.maximum(error, off)
        errors.append(error)
    worst = np.zeros(hit.shape)
    worst[hit] = np.min(errors, axis=0)
    return worst


def _near_edge(raster: np.ndarray) -> np.ndarray:
    """Raster positions within float rounding (16 ulp at 1000) of an edge between pixels."""
    return (np.abs(raster - np.round(raster)) < 1e-3).any(axis=-1)


def _near_threshold(
    paint: Paint, slots: list[Light], geometry: Geometry, light: int, found: np.ndarray
) -> np.ndarray:
    """Counts that the core finds too, when <N> moves by its rounding.

    Both draw from the same bits, and <N> is in proportion to the footprint.
    """
    bounds = []
    for by in (1 - MEAN_ROUNDING, 1, 1 + MEAN_ROUNDING):
        moved = dataclasses.replace(geometry, footprint=by * geometry.footprint)
        bounds.append(predict(paint, slots, moved, "float")["count"][:, light])
    return (np.min(bounds, axis=0) <= found) & (found <= np.max(bounds, axis=0))
