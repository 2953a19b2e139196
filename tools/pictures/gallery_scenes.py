# SPDX-License-Identifier: Apache-2.0
"""What the gallery photographs: swatches, a macro plate and the car, and the light on them.

Metres, in true size: how large sparkles are follows from that. Every scene starts empty; the
functions here add to it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Vector

from pictures import demo_model, render_scene, shapes, studio

SUN_ANGLE = math.radians(0.53)
COURTYARD_BALANCE = (1.0, 0.98, 0.9)  # its sky is blue
SWATCH_WIDTH = 0.105  # of the picture, metres


def empty_scene(
    width: int, height: int, samples: int, exposure: float = 0, as_photograph: bool = False
) -> bpy.types.Scene:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    render_scene.set_up_studio(scene)
    render_scene.set_up(scene, samples, width, height)
    scene.cycles.max_bounces = 2  # floor and paint light each other once
    if not as_photograph:  # colours as they are
        scene.view_settings.view_transform, scene.view_settings.look = "Standard", "None"
    scene.view_settings.exposure = exposure
    return scene


# ---- Cameras ----


def add_camera(
    scene: bpy.types.Scene, at: Sequence[float], target: Sequence[float], width: float
) -> bpy.types.Object:
    """A camera from which the picture is `width` metres wide at the target."""
    data = bpy.data.cameras.new("Camera")
    camera = bpy.data.objects.new("Camera", data)
    scene.collection.objects.link(camera)
    scene.camera = camera
    away = Vector(at) - Vector(target)
    camera.location = at
    camera.rotation_euler = away.to_track_quat("Z", "Y").to_euler()
    data.sensor_fit = "HORIZONTAL"
    data.lens = data.sensor_width * away.length / width
    data.clip_start, data.clip_end = away.length / 100, away.length * 1000
    return camera


def add_label(scene: bpy.types.Scene, text: str, *, plate: bool = False) -> bpy.types.Object:
    """Words at the lower edge of the picture; with `plate` on black, where sparkles hide them."""
    camera = scene.camera.data
    near = 10 * camera.clip_start
    half = near * camera.sensor_width / camera.lens / 2
    curve = bpy.data.curves.new("Label", "FONT")
    curve.body, curve.size = text, 0.124 * half
    curve.align_x = "CENTER"
    label = bpy.data.objects.new("Label", curve)
    scene.collection.objects.link(label)
    bottom = -half * 0.94 * scene.render.resolution_y / scene.render.resolution_x
    _fix_to_camera(scene, label, (0, bottom, -near), 0.85 * 2**-scene.view_settings.exposure)
    if plate:
        low, high = -0.1 * half, 0.124 * half
        corners = np.array(
            [(x, y, 0) for x, y in ((-half, low), (half, low), (half, high), (-half, high))]
        )
        black = shapes.add_mesh(scene, "Plate", corners, np.array([(0, 1, 2, 3)]), None)
        _fix_to_camera(scene, black, (0, bottom, -1.001 * near), 0)
    return label


def _fix_to_camera(
    scene: bpy.types.Scene, thing: bpy.types.Object, at: Sequence[float], radiance: float
) -> None:
    """At a place of the camera's space, shining, seen by the camera alone."""
    thing.parent = scene.camera
    thing.location = at
    for ray in ("diffuse", "glossy", "shadow"):
        setattr(thing, f"visible_{ray}", False)
    surface = bpy.data.materials.new(thing.name)
    if surface.node_tree is None:
        surface.use_nodes = True  # Blender 4.5
    nodes = surface.node_tree.nodes
    nodes.clear()
    glow, out = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    surface.node_tree.links.new(glow.outputs[0], out.inputs["Surface"])
    glow.inputs["Strength"].default_value = radiance
    thing.data.materials.clear()
    thing.data.materials.append(surface)


# ---- Light ----


def add_sun(
    scene: bpy.types.Scene, towards: Sequence[float], irradiance: float,
    colour: Sequence[float] = (1, 1, 1),
) -> bpy.types.Object:  # fmt: skip
    data = bpy.data.lights.new("Sun", "SUN")
    data.energy, data.angle, data.color = irradiance, SUN_ANGLE, colour
    return _placed(scene, data, Vector(towards))


def _placed(scene: bpy.types.Scene, data: bpy.types.Light, towards: Vector) -> bpy.types.Object:
    item = bpy.data.objects.new(data.name, data)
    item.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(item)
    return item


def set_studio_light(
    scene: bpy.types.Scene, name: str, strength: float, turn: float = 0,
    balance: Sequence[float] = (1, 1, 1),
) -> None:  # fmt: skip
    """One of the surroundings that come with Blender, turned about the vertical (degrees)."""
    background = _new_background(scene, strength)
    tree = scene.world.node_tree
    picture = tree.nodes.new("ShaderNodeTexEnvironment")
    folder = bpy.utils.system_resource("DATAFILES", path="studiolights/world")
    picture.image = bpy.data.images.load(f"{folder}/{name}.exr")
    picture.interpolation = "Cubic"  # a third of a degree wide, its pixels would show behind a car
    where, turned = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeMapping")
    turned.inputs["Rotation"].default_value[2] = math.radians(turn)
    tree.links.new(where.outputs["Generated"], turned.inputs["Vector"])
    tree.links.new(turned.outputs[0], picture.inputs[0])
    balanced = tree.nodes.new("ShaderNodeVectorMath")
    balanced.operation = "MULTIPLY"
    balanced.inputs[1].default_value = balance
    tree.links.new(picture.outputs[0], balanced.inputs[0])
    tree.links.new(balanced.outputs[0], background.inputs["Color"])


def set_sky(scene: bpy.types.Scene, towards_sun: Sequence[float], strength: float) -> None:
    """A clear sky around the sun; the sun itself is a lamp, which makes sparkles."""
    background = _new_background(scene, strength)
    tree = scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    kinds = [item.identifier for item in sky.bl_rna.properties["sky_type"].enum_items]
    sky.sky_type = "NISHITA" if "NISHITA" in kinds else "MULTIPLE_SCATTERING"  # Blender 5
    sky.sun_disc = False
    x, y, z = Vector(towards_sun).normalized()
    sky.sun_elevation, sky.sun_rotation = math.asin(z), math.atan2(x, y)
    tree.links.new(sky.outputs[0], background.inputs["Color"])


def _new_background(scene: bpy.types.Scene, strength: float) -> bpy.types.ShaderNode:
    world = bpy.data.worlds.new("Surroundings")
    if world.node_tree is None:
        world.use_nodes = True  # Blender 4.5
    scene.world = world
    background = world.node_tree.nodes["Background"]
    background.inputs["Strength"].default_value = strength
    return background


# ---- Subjects ----


def add_floor(scene: bpy.types.Scene, size: float, grey: float) -> None:
    _add_ground(scene, size, shapes.plain_material("Floor", (grey, grey, 1.03 * grey), 0.5))


def add_street(scene: bpy.types.Scene, grey: float, fade: tuple[float, float]) -> None:
    """Asphalt that gives way to the world's picture from one distance to the other (metres)."""
    surface = shapes.asphalt_material("Asphalt", grey)
    tree = surface.node_tree
    place, away, share, clear, mix = (
        tree.nodes.new(f"ShaderNode{kind}")
        for kind in ("NewGeometry", "VectorMath", "MapRange", "BsdfTransparent", "MixShader")
    )
    away.operation, share.interpolation_type = "LENGTH", "SMOOTHSTEP"
    share.inputs["From Min"].default_value, share.inputs["From Max"].default_value = fade
    tree.links.new(place.outputs["Position"], away.inputs[0])
    tree.links.new(away.outputs["Value"], share.inputs["Value"])
    tree.links.new(share.outputs["Result"], mix.inputs["Fac"])
    tree.links.new(tree.nodes["Principled BSDF"].outputs[0], mix.inputs[1])
    tree.links.new(clear.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    _add_ground(scene, 2 * fade[1], surface)


def _add_ground(scene: bpy.types.Scene, size: float, surface: bpy.types.Material) -> None:
    s = size / 2
    corners = np.array([(-s, -s, 0), (s, -s, 0), (s, s, 0), (-s, s, 0)])
    shapes.add_mesh(scene, "Floor", corners, np.array([(0, 1, 2, 3)]), surface)


def add_ball(scene: bpy.types.Scene, at: Sequence[float], radius: float) -> bpy.types.Object:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=192, ring_count=96, radius=radius, location=at)
    ball = bpy.context.object
    ball.data.polygons.foreach_set("use_smooth", np.ones(len(ball.data.polygons), bool))
    return ball


def add_bent_panel(
    scene: bpy.types.Scene, width: float, height: float, radius: float, lean: float
) -> bpy.types.Object:
    """A tile of rounded outline, bent about the x axis; its middle looks `lean` above -y."""
    s, t = shapes.rounded(160, 6)
    angle = lean + t * height / (2 * radius)
    normal = np.stack([0 * s, -np.cos(angle), np.sin(angle)], -1)
    points = (radius * normal + np.stack([s * width / 2, 0 * s, 0 * s], -1)).reshape(-1, 3)
    n, m = s.shape
    i = np.arange(n * m).reshape(n, m)
    quads = np.stack([i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]], -1).reshape(-1, 4)
    panel = shapes.add_mesh(scene, "Panel", points, quads, None)
    panel.data.normals_split_custom_set_from_vertices(normal.reshape(-1, 3))
    return panel


def swatch(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """A ball and a bent panel on a grey board, under sun and a studio's light."""
    add_floor(scene, 3, 0.16)
    panel = add_bent_panel(scene, 0.048, 0.052, 0.034, math.radians(38))
    panel.location = (-0.0235, 0.033, 0.005)
    ball = add_ball(scene, (0.0265, 0, 0.020), 0.020)
    add_camera(scene, (0, -0.40, 0.17), (0, 0.004, 0.0165), SWATCH_WIDTH)
    add_sun(scene, (-0.45, -0.55, 0.9), 1.7)
    set_studio_light(scene, "courtyard", 0.6, 0, COURTYARD_BALANCE)
    return [panel, ball]


def small_swatch(scene: bpy.types.Scene) -> bpy.types.Object:
    """A ball of 40 mm alone in the picture, on the board and in the light of the swatch."""
    radius = 0.020
    add_floor(scene, 3, 0.16)
    ball = add_ball(scene, (0, 0, radius), radius)
    add_camera(scene, (0, -0.40, 0.17), (0, 0, radius), 2.3 * radius)
    add_sun(scene, (-0.45, -0.55, 0.9), 1.7)
    set_studio_light(scene, "courtyard", 0.6, 0, COURTYARD_BALANCE)
    return ball


def close_up(scene: bpy.types.Scene, width: float) -> bpy.types.Object:
    """The top of a ball in a picture `width` metres wide, the sun almost behind the camera."""
    scene.cycles.filter_width = 2.5  # pixels: the lens blurs a flake as small as a pixel
    radius = 6 * width
    ball = add_ball(scene, (0, 0, -radius), radius)
    add_camera(scene, (0, 0, 15 * width), (0, 0, 0), width)
    add_sun(scene, (0.2, 0.25, 1), 1.7)
    set_studio_light(scene, "courtyard", 0.6, 0, COURTYARD_BALANCE)
    return ball


def macro(scene: bpy.types.Scene, width: float) -> bpy.types.Object:
    """The top of a ball, aslant, in a picture so many metres wide, in a courtyard and a soft lamp.

    The lens has a depth of field. A point that lies h nearer or farther than the middle, at the
    distance d, is a disc as wide as A h / d, with A the lens' aperture. At the picture's edges h is
    width tan(slant) / 2; there the disc is to be 4 % of the picture.
    """
    slant, distance = math.radians(40), 15 * width
    ball = add_ball(scene, (0, 0, -6 * width), 6 * width)
    towards = Vector((0, -math.sin(slant), math.cos(slant)))
    camera = add_camera(scene, distance * towards, (0, 0, 0), width).data
    aperture = 0.04 * 2 * distance / math.tan(slant)
    camera.dof.use_dof, camera.dof.focus_distance = True, distance
    camera.dof.aperture_fstop = camera.lens * 1e-3 / aperture
    # Its image in the lacquer lies beside the picture. A flake that mirrors it is some ten times as
    # bright as the sky, not ten thousand times as with a sun: so blurred flakes have soft edges.
    lamp = add_sun(scene, (0.2, 0.35, 0.9), 0.08)
    lamp.data.angle = math.radians(6)
    set_studio_light(scene, "courtyard", 0.6, 0, COURTYARD_BALANCE)
    return ball


LOW_VIEW = (*studio.VIEW[:2], 0.06)  # the lens as high as the headlamps: the horizon is seen


def car(scene: bpy.types.Scene, view: Sequence[float] = LOW_VIEW) -> bpy.types.Object:
    body = demo_model.build_car(scene)
    bpy.context.view_layer.update()
    studio.add_camera(scene, studio.world_box(body), view)
    return body


def seen_point(scene: bpy.types.Scene, near: Vector, away: Vector) -> Vector:
    """Where one who looks from that direction at a point sees a surface first."""
    bpy.context.view_layer.update()
    graph = bpy.context.evaluated_depsgraph_get()
    hit, where, *_ = scene.ray_cast(graph, near + 20 * away, -away)
    return where if hit else near
