# SPDX-License-Identifier: Apache-2.0
"""What ./paint motion films: a painted thing under a sun, in one material after the other.

Metres, in true size. There is no light but the sun's, and it is sampled alone: what differs between
two renders is where their samples lie in the pixels.
"""

from __future__ import annotations

import dataclasses
import math

import bpy
import numpy as np
from mathutils import Vector
from metallic_paint import verify
from metallic_paint.paint import Paint, material, presets
from metallic_paint.scene import lights

MEAN = "mean"  # the paint without sparkles, its closed form, beside MATERIALS

PAINT = presets.load("silver-coarse")
PIXEL = 1e-4  # of the surface, across the view
TOWARDS_SUN = Vector((-0.2, 0.5, 0.9)).normalized()
SUN_ANGLE = math.radians(0.53)
ELEVATION = math.radians(50)  # of the camera
TOWARDS_CAMERA = Vector((0, -math.cos(ELEVATION), math.sin(ELEVATION)))
RIGHT = Vector((1, 0, 0))  # of the picture
UP = TOWARDS_CAMERA.cross(RIGHT)
BEHIND_CAMERA = (TOWARDS_CAMERA + 0.3 * UP).normalized()  # another place of the sun
AWAY = 1.0  # of the orthographic camera


class Stage:
    """An empty picture of size x size pixels; the scene's things are added to it."""

    def __init__(self, size: int, paint: Paint = PAINT, sun_angle: float = SUN_ANGLE) -> None:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.paint, self.size = paint, size
        self.scene = scene = bpy.context.scene
        material.set_up_cycles(scene)
        verify.make_noiseless(scene)
        scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", 1.5
        scene.render.use_persistent_data = True  # the paint stays compiled
        scene.render.resolution_x = scene.render.resolution_y = size
        scene.render.resolution_percentage = 100
        self.thing: bpy.types.Object

        data = bpy.data.lights.new("Sun", "SUN")
        data.energy, data.angle = 3.0, sun_angle
        data.cycles.use_multiple_importance_sampling = False
        self.sun = self._add("Sun", data)
        self.turn_sun(TOWARDS_SUN)

        data = bpy.data.cameras.new("Camera")
        data.type, data.ortho_scale = "ORTHO", size * PIXEL
        self.camera = scene.camera = self._add("Camera", data)
        self.camera.location = AWAY * TOWARDS_CAMERA
        self.camera.rotation_euler = TOWARDS_CAMERA.to_track_quat("Z", "Y").to_euler()

    def _add(self, name: str, data: bpy.types.ID) -> bpy.types.Object:
        thing = bpy.data.objects.new(name, data)
        self.scene.collection.objects.link(thing)
        return thing

    def add_plane(self, size: float) -> None:
        bpy.ops.mesh.primitive_plane_add(size=size)
        self.thing = bpy.context.object

    def add_ball(self, radius: float, at: Vector) -> None:
        bpy.ops.mesh.primitive_uv_sphere_add(
            segments=192, ring_count=96, radius=radius, location=at
        )
        self.thing = bpy.context.object
        self.thing.data.shade_smooth()

    def look_through_lens(self, angle: float) -> None:
        data = self.camera.data
        data.type, data.angle = "PERSP", angle
        data.clip_start, data.clip_end = 0.01, 1000

    def look_around(self, width: int, below: float) -> None:
        """Equirectangular, over the thing's origin, so near that pixels are PIXEL large.

        The picture is the square of a panorama `width` wide that begins so far below the horizon,
        towards the sun's mirror image.
        """
        data, render = self.camera.data, self.scene.render
        data.type = "PANO"
        owner = data if hasattr(data, "panorama_type") else data.cycles  # Blender 5, 4.5
        owner.panorama_type = "EQUIRECTANGULAR"
        data.clip_start = PIXEL
        self.camera.location = (0, 0, PIXEL * width / (2 * math.pi))
        azimuth = math.atan2(TOWARDS_SUN.y, TOWARDS_SUN.x)
        self.camera.rotation_euler = (math.pi / 2, 0, azimuth - math.pi / 2)
        render.resolution_x, render.resolution_y = width, width // 2
        render.use_border = render.use_crop_to_border = True
        half = self.size / 2 / width
        top = 0.5 - below / math.pi
        render.border_min_x, render.border_max_x = 0.5 - half, 0.5 + half
        render.border_min_y, render.border_max_y = top - 4 * half, top

    def turn_sun(self, towards: Vector) -> None:
        self.sun.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()

    def set_sky(self, radiance: float) -> None:
        """From everywhere; the camera does not see it."""
        world = bpy.data.worlds.new("Sky")
        if world.node_tree is None:
            world.use_nodes = True  # Blender 4.5
        self.scene.world = world
        world.node_tree.nodes["Background"].inputs["Color"].default_value = [radiance] * 3 + [1]

    def put_on(self, name: str) -> None:
        """One of MATERIALS, or MEAN."""
        if name == "Voronoi":
            made = voronoi(self.paint)
        else:
            changed = {"sparkle_contrast": 0} if name == MEAN else {"anchor": name}
            made = material.create(dataclasses.replace(self.paint, **changed))
        self.wear(made)

    def wear(self, made: bpy.types.Material) -> None:
        material.assign(self.thing, made)
        lights.fill(self.scene)

    def picture(self, samples: int, seed: int = 0) -> np.ndarray:
        """(height, width, 3), linear, row 0 at the bottom."""
        self.scene.cycles.samples, self.scene.cycles.seed = samples, seed
        return verify.render(self.scene)

    def shoot(self, samples: int, seed: int = 0) -> np.ndarray:
        """(height, width): the mean of the colours."""
        return self.picture(samples, seed).mean(axis=-1, dtype=float)


def voronoi(paint: Paint) -> bpy.types.Material:
    """The usual flakes of nodes: the cells of a Voronoi texture turn the normal of a metal.

    They have the paint's number, and its tilt as the binder shows it, eta times as wide. Of a
    Poisson-Voronoi tessellation with s^3 cells in a volume a plane cuts 1.458 s^2 in an area (Okabe
    et al., Spatial Tessellations, 2000). The colour's channels are even in [0, 1]: their standard
    deviation is 1/sqrt(12).
    """
    made = bpy.data.materials.new("Voronoi flakes")
    if made.node_tree is None:
        made.use_nodes = True  # Blender 4.5
    nodes, links = made.node_tree.nodes, made.node_tree.links
    place, cells, normal = (
        nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "TexVoronoi", "NewGeometry")
    )
    tilted, added, unit = (nodes.new("ShaderNodeVectorMath") for _ in range(3))
    metal = nodes["Principled BSDF"]
    cells.inputs["Scale"].default_value = math.sqrt(paint.flakes_per_mm2 * 1e6 / 1.458)
    strength = math.sqrt(12) * paint.binder_ior * paint.tilt
    tilted.operation, added.operation, unit.operation = "MULTIPLY_ADD", "ADD", "NORMALIZE"
    tilted.inputs[1].default_value = [strength] * 3
    tilted.inputs[2].default_value = [-strength / 2] * 3
    metal.inputs["Metallic"].default_value = 1
    metal.inputs["Base Color"].default_value = (0.87, 0.88, 0.89, 1)
    # A facet spreads light as the paint's flakes do: alpha, the roughness squared, is in normals.
    metal.inputs["Roughness"].default_value = math.sqrt(paint.binder_ior * cone(paint))
    links.new(place.outputs["Object"], cells.inputs["Vector"])
    links.new(cells.outputs["Color"], tilted.inputs[0])
    links.new(tilted.outputs[0], added.inputs[0])
    links.new(normal.outputs["Normal"], added.inputs[1])
    links.new(added.outputs[0], unit.inputs[0])
    links.new(unit.outputs[0], metal.inputs["Normal"])
    return made


def flake_normal(view: Vector, light: Vector, normal: Vector, eta: float) -> Vector:
    """n_f: of the flake that mirrors the light to the observer, both refracted."""

    def inside(outside: Vector) -> Vector:
        cosine = outside.dot(normal)
        return (outside - cosine * normal) / eta + normal * math.sqrt(
            1 - (1 - cosine * cosine) / eta**2
        )

    return (inside(view) + inside(light)).normalized()


def cone(paint: Paint) -> float:
    """Radius of the cone of normals that sparkle, rad, without what the sun's size adds.

    sin^2(rho/2) = (Delta^2 + epsilon^2)/(16 cos(alpha)) of core/expected_sparkles.h with Delta = 0
    and the flake met head on; epsilon with diffraction, core/layer.h.
    """
    edge = 0.35 / (paint.binder_ior * paint.flake_diameter_um)
    return math.hypot(paint.flake_spread, edge) / 2


def cones_turned(
    normal: Vector, before: tuple[Vector, Vector], after: tuple[Vector, Vector]
) -> float:
    """How far n_f turns, in cones, where view and light change."""
    turned = [flake_normal(*each, normal, PAINT.binder_ior) for each in (before, after)]
    return (turned[0] - turned[1]).length / cone(PAINT)
