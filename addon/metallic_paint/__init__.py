# SPDX-License-Identifier: GPL-3.0-or-later
"""Metallic paint with sparkling flakes for Cycles.

paint/      what a paint is, its presets, and the material that shows it
scene/      what a scene gives to its paints and asks of them: lights, needs, render settings
verify/     the artist's own scene against the core
denoise.py  compositing that denoises all but the sparkles
interface/  operators, menus, panels and preferences
"""

from __future__ import annotations

import importlib
from types import ModuleType

ADD_ON = __name__  # as Blender knows it

# Each has register() and unregister().
_MODULES = (
    "interface.operators", "interface.preset_operators", "interface.live",
    "interface.rest_position", "interface.panel", "scene.follow", "scene.imports",
    "interface.library", "interface.denoise", "interface.quality", "interface.report",
    "interface.verify",
)  # fmt: skip


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()


def _modules() -> list[ModuleType]:
    """Imported here: tools read presets where there is no Blender."""
    return [importlib.import_module(f".{name}", __package__) for name in _MODULES]
