# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Metallic Paint" in material properties and shader editor, and the Add menu's entry."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import bpy

from ..paint import PANELS, material, migration
from ..scene import follow, lights, needs, rest_position
from . import knobs, live, operators, preset_operators
from .rest_position import SCENE_OT_metallic_paint_add_rest_position

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import IconItems

LINE = 60  # characters of a report in a line of the panel, where that is wide enough
_LETTER = 6.5  # pixels of a character of Blender's font on average, and of a margin, at its size 1
_MARGIN = 75
_WIDE = 380  # from here on a label stands before its value


def _width() -> float:
    """Of the region that is drawn, in pixels as they are at Blender's size 1."""
    region = bpy.context.region
    return region.width / bpy.context.preferences.system.ui_scale if region else 1000.0


def _line() -> int:
    return int(min(max((_width() - _MARGIN) / _LETTER, 10), LINE))


def draw_lines(layout: bpy.types.UILayout, text: str, icon: IconItems = "NONE") -> None:
    """A report of several lines, wrapped, close together; the icon stands before the first."""
    column = layout.column(align=True)
    for paragraph in text.splitlines():
        for line in textwrap.wrap(paragraph, _line()):
            column.label(text=line, icon=icon)
            icon = "BLANK1" if icon != "NONE" else icon


_PREVIEWED = "A preview: the sparkles themselves show in Rendered view."

_LINKED = (
    "The paints are linked from {}: they cannot be edited, and do not see the lights of this file "
    "as none is an asset there. Mark one as an asset in that file and save it, or append them."
)


_WITHIN_GROUP = "Of the node group “{}”: what changes here changes wherever that is used."


class _PaintPanel:
    bl_label = "Metallic Paint"
    layout: bpy.types.UILayout  # of the panels

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        node = operators.paint_node(context)
        if node is None:
            layout.operator(operators.MATERIAL_OT_metallic_paint_new.bl_idname, icon="ADD")
        else:
            if material.is_within_group(node):
                draw_lines(layout, _WITHIN_GROUP.format(node.id_data.name), "INFO")
            preset_operators.draw_swatches(layout, node)
        layout.menu(
            "MATERIAL_MT_metallic_paint_presets", text="Metallic Paint Presets", icon="PRESET"
        )
        if node is not None:
            amount = knobs.draw_first(_values(layout), node)
            draw_lines(layout, amount)
            live.draw(layout, node)
        if missing := material.missing(context.scene):
            box = layout.box()
            draw_lines(box, missing, "ERROR")
            if material.has_osl():
                box.operator(operators.SCENE_OT_metallic_paint_use_osl.bl_idname)
        elif node is not None and not _shows_in(context.screen):
            draw_lines(layout, _PREVIEWED, "INFO")
        if migration.has_outdated():
            box = layout.box()
            draw_lines(box, "This file holds paints of an older version.", "INFO")
            box.operator(operators.MATERIAL_OT_metallic_paint_update.bl_idname)
        if context.object is not None and (about := rest_position.about(context.object)):
            box = layout.box()
            draw_lines(box, about, "INFO")
            if rest_position.lacks(context.object):
                box.operator(SCENE_OT_metallic_paint_add_rest_position.bl_idname)
        if lights.groups():
            if trouble := follow.trouble():
                draw_lines(layout, trouble, "ERROR")
        elif linked := lights.linked_files():
            draw_lines(layout.box(), _LINKED.format(", ".join(linked)), "INFO")


def _values(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    """For sockets: each with its label before it, or within it where that would be cut."""
    column = layout.column()
    column.use_property_split = _width() >= _WIDE
    column.use_property_decorate = False
    return column


def _draw_lights(layout: bpy.types.UILayout) -> None:
    if not lights.groups():
        return
    layout.operator(operators.SCENE_OT_metallic_paint_update_lights.bl_idname, icon="LIGHT")
    if said := needs.said():
        draw_lines(layout.box(), f"All paints of this file share its lights.\n{said}")


def _shows_in(screen: bpy.types.Screen | None) -> bool:
    """Whether a view is Rendered, or there is none."""
    areas = screen.areas if screen is not None else ()
    shadings = [each.spaces.active.shading.type for each in areas if each.type == "VIEW_3D"]
    return not shadings or "RENDERED" in shadings


class _MaterialPanel(_PaintPanel, bpy.types.Panel):
    """Of materials with a paint, or of those without."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"
    painted: bool

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """With every render engine: the warning is for the others."""
        thing = context.object
        if thing is None or thing.type not in operators.PAINTABLE:
            return False
        of = operators.active_material(context)
        return (of is not None and material.has_paint(of)) == cls.painted


class MATERIAL_PT_metallic_paint(_MaterialPanel):
    """Of a material that has a paint.

    Blender sorts panels without a header above all others, which no order can do: so this stands
    right below the material's name.
    """

    bl_options = {"HIDE_HEADER"}
    painted = True


class MATERIAL_PT_metallic_paint_new(_MaterialPanel):
    """The same at the foot of the tab, where it is in nobody's way, while there is no paint."""

    painted = False


class SubPanel(bpy.types.Panel):
    """What the panels below the one in material properties share."""

    bl_parent_id = "MATERIAL_PT_metallic_paint"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"
    bl_options = {"DEFAULT_CLOSED"}


class _Values(SubPanel):
    """A panel of the node, with words for its choices."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        node = operators.paint_node(context)
        return node is not None and bool(knobs.labels_of(node, cls.bl_label))

    def draw(self, context: bpy.types.Context) -> None:
        knobs.draw_panel(_values(self.layout), operators.paint_node(context), self.bl_label)


_VALUES = tuple(
    type(f"MATERIAL_PT_metallic_paint_{name.lower().replace(' ', '_')}", (_Values,),
         {"bl_label": name, "__module__": __name__})
    for name in PANELS
)  # fmt: skip


class MATERIAL_PT_metallic_paint_diagnostics(SubPanel):
    """The lights that the paints know; below it Scene Report and Verify."""

    bl_label = "Diagnostics"
    bl_order = 1  # after the other sub-panels

    def draw(self, context: bpy.types.Context) -> None:
        _draw_lights(self.layout)


class DiagnosticsPanel(SubPanel):
    bl_parent_id = "MATERIAL_PT_metallic_paint_diagnostics"


class NODE_PT_metallic_paint(_PaintPanel, bpy.types.Panel):
    bl_space_type = "NODE_EDITOR"
    bl_region_type = "UI"
    bl_category = "Metallic Paint"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        space = context.space_data
        return space.tree_type == "ShaderNodeTree" and space.shader_type == "OBJECT"

    def draw(self, context: bpy.types.Context) -> None:
        _PaintPanel.draw(self, context)
        _draw_lights(self.layout)


def _draw_add(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    """Entry of the shader editor's Add menu."""
    if context.space_data.shader_type == "OBJECT":
        menu.layout.separator()
        menu.layout.operator(operators.NODE_OT_metallic_paint_add.bl_idname)


_CLASSES = (
    MATERIAL_PT_metallic_paint,
    MATERIAL_PT_metallic_paint_new,
    *_VALUES,
    MATERIAL_PT_metallic_paint_diagnostics,
    NODE_PT_metallic_paint,
)


def register() -> None:
    knobs.register()
    for each in _CLASSES:
        bpy.utils.register_class(each)
    bpy.types.NODE_MT_shader_node_add_all.append(_draw_add)


def unregister() -> None:
    bpy.types.NODE_MT_shader_node_add_all.remove(_draw_add)
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
    knobs.unregister()
