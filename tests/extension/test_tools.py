# SPDX-License-Identifier: Apache-2.0
"""Denoising, quality, report and check, from the zip: each with its button."""

from __future__ import annotations

import math

import bpy
import pytest
from recording import drawn

BUTTONS = {
    "MATERIAL_PT_metallic_paint_denoise": "scene.metallic_paint_denoise",
    "MATERIAL_PT_metallic_paint_quality": "scene.metallic_paint_quality",
    "MATERIAL_PT_metallic_paint_report": "scene.metallic_paint_report",
    "MATERIAL_PT_metallic_paint_verify": "scene.metallic_paint_verify",
}


@pytest.fixture
def scene() -> bpy.types.Scene:
    """A painted ball under a sun, before a camera."""
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = 48
    bpy.ops.object.light_add(type="SUN", rotation=(0.7, 0.3, 0))
    bpy.context.object.data.angle = math.radians(0.53)
    bpy.ops.object.camera_add(location=(0, -0.4, 0), rotation=(math.radians(90), 0, 0))
    scene.camera = bpy.context.object
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.05)
    bpy.ops.object.shade_smooth()
    bpy.ops.scene.metallic_paint_use_osl()
    bpy.ops.material.metallic_paint_new(preset="silver-coarse")
    return scene


@pytest.mark.parametrize("panel", BUTTONS)
def test_panel_offers_its_button(scene: bpy.types.Scene, panel: str) -> None:
    assert BUTTONS[panel] in drawn(getattr(bpy.types, panel)).names


@pytest.mark.parametrize("button", BUTTONS.values())
def test_button_does_its_work(scene: bpy.types.Scene, button: str) -> None:
    category, _, name = button.partition(".")
    assert getattr(getattr(bpy.ops, category), name)() == {"FINISHED"}


def test_check_runs_with_what_the_zip_holds(scene: bpy.types.Scene) -> None:
    bpy.ops.scene.metallic_paint_verify(size=32)
    shown = " ".join(drawn(bpy.types.MATERIAL_PT_metallic_paint_verify).texts)
    assert "agree with the core" in shown
    assert "DO NOT" not in shown
    assert tuple(bpy.data.images["Metallic Paint Core"].size) == (32, 32)
