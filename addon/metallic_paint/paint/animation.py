# SPDX-License-Identifier: GPL-3.0-or-later
"""What animates a node tree: drivers, and keys in actions and in the nonlinear editor."""

from __future__ import annotations

import re
from collections.abc import Iterator

import bpy


def curves(
    tree: bpy.types.NodeTree,
) -> Iterator[bpy.types.AnimDataDrivers | bpy.types.ActionChannelbagFCurves]:
    """The drivers and, of each action that the tree uses, the curves of keys."""
    data = tree.animation_data
    if data is None:
        return
    yield data.drivers
    used = {(data.action, data.action_slot)}
    for track in data.nla_tracks:
        used.update((strip.action, strip.action_slot) for strip in _strips(track))
    for action, slot in used:
        if action is None or slot is None:
            continue
        for layer in action.layers:
            for strip in layer.strips:
                if (bag := strip.channelbag(slot)) is not None:
                    yield bag.fcurves


def of_inputs(
    tree: bpy.types.NodeTree, node: bpy.types.Node
) -> list[tuple[bpy.types.FCurve, bpy.types.NodeSocket, str]]:
    """The curves that give a value to the node's inputs, each with the rest of its path."""
    pattern = re.compile(re.escape(f"{node.path_from_id()}.inputs[") + r"(\d+)\](.*)", re.DOTALL)
    matched = [
        (curve, match)
        for group in curves(tree)
        for curve in group
        if (match := pattern.fullmatch(curve.data_path)) and int(match[1]) < len(node.inputs)
    ]
    return [(curve, node.inputs[int(match[1])], match[2]) for curve, match in matched]


def _strips(of: bpy.types.NlaTrack | bpy.types.NlaStrip) -> Iterator[bpy.types.NlaStrip]:
    """Of the nonlinear editor, with those that strips of strips hold."""
    for strip in of.strips:
        yield strip
        yield from _strips(strip)
