# SPDX-License-Identifier: GPL-3.0-or-later
"""Live sliders of a paint: the button, and what a copy of such a paint is offered."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..paint import PaintError, live, material
from ..scene import needs
from . import operators

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems


class MATERIAL_OT_metallic_paint_live(operators.ChangesPaint):
    """Let the Rendered view follow this paint's numbers and colours at once. Blender compiles the \
paint once for this, and a sample takes a fifth longer. A part of the paint that is 0 now stays \
away: add it, then switch this off and on again"""

    bl_idname = "material.metallic_paint_live"
    bl_label = "Live Sliders"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        node = operators.paint_node(context)
        if live.is_live(node):
            if (animated := live.animated(node)) and not live.is_shared(node):
                lost = f"keys or drivers, which would be lost: {', '.join(animated)}"
                self.report({"ERROR"}, f"Live values have {lost}")
                return {"CANCELLED"}
            live.end(node)
            return {"FINISHED"}
        if file := material.linked_from(node):
            self.report({"ERROR"}, f"The paint's shader is linked from {file}: append it")
            return {"CANCELLED"}
        try:
            count = live.begin(node, material.paint_of(node))
        except PaintError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not count:
            self.report({"WARNING"}, "All values of the paint are 0, linked or animated")
            return {"CANCELLED"}
        needs.fit(context.scene)
        return {"FINISHED"}


class MATERIAL_OT_metallic_paint_live_single(operators.ChangesPaint):
    """Give this paint live values of its own, which are the same at first. Keys and drivers stay \
with those of the other paint"""

    bl_idname = "material.metallic_paint_live_single"
    bl_label = "Make Single"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not super().poll(context):
            return False
        if not live.is_shared(operators.paint_node(context)):
            cls.poll_message_set("No other paint has these live values")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        live.make_single(operators.paint_node(context))
        return {"FINISHED"}


def draw(layout: bpy.types.UILayout, node: bpy.types.ShaderNodeGroup) -> None:
    """A button that stays pressed, and beside it what a copy needs."""
    row = layout.row(align=True)
    row.operator(MATERIAL_OT_metallic_paint_live.bl_idname, icon="PLAY", depress=live.is_live(node))
    if live.is_shared(node):
        row.operator(MATERIAL_OT_metallic_paint_live_single.bl_idname, icon="UNLINKED")


register, unregister = bpy.utils.register_classes_factory(
    (MATERIAL_OT_metallic_paint_live, MATERIAL_OT_metallic_paint_live_single)
)
