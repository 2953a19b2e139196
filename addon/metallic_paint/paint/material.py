# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group "Metallic Paint" and materials made of it."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any, TypeGuard

import bpy
import numpy as np

from ..scene import carrier, lights
from . import animation, live, preview, shader, solid
from .parameters import (
    BINDER,
    FLAKES,
    INT_MAX,
    INT_MIN,
    LIGHTS,
    PANELS,
    PARAMETERS,
    SECOND,
    SPARKLE,
    SUBSTRATE,
    THIRD,
    Color,
    Flakes,
    Paint,
    PaintError,
    Parameter,
    shader_value,
    value_of,
)

NAME = "Metallic Paint"
VERSION = 8  # of the group's interface: another layout or another range, another version
OUTPUT = "BSDF"
NORMAL, COAT_NORMAL, REST_POSITION = "Normal", "Coat Normal", "Rest Position"
MODEL_SCALE = "Model Scale"
NEW_IN_EVERY_FRAME = "New in Every Frame"
ANCHOR = PARAMETERS["anchor"]

NO_OSL = "This Blender was built without Open Shading Language, which the paint is written in."
_MIXED = "it is of another version than the add-on, which has to be installed anew"
_PREVIEW = "a preview with a hint of sparkles"
NO_CYCLES = "Enable the add-on Cycles Render Engine first"
LINKED = "The {} is linked from another file and cannot be changed"
OVERRIDDEN = (
    "The material is a library override, whose nodes are those of the other file again when this "
    "one is opened: make it local"
)

_GPUS = {"METAL": "Metal", "ONEAPI": "oneAPI"}  # as their makers write them

_MARK = "metallic_paint"  # custom properties of the group: its version, and its shader's digest
_SOURCE_MARK = "metallic_paint_source"
_SOLID = "metallic_paint_solid"  # of a material: the look that it was given for the Solid view

_PANEL_DESCRIPTIONS = {
    FLAKES: "The metal flakes: how many, how large, how they lie, what they reflect",
    SECOND: "Other flakes among the first, as pearls among metal; none while Flakes per mm² 2 is 0",
    THIRD: "Further flakes among both; none while Flakes per mm² 3 is 0",
    BINDER: "The clear or coloured lacquer that holds the flakes, and its surface",
    SUBSTRATE: "What lies under the flakes",
    SPARKLE: "How the sparkles are drawn",
    LIGHTS: "How the lights that sparkle show on this paint",
}


@dataclass(frozen=True)
class _Extra:
    """A socket that belongs to the scene or to tests, not to a paint."""

    label: str
    panel: str
    minimum: int
    maximum: int
    default: int
    description: str


# Sockets without a value of their own: unconnected, the surface's.
GEOMETRY = {"Normal": NORMAL, "CoatNormal": COAT_NORMAL, "RestPosition": REST_POSITION}
_GEOMETRY_DESCRIPTIONS = {
    NORMAL: "Normal of the surface, for bump or normal maps",
    COAT_NORMAL: "Normal of the lacquer's surface, for waves or dents that leave the flakes as "
    "they are",
    REST_POSITION: "For a mesh that deforms: where each point lies before it does, so that the "
    "sparkles move with the mesh. Add Rest Position connects the attribute rest_position here",
}

_EXTRAS = {
    "Frame": _Extra(
        "Frame", SPARKLE, INT_MIN, INT_MAX, 0,
        "Another number draws the flakes of the same paint anew, as another frame does",
    ),
}  # fmt: skip
_CURRENT_FRAME = "CurrentFrame"  # the shader's name of what is added to Frame


def create(paint: Paint, name: str = NAME) -> bpy.types.Material:
    """A new material with the paint's values."""
    group = node_group()
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True  # Blender 4.5
    nodes = material.node_tree.nodes
    nodes.clear()
    node = new_node(material.node_tree, group)
    out = nodes.new("ShaderNodeOutputMaterial")
    out.location.x = 300
    material.node_tree.links.new(node.outputs[OUTPUT], out.inputs["Surface"])
    apply(node, paint)
    return material


def add_node(tree: bpy.types.NodeTree, paint: Paint) -> bpy.types.ShaderNodeGroup:
    """A new node with the paint's values, not yet connected."""
    node = new_node(tree, node_group())
    apply(node, paint)
    return node


def new_node(
    tree: bpy.types.NodeTree, group: bpy.types.ShaderNodeTree
) -> bpy.types.ShaderNodeGroup:
    """A new node of the paint's group with the group's values, not yet connected."""
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    node.name = NAME
    node.width = 240
    return node


def apply(target: bpy.types.Material | bpy.types.ShaderNodeGroup, paint: Paint) -> None:
    """Sets every socket of a paint that exists to the paint's values; live ones stay live.

    A material that is the paint and no more also takes its look, for the Solid view.

    Raises PaintError, with nothing changed, where the node is of another version.
    """
    node = _todays_node(target)
    anew = live.is_live(node) and not live.animated(node)  # which are depends on the paint
    if anew:
        live.end(node)
    for name, parameter in PARAMETERS.items():
        value = shader_value(parameter, value_of(paint, name))
        live.set_value(node.inputs[parameter.label], value)
    if anew:
        live.begin(node, paint)
    for owner in bpy.data.materials:
        if owner.node_tree == node.id_data and is_pure(owner):
            _show_in_solid_view(owner, paint)


def follow_in_solid_view(changed: Collection[int], stepped: Collection[str]) -> None:
    """Materials that are the paint and no more look as their sockets say now: those of these
    session_uids, and those whose live values have these keys.

    One whose owner gave it another look keeps that.
    """
    for owner in bpy.data.materials:
        if _SOLID not in owner or tuple(owner[_SOLID]) != _look_of(owner) or not is_pure(owner):
            continue
        if owner.session_uid in changed or (stepped and live.key_of(paint_node(owner)) in stepped):
            with contextlib.suppress(PaintError):  # of another version, or no paint that can be
                _show_in_solid_view(owner, paint_of(owner))


def _show_in_solid_view(owner: bpy.types.Material, paint: Paint) -> None:
    """Changes nothing where it looks so already: Blender would draw all anew."""
    look = solid.look(paint)
    wanted = (*look.color, look.metallic, look.roughness)
    if not (_SOLID in owner and np.allclose(wanted, _look_of(owner), atol=1e-4)):
        owner.diffuse_color = (*look.color, 1.0)
        owner.metallic, owner.roughness = look.metallic, look.roughness
        owner[_SOLID] = _look_of(owner)


def _look_of(owner: bpy.types.Material) -> tuple[float, ...]:
    return (*owner.diffuse_color[:3], owner.metallic, owner.roughness)


def paint_of(target: bpy.types.Material | bpy.types.ShaderNodeGroup) -> Paint:
    """The paint that the sockets hold, by their live values where they have such; links and drivers
    on them are not part of it.

    Raises PaintError with field, value and range where a socket holds what no paint can have, and
    where the node is of another version.
    """
    node = _todays_node(target)
    fields: dict[str, dict[str, Any]] = {"": {}, "second": {}, "third": {}}
    for name, parameter in PARAMETERS.items():
        species, _, field = name.rpartition(".")
        fields[species][field] = _field(parameter, node.inputs[parameter.label])
    paint = fields.pop("")
    for species, values in fields.items():
        try:
            paint[species] = Flakes(**values)
        except PaintError as error:
            raise PaintError(f"{species}.{error}") from error
    return Paint(**paint)


def _todays_node(
    target: bpy.types.Material | bpy.types.ShaderNodeGroup,
) -> bpy.types.ShaderNodeGroup:
    """The paint node, whose sockets are today's."""
    node = paint_node(target) if isinstance(target, bpy.types.Material) else target
    found = version(node.node_tree)
    if found > VERSION:
        raise PaintError("The paint is of a newer version: update the add-on first.")
    if found < VERSION or any(each.label not in node.inputs for each in PARAMETERS.values()):
        raise PaintError("The paint is of an older version: update it first.")
    return node


def _field(parameter: Parameter, socket: bpy.types.NodeSocket) -> float | int | str | Color:
    """The inverse of shader_value: a socket's value as the paint's field has it."""
    value = live.value(socket)
    if parameter.choices:
        return parameter.choices[min(max(value, 0), len(parameter.choices) - 1)]
    if isinstance(value, int):
        return value
    numbers = tuple(float(str(np.float32(x))) for x in np.ravel(value)[:3])  # 0.1 as it was typed
    return numbers if len(numbers) == 3 else numbers[0]


def paint_paths(tree: bpy.types.NodeTree | None) -> Iterator[list[bpy.types.ShaderNodeGroup]]:
    """Of each paint the node groups that it stands in, outermost first, and its own node.

    Paints of the tree itself come before those within its groups.
    """
    nodes = tree.nodes if tree is not None else ()
    groups: list[Any] = [node for node in nodes if node.type == "GROUP"]
    yield from ([node] for node in groups if is_paint(node))
    for node in groups:
        if not is_paint(node):
            yield from ([node, *path] for path in paint_paths(node.node_tree))


def paint_nodes(tree: bpy.types.NodeTree | None) -> Iterator[bpy.types.ShaderNodeGroup]:
    """In the order of paint_paths."""
    return (path[-1] for path in paint_paths(tree))


def paint_node(material: bpy.types.Material) -> bpy.types.ShaderNodeGroup:
    """The material's first paint node; one at the top level comes before those within groups.

    Raises PaintError where it has none.
    """
    if (node := next(paint_nodes(material.node_tree), None)) is None:
        raise PaintError(
            f"The material {material.name!r} has no {NAME} node: add one (Add > {NAME} in the "
            "shader editor), or take a material that has one."
        )
    return node


def is_paint(node: bpy.types.Node) -> TypeGuard[bpy.types.ShaderNodeGroup]:
    return node.type == "GROUP" and node.node_tree is not None and _MARK in node.node_tree


def has_paint(material: bpy.types.Material) -> bool:
    return next(paint_nodes(material.node_tree), None) is not None


def is_within_group(node: bpy.types.ShaderNodeGroup) -> bool:
    """Whether the paint node stands in a node group of the artist's, not in a material."""
    return not node.id_data.is_embedded_data


def owner(node: bpy.types.ShaderNodeGroup, of: bpy.types.Material) -> bpy.types.ID:
    """What has the paint node of a material among its nodes: a node group, or the material."""
    return node.id_data if is_within_group(node) else of


def keeps_nodes(owner: bpy.types.ID) -> bool:
    """Whether what is done to its nodes stays: not where they are linked, nor in an override."""
    return owner.is_editable and owner.override_library is None


def rides(node: bpy.types.ShaderNodeGroup) -> bool:
    """Whether the sparkles belong to the surface; what a link says is not known, so it may."""
    socket: bpy.types.NodeSocket | None = node.inputs.get(ANCHOR.label)
    if socket is None:  # of an older version
        return False
    return socket.is_linked or socket.default_value != ANCHOR.choices.index("pixel")


def draws_every_frame(tree: bpy.types.NodeTree) -> bool:
    """Whether a paint in the tree is, or by a link or key may be, drawn anew in every frame."""
    for node in filter(is_paint, tree.nodes):
        socket: bpy.types.NodeSocket | None = node.inputs.get(NEW_IN_EVERY_FRAME)
        if socket is not None and (  # None of an older version
            socket.default_value
            or socket.is_linked
            or any(animated == socket for _, animated, _ in animation.of_inputs(tree, node))
        ):
            return True
    return False


def frame_of(node: bpy.types.ShaderNodeGroup, scene: bpy.types.Scene) -> int:
    """The core's frame of what the scene shows now: integers wrap, as the shader's."""
    current = scene.frame_current if node.inputs[NEW_IN_EVERY_FRAME].default_value else 0
    return (node.inputs["Frame"].default_value + current - INT_MIN) % 2**32 + INT_MIN


def linked_from(node: bpy.types.ShaderNodeGroup) -> str:
    """The file whose lights the paint keeps, as Blender writes it; empty where it sees ours."""
    trees = (each.node_tree for each in node.node_tree.nodes if each.type == "GROUP")
    held = [tree for tree in trees if tree is not None and lights.keeps_lights(tree)]
    return next((tree.library.filepath for tree in held if tree.library), "")


def is_pure(material: bpy.types.Material) -> bool:
    """Whether the material is the paint and no more: opaque, undisplaced, without a volume."""
    out = material.node_tree.get_output_node("CYCLES") if material.node_tree else None
    if out is None or out.inputs["Volume"].is_linked or out.inputs["Displacement"].is_linked:
        return False
    sources = [link.from_node for link in out.inputs["Surface"].links]
    return bool(sources) and all(is_paint(node) and not node.mute for node in sources)


def assign(thing: bpy.types.Object, material: bpy.types.Material) -> None:
    """Paints the whole object: the material takes the place of all that it had."""
    materials = getattr(thing.data, "materials", None)
    if materials is None:
        raise PaintError(
            f"The object {thing.name!r} ({thing.type}) cannot hold a material: paint one that has "
            "a surface, such as a mesh."
        )
    materials.clear()
    materials.append(material)


def set_up_cycles(scene: bpy.types.Scene) -> None:
    """Makes the scene render with Cycles on the CPU with OSL. For tools; artists choose."""
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.shading_system = True


def has_osl() -> bool:
    """Whether this Blender was built with Open Shading Language."""
    return getattr(bpy.app.build_options, "cycles_osl", True)


def missing(scene: bpy.types.Scene) -> str:
    """What the scene lacks to show a paint, in a sentence; empty if it renders with OSL."""
    if not has_osl():
        return f"{NO_OSL} It shows {_PREVIEW}."
    if scene.render.engine != "CYCLES":
        return f"The scene does not render with Cycles: the paint shows {_PREVIEW}."
    if not scene.cycles.shading_system:
        return f"Open Shading Language is off in this scene: the paint shows {_PREVIEW}."
    device = gpu(scene)
    if device == "OPTIX":
        return "The scene renders on the GPU by OptiX: the paint is tested on the CPU only."
    if device != "NONE":
        return (
            f"The scene renders on the GPU by {_GPUS.get(device, device)}, which has no Open "
            f"Shading Language, as the CPU and OptiX have: the paint shows {_PREVIEW}."
        )
    return ""


def gpu(scene: bpy.types.Scene) -> str:
    """What the scene renders by, in Blender's word for it: NONE on the CPU."""
    cycles: bpy.types.Addon | None = bpy.context.preferences.addons.get("cycles")
    if cycles is None or scene.cycles.device != "GPU":
        return "NONE"
    return cycles.preferences.compute_device_type


def digest(source: str) -> str:
    """What tells apart the groups of two shaders."""
    return hashlib.sha256(source.encode()).hexdigest()


def is_current(
    group: bpy.types.NodeTree, source_digest: str
) -> TypeGuard[bpy.types.ShaderNodeTree]:
    """Whether the paint's group has today's interface and the shader of that digest."""
    return _marks(group) == (VERSION, source_digest)


def share(arrived: Collection[bpy.types.ShaderNodeTree]) -> None:
    """Where the file had the shader of an arrived paint group, that group takes the place of it.

    Every group holds its shader, compiled: 2 MB.
    """
    for group in [each for each in arrived if version(each) and each.library is None]:
        if twin := _own_group(_marks(group), beside=arrived):
            group.user_remap(twin)
            texts = {node.script for node in group.nodes if node.type == "SCRIPT"}
            bpy.data.batch_remove([group, *filter(None, texts)])


def _marks(group: bpy.types.NodeTree) -> tuple[object, object]:
    """A group that has lost its light slots is no longer of its shader: a new one heals it."""
    has_slots = lights.holds_slots(group)
    return group.get(_MARK), group.get(_SOURCE_MARK) if has_slots else None


def _own_group(
    marks: tuple[object, object], beside: Collection[bpy.types.NodeTree] = ()
) -> bpy.types.ShaderNodeTree | None:
    """The paint group of this file that has the marks."""
    for group in bpy.data.node_groups:
        own = group.library is None and group not in beside
        if own and _marks(group) == marks and isinstance(group, bpy.types.ShaderNodeTree):
            return group
    return None


def mark(group: bpy.types.NodeTree, source: str) -> None:
    """As a paint's group of today's version, with the shader of that source."""
    group[_MARK], group[_SOURCE_MARK] = VERSION, digest(source)


def version(group: bpy.types.NodeTree) -> int:
    """Of a paint's group, at least 1; 0 for other groups."""
    return group.get(_MARK, 0)


def node_group() -> bpy.types.ShaderNodeTree:
    """The file's group with today's shader, made when there is none.

    Groups of other versions stay as they are: a paint keeps its look until its owner updates it.
    """
    text = shader.source()
    if own := _own_group((VERSION, digest(text))):
        return own
    if kept := _from_library(text):
        return kept
    if not has_osl():
        raise shader.CompileError(NO_OSL)
    group = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    try:
        script = _script_node(group, text)
        _build(group, script)
    except Exception:
        bpy.data.node_groups.remove(group)
        raise
    mark(group, text)
    return group


def _from_library(source: str) -> bpy.types.ShaderNodeTree | None:
    """The group, compiled: sooner than it is made, and in a Blender without a compiler too.

    None where the library has another shader or cannot be read.
    """
    kept = shader.LIBRARY.with_suffix(shader.DIGEST)
    opened: Any = bpy.data.libraries.load  # the stubs have it return nothing
    try:
        if kept.read_text(encoding="ascii") != digest(source):
            return None
        with opened(str(shader.LIBRARY), link=False) as (_, into):
            into.node_groups = [NAME]
    except OSError:
        return None
    [group] = into.node_groups
    return group


def _script_node(group: bpy.types.ShaderNodeTree, source: str) -> bpy.types.ShaderNodeScript:
    text = bpy.data.texts.new(shader.FILE)
    text.write(source)
    script = group.nodes.new("ShaderNodeScript")
    script.name = script.label = NAME
    script.width = 240
    try:
        shader.compile_into(script, text)
        _check_parameters(script)
    except Exception:
        bpy.data.texts.remove(text)
        raise
    return script


def _check_parameters(script: bpy.types.ShaderNodeScript) -> None:
    expected = {parameter.shader for parameter in PARAMETERS.values()}
    expected |= {
        *_EXTRAS, _CURRENT_FRAME, *GEOMETRY, lights.METERS_PER_UNIT, lights.OTHER_LIGHT,
    }  # fmt: skip
    for slot in range(1, lights.SLOTS + 1):
        expected.update(lights.slot_names(slot))
    expected |= {preview.RENDERED, OUTPUT}
    found = {socket.identifier for socket in (*script.inputs, *script.outputs)}
    if missing := sorted(expected - found):
        raise shader.CompileError(
            f"{shader.FILE} lacks the parameters {', '.join(missing)}: {_MIXED}."
        )
    if unknown := sorted(found - expected):
        raise shader.CompileError(
            f"{shader.FILE} has unknown parameters {', '.join(unknown)}: {_MIXED}."
        )


def _build(group: bpy.types.ShaderNodeTree, script: bpy.types.ShaderNodeScript) -> None:
    """Gives the group its interface and wires it, in the order of the panels."""
    group.color_tag = "SHADER"
    group.description = "Metallic paint with sparkling flakes"
    group.default_group_node_width = 240
    inside = group.nodes.new("NodeGroupInput")
    inside.location.x = -500
    out = group.nodes.new("NodeGroupOutput")
    out.location.x = 400
    script_inputs = {socket.identifier: socket for socket in script.inputs}

    group.interface.new_socket(OUTPUT, in_out="OUTPUT", socket_type="NodeSocketShader")
    # Closed: Blender's own Surface panel shows them too, with numbers for choices and names cut.
    panels = {
        name: group.interface.new_panel(
            name, description=_PANEL_DESCRIPTIONS[name], default_closed=True
        )
        for name in PANELS
    }
    for name, parameter in PARAMETERS.items():
        _add_parameter(group, name, panels[parameter.panel])
        group.links.new(inside.outputs[parameter.label], script_inputs[parameter.shader])

    def add_extra(name: str) -> None:
        extra = _EXTRAS[name]
        socket = group.interface.new_socket(
            extra.label, in_out="INPUT", socket_type="NodeSocketInt", parent=panels[extra.panel],
            description=extra.description,
        )  # fmt: skip
        socket.min_value, socket.max_value = extra.minimum, extra.maximum
        socket.default_value = extra.default
        group.links.new(inside.outputs[extra.label], script_inputs[name])

    for name in _EXTRAS:
        add_extra(name)
    _add_new_in_every_frame(group, panels[SPARKLE], script_inputs[_CURRENT_FRAME], inside)
    for name, label in GEOMETRY.items():
        _add_geometry(group, label)
        group.links.new(inside.outputs[label], script_inputs[name])
    _add_model_scale(group, panels[SPARKLE])
    _wire_lights(group, script_inputs, inside)
    shown = preview.mix_with(group, inside, script, OUTPUT)
    group.links.new(shown, out.inputs[OUTPUT])


def _add_parameter(
    group: bpy.types.ShaderNodeTree, name: str, panel: bpy.types.NodeTreeInterfacePanel
) -> None:
    parameter = PARAMETERS[name]
    default: float | tuple[float, ...] = shader_value(parameter, value_of(Paint(), name))
    if not isinstance(default, tuple):
        kind = "NodeSocketInt" if isinstance(default, int) else "NodeSocketFloat"
    elif parameter.is_color:
        kind, default = "NodeSocketColor", (*default, 1.0)
    else:
        kind = "NodeSocketVector"
    socket = group.interface.new_socket(
        parameter.label, in_out="INPUT", socket_type=kind, parent=panel,
        description=parameter.description,
    )  # fmt: skip
    if not parameter.is_color:  # a colour socket has no range of its own: Blender's picker has
        socket.subtype = parameter.subtype
        socket.min_value, socket.max_value = parameter.slider
    socket.default_value = default


def _add_new_in_every_frame(
    group: bpy.types.ShaderNodeTree,
    panel: bpy.types.NodeTreeInterfacePanel,
    current_frame: bpy.types.NodeSocket,
    inside: bpy.types.Node,
) -> None:
    """The carrier's frame times 1 or 0: for 0 Blender leaves it out of the shader.

    Fac is the mean of three equal numbers, which is exact for Blender's frames.
    """
    socket = group.interface.new_socket(
        NEW_IN_EVERY_FRAME, in_out="INPUT", socket_type="NodeSocketBool", parent=panel,
        description="Draw the flakes anew in every frame, so that they flicker like film grain. "
        "Blender compiles nothing for it",
    )  # fmt: skip
    socket.default_value = False
    carried = group.nodes.new("ShaderNodeAttribute")
    carried.attribute_type, carried.attribute_name = "INSTANCER", carrier.FRAME_PATH
    product = group.nodes.new("ShaderNodeMath")
    product.operation = "MULTIPLY"
    carried.location, product.location = (-500, 300), (-250, 300)
    group.links.new(carried.outputs["Fac"], product.inputs[0])
    group.links.new(inside.outputs[NEW_IN_EVERY_FRAME], product.inputs[1])
    group.links.new(product.outputs[0], current_frame)


def _add_geometry(group: bpy.types.ShaderNodeTree, label: str) -> None:
    """An unconnected Normal is the shading normal, an unconnected Coat Normal the Normal.

    Cycles gives a script parameter that is initialised with N no value from an unlinked socket,
    neither directly nor through groups, whatever the socket's hidden value is. (Blender 5.2 treats
    a link from a constant likewise: a normal has to vary, as every bump or normal map does.)

    An unconnected Rest Position is (0, 0, 0), which the shader takes for the point itself.
    """
    socket = group.interface.new_socket(
        label, in_out="INPUT", socket_type="NodeSocketVector",
        description=_GEOMETRY_DESCRIPTIONS[label],
    )  # fmt: skip
    socket.hide_value = True


def _add_model_scale(
    group: bpy.types.ShaderNodeTree, panel: bpy.types.NodeTreeInterfacePanel
) -> None:
    socket = group.interface.new_socket(
        MODEL_SCALE, in_out="INPUT", socket_type="NodeSocketFloat", parent=panel,
        description="Metres of the real object per metre of the scene: 1 for a life-size model, "
        "10 for one at a tenth of the size",
    )  # fmt: skip
    socket.min_value, socket.max_value, socket.default_value = 1e-3, 1e3, 1


def _wire_lights(
    group: bpy.types.ShaderNodeTree,
    script_inputs: dict[str, bpy.types.NodeSocket],
    inside: bpy.types.Node,
) -> None:
    """The lights, other light, and the length of a unit: the scene's, so shared by all paints."""
    shared = group.nodes.new("ShaderNodeGroup")
    shared.node_tree = lights.node_group()
    shared.name = shared.label = lights.NAME
    shared.location = -500, -700
    for socket in shared.outputs:
        if socket.name != lights.METERS_PER_UNIT:
            group.links.new(socket, script_inputs[socket.name])
    product = group.nodes.new("ShaderNodeMath")
    product.operation = "MULTIPLY"
    product.location = -250, -700
    group.links.new(shared.outputs[lights.METERS_PER_UNIT], product.inputs[0])
    group.links.new(inside.outputs[MODEL_SCALE], product.inputs[1])
    group.links.new(product.outputs[0], script_inputs[lights.METERS_PER_UNIT])
