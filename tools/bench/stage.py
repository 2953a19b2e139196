# SPDX-License-Identifier: Apache-2.0
"""Painted planes side by side in one scene, of which the camera sees one at a time.

So every contender stays compiled while the race goes round. Times are processor times.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Vector
from metallic_paint import verify
from metallic_paint.paint import material
from metallic_paint.scene import needs

from bench.rows import by_turns

WIDTH = 0.2  # m, what a picture shows
THREADS = 2
TOWARDS_CAMERA = Vector((0.1, -math.cos(math.radians(50)), math.sin(math.radians(50)))).normalized()

Lamp = Callable[[bpy.types.Scene], bpy.types.Object]


@dataclass(frozen=True)
class View:
    """A plane, its part that the picture shows, and how the picture is rendered."""

    place: float
    width: float
    size: int  # pixels along each side
    osl: bool


class Stage:
    def __init__(self, lamps: Sequence[Lamp], sky: float = 0, threads: int = THREADS) -> None:
        """Under the lamps, and a world of that radiance."""
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = scene = bpy.context.scene
        self.views: dict[str, View] = {}
        self._end = 0.0  # of the planes
        material.set_up_cycles(scene)
        verify.make_noiseless(scene)
        scene.render.resolution_percentage = 100
        scene.render.threads_mode, scene.render.threads = "FIXED", threads
        scene.render.use_persistent_data = True  # keeps the shaders compiled
        self.lamps = [add(scene) for add in lamps]
        if sky:
            world = scene.world = bpy.data.worlds.new("Sky")
            if world.node_tree is None:
                world.use_nodes = True  # Blender 4.5
            world.node_tree.nodes["Background"].inputs["Color"].default_value = [sky] * 3 + [1]
        data = bpy.data.cameras.new("Camera")
        data.type = "ORTHO"
        self.camera = scene.camera = bpy.data.objects.new("Camera", data)
        self.camera.rotation_euler = TOWARDS_CAMERA.to_track_quat("Z", "Y").to_euler()
        scene.collection.objects.link(self.camera)
        self._without_osl: bpy.types.Scene | None = None

    def add(
        self, name: str, materials: Sequence[bpy.types.Material], size: int, width: float = WIDTH,
        osl: bool = True,
    ) -> None:  # fmt: skip
        """A plane in as many strips as there are materials."""
        half, n = 4 * width, len(materials)
        mesh = bpy.data.meshes.new(name)
        xs = [width * (i / n - 0.5) for i in range(n + 1)]
        xs[0], xs[-1] = -half, half
        corners = [(x, y, 0) for x in xs for y in (-half, half)]
        mesh.from_pydata(corners, [], [(2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1) for i in range(n)])
        for i, each in enumerate(materials):
            mesh.materials.append(each)
            mesh.polygons[i].material_index = i
        thing = bpy.data.objects.new(name, mesh)
        self.stand(thing, half)
        self.look(name, thing, size, width, osl)

    def stand(self, thing: bpy.types.Object, half: float) -> None:
        """Beside the others; it reaches so far from its middle."""
        thing.location.x = self._end + half
        self._end += 2.2 * half
        self.scene.collection.objects.link(thing)

    def look(
        self, name: str, thing: bpy.types.Object, size: int, width: float, osl: bool = True
    ) -> None:
        """A view of its middle."""
        self.views[name] = View(thing.location.x, width, size, osl)

    def light_with(self, count: int) -> None:
        """The first lamps alone."""
        for i, lamp in enumerate(self.lamps):
            shines = lamp.name in self.scene.collection.objects
            if shines != (i < count):
                objects = self.scene.collection.objects
                (objects.unlink if shines else objects.link)(lamp)
        self.fit()

    def fit(self) -> None:
        """The paints to the scene, as the add-on does it; call it when all is there."""
        needs.fit(self.scene)
        if any(not view.osl for view in self.views.values()):
            self._without_osl = self.scene.copy()
            self._without_osl.cycles.shading_system = False

    def picture(self, name: str, samples: int, seed: int = 0) -> np.ndarray:
        """(size, size, 3), linear."""
        self.scene.cycles.seed = seed
        return verify.render(self._aim(name, samples))

    def render(self, name: str, samples: int) -> float:
        """s of one processor for the picture."""
        scene = self._aim(name, samples)
        start = time.process_time()
        verify.render(scene)
        return time.process_time() - start

    def _aim(self, name: str, samples: int) -> bpy.types.Scene:
        """The scene that shows the view."""
        view = self.views[name]
        scene = self.scene
        if not view.osl:
            assert self._without_osl is not None
            scene = self._without_osl
        data, distance = self.camera.data, 10 * view.width
        data.ortho_scale, data.clip_start, data.clip_end = view.width, distance / 10, 10 * distance
        self.camera.location = distance * TOWARDS_CAMERA + Vector((view.place, 0, 0))
        scene.render.resolution_x = scene.render.resolution_y = view.size
        scene.cycles.samples = samples
        return scene

    def per_sample(self, name: str, samples: int) -> float:
        """s of one processor for each of about so many samples, less what a picture costs besides.

        The first picture compiles.
        """
        pixels = self.views[name].size ** 2
        count = max(samples // pixels, 1)  # in a pixel
        self.render(name, 1)
        start, whole = self.render(name, 1), self.render(name, count + 1)
        return (whole - start) / (count * pixels)

    def race(self, samples: int, repetitions: int) -> dict[str, list[float]]:
        """Of every view, per sample, by turns."""
        return by_turns(self.views, lambda name: self.per_sample(name, samples), repetitions)
