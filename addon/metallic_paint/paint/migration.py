# SPDX-License-Identifier: GPL-3.0-or-later
"""Paints of older versions, made anew: today's node group with the values, links and animation.

Sockets are known by their label, as their owner sees them: place and identifier change between
versions.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache

import bpy

from ..scene import lights
from . import animation, material, shader

_PARKED = "metallic_paint_parked["

Value = float | tuple[float, ...]  # of a socket
_Parked = tuple[bpy.types.ShaderNodeGroup, str, str]  # socket's node and label, rest of the path


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
            lines.append("Sparkles now ride on the surface: set Anchor to pixel to have them on "
                         "the pixels.")  # fmt: skip
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
    found = list(_outdated_nodes())
    nodes = [node for owner, node in found if material.keeps_nodes(owner)]
    report.updated, report.linked = len(nodes), len(found) - len(nodes)
    material.node_group()  # where the shader does not compile, all stays as it is
    parked = _park_animation(nodes)
    for node in nodes:
        report.riding += material.ANCHOR.label not in node.inputs
        report.lost |= _update(node)
    report.lost |= _unpark_animation([node.id_data for node in nodes], parked)
    _remove_unused()
    return report


def _is_outdated(group: bpy.types.NodeTree) -> bool:
    version = material.version(group)
    return 0 < version <= material.VERSION and not material.is_current(group, _digest())


@cache
def _digest() -> str:
    return material.digest(shader.source())


def _outdated_nodes() -> Iterator[tuple[bpy.types.ID, bpy.types.ShaderNodeGroup]]:
    """Each with the material or node group that it stands in."""
    owners = [each for each in bpy.data.materials if each.node_tree]
    for owner in (*owners, *bpy.data.node_groups):
        tree = owner.node_tree if isinstance(owner, bpy.types.Material) else owner
        for node in tree.nodes:
            if not isinstance(node, bpy.types.ShaderNodeGroup) or node.node_tree is None:
                continue
            if _is_outdated(node.node_tree):
                yield owner, node


def _update(node: bpy.types.ShaderNodeGroup) -> set[str]:
    """Returns the labels that were in use and are no more."""
    tree = node.id_data
    values = {each.name: _value(each) for each in node.inputs if hasattr(each, "default_value")}
    links = [
        (link.from_node, link.from_socket, link.to_node, link.to_socket,
         link.from_socket.name, link.to_socket.name, link.is_muted)
        for link in tree.links
        if node in (link.from_node, link.to_node)
    ]  # fmt: skip
    # Blender would join what has the same identifier, whatever it is now.
    for link in [link for link in tree.links if node in (link.from_node, link.to_node)]:
        tree.links.remove(link)
    node.node_tree = material.node_group()

    for socket in node.inputs:
        if hasattr(socket, "default_value"):
            socket.default_value = _fitting(values.get(socket.name), _default(node, socket), socket)
    lost = set()
    for from_node, output, to_node, target, from_label, to_label, is_muted in links:
        if from_node == node:
            output = node.outputs.get(from_label)
        if to_node == node:
            target = node.inputs.get(to_label)
        if output is None or target is None:
            lost.add(from_label if output is None else to_label)
        else:
            tree.links.new(output, target).is_muted = is_muted
    return lost


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


def _park_animation(nodes: list[bpy.types.ShaderNodeGroup]) -> list[_Parked]:
    """Keys and drivers name a socket by its number: meanwhile by their own, which nothing bears.

    Blender 5 would delete those of sockets that go. Copies of a material share their keys: all are
    parked before any node changes, so that none is counted anew twice.
    """
    parked: list[_Parked] = []
    for node in nodes:
        for curve, socket, rest in animation.of_inputs(node.id_data, node):
            curve.data_path = f"{_PARKED}{len(parked)}]"
            parked.append((node, socket.name, rest))
    return parked


def _unpark_animation(trees: list[bpy.types.NodeTree], parked: list[_Parked]) -> set[str]:
    """Back to numbers, today's; returns the labels that are no more, without their animation."""
    lost = set()
    for curves in itertools.chain.from_iterable(map(animation.curves, trees)):
        for curve in [each for each in curves if each.data_path.startswith(_PARKED)]:
            node, label, rest = parked[int(curve.data_path.removeprefix(_PARKED).rstrip("]"))]
            if (number := node.inputs.find(label)) >= 0:
                curve.data_path = f"{node.path_from_id()}.inputs[{number}]{rest}"
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
