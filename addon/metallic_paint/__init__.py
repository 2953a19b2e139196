# SPDX-License-Identifier: GPL-3.0-or-later
"""Metallic paint with sparkling flakes for Cycles.

paint.py      what a paint is: fields, units, ranges
presets.py    paints as files
shader.py     the OSL text, and its compilation into a script node
material.py   the node group and the material around the shader
lights.py     the lights that sparkle, fed to every paint of the file by drivers
needs.py      what a scene requires of its paints; the rest is left out
migration.py  paints of older versions, made anew

operators.py         new paints, the scene's lights, Cycles with OSL, updates
preset_operators.py  presets: their menu, apply, load, save
panel.py             the panel in material properties and shader editor, and the Add menu
follow.py            lights that follow by themselves
imports.py           what comes along with a paint from another file and does not belong to it
library.py           the asset library, in the add-on's preferences
denoise.py           compositing that denoises all but the sparkles
quality.py           draft, final, reference: the render settings for sparkles
scene_report.py      what a scene needs, what the camera sees of the flakes, what spoils them
verify_operator.py   the artist's own scene against the core, in another process
"""

from __future__ import annotations

import importlib
from types import ModuleType

# Each has register() and unregister().
_MODULES = ("operators", "preset_operators", "panel", "follow", "imports",
            "library", "denoise", "quality", "scene_report", "verify_operator")  # fmt: skip


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()


def _modules() -> list[ModuleType]:
    """Imported here: tools read presets where there is no Blender."""
    return [importlib.import_module(f".{name}", __package__) for name in _MODULES]
