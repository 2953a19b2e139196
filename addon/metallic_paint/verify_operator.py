# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks a small region of the artist's own scene against the core, in another process.

The other Blender opens a copy of the file, where everything but the paint is held out, the lamps
are lit one by one, and the shader shows its inner values (verify.py). Here the scene stays as it
is, and the interface alive.
"""

from __future__ import annotations

import dataclasses
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
from bpy.props import IntProperty

from . import lights, material, scene_report, shader, verify
from .operators import WITHIN_GROUP
from .paint import PaintError, core_paint
from .panel import SubPanel, draw_lines

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems
    from metallic_paint_core._native import Light, Paint, Pixels

SIZE = 96  # pixels along each side of the region
PICTURES = ("Cycles", "Core", "Difference × 100")
_KEY = "metallic_paint_verified"  # custom property of the window manager: not in the file
_SECONDS = 0.2  # between looks at the other process

Progress = Callable[[float, str], None]


class VerifyError(RuntimeError):
    """Why a scene cannot be checked, in a sentence."""


# What a check may end in: also a full disk, and files of the other process that are cut off.
_ENDS = (VerifyError, OSError, RuntimeError, ValueError, EOFError)


@dataclass(frozen=True)
class Found:
    """How the region agrees with the core."""

    of: str  # object and material, and the scene
    region: tuple[int, int, int, int]  # left, bottom, right, top: pixels of the frame
    pixels: int  # with paint in them, times the flake species and the lights that reach them
    same_count: int
    at_pixel_edge: int  # as in verify.Comparison, and so the next three
    at_threshold: int
    unexplained: int
    by_chance: int
    worst_error: float  # relative, of a pixel's radiance
    worst_pixel: tuple[int, int]  # of the frame
    notes: tuple[str, ...]  # what was checked otherwise than it stands in the scene

    @property
    def agrees(self) -> bool:
        return (
            self.pixels > 0
            and self.unexplained == 0
            and self.worst_error <= verify.MOST_RADIANCE_ERROR
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
        ]
        if self.by_chance:
            lines.append(f"{self.by_chance} pixels are too dim for Cycles and kept by lot.")
        return "\n".join((*lines, *self.notes))


# --- in the artist's process -------------------------------------------------------------------


def why_not(scene: bpy.types.Scene, thing: bpy.types.Object | None) -> str:
    """What keeps the scene from being checked, in a sentence; quick enough for a panel."""
    if missing := verify.core_missing():
        return f"{missing} The paint works without it"
    if scene.camera is None:
        return "The scene has no camera"
    painted = _painted(thing)
    if painted is None:
        return "Select an object with a metallic paint"
    if material.is_within_group(painted):
        return f"{WITHIN_GROUP}, where it cannot be checked"
    if file := material.linked_from(material.paint_node(painted)):
        return f"The paint is linked from {file} and keeps its lights: check it in that file"
    return ""


def _unlike_core(painted: bpy.types.Material) -> str:
    """Why the core cannot have this paint, in a sentence; too slow for a panel."""
    tree = material.paint_node(painted).node_tree
    if not material.is_current(tree, material.digest(shader.source())):
        return f"The paint of “{painted.name}” is of an older version: update it first"
    try:
        material.paint_of(painted)
    except PaintError as error:
        return str(error).rstrip(".")
    return ""


def _painted(thing: bpy.types.Object | None) -> bpy.types.Material | None:
    """The object's active material if it is a paint, or else its first paint.

    Without any, the first that holds one within a node group.
    """
    slots = (
        []
        if thing is None
        else [thing.active_material, *(s.material for s in thing.material_slots)]
    )
    held = [each for each in slots if each is not None and lights.holds_slots(each.node_tree)]
    return min(held, key=material.is_within_group, default=None)


class Job:
    """The other process, and what it has said. close() ends it and removes its files."""

    def __init__(self, scene: bpy.types.Scene, thing: bpy.types.Object, size: int = SIZE) -> None:
        if reason := why_not(scene, thing) or _unlike_core(_painted(thing)):
            raise VerifyError(f"{reason}.")
        self.progress, self.what = 0.0, "Starting Blender"
        self.found: Found | None = None
        self.folder = Path(tempfile.mkdtemp(prefix="metallic-paint-"))
        self._log = (self.folder / "log").open("wb")
        try:
            blend = self.folder / "scene.blend"
            bpy.ops.wm.save_as_mainfile(filepath=str(blend), copy=True, compress=False)
            job = {
                "modules": _modules(), "blend": str(blend), "folder": str(self.folder),
                "scene": scene.name_full, "object": thing.name_full,
                "material": _painted(thing).name_full, "size": size,
            }  # fmt: skip
            file = self.folder / "job.json"
            file.write_text(json.dumps(job), encoding="utf-8")
            self._process = subprocess.Popen(
                [*_blender(), str(file)], stdin=subprocess.DEVNULL, stdout=self._log,
                stderr=subprocess.STDOUT,
            )  # fmt: skip
        except BaseException:
            self._log.close()
            shutil.rmtree(self.folder, ignore_errors=True)
            raise

    def poll(self) -> bool:
        """Whether it has ended; progress, what and found tell the rest.

        Raises VerifyError if it failed.
        """
        ended = self._process.poll() is not None
        said = self.folder / "said.jsonl"
        text = said.read_text(encoding="utf-8") if said.exists() else ""
        lines = [json.loads(line) for line in text.splitlines(keepends=True) if line[-1] == "\n"]
        for line in lines:
            if "error" in line:
                raise VerifyError(line["error"])
            if "found" in line:
                self.found = _as_found(line["found"])
            self.progress = line.get("progress", self.progress)
            self.what = line.get("what", self.what)
        if ended and self.found is None:
            log = (self.folder / "log").read_text(encoding="utf-8", errors="replace").splitlines()
            raise VerifyError(f"The other Blender ended: {' '.join(log[-3:]) or 'without a word'}")
        return ended

    def pictures(self) -> list[bpy.types.Image]:
        """Its three pictures as images of this file, in place of those of an earlier check."""
        arrays = np.load(self.folder / "pictures.npy")
        return [
            _image(f"Metallic Paint {name}", array)
            for name, array in zip(PICTURES, arrays, strict=True)
        ]

    def close(self) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        self._log.close()
        shutil.rmtree(self.folder, ignore_errors=True)


def run(scene: bpy.types.Scene, thing: bpy.types.Object, size: int = SIZE) -> Found:
    """Checks the region of size x size pixels where the object sparkles most, and waits for it.

    Its pictures become images of the file. Raises VerifyError, in a sentence, where that cannot be.
    """
    job = Job(scene, thing, size)
    try:
        while not job.poll():
            time.sleep(_SECONDS)
        job.pictures()
        return job.found
    finally:
        job.close()


def _blender() -> list[str]:
    """What runs verify_process.py: this Blender, or the Python that has it as a module."""
    script = str(Path(__file__).with_name("verify_process.py"))
    if bpy.app.binary_path:
        return [bpy.app.binary_path, "--background", "--factory-startup", "--python", script, "--"]
    return [sys.executable, script]


def _modules() -> dict[str, str]:
    """Where the other process finds what it imports, under the names it knows them by."""
    import metallic_paint_core
    import OpenImageIO

    found = {module.__name__: module.__file__ for module in (metallic_paint_core, OpenImageIO)}
    return {**found, "metallic_paint": str(Path(__file__).with_name("__init__.py"))}


def _as_found(values: dict) -> Found:
    """JSON has lists for tuples."""
    fields: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value for name, value in values.items()
    }
    return Found(**fields)


def _image(name: str, array: np.ndarray) -> bpy.types.Image:
    """Linear light (h, w, 3), row 0 at the bottom."""
    h, w, _ = array.shape
    image: bpy.types.Image | None = bpy.data.images.get(name)
    if image is None or tuple(image.size) != (w, h) or not image.is_float:
        if image is not None:
            bpy.data.images.remove(image)
        image = bpy.data.images.new(name, w, h, float_buffer=True)
    image.pixels.foreach_set(np.dstack([array, np.ones((h, w, 1))]).astype(np.float32).ravel())
    image.update()
    image.pack()
    return image


# --- in the other process ----------------------------------------------------------------------


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
        (each for each in scene.view_layers if each.use and thing in set(lights.rendered(each))),
        None,
    )
    if layer is None:
        raise VerifyError(f"{thing.name} does not render{_as_instances(scene, thing)}.")
    notes = _freeze(painted, layer)
    lamps = lights.fill(scene).slots
    if not lamps:
        raise VerifyError("No sun, spot or point light renders: there is no sparkle to check.")
    slots = verify.core_lights()
    node = material.paint_node(painted)
    frame = int(node.inputs["Frame"].default_value)
    settings = material.paint_of(node)
    paint = core_paint(settings, frame)
    region = _region(scene, layer, thing, painted, size, paint, slots)
    _hold_out(scene, layer, painted, region)

    in_use = [i for i, each in enumerate(settings.species) if each.flakes_per_mm2 > 0]
    probe = _Probe(scene, painted, progress, steps=5 + len(lamps) * (len(in_use) + 3))
    geometry = dataclasses.replace(probe.geometry(), origin=region[:2])
    if not geometry.hit.any():
        raise VerifyError(f"The camera sees no paint of {thing.name} in the region.")
    predicted = [verify.predict(paint, slots, geometry, "float", i) for i in in_use]
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
        leaders = predicted[0]["leader"][:, light]
        for leader in np.unique(leaders[leaders >= 0]):
            mask = leaders == leader
            hit = np.zeros_like(geometry.hit)
            hit[geometry.hit] = mask
            part = dataclasses.replace(geometry, hit=hit)
            own: list[Pixels] = [
                {key: values[mask] for key, values in each.items()}  # type: ignore[index, misc]
                for each in predicted
            ]
            counts = [probe.image(verify.COUNT, leader, i)[..., 0] for i in in_use]
            cone = probe.image(verify.CONE, leader)[..., 0]
            picture, irradiance = (
                probe.lit_by([lamp], diagnostic, leader)
                for diagnostic in (verify.SPARKLES, verify.IRRADIANCE)
            )
            compared = verify.compare(
                paint, part, own, light, leader, counts, cone, picture, irradiance
            )
            for key in totals:
                totals[key] += getattr(compared, key)
            by_chance += int(compared.by_chance.sum())
            expected = np.zeros(shape)
            expected[hit] = own[0]["radiance"][:, light] * irradiance[hit]
            shown[hit] += picture[hit]
            wanted[hit] += expected[hit]
            same = np.zeros_like(hit)
            same[hit] = np.all(
                [c[hit] == each["count"][:, leader] for c, each in zip(counts, own, strict=True)],
                axis=0,
            )
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
                  notes=tuple(notes))  # fmt: skip
    return dataclasses.asdict(found)


def _as_instances(scene: bpy.types.Scene, thing: bpy.types.Object) -> str:
    layers = [each for each in scene.view_layers if each.use]
    for layer in layers:
        layer.update()
    shown = any(thing in set(lights.instanced(layer)) for layer in layers)
    return " but as instances, of which nothing can be foretold" if shown else ""


class _Probe(verify.Probe):
    """Tells of each picture that it takes."""

    def __init__(
        self, scene: bpy.types.Scene, painted: bpy.types.Material, progress: Progress, steps: int
    ) -> None:
        super().__init__(scene, [painted])
        self.progress, self.steps, self.taken = progress, steps, 0

    def image(self, diagnostic: int, light: int = 0, species: int = 0) -> np.ndarray:
        self.progress(min(self.taken / self.steps, 1), f"Picture {self.taken + 1}")
        self.taken += 1
        return super().image(diagnostic, int(light), species)


def _freeze(painted: bpy.types.Material, layer: bpy.types.ViewLayer) -> list[str]:
    """The paint alone as the surface, its parameters constant; returns what that leaves out."""
    layer.update()
    node = material.paint_node(painted)
    evaluated = painted.evaluated_get(layer.depsgraph).node_tree.nodes[node.name]
    tree, notes = painted.node_tree, []
    linked = [s for s in node.inputs if s.is_linked and s.name not in
              (material.NORMAL, material.COAT_NORMAL)]  # fmt: skip
    if linked:
        names = ", ".join(socket.name for socket in linked)
        notes.append(f"Checked with the sockets' own values, not with what is linked to {names}.")
    values = [getattr(socket, "default_value", None) for socket in evaluated.inputs]
    values = [tuple(v) if hasattr(v, "__len__") else v for v in values]
    for socket in linked:
        for link in list(socket.links):
            tree.links.remove(link)
    tree.animation_data_clear()
    for socket, value in zip(node.inputs, values, strict=True):
        if value is not None and not socket.is_linked:
            socket.default_value = value
    surface = tree.get_output_node("CYCLES").inputs["Surface"]
    if [link.from_node for link in surface.links] != [node]:
        notes.append("Checked as the paint alone, without the shaders that it is mixed with.")
    tree.links.new(node.outputs[material.OUTPUT], surface)
    return notes


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
        seen = scene_report.look(scene, layer, thing, painted, unit)
    except ValueError:
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


# --- interface ---------------------------------------------------------------------------------

_running: list[Job] = []  # at most one: what the panel shows while the operator runs


class SCENE_OT_metallic_paint_verify(bpy.types.Operator):
    """Render the region where the active object sparkles most in another process, and check each \
pixel against the core. The pictures become images of this file"""

    bl_idname = "scene.metallic_paint_verify"
    bl_label = "Verify Against Core"
    bl_options = {"REGISTER", "UNDO"}

    size: IntProperty(
        name="Size", description="Pixels along each side of the region", default=SIZE, min=8,
        max=1024, subtype="PIXEL",
    )  # fmt: skip

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        reason = "A check is running already" if _running else ""
        if reason := reason or why_not(context.scene, context.object):
            cls.poll_message_set(reason)
        return not reason

    def invoke(
        self, context: bpy.types.Context, event: bpy.types.Event
    ) -> set[OperatorReturnItems]:
        if context.window is None:
            return self.execute(context)
        try:
            _running.append(Job(context.scene, context.object, self.size))
        except _ENDS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._timer = context.window_manager.event_timer_add(_SECONDS, window=context.window)
        context.window_manager.progress_begin(0, 1)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[OperatorReturnItems]:
        if event.type == "ESC" and event.value == "PRESS":
            self.cancel(context)
            self.report({"INFO"}, "The check was stopped")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        [job] = _running
        try:
            if not job.poll():
                context.window_manager.progress_update(job.progress)
                _redraw(context)
                return {"PASS_THROUGH"}
            job.pictures()
        except _ENDS as error:
            self.cancel(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.cancel(context)
        _show(self, context, job.found)
        return {"FINISHED"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender calls it too, when it closes."""
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        _running.pop().close()
        _redraw(context)

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        try:
            found = run(context.scene, context.object, self.size)
        except _ENDS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        _show(self, context, found)
        return {"FINISHED"}


def _show(operator: bpy.types.Operator, context: bpy.types.Context, found: Found) -> None:
    context.window_manager[_KEY] = str(found)
    for line in str(found).splitlines():
        operator.report({"INFO" if found.agrees else "WARNING"}, line)


def _redraw(context: bpy.types.Context) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


class MATERIAL_PT_metallic_paint_verify(SubPanel):
    bl_label = "Verify"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        if missing := verify.core_missing():
            draw_lines(layout, f"{missing} The paint works without it.", "INFO")
            return
        layout.operator(SCENE_OT_metallic_paint_verify.bl_idname)
        if _running:
            [job] = _running
            layout.progress(factor=job.progress, text=f"{job.what}; Esc stops")
        elif text := context.window_manager.get(_KEY, ""):
            draw_lines(layout, text)


_CLASSES = (SCENE_OT_metallic_paint_verify, MATERIAL_PT_metallic_paint_verify)
_register, _unregister = bpy.utils.register_classes_factory(_CLASSES)


def register() -> None:
    _register()


def unregister() -> None:
    while _running:
        _running.pop().close()
    _unregister()
