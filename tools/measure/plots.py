# SPDX-License-Identifier: Apache-2.0
"""The figure of the report of ./paint measure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from common.figures import DARK, STYLE
from matplotlib.axes import Axes

from measure.goniophotometer import ANGLES, CURVE, LUMINANCE, Goniogram
from measure.sparkle_camera import LIGHTS, PIXEL, Sparkle

if TYPE_CHECKING:
    from measure.report import Measurement

CHANNELS = ("#d03030", "#2e9e40", "#2b5fd0")
CROP = 64  # pixels along a side
WHITE = 30  # what a picture shows as white, in medians


def draw(name: str, found: Measurement, file: Path) -> None:
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(11, 8.2), layout="constrained")
        upper, strip, lower = figure.subfigures(3, 1, height_ratios=(4, 1.1, 4))
        left, right = upper.subplots(1, 2)
        flop = found.goniogram.flop_index
        _lightness(left, found.goniogram)
        index = f": flop index {flop.value:.1f}" if np.isfinite(flop.value) else ""
        left.set_title(f"{name}{index}", loc="left", fontweight="bold")
        _reflectance(right, found.goniogram)
        _colours(strip.subplots(1, len(ANGLES)), found.goniogram)
        for axes, light in zip(lower.subplots(1, len(LIGHTS)), LIGHTS, strict=True):
            _picture(axes, light, found.sparkles[light])
        figure.savefig(file, dpi=110)
        plt.close(figure)


def _lightness(axes: Axes, goniogram: Goniogram) -> None:
    value, error = goniogram.lab.value[:, 0], goniogram.lab.error[:, 0]
    axes.errorbar(CURVE, value, error, color=DARK, lw=1.2, capsize=2)
    for angle in ANGLES:
        at = value[CURVE.index(angle)]
        axes.plot(angle, at, "o", color=DARK, ms=5)
        axes.annotate(f"{at:.1f}", (angle, at), (5, 5), textcoords="offset points", fontsize=8)
    axes.set_ylabel("L*")
    axes.set_ylim(0, max(1.1 * value.max(), 1))
    _angles(axes)


def _reflectance(axes: Axes, goniogram: Goniogram) -> None:
    value, error = goniogram.reflectance.value, goniogram.reflectance.error
    for channel, (colour, label) in enumerate(zip(CHANNELS, ("red", "green", "blue"), strict=True)):
        axes.errorbar(CURVE, value[:, channel], error[:, channel], color=colour, lw=1.2, capsize=2,
                      label=label)  # fmt: skip
    if value.max() > 0:
        axes.set_yscale("log")
    axes.set_title("reflectance factor (1: perfect diffuser)", loc="left")
    axes.legend()
    _angles(axes)


def _angles(axes: Axes) -> None:
    axes.set_xlabel("aspecular angle (light at 45°: the mirror direction is 0°)")
    axes.set_xticks(ANGLES)


def _colours(panels: np.ndarray, goniogram: Goniogram) -> None:
    colours = goniogram.reflectance.value
    white = max(1.0, colours[[CURVE.index(angle) for angle in ANGLES]].max())
    for axes, angle in zip(panels, ANGLES, strict=True):
        axes.imshow([[encoded(colours[CURVE.index(angle)] / white)]], aspect="auto")
        axes.set_title(f"{angle}°")
        bare(axes)
    panels[0].set_ylabel(f"white is R = {white:.2g}", fontsize=7)


def _picture(axes: Axes, light: int, sparkle: Sparkle) -> None:
    median = np.median(sparkle.picture @ LUMINANCE)
    crop = sparkle.picture[:CROP, :CROP]
    white = WHITE * median if median > 0 else max(crop.max(), 1e-9)
    axes.imshow(encoded(crop / white), interpolation="nearest")
    intensity = sparkle.intensity.value
    contrast = f", intensity {intensity:,.0f}" if np.isfinite(intensity) else ""
    axes.set_title(f"lamp at {light}°: area {100 * sparkle.area.value:.3g} %{contrast}")
    axes.set_xlabel(f"{len(crop) * PIXEL * 1e3:.1f} mm; white is {WHITE} × the median")
    bare(axes)


def bare(axes: Axes) -> None:
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(visible=False)


def encoded(rgb: np.ndarray) -> np.ndarray:
    """sRGB (IEC 61966-2-1), clipped."""
    x = np.clip(rgb, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
