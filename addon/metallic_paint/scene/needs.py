# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits the paints to the scene: fills the light slots, and leaves out what nothing lights.

The flakes sparkle under the lights in the slots. Under all other light (the world, lights without
a slot, neighbours) they show their mean, for which every sample draws mirrored directions. That is
left out where there surely is no other light. Whatever is not known counts as light.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass

import bpy
import numpy as np

from ..paint import live, material
from . import carrier, lights, placed, sky, sun_lamp

# Rendered objects that neither reflect nor emit, unless they are instancers.
_NO_SHAPES = {"ARMATURE", "CAMERA", "EMPTY", "LATTICE", "LIGHT", "LIGHT_PROBE", "SPEAKER"}
# Nodes with a shader output that do not emit. Groups and scripts are not among them.
_DARK_NODES = {
    "ADD_SHADER", "BSDF_DIFFUSE", "BSDF_GLASS", "BSDF_GLOSSY", "BSDF_HAIR", "BSDF_HAIR_PRINCIPLED",
    "BSDF_METALLIC", "BSDF_RAY_PORTAL", "BSDF_REFRACTION", "BSDF_SHEEN", "BSDF_TOON",
    "BSDF_TRANSLUCENT", "BSDF_TRANSPARENT", "HOLDOUT", "MIX_SHADER", "SUBSURFACE_SCATTERING",
}  # fmt: skip

# Custom properties of the group of light slots, which undo, files and copies keep with the slots.
_FITTED_TO, _SAID = "metallic_paint_fitted_to", "metallic_paint_said"
_SCENE = "metallic_paint_scene"

_WIDE = "area lights where they look wide"
_SET = "the background set"

_state = {"fitting": False}


@dataclass(frozen=True)
class Needs:
    """What the paints of a scene compute, and what they leave out."""

    lights: lights.Report
    other_light: tuple[str, ...]  # what lights the flakes beside the slots, in words; () for none
    own: bool = True  # False: the file has no paint of its own, so nothing was fitted
    library: str = ""  # why the file is a library, in words; empty where it is none

    def __str__(self) -> str:
        if not self.own:
            return "\n".join(
                ["This file has no metallic paint of its own.", *str(self.lights).splitlines()]
            )
        slots, without = len(self.lights.placed), len(self.lights.without)
        slots += bool(self.lights.sky)
        lines = str(self.lights).splitlines()
        if not slots:
            why = "none of these lights has a slot" if without else "no light renders"
            lines.append(f"No sparkles are computed: {why}.")
        elif without:
            verb = "lights" if without == 1 else "light"
            lines.append(f"{slots + without} lights: {slots} sparkle, {without} {verb} the mean.")
        if self.other_light:
            *most, last = self.other_light
            shown = f"{', '.join(most)} and {last}" if most else last
            lines.append(f"The flakes also show {shown}.")
        else:
            lines.append(
                "The flakes show no world or other lights: the scene has none; and no neighbours: "
                "its light does not bounce (Light Paths, Total or Glossy is 0)."
            )
        if self.library:
            lines.append(
                f"A library, as {self.library}: files that link its paints show them in their own "
                "light, and each move of a light prepares the paints anew."
            )
        return "\n".join(lines)


def fit(scene: bpy.types.Scene) -> Needs:
    """Fills the light slots and leaves out what the scene does not require.

    Call it again when lights, objects, or materials that emit come, go or change type, when the
    size of a lamp, the world or the number of bounces changes, and when a paint is drawn anew in
    every frame or no more.
    """
    if not lights.has_any():
        return Needs(lights.Report((), {}, lights.linked_files()), (), own=False)
    _state["fitting"] = True  # the scene is updated, which calls handlers
    try:
        live.keep_apart()
        report = lights.fill(scene)
        things = _things(placed.used_layers(scene))
        other_light = tuple(_other_light(scene, report, things))
        needs = Needs(report, other_light, library=lights.why_library())
        of_lamps = bool(report.without) or not {_WIDE, _SET}.isdisjoint(other_light)
        of_lamps = of_lamps or _any_emits(things)
        uneven = of_lamps or any(map(_world_may_be_uneven, sky.worlds(scene)))
        lights.show_other_light(bool(needs.other_light), uneven)
        carrier.follow_frame(_draws_every_frame())
        group = lights.node_group()
        group[_FITTED_TO], group[_SAID] = _fingerprint(scene), str(needs)
        group[_SCENE] = scene.name_full
    finally:
        _state["fitting"] = False
    return needs


def is_fitting() -> bool:
    """Whether fit is at work, for handlers that it calls."""
    return _state["fitting"]


def scene_to_fit(scene: bpy.types.Scene) -> bpy.types.Scene:
    """This one, unless only others use paint: of these the one fitted last, or the first."""
    painted = {each.name_full: each for each in lights.painted_scenes()}
    if scene.name_full in painted:
        return scene
    last = next((group.get(_SCENE) for group in lights.groups()), "")
    return painted.get(last) or next(iter(painted.values()), scene)


def is_fitted(scene: bpy.types.Scene) -> bool:
    """Whether fit has nothing new to find, or the file has no paint of its own."""
    groups = lights.groups()
    if len(groups) != 1:
        return not lights.has_any()
    shared = bool(lights.linked_groups())
    if not lights.is_current(groups[0]) or not carrier.is_attached_to_scenes(shared):
        return False
    if (
        not live.are_apart()
        or carrier.has_lost_lamp()
        or not carrier.is_attached(lights.showing_paint())
        or lights.kinds_of(groups[0]) != [kind for kind, *_ in carrier.values()]
    ):
        return False
    return groups[0].get(_FITTED_TO) == _fingerprint(scene)


def let_go() -> None:
    """The slots keep their values and point at no lamp any more, until the next fit."""
    carrier.let_go()
    for group in lights.groups():
        group.pop(_FITTED_TO, None)


def said() -> str:
    """What the last fit reported, in lines; empty before the first."""
    return next((group.get(_SAID, "") for group in lights.groups()), "")


def _fingerprint(scene: bpy.types.Scene) -> str:
    """Of what fit looks at, by names, which outlive the session.

    Places of lamps and paints count only where fit asks for them.
    """
    layers = placed.used_layers(scene)
    things = _things(layers)
    lamps, shapes = _lamps(things), _shapes(things)
    worlds = sky.worlds(scene)
    overrides = [(layer.name, layer.material_override) for layer in layers]
    seen: list[object] = [
        scene.name_full, scene.unit_settings.scale_length, _bounces(scene), overrides,
        *(any(map(each, worlds)) for each in (_world_may_shine, _world_may_be_uneven)),
        _draws_every_frame(), lights.rays_meet_all(), scene.background_set,
    ]  # fmt: skip
    seen += [
        (lamp.name_full, lamp.data.name_full, lamp.data.type, getattr(lamp.data, "shape", ""))
        for lamp in lamps
    ]
    seen += [lights.why_not(lamp) for lamp in lamps]
    seen.append(sky.find(scene))
    seen += [
        (
            shape.name_full, shape.type, shape.hide_render, _instanced_lamps(shape),
            [modifier.type for modifier in shape.modifiers],
            [slot.material and slot.material.name_full for slot in shape.material_slots],
        )
        for shape in shapes
    ]  # fmt: skip
    materials = dict.fromkeys(each for shape in shapes for each in _materials(shape))
    seen += [
        (_material_may_emit(each), _has_volume(each), lights.holds_slots(each.node_tree))
        for each in materials
    ]
    instances = placed.instances_in(layers)
    seen += [
        (each.name, each.number, each.followed, lights.why_not(each.lamp)) for each in instances
    ]
    if len(lamps) + len(instances) > lights.SLOTS:  # the brightest have the slots
        painted = lights.showing_paint(editable=False)
        seen += [each.matrix_world for each in (*lamps, *(s for s in shapes if s in painted))]
        seen += [each.matrix for each in instances]
        seen += [_brightness(lamp) for lamp in (*lamps, *(each.lamp for each in instances))]
    return hashlib.sha256(repr(seen).encode()).hexdigest()


def _instanced_lamps(thing: bpy.types.Object) -> list[str] | str:
    """The lights that an instance of a collection multiplies; otherwise what kind of instancer."""
    if thing.instance_collection is None:
        return thing.instance_type
    return [
        each.name_full for each in thing.instance_collection.all_objects if each.type == "LIGHT"
    ]


def _brightness(lamp: bpy.types.Object) -> tuple[object, ...]:
    data = lamp.data
    size = getattr(data, "shadow_soft_size", 0), getattr(data, "spot_size", 0)
    return lamp.hide_render, data.energy, *data.color, data.exposure, *size


def _things(layers: list[bpy.types.ViewLayer]) -> list[bpy.types.Object]:
    things = (thing for layer in layers for thing in placed.rendered(layer, ever=True))
    return list(dict.fromkeys(things))


def _lamps(things: list[bpy.types.Object]) -> list[bpy.types.Object]:
    return [each for each in things if each.type == "LIGHT" and not sun_lamp.is_one(each)]


def _shapes(things: list[bpy.types.Object]) -> list[bpy.types.Object]:
    return [thing for thing in things if thing.type not in _NO_SHAPES or _is_instancer(thing)]


def _bounces(scene: bpy.types.Scene) -> int:
    return min(scene.cycles.max_bounces, scene.cycles.glossy_bounces)


def _other_light(
    scene: bpy.types.Scene, report: lights.Report, things: list[bpy.types.Object]
) -> Iterator[str]:
    shapes = _shapes(things)
    if lights.showing_paint(editable=False).isdisjoint(shapes):
        yield "whatever there is: no object is painted yet"
    if any(map(_world_may_shine, sky.worlds(scene))):
        yield "the world"
    lamps = _lamps(things)
    if report.without or any(lamp not in report.slots for lamp in lamps):
        yield "lights without a slot"
    if any(lamp.data.type == "AREA" for lamp in report.slots):
        yield _WIDE
    if scene.background_set:
        yield _SET
    if any(map(_may_emit, shapes)):
        yield "objects that may emit"
    if any(map(_may_hold_a_volume, shapes)):
        yield "volumes"
    if _bounces(scene) > 0 and shapes:
        yield "the paint itself" if len(shapes) == 1 else "their neighbours"


def _any_emits(things: list[bpy.types.Object]) -> bool:
    """Objects of their own; what instancers show is not known."""
    return any(_may_emit(each) for each in _shapes(things) if not _makes_more(each))


def _draws_every_frame() -> bool:
    """Whether any paint of the file asks for the frame."""
    trees = [each.node_tree for each in bpy.data.materials if each.node_tree]
    return any(map(material.draws_every_frame, (*trees, *bpy.data.node_groups)))


# --- the world -------------------------------------------------------------------------------


def world_is_animated(world: bpy.types.World | None) -> bool:
    tree = world.node_tree if world else None
    return any(each is not None and each.animation_data is not None for each in (world, tree))


def _world_may_shine(world: bpy.types.World | None) -> bool:
    if world is None:
        return False
    if world_is_animated(world):
        return True
    tree = world.node_tree
    # Blender 5 always uses the nodes, and warns those who ask.
    if tree is None or (bpy.app.version < (5, 0) and not world.use_nodes):
        return any(world.color)
    out = tree.get_output_node("CYCLES")
    if out is None:
        return False
    if out.inputs["Volume"].is_linked:
        return True
    links = out.inputs["Surface"].links
    return any(may_shine(link.from_node, "Color", "Strength") for link in links)


def _world_may_be_uneven(world: bpy.types.World | None) -> bool:
    """Whether it shines more from one side than from another, as a room or a sky does."""
    tree = world.node_tree if world else None
    if tree is None or not _world_may_shine(world):
        return False
    out = tree.get_output_node("CYCLES")
    links = out.inputs["Surface"].links if out else ()
    return any(
        link.from_node.type != "BACKGROUND"
        or any(socket.is_linked for socket in link.from_node.inputs)
        for link in links
    )


def may_shine(node: bpy.types.Node, color: str, strength: str) -> bool:
    """Of an emission, background or principled node: unless colour or strength are surely zero."""
    if node.type not in ("BACKGROUND", "EMISSION", "BSDF_PRINCIPLED") or node.mute:
        return True
    sockets = node.inputs[color], node.inputs[strength]
    return not any(
        not socket.is_linked and not np.any(np.ravel(socket.default_value)[:3])
        for socket in sockets
    )


# --- objects ---------------------------------------------------------------------------------


def _is_instancer(thing: bpy.types.Object) -> bool:
    return thing.instance_type != "NONE"


def _materials(thing: bpy.types.Object) -> list[bpy.types.Material]:
    return [slot.material for slot in thing.material_slots if slot.material]


def _makes_more(thing: bpy.types.Object) -> bool:
    """Whether it brings along objects or materials that it does not show here."""
    return _is_instancer(thing) or any(
        modifier.type in ("NODES", "PARTICLE_SYSTEM") for modifier in thing.modifiers
    )


def _may_emit(thing: bpy.types.Object) -> bool:
    return _makes_more(thing) or any(map(_material_may_emit, _materials(thing)))


def _material_may_emit(painted: bpy.types.Material) -> bool:
    tree = painted.node_tree
    if tree is None or material.is_pure(painted):
        return False
    if painted.animation_data or tree.animation_data:
        return True
    return any(map(_node_may_emit, tree.nodes))


def _node_may_emit(node: bpy.types.Node) -> bool:
    if not any(socket.type == "SHADER" for socket in node.outputs) or node.type in _DARK_NODES:
        return False
    if node.type == "GROUP" and material.is_paint(node):
        return False
    if node.type == "BSDF_PRINCIPLED":
        return may_shine(node, "Emission Color", "Emission Strength")
    return may_shine(node, "Color", "Strength") if node.type == "EMISSION" else True


def _may_hold_a_volume(thing: bpy.types.Object) -> bool:
    if thing.type == "VOLUME" or _makes_more(thing):
        return True
    return any(map(_has_volume, _materials(thing)))


def _has_volume(surface: bpy.types.Material) -> bool:
    nodes = surface.node_tree.nodes if surface.node_tree else ()
    outputs = [node for node in nodes if node.type == "OUTPUT_MATERIAL"]
    return any(node.inputs["Volume"].is_linked for node in outputs)
