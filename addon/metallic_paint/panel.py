# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Metallic Paint" in material properties and shader editor, and the Add menu's entry."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import bpy

from . import lights, material, migration, needs, operators

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import IconItems

LINE = 60  # characters of a report in a line of the panel


def draw_lines(layout: bpy.types.UILayout, text: str, icon: IconItems = "NONE") -> None:
    """A report of several lines, wrapped, close together; the icon stands before the first."""
    column = layout.column(align=True)
    for paragraph in text.splitlines():
        for line in textwrap.wrap(paragraph, LINE):
            column.label(text=line, icon=icon)
            icon = "BLANK1" if icon != "NONE" else icon


class _PaintPanel:
    bl_label = "Metallic Paint"
    layout: bpy.types.UILayout  # of the panels

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        painted = operators.paint_node(context) is not None
        if not painted:
            layout.operator(operators.MATERIAL_OT_metallic_paint_new.bl_idname, icon="ADD")
        layout.menu("MATERIAL_MT_metallic_paint_presets", icon="PRESET")
        if missing := material.missing(context.scene):
            box = layout.box()
            draw_lines(box, missing, "ERROR")
            box.operator(operators.SCENE_OT_metallic_paint_use_osl.bl_idname)
        if migration.has_outdated():
            box = layout.box()
            draw_lines(box, "This file holds paints of an older version.", "INFO")
            box.operator(operators.MATERIAL_OT_metallic_paint_update.bl_idname)
        if lights.groups():
            layout.operator(operators.SCENE_OT_metallic_paint_update_lights.bl_idname, icon="LIGHT")
            if said := needs.said():
                draw_lines(layout.box(), said)


class MATERIAL_PT_metallic_paint(_PaintPanel, bpy.types.Panel):
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """With every render engine: the warning is for the others."""
        thing = context.object
        return thing is not None and thing.type in operators.PAINTABLE


class NODE_PT_metallic_paint(_PaintPanel, bpy.types.Panel):
    bl_space_type = "NODE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Metallic Paint"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        space = context.space_data
        return space.tree_type == "ShaderNodeTree" and space.shader_type == "OBJECT"


def _draw_add(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    """Entry of the shader editor's Add menu."""
    if context.space_data.shader_type == "OBJECT":
        menu.layout.separator()
        menu.layout.operator(operators.NODE_OT_metallic_paint_add.bl_idname)


_CLASSES = (MATERIAL_PT_metallic_paint, NODE_PT_metallic_paint)


def register() -> None:
    for each in _CLASSES:
        bpy.utils.register_class(each)
    bpy.types.NODE_MT_shader_node_add_all.append(_draw_add)


def unregister() -> None:
    bpy.types.NODE_MT_shader_node_add_all.remove(_draw_add)
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
