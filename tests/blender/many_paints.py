# SPDX-License-Identifier: Apache-2.0
"""Many spheres in one picture, each with a paint of its own. Their sockets are linked to properties
of the objects, so that Blender compiles one shader for all of them, which folds no value away."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

import bpy
import numpy as np
from bench.shared import Sockets, link_sockets
from mathutils import Vector
from metallic_paint import verify
from verification import scenes

RADIUS = 0.45  # metres; the spheres stand a metre apart


class ManyPaints:
    """The scene, and which sphere each pixel of its picture shows."""

    def __init__(self, paints: Sequence[Sockets], lamp: Callable, size: int) -> None:
        """size x size pixels for each sphere, that are as fine as those of one sphere 5 m away."""
        scene = bpy.context.scene
        side = math.ceil(math.sqrt(len(paints)))
        spec = scenes.Scene(
            "spheres", (lamp,), shape="sphere", width=side, distance=5 * side, scale=(RADIUS,) * 3
        )
        item = scenes.build(scene, spec, size * side)
        self.lamp = next(each for each in scene.objects if each.type == "LIGHT")
        self.probe = verify.Probe(scene, [item.active_material])
        link_sockets(self.probe.nodes[0])
        right, up, _ = scene.camera.matrix_basis.to_3x3().transposed()
        places = []
        for i, values in enumerate(paints):
            each = item if i == 0 else item.copy()
            if i:
                scene.collection.objects.link(each)
            row, column = divmod(i, side)
            each.location = right * (column - (side - 1) / 2) + up * ((side - 1) / 2 - row)
            for label, value in values.items():
                each[label] = value
            places.append(each.location)
        self.geometry = self.probe.geometry()
        self._owner = self._nearest(places)

    def of(self, i: int) -> verify.Geometry:
        """The geometry of the pixels that show one paint."""
        return dataclasses.replace(self.geometry, hit=self.geometry.hit & (self._owner == i))

    def _nearest(self, places: Sequence[Vector]) -> np.ndarray:
        nearest = np.full(self.geometry.hit.shape, -1)
        least = np.full(nearest.shape, RADIUS * 1.01)
        for i, place in enumerate(places):
            away = np.linalg.norm(self.geometry.position - np.array(place), axis=-1)
            nearest[away < least] = i
            least = np.minimum(least, away)
        return nearest
