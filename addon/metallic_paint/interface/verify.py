# SPDX-License-Identifier: GPL-3.0-or-later
"""The button that checks the artist's own scene against the core, and what it found."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import IntProperty

from ..native import core_missing
from ..verify.check import Found, VerifyError
from ..verify.job import SECONDS, SIZE, Job, run, why_not
from .panel import DiagnosticsPanel, draw_lines

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

_KEY = "metallic_paint_verified"  # custom property of the window manager: not in the file

_ENDS = (VerifyError, OSError)  # what a check may end in: also a full disk

_running: list[Job] = []  # at most one: what the panel shows while the operator runs


class SCENE_OT_metallic_paint_verify(bpy.types.Operator):
    """Render the region where the active object sparkles most, in the background, and compare \
each pixel with the core, the reference in C++. The pictures become images of this file"""

    bl_idname = "scene.metallic_paint_verify"
    bl_label = "Verify Against Core"
    bl_options = {"REGISTER", "UNDO"}

    size: IntProperty(
        name="Size", description="Pixels along each side of the region", default=SIZE, min=8,
        max=1024, subtype="PIXEL",
    )  # fmt: skip

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        reason = "A check is running already" if _running else ""
        if reason := reason or why_not(context.scene, context.object):
            cls.poll_message_set(reason)
        return not reason

    def invoke(
        self, context: bpy.types.Context, event: bpy.types.Event
    ) -> set[OperatorReturnItems]:
        if context.window is None:
            return self.execute(context)
        try:
            _running.append(Job(context.scene, context.object, self.size))
        except _ENDS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._timer = context.window_manager.event_timer_add(SECONDS, window=context.window)
        context.window_manager.progress_begin(0, 1)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[OperatorReturnItems]:
        if event.type == "ESC" and event.value == "PRESS":
            self.cancel(context)
            self.report({"INFO"}, "The check was stopped")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        [job] = _running
        ended = True  # also by an error of ours, which Blender shows with its traceback
        try:
            ended = job.poll()
            if not ended:
                context.window_manager.progress_update(job.progress)
                _redraw(context)
                return {"PASS_THROUGH"}
            job.pictures()
        except _ENDS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            if ended:
                self.cancel(context)
        _show(self, context, job.found)
        return {"FINISHED"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender calls it too, when it closes."""
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        _running.pop().close()
        _redraw(context)

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        try:
            found = run(context.scene, context.object, self.size)
        except _ENDS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        _show(self, context, found)
        return {"FINISHED"}


def _show(operator: bpy.types.Operator, context: bpy.types.Context, found: Found) -> None:
    context.window_manager[_KEY] = str(found)
    for line in str(found).splitlines():
        operator.report({"INFO" if found.agrees else "WARNING"}, line)


def _redraw(context: bpy.types.Context) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


class MATERIAL_PT_metallic_paint_verify(DiagnosticsPanel):
    bl_label = "Verify"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        if missing := core_missing():
            draw_lines(layout, f"{missing} The paint works without it.", "INFO")
            return
        layout.operator(SCENE_OT_metallic_paint_verify.bl_idname)
        if _running:
            [job] = _running
            layout.progress(factor=job.progress, text=f"{job.what}; Esc stops")
        elif text := context.window_manager.get(_KEY, ""):
            draw_lines(layout, text)


_CLASSES = (SCENE_OT_metallic_paint_verify, MATERIAL_PT_metallic_paint_verify)
_register, _unregister = bpy.utils.register_classes_factory(_CLASSES)


def register() -> None:
    _register()


def unregister() -> None:
    while _running:
        _running.pop().close()
    _unregister()
