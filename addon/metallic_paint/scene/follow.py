# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits the paints to the scene again whenever the scene changed (needs.py).

Blender calls handlers when something changes, in a render from another thread. They only note the
change. A timer fits the paints once the scene has been at rest for a moment. Without a window there
are no timers, so the handler fits at once, and before a render too. While Cycles renders, nothing
is fitted: the slots' drivers follow an animation by themselves.

Where a light is an instance that no driver follows, its place is renewed with each change and each
frame, in a render too.

Undo frees lamps. The slots' drivers would go on pointing at a freed lamp, because both steps of
undo share their group. So the slots let go of all lamps before an undo. (A step of undo of its own
for each fit would end redo.)
"""

from __future__ import annotations

import sys
import threading
import time
import traceback
from dataclasses import dataclass

import bpy
from bpy.app.handlers import persistent

from ..paint import live, material
from . import lights, needs, placed, sky

REST_SECONDS = 0.3


@dataclass
class _State:
    rendering: bool = False
    changed: bool = False  # since the last look
    changed_at: float = 0.0  # s
    repaint: bool = False  # a paint may have changed since the Solid view last followed
    shown: frozenset[str] = frozenset()  # the scenes in windows, at the last look
    trouble: str = ""  # why the last fit failed; empty after one that did not


_state = _State()


def follow() -> float:
    """The timer's function; returns after how many seconds to look again.

    Blender ends a timer for good whose function raises. So an error is told once, with its
    traceback in the console, and the next change is followed again.
    """
    try:
        _look_for_another_scene()
        if _state.changed and time.monotonic() - _state.changed_at >= REST_SECONDS:
            _fit_if_changed()
    except Exception as error:
        _tell(error)
    return REST_SECONDS


def _look_for_another_scene() -> None:
    """In a window: no handler tells of it."""
    windows = bpy.context.window_manager.windows
    shown = frozenset(window.scene.name_full for window in windows)
    if shown != _state.shown:
        _state.shown = shown
        _changed()


def trouble() -> str:
    """Why the paints do not have the scene's lights, in a sentence; empty where they do."""
    return _state.trouble


def _tell(error: Exception) -> None:
    """For the panel, and for the console unless it has been told the same already."""
    said = f"The lights could not follow the last change ({error}): press Update Lights."
    if said != _state.trouble:
        traceback.print_exception(error)
        print(f"Metallic Paint: {said}", file=sys.stderr)
    _state.trouble = said


def _fit_if_changed() -> None:
    """Not while it renders: the timer comes again."""
    if _is_rendering():
        return
    _state.changed = False
    if lights.has_any():
        _fit(needs.scene_to_fit(bpy.context.scene))
        if _state.repaint and not _shows_renders():
            _state.repaint = False
            material.follow_in_solid_view()


def _fit(scene: bpy.types.Scene) -> None:
    # The add-on of Cycles may be off.
    if hasattr(scene, "cycles") and not needs.is_fitting():
        if not needs.is_fitted(scene):
            needs.fit(scene)
        for layer in placed.used_layers(scene):
            lights.renew(layer.depsgraph)
        _state.trouble = ""


def _is_rendering() -> bool:
    """Handlers tell it only where renders are no jobs: one that fails may tell of no end."""
    return _state.rendering if bpy.app.background else bpy.app.is_job_running("RENDER")


def _shows_renders() -> bool:
    """Whether a view is Rendered: there Cycles would compile the paint anew for its other look."""
    areas = (area for window in bpy.context.window_manager.windows for area in window.screen.areas)
    views = (area.spaces.active for area in areas if area.type == "VIEW_3D")
    return any(view.shading.type == "RENDERED" for view in views)


@persistent
def _changed(*_: object) -> None:
    if needs.is_fitting():
        return
    _state.repaint = True
    _state.changed, _state.changed_at = True, time.monotonic()
    if bpy.app.background:
        _fit_if_changed()


@persistent
def _frame_changed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Also while Cycles renders an animation: Blender then evaluates what is renewed once more."""
    lights.renew(depsgraph)
    if any(map(needs.world_is_animated, sky.worlds(scene))):
        _changed()  # no driver follows its sun


@persistent
def _loaded(*_: object) -> None:
    _state.rendering, _state.trouble = False, ""
    _changed()


@persistent
def _before_undo(*_: object) -> None:
    needs.let_go()


@persistent
def _before_saving(*_: object) -> None:
    """The timer may not have come yet, nor Blender's own update."""
    _state.rendering = False
    bpy.context.view_layer.update()
    try:
        _fit_if_changed()
    finally:
        live.settle_all()


@persistent
def _render_begins(scene: bpy.types.Scene, *_: object) -> None:
    # A window renders in a thread of its own, where nothing may be changed.
    if threading.current_thread() is threading.main_thread() and lights.uses_paint(scene):
        _fit(scene)
    _state.rendering = True


@persistent
def _render_ended(*_: object) -> None:
    """The scene that rendered need not be the one that is worked on."""
    _state.rendering = False
    _changed()


_HANDLERS = {
    "depsgraph_update_post": _changed,
    "frame_change_post": _frame_changed,
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
    _state.changed = True  # a file may be open
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)
    bpy.app.timers.register(follow, first_interval=REST_SECONDS, persistent=True)


def unregister() -> None:
    """Other scripts may have cleared the lists."""
    if bpy.app.timers.is_registered(follow):
        bpy.app.timers.unregister(follow)
    for name, handler in _HANDLERS.items():
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
