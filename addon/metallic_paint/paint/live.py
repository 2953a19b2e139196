# SPDX-License-Identifier: GPL-3.0-or-later
"""Live sliders: numbers and colours of a paint that the render reads where it needs them.

Blender writes the values of sockets into the shader and compiles it anew for each change. A live
paint has them in the carrier instead (scene/carrier.py), where a step of a slider or a key of an
animation compiles nothing. A group of Attribute nodes beside the paint node reads them there. What
decides which code exists stays with the sockets: choices, parts that are absent, and what an artist
has linked or animated.

An object that carries nothing shows the sockets' own values, which become today's whenever the file
is saved. EEVEE reads the first eight attributes of a material, and shows these values for the rest.
"""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from typing import Any

import bpy
import numpy as np

from ..scene import carrier
from . import animation
from .parameters import FLAKE_PARAMETERS, PARAMETERS, Paint, value_of

NAME = ".Metallic Paint Live"  # menus leave out what begins with a dot
_KEY = "metallic_paint_live"  # of the group: whose values it reads
_LEFT_OF_PAINT = 260

Value = Any  # of a socket: a number, or three in a row


def begin(node: bpy.types.ShaderNodeGroup, paint: Paint) -> int:
    """Makes all live that can be of a node with this paint's values; returns how many are."""
    end(node)
    tree = node.id_data
    keyed = {socket for _, socket, _ in animation.of_inputs(tree, node)}
    sockets = [
        socket
        for name, parameter in PARAMETERS.items()
        if _is_in_use(paint, name)
        and not (socket := node.inputs[parameter.label]).is_linked
        and socket not in keyed
    ]
    if not sockets:
        return 0
    group = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    group.description = "Where the live sliders of a metallic paint have their values"
    group[_KEY] = secrets.token_hex(4)  # that no paint of another file has
    beside = tree.nodes.new("ShaderNodeGroup")
    beside.node_tree = group
    beside.name = beside.label = "Live Sliders"
    beside.location = node.location.x - _LEFT_OF_PAINT, node.location.y
    out = group.nodes.new("NodeGroupOutput")
    kinds = {"RGBA": "NodeSocketColor", "VECTOR": "NodeSocketVector"}
    for i, socket in enumerate(sockets):
        label, own = socket.name, _plain(socket.default_value)
        kind = kinds.get(socket.type, "NodeSocketFloat")
        group.interface.new_socket(label, in_out="OUTPUT", socket_type=kind)
        _carry(group, label, own)
        group.links.new(_reader(group, label, own, -200.0 * i), out.inputs[label])
        tree.links.new(beside.outputs[label], socket)
    return len(sockets)


def end(node: bpy.types.ShaderNodeGroup) -> None:
    """The sockets have the values again; nothing where none is live."""
    if (beside := _beside(node)) is None:
        return
    settle(node)
    group = beside.node_tree
    node.id_data.nodes.remove(beside)
    if group.users == 0:
        bpy.data.node_groups.remove(group)
        _clear_away()


def is_live(node: bpy.types.ShaderNodeGroup) -> bool:
    return _beside(node) is not None


def animated(node: bpy.types.ShaderNodeGroup) -> list[str]:
    """The labels of the live values that have keys or drivers."""
    paths = {
        curve.data_path
        for home in carrier.all_of_file()
        for group in animation.curves(home)
        for curve in group
    }
    places = ((socket.name, place_of(socket)) for socket in node.inputs)
    return [label for label, place in places if place and f'["{place[1]}"]' in paths]


def place_of(socket: bpy.types.NodeSocket) -> tuple[bpy.types.NodeTree, str] | None:
    """Where a live value stands: the datablock, and the name of its property."""
    if not _is_fed(socket):
        return None
    link = socket.links[0]
    name = _name(link.from_node.node_tree, link.from_socket.name)
    return next(((home, name) for home in carrier.all_of_file()[:1] if name in home), None)


def is_linked(socket: bpy.types.NodeSocket) -> bool:
    """Whether a link of the artist's decides the value."""
    return socket.is_linked and place_of(socket) is None


def value(socket: bpy.types.NodeSocket) -> Value:
    """The live value, or else the socket's own."""
    if (place := place_of(socket)) is None:
        return socket.default_value
    home, name = place
    return home[name]


def set_value(socket: bpy.types.NodeSocket, new: Value) -> None:
    """Of what value() returns."""
    if (place := place_of(socket)) is None:
        _set_own(socket, new)
        return
    home, name = place
    home[name] = new
    home.update_tag()


def settle(node: bpy.types.ShaderNodeGroup) -> None:
    """The sockets' own values become the live ones. If any differed, Blender compiles anew."""
    if (beside := _beside(node)) is None:
        return
    for socket in node.inputs:
        if place_of(socket) is None:
            continue
        new, old = _plain(value(socket)), _plain(socket.default_value)
        if not np.array_equal(np.array(new, np.float32), np.array(old, np.float32)):
            _set_own(socket, new)
            _set_fallback(beside.node_tree, socket.name, new)


def settle_all() -> None:
    """Of all paints of the file."""
    for node in _own_nodes():
        settle(node)
    _clear_away()


def are_apart() -> bool:
    """Whether each live paint of the file has values, and none has another's."""
    own = list(_own_nodes())
    has_all = all(place_of(socket) for node in own for socket in node.inputs if _is_fed(socket))
    return has_all and len({_group_of(node)[_KEY] for node in own}) == len(own)


def keep_apart() -> None:
    """So that it is: a copy of a live paint gets values of its own. So does one that came from
    another file: those which its sockets had when that was saved.
    """
    groups: set[bpy.types.NodeTree] = set()
    keys: set[str] = set()
    for node in list(_own_nodes()):
        group, fed = _group_of(node), [socket for socket in node.inputs if _is_fed(socket)]
        is_copy = group in groups
        values = {each.name: value(each) if is_copy else each.default_value for each in fed}
        if is_copy or group.library is not None:
            group = group.copy()
            _feeder(node).node_tree = group
        if group[_KEY] in keys:
            group[_KEY] = secrets.token_hex(4)
        for label, own in values.items():
            if (name := _name(group, label)) not in _home():
                _carry(group, label, _plain(own))
                group.nodes[label].attribute_name = carrier.live_path(name)
        groups.add(group)
        keys.add(group[_KEY])


def _is_in_use(paint: Paint, name: str) -> bool:
    """Whether a change of the number shows. What is 0 is absent, and so is other code."""
    species, _, field = name.rpartition(".")
    flakes = getattr(paint, species) if species else paint
    number = value_of(paint, name)
    if isinstance(number, (str, int)) or not np.any(number):
        return False
    if field in FLAKE_PARAMETERS and flakes.flakes_per_mm2 == 0:
        return False
    if field in ("flake_color", "flake_edge_color", "flake_transmission"):
        return flakes.coating == "colors"
    if field == "coating_nm":
        return "-on-" in flakes.coating
    if field == "orange_peel_mm":
        return paint.orange_peel > 0
    return field != "cells_per_pixel" or paint.anchor == "surface"


# --- the group ---------------------------------------------------------------------------------


def _reader(
    group: bpy.types.ShaderNodeTree, label: str, own: Value, y: float
) -> bpy.types.NodeSocket:
    """What the object carries, or else the socket's own value: Alpha says what exists."""
    carried = group.nodes.new("ShaderNodeAttribute")
    carried.name, carried.location = label, (-600, y)
    carried.attribute_type = "INSTANCER"
    carried.attribute_name = carrier.live_path(_name(group, label))
    found: bpy.types.NodeSocket = carried.outputs["Vector"]
    mix = group.nodes.new("ShaderNodeMix")
    mix.name, mix.location = _fallback(label), (-200, y)
    mix.data_type = "VECTOR" if isinstance(own, tuple) else "FLOAT"
    if not isinstance(own, tuple):  # Fac is the mean of three, off by its rounding
        apart = group.nodes.new("ShaderNodeSeparateXYZ")
        apart.location = -400, y
        group.links.new(found, apart.inputs[0])
        found = apart.outputs["X"]
    group.links.new(carried.outputs["Alpha"], mix.inputs["Factor"])
    group.links.new(found, _of_mix(mix, "B"))
    _set_fallback(group, label, own)
    return next(each for each in mix.outputs if each.enabled)


def _of_mix(mix: bpy.types.Node, name: str) -> bpy.types.NodeSocket:
    """A Mix node has sockets of all types, of which those of its own are enabled."""
    return next(each for each in mix.inputs if each.name == name and each.enabled)


def _fallback(label: str) -> str:
    return f"{label} without a carrier"


def _set_fallback(group: bpy.types.ShaderNodeTree, label: str, own: Value) -> None:
    _of_mix(group.nodes[_fallback(label)], "A").default_value = own


def _beside(node: bpy.types.ShaderNodeGroup) -> bpy.types.Node | None:
    """The node of the group that feeds the paint node."""
    sources = (link.from_node for link in node.id_data.links if link.to_node == node)
    return next(filter(_is_group, sources), None)


def _is_fed(socket: bpy.types.NodeSocket) -> bool:
    return socket.is_linked and _is_group(socket.links[0].from_node)


def _is_group(node: bpy.types.Node) -> bool:
    return node.type == "GROUP" and node.node_tree is not None and _KEY in node.node_tree


def _live_nodes() -> Iterator[bpy.types.ShaderNodeGroup]:
    """The paint nodes of the file that are live, in the order of their trees' names."""
    trees = [each.node_tree for each in bpy.data.materials if each.node_tree]
    for tree in (*trees, *bpy.data.node_groups):
        if any(map(_is_group, tree.nodes)):
            fed = (link.to_node for link in tree.links if _is_group(link.from_node))
            yield from dict.fromkeys(fed)


def _own_nodes() -> Iterator[bpy.types.ShaderNodeGroup]:
    """Those of the file itself."""
    return (node for node in _live_nodes() if node.id_data.is_editable)


def _group_of(node: bpy.types.ShaderNodeGroup) -> bpy.types.NodeTree:
    return _feeder(node).node_tree


def _feeder(node: bpy.types.ShaderNodeGroup) -> bpy.types.Node:
    """Of a paint node that is live."""
    beside = _beside(node)
    assert beside is not None
    return beside


# --- its values --------------------------------------------------------------------------------


def _home() -> bpy.types.NodeTree:
    return next(iter(carrier.all_of_file()), None) or carrier.only()


def _name(group: bpy.types.NodeTree, label: str) -> str:
    return carrier.live_name(group[_KEY], label)


def _carry(group: bpy.types.NodeTree, label: str, first: Value) -> None:
    """The value, as a property that Blender's own panels show like the socket."""
    parameter = next(each for each in PARAMETERS.values() if each.label == label)
    home, name = _home(), _name(group, label)
    home[name] = first
    least, most = parameter.slider
    told: Any = home.id_properties_ui  # the stubs have it return nothing
    told(name).update(
        min=float(parameter.minimum), max=float(parameter.maximum), soft_min=float(least),
        soft_max=float(most), step=10, precision=3, default=first,
        description=parameter.description,
        subtype="COLOR" if parameter.is_color else parameter.subtype,
    )  # fmt: skip
    home.update_tag()


def _clear_away() -> None:
    """What belongs to no paint any more."""
    carrier.keep_live({_group_of(node)[_KEY] for node in _own_nodes()})


def _set_own(socket: bpy.types.NodeSocket, new: Value) -> None:
    socket.default_value = (*new, 1.0) if socket.type == "RGBA" else new


def _plain(value: Value) -> Value:
    """Of a colour without its alpha."""
    return tuple(value)[:3] if hasattr(value, "__len__") else float(value)
