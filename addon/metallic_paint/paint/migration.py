# SPDX-License-Identifier: GPL-3.0-or-later
"""Paints of older versions, made anew: today's node group with the values, links and animation.

Sockets are known by their label, as their owner sees them: place and identifier change between
versions.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache

import bpy

from ..scene import lights
from . import animation, material, shader

_PARKED = "metallic_paint_parked["

Value = float | tuple[float, ...]  # of a socket


@dataclass
class Report:
    """What an update did."""

    updated: int = 0  # paint nodes
    lost: set[str] = field(default_factory=set)  # labels that today's paint does not have
    riding: int = 0  # paint nodes whose sparkles were the pixels' and are the surface's now
    linked: int = 0  # paint nodes that only the file they come from can update

    def __str__(self) -> str:
        lines = [f"Paints updated: {self.updated}."]
        if self.riding:
            lines.append("Sparkles now ride on the surface: set Anchor to pixel for the old "
                         "picture.")  # fmt: skip
        if self.lost:
            lines.append(f"Today's paint has no {', '.join(sorted(self.lost))}.")
        if self.linked:
            lines.append(f"Linked paints stay as they are: {self.linked}. Update the files they "
                         "come from.")  # fmt: skip
        return "\n".join(lines)


def has_outdated() -> bool:
    """Whether the file has a paint of an older version that it can update.

    Quick enough for a panel. Linked paints count where they come from.
    """
    return any(
        group.library is None and group.users > group.use_fake_user and _is_outdated(group)
        for group in bpy.data.node_groups
    )


def update() -> Report:
    """Gives every paint node of the file that can be edited today's group.

    Raises CompileError, with nothing changed, where the shader does not compile.
    """
    report = Report()
    nodes = list(_outdated_nodes())
    material.node_group()  # where the shader does not compile, all stays as it is
    for tree, node in nodes:
        if node.id_data.is_editable:
            report.riding += material.ANCHOR.label not in node.inputs
            report.lost |= _update(tree, node)
            report.updated += 1
        else:
            report.linked += 1
    _remove_unused()
    return report


def _is_outdated(group: bpy.types.NodeTree) -> bool:
    version = material.version(group)
    return 0 < version <= material.VERSION and not material.is_current(group, _digest())


@cache
def _digest() -> str:
    return material.digest(shader.source())


def _outdated_nodes() -> Iterator[tuple[bpy.types.NodeTree, bpy.types.ShaderNodeGroup]]:
    trees = [each.node_tree for each in bpy.data.materials if each.node_tree]
    for tree in (*trees, *bpy.data.node_groups):
        for node in tree.nodes:
            if node.type == "GROUP" and node.node_tree and _is_outdated(node.node_tree):
                yield tree, node


def _update(tree: bpy.types.NodeTree, node: bpy.types.ShaderNodeGroup) -> set[str]:
    """Returns the labels that were in use and are no more."""
    values = {each.name: _value(each) for each in node.inputs if hasattr(each, "default_value")}
    links = [
        (link.from_node, link.from_socket, link.to_node, link.to_socket,
         link.from_socket.name, link.to_socket.name)
        for link in tree.links
        if node in (link.from_node, link.to_node)
    ]  # fmt: skip
    # Blender would join what has the same identifier, whatever it is now.
    for link in [link for link in tree.links if node in (link.from_node, link.to_node)]:
        tree.links.remove(link)
    _park_animation(tree, node)
    node.node_tree = material.node_group()

    for socket in node.inputs:
        if hasattr(socket, "default_value"):
            socket.default_value = _fitting(values.get(socket.name), _default(node, socket), socket)
    lost = set()
    for from_node, output, to_node, target, from_label, to_label in links:
        if from_node == node:
            output = node.outputs.get(from_label)
        if to_node == node:
            target = node.inputs.get(to_label)
        if output is None or target is None:
            lost.add(from_label if output is None else to_label)
        else:
            tree.links.new(output, target)
    return lost | _unpark_animation(tree, node)


def _value(socket: bpy.types.NodeSocket) -> Value:
    value = socket.default_value
    return tuple(value) if hasattr(value, "__len__") else value


def _default(node: bpy.types.ShaderNodeGroup, socket: bpy.types.NodeSocket) -> Value:
    sockets = node.node_tree.interface.items_tree
    own = next(each for each in sockets if getattr(each, "identifier", "") == socket.identifier)
    return tuple(own.default_value) if hasattr(own.default_value, "__len__") else own.default_value


def _fitting(value: Value | None, default: Value, socket: bpy.types.NodeSocket) -> Value:
    """The old value if the socket still is of its kind, otherwise today's default."""
    if isinstance(value, tuple) and isinstance(default, tuple):
        return value if len(value) == len(default) else default
    if value is None or isinstance(value, tuple) or isinstance(default, tuple):
        return default
    return round(value) if socket.type == "INT" else value


def _park_animation(tree: bpy.types.NodeTree, node: bpy.types.ShaderNodeGroup) -> None:
    """Keys and drivers name a socket by its number: meanwhile by its label, which nothing bears.

    Blender 5 would delete those of sockets that go.
    """
    for curve, socket, rest in animation.of_inputs(tree, node):
        curve.data_path = f"{_PARKED}{socket.name}]{rest}"


def _unpark_animation(tree: bpy.types.NodeTree, node: bpy.types.ShaderNodeGroup) -> set[str]:
    """Back to numbers, today's; returns the labels that are no more, without their animation."""
    numbers = {socket.name: number for number, socket in enumerate(node.inputs)}
    lost = set()
    for curves in animation.curves(tree):
        for curve in [each for each in curves if each.data_path.startswith(_PARKED)]:
            label, _, rest = curve.data_path.removeprefix(_PARKED).rpartition("]")
            if label in numbers:
                curve.data_path = f"{node.path_from_id()}.inputs[{numbers[label]}]{rest}"
            else:
                curves.remove(curve)
                lost.add(label)
    return lost


def _remove_unused() -> None:
    """What nobody holds any more goes; the new groups get its names."""
    for group in [each for each in bpy.data.node_groups if each.library is None]:
        if group.users == 0 and _is_outdated(group):
            texts = [node.script for node in group.nodes if node.type == "SCRIPT" and node.script]
            bpy.data.node_groups.remove(group)
            for text in texts:
                if text.users <= text.use_fake_user:
                    bpy.data.texts.remove(text)
    for group in [each for each in bpy.data.node_groups if each.library is None]:
        if group.users == 0 and lights.is_outdated(group):
            bpy.data.node_groups.remove(group)
    group = material.node_group()
    group.name, group.nodes[material.NAME].script.name = material.NAME, shader.FILE
    lights.node_group().name = lights.NAME
