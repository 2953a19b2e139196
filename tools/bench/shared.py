# SPDX-License-Identifier: Apache-2.0
"""One material for many paints: its sockets are linked to properties of the objects. So Blender
compiles one program for all of them, which folds no value away."""

from __future__ import annotations

import bpy
from metallic_paint.paint import PARAMETERS, Paint, material, shader_value, value_of

Sockets = dict[str, float | tuple[float, ...]]  # values by label
LINKED = {name: each for name, each in PARAMETERS.items() if name != "seed"}  # floats have 24 bits


def linked_paint() -> bpy.types.Material:
    made = material.create(Paint())
    link_sockets(material.paint_node(made))
    return made


def link_sockets(node: bpy.types.Node) -> None:
    for parameter in LINKED.values():
        link_to_property(node.inputs[parameter.label], parameter.label)


def give(thing: bpy.types.Object, values: Sockets) -> None:
    for label, value in values.items():
        thing[label] = value
    thing.update_tag()


def sockets_of(paint: Paint) -> Sockets:
    """The values of all sockets but Seed, which stays that of the default paint."""
    return {each.label: shader_value(each, value_of(paint, name)) for name, each in LINKED.items()}


def link_to_property(socket: bpy.types.NodeSocket, name: str) -> None:
    """The socket has, on each object, the value of the object's property."""
    tree = socket.id_data
    attribute = tree.nodes.new("ShaderNodeAttribute")
    attribute.attribute_type, attribute.attribute_name = "OBJECT", name
    value = attribute.outputs["Vector"]
    if socket.type not in ("RGBA", "VECTOR"):  # Fac is the mean of three, off by its rounding
        apart = tree.nodes.new("ShaderNodeSeparateXYZ")
        tree.links.new(value, apart.inputs[0])
        value = apart.outputs["X"]
    tree.links.new(value, socket)
