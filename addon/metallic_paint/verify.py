# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks a picture of the paint against the core, pixel by pixel.

The shader shows its inner values beside the paint (Diagnostic and Shown): where each pixel
looks, and what it computed there. The core repeats the computation in float from the same places
and must find the same counts and radiances. The lit picture is checked too: where Cycles lights a
cone of radiance 1, the picture is the light's irradiance E, and the sparkles must be T E.

Every array here is (height, width, ...) with row 0 at the bottom, as the shader counts pixels.
"""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import bpy
import numpy as np

from . import lights, material, shader

if TYPE_CHECKING:
    from metallic_paint_core._native import Light, Paint, Pixels

# The shader's diagnostics, as osl/metallic_paint.osl numbers them.
COUNT, MEAN_COUNT, RADIANCE, MEAN_RADIANCE, PIXEL, POSITION, NORMAL, VIEW, RASTER = range(1, 10)
IRRADIANCE, SPARKLES, CONE, SOUND, LOBE, DIFFUSE, TEXTURE, GLOSSY, ROUGHNESS = range(10, 19)
LIT = (IRRADIANCE, SPARKLES, LOBE)  # surfaces under the lamps; the others are values to emit

# Cycles drops closures below this weight; the shader keeps them by chance (osl/cones.h).
LEAST_WEIGHT = 1.1e-5

# Error that float rounding may leave in <N> (relative) and in the uniform deviate.
MEAN_ROUNDING = 1e-5
UNIFORM_ROUNDING = 1e-6
FAR_COUNT = 32768  # up to this <N> the core draws; kFarCount / 2 in core/sparkles.h

MOST_RADIANCE_ERROR = 1e-2  # relative, of the worst pixel


def core_missing() -> str:
    """Why the native module cannot be used, in a sentence; empty where it can."""
    try:
        import metallic_paint_core  # noqa: F401
    except ImportError as error:
        if error.name == "metallic_paint_core":
            return "This build of the add-on has no native module for this Blender."
        return f"The native module metallic_paint_core cannot be loaded: {error}."
    return ""


@dataclass(frozen=True)
class Geometry:
    """Where each pixel of a picture looks. `hit` tells the paint from the background."""

    hit: np.ndarray  # (h, w) bool
    position: np.ndarray  # (h, w, 3) scene units
    normal: np.ndarray  # (h, w, 3)
    view: np.ndarray  # (h, w, 3), towards the camera
    footprint: np.ndarray  # (h, w) m²
    pixel: np.ndarray  # (h, w, 2) int, as the shader found it
    raster: np.ndarray  # (h, w, 2)
    origin: tuple[int, int] = (0, 0)  # x and y of the picture's first pixel in the whole frame

    def own_pixel(self) -> np.ndarray:
        """(h, w, 2): the coordinates of each pixel in the frame."""
        h, w = self.hit.shape
        x, y = self.origin
        return np.stack(np.meshgrid(np.arange(x, x + w), np.arange(y, y + h)), axis=-1)


@dataclass(frozen=True)
class Comparison:
    """How a light's sparkles in the picture agree with the core's."""

    pixels: int  # with paint in them, times the flake species
    same_count: int
    at_pixel_edge: int  # another count, because the sample lies on a pixel's edge within rounding
    at_threshold: int  # another count, because the draw lies on a step within rounding
    unexplained: int
    radiance_error: np.ndarray  # relative, of the pixels with the same count and any radiance
    by_chance: np.ndarray  # (h, w) bool: so dim that Cycles would drop them, kept by lot instead


def make_noiseless(scene: bpy.types.Scene) -> None:
    """One sample at the centre of each pixel, lit straight from the lamps, written as it is."""
    cycles = scene.cycles
    cycles.samples, cycles.seed = 1, 0
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.max_bounces = 0
    cycles.pixel_filter_type = "BOX"
    scene.render.film_transparent = True
    _write_floats(scene, "OPEN_EXR")


def _write_floats(
    scene: bpy.types.Scene, file_format: Literal["OPEN_EXR", "OPEN_EXR_MULTILAYER"]
) -> None:
    """All 32 bits: Blender 5 goes back to half floats with every change of the format."""
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):  # Blender 5
        layers = file_format == "OPEN_EXR_MULTILAYER"
        settings.media_type = "MULTI_LAYER_IMAGE" if layers else "IMAGE"
    settings.file_format = file_format
    settings.color_depth, settings.exr_codec = "32", "NONE"


def render(scene: bpy.types.Scene) -> np.ndarray:
    """(h, w, 3) float32, linear."""
    channels = render_channels(scene)
    return np.stack([channels[c] for c in "RGB"], axis=-1)


def render_channels(scene: bpy.types.Scene) -> dict[str, np.ndarray]:
    """Every channel (h, w) float32 of the EXR that the scene renders to, by its name there."""
    import OpenImageIO

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "probe.exr"
        scene.render.filepath = str(path)
        with (Path(folder) / "chatter").open("wb") as chatter, shader.output_into(chatter):
            bpy.ops.render.render(write_still=True, scene=scene.name)
        channels, part = {}, 0
        image = OpenImageIO.ImageBuf(str(path))
        parts = image.nsubimages
        while part < parts:
            image = OpenImageIO.ImageBuf(str(path), part, 0)
            pixels = image.get_pixels(OpenImageIO.FLOAT)[::-1]
            for i, name in enumerate(image.spec().channelnames):
                channels[name] = np.ascontiguousarray(pixels[..., i])
            part += 1
    return channels


class Probe:
    """Renders a scene's paint, one value at a time, without noise."""

    def __init__(self, scene: bpy.types.Scene, materials: list[bpy.types.Material]) -> None:
        self.scene = scene
        self.materials = materials
        self.nodes = [material.paint_node(m) for m in materials]
        make_noiseless(scene)

    def set(self, socket: str, value: object) -> None:
        for node in self.nodes:
            node.inputs[socket].default_value = value

    def image(self, diagnostic: int, light: int = 0, species: int = 0) -> np.ndarray:
        """(h, w, 3) float32: the diagnostic of the light slot and flake species (0-based)."""
        self.set("Diagnostic", diagnostic)
        self.set("Diagnostic Light", light + 1)
        self.set("Diagnostic Species", species + 1)
        try:
            if diagnostic in LIT:
                return render(self.scene)
            with _all_emitting(self.materials):
                return render(self.scene)
        finally:
            self.set("Diagnostic", 0)

    def geometry(self) -> Geometry:
        view = self.image(VIEW)
        pixel = self.image(PIXEL)
        return Geometry(
            hit=(view**2).sum(axis=-1) > 0.5,
            position=self.image(POSITION),
            normal=self.image(NORMAL),
            view=view,
            footprint=pixel[..., 0],
            pixel=pixel[..., 1:].astype(np.int32),
            raster=self.image(RASTER)[..., :2],
        )

    def passes(self) -> tuple[np.ndarray, np.ndarray]:
        """Cycles' own Position and Normal passes (h, w, 3)."""
        layer = self.scene.view_layers[0]
        layer.use_pass_position = layer.use_pass_normal = True
        _write_floats(self.scene, "OPEN_EXR_MULTILAYER")
        try:
            with _all_emitting(self.materials):
                channels = render_channels(self.scene)
        finally:
            _write_floats(self.scene, "OPEN_EXR")
            layer.use_pass_position = layer.use_pass_normal = False
        found = [
            np.stack([channels[f"{layer.name}.{name}.{c}"] for c in "XYZ"], axis=-1)
            for name in ("Position", "Normal")
        ]
        return found[0], found[1]

    def lit_by(
        self, lamps: Iterable[bpy.types.Object], diagnostic: int, light: int = 0
    ) -> np.ndarray:
        """The picture with these lamps alone, every light slot as it was."""
        all_lamps = [o for o in self.scene.objects if o.type == "LIGHT"]
        hidden = {o: o.hide_render for o in all_lamps}
        try:
            for o in all_lamps:
                o.hide_render = o not in lamps
            return self.image(diagnostic, light)
        finally:
            for o, was in hidden.items():
                o.hide_render = was


@contextlib.contextmanager
def _all_emitting(materials: list[bpy.types.Material]) -> Iterator[None]:
    with contextlib.ExitStack() as stack:
        for painted in materials:
            stack.enter_context(_emitting(painted))
        yield


@contextlib.contextmanager
def _emitting(painted: bpy.types.Material) -> Iterator[None]:
    """Lets the material emit what its paint shows, instead of its surface."""
    nodes, links = painted.node_tree.nodes, painted.node_tree.links
    surface = painted.node_tree.get_output_node("CYCLES").inputs["Surface"]
    was = [link.from_socket for link in surface.links]
    emission = nodes.new("ShaderNodeEmission")
    try:
        links.new(material.paint_node(painted).outputs[material.SHOWN], emission.inputs["Color"])
        links.new(emission.outputs[0], surface)
        yield
    finally:
        nodes.remove(emission)
        for socket in was:
            links.new(socket, surface)


def core_lights() -> list[Light]:
    """The slots in use, as the core takes them."""
    import metallic_paint_core as core

    return [core.Light(core.LightKind(int(kind)), vector, size)
            for kind, vector, size in lights.values()]  # fmt: skip


def predict(
    paint: Paint,
    slots: list[Light],
    geometry: Geometry,
    precision: Literal["float", "double"],
    species: int = 0,
) -> Pixels:
    """The core's values for the pixels with paint: arrays (pixels, lights, ...)."""
    import metallic_paint_core as core

    hit = geometry.hit
    return core.evaluate(
        paint,
        slots,
        position=geometry.position[hit],
        normal=geometry.normal[hit],
        view=geometry.view[hit],
        footprint=geometry.footprint[hit],
        pixel=geometry.own_pixel()[hit],
        precision=precision,
        species=species,
    )


def compare(
    paint: Paint,
    geometry: Geometry,
    predicted: list[Pixels],
    light: int,
    leader: int,
    counts: list[np.ndarray],
    cone: np.ndarray,
    picture: np.ndarray,
    irradiance: np.ndarray,
) -> Comparison:
    """Judges images (h, w[, 3]) against the core's prediction.

    predicted and counts are those of each flake species. picture and irradiance are lit by the lamp
    of the slot `light`; counts and cone are those of the slot that leads it: itself, unless another
    light is too close by.
    """
    hit = geometry.hit
    shifted = (geometry.pixel[hit] != geometry.own_pixel()[hit]).any(axis=-1)
    at_edge = shifted & _near_edge(geometry.raster[hit])
    same_count = edge = threshold = unexplained = 0
    all_same = np.ones(int(hit.sum()), dtype=bool)
    for species, (expected, count) in enumerate(zip(predicted, counts, strict=True)):
        found = count[hit]
        same = found == expected["count"][:, leader]
        step = _near_threshold(paint, geometry, expected, leader, species, found)
        same_count += int(same.sum())
        edge += int((~same & at_edge).sum())
        threshold += int((~same & ~at_edge & step).sum())
        unexplained += int((~same & ~at_edge & ~step).sum())
        all_same &= same

    per_irradiance = predicted[0]["radiance"][:, light]
    radiance = per_irradiance * irradiance[hit]
    lit = all_same & (radiance.max(axis=-1) > 0)
    by_chance = lit & (per_irradiance.mean(axis=-1) * cone[hit] < LEAST_WEIGHT)
    lit &= ~by_chance
    chance = np.zeros_like(hit)
    chance[hit] = by_chance
    error = np.abs(picture[hit][lit] - radiance[lit]).max(axis=-1) / radiance[lit].max(axis=-1)
    return Comparison(
        pixels=int(hit.sum()) * len(counts),
        same_count=same_count,
        at_pixel_edge=edge,
        at_threshold=threshold,
        unexplained=unexplained,
        radiance_error=error,
        by_chance=chance,
    )


def _near_edge(raster: np.ndarray) -> np.ndarray:
    """Raster positions within float rounding (16 ulp at 1000) of an edge between pixels."""
    return (np.abs(raster - np.round(raster)) < 1e-3).any(axis=-1)


def _near_threshold(
    paint: Paint,
    geometry: Geometry,
    predicted: Pixels,
    light: int,
    species: int,
    found: np.ndarray,
) -> np.ndarray:
    """Counts that the core finds too, when <N> and the uniform deviate move by their rounding.

    From afar and without contrast nothing is drawn: the count is <N>, to the nearest whole number.
    """
    import metallic_paint_core as core

    x, y = geometry.own_pixel()[geometry.hit].T
    words = core.hash_words(x, y, light=light, species=species, frame=paint.frame, seed=paint.seed)
    high, low = (words[:, i] >> 8 for i in (0, 1))
    uniform = (high + (low + 0.5) * 2.0**-24) * 2.0**-24
    mean, slots = predicted["mean_count"][:, light], predicted["slots"][:, light]
    fewest = core.count_deviate(
        mean * (1 - MEAN_ROUNDING), slots, np.minimum(uniform + UNIFORM_ROUNDING, 1)
    )
    most = core.count_deviate(
        mean * (1 + MEAN_ROUNDING), slots, np.maximum(uniform - UNIFORM_ROUNDING, 1e-15)
    )
    undrawn = (mean > FAR_COUNT) | (paint.sparkle_contrast == 0)
    undrawn &= np.abs(predicted["count"][:, light] - mean) <= 1 + mean * 1e-7
    as_mean = undrawn & (np.abs(found - mean) <= 1 + mean * MEAN_ROUNDING)
    return (fewest <= found) & (found <= most) | as_mean
