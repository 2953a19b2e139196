# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits the paints to the scene again whenever the scene changed (needs.py).

Blender calls handlers when something changes, in a render from another thread. They only note the
change. A timer fits the paints once the scene has been at rest for a moment. Without a window there
are no timers, so the handler fits at once, and before a render too. While Cycles renders, nothing
is fitted: the slots' drivers follow an animation by themselves.

Most changes are moves, which drivers follow, and steps of live sliders, which the carrier has. The
depsgraph tells them from others, so that work after an edit does not grow with the scene. It tells
no more of an object than that it moved, if a script hides it or gives it another name in the same
step: that is found with the next change, and before a render without a window.

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
from collections.abc import Iterable
from dataclasses import dataclass, field

import bpy
from bpy.app.handlers import persistent

from ..paint import live, material
from . import carrier, lights, needs, placed, sky

REST_SECONDS = 0.3


@dataclass
class _State:
    rendering: bool = False
    changed: bool = False  # since the last look
    changed_at: float = 0.0  # s
    repaint: set[int] = field(default_factory=set)  # materials that the Solid view has to follow
    stepped: bool = False  # a live value may have changed since then
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
        if time.monotonic() - _state.changed_at >= REST_SECONDS:
            _catch_up()
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


def _catch_up() -> None:
    """Not while it renders: the timer comes again."""
    if _is_rendering():
        return
    if _state.changed:
        _state.changed = False
        if lights.has_any():
            _fit(needs.scene_to_fit(bpy.context.scene))
    if (_state.repaint or _state.stepped) and not _shows_renders():
        # A new look has Cycles compile the paint anew, where it keeps what is compiled.
        kept = any(scene.render.use_persistent_data for scene in bpy.data.scenes)
        stepped = live.stepped() if _state.stepped and not kept else set()
        material.follow_in_solid_view(_state.repaint, stepped)
        _state.repaint, _state.stepped = set(), _state.stepped and kept


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
    """Whatever it was."""
    if not needs.is_fitting():
        _state.changed = True
        _wait_for_rest()


@persistent
def _updated(_: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None) -> None:
    if depsgraph is None or needs.is_fitting():
        _changed()
        return
    updates = depsgraph.updates
    paints = depsgraph.id_type_updated("MATERIAL") or depsgraph.id_type_updated("NODETREE")
    for update in updates if paints else ():
        if isinstance(update.id, bpy.types.Material):
            _state.repaint.add(update.id.original.session_uid)
        elif carrier.is_one(update.id):  # by a slider, or a fit: a lamp that moves tags nothing
            _state.stepped |= update.is_updated_geometry
    if not updates or not _are_followed(updates):
        _state.changed = True
    if _state.changed or _state.repaint or _state.stepped:
        _wait_for_rest()


def _are_followed(updates: Iterable[bpy.types.DepsgraphUpdate]) -> bool:
    """Whether all are moves that drivers follow, or changes of the carrier."""
    in_slots, rank = set(lights.in_slots()), carrier.is_full()
    moves = False
    for update in updates:
        thing = update.id
        if isinstance(thing, bpy.types.Object):
            more = update.is_updated_geometry or update.is_updated_shading
            if more or not update.is_updated_transform or (rank and _ranks(thing)):
                return False
            if thing.type == "LIGHT" and thing.original not in in_slots:
                return False
            moves = True
        elif not carrier.is_one(thing):
            return False
    return not (moves and carrier.not_followed())


def _ranks(thing: bpy.types.Object) -> bool:
    """Whether its place may decide which lights have the slots, of more than there are."""
    return thing.type == "LIGHT" or thing.instance_type != "NONE" or carrier.is_carried_by(thing)


def _wait_for_rest() -> None:
    _state.changed_at = time.monotonic()
    if bpy.app.background:
        _catch_up()


@persistent
def _frame_changed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Also while Cycles renders an animation: Blender then evaluates what is renewed once more."""
    lights.renew(depsgraph)
    if any(map(needs.world_is_animated, sky.worlds(scene))):
        _changed()  # no driver follows its sun


@persistent
def _loaded(*_: object) -> None:
    _state.rendering, _state.trouble = False, ""
    _changed_everywhere()


@persistent
def _changed_everywhere(*_: object) -> None:
    """No update tells what undo brings back."""
    _state.repaint = {each.session_uid for each in bpy.data.materials}
    _changed()


@persistent
def _before_undo(*_: object) -> None:
    needs.let_go()


@persistent
def _before_saving(*_: object) -> None:
    """The timer may not have come yet, nor Blender's own update."""
    _state.rendering = False
    bpy.context.view_layer.update()
    _state.changed = True  # not every change has Blender update anything
    try:
        _catch_up()
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
    "depsgraph_update_post": _updated,
    "frame_change_post": _frame_changed,
    "load_post": _loaded,
    "undo_pre": _before_undo,
    "redo_pre": _before_undo,
    "undo_post": _changed_everywhere,
    "redo_post": _changed_everywhere,
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
