# SPDX-License-Identifier: GPL-3.0-or-later
"""The sun of an environment image as a lamp of its own, which can be in a light group of its own.

Cycles has one light group for all light of a world. So a lamp shows the same image within the cone
about the sun that sparkles, and there the world is dark but for the camera. A surface gets the same
light from the same directions, and the slot stays that of the world's sun.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import bpy
from mathutils import Vector

from . import carrier, sky, wiring

NAME = "Metallic Paint Sun"
_MARK = sky.MARK  # of the lamp: whose sun; of the group in the world: that it is ours
_STILL = 1e-3  # rad, that a sun may move before the cone is renewed: a twentieth of it


def is_one(lamp: bpy.types.Object) -> bool:
    return _MARK in lamp


def why_not(scene: bpy.types.Scene) -> str:
    """What keeps the sun that sky.find finds from a lamp, in words; empty where nothing does."""
    world = scene.world
    if not world.is_editable:
        return "the world is linked from another file"
    background, texture = sky.shown(world)
    if not isinstance(texture, bpy.types.ShaderNodeTexEnvironment):
        return "Blender's sky shows its sun in a world alone"
    if background.inputs["Strength"].is_linked:
        return "nodes decide on the world's Strength"
    return ""


def is_current(scene: bpy.types.Scene) -> bool:
    """Whether the sun that has a slot now has its lamp, if it can, and where it stands now."""
    sun, lamp = sky.find(scene), _lamp(scene)
    if lamp is None:
        sparkles = any(kind == carrier.SKY for kind, *_ in carrier.values())
        return sun is None or not sparkles or bool(why_not(scene))
    if sun is None or _mask(scene.world) is None:
        return False
    texture: Any = sky.shown(scene.world)[1]
    images = {getattr(each, "image", None) for each in lamp.data.node_tree.nodes}
    return texture.image in images and _axis(lamp).angle(Vector(sun.direction)) < _STILL


def make(scene: bpy.types.Scene) -> bpy.types.Object:
    """Where why_not has no reason; remove is its inverse."""
    world, sun = scene.world, sky.find(scene)
    background: bpy.types.Node
    texture: Any
    background, texture = sky.shown(world)
    data: Any = bpy.data.lights.new(f"Sun of {world.name}", "SUN")
    lamp = bpy.data.objects.new(data.name, data)
    lamp[_MARK] = world
    data.angle = 2 * sky.REACH
    # Cycles looks at a lamp the more often the stronger it is, whatever its nodes make of it.
    data.energy = sun.irradiance
    _show_image(data, world, background, texture)
    lamp.rotation_euler = Vector(sun.direction).to_track_quat("Z", "Y").to_euler()
    lamp.lock_rotation = (True, True, True)
    for kind in ("diffuse", "glossy", "transmission"):
        setattr(lamp, f"visible_{kind}", getattr(world.cycles_visibility, kind))
    lamp.visible_volume_scatter = world.cycles_visibility.scatter
    data.cycles.max_bounces = world.cycles.max_bounces
    scene.collection.objects.link(lamp)

    mask = world.node_tree.nodes.new("ShaderNodeGroup")
    mask.node_tree = _darkness(sun.direction)
    mask.location = background.location.x - 200, background.location.y - 200
    world.node_tree.links.new(texture.outputs["Color"], mask.inputs["Color"])
    world.node_tree.links.new(mask.outputs["Color"], background.inputs["Color"])
    return lamp


def remove(scene: bpy.types.Scene, others: Collection[bpy.types.Scene]) -> None:
    """Gives its sun to the world again, but for lamps and worlds that these other scenes show."""
    kept = {each for other in others for each in (other.world, *other.objects)}
    lamps = [each for each in scene.objects if is_one(each) and each.is_editable]
    worlds = {scene.world, *(each[_MARK] for each in lamps)} - kept
    for world in worlds:
        if world is not None and (mask := _mask(world)) is not None:
            tree, group = world.node_tree, mask.node_tree
            if mask.inputs["Color"].is_linked:
                shown = mask.inputs["Color"].links[0].from_socket
                for link in list(mask.outputs["Color"].links):
                    tree.links.new(shown, link.to_socket)
            tree.nodes.remove(mask)
            if not group.users:
                bpy.data.node_groups.remove(group)
    for lamp in set(lamps) - kept:
        data = lamp.data
        bpy.data.objects.remove(lamp)
        if not data.users:
            bpy.data.lights.remove(data)


def _lamp(scene: bpy.types.Scene) -> bpy.types.Object | None:
    """Of the scene's world."""
    lamps = (each for each in scene.objects if is_one(each) and each[_MARK] == scene.world)
    return next(lamps, None)


def _axis(lamp: bpy.types.Object) -> Vector:
    """Towards the sun."""
    axis: Vector = lamp.rotation_euler.to_matrix().col[2]
    return axis


def _mask(world: bpy.types.World) -> bpy.types.ShaderNodeGroup | None:
    """The node that keeps the sun out of it, or None."""
    if world.node_tree is None or not world.is_editable:
        return None
    return next(filter(sky.keeps_sun_out, world.node_tree.nodes), None)


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
    tree = data.node_tree
    emission = tree.nodes["Emission"]
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
