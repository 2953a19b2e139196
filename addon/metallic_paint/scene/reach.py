# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of the lights that have slots reach a painted object: what takes their sparkles away."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import lights, needs, sky
from .sight import Room, Seen, lets_light_pass, past

_RAYS = 60  # to each light, from places spread over what the camera sees
_HIDDEN = 0.99  # of the places: so little sparkles that one takes it for none


def dark(lamps: tuple[bpy.types.Object, ...]) -> Iterator[str]:
    """Of the lights that give none."""
    for lamp in dict.fromkeys(lamps):
        data = lamp.data
        if data.energy <= 0:
            yield f"{lamp.name} gives no light: its Power or Strength is {data.energy:g}."
        elif max(data.color) <= 0:
            yield f"{lamp.name} gives no light: its Color is black."
        elif _is_dark(data):
            yield f"{lamp.name} gives no light: its nodes give none."


def _is_dark(data: bpy.types.Light) -> bool:
    """Whether its nodes surely give no light."""
    tree = data.node_tree
    if tree is None or (bpy.app.version < (5, 0) and not data.use_nodes):
        return False
    out = tree.get_output_node("CYCLES")
    node = sky.source(out.inputs["Surface"]) if out else None
    if node is None:
        return True
    return node.type == "EMISSION" and not needs.may_shine(node, "Color", "Strength")


def overridden(layer: bpy.types.ViewLayer) -> str | None:
    """Of a view layer that shows another material than the paint."""
    if layer.material_override is None:
        return None
    return (
        f"View layer {layer.name} shows everything in {layer.material_override.name}: its Material "
        "Override hides all paints."
    )


def lacking(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    thing: bpy.types.Object,
    seen: Seen,
    found: lights.Report,
) -> Iterator[str]:
    """Sentences about the lights that do not reach what the camera sees of a painted object."""
    room = Room.of(scene, layer)
    places = np.linspace(0, len(seen.position) - 1, min(_RAYS, len(seen.position))).astype(int)
    for light in _lights(scene, found):
        if light.lamp is not None and not _is_linked(light.lamp, thing):
            yield (
                f"Light linking keeps {light.name} from {thing.name}: add it to the light's "
                "collection to see its sparkles."
            )
            continue
        facing, outside = 0, 0
        blockers: Counter[bpy.types.Object] = Counter()
        for i in places:
            position, normal = Vector(seen.position[i]), Vector(seen.normal[i])
            towards, distance = light.way(position)
            if towards.dot(normal) <= 0:
                continue
            facing += 1
            if light.misses(position):
                outside += 1
                continue
            blocker = _first_shadow(room, light, position, towards, distance)
            if blocker is not None:
                blockers[blocker] += 1
        if facing == 0:
            continue  # it lights the far side
        if outside + blockers.total() < _HIDDEN * facing:
            continue
        if outside > blockers.total():
            yield f"{light.name} shines past what the camera sees of {thing.name}: its cone ends."
        else:
            [(blocker, _)] = blockers.most_common(1)
            yield (
                f"{blocker.name} keeps {light.name} from what the camera sees of {thing.name}: "
                "in its shadow nothing sparkles."
            )


@dataclass(frozen=True)
class _Light:
    name: str
    lamp: bpy.types.Object | None  # None for a world's sun
    direction: Vector | None  # towards one that is far away
    matrix: Matrix
    cone: float  # half-angle of a spot

    def way(self, position: Vector) -> tuple[Vector, float]:
        """Unit vector towards it, and how far it is."""
        if self.direction is not None:
            return self.direction, 1e9
        off = self.matrix.translation - position
        return off.normalized(), off.length

    def misses(self, position: Vector) -> bool:
        return lights.off_axis(self.matrix, position) > self.cone


def _lights(scene: bpy.types.Scene, found: lights.Report) -> Iterator[_Light]:
    """Those that have a slot."""
    for light in found.placed:
        lamp, matrix = light.lamp, light.matrix
        far = matrix.col[2].xyz.normalized() if lamp.data.type == "SUN" else None
        cone = lamp.data.spot_size / 2 if lamp.data.type == "SPOT" else math.inf
        yield _Light(light.name, lamp, far, matrix, cone)
    if found.sky and (sun := sky.find(scene)):
        yield _Light(sun.name, None, Vector(sun.direction), Matrix(), math.inf)


def _first_shadow(
    room: Room,
    light: _Light,
    origin: Vector,
    towards: Vector,
    distance: float,
) -> bpy.types.Object | None:
    """The first object on the way to a light that keeps it off."""
    lamp = light.lamp
    if lamp is not None and not lamp.data.use_shadow:
        return None
    start = past(origin, towards)
    for found, polygon in room.surfaces_on(start, towards, distance):
        thing = found.original
        if (
            thing.visible_shadow
            and (lamp is None or _blocks(lamp, thing))
            and not lets_light_pass(found, polygon)
        ):
            return thing
    return None


# --- light linking -----------------------------------------------------------------------------


def _is_linked(lamp: bpy.types.Object, thing: bpy.types.Object) -> bool:
    return _holds(lamp.light_linking.receiver_collection, thing)


def _blocks(lamp: bpy.types.Object, thing: bpy.types.Object) -> bool:
    return _holds(lamp.light_linking.blocker_collection, thing)


def _holds(collection: bpy.types.Collection | None, thing: bpy.types.Object) -> bool:
    """Whether a collection of a light's linking names an object.

    The last entry that has it decides; where all entries exclude, what none has is in.
    """
    if collection is None:
        return True
    entries = [
        (child.light_linking.link_state, thing in [*held.all_objects])
        for child, held in zip(collection.collection_children, collection.children, strict=True)
    ] + [
        (entry.light_linking.link_state, held == thing)
        for entry, held in zip(collection.collection_objects, collection.objects, strict=True)
    ]
    found = [state for state, holds in entries if holds]
    if found:
        return found[-1] == "INCLUDE"
    return all(state == "EXCLUDE" for state, _ in entries)
