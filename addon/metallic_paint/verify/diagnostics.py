# SPDX-License-Identifier: GPL-3.0-or-later
"""The inner values that the shader can show, and the paint's variant that shows them.

The text that ships shows none. The variant has a colour output with the value that its input
Diagnostic names. That input and its like are linked to properties of the painted objects, so OSL
does not fold them: with persistent data one compilation serves all pictures.
"""

from __future__ import annotations

from collections.abc import Collection
from contextlib import ExitStack
from typing import Any

import bpy

from ..paint import material, shader

# As osl/metallic_paint.osl numbers them.
COUNT, MEAN_COUNT, RADIANCE, MEAN_RADIANCE, PIXEL, POSITION, NORMAL, VIEW, RASTER = range(1, 10)
IRRADIANCE, SPARKLES, CONE, SOUND, LOBE, DIFFUSE, TEXTURE, GLOSSY, ROUGHNESS = range(10, 19)
OWN_POSITION, OWN_X, OWN_Y, OWN_Z, INSTANCE, RETURNED, EXPONENT = range(19, 26)
LIT = (IRRADIANCE, SPARKLES, LOBE)  # surfaces under the lamps; the others are values to emit

_SHOWN = "Shown"  # the output
_INPUTS = ("Diagnostic", "DiagnosticLight")
_EMITS = "Emits"  # 1: what is shown leaves as emission; 0: the surface under the lamps


def show(things: Collection[bpy.types.Object], diagnostic: int, light: int = 0) -> None:
    """What the objects show of this light slot (0-based)."""
    values = (diagnostic, light + 1, int(diagnostic not in LIT))
    set_properties(things, dict(zip((*_INPUTS, _EMITS), values, strict=True)))


def set_properties(things: Collection[bpy.types.Object], values: dict[str, float]) -> None:
    """What the objects' attribute nodes of these names have."""
    for thing in things:
        for name, value in values.items():
            thing[_property(name)] = value
        thing.update_tag()


def variants(materials: Collection[bpy.types.Material]) -> ExitStack:
    """Gives the materials the variant as their surface; what is returned puts all back at its end.

    It holds calls and no generators. Python would run the end of a forgotten generator when it
    collects garbage, in a file that may be another by then, and Blender would crash.
    """
    groups: dict[bpy.types.NodeTree, bpy.types.ShaderNodeTree] = {}
    with ExitStack() as stack:
        for painted in materials:
            group = material.paint_node(painted).node_tree
            if group not in groups:
                groups[group] = _variant(group, stack)
            _as_surface(painted, groups[group], stack)
        stack.callback(_remove_properties)
        return stack.pop_all()


def _remove_properties() -> None:
    for thing in bpy.data.objects:
        for name in (*_INPUTS, _EMITS):
            thing.pop(_property(name), None)


def _variant(group: bpy.types.ShaderNodeTree, stack: ExitStack) -> bpy.types.ShaderNodeTree:
    copy = group.copy()
    stack.callback(bpy.data.node_groups.remove, copy)
    text = bpy.data.texts.new(shader.FILE)
    stack.callback(bpy.data.texts.remove, text)
    source = shader.source(diagnostics=True)
    text.write(source)
    material.mark(copy, source)
    script: Any = copy.nodes[material.NAME]  # a ShaderNodeScript
    shader.compile_into(script, text)
    for name in _INPUTS:
        attribute = attribute_of(copy, name)
        copy.links.new(attribute.outputs["Fac"], script.inputs[name])
    copy.interface.new_socket(_SHOWN, in_out="OUTPUT", socket_type="NodeSocketColor")
    out = next(node for node in copy.nodes if node.type == "GROUP_OUTPUT")
    copy.links.new(script.outputs[_SHOWN], out.inputs[_SHOWN])
    return copy


def _as_surface(
    painted: bpy.types.Material, variant: bpy.types.ShaderNodeTree, stack: ExitStack
) -> None:
    """The paint as it was, or the emission of what it shows, as the objects' property says."""
    tree, node = painted.node_tree, material.paint_node(painted)
    group, node.node_tree = node.node_tree, variant
    # Or Cycles would take every mesh with this material for a lamp.
    sampling, painted.cycles.emission_sampling = painted.cycles.emission_sampling, "NONE"
    surface = tree.get_output_node("CYCLES").inputs["Surface"]
    emission = tree.nodes.new("ShaderNodeEmission")
    emits = attribute_of(tree, _EMITS)
    mix = tree.nodes.new("ShaderNodeMixShader")

    def put_back() -> None:
        for link in list(mix.inputs[1].links):
            tree.links.new(link.from_socket, surface)
        for added in (mix, emits, emission):
            tree.nodes.remove(added)
        painted.cycles.emission_sampling = sampling
        node.node_tree = group

    stack.callback(put_back)
    tree.links.new(emits.outputs["Fac"], mix.inputs["Fac"])
    for link in list(surface.links):
        tree.links.new(link.from_socket, mix.inputs[1])
    tree.links.new(node.outputs[_SHOWN], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], surface)


def attribute_of(tree: bpy.types.NodeTree, name: str) -> bpy.types.ShaderNodeAttribute:
    """A node with the objects' property of that name."""
    attribute = tree.nodes.new("ShaderNodeAttribute")
    attribute.attribute_type, attribute.attribute_name = "OBJECT", _property(name)
    return attribute


def _property(name: str) -> str:
    """Of an object."""
    return f"metallic_paint_{name}"
