# SPDX-License-Identifier: GPL-3.0-or-later
"""The button that reports on the scene, and what it said."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import bpy

from ..scene.report import ERROR, INFO, WARNING, report
from . import operators
from .panel import DiagnosticsPanel, draw_lines

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import IconItems, OperatorReturnItems

_ICONS: dict[str, IconItems] = {INFO: "BLANK1", WARNING: "ERROR", ERROR: "CANCEL"}
_KEY = "metallic_paint_report"  # custom property of the window manager: not in the file


class SCENE_OT_metallic_paint_report(bpy.types.Operator):
    """Look at the scene as the camera does: what its paints need, how many sparkles a pixel has, \
and which settings would spoil them"""

    bl_idname = "scene.metallic_paint_report"
    bl_label = "Report on Scene"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        editable = operators.can_change(cls, context.scene, "scene")
        return editable and operators.has_cycles(cls, context)

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        lines = report(context.scene)
        context.window_manager[_KEY] = json.dumps({context.scene.name_full: lines})
        bad = [sentence for level, sentence in lines if level != INFO]
        for sentence in bad:
            self.report({WARNING}, sentence)
        if not bad:
            self.report({INFO}, "Nothing spoils the sparkles.")
        return {"FINISHED"}


class MATERIAL_PT_metallic_paint_report(DiagnosticsPanel):
    bl_label = "Scene Report"

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.operator(SCENE_OT_metallic_paint_report.bl_idname)
        found = json.loads(context.window_manager.get(_KEY, "{}"))
        for level, sentence in found.get(context.scene.name_full, ()):
            draw_lines(self.layout, sentence, _ICONS[level])


register, unregister = bpy.utils.register_classes_factory(
    (SCENE_OT_metallic_paint_report, MATERIAL_PT_metallic_paint_report)
)
