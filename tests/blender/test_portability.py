# SPDX-License-Identifier: Apache-2.0
"""A saved file renders on a machine without the add-on, in a new process, in another Blender."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO
import pytest
from common import environments
from metallic_paint import verify
from metallic_paint.paint import material, presets
from metallic_paint.scene import needs
from scenery import add_lamp

pytestmark = pytest.mark.long

SIZE = 64
FRAMES = (1, 20)
SECONDS = 300
SCRIPT = Path(__file__).with_name("open_and_render.py")


def build() -> bpy.types.Scene:
    """A ball, flakes coloured by a texture, under sun, spot and a parented, animated lamp."""
    scene = bpy.context.scene
    material.set_up_cycles(scene)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.02)
    bpy.ops.object.shade_smooth()
    paint = material.create(presets.load("silver-coarse"))
    material.assign(bpy.context.object, paint)
    tree = paint.node_tree
    place = tree.nodes.new("ShaderNodeTexCoord")
    checker = tree.nodes.new("ShaderNodeTexChecker")
    checker.inputs["Color1"].default_value = (0.9, 0.5, 0.1, 1)
    checker.inputs["Color2"].default_value = (0.1, 0.4, 0.9, 1)
    tree.links.new(place.outputs["Generated"], checker.inputs["Vector"])
    tree.links.new(checker.outputs["Color"], material.paint_node(paint).inputs["Flake Color"])

    add_lamp("SUN", "Sun", energy=2, angle=math.radians(0.53), rotation_euler=(0.6, 0.2, 0))
    spot = {"location": (-0.6, -0.3, 0.7), "rotation_euler": (0.6, -0.6, 0)}
    add_lamp("SPOT", "Spot", energy=8, spot_size=1, shadow_soft_size=0.01, **spot)
    arm = bpy.data.objects.new("Arm", None)
    arm.scale = (1, -1.5, 1)  # mirrored and uneven
    scene.collection.objects.link(arm)
    for frame, turn in zip(FRAMES, (0.0, 1.0), strict=True):
        arm.rotation_euler.z = turn
        arm.keyframe_insert("rotation_euler", frame=frame)
    lamp = add_lamp("POINT", "Point", energy=6, shadow_soft_size=0.01, location=(0.4, 0.2, 0.5))
    lamp.parent = arm

    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (0, 0, 1)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 0.05
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    needs.fit(scene)
    verify.make_noiseless(scene)
    scene.cycles.samples = 64
    return scene


def rendered_here(scene: bpy.types.Scene) -> list[np.ndarray]:
    pictures = []
    for frame in FRAMES:
        scene.frame_set(frame)
        pictures.append(verify.render(scene))
    return pictures


def rendered_there(python: Path, blend: Path, folder: Path) -> list[np.ndarray]:
    command = [python, SCRIPT, blend, folder / "there", *map(str, FRAMES)]
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(folder / "user")}
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=SECONDS,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return [read(folder / f"there-{frame}.exr") for frame in FRAMES]


def read(file: Path) -> np.ndarray:
    return OpenImageIO.ImageBuf(str(file)).get_pixels(OpenImageIO.FLOAT)[::-1, :, :3]


def other_blenders() -> Iterator[Path]:
    """The Pythons of the other Blenders, beside the one that runs here."""
    for blender in (*environments.BLENDERS, environments.BLENDER_BETWEEN):
        python = Path(sys.prefix).parent / blender.environment.folder.name / "bin" / "python"
        if not bpy.app.version_string.startswith(blender.version) and python.is_file():
            yield python


def save(tmp_path: Path) -> tuple[Path, list[np.ndarray]]:
    scene = build()
    pictures = rendered_here(scene)
    # The lamp's path shows, so nothing but drivers can have brought it to the shader.
    # The scale leaves out the few pixels where a sample happens to meet a lamp in the sharp coat.
    assert np.abs(pictures[0] - pictures[1]).max() > 0.1 * np.quantile(pictures[0], 0.999)
    file = tmp_path / "paint.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file), copy=True)
    return file, pictures


def test_a_new_process_without_the_add_on_renders_the_same_bits(tmp_path: Path) -> None:
    file, pictures = save(tmp_path)
    for here, there in zip(
        pictures, rendered_there(Path(sys.executable), file, tmp_path), strict=True
    ):
        np.testing.assert_array_equal(there, here)


def test_another_blender_renders_the_same_picture(tmp_path: Path) -> None:
    blenders = list(other_blenders())
    if not blenders:
        pytest.skip("No other Blender is installed here: ./paint test installs what it can.")
    file, pictures = save(tmp_path)
    for blender in blenders:
        for here, there in zip(pictures, rendered_there(blender, file, tmp_path), strict=True):
            off = np.abs(there - here).max(axis=-1) / here.max()
            # Cycles rounds elsewhere; seen 1e-6. In the worst pixel a flake falls on the other side
            # of a cone's edge: seen 6e-4 with three flakes a sample, 1e-2 with one.
            assert np.quantile(off, 0.99) < 1e-5
            assert off.max() < 3e-2
