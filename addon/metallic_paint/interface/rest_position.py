# SPDX-License-Identifier: GPL-3.0-or-later
"""The button that lets sparkles follow what deforms."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..scene import rest_position
from . import operators

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems


class SCENE_OT_metallic_paint_add_rest_position(bpy.types.Operator):
    """Let the sparkles of this scene follow what deforms: switch on Add Rest Position of each \
painted object that armatures, shape keys, cloth or the like move, and connect the attribute \
rest_position with its paints"""

    bl_idname = "scene.metallic_paint_add_rest_position"
    bl_label = "Add Rest Position"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if any(map(rest_position.lacks, context.scene.objects)):
            return True
        cls.poll_message_set("No painted object of this scene deforms and lacks a rest position")
        return False

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        report = rest_position.give(context.scene)
        operators.report_of(self, str(report), "WARNING" if report.left else "INFO")
        return {"FINISHED"} if report.given else {"CANCELLED"}


register, unregister = bpy.utils.register_classes_factory(
    (SCENE_OT_metallic_paint_add_rest_position,)
)
