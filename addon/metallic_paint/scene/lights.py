# SPDX-License-Identifier: GPL-3.0-or-later
"""The lights that sparkle, in slots that every paint of the .blend shares.

The shader has to know direction and size of a light that makes sparkles; Cycles keeps its
strength, shadow and linking. One node group per file holds the slots. Drivers feed them with
simple expressions, which Blender evaluates without running Python, so that a render machine
needs neither this add-on nor permission to run scripts.

Direction and position come from the light's matrix, as Cycles takes them: the normalised third
column towards a sun, the fourth column for a position. Rotation channels (ROT_W ... ROT_Z) would
point elsewhere than Cycles under a parent that is mirrored or scaled along one axis.
The radius of a point or spot light is that of its data: Cycles does not scale it with the object.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import bpy
from mathutils import Matrix, Vector

NAME = "Metallic Paint Lights"
VERSION = 2
SLOTS = 8
METERS_PER_UNIT = "MetersPerUnit"
OTHER_LIGHT = "OtherLight"  # 1: the flakes also show other light than the slots'

PARALLEL, POSITIONED = 1, 2  # the shader's kinds; 0 is an unused slot
_KINDS = {"SUN": PARALLEL, "POINT": POSITIONED, "SPOT": POSITIONED}
# The property of the light's data that is its size, and what the slot has of it.
_SIZES = {PARALLEL: ("angle", "sin(size/2)"), POSITIONED: ("shadow_soft_size", "size")}
_MARK = "metallic_paint_lights"  # custom property of the group, holds its version

_DIRECTION = tuple(f"{c}/max(sqrt(x*x+y*y+z*z),1e-30)" for c in "xyz")
_MIN_SQUARED_DISTANCE = 1e-8  # scene units²: a light in the paint's box is merely very bright


@dataclass(frozen=True)
class Report:
    """What became of the scene's lights: objects, for a linked one may share a local one's name."""

    slots: tuple[bpy.types.Object, ...]  # slot 1 first
    left_out: dict[bpy.types.Object, str]  # why they make no sparkles
    read_only: tuple[str, ...]  # linked files whose paints keep the lights they came with

    def __str__(self) -> str:
        lines = [f"light {i}: {light.name_full}" for i, light in enumerate(self.slots, 1)]
        lines += [
            f"no sparkles from {light.name_full}: {why}" for light, why in self.left_out.items()
        ]
        lines += [f"paints linked from {path} do not see these lights" for path in self.read_only]
        return "\n".join(lines)


def slot_names(slot: int) -> tuple[str, str, str]:
    """The shader's names of kind, vector and size of a slot, 1..8."""
    return f"Light{slot}Kind", f"Light{slot}Vector", f"Light{slot}Size"


def node_group() -> bpy.types.ShaderNodeTree:
    """The file's one group of light slots, made when there is none."""
    return next(iter(groups()), None) or _new_group()


def groups() -> list[bpy.types.ShaderNodeTree]:
    """The file's own groups of light slots: none without a paint, several after an append."""
    trees = [tree for tree in bpy.data.node_groups if isinstance(tree, bpy.types.ShaderNodeTree)]
    return [group for group in trees if group.get(_MARK) == VERSION and group.library is None]


def version(group: bpy.types.ID) -> int:
    """Of a group of light slots, at least 1; 0 for anything else."""
    return group.get(_MARK, 0)


def fill(scene: bpy.types.Scene) -> Report:
    """Gives the slots to the scene's lights; call it again when lights come, go or change type.

    needs.fit calls it, and finds out whether the flakes have other light to show. What is so
    already is not touched: Blender would prepare all paints anew.

    Suns, point and spot lights that render take part, also those that animation may show later. Of
    more than 8, those stay that send the greatest irradiance to any painted object, not counting
    shadows, light linking, and nodes of the light; those hidden now come last. The slots are
    ordered by name, so a light's sparkles do not change when another light grows brighter. A file
    of several scenes has the lights of the scene filled last.
    """
    group = _one_group()
    layers = used_layers(scene)
    for layer in layers:
        layer.update()
    matrices = _rendered_lights(layers)
    left_out = _instances(layers, matrices)
    for light in [light for light in matrices if light.data.type not in _KINDS]:
        del matrices[light]
        left_out[light] = "an area light makes no sparkles"
    lights = sorted(matrices, key=lambda light: light.name_full)
    if len(lights) > SLOTS:
        irradiance = _irradiances(matrices, _painted_boxes(layers))
        brightest = sorted(lights, key=lambda light: (light.hide_render, -irradiance[light]))
        for light in brightest[SLOTS:]:
            others = "other" if light.hide_render else "brighter"
            left_out[light] = f"{SLOTS} {others} lights have the slots"
        lights = [light for light in lights if light in brightest[:SLOTS]]
    fed = _are_fed_by(group, lights)
    if not fed:
        _clear(group)
        for slot, light in enumerate(lights, 1):
            _feed(group, slot, light)
    for slot, light in enumerate(lights, 1):
        for socket, value in zip(
            _inputs(group, slot), _values(light, matrices[light]), strict=True
        ):
            _set(socket, value)
    if not fed:
        for layer in layers:
            layer.update()
    _set(group.nodes[METERS_PER_UNIT].outputs[0], scene.unit_settings.scale_length)
    return Report(tuple(lights), left_out, linked_files())


def show_other_light(needed: bool) -> None:
    """Whether the flakes show light from elsewhere than the slots; in a new file they do."""
    _set(node_group().nodes[OTHER_LIGHT].outputs[0], float(needed))


def are_fed() -> bool:
    """Whether the light of every slot in use still exists."""
    return all(source for group in groups()[:1] for source in _driven(group).values())


def in_slots() -> list[bpy.types.Object]:
    """The lights that feed the slots now."""
    return [lamp for group in groups()[:1] for lamp in feeding(group)]


def feeding(group: bpy.types.ShaderNodeTree) -> list[bpy.types.Object]:
    """The lights that the slots of this group look at."""
    lamps = [each for each in _driven(group).values() if isinstance(each, bpy.types.Object)]
    return list(dict.fromkeys(lamps))


def values() -> list[tuple[float, Vector, float]]:
    """Kind, vector and size of the slots in use, as they stand."""
    group = node_group()
    slots = [[socket.default_value for socket in _inputs(group, i)] for i in range(1, SLOTS + 1)]
    return [(kind, Vector(xyz), size) for kind, *xyz, size in slots if kind]


# --- the group ---------------------------------------------------------------------------------


def _new_group() -> bpy.types.ShaderNodeTree:
    group = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    group[_MARK] = VERSION
    group.description = "The lights that sparkle, shared by all metallic paints of this file"
    out = group.nodes.new("NodeGroupOutput")
    out.location.x = 300
    for slot in range(1, SLOTS + 1):
        kind, vector, size = slot_names(slot)
        _add_output(group, out, kind, "ShaderNodeValue", "NodeSocketFloat")
        _add_output(group, out, vector, "ShaderNodeCombineXYZ", "NodeSocketVector")
        _add_output(group, out, size, "ShaderNodeValue", "NodeSocketFloat")
    _add_output(group, out, METERS_PER_UNIT, "ShaderNodeValue", "NodeSocketFloat")
    _add_output(group, out, OTHER_LIGHT, "ShaderNodeValue", "NodeSocketFloat")
    _clear(group)
    for name in (METERS_PER_UNIT, OTHER_LIGHT):
        _set(group.nodes[name].outputs[0], 1)
    return group


def _add_output(
    group: bpy.types.ShaderNodeTree, out: bpy.types.Node, name: str, node: str, socket: str
) -> None:
    group.interface.new_socket(name, in_out="OUTPUT", socket_type=socket)
    source = group.nodes.new(node)
    source.name = source.label = name
    source.location.y = -100 * len(group.nodes)
    group.links.new(source.outputs[0], out.inputs[name])


def _clear(group: bpy.types.ShaderNodeTree) -> None:
    """Every slot unused and without drivers."""
    group.animation_data_clear()
    for slot in range(1, SLOTS + 1):
        for socket in _inputs(group, slot):
            socket.default_value = 0


def _set(socket: bpy.types.NodeSocket, value: float) -> None:
    """Sockets hold single precision."""
    if not math.isclose(socket.default_value, value, rel_tol=1e-6, abs_tol=1e-12):
        socket.default_value = value


def _inputs(group: bpy.types.ShaderNodeTree, slot: int) -> list[bpy.types.NodeSocket]:
    """Where a slot's five numbers are set: kind, x, y, z, size."""
    kind, vector, size = (group.nodes[name] for name in slot_names(slot))
    return [kind.outputs[0], *vector.inputs, size.outputs[0]]


def _one_group() -> bpy.types.ShaderNodeTree:
    """The file's group; the copies that appended paints bring along become it."""
    group = node_group()
    for other in groups():
        if other != group:
            other.user_remap(group)
            bpy.data.node_groups.remove(other)
    return group


def linked_files() -> tuple[str, ...]:
    """The files that paints are linked from, which keep the lights that they have there."""
    trees = bpy.data.node_groups
    return tuple(sorted({g.library.filepath for g in trees if _MARK in g and g.library}))


# --- drivers -----------------------------------------------------------------------------------


def _values(light: bpy.types.Object, matrix: Matrix) -> tuple[float, ...]:
    """A slot's five numbers."""
    kind = _KINDS[light.data.type]
    if kind == PARALLEL:
        return kind, *matrix.col[2].xyz.normalized(), math.sin(size_of(light) / 2)
    return kind, *matrix.translation, size_of(light)


def size_of(light: bpy.types.Object) -> float:
    """The angle of a sun, the radius of a point or spot light; 0 for those that have no slot."""
    kind = _KINDS.get(light.data.type)
    return getattr(light.data, _SIZES[kind][0]) if kind else 0.0


def has_driven_size(light: bpy.types.Object) -> bool:
    """Whether a driver follows the size: it may be animated.

    Otherwise the size is set, and again when it changes: a driver on the light's data would run
    whenever its strength changes, and Blender would prepare all paints anew.
    """
    return light.data.animation_data is not None


def _feed(group: bpy.types.ShaderNodeTree, slot: int, light: bpy.types.Object) -> None:
    """The drivers that keep the slot's values so."""
    _, *place, size = _inputs(group, slot)
    kind = _KINDS[light.data.type]
    column, expressions = (2, _DIRECTION) if kind == PARALLEL else (3, ("x", "y", "z"))
    if has_driven_size(light):
        name, expression = _SIZES[kind]
        _drive(size, expression, {"size": (light.data, name)})
    variables = {c: (light, f"matrix_world[{column}][{i}]") for i, c in enumerate("xyz")}
    for socket, expression in zip(place, expressions, strict=True):
        _drive(socket, expression, variables)


def _driven(group: bpy.types.ShaderNodeTree) -> dict[str, bpy.types.ID | None]:
    """What each driver looks at, None for what is gone, by the path of what it drives."""
    curves = group.animation_data.drivers if group.animation_data else ()
    return {curve.data_path: _source(curve.driver) for curve in curves}


def _source(driver: bpy.types.Driver) -> bpy.types.ID | None:
    return next((variable.targets[0].id for variable in driver.variables), None)


def _are_fed_by(group: bpy.types.ShaderNodeTree, lights: list[bpy.types.Object]) -> bool:
    """Whether the slots have drivers to just these lights, as what they now are."""
    driven: dict[str, bpy.types.ID | None] = {}
    kinds = []
    for slot, light in enumerate(lights, 1):
        kind, *place, size = _inputs(group, slot)
        kinds.append(kind.default_value == _KINDS[light.data.type])
        driven |= dict.fromkeys((socket.path_from_id("default_value") for socket in place), light)
        if has_driven_size(light):
            driven[size.path_from_id("default_value")] = light.data
    return all(kinds) and driven == _driven(group)


def _drive(
    socket: bpy.types.NodeSocket,
    expression: str,
    variables: Mapping[str, tuple[bpy.types.ID, str]],
) -> None:
    driver = socket.driver_add("default_value").driver  # type: ignore[union-attr]  # not an array
    driver.type = "SCRIPTED"
    for name, (datablock, path) in variables.items():
        variable = driver.variables.new()
        variable.name = name
        variable.type = "SINGLE_PROP"
        target = variable.targets[0]
        target.id_type = "LIGHT" if isinstance(datablock, bpy.types.Light) else "OBJECT"
        target.id = datablock
        target.data_path = path
    driver.expression = expression
    assert driver.is_simple_expression, expression
    assert driver.is_valid, expression


# --- which lights ------------------------------------------------------------------------------


def used_layers(scene: bpy.types.Scene) -> list[bpy.types.ViewLayer]:
    """Those that a render makes."""
    return [layer for layer in scene.view_layers if layer.use]


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


def _rendered_lights(layers: list[bpy.types.ViewLayer]) -> dict[bpy.types.Object, Matrix]:
    return {
        light: light.evaluated_get(layer.depsgraph).matrix_world.copy()
        for layer in layers
        for light in rendered(layer, ever=True)
        if light.type == "LIGHT"
    }


def _instances(
    layers: list[bpy.types.ViewLayer], lights: dict[bpy.types.Object, Matrix]
) -> dict[bpy.types.Object, str]:
    return {
        thing: "an instanced light has no place that a driver could follow"
        for layer in layers
        for thing in instanced(layer)
        if thing.type == "LIGHT" and thing not in lights
    }


def instanced(layer: bpy.types.ViewLayer) -> Iterator[bpy.types.Object]:
    """The objects that particles, geometry nodes or collection instances multiply, as often."""
    for instance in layer.depsgraph.object_instances:
        if instance.is_instance:
            yield instance.object.original


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
    paints = {each for each in bpy.data.materials if holds_slots(each.node_tree)}
    collections = [scene.collection]
    for collection in collections:
        things = collection.all_objects
        if any(slot.material in paints for thing in things for slot in thing.material_slots):
            return True
        shown = dict.fromkeys(thing.instance_collection for thing in things)
        collections += [each for each in shown if each is not None and each not in collections]
    return False


def holds_slots(tree: bpy.types.NodeTree | None) -> bool:
    """Whether there is a paint in the tree or in a group of it."""
    if tree is None:
        return False
    groups = [node.node_tree for node in tree.nodes if node.type == "GROUP" and node.node_tree]
    return any(_MARK in group or holds_slots(group) for group in groups)


def _irradiances(
    matrices: dict[bpy.types.Object, Matrix], boxes: list[_Box]
) -> dict[bpy.types.Object, float]:
    """The greatest irradiance, W/m², that each light sends to any of the boxes."""
    return {
        light: max(_irradiance(light.data, matrix, box) for box in boxes)
        for light, matrix in matrices.items()
    }


def _irradiance(light: bpy.types.Light, matrix: Matrix, box: _Box) -> float:
    """Without shadows; as if the light's power were normalized, and its colour its strongest."""
    strength = light.energy * max(light.color) * 2**light.exposure
    if light.type == "SUN":
        return strength
    position = matrix.translation
    if isinstance(light, bpy.types.SpotLight) and not _spot_reaches(light, matrix, box):
        return 0.0
    squared_distance = max(
        (box.nearest(position) - position).length_squared,
        light.shadow_soft_size**2,
        _MIN_SQUARED_DISTANCE,
    )
    return strength / (4 * math.pi * squared_distance)


def _spot_reaches(light: bpy.types.SpotLight, matrix: Matrix, box: _Box) -> bool:
    """Whether the spot's cone meets the sphere around the box (cone unscaled)."""
    towards = box.center - matrix.translation
    if towards.length <= box.radius:
        return True
    axis = -matrix.col[2].xyz
    margin = math.asin(box.radius / towards.length)
    return axis.length > 0 and axis.angle(towards) - margin < light.spot_size / 2
