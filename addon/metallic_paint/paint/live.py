# SPDX-License-Identifier: GPL-3.0-or-later
"""Live sliders: numbers and colours of a paint that the render reads where it needs them.

Blender writes the values of sockets into the shader and compiles it anew for each change. A live
paint has them in the carrier instead (scene/carrier.py), where a step of a slider or a key of an
animation compiles nothing. A group of Attribute nodes, beside the paint, reads them there. What
decides which code exists stays with the sockets: choices, parts that are absent, and what an artist
has linked or animated.

An object that carries no such values shows those that the group had when the file was saved last.
EEVEE reads the first eight attributes of a material, and shows the group's values for the rest.

The copy of a live paint shares the group and so the values, until its owner makes them its own: a
group made between two steps of undo would be freed by the next one, with the node pointing at it.
"""

from __future__ import annotations

import secrets
from typing import Any

import bpy
import numpy as np

from ..scene import carrier, wiring
from . import animation
from .parameters import FLAKE_PARAMETERS, PARAMETERS, Paint, value_of

NAME = ".Metallic Paint Live"  # menus leave out what begins with a dot
_KEY = "metallic_paint_live"  # of the group: whose values it reads
_LEFT_OF_PAINT = 260

Value = Any  # of a socket: a number, or three in a row
Place = tuple[bpy.types.NodeTree, str]  # of a live value: the datablock, and its property's name


# --- one paint ---------------------------------------------------------------------------------


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
    _settle_under(group, _new_key(), {each.name: _plain(each.default_value) for each in sockets})
    feeder = tree.nodes.new("ShaderNodeGroup")
    feeder.node_tree = group
    feeder.name = feeder.label = "Live Sliders"
    feeder.parent, feeder.location = node.parent, node.location
    feeder.location.x -= _LEFT_OF_PAINT
    out = group.nodes.new("NodeGroupOutput")
    kinds = {"RGBA": "NodeSocketColor", "VECTOR": "NodeSocketVector"}
    for i, socket in enumerate(sockets):
        kind = kinds.get(socket.type, "NodeSocketFloat")
        group.interface.new_socket(socket.name, in_out="OUTPUT", socket_type=kind)
        read = _add_reader(group, socket.name, _plain(socket.default_value), -200.0 * i)
        group.links.new(read, out.inputs[socket.name])
        tree.links.new(feeder.outputs[socket.name], socket)
    return len(sockets)


def end(node: bpy.types.ShaderNodeGroup) -> None:
    """Gives the sockets the values again; nothing where none is live."""
    if (feeder := _feeder(node)) is None:
        return
    for socket in node.inputs:
        if _is_fed(socket):
            _set_own(socket, _plain(value(socket)))
    group = feeder.node_tree
    node.id_data.nodes.remove(feeder)
    if group.users == 0:
        bpy.data.node_groups.remove(group)
        _forget_unused()


def is_live(node: bpy.types.ShaderNodeGroup) -> bool:
    return _feeder(node) is not None


def is_shared(node: bpy.types.ShaderNodeGroup) -> bool:
    """Whether another paint has the same live values, as copies of a material have."""
    feeder = _feeder(node)
    return feeder is not None and feeder.node_tree.users > 1


def make_single(node: bpy.types.ShaderNodeGroup) -> None:
    """A paint that shares live values gets its own, which are the same at first."""
    feeder = _feeder(node)
    if feeder is None or not is_shared(node):
        return
    shared = feeder.node_tree
    feeder.node_tree = own = shared.copy()
    _settle_under(own, _new_key(), {label: _value_in(shared, label) for label in _labels(shared)})


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


def _is_in_use(paint: Paint, name: str) -> bool:
    """Whether a change of the number shows. What is 0 is absent, and so is other code. The index of
    refraction stays a constant: that it folds is worth a tenth of a sample's time.
    """
    species, _, field = name.rpartition(".")
    flakes = getattr(paint, species) if species else paint
    number = value_of(paint, name)
    if isinstance(number, (str, int)) or not np.any(number) or field == "binder_ior":
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


# --- one value ---------------------------------------------------------------------------------


def place_of(socket: bpy.types.NodeSocket) -> Place | None:
    """Where the socket's live value can be changed; None where it has none in this file."""
    if not _is_fed(socket):
        return None
    link = socket.links[0]
    name = _name(link.from_node.node_tree, link.from_socket.name)
    return next(((home, name) for home in carrier.all_of_file()[:1] if name in home), None)


def can_be_set(socket: bpy.types.NodeSocket) -> bool:
    """Whether set_value changes the picture."""
    return not socket.is_linked or place_of(socket) is not None


def is_linked(socket: bpy.types.NodeSocket) -> bool:
    """Whether a link of the artist's decides the value."""
    return socket.is_linked and not _is_fed(socket)


def value(socket: bpy.types.NodeSocket) -> Value:
    """The live value, or else the socket's own."""
    if not _is_fed(socket):
        return socket.default_value
    link = socket.links[0]
    return _value_in(link.from_node.node_tree, link.from_socket.name)


def set_value(socket: bpy.types.NodeSocket, new: Value) -> None:
    """Sets the live value, or else the socket's own."""
    if (place := place_of(socket)) is None:
        _set_own(socket, new)
        return
    home, name = place
    home[name] = _plain(new)
    home.update_tag()


_values: dict[str, list[object]] = {}  # when stepped was called last


def stepped() -> set[str]:
    """The keys of the paints whose live values have changed since the last call."""
    now = carrier.live_values()
    found = {key for key, values in now.items() if values != _values.get(key)}
    _values.clear()
    _values.update(now)
    return found


def key_of(node: bpy.types.ShaderNodeGroup) -> str:
    """Of a live paint; empty for any other."""
    feeder = _feeder(node)
    return feeder.node_tree[_KEY] if feeder else ""


# --- all of the file ---------------------------------------------------------------------------


def settle_all() -> None:
    """For a save: what objects without a carrier show becomes the values of now, and so do the
    sockets' own, for those who take the node away. If any differed, Blender compiles anew.
    """
    for group in _groups():
        for label in _labels(group):
            own, new = _fallback(group, label), _plain(_value_in(group, label))
            if not _is_same(own.default_value, new):
                own.default_value = new
    trees = [each.node_tree for each in bpy.data.materials if each.node_tree]
    for tree in (*trees, *bpy.data.node_groups):
        for link in tree.links if tree.is_editable else ():
            fed = link.to_socket
            if _is_feeder(link.from_node) and link.to_node.type == "GROUP" and _is_fed(fed):
                new = _plain(value(fed))
                if not _is_same(fed.default_value, new):
                    _set_own(fed, new)
    _forget_unused()


def are_apart() -> bool:
    """Whether each group of the file has values in the carrier, and none has another's."""
    keys = [*_linked_keys(), *(group[_KEY] for group in _groups())]
    homes = carrier.all_of_file()[:1]
    return len(set(keys)) == len(keys) and all(
        _name(group, label) in home
        for group in _groups()
        for label in _labels(group)
        for home in homes
    )


def keep_apart() -> None:
    """Gives groups that came from another file values in this one, under keys of their own.

    Called before the carriers of several files become one: what came along has its values there,
    or else in the group. What was here first keeps its key.
    """
    keys = _linked_keys()
    for group in sorted(_groups(), key=lambda each: each.session_uid):
        others = carrier.all_of_file()[1:]
        values = {
            label: next(
                (home[name] for home in others if (name := _name(group, label)) in home),
                _fallback(group, label).default_value,
            )
            for label in _labels(group)
        }
        if group[_KEY] in keys:
            _settle_under(group, _new_key(), values)
        elif any(_name(group, label) not in _home() for label in values):
            _settle_under(group, group[_KEY], values)
        keys.add(group[_KEY])


# --- the group, and the node that has it -------------------------------------------------------


def _add_reader(
    group: bpy.types.ShaderNodeTree, label: str, own: Value, y: float
) -> bpy.types.NodeSocket:
    """What the object carries, or else a value of the group's: Alpha says what exists."""
    carried = wiring.attribute(group, "INSTANCER", carrier.live_path(_name(group, label)))
    carried.name, carried.location = label, (-600, y)
    found: bpy.types.NodeSocket = carried.outputs["Vector"]
    data_type: wiring.Type = "VECTOR"
    if not isinstance(own, tuple):  # Fac is the mean of three, off by its rounding
        data_type, apart = "FLOAT", group.nodes.new("ShaderNodeSeparateXYZ")
        apart.location = -400, y
        group.links.new(found, apart.inputs[0])
        found = apart.outputs["X"]
    chosen = wiring.mix(group, data_type, carried.outputs["Alpha"], own, found)
    chosen.name, chosen.location = _without_carrier(label), (-200, y)
    return wiring.result(chosen)


def _without_carrier(label: str) -> str:
    """The name of the node that holds the group's value."""
    return f"{label} without a carrier"


def _fallback(group: bpy.types.NodeTree, label: str) -> bpy.types.NodeSocket:
    holder: Any = group.nodes[_without_carrier(label)]
    return wiring.otherwise_of(holder)


def _labels(group: bpy.types.NodeTree) -> list[str]:
    items: Any = group.interface.items_tree  # panels among them, which no group of ours has
    return [each.name for each in items]


def _groups() -> list[bpy.types.NodeTree]:
    """The file's own that are in use."""
    own = (each for each in bpy.data.node_groups if _KEY in each and each.library is None)
    return [each for each in own if each.users]


def _linked_keys() -> set[str]:
    """Of groups of other files."""
    return {each[_KEY] for each in bpy.data.node_groups if _KEY in each and each.library}


def _feeder(node: bpy.types.ShaderNodeGroup) -> bpy.types.Node | None:
    """The node that has the group, beside a live paint."""
    sources = (link.from_node for link in node.id_data.links if link.to_node == node)
    return next(filter(_is_feeder, sources), None)


def _is_feeder(node: bpy.types.Node) -> bool:
    return node.type == "GROUP" and node.node_tree is not None and _KEY in node.node_tree


def _is_fed(socket: bpy.types.NodeSocket) -> bool:
    """Whether live values decide: neither the link nor the node is muted."""
    if not socket.is_linked:
        return False
    link = socket.links[0]
    return _is_feeder(link.from_node) and not (link.is_muted or link.from_node.mute)


# --- where its values lie ----------------------------------------------------------------------


def _home() -> bpy.types.NodeTree:
    return next(iter(carrier.all_of_file()), None) or carrier.only()


def _new_key() -> str:
    """That no group of another file has either."""
    return secrets.token_hex(4)


def _name(group: bpy.types.NodeTree, label: str) -> str:
    return carrier.live_name(group[_KEY], label)


def _value_in(group: bpy.types.NodeTree, label: str) -> Value:
    name = _name(group, label)
    here = next((home for home in carrier.all_of_file()[:1] if name in home), None)
    return _fallback(group, label).default_value if here is None else here[name]


def _settle_under(group: bpy.types.NodeTree, key: str, values: dict[str, Value]) -> None:
    """The values become properties of the carrier, which Blender's panels show as they do sockets,
    and the group reads them there.
    """
    group[_KEY], home = key, _home()
    told: Any = home.id_properties_ui  # the stubs have it return nothing
    for label, first in values.items():
        field, parameter = next(each for each in PARAMETERS.items() if each[1].label == label)
        name, (least, most) = _name(group, label), parameter.slider
        home[name] = _plain(first)
        told(name).update(
            min=float(parameter.minimum), max=float(parameter.maximum), soft_min=float(least),
            soft_max=float(most), step=10, precision=3, default=value_of(Paint(), field),
            description=parameter.description,
            subtype="COLOR" if parameter.is_color else parameter.subtype,
        )  # fmt: skip
        reader: bpy.types.Node | None = group.nodes.get(label)
        if reader is not None:
            reader.attribute_name = carrier.live_path(name)
    home.update_tag()


def _forget_unused() -> None:
    """Removes the values that no group reads any more."""
    carrier.keep_live({group[_KEY] for group in _groups()})


def _set_own(socket: bpy.types.NodeSocket, new: Value) -> None:
    socket.default_value = (*tuple(new)[:3], 1.0) if socket.type == "RGBA" else new


def _plain(of: Value) -> float | tuple[float, ...]:
    """As floats, and a colour without its alpha."""
    return tuple(map(float, of))[:3] if hasattr(of, "__len__") else float(of)


def _is_same(one: Value, two: Value) -> bool:
    """In single precision."""
    a, b = (np.array(_plain(each), np.float32) for each in (one, two))
    return np.array_equal(a, b)
