# SPDX-License-Identifier: Apache-2.0
"""The sun's image in the lacquer of a curved body: there at few samples, and no firefly."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest
import seeds
from metallic_paint import verify
from metallic_paint.paint import material, presets
from metallic_paint.scene import needs
from scenery import add_lamp

pytestmark = pytest.mark.long

PIXELS, HALF = 96, 8  # of the picture, and of the region about the glint
SAMPLES, SHOTS, CONVERGED = 16, 8, 2048
# Principled's light has a long tail: the deviation of eight of its shots is often half the truth.
PLAIN_SHOTS = 40


def ball() -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=0.075)


def torus() -> None:
    bpy.ops.mesh.primitive_torus_add(
        major_segments=128, minor_segments=48, major_radius=0.06, minor_radius=0.025,
        rotation=(0.9, 0.2, 0),
    )  # fmt: skip


def stage(body: object) -> bpy.types.Object:
    """15 cm of a painted body a metre away, under a sun, its flakes in their mean."""
    scene = bpy.context.scene
    material.set_up_cycles(scene)
    body()
    bpy.ops.object.shade_smooth()
    thing = bpy.context.object
    paint = material.create(presets.load("silver-coarse"))
    material.paint_node(paint).inputs["Sparkle Contrast"].default_value = 0
    material.assign(thing, paint)
    add_lamp("SUN", "Sun", energy=3, angle=math.radians(0.53), rotation_euler=(0.7, 0.3, 0))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -1, 0), (math.pi / 2, 0, 0)
    camera.data.angle = 2 * math.atan(0.09)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    needs.fit(scene)
    verify.make_noiseless(scene)
    return thing


def look_at_glint(thing: bpy.types.Object) -> None:
    """The region about the pixel that mirrors the sun best, off the silhouette."""
    scene = bpy.context.scene
    probe = verify.Probe(scene, [thing.active_material])
    seen = probe.geometry()
    probe.close()
    cosine = (seen.normal * seen.view).sum(axis=-1, keepdims=True)
    towards = np.array(bpy.data.objects["Sun"].matrix_world)[:3, 2]
    off = np.linalg.norm(2 * cosine * seen.normal - seen.view - towards, axis=-1)
    off[~seen.hit | (cosine[..., 0] < 0.3)] = np.inf
    y, x = np.unravel_index(int(off.argmin()), off.shape)
    render = scene.render
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x = (x - HALF + 0.5) / PIXELS, (x + HALF + 0.5) / PIXELS
    render.border_min_y, render.border_max_y = (y - HALF + 0.5) / PIXELS, (y + HALF + 0.5) / PIXELS


def shots(random: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The converged region, and several of few samples."""
    scene, found = bpy.context.scene, []
    for samples in (CONVERGED, *(count * [SAMPLES])):
        scene.cycles.samples = samples
        scene.cycles.seed = int(random.integers(2**31))
        found.append(verify.render(scene).mean(axis=-1))
    return found[0], np.array(found[1:])


def principled() -> bpy.types.Material:
    """A metal in a coat of Blender's own, whose roughness blurs the sun's disc a little."""
    plain = bpy.data.materials.new("Plain")
    if plain.node_tree is None:
        plain.use_nodes = True  # Blender 4.5
    inputs = plain.node_tree.nodes["Principled BSDF"].inputs
    values = {"Metallic": 1, "Roughness": 0.4, "Coat Weight": 1, "Coat Roughness": 0.03}
    for name, value in values.items():
        inputs[name].default_value = value
    return plain


@pytest.mark.parametrize("body", [ball, pytest.param(torus, marks=pytest.mark.long)])
def test_few_samples_find_the_suns_image(body: object) -> None:
    """The light of the region is as sure as a Principled coat's, and in most shots it is there.

    In the ball, 16 samples of a pixel of 2 mm missed the image in none of 192 shots, so in one of
    60 at most: in three of eight with a probability of 2e-4. With a hard rim one of 20 was missed,
    as small as the sun half of them.
    """
    random = seeds.fresh(660)
    thing = stage(body)
    look_at_glint(thing)
    converged, few = shots(random, SHOTS)
    thing.data.materials[0] = principled()
    plain, others = shots(random, PLAIN_SHOTS)
    sure = others.sum(axis=(1, 2)).std(ddof=1) / plain.sum()
    off = few.sum(axis=(1, 2)) / converged.sum() - 1
    assert np.abs(off).max() <= max(0.01, 3 * sure)
    around = np.median(converged)
    assert converged.max() > 4 * around
    there = (few > 3 * around).any(axis=(1, 2))
    assert there.sum() > SHOTS - 3
