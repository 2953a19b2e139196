# SPDX-License-Identifier: GPL-3.0-or-later
"""The lights that a scene shows: those that stand in it, and instances of lights.

A collection instance has a matrix to follow, and so has the light in it. Instances within instances
are not followed, and what geometry nodes, particles, vertices or faces multiply only Blender's own
evaluation knows: such a light is where it was when somebody looked last.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import bpy
import numpy as np
from mathutils import Matrix

_NO_NUMBER = 2**31 - 1  # fills up what tells instances apart


@dataclass(frozen=True)
class Placed:
    """A light, and where it is."""

    lamp: bpy.types.Object
    matrix: Matrix = field(compare=False)
    instancer: bpy.types.Object | None = None  # None: the light itself
    number: tuple[int, ...] = ()  # which of its instances
    followed: bool = field(default=True, compare=False)  # by drivers, whatever moves

    @property
    def name(self) -> str:
        name = self.lamp.name_full
        return f"{name} in {self.instancer.name_full}" if self.instancer else name


def lights(layers: list[bpy.types.ViewLayer]) -> list[Placed]:
    """Each once, in the order of names, by which slots keep their lights."""
    themselves = {each for layer in layers for each in _themselves(layer)}
    return sorted({*themselves, *instances_in(layers)}, key=lambda each: (each.name, each.number))


def rendered(layer: bpy.types.ViewLayer, *, ever: bool = False) -> Iterator[bpy.types.Object]:
    """The objects of a view layer that a render shows; with `ever`, those too that may appear."""
    collections = [layer.layer_collection]
    while collections:
        current = collections.pop()
        if current.exclude or current.collection.hide_render:
            continue
        collections.extend(current.children)
        for thing in current.collection.objects:
            if not thing.hide_render or (ever and thing.animation_data):
                yield thing


def used_layers(scene: bpy.types.Scene) -> list[bpy.types.ViewLayer]:
    """Those that a render makes."""
    return [layer for layer in scene.view_layers if layer.use]


def unrendered(layer: bpy.types.ViewLayer) -> set[bpy.types.Object]:
    """The objects of a view layer that a render does not show."""
    return {*layer.objects}.difference(rendered(layer))


def instanced(layer: bpy.types.ViewLayer) -> Iterator[bpy.types.Object]:
    """The objects that particles, geometry nodes or collection instances multiply, as often."""
    for instance in layer.depsgraph.object_instances:
        if instance.is_instance:
            yield instance.object.original


def instances_in(layers: list[bpy.types.ViewLayer]) -> list[Placed]:
    """The lights among what is multiplied, which may be a forest: so it is looked at only where
    something can multiply lights.
    """
    if not _may_be_instanced():
        return []
    return list(dict.fromkeys(each for layer in layers for each in instances(layer.depsgraph)))


def _may_be_instanced() -> bool:
    """Whether anything but the collections of a scene has a light of the file."""
    lamps = {each for each in bpy.data.objects if each.type == "LIGHT"}
    users: set[bpy.types.ID] = {*lamps}
    held: set[bpy.types.ID] = set()
    while users:
        held |= users
        users = set().union(*bpy.data.user_map(subset=users).values()) - held
        if any(map(_multiplies, users)):
            return True
        users = {each for each in users if isinstance(each, bpy.types.Collection)}
    return any(map(_is_pattern, lamps))


def _is_pattern(lamp: bpy.types.Object) -> bool:
    """Whether vertices or faces of its parent show it, and it is not rendered itself."""
    return lamp.parent is not None and lamp.parent.instance_type in ("VERTS", "FACES")


def _multiplies(user: bpy.types.ID) -> bool:
    if isinstance(user, bpy.types.Object):
        types = {modifier.type for modifier in user.modifiers}
        return user.instance_type != "NONE" or "NODES" in types
    return isinstance(user, bpy.types.GeometryNodeTree | bpy.types.ParticleSettings)


def instances(depsgraph: bpy.types.Depsgraph) -> Iterator[Placed]:
    """Of lights that a render shows: those of collections by their matrices, also where the
    viewport hides them, and what else multiplies lights as Blender has evaluated it.
    """
    shown = {*rendered(depsgraph.view_layer)}
    of_collections: dict[tuple[bpy.types.Object, bpy.types.Object], list[Matrix]] = {}
    for instancer in (each for each in shown if each.instance_type == "COLLECTION"):
        for each, renders in _held(instancer, depsgraph):
            of_collections.setdefault((instancer, each.lamp), []).append(each.matrix)
            if renders:
                yield each
    for instance in depsgraph.object_instances:
        if not instance.is_instance or instance.object.type != "LIGHT":
            continue
        lamp, instancer = instance.object.original, instance.parent.original
        if lamp.hide_render or instancer not in shown:
            continue
        matrix = instance.matrix_world.copy()
        if any(_are_close(matrix, each) for each in of_collections.get((instancer, lamp), ())):
            continue
        number = tuple(each for each in instance.persistent_id if each != _NO_NUMBER)
        yield Placed(lamp, matrix, instancer, number, followed=False)


def _themselves(layer: bpy.types.ViewLayer) -> Iterator[Placed]:
    for thing in rendered(layer, ever=True):
        if thing.type == "LIGHT" and not _is_pattern(thing):
            yield Placed(thing, thing.evaluated_get(layer.depsgraph).matrix_world.copy())


def _held(
    instancer: bpy.types.Object, depsgraph: bpy.types.Depsgraph
) -> Iterator[tuple[Placed, bool]]:
    """The lights of the collections that an empty shows, and whether a render shows them."""
    outer, number = instancer.evaluated_get(depsgraph).matrix_world, tuple[int, ...]()
    waiting = [(instancer, outer, number, True)]
    while waiting:
        holder, outer, number, renders = waiting.pop()
        collection = holder.instance_collection
        if collection is None or holder.instance_type != "COLLECTION":
            continue
        held = [each for each in collection.all_objects if each.type in ("LIGHT", "EMPTY")]
        rendered_here = {*_rendered_of(collection)} if held and renders else set()
        there = outer @ Matrix.Translation(-collection.instance_offset)
        for i, thing in enumerate(held):
            matrix = there @ thing.evaluated_get(depsgraph).matrix_world
            if thing.type == "EMPTY":
                waiting.append((thing, matrix, (*number, i), thing in rendered_here))
            elif not _is_pattern(thing):
                # A product of two matrices is what drivers follow.
                light = Placed(thing, matrix, instancer, number, followed=not number)
                yield light, thing in rendered_here


def _rendered_of(collection: bpy.types.Collection) -> Iterator[bpy.types.Object]:
    """The objects that an instance of the collection shows in a render."""
    if not collection.hide_render:
        yield from (thing for thing in collection.objects if not thing.hide_render)
        for child in collection.children:
            yield from _rendered_of(child)


def _are_close(one: Matrix, other: Matrix) -> bool:
    return np.allclose(np.array(one), np.array(other), rtol=1e-5, atol=1e-5)
