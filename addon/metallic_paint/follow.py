# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights that follow by themselves: the paints are fitted to the scene again when it changed.

Handlers only start a timer, which fits once the scene has been at rest for a moment. Without a
window there are no timers, and the handler fits at once, before a render too. While Cycles renders,
nothing happens: drivers do what an animation needs.

Undo frees lamps. What points at them in a group that both of its steps share would outlive them, so
the slots let go before. (A step of undo for each fit would end redo.)
"""

from __future__ import annotations

import threading

import bpy
from bpy.app.handlers import persistent

from . import lights, needs

REST_SECONDS = 0.3

_state = {"rendering": False, "fitting": False}


def follow() -> float | None:
    """Fits the paints to the scene if it changed since; returns after how many seconds to retry."""
    if _is_rendering():
        return REST_SECONDS
    _fit(bpy.context.scene)
    return None


def _fit(scene: bpy.types.Scene) -> None:
    if _state["fitting"] or not hasattr(scene, "cycles"):  # the add-on of Cycles may be off
        return
    _state["fitting"] = True  # fit updates the scene, which calls the handlers
    try:
        if not needs.is_fitted(scene):
            needs.fit(scene)
    finally:
        _state["fitting"] = False


def _is_rendering() -> bool:
    """Handlers tell it only where renders are no jobs: one that fails may tell of no end."""
    return _state["rendering"] if bpy.app.background else bpy.app.is_job_running("RENDER")


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
def _loaded(*_: object) -> None:
    _state["rendering"] = False
    _changed()


@persistent
def _before_undo(*_: object) -> None:
    needs.let_go()


@persistent
def _before_saving(*_: object) -> None:
    """The timer may not have come yet, nor Blender's own update."""
    _state["rendering"] = False
    bpy.context.view_layer.update()
    follow()


@persistent
def _render_begins(scene: bpy.types.Scene, *_: object) -> None:
    # A window renders in a thread of its own, where nothing may be changed.
    if threading.current_thread() is threading.main_thread() and lights.uses_paint(scene):
        _fit(scene)
    _state["rendering"] = True


@persistent
def _render_ended(*_: object) -> None:
    """The scene that rendered need not be the one that is worked on."""
    _state["rendering"] = False
    _changed()


def _stop_timer() -> None:
    if bpy.app.timers.is_registered(follow):
        bpy.app.timers.unregister(follow)


_HANDLERS = {
    "depsgraph_update_post": _changed,
    "load_post": _loaded,
    "undo_pre": _before_undo,
    "redo_pre": _before_undo,
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
