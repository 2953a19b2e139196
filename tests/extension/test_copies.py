# SPDX-License-Identifier: Apache-2.0
"""Copies, links, renames, instances, and files that travel."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO
import pytest
from package import Addon


@pytest.fixture
def painted() -> bpy.types.Object:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8)
    bpy.ops.material.metallic_paint_new(preset="gold")
    return bpy.context.object


def add_sun(name: str = "Sun") -> bpy.types.Object:
    bpy.ops.object.light_add(type="SUN", rotation=(0.3, 0, 0))
    bpy.context.object.name = name
    bpy.context.view_layer.update()
    return bpy.context.object


def groups(mark: str) -> list[bpy.types.NodeTree]:
    return [group for group in bpy.data.node_groups if mark in group]


def undefined_nodes() -> list[str]:
    trees = [*(each.node_tree for each in bpy.data.materials), *bpy.data.node_groups]
    nodes = [node for tree in trees if tree for node in tree.nodes]
    return [node.name for node in nodes if node.bl_idname in ("", "NodeUndefined")]


def test_copied_material_has_values_of_its_own(addon: Addon, painted: bpy.types.Object) -> None:
    material, presets = addon("paint.material"), addon("paint.presets")
    first = painted.active_material
    second = first.copy()
    second.name = "Renamed"
    material.apply(second, presets.load("lime"))
    assert material.paint_of(first) == presets.load("gold")
    assert material.paint_of(second) == presets.load("lime")
    assert len(groups("metallic_paint")) == 1


def test_many_paints_share_one_group_and_one_set_of_lights(
    addon: Addon, painted: bpy.types.Object
) -> None:
    for preset in ("lime", "candy-red"):
        bpy.ops.mesh.primitive_cube_add()
        bpy.ops.material.metallic_paint_new(preset=preset)
    bpy.ops.object.material_slot_add()
    bpy.ops.material.metallic_paint_new(preset="silver-fine")
    assert len(bpy.data.materials) == 4
    assert len(groups("metallic_paint")) == 1
    assert len(addon("scene.lights").groups()) == 1


def test_duplicates_and_instances_keep_the_paint(addon: Addon, painted: bpy.types.Object) -> None:
    bpy.ops.object.duplicate()
    twin = bpy.context.object
    assert twin.active_material == painted.active_material
    collection = bpy.data.collections.new("Parts")
    collection.objects.link(twin)
    bpy.context.collection.objects.unlink(twin)
    bpy.ops.object.collection_instance_add(collection="Parts")
    sun = add_sun()
    bpy.context.view_layer.update()
    assert addon("scene.carrier").values()
    assert "no sparkles from" not in addon("scene.needs").said()
    collection.objects.link(sun)
    bpy.context.view_layer.update()
    assert (
        "no sparkles from" not in addon("scene.needs").said()
    )  # it shines where it stands as well
    spare = bpy.data.objects.new("Spare", bpy.data.lights.new("Spare", "SUN"))
    collection.objects.link(spare)  # which shines in the instance alone
    bpy.context.view_layer.update()
    assert ": Spare in Parts" in addon("scene.needs").said()


@pytest.mark.parametrize("link", [True, False])
def test_paint_from_another_file(
    addon: Addon, painted: bpy.types.Object, tmp_path: Path, link: bool
) -> None:
    """It takes this file's lights; linked, through the scene."""
    painted.active_material.name = "Theirs"
    add_sun("Their Sun")
    file = str(tmp_path / "other.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file, copy=True)
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.material.metallic_paint_new(preset="lime")
    add_sun("Our Sun")
    with bpy.data.libraries.load(file, link=link) as (_, into):
        into.materials = ["Theirs"]
    theirs = bpy.data.materials["Theirs"]
    bpy.data.objects["Cube"].data.materials.append(theirs)
    bpy.context.view_layer.update()
    assert addon("paint.material").paint_of(theirs) == addon("paint.presets").load("gold")
    assert "light 1: Our Sun" in addon("scene.needs").said()
    assert "Their Sun" not in addon("scene.needs").said()
    assert "do not see these lights" not in addon("scene.needs").said()
    assert ("metallic_paint_lights" in bpy.context.scene) == link
    own = addon("scene.lights").groups()
    assert len(own) == 1
    slots = {
        node.node_tree
        for group in groups("metallic_paint")
        for node in group.nodes
        if node.type == "GROUP"
    }
    assert own[0] in slots
    assert len(slots) == 1 + link


@pytest.fixture
def theirs(painted: bpy.types.Object, tmp_path: Path) -> Path:
    """A file with a paint, an object that it needs, and a lamp with all that this one needs."""
    painted.active_material.name = "Theirs"
    sun = add_sun("Their Sun")
    bpy.ops.object.empty_add()
    sun.parent = bpy.context.object
    sun.parent.name = "Rig"
    bpy.ops.object.empty_add()
    bpy.context.object.name = "Mirror"
    painted.modifiers.new("Mirror", "MIRROR").mirror_object = bpy.context.object
    together = bpy.data.collections.new("Set")
    bpy.context.scene.collection.children.link(together)
    together.objects.link(sun)
    together.objects.link(painted)
    file = tmp_path / "theirs.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file), copy=True)
    return file


def append(file: Path, kind: str, name: str) -> list[str]:
    """Names of the objects that are then in a scene that had one, Cube."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.mesh.primitive_cube_add()
    folder = f"{file}/{kind}/"
    bpy.ops.wm.append(filepath=f"{folder}{name}", directory=folder, filename=name)
    bpy.context.view_layer.update()
    return sorted(thing.name for thing in bpy.context.scene.objects)


def test_appended_paint_leaves_the_lamps_of_its_file_behind(addon: Addon, theirs: Path) -> None:
    assert append(theirs, "Material", "Theirs") == ["Cube"]
    assert not [thing.name for thing in bpy.data.objects if thing.name != "Cube"]
    add_sun("Our Sun")
    assert addon("scene.lights").in_slots() == [bpy.data.objects["Our Sun"]]


@pytest.mark.parametrize("kind", ["Material", "NodeTree"])
def test_appended_paints_share_the_shader(addon: Addon, theirs: Path, kind: str) -> None:
    """But a node group that was asked for is another."""
    append(theirs, "Material", "Theirs")
    bpy.context.object.data.materials.append(bpy.data.materials["Theirs"])
    name = "Theirs" if kind == "Material" else "Metallic Paint"
    for _ in range(2):
        bpy.ops.wm.append(filepath=f"{theirs}/{kind}/{name}", directory=f"{theirs}/{kind}/",
                          filename=name)  # fmt: skip
        bpy.context.view_layer.update()
    more = 0 if kind == "Material" else 2
    assert len(groups("metallic_paint")) == len(bpy.data.texts) == 1 + more
    assert len(addon("scene.lights").groups()) == 1
    paint = addon("paint.presets").load("gold")
    assert all(addon("paint.material").paint_of(each) == paint for each in bpy.data.materials)


def test_appended_object_brings_what_it_needs_itself(addon: Addon, theirs: Path) -> None:
    assert append(theirs, "Object", "Sphere") == ["Cube", "Mirror", "Sphere"]


def test_lamps_that_were_asked_for_come_along(addon: Addon, theirs: Path) -> None:
    assert append(theirs, "Collection", "Set") == ["Cube", "Mirror", "Rig", "Sphere", "Their Sun"]
    assert addon("scene.lights").in_slots() == [bpy.data.objects["Their Sun"]]


def test_pasted_object_does_not_bring_the_lamps_a_second_time(
    addon: Addon, painted: bpy.types.Object
) -> None:
    sun = add_sun()
    for thing in bpy.context.scene.objects:
        thing.select_set(thing == painted)
    bpy.ops.view3d.copybuffer()
    bpy.ops.view3d.pastebuffer()
    bpy.context.view_layer.update()
    assert sorted(thing.name for thing in bpy.context.scene.objects) == [
        "Sphere", "Sphere.001", "Sun",
    ]  # fmt: skip
    assert addon("scene.lights").in_slots() == [sun]


def test_file_with_only_a_linked_paint_gives_it_its_lights(
    addon: Addon, painted: bpy.types.Object, tmp_path: Path
) -> None:
    """By itself, by Update Lights, and in the saved file."""
    file = str(tmp_path / "other.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file, copy=True)
    bpy.ops.wm.read_homefile(use_empty=True)
    add_sun()
    assert not bpy.ops.scene.metallic_paint_update_lights.poll()
    with bpy.data.libraries.load(file, link=True) as (_, into):
        into.objects = ["Sphere"]
    bpy.context.scene.collection.objects.link(into.objects[0])
    bpy.context.view_layer.update()

    def is_told() -> bool:
        scene = bpy.context.scene
        tree = addon("scene.carrier").only()
        assert addon("scene.needs").is_fitted(scene)
        assert "light 1: Sun" in addon("scene.needs").said()
        return scene["metallic_paint_lights"] == tree and len(addon("scene.carrier").values()) == 1

    assert is_told()
    assert bpy.ops.scene.metallic_paint_update_lights() == {"FINISHED"}
    assert is_told()
    shot = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=shot)
    bpy.ops.wm.open_mainfile(filepath=shot)
    assert is_told()


def test_saved_file_reloads_whole(addon: Addon, painted: bpy.types.Object, tmp_path: Path) -> None:
    add_sun()
    file = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    bpy.ops.wm.open_mainfile(filepath=file)
    painted = bpy.data.objects["Sphere"].active_material
    assert addon("paint.material").paint_of(painted) == addon("paint.presets").load("gold")
    assert addon("scene.carrier").values()
    assert undefined_nodes() == []
    assert addon("scene.carrier").only().animation_data.drivers[0].is_valid


RENDER = """
import os, sys, bpy
assert not [name for name in sys.modules if "metallic_paint" in name]
bpy.ops.wm.open_mainfile(filepath=sys.argv[1], use_scripts=False)
bpy.context.scene.render.filepath = sys.argv[2]
bpy.ops.render.render(write_still=True)
sys.stdout.flush()
os._exit(0)
"""


def test_saved_file_renders_the_same_without_the_extension(
    painted: bpy.types.Object, tmp_path: Path
) -> None:
    """In a new process with empty settings, without Blender's compiler, without scripts."""
    scene = bpy.context.scene
    bpy.ops.object.camera_add(location=(0, 0, 5))
    scene.camera = bpy.context.object
    add_sun()
    bpy.ops.scene.metallic_paint_use_osl()
    scene.render.resolution_x = scene.render.resolution_y = 24
    scene.cycles.samples, scene.cycles.use_denoising = 4, False
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    pictures = [str(tmp_path / name) for name in ("here.exr", "elsewhere.exr")]
    scene.render.filepath = pictures[0]
    file = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    bpy.ops.render.render(write_still=True)
    (tmp_path / "user").mkdir()
    subprocess.run(
        ["timeout", "-k", "2", "120", sys.executable, "-c", RENDER, file, pictures[1]],
        env={"BLENDER_USER_RESOURCES": str(tmp_path / "user")}, check=True,
    )  # fmt: skip
    here, elsewhere = (
        OpenImageIO.ImageBuf(name).get_pixels(OpenImageIO.FLOAT)[..., :3] for name in pictures
    )
    assert here.max() > 0.1
    np.testing.assert_array_equal(here, elsewhere)
