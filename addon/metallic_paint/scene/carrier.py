# SPDX-License-Identifier: GPL-3.0-or-later
"""What changes while one works: the lights' directions, places and sizes, the frame, and the values
of paints whose sliders are live (paint/live.py).

Blender writes the values of nodes into the shader and compiles it anew for each change. What an
Attribute node finds at an object it reads in the render. So one datablock of the file holds these
values, every object that shows a paint has a property that points to it, and light slots and paints
read it by that path: a lamp that moves compiles nothing, nor does a frame with grain of its own.

The datablock is a node tree that no shader uses. Blender evaluates it where nothing but such a
property leads to it, it can have drivers, and no material or mesh has to be prepared anew for it.
Copies of an object point to it too, and what is appended brings its own along (`only`). An object
that has none shows the lights where they stood when their number or kind changed last.

An object that is linked from another file cannot be given one: it points to the carrier of its own
file. For these the file's scenes point to the carrier too, where an Attribute node of type View
Layer finds the same values by the same path, at the price of a compilation for each change.

Drivers feed it with simple expressions, which Blender evaluates without running Python, so that a
render machine needs neither this add-on nor permission to run scripts. Direction and position come
from the light's matrix, as Cycles takes them: the normalised third column towards a sun, the fourth
column for a position. Rotation channels (ROT_W ... ROT_Z) would point elsewhere than Cycles under a
parent that is mirrored or scaled along one axis. The radius of a point or spot light is that of its
data: Cycles does not scale it with the object, but it does the sides of an area light, which lie
along the first two columns.

The matrix of a light that a collection instance shows is the product of two. Drivers write its rows
into the datablock, and those of the light read them there.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import product

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ..paint.table import AREA, PARALLEL, POSITIONAL, SKY
from .placed import Placed

NAME = ".Metallic Paint Lights"  # menus leave out what begins with a dot
_MARK = "metallic_paint_carrier"
_POINTER = "metallic_paint_lights"  # an object's property, and a scene's

SLOTS = 8
KINDS = {"SUN": PARALLEL, "POINT": POSITIONAL, "SPOT": POSITIONAL, "AREA": AREA}
_NAMES = {PARALLEL: "Direction", POSITIONAL: "Position", AREA: "Area", SKY: "Sky"}

# An attribute that is missing is (0, 0, 0, 0): so a slot's fourth number, its size, is never 0.
_LEAST_SIZE = 1e-30
_UNIT = "/max(sqrt(x*x+y*y+z*z),1e-30)"
# What a slot has of the light's matrix and size: x, y, z and size.
_EXPRESSIONS = {
    PARALLEL: (*(f"{c}{_UNIT}" for c in "xyz"), f"max(sin(size/2),{_LEAST_SIZE})"),
    POSITIONAL: ("x", "y", "z", f"max(size,{_LEAST_SIZE})"),
}
# Of an area light too, whose sides are u and v: the radius of the disc of its area, and half of the
# diagonal or of the longer axis. a, b, c and d, e, f are the columns along which u and v lie.
_U, _V = "sqrt(a*a+b*b+c*c)*u", "sqrt(d*d+e*e+f*f)*v"
_ROUND = f"max(sqrt({_U}*{_V})/2,{_LEAST_SIZE})", f"max({_U},{_V})/2"
_RECTANGULAR = (
    f"max(sqrt({_U}*{_V}/pi),{_LEAST_SIZE})",
    "sqrt((a*a+b*b+c*c)*u*u+(d*d+e*e+f*f)*v*v)/2",
)

_FRAME, _FILE, _GROUP = "Frame", "File", "Group"
_LIVE = "Live"  # the first word of the names of live values
FRAME_PATH = f'["{_POINTER}"]["{_FRAME}"]'  # where such an object has the scene's frame
FILE_PATH = f'["{_POINTER}"]["{_FILE}"]'  # where a scene has what constants of linked paints are


def path(slot: int, kind: int) -> str:
    """Where an object that shows a paint has the four numbers of a slot, 1..8.

    The name tells the kind: a paint that keeps the lights of another file does not take a place of
    this one for the direction that it expects there.
    """
    return f'["{_POINTER}"]["{_name(slot, kind)}"]'


def scene_path(slot: int) -> str:
    """Where a scene has them, of whatever kind."""
    return f'["{_POINTER}"]["{_name(slot)}"]'


def facing_path(slot: int) -> str:
    """Where it has the normal of an area light, as long as the light's farthest point is off, and
    in the fourth place the slot's kind.
    """
    return f'["{_POINTER}"]["{_facing_name(slot)}"]'


def live_name(key: str, label: str) -> str:
    """Of a live value: the paint that has it, and the socket's label."""
    return f"{_LIVE} {key} {label}"


def live_path(name: str) -> str:
    """Where an object that shows a paint has a live value."""
    return f'["{_POINTER}"]["{name}"]'


def live_values() -> dict[str, list[object]]:
    """Of the file, by the paints that have them."""
    found: dict[str, list[object]] = {}
    for tree in all_of_file()[:1]:
        for name in filter(_is_live, tree.keys()):
            value = tree[name]
            plain = value if isinstance(value, float) else tuple(value)
            found.setdefault(name.split()[1], []).append(plain)
    return found


def keep_live(keys: Collection[str]) -> None:
    """Of the live values only those of these paints."""
    for tree in all_of_file():
        for name in filter(_is_live, [*tree.keys()]):
            if name.split()[1] not in keys:
                del tree[name]


def _is_live(name: str) -> bool:
    return name.startswith(f"{_LIVE} ")


def _name(slot: int, kind: int | None = None) -> str:
    return f"Light{slot}{_NAMES[kind] if kind else ''}"


def _names(slot: int, kind: int) -> list[str]:
    """For objects, and for scenes where they carry it."""
    for_scenes = any(scene.get(_POINTER) for scene in _own_scenes())
    return [_name(slot, kind), _name(slot)] if for_scenes else [_name(slot, kind)]


def _facing_name(slot: int) -> str:
    return f"Light{slot}Facing"


def _matrix_name(slot: int) -> str:
    """Of an instance's matrix: three rows of four."""
    return f"Light{slot}Matrix"


def _instance_name(slot: int) -> str:
    """Of what is told of an instance that no driver follows."""
    return f"Light{slot}Instance"


def all_of_file() -> list[bpy.types.NodeTree]:
    """The file's own: none before the first fit, several after an append.

    Whoever overrides an asset with a lamp of its own overrides its file's too: Blender keeps
    nothing that is written there.
    """
    return [
        tree
        for tree in bpy.data.node_groups
        if _MARK in tree and tree.library is None and tree.override_library is None
    ]


def is_one(thing: bpy.types.ID) -> bool:
    return isinstance(thing, bpy.types.NodeTree) and _MARK in thing


def only() -> bpy.types.NodeTree:
    """The file's one, made when there is none; those that came with an append become it."""
    first, *others = all_of_file() or [_new()]
    for other in others:
        other.user_remap(first)
        bpy.data.node_groups.remove(other)
    return first


def _new() -> bpy.types.NodeTree:
    tree = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    tree[_MARK] = 1
    tree.description = "Where the metallic paints of this file have their lights and live values"
    return tree


# --- who carries it ----------------------------------------------------------------------------


def attach(things: Collection[bpy.types.Object]) -> bool:
    """Lets the objects carry it; returns whether that was new to any."""
    tree = only()
    new = [thing for thing in things if thing.get(_POINTER) != tree]
    for thing in new:
        thing[_POINTER] = tree
        if thing.override_library is None:  # so that an override's is stored where it is linked to
            thing.property_overridable_library_set(f'["{_POINTER}"]', True)
        thing.update_tag()
    return bool(new)


def is_carried_by(thing: bpy.types.Object) -> bool:
    return _POINTER in thing


def is_attached(things: Collection[bpy.types.Object]) -> bool:
    trees = all_of_file()
    return len(trees) == 1 and all(thing.get(_POINTER) == trees[0] for thing in things)


def attach_to_scenes(needed: bool) -> bool:
    """Lets all scenes of the file carry it, or none; returns whether that was new to any."""
    tree = only() if needed else None
    new = [scene for scene in _own_scenes() if scene.get(_POINTER) != tree]
    for scene in new:
        if needed:
            scene[_POINTER] = tree
        else:
            del scene[_POINTER]
        scene.update_tag()
    return bool(new)


def is_attached_to_scenes(needed: bool) -> bool:
    tree = next(iter(all_of_file()), None) if needed else None
    return all(scene.get(_POINTER) == tree for scene in _own_scenes())


def _own_scenes() -> list[bpy.types.Scene]:
    return [scene for scene in bpy.data.scenes if scene.library is None]


# --- its values --------------------------------------------------------------------------------


def numbers_of(light: Placed) -> tuple[float, float, float, float]:
    """What a slot holds of a light that stands so: x, y, z and size."""
    lamp, matrix = light.lamp.data, light.matrix
    if isinstance(lamp, bpy.types.SunLight):
        return (*matrix.col[2].xyz.normalized(), max(math.sin(lamp.angle / 2), _LEAST_SIZE))
    if isinstance(lamp, bpy.types.AreaLight):
        u, v = _sides(lamp, matrix)
        size = math.sqrt(u * v) / 2 if _is_round(lamp) else math.sqrt(u * v / math.pi)
    else:
        size = lamp.shadow_soft_size
    return (*matrix.translation, max(size, _LEAST_SIZE))


def facing_of(light: Placed) -> tuple[float, float, float]:
    """What a slot holds besides of an area light; zeros for any other."""
    lamp, matrix = light.lamp.data, light.matrix
    if not isinstance(lamp, bpy.types.AreaLight):
        return (0.0, 0.0, 0.0)
    u, v = _sides(lamp, matrix)
    reach = max(u, v) / 2 if _is_round(lamp) else math.hypot(u, v) / 2
    x, y, z = -matrix.col[2].xyz.normalized() * reach
    return x, y, z


def _sides(lamp: bpy.types.AreaLight, matrix: Matrix) -> tuple[float, float]:
    scale_u, scale_v = (matrix.col[i].xyz.length for i in range(2))
    return lamp.size * scale_u, getattr(lamp, _second_side(lamp)) * scale_v


def _second_side(lamp: bpy.types.AreaLight) -> str:
    return "size_y" if lamp.shape in ("RECTANGLE", "ELLIPSE") else "size"


def _is_round(lamp: bpy.types.AreaLight) -> bool:
    return lamp.shape in ("DISK", "ELLIPSE")


def values() -> list[tuple[int, Vector, float, Vector]]:
    """Kind, vector, size and facing of the slots in use, as they stand, in single precision."""
    found = []
    for tree in all_of_file()[:1]:
        for slot in range(1, SLOTS + 1):
            if (what := tree.get(_facing_name(slot))) is not None:
                *facing, kind = np.array(what, np.float32).tolist()
                if (where := tree.get(_name(slot, round(kind)))) is not None:
                    *vector, size = np.array(where, np.float32).tolist()
                    found.append((round(kind), Vector(vector), size, Vector(facing)))
    return found


def is_full() -> bool:
    """Whether all slots are in use, so that further lights may have none."""
    return any(_facing_name(SLOTS) in tree for tree in all_of_file())


def feed(lights: Sequence[Placed]) -> None:
    """The values of these lights, slot 1 first, and drivers that keep them so."""
    tree = only()
    for data_path, index in _driven(tree):
        tree.driver_remove(data_path, index)
    for name in {*tree.keys()} - {_MARK, _FRAME, _FILE, _GROUP}:
        if not _is_live(name):
            del tree[name]
    set_values(lights)
    for slot, light in enumerate(lights, 1):
        if not light.followed:
            tree[_instance_name(slot)] = {
                "lamp": light.lamp, "instancer": light.instancer, "number": [*light.number]
            }  # fmt: skip
    for (data_path, index), (expression, variables) in _channels(tree, lights).items():
        _drive(tree, data_path, index, expression, variables)


_Channels = dict[tuple[str, int], tuple[str, dict[str, tuple[bpy.types.ID, str]]]]


def _channels(tree: bpy.types.NodeTree, lights: Sequence[Placed]) -> _Channels:
    """The expression of each number, and of which variables."""
    found: _Channels = {}
    for slot, light in enumerate(lights, 1):
        lamp = light.lamp
        kind = KINDS[lamp.data.type]
        if not light.followed:
            continue
        if light.instancer is not None:
            found |= _product(slot, light.instancer, lamp)

        def column(
            i: int, names: str, slot: int = slot, light: Placed = light
        ) -> dict[str, tuple[bpy.types.ID, str]]:
            if light.instancer is None:
                return dict(_column(light.lamp, i, names))
            return {
                name: (tree, f'["{_matrix_name(slot)}"][{4 * row + i}]')
                for row, name in enumerate(names)
            }

        if isinstance(lamp.data, bpy.types.AreaLight):
            size, reach = _ROUND if _is_round(lamp.data) else _RECTANGULAR
            sides = {
                **column(0, "abc"), **column(1, "def"),
                "u": (lamp.data, "size"), "v": (lamp.data, _second_side(lamp.data)),
            }  # fmt: skip
            numbers = [(c, column(3, "xyz")) for c in "xyz"] + [(size, sides)]
            facing_path = f'["{_facing_name(slot)}"]'
            for i, c in enumerate("xyz"):
                found[facing_path, i] = (f"-{c}{_UNIT}*{reach}", {**column(2, "xyz"), **sides})
        else:
            *place, size = _EXPRESSIONS[kind]
            where = column(2 if kind == PARALLEL else 3, "xyz")
            source = "angle" if kind == PARALLEL else "shadow_soft_size"
            numbers = [(each, where) for each in place] + [(size, {"size": (lamp.data, source)})]
        for name in _names(slot, kind):
            for i, number in enumerate(numbers):
                found[f'["{name}"]', i] = number
    return found


def _product(slot: int, instancer: bpy.types.Object, lamp: bpy.types.Object) -> _Channels:
    """Of the matrix of a light that a collection instance shows, and that collection's offset."""
    offset = {
        name: (instancer.instance_collection, f"instance_offset[{i}]")
        for i, name in enumerate("uvw")
    }
    found: _Channels = {}
    for row, i in product(range(3), range(4)):
        outer = {c: (instancer, f"matrix_world[{k}][{row}]") for k, c in enumerate("abcd")}
        inner = dict(_column(lamp, i, "xyz"))
        if i < 3:
            del outer["d"]
            number = "a*x+b*y+c*z", {**outer, **inner}
        else:
            number = "a*(x-u)+b*(y-v)+c*(z-w)+d", {**outer, **inner, **offset}
        found[f'["{_matrix_name(slot)}"]', 4 * row + i] = number
    return found


def _column(
    light: bpy.types.Object, column: int, names: str
) -> Iterator[tuple[str, tuple[bpy.types.ID, str]]]:
    for i, name in enumerate(names):
        yield name, (light, f"matrix_world[{column}][{i}]")


def set_values(lights: Sequence[Placed]) -> None:
    """At once, also where Blender does not evaluate the drivers because no object leads there."""
    tree = only()
    for slot, light in enumerate(lights, 1):
        kind = KINDS[light.lamp.data.type]
        if light.followed and light.instancer is not None:
            tree[_matrix_name(slot)] = [x for row in light.matrix[:3] for x in row]
        for name in _names(slot, kind):
            tree[name] = numbers_of(light)
        tree[_facing_name(slot)] = (*facing_of(light), float(kind))
    tree.update_tag()


def not_followed() -> dict[int, tuple[bpy.types.Object | None, bpy.types.Object | None, tuple]]:
    """The slots of instances that no driver follows: the light, its instancer, and which it is."""
    return {
        slot: (who["lamp"], who["instancer"], tuple(who["number"]))
        for tree in all_of_file()[:1]
        for slot in range(1, SLOTS + 1)
        if (who := tree.get(_instance_name(slot))) is not None
    }


def renew(slot: int, light: Placed) -> None:
    """Where such a light is now; nothing is touched where it has not moved.

    Numbers change where they stand: Blender may call from the thread that renders.
    """
    [tree, *_] = all_of_file()
    kind = KINDS[light.lamp.data.type]
    new = {_facing_name(slot): (*facing_of(light), float(kind))}
    new |= dict.fromkeys(_names(slot, kind), numbers_of(light))
    for name, numbers in new.items():
        if name not in tree:
            continue  # the lamp has become another kind: the next fit tells
        for i, number in enumerate(numbers):
            if tree[name][i] != number:
                tree[name][i] = number
                tree.update_tag()


def set_sky(slot: int, numbers: tuple[float, float, float, float] | None) -> None:
    """Where the sun of the world stands, which no driver follows; None: it has none."""
    tree = only()
    for other in range(slot, SLOTS + 1):
        for name in {_name(other), _name(other, SKY), _facing_name(other)} & {*tree.keys()}:
            del tree[name]
    if numbers is not None:
        tree[_facing_name(slot)] = (0.0, 0.0, 0.0, float(SKY))
        for name in _names(slot, SKY):
            tree[name] = numbers
    tree.update_tag()


def tell_scenes(numbers: tuple[float, float, float] | None, group: bpy.types.NodeTree) -> None:
    """What linked paints read of the file itself, and the group that is kept with it; None: no
    paint is linked.
    """
    tree = only()
    if numbers is not None:
        tree[_FILE], tree[_GROUP] = numbers, group
    else:
        for name in {*tree.keys()} & {_FILE, _GROUP}:
            del tree[name]
    tree.update_tag()


def follow_frame(needed: bool) -> None:
    """Whether there is the frame; if so, Blender evaluates all that carry it in every frame.

    Motion blur may put a render between two frames, which then belongs to the first.
    """
    tree = only()
    if needed == _follows_frame(tree):
        return
    if needed:
        tree[_FRAME] = 0.0
        _drive(tree, f'["{_FRAME}"]', -1, "floor(frame)", {})
    else:
        tree.driver_remove(f'["{_FRAME}"]')
        del tree[_FRAME]


def _follows_frame(tree: bpy.types.NodeTree) -> bool:
    return any(not curve.driver.variables for curve in _curves(tree))


def let_go() -> None:
    """The values stay, and follow nothing any more; live values go on as they are animated."""
    for tree in all_of_file():
        forget_lights(tree)
        for slot in range(1, SLOTS + 1):
            tree.pop(_instance_name(slot), None)


def forget_lights(tree: bpy.types.NodeTree) -> None:
    """No driver leads to a light or the frame any more."""
    for curve in _curves(tree):
        tree.driver_remove(curve.data_path, curve.array_index)
    if tree.animation_data and not (tree.animation_data.drivers or tree.animation_data.action):
        tree.animation_data_clear()


def is_fed_by(lights: Sequence[Placed]) -> bool:
    """Whether drivers lead to just these lights, as what they now are."""
    trees = all_of_file()
    if len(trees) != 1 or not_followed() != {
        slot: (light.lamp, light.instancer, light.number)
        for slot, light in enumerate(lights, 1)
        if not light.followed
    }:
        return False
    expected = {
        at: (expression, [*variables.values()])
        for at, (expression, variables) in _channels(trees[0], lights).items()
    }
    return expected == {
        (curve.data_path, curve.array_index): (
            curve.driver.expression,
            [(each.targets[0].id, each.targets[0].data_path) for each in curve.driver.variables],
        )
        for curve in _curves(trees[0])
        if curve.driver.variables
    }


def sources_of(tree: bpy.types.NodeTree) -> list[bpy.types.Object]:
    """The lights that it looks at, and the instancers of such lights."""
    found = [source for sources in _driven(tree).values() for source in sources]
    for slot in range(1, SLOTS + 1):
        if (who := tree.get(_instance_name(slot))) is not None:
            found += [who["lamp"], who["instancer"]]
    return list(dict.fromkeys(each for each in found if isinstance(each, bpy.types.Object)))


def has_lost_lamp() -> bool:
    """Whether the light of a slot is gone."""
    driven = [sources for tree in all_of_file() for sources in _driven(tree).values()]
    return any(None in sources for sources in (*driven, *not_followed().values()))


def _driven(tree: bpy.types.NodeTree) -> dict[tuple[str, int], list[bpy.types.ID | None]]:
    """What each driver of a slot looks at, None for what is gone."""
    return {
        (curve.data_path, curve.array_index): [
            variable.targets[0].id for variable in curve.driver.variables
        ]
        for curve in _curves(tree)
        if curve.driver.variables  # the frame's has none
    }


def _curves(tree: bpy.types.NodeTree) -> list[bpy.types.FCurve]:
    """The drivers, without those that artists gave live values."""
    drivers = tree.animation_data.drivers if tree.animation_data else ()
    return [curve for curve in drivers if not _is_live(curve.data_path.removeprefix('["'))]


def _drive(
    tree: bpy.types.NodeTree,
    data_path: str,
    index: int,
    expression: str,
    variables: Mapping[str, tuple[bpy.types.ID, str]],
) -> None:
    curve: bpy.types.FCurve = tree.driver_add(data_path, index)  # type: ignore[assignment]
    curve.keyframe_points.clear()  # Blender 5 rounds to the nearer of its keys (0, 0) and (1, 1)
    driver = curve.driver
    driver.type = "SCRIPTED"
    for name, (datablock, of) in variables.items():
        variable = driver.variables.new()
        variable.name = name
        variable.type = "SINGLE_PROP"
        target = variable.targets[0]
        target.id_type = datablock.id_type
        target.id = datablock
        target.data_path = of
    driver.expression = expression
