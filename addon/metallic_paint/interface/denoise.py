# SPDX-License-Identifier: GPL-3.0-or-later
"""Buttons that set up the denoising that keeps the sparkles, and take it back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..denoise import SET_UP, is_set_up, outdated, remove, set_up, why_not, why_not_remove
from .panel import SubPanel, draw_lines

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems


class SCENE_OT_metallic_paint_denoise(bpy.types.Operator):
    """Denoise everything but the sparkles, by nodes of the compositor. The sun of an environment \
image becomes a lamp for this"""

    bl_idname = "scene.metallic_paint_denoise"
    bl_label = SET_UP
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if reason := why_not(context.scene):
            cls.poll_message_set(reason)
        return not reason

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        for sentence in set_up(context.scene):
            self.report({"INFO"}, sentence)
        return {"FINISHED"}


class SCENE_OT_metallic_paint_denoise_remove(bpy.types.Operator):
    """Take compositing, passes, light groups and the world's sun back to what they were before"""

    bl_idname = "scene.metallic_paint_denoise_remove"
    bl_label = "Remove Sparkle Denoising"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if reason := why_not_remove(context.scene):
            cls.poll_message_set(reason)
        return not reason

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        for sentence in remove(context.scene):
            self.report({"INFO"}, sentence)
        return {"FINISHED"}


class MATERIAL_PT_metallic_paint_denoise(SubPanel):
    bl_label = "Denoising"

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column()
        column.operator(SCENE_OT_metallic_paint_denoise.bl_idname)
        if is_set_up(context.scene):
            column.operator(SCENE_OT_metallic_paint_denoise_remove.bl_idname)
        if reason := why_not(context.scene) or outdated(context.scene):
            draw_lines(column, f"{reason}.", "INFO")


register, unregister = bpy.utils.register_classes_factory(
    (
        SCENE_OT_metallic_paint_denoise,
        SCENE_OT_metallic_paint_denoise_remove,
        MATERIAL_PT_metallic_paint_denoise,
    )
)
