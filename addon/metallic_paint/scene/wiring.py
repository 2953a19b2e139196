# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes within groups that hand on what a render finds: attributes, or constants in their place."""

from __future__ import annotations

from typing import Literal

import bpy

Constant = float | tuple[float, ...]
Type = Literal["FLOAT", "VECTOR"]


def attribute(
    group: bpy.types.ShaderNodeTree, of: Literal["INSTANCER", "VIEW_LAYER"], path: str
) -> bpy.types.Node:
    """INSTANCER: of what is instanced, or else the object itself; VIEW_LAYER: of the scene."""
    node = group.nodes.new("ShaderNodeAttribute")
    node.attribute_type = of
    node.attribute_name = path
    return node


def feed(
    group: bpy.types.NodeTree,
    socket: bpy.types.NodeSocket,
    value: bpy.types.NodeSocket | Constant,
) -> None:
    if isinstance(value, bpy.types.NodeSocket):
        group.links.new(value, socket)
    else:
        socket.default_value = value


def compute(
    tree: bpy.types.NodeTree,
    operation: Literal["COMPARE", "GREATER_THAN", "SUBTRACT"],
    *values: bpy.types.NodeSocket | float,
) -> bpy.types.Node:
    node = tree.nodes.new("ShaderNodeMath")
    node.operation = operation
    for socket, value in zip(node.inputs, values, strict=False):
        feed(tree, socket, value)
    return node


def mix(
    group: bpy.types.ShaderNodeTree,
    data_type: Type,
    factor: bpy.types.NodeSocket,
    otherwise: bpy.types.NodeSocket | Constant,
    value: bpy.types.NodeSocket,
    into: bpy.types.NodeSocket | None = None,
) -> bpy.types.ShaderNodeMix:
    """A node that hands on the value where the factor is 1, and the other where it is 0."""
    node: bpy.types.ShaderNodeMix = group.nodes.new("ShaderNodeMix")
    node.data_type, node.clamp_factor = data_type, False
    feed(group, otherwise_of(node), otherwise)
    for name, source in (("Factor_Float", factor), (f"B_{data_type.title()}", value)):
        group.links.new(source, _input(node, name))
    if into is not None:
        group.links.new(result(node), into)
    return node


def otherwise_of(node: bpy.types.ShaderNodeMix) -> bpy.types.NodeSocket:
    return _input(node, f"A_{node.data_type.title()}")


def result(node: bpy.types.ShaderNodeMix) -> bpy.types.NodeSocket:
    identifier = f"Result_{node.data_type.title()}"
    return next(each for each in node.outputs if each.identifier == identifier)


def _input(node: bpy.types.ShaderNodeMix, identifier: str) -> bpy.types.NodeSocket:
    """A Mix node has sockets of all its types."""
    return next(each for each in node.inputs if each.identifier == identifier)


def lay_out(tree: bpy.types.NodeTree) -> None:
    """Nodes in columns, from left to right as the light goes."""
    column = dict.fromkeys(tree.nodes, 0)
    for _ in tree.nodes:
        for link in tree.links:
            column[link.to_node] = max(column[link.to_node], column[link.from_node] + 1)
    rows: dict[int, int] = {}
    for node, x in column.items():
        node.location = 250 * x, -200 * rows.get(x, 0)
        rows[x] = rows.get(x, 0) + 1
