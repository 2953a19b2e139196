# SPDX-License-Identifier: GPL-3.0-or-later
"""The button Live Sliders."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..paint import PaintError, live, material
from ..scene import needs
from . import operators

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems


class MATERIAL_OT_metallic_paint_live(bpy.types.Operator):
    """Let the Rendered view follow this paint's numbers and colours at once. Blender prepares the \
paint once more, and then no more for a step of a slider, nor for keys on it. What is 0 now stays \
as it is: add the part, and press twice"""

    bl_idname = "material.metallic_paint_live"
    bl_label = "Live Sliders"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        node = operators.paint_node(context)
        if node is None:
            cls.poll_message_set("The material has no metallic paint")
            return False
        return operators.can_change(cls, node.id_data, "material")

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        node = operators.paint_node(context)
        if live.is_live(node):
            if animated := live.animated(node):
                lost = f"keys or drivers, which would be lost: {', '.join(animated)}"
                self.report({"ERROR"}, f"Live values have {lost}")
                return {"CANCELLED"}
            live.end(node)
            return {"FINISHED"}
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


def draw(layout: bpy.types.UILayout, node: bpy.types.ShaderNodeGroup) -> None:
    """As a button that stays pressed."""
    layout.operator(
        MATERIAL_OT_metallic_paint_live.bl_idname, icon="PLAY", depress=live.is_live(node)
    )


register, unregister = bpy.utils.register_classes_factory((MATERIAL_OT_metallic_paint_live,))
