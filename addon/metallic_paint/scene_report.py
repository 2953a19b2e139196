# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene's paints compute, what the camera sees of their flakes, and what would spoil them.

Rays from the active camera find where each painted object shows; there the core says how many
flakes and sparkles a pixel has, and how bright one sparkle is.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import bpy
import numpy as np
from mathutils import Matrix, Vector
from mathutils.interpolate import poly_3d_calc

from . import denoise, lights, material, needs, operators, verify
from .paint import Paint, PaintError, core_paint
from .panel import SubPanel, draw_lines

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import IconItems, OperatorReturnItems

INFO: Final = "INFO"
WARNING: Final = "WARNING"
ERROR: Final = "ERROR"
Line = tuple[str, str]  # level and sentence

_RAYS = 40  # along each side of an object's box in the picture
_THROUGH = 16  # surfaces that a ray may pass that no render shows
_BRIGHT = 0.9  # quantile of a pixel's sparkles that stands for "where it sparkles most"
_MANY = 100.0  # sparkles a pixel whose sum deviates by a tenth or less
_FEW = 1.0  # in the whole picture
_SMALLEST, _LARGEST = 0.005, 100.0  # metres: sizes of what one paints
_ICONS: dict[str, IconItems] = {INFO: "BLANK1", WARNING: "ERROR", ERROR: "CANCEL"}
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
    if not fitted.lights.slots:
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
    brightest = 0.0
    for thing in painted:
        found, brightness = _about(scene, shown[thing], thing, fitted.lights.slots)
        lines += found
        brightest = max(brightest, brightness)
    lines += _clamping(scene, brightest, len(fitted.lights.slots) + bool(fitted.other_light))
    return lines


# --- settings ----------------------------------------------------------------------------------


def _render_settings(scene: bpy.types.Scene) -> Iterator[Line]:
    missing = material.missing(scene)
    if scene.render.engine != "CYCLES":
        yield ERROR, missing
        return
    if missing:
        shows = scene.cycles.shading_system and material.gpu(scene) in ("NONE", "OPTIX")
        yield WARNING if shows else ERROR, missing
    if scene.cycles.use_denoising and not denoise.is_set_up(scene):
        label = denoise.SCENE_OT_metallic_paint_denoise.bl_label
        yield WARNING, f"Denoising takes sparkles for noise: “{label}” keeps them."


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


# --- objects -----------------------------------------------------------------------------------


def _about(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    thing: bpy.types.Object,
    lamps: tuple[bpy.types.Object, ...],
) -> tuple[list[Line], float]:
    """Lines about a painted object, and how bright a pixel of it may sparkle."""
    name = thing.name
    lines: list[Line] = []
    brightest = 0.0
    materials = [slot.material for slot in thing.material_slots if slot.material]
    nodes = [(each, _node(each)) for each in materials if _node(each) is not None]
    for painted, node in nodes:
        label = name if len(nodes) == 1 else f"{name}, {painted.name}"
        try:
            paint = material.paint_of(node)
        except PaintError as error:
            lines.append((ERROR, f"{label}: {error}"))
            continue
        unit = scene.unit_settings.scale_length * node.inputs[material.MODEL_SCALE].default_value
        size = max(thing.dimensions) * unit
        if not _SMALLEST <= size <= _LARGEST:
            lines.append((WARNING, f"{label} is {_length(size)} large: is its Model Scale right?"))
        try:
            seen = look(scene, layer, thing, painted, unit)
        except ValueError as error:
            lines.append((INFO, f"{label}: {error}"))
            continue
        if seen is None:
            lines.append((INFO, f"{label}: the camera does not see it."))
            continue
        expected = _expect(paint, seen, lamps)
        brightest = max(brightest, expected.brightness or 0.0)
        lines += _judge(label, node, expected)
    return lines, brightest


def _node(painted: bpy.types.Material) -> bpy.types.ShaderNodeGroup | None:
    try:
        return material.paint_node(painted)
    except ValueError:
        return None


def _judge(label: str, node: bpy.types.ShaderNodeGroup, expected: Expected) -> Iterator[Line]:
    held = f"{label}: {_number(expected.flakes)} flakes a pixel"
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


def look(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    thing: bpy.types.Object,
    painted: bpy.types.Material,
    meters_per_unit: float,
) -> Seen | None:
    """Rays through the object's box in the picture; None if none meets the material there.

    Raises ValueError, in a sentence, for a camera that this cannot look through.
    """
    camera = scene.camera
    if camera is None or camera.type != "CAMERA":
        raise ValueError("without a camera nothing can be said of its pixels.")
    if camera.data.type not in ("PERSP", "ORTHO"):
        raise ValueError(f"nothing can be said of the pixels of a {camera.data.type} camera.")
    layer.update()
    at, _, _ = camera.matrix_world.decompose()
    matrix = Matrix.Translation(at) @ camera.matrix_world.to_quaternion().to_matrix().to_4x4()
    frame = camera.data.view_frame(scene=scene)
    low = Vector([min(axis) for axis in zip(*frame, strict=True)])
    high = Vector([max(axis) for axis in zip(*frame, strict=True)])
    orthographic = camera.data.type == "ORTHO"
    box = _box_in_picture(thing, matrix.inverted(), low, high, orthographic)
    if box is None:
        return None
    percentage = scene.render.resolution_percentage / 100
    resolution = np.array([scene.render.resolution_x, scene.render.resolution_y]) * percentage
    pixel_area = float(np.prod([(high[i] - low[i]) / resolution[i] for i in (0, 1)]))
    axis = matrix.to_3x3() @ Vector((0, 0, 1))
    hits = []
    steps = (np.arange(_RAYS) + 0.5) / _RAYS
    for x in box[0] + steps * (box[2] - box[0]):
        for y in box[1] + steps * (box[3] - box[1]):
            place = Vector((low.x + x * (high.x - low.x), low.y + y * (high.y - low.y), low.z))
            origin = Vector((place.x, place.y, 0)) if orthographic else Vector()
            direction = Vector((0, 0, -1)) if orthographic else place.normalized()
            hit = _cast(scene, layer, matrix @ origin, matrix.to_3x3() @ direction, thing, painted)
            if hit is None:
                continue
            position, normal = hit
            view = -(matrix.to_3x3() @ direction)
            cosine = max(abs(view.dot(normal)), 1e-3)
            depth = 1.0 if orthographic else (matrix.translation - position).dot(axis) / -low.z
            area = pixel_area * depth**2 * view.dot(axis) / cosine * meters_per_unit**2
            facing = normal if view.dot(normal) > 0 else -normal
            hits.append((*position, *facing, *view, area, *((x, y) * resolution)))
    if not hits:
        return None
    table = np.array(hits)
    share = len(hits) / _RAYS**2 * (box[2] - box[0]) * (box[3] - box[1])
    return Seen(
        position=table[:, :3],
        normal=table[:, 3:6],
        view=table[:, 6:9],
        footprint=table[:, 9],
        raster=table[:, 10:],
        pixels=float(share * resolution.prod()),
    )


def _box_in_picture(
    thing: bpy.types.Object, to_camera: Matrix, low: Vector, high: Vector, orthographic: bool
) -> tuple[float, float, float, float] | None:
    """Left, bottom, right, top of the object's box in 0..1 of the picture; None outside."""
    corners = [to_camera @ thing.matrix_world @ Vector(corner) for corner in thing.bound_box]
    if all(corner.z >= 0 for corner in corners):
        return None
    if not orthographic and any(corner.z >= -1e-6 for corner in corners):
        return 0, 0, 1, 1  # the camera stands in the box
    scales = [1 if orthographic else low.z / corner.z for corner in corners]
    left, right, bottom, top = (
        end((corner[i] * scale - low[i]) / (high[i] - low[i])
            for corner, scale in zip(corners, scales, strict=True))
        for i in (0, 1) for end in (min, max)
    )  # fmt: skip
    left, bottom, right, top = max(left, 0), max(bottom, 0), min(right, 1), min(top, 1)
    return (left, bottom, right, top) if left < right and bottom < top else None


def _cast(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    origin: Vector,
    direction: Vector,
    thing: bpy.types.Object,
    painted: bpy.types.Material,
) -> tuple[Vector, Vector] | None:
    """Place and normal where the ray meets the material on the object, if nothing is before it."""
    for _ in range(_THROUGH):
        hit, place, normal, index, found, _ = scene.ray_cast(layer.depsgraph, origin, direction)
        if not hit:
            return None
        if found.hide_render or not found.visible_camera:
            origin = place + 1e-5 * max(place.length, 1) * direction
            continue
        if found.original != thing.original:
            return None
        mesh = thing.evaluated_get(layer.depsgraph).data
        polygon = mesh.polygons[index] if isinstance(mesh, bpy.types.Mesh) else None
        if _material_at(thing, polygon) != painted:
            return None
        return place, normal if polygon is None else _smooth_normal(thing, mesh, polygon, place)
    return None


def _material_at(
    thing: bpy.types.Object, polygon: bpy.types.MeshPolygon | None
) -> bpy.types.Material | None:
    slot = polygon.material_index if polygon is not None else 0
    return thing.material_slots[min(slot, len(thing.material_slots) - 1)].material


def _smooth_normal(
    thing: bpy.types.Object, mesh: bpy.types.Mesh, polygon: bpy.types.MeshPolygon, place: Vector
) -> Vector:
    """The shading normal in the world, between those of the polygon's corners."""
    to_local = thing.matrix_world.inverted_safe()
    corners = [mesh.vertices[i].co for i in polygon.vertices]
    weights = poly_3d_calc(corners, to_local @ place)
    normals = [mesh.corner_normals[i].vector for i in polygon.loop_indices]
    normal = sum((w * n for w, n in zip(weights, normals, strict=True)), Vector())
    return (to_local.to_3x3().transposed() @ normal).normalized()


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
