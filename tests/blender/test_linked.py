# SPDX-License-Identifier: Apache-2.0
"""A paint that is linked from another file sees the lights of this one: every pixel is that of the
same paint appended, also on a machine without the add-on."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO
import pytest
from gate import first_of
from metallic_paint import verify
from metallic_paint.paint import material, presets
from metallic_paint.scene import carrier, lights, needs
from scenery import add_lamp, nest_paint

SCRIPT = Path(__file__).with_name("open_and_render.py")
SECONDS = 300
WAYS = ["object", "material", "instance"]


@pytest.fixture
def library(tmp_path: Path) -> Path:
    """A car of 2 cm under one sun, in a collection."""
    scene = bpy.context.scene
    material.set_up_cycles(scene)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.02)
    car = bpy.context.object
    car.name = "Car"
    material.assign(car, material.create(presets.load("silver-coarse"), "Painted"))
    cars = bpy.data.collections.new("Cars")
    cars.objects.link(car)
    scene.collection.children.link(cars)
    scene.collection.objects.unlink(car)
    add_lamp("SUN", "Library sun", rotation_euler=(1, 0, 0))
    needs.fit(scene)
    return save(tmp_path / "library.blend")


def save(file: Path) -> Path:
    """Afterwards the scene is empty."""
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return file


def bring(library: Path, way: str, *, link: bool) -> bpy.types.Object:
    """Puts the library's car, or one that has its paint, into a new shot under other lights."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    material.set_up_cycles(scene)
    scene.unit_settings.scale_length = 0.5
    add_lamp("POINT", "Lamp", energy=0.3, shadow_soft_size=0.01, location=(0.1, 0.1, 0.3))
    add_lamp("SUN", "Sun", energy=2, angle=0.02, rotation_euler=(0.3, 0.4, 0))
    add_lamp("SUN", "Sun of the left", energy=1, rotation_euler=(0.2, -0.7, 0))
    add_lamp("AREA", "Softbox", energy=0.2, size=0.1, shape="DISK", location=(0, -0.1, 0.4))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location.z = 1
    camera.data.type, camera.data.ortho_scale = "ORTHO", 0.05
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = 48
    verify.make_noiseless(scene)
    with bpy.data.libraries.load(str(library), link=link) as (_, here):
        if way == "material":
            here.materials = ["Painted"]
        elif way == "instance":
            here.collections = ["Cars"]
        else:
            here.objects = ["Car"]
    if way == "material":
        bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.02)
        car = bpy.context.object
        car.name = "Car"
        material.assign(car, here.materials[0])
    elif way == "instance":
        car = bpy.data.objects.new("Empty", None)
        car.instance_type, car.instance_collection = "COLLECTION", here.collections[0]
        scene.collection.objects.link(car)
    else:
        [car] = here.objects
        scene.collection.objects.link(car)
    return car


def shown(scene: bpy.types.Scene) -> np.ndarray:
    needs.fit(scene)
    assert needs.is_fitted(scene)
    return verify.render(scene)


def shown_appended(library: Path, way: str) -> np.ndarray:
    bring(library, way, link=False)
    picture = shown(bpy.context.scene)
    assert picture.std() > 0.01
    return picture


def shown_elsewhere(folder: Path) -> np.ndarray:
    """The scene as it is saved, by a Blender without the add-on."""
    shot = folder / "shot.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(shot))
    done = subprocess.run(
        [sys.executable, SCRIPT, shot, folder / "there", "1"], cwd=folder,
        env={**os.environ, "BLENDER_USER_RESOURCES": str(folder / "user")},
        capture_output=True, text=True, timeout=SECONDS, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return OpenImageIO.ImageBuf(str(folder / "there-1.exr")).get_pixels()[::-1, :, :3]


@pytest.mark.parametrize("way", first_of(WAYS))
def test_a_linked_car_is_lit_as_the_appended_one(library: Path, way: str, tmp_path: Path) -> None:
    expected = shown_appended(library, way)
    bring(library, way, link=True)
    np.testing.assert_array_equal(shown(bpy.context.scene), expected)
    np.testing.assert_array_equal(shown_elsewhere(tmp_path), expected)


def add_camera() -> None:
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera


@pytest.fixture
def shot(library: Path) -> Path:
    """The library's file with a camera of its own."""
    bpy.ops.wm.open_mainfile(filepath=str(library))
    add_camera()
    needs.fit(bpy.context.scene)
    return save(library)


@pytest.mark.long
@pytest.mark.parametrize("what", ["objects", "materials", "collections"])
def test_an_asset_makes_a_library(shot: Path, what: str) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(shot))
    scene = bpy.context.scene
    assert not lights.is_library()
    bpy.data.objects["Camera"].asset_mark()
    assert not lights.is_library()
    assert needs.is_fitted(scene)
    name = {"objects": "Car", "materials": "Painted", "collections": "Cars"}[what]
    getattr(bpy.data, what)[name].asset_mark()
    assert lights.is_library()
    assert not needs.is_fitted(scene)
    assert f"A library, as {name} is marked as an asset" in str(needs.fit(scene))
    assert needs.is_fitted(scene)
    library = save(shot)
    expected = shown_appended(library, "object")
    bring(library, "object", link=True)
    np.testing.assert_array_equal(shown(bpy.context.scene), expected)
    assert not lights.linked_files()


@pytest.mark.long
def test_a_paint_of_another_file_keeps_its_lights(shot: Path) -> None:
    """Also on an object that has a slot of another kind where the paint expects a sun."""
    car = bring(shot, "material", link=True)
    scene = bpy.context.scene
    expected = shown(scene)
    assert expected.std() > 0.01
    assert lights.linked_files() == (str(shot),)
    assert "do not see these lights" in str(needs.fit(scene).lights)
    theirs = car.active_material
    material.assign(car, material.create(presets.load("gold")))
    assert (shown(scene) != expected).any()
    assert carrier.is_attached([car])
    material.assign(car, theirs)
    np.testing.assert_array_equal(shown(scene), expected)


@pytest.mark.long
@pytest.mark.parametrize("way", ["object", "instance"])
def test_an_overridden_car_is_lit_as_the_appended_one(
    library: Path, way: str, tmp_path: Path
) -> None:
    expected = shown_appended(library, "object")
    scene = bpy.context.scene
    car = bring(library, way, link=True)
    scene = bpy.context.scene
    if way == "object":
        car.override_create(remap_local_usages=True)
    else:
        cars = car.instance_collection
        bpy.data.objects.remove(car)
        cars.override_hierarchy_create(scene, bpy.context.view_layer)
    assert any(each.override_library for each in scene.objects)
    np.testing.assert_array_equal(shown(scene), expected)
    np.testing.assert_array_equal(shown_elsewhere(tmp_path), expected)


@pytest.mark.long
def test_an_overridden_car_with_headlights_keeps_the_shots_lights_once_it_is_saved(
    library: Path, tmp_path: Path
) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(library))
    lamp = add_lamp("POINT", "Headlight", energy=0.1, location=(0.02, 0, 0.1))
    bpy.data.collections["Cars"].objects.link(lamp)
    bpy.context.collection.objects.unlink(lamp)
    needs.fit(bpy.context.scene)
    save(library)
    car = bring(library, "instance", link=True)
    cars = car.instance_collection
    bpy.data.objects.remove(car)
    cars.override_hierarchy_create(
        bpy.context.scene, bpy.context.view_layer, do_fully_editable=True
    )
    assert any(tree.override_library for tree in bpy.data.node_groups)  # of the library's lights
    needs.fit(bpy.context.scene)
    values = carrier.values()
    assert len(values) == 5
    shot = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=shot)
    bpy.ops.wm.open_mainfile(filepath=shot)
    assert carrier.values() == values
    assert needs.is_fitted(bpy.context.scene)


def test_a_slot_that_the_file_lost_is_noticed(library: Path) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(library))
    scene, values = bpy.context.scene, carrier.values()
    for name in ("Light1Direction", "Light1Facing"):
        assert needs.is_fitted(scene)
        del carrier.only()[name]
        assert not needs.is_fitted(scene)
        needs.fit(scene)
        assert carrier.values() == values


@pytest.mark.long
def test_a_car_that_comes_through_two_files(library: Path, tmp_path: Path) -> None:
    expected = shown_appended(library, "material")
    bring(library, "material", link=True)
    for light in bpy.data.lights:
        light.energy = 7
    needs.fit(bpy.context.scene)
    between = save(tmp_path / "between.blend")
    bring(between, "object", link=True)
    np.testing.assert_array_equal(shown(bpy.context.scene), expected)


@pytest.mark.long
def test_a_paint_within_a_group(library: Path, tmp_path: Path) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(library))
    nest_paint(bpy.data.materials["Painted"])
    library = save(library)
    expected = shown_appended(library, "object")
    bring(library, "object", link=True)
    np.testing.assert_array_equal(shown(bpy.context.scene), expected)


@pytest.mark.long
def test_it_follows_an_animated_lamp(library: Path) -> None:
    pictures = []
    for link in (False, True):
        bring(library, "object", link=link)
        scene = bpy.context.scene
        sun = scene.objects["Sun"]
        for frame, turn in ((1, 0.1), (10, 0.6)):
            sun.rotation_euler.x = turn
            sun.keyframe_insert("rotation_euler", frame=frame)
        needs.fit(scene)
        scene.render.use_persistent_data = True
        for frame in (1, 10):
            scene.frame_set(frame)
            pictures.append(verify.render(scene))
    one, other, linked_one, linked_other = pictures
    np.testing.assert_array_equal(linked_one, one)
    np.testing.assert_array_equal(linked_other, other)
    assert (one != other).any()


@pytest.mark.long
def test_the_file_that_a_shot_was_copied_from_may_be_linked(library: Path, tmp_path: Path) -> None:
    """Both have the same number then, until the shot is fitted."""
    expected = shown_appended(library, "object")
    bring(library, "object", link=False)
    scene = bpy.context.scene
    needs.fit(scene)
    [number] = [group["metallic_paint_file"] for group in lights.groups()]
    bpy.ops.wm.open_mainfile(filepath=str(library))
    lights.node_group()["metallic_paint_file"] = number
    lights._build(lights.node_group(), [], [])
    save(library)
    bring(library, "object", link=True)
    np.testing.assert_array_equal(shown(bpy.context.scene), expected)


def test_a_file_without_linked_paints_tells_its_scenes_nothing(library: Path) -> None:
    car = bring(library, "object", link=True)
    scene = bpy.context.scene
    another = bpy.data.scenes.new("Another")
    needs.fit(scene)
    assert all("metallic_paint_lights" in each for each in (scene, another))
    bpy.data.objects.remove(car)
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    assert not lights.linked_groups()
    material.create(presets.load("silver-coarse"))
    assert not needs.is_fitted(scene)
    needs.fit(scene)
    assert needs.is_fitted(scene)
    assert not any("metallic_paint_lights" in each for each in (scene, another))
    assert {*carrier.only().keys()} >= {"Light1Position"}
    assert not {*carrier.only().keys()} & {"Light1", "File", "Group"}
