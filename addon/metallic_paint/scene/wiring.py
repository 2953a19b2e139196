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
    group: bpy.types.ShaderNodeTree,
    socket: bpy.types.NodeSocket,
    value: bpy.types.NodeSocket | Constant,
) -> None:
    if isinstance(value, bpy.types.NodeSocket):
        group.links.new(value, socket)
    else:
        socket.default_value = value


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
