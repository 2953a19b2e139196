# SPDX-License-Identifier: Apache-2.0
"""The pictures of ./paint measure --fit: curves along the plane of incidence, and spheres."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from common.figures import DARK, STYLE, save
from metallic_paint.paint import Paint

from measure.brdf import GRAZING, Brdf, direction
from measure.fit import frame, radiance
from measure.plots import CHANNELS, bare, encoded

INCIDENCES = (15, 45, 75)  # degrees
STEP = 1  # degrees, of curves
IN_PLANE = np.radians(3)  # so near to the plane, or to the incidence, a file's row counts as there
SIDE = 192  # pixels of a sphere
LAMP = np.array([-0.45, 0.45, 0.77])  # seen from the sphere; the camera looks along -z
WHITE = 99.0  # percentile of the measured sphere's luminance that is white, at least a diffuser
UNKNOWN = 0.35  # grey of what was not measured


@dataclass(frozen=True)
class Curve:
    """One incidence in its plane. Angles are aspecular, degrees, positive towards the normal."""

    incidence: float
    angles: np.ndarray
    light: np.ndarray
    view: np.ndarray
    measured: np.ndarray  # (n, 3), 1/sr


def curves(brdf: Brdf) -> Iterator[Curve]:
    for incidence in INCIDENCES:
        if brdf.is_scattered:
            yield from _of_rows(brdf, incidence)
            continue
        most = np.degrees(GRAZING)
        views = np.arange(-most, most + STEP, STEP)
        light = np.tile(direction(np.radians(incidence), np.pi), (len(views), 1))
        view = direction(np.radians(views))
        yield Curve(incidence, incidence - views, light, view, brdf.value(light, view))


def _of_rows(brdf: Brdf, wanted: float) -> Iterator[Curve]:
    """The rows in the plane of the incidence that is the nearest among the file's."""
    angles = np.arccos(np.clip(brdf.light[:, 2], -1, 1))
    aside = np.abs(brdf.view[:, 1])  # the light's azimuth is 0
    flat = aside < np.sin(IN_PLANE)
    if not flat.any():
        return
    incidence = angles[flat][np.argmin(np.abs(angles[flat] - np.radians(wanted)))]
    rows = flat & (np.abs(angles - incidence) < IN_PLANE)
    light, view = brdf.light[rows], brdf.view[rows]
    seen = np.degrees(np.arctan2(-view[:, 0], view[:, 2]))
    order = np.argsort(seen)
    yield Curve(float(np.degrees(incidence)), (np.degrees(incidence) - seen)[order], light[order],
                view[order], brdf.value(light, view)[order])  # fmt: skip


def draw_curves(brdf: Brdf, paint: Paint, file: Path) -> None:
    found = list(curves(brdf))
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(
            1, max(len(found), 1), figsize=(11, 4.2), layout="constrained", squeeze=False
        )
        for axes, curve in zip(panels[0], found, strict=False):
            ours = radiance(paint, curve.light, curve.view) / curve.light[:, 2:]
            for channel, colour in enumerate(CHANNELS):
                style = {"color": colour, "lw": 1.3}
                marks = {"marker": "o", "ms": 3, "ls": "none"} if brdf.is_scattered else {}
                axes.plot(curve.angles, curve.measured[:, channel], **style, **marks)
                axes.plot(curve.angles, ours[:, channel], **style, ls="--")
                if brdf.second:
                    other = brdf.second(curve.light, curve.view)
                    axes.plot(curve.angles, other[:, channel], color=colour, lw=0.8, ls=":")
            axes.set_yscale("log")
            axes.set_title(f"light at {curve.incidence:.0f}°", loc="left")
            axes.set_xlabel("aspecular angle (the mirror direction is 0°)")
        panels[0, 0].set_ylabel("BRDF, 1/sr")
        what = "dots" if brdf.is_scattered else "line"
        label = f"{brdf.name}: {what} measured, dashed the paint"
        figure.suptitle(label + (", dotted another fit" if brdf.second else ""), color=DARK)
        save(figure, file)


def draw_spheres(brdf: Brdf, paint: Paint, file: Path) -> None:
    inside, light, view = _sphere()
    balls = [("measured", brdf.value(light, view) * light[:, 2:])]
    balls.append(("the paint", radiance(paint, light, view)))
    if brdf.second:
        balls.append(("another fit of the measured", brdf.second(light, view) * light[:, 2:]))
    known = balls[0][1][np.isfinite(balls[0][1]).all(axis=1)]
    white = max(float(np.percentile(known.mean(axis=1), WHITE)), 1 / np.pi) if len(known) else 1.0
    with plt.rc_context(STYLE):
        figure, panels = plt.subplots(1, len(balls), figsize=(3.6 * len(balls), 3.9),
                                      layout="constrained")  # fmt: skip
        for axes, (name, seen) in zip(panels, balls, strict=True):
            picture = np.zeros((SIDE, SIDE, 3))
            shown = encoded(np.nan_to_num(seen) / white)
            shown[~np.isfinite(seen).all(axis=1)] = UNKNOWN
            picture[inside] = shown
            axes.imshow(picture)
            axes.set_title(name, loc="left")
            bare(axes)
        caption = f"one lamp; white is a reflectance factor of {np.pi * white:.2g}"
        if len(known) < len(light):
            caption += "; grey was not measured"
        figure.supxlabel(caption, fontsize=8)
        figure.savefig(file, dpi=110)
        plt.close(figure)


def _sphere() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which pixels are lit, and there the light and the view about the normal."""
    across = (np.arange(SIDE) + 0.5) / SIDE * 2.04 - 1.02
    x, y = np.meshgrid(across, -across)
    height = np.sqrt(np.clip(1 - x * x - y * y, 0, 1))
    normal = np.stack([x, y, height], axis=-1)
    lamp = LAMP / np.linalg.norm(LAMP)
    inside = (x * x + y * y < 1) & (normal @ lamp > 0) & (height > 0)
    lit = normal[inside]
    axes = np.stack(frame(lit), axis=1)
    return inside, axes @ lamp, axes @ np.array([0.0, 0, 1])
