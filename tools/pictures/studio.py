# SPDX-License-Identifier: Apache-2.0
"""The studio of the demo: long softboxes over a dark, glossy floor, and three small lamps.

A photographer lights a car by what it mirrors: the softboxes' edges draw the body's lines. Small
lamps make the sparkles. Everything is measured in radii of the subject.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Vector

from pictures.shapes import Array, add_grid, glowing_material, plain_material

VIEW = (0.78, -0.95, 0.19)  # towards the camera: three quarters from the front
FALL = "fall"  # the attribute of a softbox that tells its light's fall towards the edges
LENS = 85  # mm, on a film 36 mm wide


def build(scene: bpy.types.Scene, subject: bpy.types.Object) -> None:
    """Puts a floor, a backdrop, softboxes, lamps and a camera around the subject."""
    bpy.context.view_layer.update()
    corners = world_box(subject)
    low, high = corners.min(0), corners.max(0)
    lowest = min(world_box(item)[:, 2].min() for item in scene.objects if item.type == "MESH")
    centre, radius = Vector((low + high) / 2), float(np.linalg.norm(high - low)) / 2
    ground = Vector((centre.x, centre.y, lowest))
    add_camera(scene, corners)
    add_cyclorama(scene, ground, radius)
    for at, target, size, radiance in SOFTBOXES:
        add_softbox(scene, ground + radius * Vector(at), ground + radius * Vector(target),
                    (size[0] * radius, size[1] * radius), radiance)  # fmt: skip
    add_lamp(scene, centre, radius, *LAMP)
    world = bpy.data.worlds.new("Studio")
    if world.node_tree is None:
        world.use_nodes = True  # Blender 4.5
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.010, 0.011, 0.013, 1)
    world.cycles.sampling_method = "NONE"
    scene.world = world


# Place, target, size along and across, radiance.
SOFTBOXES = (
    ((-0.6, 1.3, 1.9), (0.0, 0.0, 0.2), (4.2, 0.9), 6.5),  # above and behind: bonnet, roof
    ((-1.9, -2.3, 1.75), (0.0, 0.0, 0.2), (3.6, 0.36), 9.0),  # the flank's shoulder
    ((-2.1, -2.5, 0.42), (0.0, 0.0, 0.25), (3.0, 0.12), 7.0),  # the door
    ((2.3, 2.2, 1.1), (0.7, 0.0, 0.2), (1.6, 0.5), 5.0),  # the nose
)  # fmt: skip
# Towards the lamp, and the irradiance that it gives the subject's middle, W/m².
LAMP = ((0.9, -1.5, 1.9), 6.0)


def world_box(item: bpy.types.Object) -> Array:
    """The corners (8, 3) of the object's bounding box in the world."""
    return np.array([item.matrix_world @ Vector(corner) for corner in item.bound_box])


def add_camera(
    scene: bpy.types.Scene, corners: Array, view: Sequence[float] = VIEW
) -> bpy.types.Object:
    """A view from which the box of these corners fills the picture."""
    low, high = corners.min(0), corners.max(0)
    centre, radius = Vector((low + high) / 2), float(np.linalg.norm(high - low)) / 2
    data = bpy.data.cameras.new("Camera")
    data.lens = LENS
    camera = bpy.data.objects.new("Camera", data)
    scene.collection.objects.link(camera)
    scene.camera = camera
    towards = Vector(view).normalized()
    camera.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
    axes = np.array(camera.rotation_euler.to_matrix()).T
    aspect = scene.render.resolution_y / scene.render.resolution_x
    half = (
        0.5
        * data.sensor_width
        / data.lens
        * np.array([1, aspect] if aspect <= 1 else [1 / aspect, 1])
    )
    local = (corners - np.array(centre)) @ axes.T
    # Each corner asks for a distance at which it lies within 107 % of the picture: a body is round
    # and leaves its box's corners empty.
    distance = max(float((np.abs(local[:, :2]) / (1.07 * half) + local[:, 2:]).max()), radius)
    camera.location = centre + distance * towards
    data.clip_start, data.clip_end = distance / 1000, distance * 1000
    return camera


def add_cyclorama(scene: bpy.types.Scene, ground: Vector, radius: float) -> None:
    """A floor of dark epoxy that bends into a round wall, which a lamp behind the car lights."""
    angle = np.linspace(0, 2 * np.pi, 129)[:-1]
    wall, bend = 9 * radius, 3 * radius
    cove = np.linspace(0, np.pi / 2, 24)
    out = np.concatenate([[0, 0.5 * wall], wall - bend + bend * np.sin(cove), [wall]])
    up = np.concatenate([[0, 0], bend - bend * np.cos(cove), [wall]])
    around = [np.outer(out, np.cos(angle)), np.outer(out, np.sin(angle)), up[:, None] + 0 * angle]
    behind = ground - wall * Vector((VIEW[0], VIEW[1], 0)).normalized()
    behind.z += 0.6 * radius
    surface = _cyclorama(ground, (2.6 * radius, wall - bend), behind, wall)
    grid = np.stack(around, -1) + np.array(ground)
    add_grid(scene, "Cyclorama", grid, surface, closed=(False, True))


def _cyclorama(
    ground: Vector, fade: tuple[float, float], middle: Vector, width: float
) -> bpy.types.Material:
    """Epoxy that fades, with the distance from the car, into the light that falls on the wall."""
    surface = plain_material("Cyclorama", (0.010, 0.0105, 0.012), roughness=0.14)
    tree = surface.node_tree
    place, apart, fall, ramp, glow, away, far, mix = (
        tree.nodes.new(f"ShaderNode{kind}")
        for kind in ("NewGeometry", "VectorMath", "MapRange", "ValToRGB", "Emission",
                     "VectorMath", "MapRange", "MixShader")
    )  # fmt: skip
    apart.operation = away.operation = "DISTANCE"
    apart.inputs[1].default_value, away.inputs[1].default_value = middle, ground
    fall.inputs["From Max"].default_value = width
    far.interpolation_type = "SMOOTHSTEP"
    far.inputs["From Min"].default_value, far.inputs["From Max"].default_value = fade
    colours = ramp.color_ramp
    colours.interpolation = "EASE"
    colours.elements[0].color = (0.060, 0.066, 0.078, 1)
    colours.elements[1].color = (0.003, 0.0033, 0.0045, 1)
    colours.elements[1].position = 0.75
    out = tree.nodes["Material Output"]
    tree.links.new(place.outputs["Position"], apart.inputs[0])
    tree.links.new(place.outputs["Position"], away.inputs[0])
    tree.links.new(apart.outputs["Value"], fall.inputs["Value"])
    tree.links.new(fall.outputs["Result"], ramp.inputs["Fac"])
    tree.links.new(ramp.outputs["Color"], glow.inputs["Color"])
    tree.links.new(away.outputs["Value"], far.inputs["Value"])
    tree.links.new(far.outputs["Result"], mix.inputs["Fac"])
    tree.links.new(tree.nodes["Principled BSDF"].outputs[0], mix.inputs[1])
    tree.links.new(glow.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], out.inputs["Surface"])
    return surface


def add_softbox(
    scene: bpy.types.Scene, at: Vector, target: Vector, size: tuple[float, float], radiance: float
) -> bpy.types.Object:
    """A bright rectangle of that radiance, W/(m² sr), turned to the target; its length is level.

    It is a mesh that no shadow ray seeks: what mirrors it finds it. So each of them goes to the
    lamp, whose sparkles, which no denoiser may touch, come without noise.
    """
    x, y, _ = np.array((target - at).to_track_quat("Z", "Y").to_matrix()).T
    u, v = np.linspace(-1, 1, 65)[:, None], np.linspace(-1, 1, 17)[None, :]
    grid = size[0] / 2 * u[..., None] * x + size[1] / 2 * v[..., None] * y + np.array(at)
    box = add_grid(scene, "Softbox", grid, glowing_material("Softbox", radiance, FALL))
    # Brightest in the middle, where its lamp is behind the cloth.
    cloth = (1 - 0.6 * u**2) * (1 - 0.45 * v**2)
    box.data.attributes.new(FALL, "FLOAT", "POINT").data.foreach_set("value", cloth.ravel())
    return box


def add_lamp(
    scene: bpy.types.Scene, centre: Vector, radius: float, towards: Sequence[float],
    irradiance: float,
) -> bpy.types.Object:  # fmt: skip
    """A spot lamp as wide as a fist, 2.5 radii or so away."""
    data = bpy.data.lights.new("Lamp", "SPOT")
    away = Vector(towards) * radius
    data.energy = irradiance * 4 * math.pi * away.length_squared
    data.shadow_soft_size = 0.012 * radius
    data.spot_size, data.spot_blend = math.radians(70), 0.6
    item = bpy.data.objects.new("Lamp", data)
    item.location = centre + away
    item.rotation_euler = away.to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(item)
    return item
