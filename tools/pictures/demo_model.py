# SPDX-License-Identifier: Apache-2.0
"""The demo subject, a small coupé of the sixties in curves that show paint, and its studio.

The body is the zero set of one smooth function of space, solid(): super-elliptic sections along
splines, blended by a soft minimum, the wheel arches cut by a soft maximum. A grid finds the faces;
then each vertex is moved onto the surface exactly and given the exact normal, so reflections are
as smooth as the function. Glass, lamps and trim are outlines projected onto the same function.

Metres; the nose points to +X, the left side to +Y, the ground is z = 0.
"""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Vector
from numpy.typing import NDArray

Array = NDArray[np.float64]

HALF_LENGTH = 2.08
AXLES = (1.27, -1.16)  # x of the front and rear wheels
WHEEL_RADIUS = 0.315
TRACK = 0.70  # y of a wheel's middle
ARCH_RADIUS = 0.365
ROOF = (0.45, 0.70, 0.93, 1.09, 1.20, 1.26, 1.27, 1.15, 0.80, 0.45)  # heights, rear to front
CELL = 0.013  # of the grid that finds the body's faces


# ---- The body as a function of space: negative inside, about the distance in metres ----


def spline(x: Array, first: float, last: float, controls: Sequence[float]) -> Array:
    """The uniform cubic B-spline with these controls at even steps of x: no wiggles, C2."""
    c = np.array([2 * controls[0] - controls[1], *controls, 2 * controls[-1] - controls[-2]])
    u = np.clip((x - first) / (last - first), 0, 1) * (len(controls) - 1)
    i = np.minimum(u.astype(int), len(controls) - 2)
    t = u - i
    return (
        c[i] * (1 - t) ** 3
        + c[i + 1] * (3 * t**3 - 6 * t**2 + 4)
        + c[i + 2] * (1 + 3 * (t + t**2 - t**3))
        + c[i + 3] * t**3
    ) / 6


def norm(p: float, *terms: Array) -> Array:
    """The p-norm, whose unit ball is a super-ellipsoid."""
    return sum(np.abs(t) ** p for t in terms) ** (1 / p)


def union(a: Array, b: Array, k: float) -> Array:
    """The smooth minimum; k is about the radius of the fillet."""
    return np.minimum(a, b) - k * np.log1p(np.exp(-np.abs(a - b) / k))


def solid(x: Array, y: Array, z: Array) -> Array:
    """The car's body with its greenhouse."""
    y = np.sqrt(y * y + 1e-4)  # |y| without its kink
    # Hull: from sill to waist.
    half_width = spline(x, -2.1, 2.1, (0.66, 0.76, 0.80, 0.79, 0.79, 0.80, 0.76, 0.66))
    top = spline(x, -2.1, 2.1, (0.62, 0.80, 0.89, 0.91, 0.91, 0.86, 0.76, 0.62))
    middle = 0.50
    height = np.where(z > middle, top - middle, 0.38)
    section = norm(2.5, y / half_width, (z - middle) / height)
    body = 0.5 * (norm(4.5, section, x / HALF_LENGTH) - 1)
    # Fenders: the front ones carry the head lamps.
    behind = np.where(x > 1.15, 0.83, 1.5)
    front = norm(2.4, (x - 1.15) / behind, (y - 0.59) / 0.19, (z - 0.54) / 0.28)
    rear = norm(2.4, (x + 1.12) / 0.95, (y - 0.58) / 0.25, (z - 0.56) / 0.27)
    body = union(body, 0.2 * (front - 1), 0.03)
    body = union(body, 0.2 * (rear - 1), 0.04)
    # Greenhouse: a fastback.
    roof = spline(x, -2.2, 1.2, ROOF)
    half_width = spline(x, -2.2, 1.2, (0.36, 0.50, 0.58, 0.64, 0.67, 0.68, 0.67, 0.65, 0.62, 0.55))
    house = norm(2.7, y / half_width, (z - 0.55) / np.maximum(roof - 0.55, 0.01))
    house = norm(8, house, (x + 0.45) / 1.6)
    body = union(body, 0.35 * (house - 1), 0.02)
    # Floor and wheel arches with their lips.
    body = -union(-body, z - 0.19, 0.012)
    for axle in AXLES:
        r = np.hypot(x - axle, z - WHEEL_RADIUS)
        body = body - 0.018 * np.exp(-(((r - ARCH_RADIUS) / 0.05) ** 2))
        well = -union(ARCH_RADIUS - r, y - 0.48, 0.01)
        body = -union(-body, well, 0.006)
    return body


def gradient(p: Array) -> tuple[Array, Array]:
    """Value and gradient of solid() at points (n, 3), from the corners of a tetrahedron."""
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
    h = 1e-4
    values = np.array([solid(*(p + h * c).T) for c in corners])
    return values.mean(0), values.T @ corners / (4 * h)


def unit(v: Array) -> Array:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def body_mesh() -> tuple[Array, Array]:
    """Vertices and quads of solid()'s surface: surface nets, relaxed along the surface."""
    ny = int(0.95 / CELL)
    axes = (
        np.arange(-2.2, 2.2, CELL),
        np.arange(-ny, ny + 1) * CELL,
        np.arange(0.1, 1.4, CELL),
    )
    half = solid(axes[0][:, None, None], axes[1][None, ny:, None], axes[2][None, None, :])
    inside = np.concatenate([half[:, :0:-1], half], axis=1) < 0

    # One vertex in each cell that has corners on both sides.
    count = sum(
        inside[i : i - 1 or None, j : j - 1 or None, k : k - 1 or None].astype(np.int8)
        for i in (0, 1)
        for j in (0, 1)
        for k in (0, 1)
    )
    mixed = (count > 0) & (count < 8)
    index = np.full(mixed.shape, -1)
    index[mixed] = np.arange(mixed.sum())
    points = np.stack([a[i] for a, i in zip(axes, np.nonzero(mixed), strict=True)], 1) + CELL / 2

    # One quad across each grid edge whose ends differ.
    quads = []
    for axis in range(3):
        s = np.moveaxis(inside, axis, 0)
        n = np.moveaxis(index, axis, 0)
        i, j, k = np.nonzero(s[1:] != s[:-1])
        quad = np.stack([n[i, j - 1, k - 1], n[i, j, k - 1], n[i, j, k], n[i, j - 1, k]], 1)
        flip = s[i, j, k] ^ (axis == 1)
        quad[~flip] = quad[~flip, ::-1]
        quads.append(quad)
    faces = np.concatenate(quads)

    for step in range(5):
        if step:
            total = np.zeros_like(points)
            for a in range(4):
                for d in range(3):
                    total[:, d] += np.bincount(
                        faces[:, a],
                        points[faces[:, a - 1], d] + points[faces[:, a - 3], d],
                        len(points),
                    )
            points = total / (2 * np.bincount(faces.ravel(), minlength=len(points))[:, None])
        for _ in range(2):
            value, g = gradient(points)
            points = points - (value / (g * g).sum(1))[:, None] * g
    return points, faces


# ---- The car ----


def build_car(scene: bpy.types.Scene) -> bpy.types.Object:
    """Adds the car, 4.2 m long, with glass, lamps and wheels; returns the body, unpainted."""
    points, faces = body_mesh()
    body = add_mesh(scene, "Body", points, faces, None)
    body.data.normals_split_custom_set_from_vertices(unit(gradient(points)[1]))
    glass = plain_material("Glass", (0.012, 0.013, 0.015), roughness=0.03)
    lamp = plain_material("Lamp", (0.45, 0.45, 0.44), roughness=0.1, metallic=0.6)
    rubber = plain_material("Rubber", (0.015, 0.015, 0.015), roughness=0.7)
    chrome = plain_material("Chrome", (0.8, 0.8, 0.8), roughness=0.12, metallic=1)
    for side in (1, -1):
        add_window(scene, glass, side, 0.10, 0.40)
        add_window(scene, glass, side, -0.76, 0.36)
        add_patch(scene, "Head lamp", lamp, (side * 0.60, 0.575), (0.085, 0.085), 2, 1.75, 2.3)
        add_patch(scene, "Tail lamp", lamp, (side * 0.55, 0.60), (0.10, 0.035), 3, -1.7, -2.3)
        for axle in AXLES:
            add_wheel(scene, Vector((axle, side * TRACK, WHEEL_RADIUS)), rubber, chrome)
    add_patch(scene, "Windscreen", glass, (0, 1.045), (0.52, 0.115), 4, 0, 2.3)
    add_patch(scene, "Rear window", glass, (0, 1.00), (0.40, 0.10), 4, 0, -2.3)
    return body


def add_mesh(
    scene: bpy.types.Scene,
    name: str,
    points: Array,
    faces: Array,
    surface: bpy.types.Material | None,
) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), bool))
    mesh.update()
    if surface:
        mesh.materials.append(surface)
    item = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(item)
    return item


def add_projected(
    scene: bpy.types.Scene, name: str, surface: bpy.types.Material, grid: Array, axis: int,
    near: float, far: float,
) -> None:  # fmt: skip
    """A grid of points (n, m, 3), moved along an axis onto the body, 3 mm proud of it.

    The surface is sought from near, a point within, to far, one without.
    """
    points = grid.reshape(-1, 3)
    inside, outside = np.full(len(points), near), np.full(len(points), far)
    for _ in range(40):
        points[:, axis] = (inside + outside) / 2
        within = solid(*points.T) < 0
        inside = np.where(within, points[:, axis], inside)
        outside = np.where(within, outside, points[:, axis])
    points = points + 0.003 * unit(gradient(points)[1])
    n, m = grid.shape[:2]
    i = np.arange(n * m).reshape(n, m)
    quads = np.stack([i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]], -1).reshape(-1, 4)
    add_mesh(scene, name, points, quads, surface)


def rounded(n: int, power: float) -> tuple[Array, Array]:
    """A grid over the super-ellipse |s|^p + |t|^p <= 1, denser where its outline is steep."""
    s = np.sin(np.linspace(-1, 1, n) * np.pi / 2)
    s, t = np.meshgrid(s, np.linspace(-1, 1, n // 2), indexing="ij")
    return s, t * (1 - np.abs(s) ** power) ** (1 / power)


def add_patch(
    scene: bpy.types.Scene,
    name: str,
    surface: bpy.types.Material,
    centre: tuple[float, float],
    radii: tuple[float, float],
    power: float,
    near: float,
    far: float,
) -> None:
    """A rounded patch seen from the front or the rear: centre and radii in y and z."""
    s, t = rounded(60, power)
    grid = np.stack([0 * s, centre[0] + radii[0] * s, centre[1] + radii[1] * t], -1)
    add_projected(scene, name, surface, grid, 0, near, far)


def add_window(
    scene: bpy.types.Scene, glass: bpy.types.Material, side: int, middle: float, half: float
) -> None:
    """A side window between the waist and the roof's line."""
    s, t = rounded(60, 5)
    x = middle + half * s
    roof = spline(x, -2.2, 1.2, ROOF) - 0.085
    waist = 0.955
    grid = np.stack([x, 0 * x, (roof + waist) / 2 + t * (roof - waist) / 2], -1)
    add_projected(scene, "Window", glass, grid, 1, 0, side * 1.2)


def add_wheel(
    scene: bpy.types.Scene, centre: Vector, rubber: bpy.types.Material, chrome: bpy.types.Material
) -> None:
    upright = (np.pi / 2, 0, 0)
    bpy.ops.mesh.primitive_torus_add(
        location=centre, rotation=upright, major_radius=WHEEL_RADIUS - 0.075, minor_radius=0.075,
        major_segments=96, minor_segments=32,
    )  # fmt: skip
    tyre = bpy.context.object
    bpy.ops.mesh.primitive_uv_sphere_add(
        segments=64, ring_count=32, radius=1, location=centre, rotation=upright
    )
    hub = bpy.context.object
    hub.scale = (0.18, 0.18, 0.07)
    for item, surface in ((tyre, rubber), (hub, chrome)):
        item.data.polygons.foreach_set("use_smooth", np.ones(len(item.data.polygons), bool))
        item.data.materials.append(surface)


def plain_material(
    name: str, colour: tuple[float, float, float], roughness: float, metallic: float = 0
) -> bpy.types.Material:
    surface = bpy.data.materials.new(name)
    if surface.node_tree is None:
        surface.use_nodes = True  # Blender 4.5
    shader = surface.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1)
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Metallic"].default_value = metallic
    return surface


# ---- The studio ----


def build_scene(scene: bpy.types.Scene, subject: bpy.types.Object) -> None:
    """Puts a floor, a camera, a sun, a spot, a point light and a dim world around the subject.

    Everything is measured from the subject's bounding box. Exposed for the Standard view.
    """
    bpy.context.view_layer.update()
    corners = world_box(subject)
    low, high = corners.min(0), corners.max(0)
    lowest = min(world_box(item)[:, 2].min() for item in scene.objects if item.type == "MESH")
    centre, radius = Vector((low + high) / 2), float(np.linalg.norm(high - low)) / 2

    bpy.ops.mesh.primitive_circle_add(
        vertices=128, radius=40 * radius, fill_type="NGON",
        location=(centre.x, centre.y, lowest),
    )  # fmt: skip
    bpy.context.object.name = "Floor"
    bpy.context.object.data.materials.append(
        plain_material("Floor", (0.10, 0.10, 0.105), roughness=0.45)
    )
    add_camera(scene, centre, radius, corners)
    irradiance = 3.0  # W/m² on the subject, from each
    add_light(scene, "Sun", centre, radius, (0.62, -0.95, 1.1), irradiance)
    add_light(scene, "Spot", centre, radius, (-0.8, -1.7, 1.5), irradiance)
    add_light(scene, "Point", centre, radius, (1.7, 0.35, 1.0), 0.7 * irradiance)
    world = bpy.data.worlds.new("Studio")
    if world.node_tree is None:
        world.use_nodes = True  # Blender 4.5
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.05, 0.052, 0.056, 1)
    scene.world = world


def world_box(item: bpy.types.Object) -> Array:
    """The corners (8, 3) of the object's bounding box in the world."""
    return np.array([item.matrix_world @ Vector(corner) for corner in item.bound_box])


def add_camera(scene: bpy.types.Scene, centre: Vector, radius: float, corners: Array) -> None:
    """A three-quarter view from which the box fills the picture."""
    data = bpy.data.cameras.new("Camera")
    data.lens = 70
    camera = bpy.data.objects.new("Camera", data)
    scene.collection.objects.link(camera)
    scene.camera = camera
    towards = Vector((0.78, -0.95, 0.42)).normalized()
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
    # Each corner asks for a distance at which it lies within 90 % of the picture.
    distance = max(float((np.abs(local[:, :2]) / (0.9 * half) + local[:, 2:]).max()), radius)
    camera.location = centre + distance * towards
    data.clip_start, data.clip_end = distance / 1000, distance * 1000


def add_light(
    scene: bpy.types.Scene,
    kind: str,
    centre: Vector,
    radius: float,
    offset: tuple[float, float, float],
    irradiance: float,
) -> None:
    """A lamp that lights the subject's middle with that irradiance from an offset in its radii."""
    data = bpy.data.lights.new(kind, kind.upper())
    away = Vector(offset) * radius
    if kind == "Sun":
        data.energy, data.angle = irradiance, np.radians(0.53)
    else:
        data.energy = irradiance * 4 * np.pi * away.length_squared
        data.shadow_soft_size = 0.006 * radius
    if kind == "Spot":
        data.spot_size, data.spot_blend = np.radians(50), 0.5
    item = bpy.data.objects.new(kind, data)
    item.location = centre + away
    item.rotation_euler = away.to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(item)
