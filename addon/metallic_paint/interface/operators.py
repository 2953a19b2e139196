# SPDX-License-Identifier: GPL-3.0-or-later
"""New paints, the scene's lights, Cycles with OSL, and paints of older versions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import StringProperty

from ..paint import Paint, material, migration, presets, shader
from ..scene import lights, needs, sky

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems, WmReportItems

PAINTABLE = {"MESH", "CURVE", "SURFACE", "META", "FONT", "CURVES", "POINTCLOUD"}


def active_material(context: bpy.types.Context) -> bpy.types.Material | None:
    return getattr(context, "material", None) or getattr(context.object, "active_material", None)


def paint_node(context: bpy.types.Context) -> bpy.types.ShaderNodeGroup | None:
    """The paint node of the context's material: the active one if there are several."""
    of = active_material(context)
    if of is None or of.node_tree is None:
        return None
    paints = list(material.paint_nodes(of.node_tree))
    active = of.node_tree.nodes.active
    return active if active in paints else next(iter(paints), None)


# What the shader's compilation may end in: the compiler's word, or no place for its files.
UNCOMPILED = (shader.CompileError, OSError)


def has_cycles(operator: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """For a poll: without Cycles, an add-on of its own, no paint compiles or is fitted."""
    if hasattr(context.scene, "cycles"):
        return True
    operator.poll_message_set(material.NO_CYCLES)
    return False


def can_change(operator: type[bpy.types.Operator], datablock: bpy.types.ID, what: str) -> bool:
    """For a poll."""
    if datablock.is_editable:
        return True
    operator.poll_message_set(material.LINKED.format(what))
    return False


def can_change_nodes(operator: type[bpy.types.Operator], owner: bpy.types.ID) -> bool:
    """For a poll: of a material or a node group."""
    if not can_change(operator, owner, "material"):
        return False
    if not material.keeps_nodes(owner):
        operator.poll_message_set(material.OVERRIDDEN)
        return False
    return True


def on_paint(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Whether the active material has a paint; if not, the operator tells."""
    if paint_node(context) is None:
        cls.poll_message_set("The active material has no metallic paint")
        return False
    return True


class ChangesPaint(bpy.types.Operator):
    """For operators that change the paint of the active material."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return on_paint(cls, context) and can_change_nodes(
            cls, material.owner(paint_node(context), active_material(context))
        )


def report_of(operator: bpy.types.Operator, text: str, kind: WmReportItems = "INFO") -> None:
    for line in text.splitlines():
        operator.report({kind}, line)


def cannot_compile(operator: bpy.types.Operator, error: Exception) -> set[OperatorReturnItems]:
    """Ends an operator that could not make the paint's shader."""
    reason = str(error)
    if not material.has_osl():
        reason = material.NO_OSL
    elif isinstance(error, OSError):
        reason = f"The paint's shader cannot be compiled: {error}"
    operator.report({"ERROR"}, reason)
    return {"CANCELLED"}


def fit(operator: bpy.types.Operator, context: bpy.types.Context) -> None:
    """Lights and needs for a new paint, and a warning where the scene cannot show it."""
    needs.fit(context.scene)
    if missing := material.missing(context.scene):
        operator.report({"WARNING"}, missing)


def load(name_or_path: str) -> Paint:
    """The default paint for an empty name."""
    return presets.load(name_or_path) if name_or_path else Paint()


def title(name_or_path: str) -> str:
    """What a paint made of this preset is called: candy-red is Candy Red."""
    stem = name_or_path.replace("\\", "/").rpartition("/")[2].removesuffix(".json")
    return stem.replace("-", " ").title() or material.NAME


class MATERIAL_OT_metallic_paint_new(bpy.types.Operator):
    """Give the active object a new metallic paint in its active material slot"""

    bl_idname = "material.metallic_paint_new"
    bl_label = "New Metallic Paint"
    bl_options = {"REGISTER", "UNDO"}

    preset: StringProperty(
        name="Preset", description="Name or file of a preset; empty for a plain silver"
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not has_cycles(cls, context):
            return False
        thing = context.object
        if thing is None or thing.type not in PAINTABLE:
            cls.poll_message_set("Select an object whose surface can hold a material")
            return False
        slots, active = thing.material_slots, thing.active_material_index
        by_object = active < len(slots) and slots[active].link == "OBJECT"
        if not thing.is_editable or not (thing.data.is_editable or by_object):
            cls.poll_message_set(material.LINKED.format("object"))
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        try:
            paint = load(self.preset)
        except presets.PresetError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        try:
            painted = material.create(paint, title(self.preset))
        except UNCOMPILED as error:
            return cannot_compile(self, error)
        context.object.active_material = painted
        fit(self, context)
        return {"FINISHED"}


class NODE_OT_metallic_paint_add(bpy.types.Operator):
    """Add a metallic paint node, to be connected with a material's surface"""

    bl_idname = "node.metallic_paint_add"
    bl_label = "Metallic Paint"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not has_cycles(cls, context):
            return False
        space = context.space_data
        tree = space.edit_tree if space is not None and space.type == "NODE_EDITOR" else None
        if tree is None or tree.bl_idname != "ShaderNodeTree" or space.shader_type != "OBJECT":
            cls.poll_message_set("Open a material in a shader editor")
            return False
        # A material's nodes do not say whose they are.
        owner = next((each for each in bpy.data.materials if each.node_tree == tree), tree)
        if not can_change_nodes(cls, owner):
            return False
        if material.version(tree) or tree in lights.groups():
            cls.poll_message_set("A paint cannot stand within a paint")
            return False
        return True

    def invoke(
        self, context: bpy.types.Context, event: bpy.types.Event
    ) -> set[OperatorReturnItems]:
        context.space_data.cursor_location_from_region(event.mouse_region_x, event.mouse_region_y)
        result = self.execute(context)
        if result != {"FINISHED"}:
            return result
        bpy.ops.node.translate_attach_remove_on_cancel("INVOKE_DEFAULT")
        return result

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        tree = context.space_data.edit_tree
        try:
            node = material.add_node(tree, Paint())
        except UNCOMPILED as error:
            return cannot_compile(self, error)
        node.location = context.space_data.cursor_location
        for other in tree.nodes:
            other.select = other == node
        tree.nodes.active = node
        fit(self, context)
        return {"FINISHED"}


class SCENE_OT_metallic_paint_update_lights(bpy.types.Operator):
    """Tell the paints anew which lights the scene has, and which parts of a paint it does \
without. This happens by itself while you work; a script has to call it"""

    bl_idname = "scene.metallic_paint_update_lights"
    bl_label = "Update Lights"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not lights.has_any():
            cls.poll_message_set("This file has no metallic paint")
            return False
        return has_cycles(cls, context)

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        sky.forget()
        report_of(self, str(needs.fit(context.scene)))
        return {"FINISHED"}


class SCENE_OT_metallic_paint_use_osl(bpy.types.Operator):
    """Render this scene with Cycles and Open Shading Language on the CPU"""

    bl_idname = "scene.metallic_paint_use_osl"
    bl_label = "Use Cycles with OSL"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not material.has_osl():
            cls.poll_message_set(material.NO_OSL.rstrip("."))
            return False
        return has_cycles(cls, context) and can_change(cls, context.scene, "scene")

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        material.set_up_cycles(context.scene)
        return {"FINISHED"}


class MATERIAL_OT_metallic_paint_update(bpy.types.Operator):
    """Give all paints of this file that were made by an older version today's shader. Their \
values, links and animation stay; their look may change"""

    bl_idname = "material.metallic_paint_update"
    bl_label = "Update Paints"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not migration.has_outdated():
            cls.poll_message_set("All paints of this file are of today's version")
            return False
        return has_cycles(cls, context)

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        try:
            report = migration.update()
        except UNCOMPILED as error:
            return cannot_compile(self, error)
        report_of(self, str(report), "WARNING" if report.lost or report.linked else "INFO")
        fit(self, context)
        return {"FINISHED"}


_CLASSES = (
    MATERIAL_OT_metallic_paint_new,
    NODE_OT_metallic_paint_add,
    SCENE_OT_metallic_paint_update_lights,
    SCENE_OT_metallic_paint_use_osl,
    MATERIAL_OT_metallic_paint_update,
)


register, unregister = bpy.utils.register_classes_factory(_CLASSES)
