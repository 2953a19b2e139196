# SPDX-License-Identifier: Apache-2.0
"""The scenes of ./paint verify: all kinds of lights, models, surfaces and cameras, near and far."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import bpy
from mathutils import Vector
from metallic_paint.paint import Flakes, Paint, material, presets
from metallic_paint.scene import lights, rest_position
from pictures import demo_model

SILVER = Paint()
CANDY = Paint(
    flakes_per_mm2=1500, flake_diameter_um=30, flake_area_spread=0.5, tilt=0.2,
    flake_color=(0.9, 0.8, 0.6), binder_absorption_per_mm=(1, 15, 40), rayleigh_per_mm=0.3, seed=7,
)  # fmt: skip
THREE = dataclasses.replace(
    CANDY,
    second=Flakes(flakes_per_mm2=200, flake_diameter_um=50, tilt=0.3, flake_color=(0.2, 0.9, 0.4)),
    third=Flakes(flakes_per_mm2=9000, flake_diameter_um=8, orientation="ggx", tilt=0.4),
)
PEARLS = Paint(
    flakes_per_mm2=2500, coating="tio2-on-mica", coating_nm=115, flake_diameter_um=18,
    second=Flakes(flakes_per_mm2=400, coating="tio2-on-thin-silica", coating_nm=70,
                  flake_diameter_um=35, tilt=0.1),
    third=Flakes(flakes_per_mm2=900, coating="gold", flake_diameter_um=12, tilt=0.25),
    substrate_color=(0.8, 0.75, 0.7), texture_contrast=0.05, seed=3,
)  # fmt: skip


@dataclass(frozen=True)
class Scene:
    """What a scene shows. Distances are in metres; the camera looks at the origin."""

    name: str
    lamps: tuple[Callable[[bpy.types.Scene], bpy.types.Object | bpy.types.World], ...]
    paint: Paint = SILVER
    shape: str = "plane"
    distance: float = 1.0  # of the camera
    elevation: float = 50.0  # of the camera over the plane, degrees
    width: float = 0.2  # of what the picture shows, metres
    orthographic: bool = False
    panorama: str = ""  # Blender's name of its kind
    scale: tuple[float, float, float] = (1, 1, 1)
    rotation: tuple[float, float, float] = (0, 0, 0)
    seeds: int = 1  # pictures over which mean and variance are taken


def sun(name: str, elevation: float, azimuth: float, angle: float = 0.0) -> Callable:
    """A sun at that elevation and azimuth, of that angular diameter, in degrees."""

    def add(scene: bpy.types.Scene) -> bpy.types.Object:
        data = bpy.data.lights.new(name, "SUN")
        data.energy, data.angle = 3.0, math.radians(angle)
        e, a = math.radians(elevation), math.radians(azimuth)
        towards = Vector((math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)))
        return _place(scene, name, data, (0, 0, 0), towards)

    return add


def lamp(
    name: str, kind: str, location: tuple, radius: float = 0.0, energy: float = 100
) -> Callable:
    """A point or a spot light at a location, the spot aimed at the origin."""

    def add(scene: bpy.types.Scene) -> bpy.types.Object:
        data = bpy.data.lights.new(name, kind)
        data.energy, data.shadow_soft_size = energy, radius
        if kind == "SPOT":
            data.spot_size, data.spot_blend = math.radians(30), 0.2
        return _place(scene, name, data, location, Vector(location))

    return add


def area(
    name: str, shape: str, location: tuple, half: float, aspect: float = 1, turn: float = 0.3
) -> Callable:
    """An area light that is turned away from the origin a little.

    Head on it would be seen there under that half-angle, in degrees, along its longer side.
    """

    def add(scene: bpy.types.Scene) -> bpy.types.Object:
        data = bpy.data.lights.new(name, "AREA")
        data.energy, data.shape = 20, shape
        data.size = 2 * Vector(location).length * math.tan(math.radians(half))
        data.size_y = data.size / aspect
        lamp = _place(scene, name, data, location, Vector(location))
        lamp.rotation_euler.rotate_axis("X", turn)
        return lamp

    return add


def sky(elevation: float, azimuth: float, angle: float = 0.53) -> Callable:
    """The world: a sky, whose sun stands there, of that angular diameter, in degrees."""

    def add(scene: bpy.types.Scene) -> bpy.types.World:
        scene.world = world = bpy.data.worlds.new("World")
        if world.node_tree is None:
            world.use_nodes = True  # Blender 4.5
        tree = world.node_tree
        node = tree.nodes.new("ShaderNodeTexSky")
        node.sun_elevation, node.sun_size = math.radians(elevation), math.radians(angle)
        node.sun_rotation = math.radians(90 - azimuth)
        tree.links.new(node.outputs[0], tree.nodes["Background"].inputs["Color"])
        return world

    return add


def _place(
    scene: bpy.types.Scene, name: str, data: bpy.types.Light, location: tuple, towards: Vector
) -> bpy.types.Object:
    data.cycles.use_multiple_importance_sampling = False  # one sample hits the lamp, without noise
    data.use_shadow = True
    item = bpy.data.objects.new(name, data)
    item.location = location
    item.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(item)
    return item


SUN = sun("Sun", 60, 110, 0.53)
BALL = (0.03, 0.03, 0.03)
_SCENES = (
    Scene("sun, plane, close", (SUN,), width=0.06, seeds=8),
    Scene("sun, plane, far", (SUN,), distance=300, width=60),
    Scene("sun of no size, sphere, close", (sun("Sun", 60, 110),), shape="sphere",
          scale=(0.03, 0.03, 0.03), width=0.05, seeds=16),
    Scene("sun, sphere, far", (SUN,), shape="sphere", distance=100, width=16, scale=(8, 8, 8),
          paint=CANDY),
    Scene("spot, plane", (lamp("Spot", "SPOT", (0.5, 0.6, 1.2), 0.02),), width=0.4, seeds=2),
    Scene("point, mesh with smooth normals", (lamp("Point", "POINT", (-0.5, 0.4, 0.9), 0.05),),
          shape="monkey", scale=(0.1, 0.1, 0.1), width=0.3, seeds=2),
    Scene("point of no size, sphere", (lamp("Point", "POINT", (-0.5, 0.4, 0.9)),), shape="sphere",
          scale=(0.15, 0.15, 0.15), width=0.3, seeds=2),
    Scene("thinned, sphere", (SUN,), shape="sphere", width=1, distance=5,
          paint=dataclasses.replace(CANDY, depth_model="thinned"), scale=(0.5, 0.5, 0.5)),
    Scene("attenuated, sphere", (SUN,), shape="sphere", width=1, distance=5,
          paint=dataclasses.replace(CANDY, depth_model="attenuated"), scale=(0.5, 0.5, 0.5)),
    Scene("published, plane", (SUN,), paint=dataclasses.replace(SILVER, radiometry="published"),
          seeds=4),
    Scene("published and thinned, sphere", (SUN,), shape="sphere", distance=5, width=1,
          scale=(0.5, 0.5, 0.5),
          paint=dataclasses.replace(CANDY, radiometry="published", depth_model="thinned")),
    Scene("orthographic, plane, close", (SUN,), orthographic=True, width=0.06, seeds=8),
    Scene("orthographic, sphere, far", (SUN,), shape="sphere", orthographic=True, distance=50,
          width=16, scale=(8, 8, 8)),
    Scene("scaled and rotated mesh", (SUN,), shape="monkey", scale=(0.13, 0.05, 0.08),
          rotation=(0.5, -0.3, 1.1), width=0.2, paint=CANDY, seeds=16),
    Scene("sun, spot and point at once", (SUN, lamp("Spot", "SPOT", (0.5, 0.6, 1.2), 0.02),
          lamp("Point", "POINT", (-0.5, 0.4, 0.9), 0.05)), shape="monkey", scale=(0.1, 0.1, 0.1),
          width=0.3, seeds=2),
    # Diffraction would dim one pixel in twenty below Cycles' least weight in cones so narrow.
    Scene("two suns 0.6 degrees apart", (sun("Sun", 60, 110, 0.2), sun("Sun two", 60.6, 110, 0.2)),
          paint=dataclasses.replace(SILVER, diffraction="none"), seeds=2),
    Scene("flakes of little spread", (sun("Sun", 55, 95),), width=0.06, seeds=8,
          paint=dataclasses.replace(SILVER, diffraction="none", flake_spread=0.001, tilt=0.05)),
    Scene("two suns in one another", (sun("Sun", 60, 110, 0.53), sun("Sun two", 60.1, 110, 0.53)),
          seeds=2),
    Scene("three suns in a row", (sun("Sun A", 60, 110, 0.3), sun("Sun B", 60.3, 110, 0.3),
          sun("Sun C", 60.6, 110, 0.3))),
    Scene("a group between two suns", (sun("Sun A", 60, 110, 0.1), sun("Sun B", 60.2, 110, 0.2),
          sun("Sun C", 59.75, 110, 0.1), sun("Sun D", 62, 110, 0.1)), seeds=2),
    Scene("a sun below the horizon", (SUN, sun("Under", -20, 40, 0.53)), seeds=2),
    Scene("eight lights", tuple(sun(f"Sun {i}", 45 + 4 * i, 60 + 14 * i, 0.1 * i)
          for i in range(8)), shape="sphere", scale=(0.2, 0.2, 0.2), width=0.3, seeds=2),
    Scene("GGX flakes", (SUN,), shape="sphere", width=1, distance=5, scale=(0.5, 0.5, 0.5),
          paint=dataclasses.replace(CANDY, orientation="ggx", tilt=0.3)),
    Scene("Beckmann flakes", (SUN,), shape="sphere", width=1, distance=5, scale=(0.5, 0.5, 0.5),
          paint=dataclasses.replace(SILVER, orientation="beckmann", tilt=0.3)),
    Scene("wide tilt, no refraction", (SUN,), shape="sphere", width=1, distance=5,
          paint=dataclasses.replace(SILVER, tilt=0.6, binder_ior=1.0), scale=(0.5, 0.5, 0.5)),
    Scene("pixels smaller than a flake", (sun("Sun", 60, 110, 4),), width=0.01, distance=0.3,
          paint=dataclasses.replace(SILVER, flake_diameter_um=90, flakes_per_mm2=150), seeds=4),
    Scene("a lamp wider than the tilt", (lamp("Point", "POINT", (-0.2, 0.5, 0.7), 0.12),),
          width=0.5, paint=dataclasses.replace(SILVER, tilt=0.04), seeds=2),
    Scene("a sun wider than GGX flakes' tilt", (sun("Sun", 55, 90, 12),), width=0.5, seeds=2,
          paint=dataclasses.replace(CANDY, orientation="ggx", tilt=0.03)),
    Scene("more sparkles than a pixel has places for", (sun("Sun", 55, 95, 8),), width=0.006,
          distance=0.3, paint=dataclasses.replace(SILVER, flake_diameter_um=90, tilt=0.02,
          flakes_per_mm2=600, flake_transmission=(0.05, 0.05, 0.05),
          flake_edge_color=(0.94, 0.94, 0.94)), seeds=4),
    Scene("three species of flakes", (SUN,), shape="sphere", distance=1, width=0.3,
          scale=(0.15, 0.15, 0.15), paint=THREE, seeds=4),
    Scene("pearls over a textured white", (SUN,), shape="sphere", distance=1, width=0.3,
          scale=(0.15, 0.15, 0.15), paint=PEARLS, seeds=2),
    Scene("pearls seen one by one", (sun("Sun", 55, 95, 8),), width=0.003, distance=0.3,
          paint=dataclasses.replace(PEARLS, flake_diameter_um=90, flakes_per_mm2=150), seeds=4),
    Scene("so far that the mean takes over", (SUN,), shape="sphere", distance=1000, width=170,
          scale=(80, 80, 80), paint=dataclasses.replace(THREE, depth_model="thinned")),
    Scene("half the contrast, near and far", (SUN,), shape="sphere", distance=5, width=1,
          scale=(0.5, 0.5, 0.5), paint=dataclasses.replace(THREE, sparkle_contrast=0.5), seeds=4),
    Scene("no contrast", (SUN,), shape="sphere", distance=1, width=0.3, scale=(0.15, 0.15, 0.15),
          paint=dataclasses.replace(CANDY, sparkle_contrast=0)),
    Scene("the demo's car", (sun("Sun", 45, -60, 0.53),
          lamp("Spot", "SPOT", (-3, -6, 5), 0.02, 3000),
          lamp("Point", "POINT", (4, -2, 3), 0.02, 1500)), shape="car",
          rotation=(0, 0, -0.6), distance=10, elevation=20, width=4.6,
          paint=presets.load("deep-blue"), seeds=2),
    Scene("20 cells in a pixel", (SUN,), width=0.06, seeds=8,
          paint=dataclasses.replace(SILVER, cells_per_pixel=20)),
    Scene("unevenly scaled and sheared", (SUN,), shape="sheared", scale=(0.03, 0.01, 0.05),
          rotation=(0.5, -0.3, 1.1), width=0.08, paint=CANDY, seeds=16),
    Scene("instances", (SUN,), shape="instances", scale=BALL, width=0.2, seeds=4),
    Scene("instances that sparkle alike", (SUN,), shape="instances", scale=BALL, width=0.2,
          paint=dataclasses.replace(SILVER, instances="same"), seeds=4),
    Scene("bent, with a rest position", (SUN,), shape="bent", scale=BALL, width=0.08, seeds=8),
    # Of 1, 5 and 15 degrees: sparkling, and partly melted or gone where the tilt is small.
    Scene("a disk", (area("Disk", "DISK", (-0.2, 0.5, 0.7), 5),), width=0.4, seeds=2),
    Scene("a small square, sphere", (area("Square", "SQUARE", (-0.5, 0.4, 0.9), 1),),
          shape="sphere", scale=(0.15, 0.15, 0.15), width=0.3, seeds=2),
    Scene("a wide disk over flakes of wide tilt", (area("Disk", "DISK", (-0.2, 0.5, 0.7), 15),),
          width=0.5, paint=dataclasses.replace(CANDY, tilt=0.3), seeds=2),
    Scene("a rectangle that melts", (area("Rectangle", "RECTANGLE", (-0.2, 0.5, 0.7), 12, 2),),
          width=0.6, paint=dataclasses.replace(SILVER, tilt=0.06), seeds=2),
    Scene("an ellipse near a sun", (area("Ellipse", "ELLIPSE", (-0.3, 0.5, 0.7), 8, 1.5),
          sun("Sun", 45, 110, 0.53)), width=0.5, seeds=2),
    Scene("a lamp that looks too wide", (area("Softbox", "SQUARE", (-0.2, 0.4, 0.6), 15),),
          width=1.2, paint=dataclasses.replace(THREE, tilt=0.12), seeds=2),
    Scene("a sky's sun", (sky(50, 110),), width=0.2, seeds=4),
    # Its cone has one width, so that dim pixels would fall below Cycles' least weight from afar.
    Scene("a sky's sun, sphere", (sky(50, 110, 2),), shape="sphere", scale=BALL, width=0.08,
          seeds=8),
)  # fmt: skip
# What the pixel anchor cannot show: it counts pixels of the picture, which these cameras bend.
_PANORAMAS = (
    Scene("fisheye", (SUN,), panorama="FISHEYE_EQUIDISTANT", distance=0.05, width=0.3, seeds=2),
    Scene("equirectangular", (SUN,), panorama="EQUIRECTANGULAR", distance=0.05, width=0.3,
          seeds=2),
    Scene("mirror ball", (SUN,), panorama="MIRRORBALL", distance=0.05, width=0.3, seeds=2),
)  # fmt: skip


def _by_pixels(spec: Scene) -> Scene:
    paint = dataclasses.replace(spec.paint, anchor="pixel")
    return dataclasses.replace(spec, name=f"{spec.name}, by pixels", paint=paint)


# Every scene with Anchor surface, every third by pixels too.
SCENES = (*_SCENES, *_PANORAMAS, *map(_by_pixels, _SCENES[2::3]))


def _add_car(scene: bpy.types.Scene) -> None:
    """The painted body of ./paint demo alone, about the origin, as the active object."""
    body = demo_model.build_car(scene)
    for item in scene.objects:
        item.hide_render = item != body
    body.location.z = -0.65
    bpy.context.view_layer.objects.active = body


def _add_sheared() -> None:
    """A sphere whose parent's uneven scale is turned against its own."""
    bpy.ops.object.empty_add()
    parent = bpy.context.object
    parent.scale, parent.rotation_euler = (1, 0.6, 0.8), (0.2, 0.4, 0)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48)
    bpy.context.object.parent = parent


def _add_instances(scene: bpy.types.Scene) -> None:
    """A sphere, and three of it by instances of its collection; also under another name."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24)
    sphere = bpy.context.object
    collection = bpy.data.collections.new("Instanced")
    collection.objects.link(sphere)
    for x, y, turn in ((-0.07, 0, 0), (0.07, 0, 1), (0, 0.07, 2)):
        empty = bpy.data.objects.new("Instancer", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location, empty.rotation_euler = (x, y, 0), (0, 0, turn)
        scene.collection.objects.link(empty)


def _add_bent() -> None:
    """A sphere that a shape key bends, with its rest position."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48)
    sphere = bpy.context.object
    sphere.shape_key_add(name="Basis")
    key = sphere.shape_key_add(name="Bent")
    for point in key.data:
        x, y, z = point.co
        point.co = (x + 0.5 * z * z, y * (1 + 0.4 * z), z + 0.3 * x * y)
    key.value = 1


def build(scene: bpy.types.Scene, spec: Scene, size: int) -> bpy.types.Object:
    """Fills the empty scene; pictures have size x size pixels. Returns the painted object."""
    material.set_up_cycles(scene)
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    add = {
        "car": lambda: _add_car(scene),
        "plane": lambda: bpy.ops.mesh.primitive_plane_add(size=4 * spec.width),
        "sphere": lambda: bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48),
        "monkey": lambda: bpy.ops.mesh.primitive_monkey_add(),
        "sheared": _add_sheared,
        "instances": lambda: _add_instances(scene),
        "bent": _add_bent,
    }
    add[spec.shape]()
    item = bpy.context.object
    for polygon in item.data.polygons:
        polygon.use_smooth = spec.shape != "plane"
    item.scale, item.rotation_euler = spec.scale, spec.rotation
    material.assign(item, material.create(spec.paint))
    rest_position.give(scene)
    for add_lamp in spec.lamps:
        add_lamp(scene)

    data = bpy.data.cameras.new("Camera")
    camera = bpy.data.objects.new("Camera", data)
    e = math.radians(spec.elevation)
    camera.location = Vector((0.1, -math.cos(e), math.sin(e))).normalized() * spec.distance
    camera.rotation_euler = camera.location.to_track_quat("Z", "Y").to_euler()
    data.clip_start, data.clip_end = spec.distance / 100, spec.distance * 100
    if spec.panorama:
        data.type, data.panorama_type = "PANO", spec.panorama
        data.fisheye_fov = math.radians(120)
    elif spec.orthographic:
        data.type, data.ortho_scale = "ORTHO", spec.width
    else:
        data.angle = 2 * math.atan(spec.width / 2 / spec.distance)
    scene.collection.objects.link(camera)
    scene.camera = camera
    lights.fill(scene)
    return item
