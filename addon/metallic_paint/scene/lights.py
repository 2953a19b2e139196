# SPDX-License-Identifier: GPL-3.0-or-later
"""The lights that sparkle, in slots that every paint of the .blend shares.

The shader has to know direction and size of a light that makes sparkles; Cycles keeps its
strength, shadow and linking. One node group per file holds the slots. Which slots are in use, and
by what kind of light, are constants in it: OSL leaves out what they do not need. Where the lights
are comes from the carrier (carrier.py), so that no shader is compiled when they move.

A paint that is linked from another file brings that file's group along, which cannot be changed.
So the group of a file that is made to be linked (is_library) knows its file by a number, and looks
what number the scene has. Where that is another one, all slots are what the scene has. The
comparison folds: what is not taken is free. Only, Cycles prepares a paint that looks at the scene
anew whenever anything moves, so the groups of other files do not look.
"""

from __future__ import annotations

import math
import secrets
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import carrier, placed, sky, sun_lamp, wiring
from .placed import Placed

NAME = "Metallic Paint Lights"
VERSION = 5  # of its nodes
_LEAST_VERSION = 4  # with these outputs: paints of an older one keep the group they came with
SLOTS = carrier.SLOTS
METERS_PER_UNIT = "MetersPerUnit"
# 1: the flakes also show other light than the slots'; 2: of lamps too, which need a smooth lobe
OTHER_LIGHT = "OtherLight"

# Custom properties of the group: its version, its file's number, which a float holds, and whether
# it looks at the scene.
_MARK, _FILE, _LOOKS = "metallic_paint_lights", "metallic_paint_file", "metallic_paint_looks"

# The edge of a disc of 0.3 rad, seen head on, is then 30 % darker than its centre, and its sparkles
# are those of a disc of 1 % less.
_LEAST_SPREAD = math.radians(90)
LEAST_SQUARED_DISTANCE = 1e-8  # scene units²: a light in the paint's box is merely very bright
_NOT_FOLLOWED = " (an instance: a render without the add-on has its sparkles where it is now)"


_Squared = TypeVar("_Squared", float, np.ndarray)
_Constants = tuple[tuple[float, float, float, float], tuple[float, float, float]]
_OF_SCENE = METERS_PER_UNIT, OTHER_LIGHT


@dataclass(frozen=True)
class Report:
    """What became of the scene's lights."""

    placed: tuple[Placed, ...]  # slot 1 first
    without: dict[Placed, str]  # why they make no sparkles
    read_only: tuple[str, ...]  # linked files whose paints keep the lights they came with
    sky: str = ""  # the world's sun, which has the slot after them

    @property
    def slots(self) -> tuple[bpy.types.Object, ...]:
        """Objects, for a linked one may share a local one's name; slot 1 first."""
        return tuple(each.lamp for each in self.placed)

    @property
    def left_out(self) -> dict[bpy.types.Object, str]:
        return {each.lamp: why for each, why in self.without.items()}

    def __str__(self) -> str:
        lines = [
            f"light {i}: {each.name}{'' if each.followed else _NOT_FOLLOWED}"
            for i, each in enumerate(self.placed, 1)
        ]
        if self.sky:
            lines.append(f"light {len(self.placed) + 1}: {self.sky}")
        alike = Counter((each.name, why) for each, why in self.without.items())
        lines += [
            f"no sparkles from {f'{n} times ' if n > 1 else ''}{name}: {why}"
            for (name, why), n in alike.items()
        ]
        lines += [f"paints linked from {path} do not see these lights" for path in self.read_only]
        return "\n".join(lines)


def slot_names(slot: int) -> tuple[str, str, str, str]:
    """The shader's names of kind, vector, size and facing of a slot, 1..8."""
    return f"Light{slot}Kind", f"Light{slot}Vector", f"Light{slot}Size", f"Light{slot}Facing"


def node_group() -> bpy.types.ShaderNodeTree:
    """The file's one group of light slots, made when there is none."""
    return next(iter(groups()), None) or _new_group()


def groups() -> list[bpy.types.ShaderNodeTree]:
    """The file's own groups of light slots: none without a paint, several after an append."""
    trees = [tree for tree in bpy.data.node_groups if isinstance(tree, bpy.types.ShaderNodeTree)]
    return [each for each in trees if version(each) >= _LEAST_VERSION and each.library is None]


def linked_groups() -> list[bpy.types.NodeTree]:
    """Those of other files whose paints see the lights of this one."""
    return [each for each in bpy.data.node_groups if each.get(_LOOKS) and each.library]


def is_library() -> bool:
    """Whether this file's paints are for others to link."""
    return bool(why_library())


def why_library() -> str:
    """A paint is marked as an asset, itself or what shows it, or nothing can be rendered."""
    if not any(scene.camera for scene in bpy.data.scenes):
        return "no scene has a camera"
    for each in (*bpy.data.materials, *bpy.data.objects, *bpy.data.collections):
        if each.asset_data and not each.library and _shows_paint(each):
            return f"{each.name} is marked as an asset"
    return ""


def _shows_paint(what: bpy.types.Material | bpy.types.Object | bpy.types.Collection) -> bool:
    if isinstance(what, bpy.types.Material):
        return holds_slots(what.node_tree)
    things = what.all_objects if isinstance(what, bpy.types.Collection) else [what]
    return any(map(is_painted, things))


def is_outdated(group: bpy.types.NodeTree) -> bool:
    """Whether it is a group of light slots that today's paints cannot use."""
    return 0 < version(group) < _LEAST_VERSION


def has_any() -> bool:
    """Whether the file has a paint that can be given its lights."""
    return bool(groups() or linked_groups())


def version(group: bpy.types.ID) -> int:
    """Of a group of light slots, at least 1; 0 for anything else."""
    return group.get(_MARK, 0)


def fill(scene: bpy.types.Scene) -> Report:
    """Gives the slots to the scene's lights; call it again when lights come, go or change type.

    needs.fit calls it, and finds out whether the flakes have other light to show. What is so
    already is not touched: Blender would prepare all paints anew.

    Lights that render take part, also those that animation may show later. Of more than 8, those
    stay that send the greatest irradiance to any painted object, not counting shadows, light
    linking, and nodes of the light; those hidden now come last. The slots are ordered by name, so a
    light's sparkles do not change when another light grows brighter; area lights come after all
    others, and the sun of the world last, where a slot is left. A file of several scenes has the
    lights of the scene filled last.
    """
    group = _one_group()
    layers = placed.used_layers(scene)
    for layer in layers:
        layer.update()
    without: dict[Placed, str] = {}
    lights = []
    for each in placed.lights(layers):
        if sun_lamp.is_one(each.lamp):
            continue  # which has the slot of the world's sun
        if why := why_not(each.lamp):
            without[each] = why
        else:
            lights.append(each)
    lights.sort(key=lambda each: each.lamp.data.type == "AREA")  # and by name as before
    if len(lights) > SLOTS:
        sent = _irradiances(lights, _painted_boxes(layers))
        brightest = sorted(lights, key=lambda each: (each.lamp.hide_render, -sent[each]))
        for each in brightest[SLOTS:]:
            others = "other" if each.lamp.hide_render else "brighter"
            without[each] = f"{SLOTS} {others} lights have the slots"
        lights = [each for each in lights if each not in without]
    attached = carrier.attach(showing_paint())
    attached |= carrier.attach_to_scenes(bool(linked_groups()))
    if attached or not carrier.is_fed_by(lights):  # Blender notes a new way there with new drivers
        carrier.feed(lights)
        for layer in layers:
            layer.update()
    carrier.set_values(lights)
    kinds = [carrier.KINDS[each.lamp.data.type] for each in lights]
    numbers = [_constants(each) for each in lights]
    sun = sky.find(scene) if len(lights) < SLOTS else None
    in_sky = (*sun.direction, max(sun.sine, 1e-6)) if sun else None
    carrier.set_sky(len(lights) + 1, in_sky)
    if in_sky:
        kinds.append(carrier.SKY)
        numbers.append((in_sky, (0.0, 0.0, 0.0)))
    if not is_current(group) or kinds_of(group) != kinds:
        _build(group, kinds, numbers)
    _set(group, METERS_PER_UNIT, scene.unit_settings.scale_length)
    _tell_scenes(group)
    return Report(tuple(lights), without, linked_files(), sun.name if sun else "")


def why_not(light: bpy.types.Object) -> str:
    """Why a light can have no slot, whatever else there is; empty where it can."""
    if light.data.type not in carrier.KINDS:
        return f"lights of type {light.data.type} are not known"
    if not light.visible_glossy:
        return "its Ray Visibility has Glossy off, so no flake mirrors it"
    if isinstance(light.data, bpy.types.AreaLight):
        if light.data.cycles.is_portal:
            return "a portal is a window for the world's light"
        if light.data.spread < _LEAST_SPREAD:
            return (
                f"its Spread is below {math.degrees(_LEAST_SPREAD):.0f}°, so parts of it are dark"
            )
    return ""


def show_other_light(needed: bool, uneven: bool = False) -> None:
    """Whether the flakes show light from elsewhere than the slots, in a new file they do; and
    whether it comes from some sides more, as of lamps, which random flakes show with much noise."""
    group = node_group()
    from_sides = 3.0 if rays_meet_all() else 2.0
    _set(group, OTHER_LIGHT, from_sides if needed and uneven else float(needed))
    _tell_scenes(group)


def rays_meet_all() -> bool:
    """Whether a mirror shows every lamp of the file: Cycles leaves out those without multiple
    importance sampling."""
    return all(light.cycles.use_multiple_importance_sampling for light in bpy.data.lights)


def _tell_scenes(group: bpy.types.ShaderNodeTree) -> None:
    meters, other_light = (constant(name) for name in (METERS_PER_UNIT, OTHER_LIGHT))
    told = (float(group[_FILE]), meters, other_light) if linked_groups() else None
    carrier.tell_scenes(told, group)


def is_current(group: bpy.types.ShaderNodeTree) -> bool:
    """Whether it has today's nodes, and another number than every linked one."""
    return version(group) >= VERSION and _has_own_number(group) and group[_LOOKS] == is_library()


def keeps_lights(group: bpy.types.ID) -> bool:
    """Whether it is a group of light slots that has its own file's lights wherever it is linked."""
    return bool(version(group)) and not group.get(_LOOKS)


def _has_own_number(group: bpy.types.ShaderNodeTree) -> bool:
    """Copies of a file have the same one until they meet."""
    return _FILE in group and group[_FILE] not in {each[_FILE] for each in linked_groups()}


def in_slots() -> list[bpy.types.Object]:
    """The lights that feed the slots now."""
    things = [each for tree in carrier.all_of_file()[:1] for each in carrier.sources_of(tree)]
    return [each for each in things if each.type == "LIGHT"]


def renew(depsgraph: bpy.types.Depsgraph) -> None:
    """The places of instances that no driver follows."""
    if kept := carrier.not_followed():
        there = {(each.lamp, each.instancer, each.number): each
                 for each in placed.instances(depsgraph)}  # fmt: skip
        for slot, who in kept.items():
            if who in there:
                carrier.renew(slot, there[who])


# --- the group ---------------------------------------------------------------------------------


def _new_group() -> bpy.types.ShaderNodeTree:
    group = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    group.description = "The lights that sparkle, shared by all metallic paints of this file"
    outputs = [(METERS_PER_UNIT, "NodeSocketFloat"), (OTHER_LIGHT, "NodeSocketFloat")]
    for slot in range(SLOTS, 0, -1):
        kinds = ("NodeSocketFloat", "NodeSocketVector", "NodeSocketFloat", "NodeSocketVector")
        outputs[:0] = zip(slot_names(slot), kinds, strict=True)
    for name, socket in outputs:
        group.interface.new_socket(name, in_out="OUTPUT", socket_type=socket)
    _build(group, [], [])
    return group


def _build(
    group: bpy.types.ShaderNodeTree,
    kinds: Sequence[int],
    numbers: Sequence[_Constants],
) -> None:
    """Slots of these kinds, 1 first; the numbers are for objects that have no carrier."""
    of_scene = {
        name: _own(group, name).default_value if version(group) else 1 for name in _OF_SCENE
    }
    out = _output(group)
    for node in [each for each in group.nodes if each != out]:
        group.nodes.remove(node)
    group.animation_data_clear()
    group[_MARK] = VERSION
    if not _has_own_number(group):
        group[_FILE] = 1 + secrets.randbelow(2**24 - 1)
    group[_LOOKS] = is_library()
    scene = _look_at_scene(group) if group[_LOOKS] else None
    for name in _OF_SCENE:
        _hand_out(group, name, of_scene[name], scene)
    for slot in range(1, SLOTS + 1):
        row = []
        here: list[bpy.types.NodeSocket | wiring.Constant] = [
            0.0,
            (0.0, 0.0, 0.0),
            0.0,
            (0.0, 0.0, 0.0),
        ]
        if slot <= len(kinds):
            here[0] = float(kinds[slot - 1])
            (*own_place, own_size), own_facing = numbers[slot - 1]
            carried = wiring.attribute(group, "INSTANCER", carrier.path(slot, kinds[slot - 1]))
            is_there = wiring.compute(group, "GREATER_THAN", carried.outputs["Alpha"], 0)
            place = wiring.mix(
                group, "VECTOR", is_there.outputs[0], tuple(own_place), carried.outputs["Vector"]
            )
            extent = wiring.mix(
                group, "FLOAT", is_there.outputs[0], own_size, carried.outputs["Alpha"]
            )
            here[1:3] = wiring.result(place), wiring.result(extent)
            row = [carried, is_there, place, extent]
            if kinds[slot - 1] == carrier.AREA:
                side = wiring.attribute(group, "INSTANCER", carrier.facing_path(slot))
                normal = wiring.mix(
                    group, "VECTOR", is_there.outputs[0], own_facing, side.outputs["Vector"]
                )
                here[3] = wiring.result(normal)
                row += [side, normal]
        if scene:
            row += scene.slots[slot - 1]
        for name, own in zip(slot_names(slot), here, strict=True):
            row += _hand_out(group, name, own, scene)
        _arrange(row, slot)


@dataclass(frozen=True)
class _Scene:
    """What the nodes of a group find at the scene."""

    is_elsewhere: bpy.types.Node  # 1 where the scene is another file's
    values: dict[str, bpy.types.NodeSocket]  # of each output
    slots: list[list[bpy.types.Node]]


def _look_at_scene(group: bpy.types.ShaderNodeTree) -> _Scene:
    told = wiring.attribute(group, "VIEW_LAYER", carrier.FILE_PATH)
    apart = group.nodes.new("ShaderNodeSeparateXYZ")
    group.links.new(told.outputs["Vector"], apart.inputs[0])
    number, *values = apart.outputs
    is_known = wiring.compute(group, "GREATER_THAN", number, 0.5)
    is_own = wiring.compute(group, "COMPARE", number, group[_FILE], 0.5)
    is_elsewhere = wiring.compute(group, "GREATER_THAN", is_known.outputs[0], is_own.outputs[0])
    _arrange([told, apart, is_known, is_own, is_elsewhere], 0)
    found = dict(zip(_OF_SCENE, values, strict=True))
    slots = []
    for slot in range(1, SLOTS + 1):
        where = wiring.attribute(group, "VIEW_LAYER", carrier.scene_path(slot))
        what = wiring.attribute(group, "VIEW_LAYER", carrier.facing_path(slot))
        sources = (what, "Alpha"), (where, "Vector"), (where, "Alpha"), (what, "Vector")
        for name, (node, output) in zip(slot_names(slot), sources, strict=True):
            found[name] = node.outputs[output]
        slots.append([where, what])
    return _Scene(is_elsewhere, found, slots)


def _hand_out(
    group: bpy.types.ShaderNodeTree,
    name: str,
    own: bpy.types.NodeSocket | wiring.Constant,
    scene: _Scene | None,
) -> list[bpy.types.Node]:
    """What an output gives: the file's own, or the scene's where that is another file's."""
    into = _output(group).inputs[name]
    if scene is None:
        wiring.feed(group, into, own)
        return []
    value = scene.values[name]
    data_type: wiring.Type = "VECTOR" if value.type == "VECTOR" else "FLOAT"
    chosen = wiring.mix(group, data_type, scene.is_elsewhere.outputs[0], own, value, into)
    chosen.name = name
    return [chosen]


def _arrange(row: Sequence[bpy.types.Node], line: int) -> None:
    for column, node in enumerate(row):
        node.location = 200 * (column - len(row)), -250 * line


def _constants(light: Placed) -> _Constants:
    return carrier.numbers_of(light), carrier.facing_of(light)


def _output(group: bpy.types.ShaderNodeTree) -> bpy.types.Node:
    return next((node for node in group.nodes if node.type == "GROUP_OUTPUT"), None) or (
        group.nodes.new("NodeGroupOutput")
    )


def _own(group: bpy.types.ShaderNodeTree, name: str) -> bpy.types.NodeSocket:
    """Which holds a constant of the group, for scenes of its own file."""
    node: bpy.types.Node | None = group.nodes.get(name)
    if node is None:  # of a group that does not look at the scene
        return _output(group).inputs[name]
    return next(each for each in node.inputs if each.identifier == "A_Float")


def kinds_of(group: bpy.types.ShaderNodeTree) -> list[int]:
    """Of the slots in use, 1 first."""
    sockets = (_own(group, slot_names(slot)[0]) for slot in range(1, SLOTS + 1))
    return [kind for socket in sockets if (kind := round(socket.default_value))]


def _set(group: bpy.types.ShaderNodeTree, name: str, value: float) -> None:
    """A constant, which holds single precision; Blender compiles all paints anew for a change."""
    socket = _own(group, name)
    if not math.isclose(socket.default_value, value, rel_tol=1e-6, abs_tol=1e-12):
        socket.default_value = value


def constant(name: str) -> float:
    """Of the file's slots: a kind, METERS_PER_UNIT or OTHER_LIGHT."""
    return _own(node_group(), name).default_value


def _one_group() -> bpy.types.ShaderNodeTree:
    """The file's group; the copies that appended paints bring along become it."""
    group = node_group()
    for other in groups():
        if other != group:
            other.user_remap(group)
            bpy.data.node_groups.remove(other)
    return group


def linked_files() -> tuple[str, ...]:
    """The files that paints are linked from which keep the lights that they have there."""
    linked = [each for each in bpy.data.node_groups if each.library and keeps_lights(each)]
    return tuple(sorted({each.library.filepath for each in linked}))


# --- the brightest -----------------------------------------------------------------------------


@dataclass(frozen=True)
class _Box:
    """An object's bounding box in the world."""

    matrix: Matrix
    low: Vector
    high: Vector

    @property
    def center(self) -> Vector:
        return self.matrix @ ((self.low + self.high) / 2)

    @property
    def radius(self) -> float:
        return (self.matrix.to_3x3() @ (self.high - self.low)).length / 2

    def nearest(self, point: Vector) -> Vector:
        local = self.matrix.inverted_safe() @ point
        bounded = zip(self.low, local, self.high, strict=True)
        return self.matrix @ Vector([min(max(low, x), high) for low, x, high in bounded])


def _painted_boxes(layers: list[bpy.types.ViewLayer]) -> list[_Box]:
    """The painted objects and instances; without any, every mesh; without those, the origin."""
    painted, meshes = [], []
    for layer in layers:
        for instance in layer.depsgraph.object_instances:
            thing = instance.object
            if thing.type == "MESH" and not thing.original.hide_render:
                box = _box(thing, instance.matrix_world.copy())
                meshes.append(box)
                if is_painted(thing):
                    painted.append(box)
    return painted or meshes or [_Box(Matrix(), Vector(), Vector())]


def _box(thing: bpy.types.Object, matrix: Matrix) -> _Box:
    axes = [*zip(*thing.bound_box, strict=True)]
    return _Box(matrix, Vector([min(axis) for axis in axes]), Vector([max(axis) for axis in axes]))


def is_painted(thing: bpy.types.Object) -> bool:
    materials = [slot.material for slot in thing.material_slots if slot.material]
    return any(holds_slots(each.node_tree) for each in materials)


def uses_paint(scene: bpy.types.Scene) -> bool:
    """Whether an object of the scene, or of a collection that it shows as instances, is painted."""
    return _shows_any(scene, showing_paint(editable=False))


def painted_scenes() -> list[bpy.types.Scene]:
    """Those that use paint."""
    painted = showing_paint(editable=False)
    return [each for each in bpy.data.scenes if _shows_any(each, painted)]


def _shows_any(scene: bpy.types.Scene, painted: set[bpy.types.Object]) -> bool:
    collections = [scene.collection]
    for collection in collections:
        things = collection.all_objects
        if not painted.isdisjoint(things):
            return True
        shown = dict.fromkeys(thing.instance_collection for thing in things)
        collections += [each for each in shown if each is not None and each not in collections]
    return False


def showing_paint(*, editable: bool = True) -> set[bpy.types.Object]:
    """The file's objects that show a paint, by their material slots or by geometry nodes, and can
    be changed; without `editable`, all. Where an empty shows a linked collection, its objects
    cannot, and the empty is.
    """
    paints = {each for each in bpy.data.materials if holds_slots(each.node_tree)}
    found: set[bpy.types.Object] = set()
    users: set[bpy.types.ID] = {*paints}
    seen: set[bpy.types.ID] = set()
    while users:
        seen |= users
        users = set().union(*bpy.data.user_map(subset=users).values()) - seen
        found |= {each for each in users if isinstance(each, bpy.types.Object)}
        # On the way lie meshes and the like, and the trees of geometry nodes.
        users = {
            each
            for each in users
            if hasattr(each, "materials") or isinstance(each, bpy.types.GeometryNodeTree)
        }
    found |= {each for each in bpy.data.objects if _shows_linked(each, found)}
    return {each for each in found if each.is_editable or not editable}


def _shows_linked(thing: bpy.types.Object, painted: set[bpy.types.Object]) -> bool:
    collection = thing.instance_collection
    if collection is None or collection.library is None:
        return False
    return any(each in painted for each in collection.all_objects)


def holds_slots(tree: bpy.types.NodeTree | None) -> bool:
    """Whether there is a paint in the tree or in a group of it."""
    if tree is None:
        return False
    groups = [node.node_tree for node in tree.nodes if node.type == "GROUP" and node.node_tree]
    return any(_MARK in group or holds_slots(group) for group in groups)


def _irradiances(lights: list[Placed], boxes: list[_Box]) -> dict[Placed, float]:
    """The greatest irradiance, W/m², that each light sends to any of the boxes."""
    return {
        each: max(_irradiance(each.lamp.data, each.matrix, box) for box in boxes) for each in lights
    }


def irradiance(light: bpy.types.Light, squared_distance: _Squared) -> _Squared:
    """Of a plane that faces the light, and that an area light faces, W/m².

    Without shadows; as if the light's power were normalized, and its colour its strongest.
    """
    strength = light.energy * max(light.color) * 2**light.exposure
    if light.type == "SUN":
        return strength + 0 * squared_distance  # as many as there are distances
    return strength / ((1 if light.type == "AREA" else 4) * math.pi * squared_distance)


def _irradiance(light: bpy.types.Light, matrix: Matrix, box: _Box) -> float:
    position = matrix.translation
    if isinstance(light, bpy.types.SpotLight) and not _spot_reaches(light, matrix, box):
        return 0.0
    squared_distance = max(
        (box.nearest(position) - position).length_squared,
        getattr(light, "shadow_soft_size", 0) ** 2,
        LEAST_SQUARED_DISTANCE,
    )
    facing = _faces(matrix, box) if isinstance(light, bpy.types.AreaLight) else 1.0
    return facing * irradiance(light, squared_distance)


def _faces(matrix: Matrix, box: _Box) -> float:
    """The greatest cosine to an area light's normal that the sphere around the box comes to."""
    towards, axis = box.center - matrix.translation, -matrix.col[2].xyz
    if towards.length <= box.radius:
        return 1.0
    angle = axis.angle(towards, 0) - math.asin(box.radius / towards.length)
    return max(math.cos(max(angle, 0)), 0)


def _spot_reaches(light: bpy.types.SpotLight, matrix: Matrix, box: _Box) -> bool:
    """Whether the spot's cone meets the sphere around the box."""
    local = _Box(matrix.inverted_safe() @ box.matrix, box.low, box.high)
    distance = local.center.length
    if distance <= local.radius:
        return True
    return off_axis(matrix, box.center) - math.asin(local.radius / distance) < light.spot_size / 2


def off_axis(matrix: Matrix, point: Vector) -> float:
    """The angle at a spot between its axis and a point: Cycles scales the cone with the object."""
    return Vector((0, 0, -1)).angle(matrix.inverted_safe() @ point, 0)
