# SPDX-License-Identifier: Apache-2.0
"""Pictures of flakes with more and more samples: the paint, explicit flakes, and the others.

equal_error.py makes errors of them, for which this Python lacks FLIP.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from metallic_paint.paint import Paint, material
from motion.scenes import voronoi
from pictures.render_scene import say
from verification import scenes

from bench import materials
from bench.equal_error import EXPLICIT, PAINT, Series, name_of
from bench.stage import TOWARDS_CAMERA, Stage

CORNERS = 6  # of a flake
SEED = 1  # of the converged picture; the others have 2


@dataclass(frozen=True)
class Effort:
    flakes: tuple[float, ...]  # in a pixel
    most_flakes: int  # in a picture; pictures of more flakes in a pixel are smaller
    size: int
    converged: int  # samples of a whole picture


FULL = Effort((4, 16, 64, 256, 1024), 300_000, 48, 1 << 21)
QUICK = Effort((16, 256), 60_000, 24, 1 << 18)
OF_CONVERGED = 1 / 4  # at most, of its samples the others have


def render_all(folder: Path, quick: bool) -> None:
    effort = QUICK if quick else FULL
    paint = Paint()
    stage = Stage([scenes.SUN])
    half = math.sqrt(effort.most_flakes / (paint.flakes_per_mm2 * 1e6)) / 2
    things = {EXPLICIT: explicit(paint, half)}
    for name, made in (
        (PAINT, material.create(paint)),
        ("Voronoi flakes", voronoi(paint)),
        ("noise flakes", materials.noise_flakes(paint)),
    ):
        bpy.ops.mesh.primitive_plane_add(size=2 * half)
        things[name] = bpy.context.object
        stage.scene.collection.objects.unlink(things[name])
        material.assign(things[name], made)
    for thing in things.values():
        stage.stand(thing, 2 * half)
    for flakes in effort.flakes:
        pixel = math.sqrt(flakes / (paint.flakes_per_mm2 * 1e6) * TOWARDS_CAMERA.z)
        # The picture's height lies aslant on the plane, and its rim has to hold flakes.
        size = min(effort.size, int(1.8 * half * TOWARDS_CAMERA.z / pixel))
        for name, thing in things.items():
            stage.look(name_of(name, flakes), thing, size, pixel * size)
    stage.fit()
    for flakes in effort.flakes:
        say(f"  {flakes:g} flakes in a pixel")
        for name in things:
            view = name_of(name, flakes)
            series(stage, view, effort).save(folder / f"{view}.npz")


def series(stage: Stage, view: str, effort: Effort) -> Series:
    most = effort.converged // stage.views[view].size ** 2
    counts = 4 ** np.arange(math.floor(math.log(most * OF_CONVERGED, 4)) + 1)
    converged = stage.picture(view, most, seed=SEED)
    pictures = [stage.picture(view, int(count), seed=SEED + 1) for count in counts]
    seconds = stage.per_sample(view, int(effort.converged * OF_CONVERGED))
    return Series(seconds, counts, np.array(pictures), most, converged)


def explicit(paint: Paint, half: float) -> bpy.types.Object:
    """Every flake of a square as a disc of six corners, in a mesh.

    Centres are uniform in the layer; normals are tilted as the binder shows them, eta times as
    wide; the metal is that of the Voronoi flakes, whose roughness is the flakes' spread.
    """
    rng = np.random.default_rng(0)
    count = round(paint.flakes_per_mm2 * 1e6 * (2 * half) ** 2)
    depth = paint.layer_thickness_um * 1e-6
    centre = rng.uniform([-half, -half, -depth], [half, half, 0], (count, 3))
    slope = rng.normal(scale=paint.binder_ior * paint.tilt, size=(count, 2))
    normal = np.concatenate([slope, np.ones((count, 1))], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    across = np.cross(normal, [0, 1, 0])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    along = np.cross(normal, across)
    # Of the disc's area.
    corner_radius = math.sqrt(2 * math.pi / (CORNERS * math.sin(2 * math.pi / CORNERS)))
    radius = corner_radius * paint.flake_diameter_um * 0.5e-6
    turn = np.arange(CORNERS) * 2 * math.pi / CORNERS
    corners = centre[:, None] + radius * (
        np.cos(turn)[:, None] * across[:, None] + np.sin(turn)[:, None] * along[:, None]
    )
    mesh = bpy.data.meshes.new(EXPLICIT)
    mesh.vertices.add(count * CORNERS)
    mesh.loops.add(count * CORNERS)
    mesh.polygons.add(count)
    mesh.vertices.foreach_set("co", corners.astype(np.float32).ravel())
    mesh.loops.foreach_set("vertex_index", np.arange(count * CORNERS, dtype=np.int32))
    mesh.polygons.foreach_set("loop_start", np.arange(count, dtype=np.int32) * CORNERS)
    mesh.update(calc_edges=True)
    metal = voronoi(paint)
    shader = metal.node_tree.nodes["Principled BSDF"]
    metal.node_tree.links.remove(shader.inputs["Normal"].links[0])
    mesh.materials.append(metal)
    return bpy.data.objects.new(EXPLICIT, mesh)
