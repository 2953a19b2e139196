# SPDX-License-Identifier: GPL-3.0-or-later
"""The check of a small region of a scene against the core, in the Blender that job.py starts.

Everything but the paint is held out, the lamps are lit one by one, and the shader shows its inner
values (probe.py).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from ..native import core_lights
from ..paint import core_paint, live, material
from ..scene import lights, placed, sight
from .comparison import MOST_RADIANCE_ERROR, MOST_STACK_ERROR, compare, predict, stack_error
from .diagnostics import (
    CONE,
    COUNT,
    DIFFUSE,
    GLOSSY,
    IRRADIANCE,
    RETURNED,
    ROUGHNESS,
    SPARKLES,
    TEXTURE,
)
from .probe import Probe

if TYPE_CHECKING:
    from metallic_paint_core._native import Light, Paint

Progress = Callable[[float, str], None]


class VerifyError(RuntimeError):
    """Why a scene cannot be checked, in a sentence."""


@dataclass(frozen=True)
class Found:
    """How the region agrees with the core."""

    of: str  # object and material, and the scene
    region: tuple[int, int, int, int]  # left, bottom, right, top: pixels of the frame
    pixels: int  # with paint in them, times the lights that reach them
    same_count: int
    at_pixel_edge: int  # as in comparison.Comparison, and so the next three
    at_threshold: int
    unexplained: int
    by_chance: int
    worst_error: float  # relative, of a pixel's radiance
    worst_pixel: tuple[int, int]  # of the frame
    worst_under: float  # of an albedo or roughness of what lies under the sparkles
    notes: tuple[str, ...]  # what was checked otherwise than it stands in the scene

    @property
    def agrees(self) -> bool:
        return (
            self.pixels > 0
            and self.unexplained == 0
            and self.worst_error <= MOST_RADIANCE_ERROR
            and self.worst_under <= MOST_STACK_ERROR
        )

    def __str__(self) -> str:
        left, bottom, right, top = self.region
        lines = [
            f"{self.of}: pixels {left}..{right - 1} × {bottom}..{top - 1} "
            f"{'agree' if self.agrees else 'DO NOT agree'} with the core.",
            f"The same count in {self.same_count} of {self.pixels}; otherwise the pixel's edge "
            f"({self.at_pixel_edge}), rounding ({self.at_threshold}), "
            f"unexplained ({self.unexplained}).",
            f"Worst pixel {self.worst_pixel[0]}, {self.worst_pixel[1]}: radiance off by "
            f"{100 * self.worst_error:.2g} %.",
            f"Substrate, mixture and texture under them: off by {self.worst_under:.2g} at most.",
        ]
        if self.by_chance:
            lines.append(f"{self.by_chance} pixels are too dim for Cycles and kept by lot.")
        return "\n".join((*lines, *self.notes))


def as_found(values: dict) -> Found:
    """JSON has lists for tuples."""
    fields: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value for name, value in values.items()
    }
    return Found(**fields)


def check(
    scene: bpy.types.Scene,
    thing: bpy.types.Object,
    painted: bpy.types.Material,
    size: int,
    folder: Path,
    progress: Progress,
) -> dict:
    """The fields of Found. Changes the scene as it needs; pictures.npy comes into the folder."""
    import metallic_paint_core as core

    layer = next(
        (each for each in placed.used_layers(scene) if thing in set(placed.rendered(each))),
        None,
    )
    if layer is None:
        raise VerifyError(f"{thing.name} does not render{_as_instances(scene, thing)}.")
    notes = _freeze(painted, layer)
    lamps = _make_real(scene, lights.fill(scene).placed)
    if not lamps:
        raise VerifyError(
            "No sun, spot, point or area light renders: there is no sparkle to check."
        )
    slots = core_lights()
    node = material.paint_node(painted)
    frame = material.frame_of(node, scene)
    settings = material.paint_of(node)
    paint = core_paint(settings, frame)
    region = _region(scene, layer, thing, painted, size, paint, slots)
    _hold_out(scene, layer, painted, region)

    probe = _Probe(scene, painted, progress, steps=15 + 4 * len(lamps))
    geometry = dataclasses.replace(probe.geometry(), origin=region[:2])
    if not geometry.hit.any():
        raise VerifyError(f"The camera sees no paint of {thing.name} in the region.")
    predicted = predict(paint, slots, geometry, "float")
    under = {
        "diffuse": DIFFUSE, "glossy": GLOSSY, "returned": RETURNED, "alpha": ROUGHNESS,
        "texture": TEXTURE,
    }  # fmt: skip
    shown_under = {name: probe.image(diagnostic) for name, diagnostic in under.items()}
    worst_under = float(stack_error(paint, geometry, shown_under).max())
    totals = dict.fromkeys(
        ("pixels", "same_count", "at_pixel_edge", "at_threshold", "unexplained"), 0
    )
    by_chance = 0
    shape = (*geometry.hit.shape, 3)
    shown, wanted = np.zeros(shape), np.zeros(shape)
    worst, where = 0.0, (int(region[0]), int(region[1]))
    for light, lamp in enumerate(lamps):
        if lamp.hide_render:
            continue  # it has its slot for another frame
        leaders = predicted["leader"][:, light]
        for leader in np.unique(leaders[leaders >= 0]):
            mask = leaders == leader
            hit = np.zeros_like(geometry.hit)
            hit[geometry.hit] = mask
            part = dataclasses.replace(geometry, hit=hit)
            own: Any = {key: array[mask] for key, array in predicted.items()}  # type: ignore[index]
            count = probe.image(COUNT, leader)[..., 0]
            cone = probe.image(CONE, leader)[..., 0]
            picture, irradiance = (
                probe.lit_by([lamp], diagnostic, leader) for diagnostic in (SPARKLES, IRRADIANCE)
            )
            compared = compare(
                paint, slots, part, own, light, leader, count, cone, picture, irradiance
            )
            for key in totals:
                totals[key] += getattr(compared, key)
            by_chance += int(compared.by_chance.sum())
            expected = np.zeros(shape)
            expected[hit] = own["radiance"][:, light] * irradiance[hit]
            shown[hit] += picture[hit]
            wanted[hit] += expected[hit]
            same = np.zeros_like(hit)
            same[hit] = count[hit] == own["count"][:, leader]
            lit = same & (expected.max(axis=-1) > 0) & ~compared.by_chance
            error = np.abs(picture - expected).max(axis=-1) / np.maximum(
                expected.max(axis=-1), 1e-30
            )
            error[~lit] = 0
            y, x = np.unravel_index(int(error.argmax()), error.shape)
            if error[y, x] > worst:
                worst, where = float(error[y, x]), (int(region[0] + x), int(region[1] + y))
    np.save(folder / "pictures.npy", np.stack([shown, wanted, 100 * np.abs(shown - wanted)]))
    if not totals["pixels"]:
        raise VerifyError(f"No light with a slot reaches {thing.name} in the region.")
    notes.append(f"The core is metallic_paint_core {core.__version__}.")
    of = f"{thing.name}, {painted.name} ({scene.name})"
    found = Found(of, region, **totals, by_chance=by_chance, worst_error=worst, worst_pixel=where,
                  worst_under=worst_under, notes=tuple(notes))  # fmt: skip
    return dataclasses.asdict(found)


def _as_instances(scene: bpy.types.Scene, thing: bpy.types.Object) -> str:
    layers = placed.used_layers(scene)
    for layer in layers:
        layer.update()
    shown = any(thing in set(placed.instanced(layer)) for layer in layers)
    return " but as instances, of which nothing can be foretold" if shown else ""


class _Probe(Probe):
    """Tells of each picture that it takes."""

    def __init__(
        self, scene: bpy.types.Scene, painted: bpy.types.Material, progress: Progress, steps: int
    ) -> None:
        super().__init__(scene, [painted])
        self.progress, self.steps, self.taken = progress, steps, 0

    def image(self, diagnostic: int, light: int = 0) -> np.ndarray:
        self.progress(min(self.taken / self.steps, 1), f"Picture {self.taken + 1}")
        self.taken += 1
        return super().image(diagnostic, int(light))


def _make_real(scene: bpy.types.Scene, found: tuple[placed.Placed, ...]) -> list[bpy.types.Object]:
    """Lamps that can be lit one by one, in place of instances, which go dark; the slots stay."""
    instanced = {each.lamp for each in placed.instances_in(placed.used_layers(scene))}
    lamps = [each.lamp.copy() if each.lamp in instanced else each.lamp for each in found]
    for lamp in instanced:
        lamp.data = lamp.data.copy()
        lamp.data.animation_data_clear()
        lamp.data.energy = 0
    for light, lamp in zip(found, lamps, strict=True):
        if lamp != light.lamp:
            lamp.parent = None
            lamp.constraints.clear()
            lamp.animation_data_clear()
            lamp.matrix_world = light.matrix
            scene.collection.objects.link(lamp)
    return lamps


def _freeze(painted: bpy.types.Material, layer: bpy.types.ViewLayer) -> list[str]:
    """The paint alone as the surface, its parameters constant; returns what that leaves out.

    One that stands within a node group is brought out of it.
    """
    path = next(material.paint_paths(painted.node_tree))
    live.end(path[-1])
    layer.update()
    tree, notes = painted.node_tree, []
    given = [_given(path, socket, painted, layer) for socket in path[-1].inputs]
    node, kept = path[-1], set(material.GEOMETRY.values())
    if material.is_within_group(node):
        node, kept = material.new_node(tree, node.node_tree), set()
    linked = [each.name for each in given if each.linked and each.name not in kept]
    if linked:
        names = ", ".join(linked)
        notes.append(f"Checked with the sockets' own values, not with what is linked to {names}.")
    tree.animation_data_clear()
    for socket, each in zip(node.inputs, given, strict=True):
        if each.name in kept:
            continue
        for link in list(socket.links):
            tree.links.remove(link)
        if each.value is not None:
            socket.default_value = each.value
    surface = tree.get_output_node("CYCLES").inputs["Surface"]
    if node != path[-1]:
        notes.append(f"Checked as the paint alone, out of the group {path[-1].id_data.name}.")
    elif [link.from_node for link in surface.links] != [node]:
        notes.append("Checked as the paint alone, without the shaders that it is mixed with.")
    tree.links.new(node.outputs[material.OUTPUT], surface)
    return notes


@dataclass(frozen=True)
class _Given:
    """What a socket of the paint has."""

    name: str
    value: Any  # None for a socket without a value of its own
    linked: bool  # to what is no socket of a group: the value is not what the socket shows


def _given(
    path: list[bpy.types.ShaderNodeGroup],
    socket: bpy.types.NodeSocket,
    painted: bpy.types.Material,
    layer: bpy.types.ViewLayer,
) -> _Given:
    """The value in the frame; where an input of the group around decides, that input's."""
    *groups, node = path
    if groups:
        now = node.id_data.evaluated_get(layer.depsgraph)
    else:
        now = painted.evaluated_get(layer.depsgraph).node_tree
    own = next(s for s in now.nodes[node.name].inputs if s.identifier == socket.identifier)
    value = getattr(own, "default_value", None)
    value = tuple(value) if hasattr(value, "__len__") else value
    if not socket.is_linked:
        return _Given(socket.name, value, False)
    source = socket.links[0].from_socket
    if groups and source.node.type == "GROUP_INPUT" and source.type == socket.type:
        outer = next(s for s in groups[-1].inputs if s.identifier == source.identifier)
        return dataclasses.replace(_given(groups, outer, painted, layer), name=socket.name)
    return _Given(socket.name, value, True)


def _region(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    thing: bpy.types.Object,
    painted: bpy.types.Material,
    size: int,
    paint: Paint,
    slots: list[Light],
) -> tuple[int, int, int, int]:
    """Where the object sparkles most; the frame's centre if rays cannot tell."""
    import metallic_paint_core as core

    frame = np.array([scene.render.resolution_x, scene.render.resolution_y])
    frame = np.maximum((frame * scene.render.resolution_percentage / 100).astype(int), 1)
    unit = scene.unit_settings.scale_length
    unit *= material.paint_node(painted).inputs[material.MODEL_SCALE].default_value
    centre = frame / 2
    try:
        seen = sight.look(scene, layer, thing, painted, unit)
    except sight.SightError:
        seen = None
    if seen is not None:
        mean = core.evaluate(
            paint, slots, position=seen.position, normal=seen.normal, view=seen.view,
            footprint=seen.footprint, pixel=np.zeros((len(seen.footprint), 2), np.int32),
        )["mean_radiance"].sum(axis=(1, 2))  # fmt: skip
        centre = seen.raster[int(mean.argmax())]
    extent = np.minimum(size, frame)
    low = np.clip((centre - extent / 2).astype(int), 0, frame - extent)
    left, bottom = map(int, low)
    right, top = map(int, low + extent)
    return left, bottom, right, top


def _hold_out(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    painted: bpy.types.Material,
    region: tuple[int, int, int, int],
) -> None:
    """Nothing but the paint gives light to the camera; all else still throws shadows."""
    material.set_up_cycles(scene)
    for each in scene.view_layers:
        each.use = each == layer
    layer.material_override = None
    if hasattr(layer, "world_override"):
        layer.world_override = None
    scene.world = None
    hole = bpy.data.materials.new("Hole")
    if hole.node_tree is None:
        hole.use_nodes = True  # Blender 4.5
    hole.node_tree.nodes.clear()
    out = hole.node_tree.nodes.new("ShaderNodeOutputMaterial")
    shader_node = hole.node_tree.nodes.new("ShaderNodeHoldout")
    hole.node_tree.links.new(shader_node.outputs[0], out.inputs["Surface"])
    for other in list(bpy.data.materials):
        if other not in (painted, hole):
            other.user_remap(hole)
    for thing in scene.objects:
        thing.is_shadow_catcher = False
        slots = thing.material_slots
        if thing.type != "LIGHT" and not (slots and all(slot.material for slot in slots)):
            thing.is_holdout = True
        if thing.type == "LIGHT":  # one sample hits the lamp, without noise
            thing.data.cycles.use_multiple_importance_sampling = False

    cycles, render = scene.cycles, scene.render
    cycles.light_sampling_threshold = 0
    cycles.film_exposure = 1
    scene.camera.data.dof.use_dof = False
    render.use_motion_blur = render.use_compositing = render.use_sequencer = False
    render.use_multiview = render.use_freestyle = render.use_stamp = False
    render.use_overwrite, render.use_placeholder = True, False
    render.image_settings.color_management = "FOLLOW_SCENE"
    render.use_border = render.use_crop_to_border = True
    w = int(render.resolution_x * render.resolution_percentage / 100)
    h = int(render.resolution_y * render.resolution_percentage / 100)
    # Blender rounds down: half a pixel keeps clear of the step.
    left, bottom, right, top = (edge + 0.5 for edge in region)
    render.border_min_x, render.border_max_x = left / w, min(right / w, 1)
    render.border_min_y, render.border_max_y = bottom / h, min(top / h, 1)
