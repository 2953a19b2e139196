# SPDX-License-Identifier: Apache-2.0
"""A light that moves compiles nothing, nor does a frame that draws the flakes anew: the picture is
that of the light that always stood so, of a paint that always had that Frame."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO
import pytest
from metallic_paint import verify
from metallic_paint.paint import material, presets
from metallic_paint.scene import needs
from scenery import add_lamp, show_as_instance

pytestmark = pytest.mark.long

SCRIPT = Path(__file__).with_name("count_programs.py")
SECONDS = 120


@pytest.fixture
def blend(tmp_path: Path) -> Path:
    """A painted ball under an animated sun, the lamp Lamp, and one that an empty shows."""
    scene = bpy.context.scene
    material.set_up_cycles(scene)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.02)
    paint = material.create(presets.load("silver-coarse"), "Painted")
    material.paint_node(paint).inputs[material.NEW_IN_EVERY_FRAME].default_value = True
    material.assign(bpy.context.object, paint)
    sun = add_lamp("SUN", "Sun", energy=2)
    for frame, turn in ((1, 0.3), (10, 0.8)):
        sun.rotation_euler.x = sun.data.energy = sun.data.angle = turn
        sun.keyframe_insert("rotation_euler", frame=frame)
        sun.data.keyframe_insert("energy", frame=frame)
        sun.data.keyframe_insert("angle", frame=frame)
    add_lamp("POINT", "Lamp", energy=6, shadow_soft_size=0.01, location=(0.4, 0.2, 0.5))
    show_as_instance(
        add_lamp("POINT", "Shown", energy=6, shadow_soft_size=0.01, location=(-0.4, 0.2, 0.5))
    )
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location.z = 1
    camera.data.type, camera.data.ortho_scale = "ORTHO", 0.05
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = 64
    needs.fit(scene)
    verify.make_noiseless(scene)
    file = tmp_path / "lit.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    return file


def read(file: Path) -> np.ndarray:
    return OpenImageIO.ImageBuf(str(file)).get_pixels(OpenImageIO.FLOAT)[..., :3]


def test_lights_that_move_and_frames_that_are_drawn_anew_compile_nothing(
    blend: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "programs"
    folder.mkdir()
    environment = {
        **os.environ,
        "OSL_OPTIONS": "llvm_output_bitcode=1",
        "BLENDER_USER_RESOURCES": str(tmp_path / "user"),
    }
    done = subprocess.run(
        [sys.executable, SCRIPT, blend, tmp_path / "there"], cwd=folder, env=environment,
        capture_output=True, text=True, timeout=SECONDS, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    [counted] = [line for line in done.stdout.splitlines() if line.startswith("Programs:")]
    first, moved, next_frame, slider = map(int, counted.split()[1:])
    assert (moved, next_frame) == (0, 0)
    assert first > 0
    assert slider > 0  # or the counting is broken

    there = {name: read(tmp_path / f"there-{name}.exr") for name in ("first", "moved", "next")}
    for name in ("moved", "next"):
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / f"there-{name}.blend"))
        inputs = material.paint_node(bpy.data.materials["Painted"]).inputs
        inputs[material.NEW_IN_EVERY_FRAME].default_value = False
        inputs["Frame"].default_value = bpy.context.scene.frame_current
        np.testing.assert_array_equal(verify.render(bpy.context.scene)[::-1], there[name])
    for one, other in (("first", "moved"), ("moved", "next")):
        assert (there[one] != there[other]).any(axis=-1).sum() > 100
    # The paint, and not its lights alone: at the frame of before it is another.
    inputs["Frame"].default_value -= 1
    assert (verify.render(bpy.context.scene)[::-1] != there["next"]).any(axis=-1).sum() > 100
