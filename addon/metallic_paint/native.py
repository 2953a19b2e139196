# SPDX-License-Identifier: GPL-3.0-or-later
"""The native module, metallic_paint_core, as the add-on uses it: the paint works without it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .scene import carrier

if TYPE_CHECKING:
    from metallic_paint_core._native import Light


def core_missing() -> str:
    """Why the native module cannot be used, in a sentence; empty where it can."""
    try:
        import metallic_paint_core  # noqa: F401
    except ImportError as error:
        if error.name == "metallic_paint_core":
            return "This build of the add-on has no native module for this Blender."
        return f"The native module metallic_paint_core cannot be loaded: {error}."
    return ""


def core_lights() -> list[Light]:
    """The slots in use, as the core takes them."""
    import metallic_paint_core as core

    return [core.Light(core.LightKind(kind), vector, size)
            for kind, vector, size in carrier.values()]  # fmt: skip
