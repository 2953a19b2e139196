# SPDX-License-Identifier: Apache-2.0
"""Fits a paint's parameters to a measured BRDF, by the core's own answer for the whole paint.

What is compared is lightness: 116 times the cube root of the radiance, of a lamp whose light falls
on a white diffuser that faces it as 1. So the eye weighs it (CIE 1976), and the radiance holds the
cosine of the light. Errors are its root mean square, in steps of L*.

A BRDF says nothing of the flakes' size but by how thick the layer is beside it, so the diameter
stays as given; their number and the thickness follow from it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import metallic_paint_core as core
import numpy as np
from metallic_paint.paint import Paint, core_paint

from measure.brdf import Brdf

ORIENTATIONS = ("gaussian", "beckmann", "ggx")
ENOUGH = 1e-5  # relative gain of a step below which the search ends
ROUGHNESSES = (0.3, 0.06)  # where searches begin: matt and smooth coats are dips of their own
AT_ONCE = 8  # lights that the core takes
LAMP = math.sin(math.radians(0.05))  # narrow against every lobe
FOOTPRINT = 1.0  # m2: the mean of endless flakes
DEPTH_BLACK = 1e-4  # optical depth from which a fitted absorption counts
DIGITS = 4  # of fitted numbers
AT_END = 0.002  # so near to its range's end, as a share of it, a number stands there


@dataclass(frozen=True)
class Number:
    """One that the fit finds, and its range there."""

    name: str
    low: float
    high: float
    start: float
    logarithmic: bool = False

    def inside(self, value: float) -> float:
        """As the search takes it: from 0 to 1."""
        if self.logarithmic:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def outside(self, place: float) -> float:
        if self.logarithmic:
            return self.low * (self.high / self.low) ** place
        return self.low + (self.high - self.low) * place


def colour(name: str, *range_and_start: float, logarithmic: bool = False) -> list[Number]:
    return [Number(f"{name}.{channel}", *range_and_start, logarithmic) for channel in "rgb"]


NUMBERS = (
    Number("coverage", 0.01, 6, 0.8, logarithmic=True),
    Number("tilt", 0.01, 1, 0.15, logarithmic=True),
    Number("thickness in flakes", 0.3, 30, 2, logarithmic=True),
    Number("binder_ior", 1.3, 1.8, 1.5),  # lacquers have 1.45 to 1.6
    Number("coat_roughness", 0.02, 1, ROUGHNESSES[0]),
    *colour("flake_color", 0, 1, 0.7),
    *colour("edge", 0, 1, 0.5),  # flake_edge_color: from flake_color, 0, to white, 1
    *colour("absorbed depth", DEPTH_BLACK / 10, 5, 0.05, logarithmic=True),
    *colour("substrate_color", 0, 1, 0.05),
)


@dataclass(frozen=True)
class Fit:
    paint: Paint
    error: float  # RMS, steps of L*
    at_end: tuple[str, ...]  # numbers that stand at an end of their range


def radiance(paint: Paint, light: np.ndarray, view: np.ndarray) -> np.ndarray:
    """f cos(theta') of the whole paint towards each view, (n, 3), each under its own light."""
    given = core_paint(dataclasses.replace(paint, orange_peel=0, texture_contrast=0))
    up = np.array([0.0, 0, 1])
    cosines, which = np.unique(np.round(view[:, 2], 12), return_inverse=True)
    if len(cosines) > len(view) // AT_ONCE:
        # Each place is turned so that all have one light, along z.
        axes = np.stack(frame(light), axis=1)  # rows: x, y and the light
        return _shade(given, [core.Light(core.LightKind.parallel, up, LAMP)], axes[:, :, 2],
                      np.einsum("ijk,ik->ij", axes, view))[:, 0]  # fmt: skip
    # The paint is isotropic: turn every view into the plane of x, and compute each but once.
    found = np.zeros_like(light)
    across = np.hypot(view[:, 0], view[:, 1])
    x = np.where(across > 0, view[:, 0] / np.maximum(across, 1e-300), 1.0)
    y = np.where(across > 0, view[:, 1] / np.maximum(across, 1e-300), 0.0)
    turned = np.stack([light[:, 0] * x + light[:, 1] * y, light[:, 1] * x - light[:, 0] * y,
                       light[:, 2]], axis=1)  # fmt: skip
    for group, cosine in enumerate(cosines):
        towards = np.array([[math.sqrt(max(1 - cosine * cosine, 0)), 0, cosine]])
        [members] = np.nonzero(which == group)
        for begin in range(0, len(members), AT_ONCE):
            some = members[begin : begin + AT_ONCE]
            lamps = [core.Light(core.LightKind.parallel, turned[i], LAMP) for i in some]
            found[some] = _shade(given, lamps, up[None], towards)[0]
    return found


def frame(light: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    least = np.eye(3)[np.argmin(np.abs(light), axis=1)]
    x = np.cross(light, least)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return x, np.cross(light, x), light


def _shade(
    paint: core.Paint, lamps: Sequence[core.Light], normal: np.ndarray, view: np.ndarray
) -> np.ndarray:
    n = len(view)
    shades = core.shade(
        paint, lamps, position=np.zeros((n, 3)), normal=normal, view=view,
        footprint=np.full(n, FOOTPRINT), pixel=np.zeros((n, 2), int),
    )  # fmt: skip
    return shades["mean_radiance"]


def lightness(seen: np.ndarray) -> np.ndarray:
    """Of a radiance under a lamp of irradiance 1 on a plane that faces it."""
    return 116 * np.cbrt(np.pi * np.maximum(seen, 0))


def measured_lightness(brdf: Brdf) -> np.ndarray:
    return lightness(brdf.value(brdf.light, brdf.view) * brdf.light[:, 2:])


def paint_of(
    places: np.ndarray, orientation: str, diameter_um: float, digits: int = DIGITS
) -> Paint:
    """The paint of the search's numbers, each from 0 to 1."""

    def rounded(value: float) -> float:
        return float(f"{value:.{digits}g}")

    values = {n.name: n.outside(float(p)) for n, p in zip(NUMBERS, places, strict=True)}

    def three(name: str) -> tuple[float, ...]:
        return tuple(rounded(values[f"{name}.{channel}"]) for channel in "rgb")

    thickness_um = rounded(values["thickness in flakes"] * diameter_um)
    absorption = tuple(
        rounded(depth / (thickness_um * 1e-3)) if depth > DEPTH_BLACK else 0.0
        for depth in (values[f"absorbed depth.{channel}"] for channel in "rgb")
    )
    face = three("flake_color")
    edge = tuple(
        rounded(colour + (1 - colour) * values[f"edge.{channel}"])
        for colour, channel in zip(face, "rgb", strict=True)
    )
    bare = Paint(flakes_per_mm2=1, flake_diameter_um=diameter_um, flake_area_spread=0.3)
    return dataclasses.replace(
        bare,
        flakes_per_mm2=rounded(values["coverage"] / bare.flake_coverage),
        orientation=orientation, tilt=rounded(values["tilt"]),
        layer_thickness_um=thickness_um, binder_ior=rounded(values["binder_ior"]),
        coat_roughness=rounded(values["coat_roughness"]),
        flake_color=face, flake_edge_color=edge,
        binder_absorption_per_mm=absorption, substrate_color=three("substrate_color"),
    )  # fmt: skip


def fit(
    brdf: Brdf, diameter_um: float, steps: int, progress: Callable[[str], None] = lambda _: None
) -> Fit:
    """The nearest paint that a search finds, of the orientation that comes nearest."""
    from scipy.optimize import least_squares  # only ./paint measure has it

    wanted = measured_lightness(brdf)
    best = math.inf, np.zeros(len(NUMBERS)), ORIENTATIONS[0]

    def search(orientation: str, roughness: float) -> None:
        nonlocal best
        start = [n.inside(roughness if n.name == "coat_roughness" else n.start) for n in NUMBERS]

        def off(places: np.ndarray) -> np.ndarray:
            paint = paint_of(places, orientation, diameter_um, digits=17)
            return (lightness(radiance(paint, brdf.light, brdf.view)) - wanted).ravel()

        found = least_squares(off, start, bounds=(0, 1), x_scale=0.1, diff_step=1e-3,
                              ftol=ENOUGH, max_nfev=steps)  # fmt: skip
        error = math.sqrt(2 * found.cost / wanted.size)
        progress(f"{orientation}, coat roughness from {roughness:g}: {error:.2f} steps of L*")
        if error < best[0]:
            best = error, found.x, orientation

    for orientation in ORIENTATIONS:
        search(orientation, ROUGHNESSES[0])
    for roughness in ROUGHNESSES[1:]:
        search(best[2], roughness)
    paint = paint_of(best[1], best[2], diameter_um)
    at_end = tuple(
        number.name for number, place in zip(NUMBERS, best[1], strict=True)
        if not AT_END < place < 1 - AT_END
    )  # fmt: skip
    return Fit(paint, rms(residual(paint, brdf)), at_end)


def residual(paint: Paint, brdf: Brdf) -> np.ndarray:
    """Lightness of the paint less that measured, (n, 3)."""
    return lightness(radiance(paint, brdf.light, brdf.view)) - measured_lightness(brdf)


def rms(differences: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(differences))))
