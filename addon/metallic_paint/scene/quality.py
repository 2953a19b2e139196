# SPDX-License-Identifier: GPL-3.0-or-later
"""Draft, Final and Reference: the render settings that decide how exactly sparkles are drawn.

The paint itself has no cheaper choice to offer (docs/accuracy): of those that the shader knows,
none is as fast and as exact as what ships, a thinned depth saves 8 % of the shader alone, and the
published radiometry is another mean, not another price. So the paints stay as they are, and their
look with them; Reference names those that differ from the exact model.

What a sparkle's brightness errs at is noise: Cycles picks one lamp, or the world, for each sample.
On a ball under a sun and an uneven world it was 15 % at 32 samples, 5 % at 256 and at a noise
threshold of 0.01, 10 % at one of 0.1. Clamp Direct cuts what makes a sparkle, at any quality.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import bpy

from ..paint import PaintError, material
from . import placed

_Settings = dict[str, bool | int | float]  # values of scene.cycles by their names there


@dataclass(frozen=True)
class Quality:
    description: str
    settings: _Settings


IN_REFERENCE_ALONE = "Time Limit, Light Sampling Threshold and Filter Glossy"

QUALITIES = {
    "DRAFT": Quality(
        "To see where it sparkles: a sparkle's brightness errs by some 10 %",
        {
            "use_adaptive_sampling": True, "adaptive_threshold": 0.1, "adaptive_min_samples": 0,
            "samples": 64, "sample_clamp_direct": 0.0, "sample_clamp_indirect": 10.0,
        },
    ),
    "FINAL": Quality(
        "For pictures: a sparkle's brightness errs by some 3 to 5 %",
        {
            "use_adaptive_sampling": True, "adaptive_threshold": 0.01, "adaptive_min_samples": 0,
            "samples": 1024, "sample_clamp_direct": 0.0, "sample_clamp_indirect": 10.0,
        },
    ),
    "REFERENCE": Quality(
        "To compare others with: every sample is taken, and nothing is clamped or left to chance. "
        f"Also sets {IN_REFERENCE_ALONE} to 0; Draft and Final put them back",
        {
            "use_adaptive_sampling": False, "samples": 4096, "time_limit": 0.0,
            "sample_clamp_direct": 0.0, "sample_clamp_indirect": 0.0,
            "light_sampling_threshold": 0.0, "blur_glossy": 0.0,
        },
    ),
}  # fmt: skip

_ALONE = sorted(QUALITIES["REFERENCE"].settings.keys() - QUALITIES["FINAL"].settings.keys())
_BEFORE = "metallic_paint_before_reference"  # property of a scene: what it had of these

# Choices of a paint that are its exact model.
_EXACT = {"depth_model": "correlated", "radiometry": "exact", "composition": "exact"}


def apply(scene: bpy.types.Scene, quality: str) -> list[str]:
    """Sets the scene's render settings to a quality; returns what it changed, with what it was.

    Draft and Final put back what Reference alone sets, unless it was changed since.

    Raises ValueError for a quality that is not in QUALITIES.
    """
    if quality not in QUALITIES:
        raise ValueError(f"quality is {quality!r} and must be one of {', '.join(QUALITIES)}.")
    cycles, settings, before = scene.cycles, QUALITIES[quality].settings, _before_reference(scene)
    if quality == "REFERENCE":
        found = {name: getattr(cycles, name) for name in _others(scene, settings)}
        scene[_BEFORE] = before | {name: found[name] for name in _ALONE if name in found}
    else:
        settings = settings | before
        scene.pop(_BEFORE, None)
    changed = []
    for name, value in _others(scene, settings).items():
        was = getattr(cycles, name)
        setattr(cycles, name, value)
        label = cycles.bl_rna.properties[name].name
        changed.append(f"{label}: {_shown(was)} → {_shown(value)}.")
    if quality == "REFERENCE":
        changed += _inexact_paints(scene)
        if cycles.use_denoising:
            changed.append("Denoising stays on: a reference has none.")
    return changed or ["All settings are so already."]


def is_set(scene: bpy.types.Scene, quality: str) -> bool:
    """Whether the scene has all settings of that quality."""
    return not _others(scene, QUALITIES[quality].settings)


def _others(scene: bpy.types.Scene, settings: _Settings) -> _Settings:
    """Those that the scene has otherwise."""
    return {name: value for name, value in settings.items()
            if abs(getattr(scene.cycles, name) - value) > 1e-6}  # fmt: skip


def _before_reference(scene: bpy.types.Scene) -> _Settings:
    """Of what still is as Reference alone sets it; Blender's defaults where an older version did,
    which kept no record."""
    reference = QUALITIES["REFERENCE"].settings
    before: _Settings = {}
    if _BEFORE in scene:
        before = dict(scene[_BEFORE])
    elif is_set(scene, "REFERENCE"):
        before = {name: scene.cycles.bl_rna.properties[name].default for name in _ALONE}
    return {
        name: value for name, value in before.items()
        if getattr(scene.cycles, name) == reference[name]
    }  # fmt: skip


def _shown(value: bool | int | float) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:.4g}"


def _inexact_paints(scene: bpy.types.Scene) -> Iterator[str]:
    layers = placed.used_layers(scene)
    things = {thing: None for layer in layers for thing in placed.rendered(layer)}
    slots = [slot.material for thing in things for slot in thing.material_slots]
    for painted in dict.fromkeys(slots):
        if painted is None or not material.has_paint(painted):
            continue
        try:
            paint = material.paint_of(painted)
        except PaintError as error:
            yield f"{painted.name}: {error}"
            continue
        for name, exact in _EXACT.items():
            if getattr(paint, name) != exact:
                found = getattr(paint, name)
                yield f"{painted.name} keeps its {name.replace('_', ' ')} {found}, not {exact}."
