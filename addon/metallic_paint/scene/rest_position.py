# SPDX-License-Identifier: GPL-3.0-or-later
"""Rest positions: where the flakes lie on painted objects that deform.

With Anchor surface, flakes lie in the object's own space. What moves vertices there moves the
surface past its flakes. So a mesh that deforms hands the paint its place at rest: Blender's
attribute rest_position, which an object has where its switch Add Rest Position is on. It is the
mesh before shape keys and all modifiers, and later modifiers carry it along. An object without it
hands on (0, 0, 0), and the paint takes the point itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from ..paint import material

ATTRIBUTE = "rest_position"  # Blender's name of it

# Modifiers that move the vertices of a mesh, most of them in time.
_MOVE = {
    "ARMATURE", "CAST", "CLOTH", "CURVE", "DISPLACE", "DYNAMIC_PAINT", "HOOK", "LAPLACIANDEFORM",
    "LATTICE", "MESH_CACHE", "MESH_DEFORM", "MESH_SEQUENCE_CACHE", "OCEAN", "SHRINKWRAP",
    "SIMPLE_DEFORM", "SOFT_BODY", "SURFACE_DEFORM", "WARP", "WAVE",
}  # fmt: skip
# Modifiers that make another mesh, on which no attribute is left.
_REMAKE = {"REMESH", "SKIN", "VOLUME_TO_MESH"}


@dataclass(frozen=True)
class Report:
    """What became of the objects that lacked a rest position."""

    given: tuple[bpy.types.Object, ...]
    left: dict[bpy.types.Object, str]  # why they still lack it

    def __str__(self) -> str:
        lines = []
        if self.given:
            names = ", ".join(thing.name_full for thing in self.given)
            lines.append(f"Sparkles follow what deforms: {names}.")
        lines += [f"{thing.name_full} is left as it is: {why}." for thing, why in self.left.items()]
        return "\n".join(lines)


def lacks(thing: bpy.types.Object) -> bool:
    """Whether it deforms, and a rest position that it could have is not given to its paints."""
    if thing.type != "MESH" or not _moved_by(thing) or _remade_by(thing):
        return False
    return not all(_is_given(thing, node) for node in _riding(thing))


def about(thing: bpy.types.Object) -> str:
    """Why sparkles do not ride on a painted object, in sentences; empty where they do."""
    if not _riding(thing):
        return ""
    if remade := _remade_by(thing):
        return (
            f"{thing.name} is made anew ({', '.join(remade)}) and has no rest position: sparkles "
            "stay in place while it flows through them."
        )
    deforms = f"{thing.name} deforms ({', '.join(_moved_by(thing))})"
    if lacks(thing):
        return f"{deforms}: without a rest position it slides under its sparkles."
    if thing.type != "MESH" and _moved_by(thing):
        return (
            f"{deforms} and slides under its sparkles, for only a mesh has a rest position: "
            "convert it to one."
        )
    return ""


def give(scene: bpy.types.Scene) -> Report:
    """Rest positions to all painted objects of the scene that lack one, and to their paints."""
    given: list[bpy.types.Object] = []
    left: dict[bpy.types.Object, str] = {}
    for thing in filter(lacks, scene.objects):
        unconnected = {node: of for node, of in _riding(thing).items() if not _is_linked(node)}
        elsewhere = [of.name_full for of in unconnected.values() if not material.keeps_nodes(of)]
        if thing.library is not None:
            left[thing] = "it is linked from another file, where this is to be done"
        elif elsewhere:
            left[thing] = f"it has a paint that is linked from another file, {elsewhere[0]}"
        else:
            for node in unconnected:
                _connect(node)
            thing.add_rest_position_attribute = True
            given.append(thing)
    return Report(tuple(given), left)


def _riding(thing: bpy.types.Object) -> dict[bpy.types.ShaderNodeGroup, bpy.types.ID]:
    """Its paints whose sparkles belong to the surface, each with its owner."""
    return {
        node: material.owner(node, slot.material)
        for slot in thing.material_slots
        if slot.material
        for node in material.paint_nodes(slot.material.node_tree)
        if material.rides(node)
    }


def _moved_by(thing: bpy.types.Object) -> list[str]:
    """What moves its vertices in a render, by the names that the artist sees."""
    keys = getattr(thing.data, "shape_keys", None)
    names = ["Shape Keys"] if keys is not None and len(keys.key_blocks) > 1 else []
    return names + [
        modifier.name
        for modifier in thing.modifiers
        if modifier.show_render and (modifier.type in _MOVE or _sets_positions(modifier))
    ]


def _remade_by(thing: bpy.types.Object) -> list[str]:
    return [
        modifier.name
        for modifier in thing.modifiers
        if modifier.show_render and (modifier.type in _REMAKE or _is_liquid(modifier))
    ]


def _is_liquid(modifier: bpy.types.Modifier) -> bool:
    if not isinstance(modifier, bpy.types.FluidModifier) or modifier.fluid_type != "DOMAIN":
        return False
    return modifier.domain_settings.domain_type == "LIQUID"


def _sets_positions(modifier: bpy.types.Modifier) -> bool:
    """Of geometry nodes: whether they may move what is there."""
    if not isinstance(modifier, bpy.types.NodesModifier):
        return False
    trees = [modifier.node_group]
    for tree in trees:
        for node in tree.nodes if tree else ():
            if node.bl_idname == "GeometryNodeSetPosition":
                return True
            inner = getattr(node, "node_tree", None)
            if inner is not None and inner not in trees:
                trees.append(inner)
    return False


def _is_linked(node: bpy.types.ShaderNodeGroup) -> bool:
    return node.inputs[material.REST_POSITION].is_linked


def _is_given(thing: bpy.types.Object, node: bpy.types.ShaderNodeGroup) -> bool:
    """Whether the paint has a place at rest; what else one links to it is one's own."""
    if not _is_linked(node):
        return False
    source = node.inputs[material.REST_POSITION].links[0].from_node
    if not isinstance(source, bpy.types.ShaderNodeAttribute) or source.attribute_name != ATTRIBUTE:
        return True
    return thing.add_rest_position_attribute or ATTRIBUTE in thing.data.attributes


def _connect(node: bpy.types.ShaderNodeGroup) -> None:
    tree = node.id_data
    attribute = tree.nodes.new("ShaderNodeAttribute")
    attribute.attribute_type, attribute.attribute_name = "GEOMETRY", ATTRIBUTE
    attribute.location = node.location.x - 250, node.location.y - 500
    tree.links.new(attribute.outputs["Vector"], node.inputs[material.REST_POSITION])
