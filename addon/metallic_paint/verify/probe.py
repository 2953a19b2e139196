# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the shader's inner values, without noise.

They tell where each pixel looks, and what the shader computed there (diagnostics.py).

Every array here is (height, width, ...) with row 0 at the bottom, as the shader counts pixels.
"""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import bpy
import numpy as np

from ..paint import material
from .diagnostics import (
    INSTANCE,
    NORMAL,
    OWN_POSITION,
    OWN_X,
    OWN_Y,
    OWN_Z,
    PIXEL,
    POSITION,
    RASTER,
    VIEW,
    attribute_of,
    set_properties,
    show,
    variants,
)


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
    own_position: np.ndarray  # (h, w, 3) m, in the object's own space
    own_axes: np.ndarray  # (h, w, 3, 3), that space's x, y and z in the world
    instance: np.ndarray  # (h, w) int, tells copies of an object apart
    origin: tuple[int, int] = (0, 0)  # x and y of the picture's first pixel in the whole frame

    def own_pixel(self) -> np.ndarray:
        """(h, w, 2): the coordinates of each pixel in the frame."""
        h, w = self.hit.shape
        x, y = self.origin
        return np.stack(np.meshgrid(np.arange(x, x + w), np.arange(y, y + h)), axis=-1)

    def places(self) -> dict[str, np.ndarray]:
        """The pixels with paint, as the core's functions take them."""
        hit = self.hit
        return {
            "position": self.position[hit],
            "normal": self.normal[hit],
            "view": self.view[hit],
            "footprint": self.footprint[hit],
            "pixel": self.own_pixel()[hit],
            "own_position": self.own_position[hit],
            "own_axes": self.own_axes[hit],
            "instance": self.instance[hit],
        }


def make_noiseless(scene: bpy.types.Scene) -> None:
    """One sample at the centre of each pixel, lit straight from the lamps, written as it is."""
    cycles = scene.cycles
    cycles.samples, cycles.seed = 1, 0
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.max_bounces = 0
    cycles.pixel_filter_type = "BOX"
    scene.render.film_transparent = True
    write_floats(scene, "OPEN_EXR")


def write_floats(
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
    """Renders a scene's paint, one value at a time, without noise.

    From its first image until close() or picture(), the paint is the variant that shows them.
    """

    def __init__(self, scene: bpy.types.Scene, materials: list[bpy.types.Material]) -> None:
        self.scene = scene
        self.materials = materials
        self.nodes = [material.paint_node(m) for m in materials]
        self._variants = contextlib.ExitStack()
        self._diagnosing = False
        self._driven: set[str] = set()
        make_noiseless(scene)

    def set(self, socket: str, value: float) -> None:
        if socket in self._driven:
            set_properties(self._painted(), {socket: value})
            return
        for node in self.nodes:
            node.inputs[socket].default_value = value

    def drive(self, socket: str) -> None:
        """Lets set() change the socket without a compilation: for whole numbers up to 2**24."""
        value = self.nodes[0].inputs[socket].default_value
        for painted, node in zip(self.materials, self.nodes, strict=True):
            attribute = attribute_of(painted.node_tree, socket)
            painted.node_tree.links.new(attribute.outputs["Fac"], node.inputs[socket])
        self._driven.add(socket)
        self.set(socket, value)

    def image(self, diagnostic: int, light: int = 0) -> np.ndarray:
        """(h, w, 3) float32: the diagnostic of the light slot (0-based)."""
        self._show(diagnostic, light)
        return render(self.scene)

    def picture(self) -> np.ndarray:
        """(h, w, 3) float32: the paint with the shader that ships."""
        self.close()
        return render(self.scene)

    def close(self) -> None:
        """The paint is as it was."""
        self._variants.close()
        self._diagnosing = False

    def _show(self, diagnostic: int, light: int = 0) -> None:
        if not self._diagnosing:
            self._variants.enter_context(variants(self.materials))
            # Cycles keeps the scene and its compiled shaders from one picture to the next.
            render_settings = self.scene.render
            was = render_settings.use_persistent_data
            self._variants.callback(setattr, render_settings, "use_persistent_data", was)
            render_settings.use_persistent_data = True
            self._diagnosing = True
        show(self._painted(), diagnostic, light)

    def _painted(self) -> list[bpy.types.Object]:
        return [
            thing
            for thing in self.scene.objects
            if any(slot.material in self.materials for slot in thing.material_slots)
        ]

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
            own_position=self.image(OWN_POSITION),
            own_axes=np.stack([self.image(axis) for axis in (OWN_X, OWN_Y, OWN_Z)], axis=-2),
            instance=self.image(INSTANCE)[..., 0].astype(np.int32),
        )

    def passes(self) -> tuple[np.ndarray, np.ndarray]:
        """Cycles' own Position and Normal passes (h, w, 3)."""
        layer = self.scene.view_layers[0]
        layer.use_pass_position = layer.use_pass_normal = True
        write_floats(self.scene, "OPEN_EXR_MULTILAYER")
        try:
            self._show(VIEW)
            channels = render_channels(self.scene)
        finally:
            write_floats(self.scene, "OPEN_EXR")
            layer.use_pass_position = layer.use_pass_normal = False
        found = [
            np.stack([channels[f"{layer.name}.{name}.{c}"] for c in "XYZ"], axis=-1)
            for name in ("Position", "Normal")
        ]
        return found[0], found[1]

    def lit_by(
        self, lit: Iterable[bpy.types.Object | bpy.types.World], diagnostic: int, light: int = 0
    ) -> np.ndarray:
        """The picture with these lamps alone, or the world, every light slot as it was."""
        all_lamps = [o for o in self.scene.objects if o.type == "LIGHT"]
        hidden, world = {o: o.hide_render for o in all_lamps}, self.scene.world
        try:
            for o in all_lamps:
                o.hide_render = o not in lit
            if world not in lit:
                self.scene.world = None
            return self.image(diagnostic, light)
        finally:
            self.scene.world = world
            for o, was in hidden.items():
                o.hide_render = was
