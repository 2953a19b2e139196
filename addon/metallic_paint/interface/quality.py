# SPDX-License-Identifier: GPL-3.0-or-later
"""Buttons for Draft, Final and Reference."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import EnumProperty

from ..scene.quality import IN_REFERENCE_ALONE, QUALITIES, apply, is_set
from . import operators
from .panel import SubPanel, draw_lines

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems


class SCENE_OT_metallic_paint_quality(bpy.types.Operator):
    """Set samples, noise threshold and clamping of this scene for sparkles of this quality, and \
tell what they were. The paints stay as they are"""

    bl_idname = "scene.metallic_paint_quality"
    bl_label = "Set Quality"
    bl_options = {"REGISTER", "UNDO"}

    quality: EnumProperty(
        name="Quality",
        description="How exactly sparkles are drawn",
        items=[(key, key.title(), each.description) for key, each in QUALITIES.items()],
        default="FINAL",
    )

    @classmethod
    def description(
        cls, context: bpy.types.Context, properties: bpy.types.OperatorProperties
    ) -> str:
        return QUALITIES[properties.quality].description

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if context.scene.render.engine != "CYCLES":
            cls.poll_message_set("The scene does not render with Cycles")
            return False
        return operators.can_change(cls, context.scene, "scene")

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        for sentence in apply(context.scene, self.quality):
            self.report({"INFO"}, sentence)
        return {"FINISHED"}


class MATERIAL_PT_metallic_paint_quality(SubPanel):
    bl_label = "Quality"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return hasattr(context.scene, "cycles")  # its add-on may be off

    def draw(self, context: bpy.types.Context) -> None:
        row = self.layout.row(align=True)
        name = SCENE_OT_metallic_paint_quality.bl_idname
        for key in QUALITIES:
            row.operator(name, text=key.title(), depress=is_set(context.scene, key)).quality = key
        draw_lines(
            self.layout,
            "Sets samples, noise threshold and clamping; Reference also "
            f"{IN_REFERENCE_ALONE}, which Draft and Final put back. The paints stay.",
        )


register, unregister = bpy.utils.register_classes_factory(
    (SCENE_OT_metallic_paint_quality, MATERIAL_PT_metallic_paint_quality)
)
