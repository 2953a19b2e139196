# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the camera sees a painted object, and how large its pixels are there.

A ray at the object alone is quick. A ray through the scene, which finds out what stands before it,
takes the longer the more objects there are: so many are cast as there is time for, and each other
ray shares the fate of the nearest of these.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree
from mathutils.interpolate import poly_3d_calc

from . import placed

_RAYS = 40  # along each side of an object's box in the picture, at most
_FEWEST_RAYS = 10
_ALL_RAYS = 6400  # of a report, at the objects alone
_VISITS = 250_000  # of objects, by a report's rays through the scene: about a quarter of a second
_FEWEST_TESTS = 8  # rays through the scene for one object
_THROUGH = 16  # surfaces that a ray may pass
POLYGONAL = ("MESH", "CURVE", "SURFACE", "FONT", "META")
_CLEAR = ("BSDF_TRANSPARENT", "HOLDOUT")  # nodes by which light passes a material


class SightError(ValueError):
    """Why nothing can be said of what the camera sees, in a sentence."""


@dataclass(frozen=True)
class Seen:
    """Where the camera sees a painted object: n rays that meet it, and the share of those cast."""

    position: np.ndarray  # (n, 3) scene units
    normal: np.ndarray  # (n, 3), towards the camera's side
    view: np.ndarray  # (n, 3), unit, towards the camera
    footprint: np.ndarray  # (n,), of a pixel on the surface, m² of the real object
    raster: np.ndarray  # (n, 2), where in the frame, in pixels from its lower left corner
    pixels: float  # of the frame that show the object


@dataclass(frozen=True)
class Effort:
    """How much a look may cost, as all looks of a report share its rays."""

    objects: int  # that may be looked at
    rays: int  # at each, along each side of its box in the picture
    tests: int  # of these, through the scene


def effort_for(surfaces: int, objects: int) -> Effort:
    """For so many painted surfaces in a scene of so many objects."""
    tests = _VISITS // max(objects, 1)
    most = min(surfaces, _ALL_RAYS // _FEWEST_RAYS**2, tests // _FEWEST_TESTS)
    share = max(most, 1)
    return Effort(share, min(_RAYS, math.isqrt(_ALL_RAYS // share)), max(tests // share, 1))


@dataclass(frozen=True)
class Camera:
    """How the scene's camera makes its picture; places in it are in 0..1."""

    matrix: Matrix  # unscaled, to the world
    low: Vector  # corners of its frame
    high: Vector
    orthographic: bool
    resolution: np.ndarray
    pixel: float  # area of one in the frame, scene units²
    clip: tuple[float, float]  # its start and end

    @staticmethod
    def of(scene: bpy.types.Scene) -> Camera:
        """Raises SightError, in a sentence, for a camera that this cannot look through."""
        camera = scene.camera
        if camera is None or camera.type != "CAMERA":
            raise SightError("without a camera nothing can be said of its pixels.")
        if camera.data.type not in ("PERSP", "ORTHO"):
            raise SightError(f"nothing can be said of the pixels of a {camera.data.type} camera.")
        at, turned, _ = camera.matrix_world.decompose()
        frame = camera.data.view_frame(scene=scene)
        low, high = (Vector([end(axis) for axis in zip(*frame, strict=True)]) for end in (min, max))
        render = scene.render
        resolution = np.array([render.resolution_x, render.resolution_y])
        resolution = resolution * render.resolution_percentage / 100
        return Camera(
            matrix=Matrix.Translation(at) @ turned.to_matrix().to_4x4(),
            low=low,
            high=high,
            orthographic=camera.data.type == "ORTHO",
            resolution=resolution,
            pixel=float(np.prod([(high[i] - low[i]) / resolution[i] for i in (0, 1)])),
            clip=(camera.data.clip_start, camera.data.clip_end),
        )

    def box(self, thing: bpy.types.Object) -> tuple[float, float, float, float] | None:
        """Left, bottom, right, top of the object's box in the picture; None outside."""
        low, high = self.low, self.high
        to_camera = self.matrix.inverted() @ thing.matrix_world
        corners = [to_camera @ Vector(corner) for corner in thing.bound_box]
        if all(corner.z >= 0 for corner in corners):
            return None
        if not self.orthographic and any(corner.z >= -1e-6 for corner in corners):
            return 0, 0, 1, 1  # the camera stands in the box
        scales = [1 if self.orthographic else low.z / corner.z for corner in corners]
        left, right, bottom, top = (
            end((corner[i] * scale - low[i]) / (high[i] - low[i])
                for corner, scale in zip(corners, scales, strict=True))
            for i in (0, 1) for end in (min, max)
        )  # fmt: skip
        left, bottom, right, top = max(left, 0), max(bottom, 0), min(right, 1), min(top, 1)
        return (left, bottom, right, top) if left < right and bottom < top else None

    def ray(self, x: float, y: float) -> tuple[Vector, Vector]:
        """Origin and direction in the world."""
        low, high = self.low, self.high
        place = Vector((low.x + x * (high.x - low.x), low.y + y * (high.y - low.y), low.z))
        origin = Vector((place.x, place.y, 0)) if self.orthographic else Vector()
        direction = Vector((0, 0, -1)) if self.orthographic else place.normalized()
        return self.matrix @ origin, self.matrix.to_3x3() @ direction

    def pixel_area(self, position: Vector, direction: Vector) -> float:
        """Scene units², of what a pixel sees of a plane across the ray there."""
        depth = 1 if self.orthographic else self.depth(position) / -self.low.z
        return self.pixel * depth**2 * -direction.dot(self.matrix.col[2].xyz)

    def depth(self, position: Vector) -> float:
        """How far it is off along the camera's axis."""
        return (self.matrix.translation - position).dot(self.matrix.col[2].xyz)


@dataclass(frozen=True)
class Room:
    """What a render shows of a view layer, for rays."""

    scene: bpy.types.Scene
    layer: bpy.types.ViewLayer
    unrendered: set[bpy.types.Object]

    @staticmethod
    def of(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> Room:
        return Room(scene, layer, placed.unrendered(layer))

    def surfaces_on(
        self, origin: Vector, direction: Vector, distance: float = 1e9
    ) -> Iterator[tuple[bpy.types.Object, int]]:
        """What a ray meets in turn, so far: the evaluated object and its polygon; 16 at most."""
        end = origin + distance * direction
        for _ in range(_THROUGH):
            left = (end - origin).dot(direction)
            if left <= 0:
                return
            hit, place, _, polygon, found, _ = self.scene.ray_cast(
                self.layer.depsgraph, origin, direction, distance=left
            )
            if not hit:
                return
            if not found.hide_render and found.original not in self.unrendered:
                yield found, polygon
            origin = past(place, direction)


def look(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    thing: bpy.types.Object,
    painted: bpy.types.Material,
    meters_per_unit: float,
    effort: Effort | None = None,
) -> Seen | None:
    """Rays through the object's box in the picture; None if none meets the material there.

    Raises SightError, in a sentence, for a camera or an object that this cannot look through or at.
    """
    layer.update()
    camera = Camera.of(scene)
    effort = effort or effort_for(1, len(layer.depsgraph.object_instances))
    box = camera.box(thing)
    if box is None or not thing.visible_camera:
        return None
    steps = (np.arange(effort.rays) + 0.5) / effort.rays
    places = [(x, y) for x in box[0] + steps * (box[2] - box[0])
              for y in box[1] + steps * (box[3] - box[1])]  # fmt: skip
    rays, hits = [], []
    with _polygons(thing, layer) as polygons:
        for place in places:
            origin, direction = camera.ray(*place)
            hit = polygons.meet(origin, direction, painted)
            if hit is None:
                continue
            position, normal = hit
            if not camera.clip[0] <= camera.depth(position) <= camera.clip[1]:
                continue
            cosine = direction.dot(normal)
            area = camera.pixel_area(position, direction) / max(abs(cosine), 1e-3)
            facing = normal if cosine < 0 else -normal
            raster = place * camera.resolution
            hits.append((*position, *facing, *-direction, area * meters_per_unit**2, *raster))
            rays.append((origin, direction))
    if not hits:
        return None
    table = np.array(hits)
    room = Room.of(scene, layer)
    table = table[_in_sight(room, thing, rays, table[:, 10:], effort.tests)]
    if not len(table) and effort.tests < len(rays):
        raise SightError("the camera sees nothing of it, or little.")
    if not len(table):
        return None
    share = len(table) / len(places) * (box[2] - box[0]) * (box[3] - box[1])
    return Seen(
        position=table[:, :3],
        normal=table[:, 3:6],
        view=table[:, 6:9],
        footprint=table[:, 9],
        raster=table[:, 10:],
        pixels=float(share * camera.resolution.prod()),
    )


@dataclass(frozen=True)
class _Polygons:
    """An object as it stands evaluated, alone."""

    thing: bpy.types.Object  # evaluated
    mesh: bpy.types.Mesh
    tree: BVHTree | None  # None for a mesh, which Blender has a tree of

    def meet(
        self, origin: Vector, direction: Vector, painted: bpy.types.Material
    ) -> tuple[Vector, Vector] | None:
        """Place and shading normal where the ray meets the material, if that comes first."""
        to_local = self.thing.matrix_world.inverted_safe()
        ray = to_local @ origin, to_local.to_3x3() @ direction
        if self.tree is None:
            hit, place, _, index = self.thing.ray_cast(*ray)
        else:
            place, _, index, _ = self.tree.ray_cast(*ray)
            hit = place is not None
        if not hit:
            return None
        polygon = self.mesh.polygons[index]
        slots = self.thing.material_slots
        found = slots[min(polygon.material_index, len(slots) - 1)].material
        if found is None or found.original != painted:
            return None
        normal = to_local.to_3x3().transposed() @ self._smooth_normal(polygon, place)
        return self.thing.matrix_world @ place, normal.normalized()

    def _smooth_normal(self, polygon: bpy.types.MeshPolygon, place: Vector) -> Vector:
        """Between those of the polygon's corners."""
        corners = [self.mesh.vertices[i].co for i in polygon.vertices]
        weights = poly_3d_calc(corners, place)
        normals = [self.mesh.corner_normals[i].vector for i in polygon.loop_indices]
        return sum((w * n for w, n in zip(weights, normals, strict=True)), Vector())


@contextmanager
def _polygons(thing: bpy.types.Object, layer: bpy.types.ViewLayer) -> Iterator[_Polygons]:
    """Raises SightError, in a sentence, where Blender has none.

    It crashes where a ray is cast at an object that is not a mesh and has none evaluated.
    """
    evaluated = thing.evaluated_get(layer.depsgraph)
    if not thing.visible_get(view_layer=layer) or not evaluated.is_evaluated:
        raise SightError("it is hidden in the viewport, so nothing can be foretold of it.")
    if isinstance(evaluated.data, bpy.types.Mesh):
        yield _Polygons(evaluated, evaluated.data, None)
        return
    if thing.type not in POLYGONAL:
        raise SightError("nothing can be foretold of hair and points.")
    mesh = evaluated.to_mesh()
    try:
        places = [vertex.co for vertex in mesh.vertices]
        polygons = [tuple(polygon.vertices) for polygon in mesh.polygons]
        yield _Polygons(evaluated, mesh, BVHTree.FromPolygons(places, polygons))
    finally:
        evaluated.to_mesh_clear()


def _in_sight(
    room: Room,
    thing: bpy.types.Object,
    rays: list[tuple[Vector, Vector]],
    raster: np.ndarray,
    tests: int,
) -> np.ndarray:
    """(n,) bool: which rays meet nothing before the object; untested, as the nearest tested one."""
    tested = np.sort(np.random.default_rng(0).permutation(len(rays))[:tests])
    free = np.array([_is_free(room, thing, *rays[i]) for i in tested])
    if len(tested) == len(rays):
        return free
    apart = ((raster[:, None] - raster[tested]) ** 2).sum(axis=-1)
    return free[apart.argmin(axis=1)]


def _is_free(room: Room, thing: bpy.types.Object, origin: Vector, direction: Vector) -> bool:
    """Whether the object is the first on the ray that the camera sees."""
    for found, polygon in room.surfaces_on(origin, direction):
        if found.original == thing:
            return True
        if found.visible_camera and not lets_light_pass(found, polygon):
            return False
    return False


def past(place: Vector, direction: Vector) -> Vector:
    """Where a ray goes on behind a surface."""
    return place + 1e-5 * max(place.length, 1) * direction


def lets_light_pass(thing: bpy.types.Object, polygon: int) -> bool:
    """Whether the material there may: what its nodes make of it is not known."""
    slots = thing.material_slots
    if not slots or not isinstance(thing.data, bpy.types.Mesh):
        return False
    polygons = thing.data.polygons
    index = polygons[polygon].material_index if 0 <= polygon < len(polygons) else 0
    found = slots[min(index, len(slots) - 1)].material
    if found is None or found.node_tree is None:
        return False
    for node in found.node_tree.nodes:
        if node.type in _CLEAR:
            return True
        if node.type == "BSDF_PRINCIPLED":
            alpha = node.inputs["Alpha"]
            if alpha.is_linked or alpha.default_value < 1:
                return True
    return False
