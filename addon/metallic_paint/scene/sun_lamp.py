# SPDX-License-Identifier: GPL-3.0-or-later
"""The sun of an environment image as a lamp of its own, which can be in a light group of its own.

Cycles has one light group for all light of a world. So a lamp shows the same image within the cone
about the sun that sparkles, and there the world is dark but for the camera. In a scene that has the
lamp a surface gets the same light from the same directions, and the slot stays that of the world's
sun.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import bpy
from mathutils import Vector

from ..paint import animation
from . import carrier, placed, sky, wiring

NAME = "Metallic Paint Sun"
_MARK = sky.MARK  # of the lamp: whose sun; of the group in the world: that it is ours
_STILL = 1e-3  # rad, that a sun may move off the cone: a twentieth of its half-angle


def is_one(lamp: bpy.types.Object) -> bool:
    return _MARK in lamp


def why_not(scene: bpy.types.Scene) -> str:
    """What keeps the sun that sky.find finds from a lamp, in words; empty where nothing does."""
    if any(not layer.use_sky or getattr(layer, "world_override", None)
           for layer in placed.used_layers(scene)):  # fmt: skip
        return "the view layer does not show the scene's world"
    world = scene.world
    if not world.is_editable or world.override_library:
        return "the world is of another file"
    parts = sky.shown(world)
    if parts is None or not isinstance(parts[1], bpy.types.ShaderNodeTexEnvironment):
        return "Blender's sky shows its sun in a world alone"
    if parts[0].inputs["Strength"].is_linked:
        return "nodes decide on the world's Strength"
    if _turns(world.node_tree):
        return "the world turns"
    for other in bpy.data.scenes:
        if other.world == world and other != scene and not _lamps(other):
            return f"the scene {other.name} has the same world"
    return ""


def _turns(tree: bpy.types.NodeTree) -> bool:
    """Whether keys or drivers turn the image, which the lamp does not follow."""
    paths = {curve.data_path for curves in animation.curves(tree) for curve in curves}
    mappings = (each for each in tree.nodes if isinstance(each, bpy.types.ShaderNodeMapping))
    return any(path.startswith(each.path_from_id()) for each in mappings for path in paths)


def is_current(scene: bpy.types.Scene) -> bool:
    """Whether the sun that has a slot has its lamp, if it can have one, and all as it is now."""
    sun, lamps, world = sky.find(scene), _lamps(scene), scene.world
    if not lamps:
        sparkles = any(kind == carrier.SKY for kind, *_ in carrier.values())
        return not is_missing(scene) and (sun is None or not sparkles or bool(why_not(scene)))
    if sun is None or len(lamps) > 1 or lamps[0][_MARK] != world or not _is_dark(world):
        return False
    [lamp] = lamps
    texture: Any = sky.shown(world)[1]
    tree = lamp.data.node_tree
    turned = lamp.matrix_world.col[2].xyz.angle(Vector(sun.direction), math.pi)
    return (
        tree is not None
        and texture.image in {getattr(each, "image", None) for each in tree.nodes}
        and turned < _STILL
        and _renders(lamp, scene)
        and lamp.data.energy > 0
        and _visibility(world) == tuple(getattr(lamp, name) for name in _VISIBLE)
    )


def is_missing(scene: bpy.types.Scene) -> bool:
    """Whether the scene's world is dark where the lamp of another scene or file shows its sun."""
    return scene.world is not None and bool(_masks(scene.world)) and not _lamps(scene)


def make(scene: bpy.types.Scene) -> bpy.types.Object:
    """The lamp in the scene, and the darkness in its world; where they are, they are renewed. For
    a scene where why_not has no reason; remove is its inverse.
    """
    world, sun = scene.world, sky.find(scene)
    background: bpy.types.Node
    texture: Any
    background, texture = sky.shown(world)
    lamp = _of(world)
    if lamp is None:
        made = bpy.data.lights.new(f"Sun of {world.name}", "SUN")
        lamp = bpy.data.objects.new(made.name, made)
        lamp[_MARK] = world
    lamp.hide_render = False
    if not _renders(lamp, scene):
        scene.collection.objects.link(lamp)
    data: Any = lamp.data
    data.angle = 2 * sky.REACH
    # Cycles looks at a lamp the more often the stronger it is, whatever its nodes make of it.
    data.energy = sun.irradiance
    _show_image(data, world, background, texture)
    lamp.rotation_mode = "XYZ"
    lamp.rotation_euler = Vector(sun.direction).to_track_quat("Z", "Y").to_euler()
    lamp.lock_rotation = (True, True, True)
    for name, value in zip(_VISIBLE, _visibility(world), strict=True):
        setattr(lamp, name, value)
    data.cycles.max_bounces = world.cycles.max_bounces

    _light_up(world)
    darkness = _darkness(sun.direction)
    mask = world.node_tree.nodes.new("ShaderNodeGroup")
    mask.node_tree = darkness
    mask.location = background.location.x - 200, background.location.y - 200
    world.node_tree.links.new(texture.outputs[0], mask.inputs[0])
    world.node_tree.links.new(mask.outputs[0], background.inputs["Color"])
    for layer in scene.view_layers:
        layer.update()  # is_current asks for the lamp's matrix
    return lamp


def remove(scene: bpy.types.Scene, others: Collection[bpy.types.Scene]) -> None:
    """Gives its sun to the world again. `others` still need the lamps and worlds that they show."""
    kept = {each for other in others for each in (other.world, *other.objects)}
    lamps = [each for each in _lamps(scene) if each.is_editable]
    for world in {scene.world, *(each[_MARK] for each in lamps)} - kept - {None}:
        _light_up(world)
    for lamp in set(lamps) - kept:
        data = lamp.data
        bpy.data.objects.remove(lamp)
        if not data.users:
            bpy.data.lights.remove(data)


def _renders(lamp: bpy.types.Object, scene: bpy.types.Scene) -> bool:
    return all(lamp in placed.rendered(layer) for layer in placed.used_layers(scene))


def _lamps(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    return [each for each in scene.objects if is_one(each)]


def _of(world: bpy.types.World) -> bpy.types.Object | None:
    """The world's lamp, of whatever scene."""
    lamps = (each for each in bpy.data.objects if is_one(each) and each[_MARK] == world)
    return next((each for each in lamps if each.is_editable and each.data.type == "SUN"), None)


_VISIBLE = (
    "visible_diffuse", "visible_glossy", "visible_transmission", "visible_volume_scatter"
)  # fmt: skip


def _visibility(world: bpy.types.World) -> tuple[bool, ...]:
    to = world.cycles_visibility
    return to.diffuse, to.glossy, to.transmission, to.scatter


def _masks(world: bpy.types.World) -> list[bpy.types.Node]:
    """The nodes that keep the sun out of it."""
    return list(filter(sky.keeps_sun_out, world.node_tree.nodes)) if world.node_tree else []


def _is_dark(world: bpy.types.World) -> bool:
    """Whether one of these decides, and no other."""
    masks, parts = _masks(world), sky.shown(world)
    used = parts and sky.source(parts[0].inputs["Color"])
    return len(masks) == 1 and used == masks[0] and not masks[0].mute


def _light_up(world: bpy.types.World) -> None:
    """Takes what keeps the sun out of a world out of it."""
    if not world.is_editable:
        return
    for mask in _masks(world):
        tree: Any = mask.id_data
        if mask.inputs and mask.outputs and mask.inputs[0].is_linked:
            shown = mask.inputs[0].links[0].from_socket
            for link in list(mask.outputs[0].links):
                tree.links.new(shown, link.to_socket)
        tree.nodes.remove(mask)
    for group in [each for each in bpy.data.node_groups if _MARK in each and not each.users]:
        bpy.data.node_groups.remove(group)


def _show_image(
    data: bpy.types.Light,
    world: bpy.types.World,
    background: bpy.types.Node,
    texture: bpy.types.ShaderNodeTexEnvironment,
) -> None:
    """A sun lamp of irradiance E whose nodes say 1 has the radiance E / (pi tan^2) in its cone; the
    image says L, so its nodes say L pi tan^2 / E, times the world's Strength.
    """
    if data.node_tree is None:
        data.use_nodes = True  # Blender 4.5
    tree: Any = data.node_tree
    tree.animation_data_clear()
    tree.nodes.clear()
    emission = tree.nodes.new("ShaderNodeEmission")
    out = tree.nodes.new("ShaderNodeOutputLight")
    tree.links.new(emission.outputs[0], out.inputs[0])
    shows = tree.nodes.new("ShaderNodeTexEnvironment")
    shows.image, shows.interpolation = texture.image, texture.interpolation
    towards = _towards(tree)
    mapping = sky.source(texture.inputs["Vector"])
    if isinstance(mapping, bpy.types.ShaderNodeMapping):
        turned = tree.nodes.new("ShaderNodeMapping")
        turned.vector_type = mapping.vector_type
        turned.inputs["Rotation"].default_value = mapping.inputs["Rotation"].default_value
        tree.links.new(towards, turned.inputs["Vector"])
        towards = turned.outputs["Vector"]
    tree.links.new(towards, shows.inputs["Vector"])
    scaled = tree.nodes.new("ShaderNodeVectorMath")
    scaled.operation = "SCALE"
    scaled.inputs["Scale"].default_value = math.pi * math.tan(sky.REACH) ** 2 / data.energy
    tree.links.new(shows.outputs["Color"], scaled.inputs[0])
    tree.links.new(scaled.outputs["Vector"], emission.inputs["Color"])
    strength = emission.inputs["Strength"]
    strength.default_value = background.inputs["Strength"].default_value
    curve: Any = strength.driver_add("default_value")
    driver = curve.driver
    driver.type = "SUM"
    target = driver.variables.new().targets[0]
    target.id_type, target.id = "WORLD", world
    target.data_path = f"node_tree.{background.inputs['Strength'].path_from_id('default_value')}"
    wiring.lay_out(tree)


def _towards(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    """The direction that a lamp or a world is seen in."""
    geometry = tree.nodes.new("ShaderNodeNewGeometry")
    back = tree.nodes.new("ShaderNodeVectorMath")
    back.operation = "SCALE"
    back.inputs["Scale"].default_value = -1
    tree.links.new(geometry.outputs["Incoming"], back.inputs[0])
    return back.outputs["Vector"]


def _darkness(direction: tuple[float, float, float]) -> bpy.types.ShaderNodeTree:
    """A group that hands on a colour, but black in the cone, which the camera sees as it was."""
    group = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    group.description = "Dark where a lamp shows the sun of this world, for its light group"
    group[_MARK] = True
    for kind in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Color", in_out=kind, socket_type="NodeSocketColor")
    taken, out = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    cosine = group.nodes.new("ShaderNodeVectorMath")
    cosine.operation = "DOT_PRODUCT"
    cosine.inputs[1].default_value = direction
    group.links.new(_towards(group), cosine.inputs[0])
    inside = wiring.compute(group, "GREATER_THAN", cosine.outputs["Value"], math.cos(sky.REACH))
    camera = group.nodes.new("ShaderNodeLightPath").outputs["Is Camera Ray"]
    hidden = wiring.compute(group, "GREATER_THAN", inside.outputs[0], camera)
    shown = wiring.compute(group, "SUBTRACT", 1.0, hidden.outputs[0])
    dimmed = group.nodes.new("ShaderNodeVectorMath")
    dimmed.operation = "SCALE"
    group.links.new(taken.outputs["Color"], dimmed.inputs[0])
    group.links.new(shown.outputs[0], dimmed.inputs["Scale"])
    group.links.new(dimmed.outputs["Vector"], out.inputs["Color"])
    wiring.lay_out(group)
    return group
