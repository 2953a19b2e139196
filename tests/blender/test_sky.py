# SPDX-License-Identifier: Apache-2.0
"""The sun of a world has a slot: Blender's sky, and the brightest spot of an environment image."""

from __future__ import annotations

import math
import os
from pathlib import Path

import bpy
import metallic_paint_core as core
import numpy as np
import pytest
import seeds
from mathutils import Euler, Vector
from metallic_paint import verify
from metallic_paint.interface import operators
from metallic_paint.native import core_lights
from metallic_paint.paint import Paint, core_paint
from metallic_paint.scene import carrier, lights, needs, sky
from scenery import HEIGHT, WIDTH, disc, world_of
from verification import scenes


def random_sun(number: int) -> tuple[np.ndarray, float]:
    random = seeds.fresh(number)
    towards = random.normal(size=3)
    towards[2] = abs(towards[2]) + 0.5
    return towards / np.linalg.norm(towards), float(random.uniform(0.008, 0.015))


def test_the_spot_is_found_with_direction_and_size() -> None:
    for k in range(4):
        towards, radius = random_sun(620 + k)
        spot = sky.spot_of(disc(towards, radius, 1e5, 0.3))
        assert spot is not None
        assert Vector(spot.direction).angle(Vector(towards)) < 2e-3
        assert spot.sine == pytest.approx(math.sin(radius), rel=0.12)  # of pixels 3 mrad wide
        assert spot.irradiance == pytest.approx(1e5 * math.pi * math.sin(radius) ** 2, rel=0.24)


def test_what_is_no_sun_has_no_slot() -> None:
    towards, _ = random_sun(630)
    assert sky.spot_of(disc(towards, 0.01, 50, 0.3)) is None  # a share of 1 %
    assert sky.spot_of(disc(towards, 0.5, 10, 0.1)) is None  # a window
    assert sky.spot_of(np.zeros((512, 1024), np.float32)) is None


def test_a_hot_pixel_is_no_sun_beside_a_sun_of_more_light() -> None:
    towards, radius = random_sun(635)
    light = disc(towards, radius, 2e3, 0.01)
    light[HEIGHT // 4, WIDTH // 3] = 3e3
    spot = sky.spot_of(light)
    assert spot is not None
    assert Vector(spot.direction).angle(Vector(towards)) < 2e-3


def test_the_slot_follows_the_worlds_mapping_and_the_skys_sun() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scenes.build(bpy.context.scene, scenes.Scene("sky", paint=Paint(), lamps=()), 16)
    towards, radius = random_sun(640)
    node = world_of(disc(towards, radius, 1e5, 0.3))
    scene, tree = bpy.context.scene, bpy.context.scene.world.node_tree
    assert needs.fit(scene).lights.sky == "the sun of World"
    assert "light 1: the sun of World" in needs.said()
    [(kind, vector, _, _)] = carrier.values()
    assert kind == carrier.SKY
    assert vector.angle(Vector(towards)) < 2e-3
    mapping, where = tree.nodes.new("ShaderNodeMapping"), tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(where.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], node.inputs["Vector"])
    mapping.inputs["Rotation"].default_value = turn = Euler((0.1, 0.2, 0.5))
    assert not needs.is_fitted(scene)
    needs.fit(scene)
    expected = turn.to_matrix().inverted() @ Vector(towards)
    assert carrier.values()[0][1].angle(expected) < 2e-3

    blue = tree.nodes.new("ShaderNodeTexSky")
    tree.links.new(blue.outputs[0], tree.nodes["Background"].inputs["Color"])
    blue.sun_elevation, blue.sun_rotation = 0.6, 0.7
    needs.fit(scene)
    [(_, vector, size, _)] = carrier.values()
    across = math.cos(0.6)
    assert (
        vector.angle(Vector((math.sin(0.7) * across, math.cos(0.7) * across, math.sin(0.6)))) < 1e-4
    )
    assert size == pytest.approx(math.sin(blue.sun_size / 2), rel=1e-5)
    blue.sun_disc = False
    needs.fit(scene)
    assert carrier.values() == []
    assert lights.constant("Light1Kind") == 0


SMALL = 256, 128  # pixels, of images that are written and changed


def paint_sun(image: bpy.types.Image, column: int) -> None:
    pixels = np.zeros((SMALL[1], SMALL[0], 4), np.float32)
    pixels[SMALL[1] * 3 // 4, column, :3] = 1e4
    image.pixels.foreach_set(pixels.ravel())


def write_sun(file: Path, column: int) -> None:
    image = bpy.data.images.new("Written", *SMALL, float_buffer=True)
    paint_sun(image, column)
    image.file_format, image.filepath_raw = "OPEN_EXR", str(file)
    image.save()
    bpy.data.images.remove(image)


def is_at(scene: bpy.types.Scene, column: int) -> bool:
    towards = Vector(sky.find(scene).direction)
    turn = -2 * math.pi * ((column + 0.5) / SMALL[0] - 0.5)
    return abs(math.remainder(math.atan2(towards.y, towards.x) - turn, 2 * math.pi)) < 0.05


@pytest.mark.parametrize("looked", ["before", "between", "shown"])
def test_the_sun_of_a_file_that_changed_is_found_once_it_is_loaded_anew(
    tmp_path: Path, looked: str
) -> None:
    """Whether one looks before it is loaded, or something else does so after."""
    file, scene = tmp_path / "sky.exr", bpy.context.scene
    write_sun(file, 40)
    node = world_of(np.full((HEIGHT, WIDTH), 0.01, np.float32))
    node.image = bpy.data.images.load(str(file))
    assert is_at(scene, 40)
    write_sun(file, 200)
    os.utime(file, (2e9, 2e9))  # a clock may be too coarse to tell the two apart
    if looked == "between":
        assert is_at(scene, 40)
    node.image.reload()
    if looked == "shown":
        assert tuple(node.image.size) == SMALL
    assert is_at(scene, 200)


def test_an_image_of_8_bits_is_judged_by_its_light() -> None:
    """A white dot on a dark grey, whose values are ten times its light."""
    scene = bpy.context.scene
    node = world_of(np.zeros((HEIGHT, WIDTH), np.float32))
    pixels = np.full((256, 512, 4), 3 / 255, np.float32)
    pixels[160:165, 378:383, :3] = pixels[..., 3] = 1
    node.image = bpy.data.images.new("Bytes", 512, 256)
    node.image.pixels.foreach_set(pixels.ravel())
    assert sky.find(scene) is not None
    node.image.colorspace_settings.name = "Non-Color"
    assert sky.find(scene) is None


def test_a_missing_file_is_not_tried_until_it_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, scene = tmp_path / "sky.exr", bpy.context.scene
    node = world_of(np.full((HEIGHT, WIDTH), 0.01, np.float32))
    write_sun(file, 40)
    node.image = bpy.data.images.load(str(file))
    node.image.reload()
    file.rename(tmp_path / "away.exr")
    monkeypatch.setattr(sky, "_search", None)
    assert sky.find(scene) is None
    monkeypatch.undo()
    (tmp_path / "away.exr").rename(file)
    node.image.reload()
    assert is_at(scene, 40)


def test_the_worlds_sun_is_that_of_the_view_layers_in_use() -> None:
    scene = bpy.context.scene
    world_of(disc(np.array((0, 0.5, 1)), 0.01, 1e5, 0.3))
    sunny, layer = scene.world, scene.view_layers[0]
    assert sky.find(scene).name == "the sun of World"
    sunny.cycles_visibility.glossy = False
    assert sky.find(scene) is None
    sunny.cycles_visibility.glossy = True
    layer.use_sky = False
    assert sky.find(scene) is None
    layer.use_sky = True
    if bpy.app.version < (5, 0):
        return
    layer.world_override = bpy.data.worlds.new("Plain")
    assert sky.find(scene) is None
    layer.world_override, scene.world = sunny, layer.world_override
    assert sky.find(scene).name == "the sun of World"
    scene.world = None
    assert sky.find(scene).name == "the sun of World"
    scene.view_layers.new("Other")
    assert sky.find(scene) is None  # paints cannot have both


def test_update_lights_finds_the_sun_of_a_painted_image() -> None:
    scene = bpy.context.scene
    scenes.build(scene, scenes.Scene("sky", paint=Paint(), lamps=()), 16)
    node = world_of(np.full((HEIGHT, WIDTH), 0.01, np.float32))
    node.image = bpy.data.images.new("Painted", *SMALL, float_buffer=True)
    paint_sun(node.image, 40)
    needs.fit(scene)
    assert is_at(scene, 40)
    paint_sun(node.image, 200)
    operators.register()
    try:
        assert bpy.ops.scene.metallic_paint_update_lights() == {"FINISHED"}
    finally:
        operators.unregister()
    assert is_at(scene, 200)
    assert carrier.values()[0][1].angle(Vector(sky.find(scene).direction)) < 1e-3


def test_an_images_sun_glitters_as_a_sun_lamp_does() -> None:
    """Of one direction, size and strength: the same sparkles, and the same light in the mean."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    paint = Paint(tilt=0.2)
    spec = scenes.Scene("sky", paint=paint, lamps=(), orthographic=True, elevation=60, width=0.5)
    item = scenes.build(bpy.context.scene, spec, 64)
    probe = verify.Probe(bpy.context.scene, [item.active_material])
    scene = probe.scene
    scene.cycles.samples, scene.cycles.max_bounces = 1, 1
    view = np.array(scene.camera.matrix_world)[:3, 2]
    towards = view * [-1, -1, 1] + [0.1, 0, 0]
    world_of(disc(towards, 0.012, 2e4, 0.05))
    needs.fit(scene)
    places = probe.geometry().places()
    counts = probe.image(verify.COUNT, 0)
    scene.cycles.samples = 64
    irradiance = float(probe.image(verify.IRRADIANCE, 0).mean())
    assert irradiance > 1
    shown = probe.image(verify.SPARKLES, 0)
    found = core.evaluate(core_paint(paint), core_lights(), **places, precision="float")
    np.testing.assert_array_equal(counts[..., 0].ravel(), found["count"][:, 0])
    mean = irradiance * found["mean_radiance"].mean(axis=(0, 1))
    deviation = irradiance * np.sqrt(found["variance"].mean(axis=(0, 1)) / shown[..., 0].size)
    assert (np.abs(shown.mean(axis=(0, 1)) - mean) < 5 * deviation + 0.01 * mean).all()
    of_world = probe.picture().mean(axis=(0, 1))

    # The lamp instead, and the rest of the world as it was.
    sine = core_lights()[0].size
    direction = np.array(core_lights()[0].vector)
    data = bpy.data.lights.new("Sun", "SUN")
    data.angle = 2 * math.asin(sine)
    data.energy = irradiance - 0.05 * 2 * math.pi * (1 - math.cos(0.02))
    lamp = bpy.data.objects.new("Sun", data)
    lamp.rotation_euler = Vector(direction).to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(lamp)
    world_of(disc(towards, 0.012, 0.05, 0.05))
    needs.fit(scene)
    np.testing.assert_allclose(probe.picture().mean(axis=(0, 1)), of_world, rtol=0.02)
