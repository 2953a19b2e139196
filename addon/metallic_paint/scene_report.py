# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene's paints compute, what the camera sees of their flakes, and what would spoil them.

Rays from the active camera find where each painted object shows; there the core says how many
flakes and sparkles a pixel has, and how bright one sparkle is.

A ray at the object alone is quick. A ray through the scene, which finds out what stands before it,
takes the longer the more objects there are: so many are cast as there is time for, and each other
ray shares the fate of the nearest of these.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import bpy
import numpy as np
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree
from mathutils.interpolate import poly_3d_calc

from . import denoise, lights, material, needs, operators, verify
from .paint import PARAMETERS, Paint, PaintError, core_paint
from .panel import SubPanel, draw_lines

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import IconItems, OperatorReturnItems

INFO: Final = "INFO"
WARNING: Final = "WARNING"
ERROR: Final = "ERROR"
Line = tuple[str, str]  # level and sentence

_RAYS = 40  # along each side of an object's box in the picture, at most
_FEWEST_RAYS = 10
_ALL_RAYS = 6400  # of a report, at the objects alone
_VISITS = 250_000  # of objects, by a report's rays through the scene: about a quarter of a second
_FEWEST_TESTS = 8  # rays through the scene for one object
_THROUGH = 16  # surfaces that a ray may pass that no render shows
_BRIGHT = 0.9  # quantile of a pixel's sparkles that stands for "where it sparkles most"
_MANY = 100.0  # sparkles a pixel whose sum deviates by a tenth or less
_FEW = 1.0  # in the whole picture
_SMALLEST, _LARGEST = 0.005, 100.0  # metres: sizes of what one paints
_ICONS: dict[str, IconItems] = {INFO: "BLANK1", WARNING: "ERROR", ERROR: "CANCEL"}
_CONTRAST = PARAMETERS["sparkle_contrast"].label
_KEY = "metallic_paint_report"  # custom property of the window manager: not in the file


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
class Expected:
    """What a pixel of a painted object holds, in the median of those that the camera sees."""

    flakes: float
    sparkles: float | None  # of all lights; None without the native module
    most_sparkles: float | None  # where it sparkles most
    in_picture: float | None  # sparkles of all its pixels
    brightness: float | None  # radiance of a pixel that sparkles, W/m²/sr


def report(scene: bpy.types.Scene) -> list[Line]:
    """Sentences about the scene's paints, each with its level: INFO, WARNING or ERROR.

    Fits the paints to the scene, as needs.fit does.
    """
    lines = list(_render_settings(scene))
    fitted = needs.fit(scene)
    for sentence in str(fitted).splitlines():
        lines.append((INFO, sentence[0].upper() + sentence[1:].rstrip(".") + "."))
    if lights.groups() and not fitted.lights.slots:
        lines.append((WARNING, "Nothing sparkles: add a sun, spot or point light that renders."))
    if outdated := denoise.outdated(scene):
        lines.append((WARNING, f"{outdated}."))
    layers = lights.used_layers(scene)
    shown = {thing: layer for layer in layers for thing in lights.rendered(layer)}
    painted = [thing for thing in shown if lights.is_painted(thing)]
    if not painted:
        multiplied = (thing for layer in layers for thing in lights.instanced(layer))
        if any(map(lights.is_painted, multiplied)):
            lines.append((INFO, "Painted only as instances: nothing can be foretold."))
        else:
            lines.append((WARNING, "No object that renders is painted."))
    if sum(map(lights.uses_paint, bpy.data.scenes)) > 1:
        text = (
            "More than one scene uses paints, which have the lights of one at a time: "
            "without this add-on, the scene that was fitted or saved last."
        )
        lines.append((WARNING, text))
    surfaces = [each for thing in painted for each in _surfaces(thing, shown[thing])]
    unknown = {each: each.unknown() for each in surfaces}
    known = [each for each, line in unknown.items() if line is None]
    objects = sum(len(layer.depsgraph.object_instances) for layer in layers)
    effort = _effort(len(known), objects)
    chosen = _largest(scene, known, effort.objects)
    brightest = 0.0
    for each, line in unknown.items():
        if line is not None:
            lines.append(line)
            continue
        found, brightness = _about(scene, each, fitted.lights.slots, effort, each in chosen)
        lines += found
        brightest = max(brightest, brightness)
    if left_out := len(known) - len(chosen):
        sentence = f"Left out, being smaller in the picture: {left_out} more painted surfaces."
        lines.append((INFO, sentence))
    lines += _clamping(scene, brightest, len(fitted.lights.slots) + bool(fitted.other_light))
    if not known or any(_sparkles(each.node) for each in known):
        lines += _denoising(scene)
    return lines


# --- settings ----------------------------------------------------------------------------------


def _render_settings(scene: bpy.types.Scene) -> Iterator[Line]:
    missing = material.missing(scene)
    if scene.render.engine != "CYCLES":
        yield ERROR, missing
        return
    if missing:
        shows = (
            material.has_osl()
            and scene.cycles.shading_system
            and material.gpu(scene) in ("NONE", "OPTIX")
        )
        yield WARNING if shows else ERROR, missing


def _clamping(scene: bpy.types.Scene, brightest: float, sources: int) -> Iterator[Line]:
    """Cycles clamps each sample, and gives one that picks a lamp among others their weight too."""
    if scene.render.engine != "CYCLES":
        return
    direct, indirect = scene.cycles.sample_clamp_direct, scene.cycles.sample_clamp_indirect
    sample = brightest * max(sources, 1)
    if direct > 0 and sample > direct:
        yield (
            WARNING,
            (
                f"Clamp Direct {direct:g} cuts sparkles, of which a sample may bring "
                f"{_number(sample)} W/m²/sr. 0 switches it off."
            ),
        )
    if indirect > 0 and brightest > indirect:
        yield INFO, f"Clamp Indirect {indirect:g} dims sparkles that are seen in other surfaces."


def _denoising(scene: bpy.types.Scene) -> Iterator[Line]:
    if scene.render.engine != "CYCLES":
        return
    if scene.cycles.use_denoising and not denoise.is_set_up(scene):
        label = denoise.SCENE_OT_metallic_paint_denoise.bl_label
        yield WARNING, f"Denoising takes sparkles for noise: “{label}” keeps them."


# --- objects -----------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Surface:
    """A paint on an object that renders."""

    label: str
    layer: bpy.types.ViewLayer
    thing: bpy.types.Object
    painted: bpy.types.Material
    node: bpy.types.ShaderNodeGroup | None  # None within a node group

    def unknown(self) -> Line | None:
        """Why nothing can be foretold of it."""
        if self.node is None:
            within = operators.WITHIN_GROUP.lower()
            return INFO, f"{self.label}: {within}, of which nothing can be foretold."
        if file := material.linked_from(self.node):
            linked = f"the paint is linked from {file} and keeps the lights that it has there."
            return WARNING, f"{self.label}: {linked}"
        try:
            material.paint_of(self.node)
        except PaintError as error:
            return ERROR, f"{self.label}: {error}"
        return None


def _sparkles(node: bpy.types.ShaderNodeGroup) -> bool:
    contrast = node.inputs[_CONTRAST]
    return contrast.is_linked or contrast.default_value > 0


def _surfaces(thing: bpy.types.Object, layer: bpy.types.ViewLayer) -> list[_Surface]:
    slots = dict.fromkeys(slot.material for slot in thing.material_slots if slot.material)
    painted = [each for each in slots if lights.holds_slots(each.node_tree)]
    return [
        _Surface(
            thing.name if len(painted) == 1 else f"{thing.name}, {each.name}",
            layer, thing, each,
            None if material.is_within_group(each) else material.paint_node(each),
        )
        for each in painted
    ]  # fmt: skip


def _largest(scene: bpy.types.Scene, surfaces: list[_Surface], number: int) -> list[_Surface]:
    """Those whose boxes are largest in the picture; without a camera, the first."""
    try:
        camera = _Camera.of(scene)
    except ValueError:
        return surfaces[:number]

    def area(surface: _Surface) -> float:
        left, bottom, right, top = camera.box(surface.thing) or (0, 0, 0, 0)
        return (right - left) * (top - bottom)

    return sorted(surfaces, key=area, reverse=True)[:number]


def _about(
    scene: bpy.types.Scene,
    surface: _Surface,
    lamps: tuple[bpy.types.Object, ...],
    effort: Effort,
    looked_at: bool,
) -> tuple[list[Line], float]:
    """Lines about a painted object, and how bright a pixel of it may sparkle."""
    label, thing, node = surface.label, surface.thing, surface.node
    assert node is not None
    lines: list[Line] = []
    unit = scene.unit_settings.scale_length * node.inputs[material.MODEL_SCALE].default_value
    size = max(thing.dimensions) * unit
    if not _SMALLEST <= size <= _LARGEST:
        lines.append((WARNING, f"{label} is {_length(size)} large: is its Model Scale right?"))
    if not looked_at:
        return lines, 0.0
    try:
        seen = look(scene, surface.layer, thing, surface.painted, unit, effort)
    except ValueError as error:
        return [*lines, (INFO, f"{label}: {error}")], 0.0
    if seen is None:
        return [*lines, (INFO, f"{label}: the camera does not see it.")], 0.0
    expected = _expect(material.paint_of(node), seen, lamps)
    return [*lines, *_judge(label, node, expected)], expected.brightness or 0.0


def _judge(label: str, node: bpy.types.ShaderNodeGroup, expected: Expected) -> Iterator[Line]:
    held = f"{label}: {_number(expected.flakes)} flakes a pixel"
    if not _sparkles(node):
        yield INFO, f"{held}. With {_CONTRAST} 0 they show their mean, no sparkles."
        return
    if expected.sparkles is None:
        yield INFO, f"{held}."
        yield INFO, f"{label}: sparkles cannot be foretold. {verify.core_missing()}"
        return
    yield (
        INFO,
        (
            f"{held}, {_number(expected.sparkles)} sparkles in the middle and "
            f"{_number(expected.most_sparkles)} where there are most."
        ),
    )
    linked = [socket.name for socket in node.inputs if socket.is_linked and socket.type != "VECTOR"]
    if linked:
        yield INFO, f"{label}: the numbers do not follow what is linked to {', '.join(linked)}."
    if expected.most_sparkles > _MANY:
        yield (
            WARNING,
            (
                f"{label}: the sparkles are too many and too small to be seen, they merge into the "
                "mean. Come nearer, render larger, or take fewer and larger flakes."
            ),
        )
    if expected.in_picture < _FEW:
        yield (
            WARNING,
            (
                f"{label}: no sparkle is to be expected in the picture "
                f"({_number(expected.in_picture)} of all its pixels). Turn the object or a lamp so "
                "that it mirrors, or take more flakes or a wider tilt."
            ),
        )


def _expect(paint: Paint, seen: Seen, lamps: tuple[bpy.types.Object, ...]) -> Expected:
    per_m2 = 1e6 * sum(flakes.flakes_per_mm2 for flakes in paint.species)
    flakes = float(np.median(seen.footprint)) * per_m2
    if verify.core_missing():
        return Expected(flakes, None, None, None, None)
    import metallic_paint_core as core

    slots = verify.core_lights()
    if not slots:
        return Expected(flakes, 0.0, 0.0, 0.0, 0.0)
    given: dict[str, Any] = {
        "position": seen.position, "normal": seen.normal, "view": seen.view,
        "footprint": seen.footprint, "pixel": np.zeros((len(seen.footprint), 2), np.int32),
    }  # fmt: skip
    counts = np.zeros((len(seen.footprint), len(slots)))
    for species, each in enumerate(paint.species):
        if each.flakes_per_mm2 > 0:
            found = core.evaluate(core_paint(paint), slots, species=species, **given)
            counts += found["mean_count"]
    counts *= [not lamp.hide_render for lamp in lamps]  # as it may be at this frame
    total = counts.sum(axis=1)
    if not counts.any():
        return Expected(flakes, 0.0, 0.0, 0.0, 0.0)
    # A pixel's radiance for E = 1: that of one sparkle, or of so many as two deviations allow.
    mean, variance = (found[key].mean(axis=-1) for key in ("mean_radiance", "variance"))
    one = np.where(counts > 1e-6, mean / np.maximum(counts, 1e-6), 0)
    one = mean + paint.sparkle_contrast * (one - mean)
    bright = np.maximum(one, mean + 2 * np.sqrt(variance)) * _irradiances(lamps, seen)
    return Expected(
        flakes=flakes,
        sparkles=float(np.median(total)),
        most_sparkles=float(np.quantile(total, _BRIGHT)),
        in_picture=float(total.mean() * seen.pixels),
        brightness=float(np.quantile(bright.max(axis=1), _BRIGHT)),
    )


def _irradiances(lamps: tuple[bpy.types.Object, ...], seen: Seen) -> np.ndarray:
    """(n, lamps): of each lamp on a plane that faces it, W/m², without shadows and spots' edges."""
    columns = []
    for lamp in lamps:
        strength = lamp.data.energy * max(lamp.data.color) * 2**lamp.data.exposure
        if lamp.data.type == "SUN":
            columns.append(np.full(len(seen.footprint), strength))
            continue
        away = seen.position - np.array(lamp.matrix_world.translation)
        columns.append(strength / (4 * np.pi * np.maximum((away**2).sum(axis=1), 1e-8)))
    return np.stack(columns, axis=1)


# --- rays --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Effort:
    """How much a look may cost, as all looks of a report share its rays."""

    objects: int  # that may be looked at
    rays: int  # at each, along each side of its box in the picture
    tests: int  # of these, through the scene


def _effort(surfaces: int, objects: int) -> Effort:
    """For so many painted surfaces in a scene of so many objects."""
    tests = _VISITS // max(objects, 1)
    most = min(surfaces, _ALL_RAYS // _FEWEST_RAYS**2, tests // _FEWEST_TESTS)
    share = max(most, 1)
    return Effort(share, min(_RAYS, math.isqrt(_ALL_RAYS // share)), max(tests // share, 1))


@dataclass(frozen=True)
class _Camera:
    """How the scene's camera makes its picture; places in it are in 0..1."""

    matrix: Matrix  # unscaled, to the world
    low: Vector  # corners of its frame
    high: Vector
    orthographic: bool
    resolution: np.ndarray
    pixel: float  # area of one in the frame, scene units²

    @staticmethod
    def of(scene: bpy.types.Scene) -> _Camera:
        """Raises ValueError, in a sentence, for a camera that this cannot look through."""
        camera = scene.camera
        if camera is None or camera.type != "CAMERA":
            raise ValueError("without a camera nothing can be said of its pixels.")
        if camera.data.type not in ("PERSP", "ORTHO"):
            raise ValueError(f"nothing can be said of the pixels of a {camera.data.type} camera.")
        at, turned, _ = camera.matrix_world.decompose()
        frame = camera.data.view_frame(scene=scene)
        low, high = (Vector([end(axis) for axis in zip(*frame, strict=True)]) for end in (min, max))
        render = scene.render
        resolution = np.array([render.resolution_x, render.resolution_y])
        resolution = resolution * render.resolution_percentage / 100
        return _Camera(
            matrix=Matrix.Translation(at) @ turned.to_matrix().to_4x4(),
            low=low,
            high=high,
            orthographic=camera.data.type == "ORTHO",
            resolution=resolution,
            pixel=float(np.prod([(high[i] - low[i]) / resolution[i] for i in (0, 1)])),
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
        axis = self.matrix.col[2].xyz
        away = (self.matrix.translation - position).dot(axis)
        depth = 1 if self.orthographic else away / -self.low.z
        return self.pixel * depth**2 * -direction.dot(axis)


def look(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    thing: bpy.types.Object,
    painted: bpy.types.Material,
    meters_per_unit: float,
    effort: Effort | None = None,
) -> Seen | None:
    """Rays through the object's box in the picture; None if none meets the material there.

    Raises ValueError, in a sentence, for a camera or an object that this cannot look through or at.
    """
    layer.update()
    camera = _Camera.of(scene)
    effort = effort or _effort(1, len(layer.depsgraph.object_instances))
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
            cosine = direction.dot(normal)
            area = camera.pixel_area(position, direction) / max(abs(cosine), 1e-3)
            facing = normal if cosine < 0 else -normal
            raster = place * camera.resolution
            hits.append((*position, *facing, *-direction, area * meters_per_unit**2, *raster))
            rays.append((origin, direction))
    if not hits:
        return None
    table = np.array(hits)
    table = table[_in_sight(scene, layer, thing, rays, table[:, 10:], effort.tests)]
    if not len(table) and effort.tests < len(rays):
        raise ValueError("the camera sees nothing of it, or little.")
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
    """Raises ValueError, in a sentence, where Blender has none.

    It crashes where a ray is cast at an object that is not a mesh and has none evaluated.
    """
    evaluated = thing.evaluated_get(layer.depsgraph)
    if not thing.visible_get(view_layer=layer) or not evaluated.is_evaluated:
        raise ValueError("it is hidden in the viewport, so nothing can be foretold of it.")
    if isinstance(evaluated.data, bpy.types.Mesh):
        yield _Polygons(evaluated, evaluated.data, None)
        return
    if thing.type not in ("CURVE", "SURFACE", "FONT", "META"):
        raise ValueError("nothing can be foretold of hair and points.")
    mesh = evaluated.to_mesh()
    try:
        places = [vertex.co for vertex in mesh.vertices]
        polygons = [tuple(polygon.vertices) for polygon in mesh.polygons]
        yield _Polygons(evaluated, mesh, BVHTree.FromPolygons(places, polygons))
    finally:
        evaluated.to_mesh_clear()


def _in_sight(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    thing: bpy.types.Object,
    rays: list[tuple[Vector, Vector]],
    raster: np.ndarray,
    tests: int,
) -> np.ndarray:
    """(n,) bool: which rays meet nothing before the object; untested, as the nearest tested one."""
    tested = np.sort(np.random.default_rng(0).permutation(len(rays))[:tests])
    free = np.array([_is_free(scene, layer, thing, *rays[i]) for i in tested])
    if len(tested) == len(rays):
        return free
    apart = ((raster[:, None] - raster[tested]) ** 2).sum(axis=-1)
    return free[apart.argmin(axis=1)]


def _is_free(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    thing: bpy.types.Object,
    origin: Vector,
    direction: Vector,
) -> bool:
    """Whether the object is the first on the ray that a render shows."""
    for _ in range(_THROUGH):
        hit, place, _, _, found, _ = scene.ray_cast(layer.depsgraph, origin, direction)
        if not hit:
            return False
        if not found.hide_render and found.visible_camera:
            return found.original == thing
        origin = place + 1e-5 * max(place.length, 1) * direction
    return False


# --- words -------------------------------------------------------------------------------------


def _number(x: float) -> str:
    """Two digits, without powers of ten where one reads it better."""
    if x == 0 or 1e-3 <= x < 1e6:
        return f"{float(f'{x:.2g}'):,g}" if x < 1e5 else f"{float(f'{x:.2g}'):,.0f}"
    return f"{x:.1e}"


def _length(meters: float) -> str:
    for unit, factor in (("km", 1e-3), ("m", 1), ("cm", 1e2), ("mm", 1e3)):
        if meters * factor >= 1:
            return f"{_number(meters * factor)} {unit}"
    return f"{_number(meters * 1e6)} µm"


# --- interface ---------------------------------------------------------------------------------


class SCENE_OT_metallic_paint_report(bpy.types.Operator):
    """Look at the scene as the camera does: what its paints need, how many sparkles a pixel has, \
and which settings would spoil them"""

    bl_idname = "scene.metallic_paint_report"
    bl_label = "Report on Scene"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        editable = operators.can_change(cls, context.scene, "scene")
        return editable and operators.has_cycles(cls, context)

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        lines = report(context.scene)
        context.window_manager[_KEY] = json.dumps({context.scene.name_full: lines})
        bad = [sentence for level, sentence in lines if level != INFO]
        for sentence in bad:
            self.report({WARNING}, sentence)
        if not bad:
            self.report({INFO}, "Nothing spoils the sparkles.")
        return {"FINISHED"}


class MATERIAL_PT_metallic_paint_report(SubPanel):
    bl_label = "Scene Report"

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.operator(SCENE_OT_metallic_paint_report.bl_idname)
        found = json.loads(context.window_manager.get(_KEY, "{}"))
        for level, sentence in found.get(context.scene.name_full, ()):
            draw_lines(self.layout, sentence, _ICONS[level])


register, unregister = bpy.utils.register_classes_factory(
    (SCENE_OT_metallic_paint_report, MATERIAL_PT_metallic_paint_report)
)
