# SPDX-License-Identifier: Apache-2.0
"""Swatches of a flake's colours over the angle and the thickness of its coating."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import matplotlib as mpl
import numpy as np

from coatings.colorimetry import encoded_srgb
from coatings.table import Array, Flake, colours

mpl.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes

ANGLES = np.linspace(0, 90, 91)  # degrees
THICKNESSES = np.linspace(0, 200, 101)  # nm


def draw(name: str, flake: Flake, binder_ior: float, file: Path) -> None:
    cosine = np.cos(np.radians(ANGLES))
    reflectance, transmittance = colours(flake, cosine, binder_ior)
    coated = flake.coating is not None
    figure, axes = plt.subplots(2, 1 + coated, figsize=(5 + 5 * coated, 6), layout="constrained")
    grid = np.reshape(axes, (2, -1))
    for row, (what, values) in enumerate(
        (("reflectance", reflectance), ("transmittance", transmittance))
    ):
        _over_angle(grid[row, 0], what, values)
    if coated:
        both = [
            colours(dataclasses.replace(flake, coating_nm=nm), cosine, binder_ior)
            for nm in THICKNESSES
        ]
        for row, what in enumerate(("reflectance", "transmittance")):
            _over_thickness(grid[row, 1], what, np.array([pair[row] for pair in both]))
    coating = f", coating {flake.coating_nm:g} nm" if coated else ""
    figure.suptitle(
        f"{name}{coating}, platelet {flake.platelet_nm:g} ± {flake.spread_nm:g} nm, "
        f"binder {binder_ior:g}"
    )
    figure.savefig(file, dpi=110)
    plt.close(figure)


def _over_angle(axes: Axes, what: str, values: Array) -> None:
    """The curves of R, G and B above a strip of the colour itself."""
    for channel, colour in enumerate(("#c03028", "#2c8c3c", "#2858c0")):
        axes.plot(ANGLES, values[:, channel], color=colour)
    swatch = encoded_srgb(values)[np.newaxis]
    axes.imshow(swatch, extent=(0, 90, -0.25, -0.05), aspect="auto", interpolation="nearest")
    axes.set(xlim=(0, 90), ylim=(-0.25, 1.1), xlabel="α in the binder (°)", ylabel=what)


def _over_thickness(axes: Axes, what: str, values: Array) -> None:
    most = min(values[:, 0].max(), 1)  # the first angle's: at grazing incidence all is white
    swatch = encoded_srgb(values / most).swapaxes(0, 1)
    extent = (THICKNESSES[0], THICKNESSES[-1], ANGLES[0], ANGLES[-1])
    axes.imshow(swatch, extent=extent, aspect="auto", origin="lower")
    axes.set(xlabel="thickness of the coating (nm)", ylabel="α (°)", title=f"{what} / {most:.2f}")
