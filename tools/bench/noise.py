# SPDX-License-Identifier: Apache-2.0
"""Noise of what flakes mirror, beside a Principled metal, on a ball under lights of any size."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator

import bpy
import numpy as np
from mathutils import Vector
from metallic_paint import verify
from metallic_paint.paint import material, presets
from metallic_paint.scene import needs
from pictures.render_scene import say
from verification import scenes

from bench import materials
from bench.rows import Row
from bench.stage import THREADS

# Twelve rows, three paints under four lights. Each light asks another part of the shader: a small
# lamp, wide ones, a world, and lobes that lean away from a sun. So does each paint: metal flakes
# (silver-fine has as much noise or less), colours, and pearls over a white substrate. 256 samples:
# of 16 figures 13 were nearer to the bar than at 16. Noise at equal time is left out: it is that at
# equal samples, times the root of the time per sample, which has a part of its own.
PRESETS = ("silver-coarse", "candy-red", "white-pearl")
SAMPLES = 256
PRINCIPLED = "Principled"
RADIUS = 0.1  # m, of the ball
FRAME = 2.1  # radii of the ball, the picture's side
SUN_IMAGE = 0.1  # rad of the ball about the sun's image in the coat
MOST = 1.5  # of Principled's noise at equal samples: 2.25 times as many make up for it


def area(
    side: float, place: tuple[float, float, float], watt: float, shape: str = "SQUARE"
) -> None:
    """A lamp that faces the ball."""
    data = bpy.data.lights.new("Area", "AREA")
    data.shape, data.size, data.energy = shape, side, watt
    item = bpy.data.objects.new("Area", data)
    item.location = place
    item.rotation_euler = Vector(place).to_track_quat("Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(item)


def lamp() -> None:
    """10 cm, 24 cm from the paint."""
    area(0.1, Vector((0.3, -0.7, 0.65)).normalized() * (RADIUS + 0.24), 5, "DISK")


def softboxes() -> None:
    area(1.2, (1.1, -0.6, 1.2), 60)
    area(0.9, (-1.2, -0.5, 0.4), 30)


def sun_and_softbox() -> None:
    sun = scenes.sun("Sun", 50, -110, 0.53)(bpy.context.scene)
    sun.data.cycles.use_multiple_importance_sampling = True
    area(1.2, (1.1, -0.6, 1.2), 60)


def hdri() -> None:
    """A room with windows, walls of some brightness and a dark floor."""
    h, w = 128, 256
    pixels = np.ones((h, w, 4), dtype=np.float32)
    pixels[..., :3] = 0.15
    pixels[: h // 2, :, :3] = 0.05
    for azimuth, width in ((20, 30), (90, 14), (150, 40), (215, 20)):
        at = slice(azimuth, azimuth + width)
        pixels[72:104, at, :3] = (6, 7, 8)
    image = bpy.data.images.new("Room", w, h, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    world = bpy.context.scene.world = bpy.data.worlds.new("Room")
    if world.node_tree is None:
        world.use_nodes = True  # Blender 4.5
    tree = world.node_tree
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = image
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])


LIGHTS: dict[str, Callable[[], None]] = {
    "a lamp near by": lamp,
    "two softboxes": softboxes,
    "an HDRI": hdri,
    "sun and softbox": sun_and_softbox,
}


class Ball:
    """Balls of several materials in one place, of which a picture shows one.

    Its noise is judged without the image of a sun in the coat: a few pixels in which a sample more
    or less is all the noise of a picture, and another with each pair of seeds. Rims are left out.
    """

    def __init__(self, light: Callable[[], None], made: Callable[[], dict], size: int) -> None:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = scene = bpy.context.scene
        material.set_up_cycles(scene)
        verify.make_noiseless(scene)
        light()
        cycles = scene.cycles
        cycles.use_adaptive_sampling = cycles.use_denoising = False
        scene.render.film_transparent = True
        scene.render.use_persistent_data = True
        scene.render.threads_mode, scene.render.threads = "FIXED", THREADS
        scene.render.resolution_x = scene.render.resolution_y = size
        scene.render.resolution_percentage = 100
        self.balls = {}
        for name, each in made().items():
            bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=RADIUS)
            ball = self.balls[name] = bpy.context.object
            for polygon in ball.data.polygons:
                polygon.use_smooth = True
            material.assign(ball, each)
        data = bpy.data.cameras.new("Camera")
        data.type, data.ortho_scale = "ORTHO", FRAME * RADIUS
        camera = scene.camera = bpy.data.objects.new("Camera", data)
        camera.location = Vector((0.1, -1, 0.35))
        camera.rotation_euler = camera.location.to_track_quat("Z", "Y").to_euler()
        scene.collection.objects.link(camera)
        needs.fit(scene)
        self.judged = self.pixels_judged(size)

    def pixels_judged(self, size: int) -> np.ndarray:
        bpy.context.view_layer.update()
        to_camera = self.scene.camera.matrix_world.to_quaternion().inverted()
        y, x = (np.indices((size, size)) - (size - 1) / 2) * FRAME / size  # radii
        judged = np.hypot(x, y) < 0.95
        normal = np.stack([x, y, np.sqrt(np.maximum(1 - x**2 - y**2, 0))], axis=-1)
        for item in self.scene.objects:
            if item.type == "LIGHT" and item.data.type == "SUN":
                towards = to_camera @ item.matrix_world.to_quaternion() @ Vector((0, 0, 1))
                half = (towards + Vector((0, 0, 1))).normalized()
                judged &= normal @ np.array(half) < math.cos(SUN_IMAGE)
        return judged

    def picture(self, name: str, samples: int, seed: int = 0) -> np.ndarray:
        for each, ball in self.balls.items():
            ball.hide_render = each != name
        self.scene.cycles.samples, self.scene.cycles.seed = samples, seed
        return verify.render(self.scene)

    def noise(self, name: str, samples: int) -> float:
        """Of brightness, relative to its mean over the ball."""
        one, other = (self.picture(name, samples, seed).mean(axis=-1) for seed in (1, 2))
        noise = math.sqrt(((one - other)[self.judged] ** 2).mean() / 2)
        return noise / float((one + other)[self.judged].mean() / 2)


def contenders() -> dict[str, bpy.types.Material]:
    made = {
        name: material.create(dataclasses.replace(presets.load(name), sparkle_contrast=0))
        for name in PRESETS
    }
    metal = made[PRINCIPLED] = materials.principled()
    metal.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.4
    return made


def noise(quick: bool) -> Iterator[Row]:
    size = 64 if quick else 128
    for lit, light in LIGHTS.items():
        say(f"  under {lit}")
        ball = Ball(light, contenders, size)
        found = {name: ball.noise(name, SAMPLES) for name in ball.balls}
        for name in PRESETS:
            over = found[name] / found[PRINCIPLED]
            behind = f"{found[name]:.3f} / {found[PRINCIPLED]:.3f}"
            what = f"{lit}: noise of {name} over {PRINCIPLED}, {SAMPLES} samples"
            yield Row(what, [over], MOST, orientation=behind)
