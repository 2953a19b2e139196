# SPDX-License-Identifier: Apache-2.0
"""Draft, Final and Reference: each nearer to the truth, each says what it changes."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Iterator

import bpy
import numpy as np
import panels
import pytest
from metallic_paint import verify
from metallic_paint.interface import quality as interface
from metallic_paint.paint import material, presets
from metallic_paint.scene import needs, quality
from recording import drawn
from scenery import add_lamp

SIZE = 28


@pytest.fixture
def registered() -> Iterator[None]:
    with panels.registered(interface):
        yield


def build() -> bpy.types.Scene:
    """A ball of 4 cm under a sun and a grey world."""
    scene = bpy.context.scene
    material.set_up_cycles(scene)
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.02)
    bpy.context.object.name = "Ball"
    bpy.ops.object.shade_smooth()
    # A coat without roughness would mirror the sun itself, in a few noisy pixels; a rougher one
    # would blur the sparkles.
    paint = dataclasses.replace(presets.load("silver-coarse"), coat_roughness=0.1)
    material.assign(bpy.context.object, material.create(paint, "Silver"))
    add_lamp("SUN", "Sun", energy=3, angle=math.radians(0.53), rotation_euler=(0.9, 0.3, 0))
    scene.world = bpy.data.worlds.new("World")
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.5, 0.5, 1)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -0.4, 0), (math.radians(90), 0, 0)
    camera.data.angle = 2 * math.atan(0.045)
    scene.collection.objects.link(camera)
    scene.camera = camera
    needs.fit(scene)
    return scene


@pytest.mark.long
def test_each_is_nearer_to_the_truth() -> None:
    scene = build()
    verify.write_floats(scene, "OPEN_EXR")
    scene.cycles.sample_clamp_direct = 0.5  # would cut the sparkles
    verify.render(scene)  # compiles the shader
    pictures, seconds = {}, {}
    for each in quality.QUALITIES:
        quality.apply(scene, each)
        scene.cycles.seed = len(pictures)
        start = time.monotonic()
        pictures[each] = verify.render(scene).mean(axis=-1)
        seconds[each] = time.monotonic() - start
    truth = pictures["REFERENCE"]
    ball = truth > 0.1 * np.median(truth)
    bright = ball & (truth > 2 * np.median(truth)) & (truth < 20 * np.median(truth))
    assert bright.sum() > 20
    error = {
        each: float(np.sqrt(((picture - truth)[bright] ** 2).mean()) / truth[bright].mean())
        for each, picture in pictures.items()
    }
    assert error["FINAL"] < 0.6 * error["DRAFT"]
    assert error["FINAL"] < 0.05
    assert error["DRAFT"] < 0.2
    assert max(seconds["DRAFT"], seconds["FINAL"]) < seconds["REFERENCE"]
    for picture in pictures.values():  # nothing is cut
        assert picture[bright].mean() == pytest.approx(truth[bright].mean(), rel=0.05)


def test_what_changes_is_said_with_what_it_was(registered: None) -> None:
    scene = build()
    scene.cycles.samples, scene.cycles.sample_clamp_direct = 77, 2.5
    bounces = scene.cycles.max_bounces
    changed = quality.apply(scene, "DRAFT")
    assert "Max Samples: 77 → 64." in changed or "Samples: 77 → 64." in changed
    assert "Clamp Direct: 2.5 → 0." in changed
    assert scene.cycles.max_bounces == bounces
    assert quality.apply(scene, "DRAFT") == ["All settings are so already."]
    assert quality.is_set(scene, "DRAFT")
    assert not quality.is_set(scene, "FINAL")
    assert bpy.ops.scene.metallic_paint_quality(quality="REFERENCE") == {"FINISHED"}
    assert quality.is_set(scene, "REFERENCE")


@pytest.mark.parametrize("each", quality.QUALITIES)
def test_every_setting_that_changes_is_said(each: str) -> None:
    scene = build()

    def settings() -> dict[str, object]:
        names = [prop.identifier for prop in scene.cycles.bl_rna.properties]
        values = {name: getattr(scene.cycles, name) for name in names}
        return {k: v for k, v in values.items() if isinstance(v, bool | int | float | str)}

    before, paint = settings(), material.paint_of(scene.objects["Ball"].active_material)
    said = quality.apply(scene, each)
    after = settings()
    changed = [name for name in before if before[name] != after[name]]
    assert changed
    assert len(said) == len(changed)
    assert material.paint_of(scene.objects["Ball"].active_material) == paint


def test_reference_names_what_is_none(registered: None) -> None:
    scene = build()
    scene.cycles.use_denoising = True
    node = material.paint_node(scene.objects["Ball"].active_material)
    node.inputs["Radiometry"].default_value = node.inputs["Depth Model"].default_value = 1
    said = quality.apply(scene, "REFERENCE")
    assert "Silver keeps its radiometry published, not exact." in said
    assert "Silver keeps its depth model thinned, not correlated." in said
    assert "Denoising stays on: a reference has none." in said
    assert node.inputs["Radiometry"].default_value == 1


def test_reference_names_a_paint_of_an_older_version() -> None:
    scene = build()
    group = material.paint_node(scene.objects["Ball"].active_material).node_tree
    group["metallic_paint"] = material.VERSION - 1
    group.interface.clear()
    said = quality.apply(scene, "REFERENCE")
    assert "Silver: The paint is of an older version: update it first." in said


ALONE = ("time_limit", "light_sampling_threshold", "blur_glossy")  # what Reference alone sets


def alone(scene: bpy.types.Scene) -> list[float]:
    return [getattr(scene.cycles, name) for name in ALONE]


@pytest.mark.parametrize("after", ["DRAFT", "FINAL"])
def test_what_reference_alone_sets_is_put_back(after: str) -> None:
    scene = build()
    cycles = scene.cycles
    cycles.time_limit, cycles.light_sampling_threshold, cycles.blur_glossy = 60, 0.25, 0.5
    quality.apply(scene, after)
    assert alone(scene) == [60, 0.25, 0.5]
    for _ in range(2):  # once more changes nothing
        quality.apply(scene, "REFERENCE")
    assert alone(scene) == [0, 0, 0]
    assert "Time Limit: 0 → 60." in quality.apply(scene, after)
    assert alone(scene) == [60, 0.25, 0.5]
    quality.apply(scene, "REFERENCE")
    cycles.time_limit = 30  # since then, so it stays
    quality.apply(scene, after)
    assert alone(scene) == [30, 0.25, 0.5]
    cycles.blur_glossy = 0
    quality.apply(scene, after)
    assert alone(scene) == [30, 0.25, 0]


def test_where_it_is_not_known_what_was_before_reference_it_is_blenders_default() -> None:
    """As in a file that an older version saved."""
    scene = build()
    defaults = alone(scene)
    for name, value in quality.QUALITIES["REFERENCE"].settings.items():
        setattr(scene.cycles, name, value)
    quality.apply(scene, "FINAL")
    assert alone(scene) == defaults


def test_reference_says_what_it_alone_sets(registered: None) -> None:
    scene = build()
    [said] = [" ".join(drawn(interface.MATERIAL_PT_metallic_paint_quality).texts[3:])]
    names = [scene.cycles.bl_rna.properties[name].name for name in ALONE]
    for text in (said, quality.QUALITIES["REFERENCE"].description):
        assert all(name in text for name in names)


def test_an_unknown_quality_and_another_engine_are_refused(registered: None) -> None:
    scene = build()
    with pytest.raises(ValueError, match="quality is 'BEST' and must be one of DRAFT, FINAL, REF"):
        quality.apply(scene, "BEST")
    scene.render.engine = "BLENDER_WORKBENCH"
    with pytest.raises(RuntimeError, match="does not render with Cycles"):
        bpy.ops.scene.metallic_paint_quality()


def test_the_panel_has_three_buttons(registered: None) -> None:
    build()
    buttons = drawn(interface.MATERIAL_PT_metallic_paint_quality).names
    assert buttons.count("scene.metallic_paint_quality") == 3
