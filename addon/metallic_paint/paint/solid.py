# SPDX-License-Identifier: GPL-3.0-or-later
"""What the Solid view shows of a paint: a colour, how metallic it is, and how rough."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import coatings
from .parameters import Paint

# The Solid view has nothing that metal could mirror but a few lamps: flat sides would be black.
_MOST_METALLIC = 0.4


@dataclass(frozen=True)
class Look:
    """As a material has it for the viewport."""

    color: tuple[float, float, float]  # linear RGB
    metallic: float
    roughness: float


def look(paint: Paint) -> Look:
    """The flakes over the substrate, without sparkle or gloss, the mean of all angles."""
    covered = np.array([each.flake_coverage for each in paint.species])
    faces = [coatings.means(each) for each in paint.species]
    whole = max(covered.sum(), 1e-30)
    reflected = covered @ np.array([reflectance for reflectance, _ in faces]) / whole
    passed = covered @ np.array([transmittance for _, transmittance in faces]) / whole
    # Where flakes let light through it goes on as through a gap.
    gaps = np.exp(-covered.sum() * (1 - passed))
    # On the average, flakes lie in the middle: there and back is once through the layer.
    once = np.exp(-np.array(paint.binder_absorption_per_mm) * paint.layer_thickness_um * 1e-3)
    flakes = once * (1 - np.exp(-covered.sum())) * reflected
    ground = once * once * gaps * np.array(paint.substrate_color)
    color = np.minimum(flakes + ground, 1)
    return Look(
        color=tuple(color.tolist()),
        metallic=float(_MOST_METALLIC * flakes.sum() / max((flakes + ground).sum(), 1e-30)),
        roughness=_roughness(paint, covered),
    )


def _roughness(paint: Paint, covered: np.ndarray) -> float:
    """Of the flakes' reflection, as in the preview; of the coat where there are none."""
    if not covered.any():
        return paint.coat_roughness
    slopes = [each.tilt**2 * (2 if each.orientation == "gaussian" else 1) for each in paint.species]
    slope2 = covered @ np.array(slopes) / covered.sum()
    return float(min((paint.binder_ior**2 * slope2) ** 0.25, 1))
