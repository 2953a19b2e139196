# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights that follow by themselves: the paints are fitted to the scene again when it changed.

Handlers only start a timer, which fits once the scene has been at rest for a moment. Without a
window there are no timers, and the handler fits at once. While Cycles renders, nothing happens:
drivers do what an animation needs.
"""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from . import lights, needs

REST_SECONDS = 0.3

_state = {"rendering": False, "fitting": False}


def follow() -> float | None:
    """Fits the paints to the scene if it changed since; returns after how many seconds to retry."""
    if _state["rendering"]:
        return REST_SECONDS
    if _state["fitting"]:
        return None
    _state["fitting"] = True  # fit updates the scene, which calls the handlers
    try:
        if not needs.is_fitted(bpy.context.scene):
            needs.fit(bpy.context.scene)
    finally:
        _state["fitting"] = False
    return None


@persistent
def _changed(*_: object) -> None:
    if _state["fitting"] or not lights.groups():
        return
    if bpy.app.background:
        follow()
        return
    _stop_timer()
    bpy.app.timers.register(follow, first_interval=REST_SECONDS)


@persistent
def _before_saving(*_: object) -> None:
    """The timer may not have come yet, nor Blender's own update."""
    bpy.context.view_layer.update()
    follow()


@persistent
def _render_begins(*_: object) -> None:
    _state["rendering"] = True


@persistent
def _render_ended(*_: object) -> None:
    _state["rendering"] = False


def _stop_timer() -> None:
    if bpy.app.timers.is_registered(follow):
        bpy.app.timers.unregister(follow)


_HANDLERS = {
    "depsgraph_update_post": _changed,
    "load_post": _changed,
    "undo_post": _changed,
    "redo_post": _changed,
    "save_pre": _before_saving,
    "render_init": _render_begins,
    "render_complete": _render_ended,
    "render_cancel": _render_ended,
}


def register() -> None:
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    _stop_timer()
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
