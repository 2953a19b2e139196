# SPDX-License-Identifier: Apache-2.0
"""Every operator of paints, lights and scene: what it does, when it refuses, how it fails."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import addon_utils
import bpy
import pytest
from package import Addon


@pytest.fixture
def cube() -> bpy.types.Object:
    bpy.ops.mesh.primitive_cube_add()
    return bpy.context.object


@pytest.fixture
def linked_paint(addon: Addon, cube: bpy.types.Object, tmp_path: Path) -> bpy.types.Object:
    """An object whose mesh and paint are linked from another file."""
    bpy.ops.material.metallic_paint_new()
    file = str(tmp_path / "other.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file, copy=True)
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(file, link=True) as (_, into):
        into.objects = ["Cube"]
    [thing] = into.objects
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    return thing


@pytest.fixture
def editor(cube: bpy.types.Object) -> Iterator[bpy.types.Area]:
    """A shader editor on the active object's material, in the context of a window's area."""
    window = bpy.context.window_manager.windows[0]
    area = window.screen.areas[0]
    area.type = "NODE_EDITOR"
    area.ui_type = "ShaderNodeTree"
    surface = bpy.data.materials.new("Surface")
    if surface.node_tree is None:
        surface.use_nodes = True  # Blender 4.5
    cube.active_material = surface
    area.spaces.active.pin = True
    area.spaces.active.node_tree = surface.node_tree
    region = next(each for each in area.regions if each.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        yield area


# --- a new paint -------------------------------------------------------------------------------


def test_new_paint_takes_the_active_slot(addon: Addon, cube: bpy.types.Object) -> None:
    first, second = (bpy.data.materials.new(name) for name in ("first", "second"))
    cube.data.materials.append(first)
    cube.data.materials.append(second)
    cube.active_material_index = 1
    assert bpy.ops.material.metallic_paint_new(preset="candy-red") == {"FINISHED"}
    assert cube.data.materials[0] == first
    painted = cube.data.materials[1]
    assert painted.name == "Candy Red"
    assert addon("paint.material").paint_of(painted) == addon("paint.presets").load("candy-red")


def test_new_paint_knows_the_lights(addon: Addon, cube: bpy.types.Object) -> None:
    bpy.ops.object.light_add(type="SUN")
    bpy.context.view_layer.objects.active = cube
    bpy.ops.material.metallic_paint_new()
    assert len(addon("scene.carrier").values()) == 1


def test_new_paint_switches_nothing(cube: bpy.types.Object) -> None:
    engine = bpy.context.scene.render.engine
    assert engine != "CYCLES"
    bpy.ops.material.metallic_paint_new()
    assert bpy.context.scene.render.engine == engine
    assert not bpy.context.scene.cycles.shading_system


@pytest.mark.parametrize("kind", ["CAMERA", "LIGHT", "EMPTY"])
def test_new_paint_refuses_what_has_no_surface(kind: str) -> None:
    data = {
        "CAMERA": lambda: bpy.data.cameras.new("a"),
        "LIGHT": lambda: bpy.data.lights.new("a", "SUN"),
        "EMPTY": lambda: None,
    }[kind]()
    thing = bpy.data.objects.new("a", data)
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    with pytest.raises(RuntimeError, match="whose surface can hold a material"):
        bpy.ops.material.metallic_paint_new()


def test_new_paint_refuses_without_an_object() -> None:
    with pytest.raises(RuntimeError, match="Select an object"):
        bpy.ops.material.metallic_paint_new()


def test_new_paint_refuses_linked_objects(linked_paint: bpy.types.Object) -> None:
    with pytest.raises(RuntimeError, match="linked from another file"):
        bpy.ops.material.metallic_paint_new()


def test_new_paint_takes_an_objects_own_slot_over_linked_data(
    addon: Addon, linked_paint: bpy.types.Object
) -> None:
    thing = bpy.data.objects.new("Ours", linked_paint.data)
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    with pytest.raises(RuntimeError, match="linked from another file"):
        bpy.ops.material.metallic_paint_new()
    thing.material_slots[0].link = "OBJECT"
    assert bpy.ops.material.metallic_paint_new(preset="lime") == {"FINISHED"}
    assert addon("paint.material").paint_of(thing.active_material) == addon("paint.presets").load(
        "lime"
    )


@pytest.mark.parametrize(
    "new",
    [
        lambda: bpy.data.curves.new("a", "CURVE"),
        lambda: bpy.data.curves.new("a", "SURFACE"),
        lambda: bpy.data.curves.new("a", "FONT"),
        lambda: bpy.data.metaballs.new("a"),
        lambda: bpy.data.hair_curves.new("a"),
        lambda: bpy.data.pointclouds.new("a"),
    ],
    ids=["curve", "surface", "text", "metaball", "hair", "points"],
)
def test_new_paint_takes_every_kind_of_surface(
    addon: Addon, new: Callable[[], bpy.types.ID]
) -> None:
    thing = bpy.data.objects.new("a", new())
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    assert bpy.ops.material.metallic_paint_new() == {"FINISHED"}
    assert addon("paint.material").paint_node(thing.active_material)


def test_new_paint_of_a_bad_preset_changes_nothing(cube: bpy.types.Object) -> None:
    with pytest.raises(RuntimeError, match="neither a file nor a preset"):
        bpy.ops.material.metallic_paint_new(preset="no-such")
    assert not cube.data.materials
    assert not bpy.data.materials


# --- a paint node ------------------------------------------------------------------------------


def test_paint_node_joins_the_material(addon: Addon, editor: bpy.types.Area) -> None:
    tree = editor.spaces.active.edit_tree
    before = len(tree.nodes)
    assert bpy.ops.node.metallic_paint_add() == {"FINISHED"}
    assert len(tree.nodes) == before + 1
    assert addon("paint.material").is_paint(tree.nodes.active)
    assert [node for node in tree.nodes if node.select] == [tree.nodes.active]


def test_paint_node_refuses_outside_a_shader_editor(cube: bpy.types.Object) -> None:
    with pytest.raises(RuntimeError, match="Open a material in a shader editor"):
        bpy.ops.node.metallic_paint_add()


def test_paint_node_refuses_a_world(editor: bpy.types.Area) -> None:
    editor.spaces.active.shader_type = "WORLD"
    with pytest.raises(RuntimeError, match="Open a material in a shader editor"):
        bpy.ops.node.metallic_paint_add()


def test_paint_node_refuses_an_overridden_material(editor: bpy.types.Area, tmp_path: Path) -> None:
    file = str(tmp_path / "theirs.blend")
    surface = bpy.data.materials["Surface"]
    bpy.data.libraries.write(file, {surface})
    with bpy.data.libraries.load(file, link=True) as (_, here):
        here.materials = [surface.name]
    overridden = here.materials[0].override_create()
    editor.spaces.active.node_tree = overridden.node_tree
    before = overridden.node_tree.nodes.keys()
    with pytest.raises(RuntimeError, match="is a library override, whose nodes"):
        bpy.ops.node.metallic_paint_add()
    assert overridden.node_tree.nodes.keys() == before


def test_paint_node_refuses_to_stand_in_a_paint(addon: Addon, editor: bpy.types.Area) -> None:
    for group in (addon("paint.material").node_group(), addon("scene.lights").node_group()):
        editor.spaces.active.node_tree = group
        with pytest.raises(RuntimeError, match="cannot stand within a paint"):
            bpy.ops.node.metallic_paint_add()


# --- a Blender that cannot compile ------------------------------------------------------------


@pytest.fixture(params=["compiler", "other version", "no osl", "no folder"])
def uncompiled(
    request: pytest.FixtureRequest, addon: Addon, monkeypatch: pytest.MonkeyPatch
) -> str:
    """What the refusal says."""

    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied", "/tmp/a")

    whole = addon("paint.shader").source()
    monkeypatch.setattr(addon("paint.shader"), "source", lambda: "shader broken(")
    if request.param == "no folder":
        monkeypatch.setattr(tempfile, "TemporaryFile", refuse)
        return "The paint's shader cannot be compiled: .*Permission denied"
    if request.param == "other version":
        other = whole.replace("int Seed = 0", "int Sead = 0").replace(" Seed,", " Sead,")
        monkeypatch.setattr(addon("paint.shader"), "source", lambda: other)
        return "metallic_paint.osl lacks the parameters Seed: it is of another version"
    if request.param == "compiler":
        return r"metallic_paint.osl[.\d]* does not compile as OSL"
    monkeypatch.setattr(addon("paint.material"), "has_osl", lambda: False)
    monkeypatch.setattr(addon("paint.shader"), "LIBRARY", Path("/nowhere"))  # as in the repository
    return "This Blender was built without Open Shading Language"


def held() -> list[str]:
    kinds = (bpy.data.materials, bpy.data.node_groups, bpy.data.texts, bpy.data.scenes)
    return [each.name for kind in kinds for each in kind]


def test_new_paint_that_does_not_compile_leaves_nothing(
    cube: bpy.types.Object, uncompiled: str
) -> None:
    before = held()
    with pytest.raises(RuntimeError, match=uncompiled) as refusal:
        bpy.ops.material.metallic_paint_new()
    assert "Traceback" not in str(refusal.value)
    assert held() == before
    assert not cube.material_slots


@pytest.mark.parametrize("has_osl", [True, False])
def test_the_shader_comes_compiled_from_the_asset_library(
    has_osl: bool, addon: Addon, cube: bpy.types.Object, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So the file of a Blender without a compiler renders wherever there is one."""
    material = addon("paint.material")
    monkeypatch.setattr(material, "has_osl", lambda: has_osl)
    monkeypatch.setattr(addon("paint.shader"), "compile_into", None)
    bpy.ops.material.metallic_paint_new(preset="gold")
    node = material.paint_node(cube.active_material)
    assert material.is_current(node.node_tree, material.digest(addon("paint.shader").source()))
    assert node.node_tree.nodes[material.NAME].bytecode
    assert material.paint_of(node) == addon("paint.presets").load("gold")
    bpy.ops.material.metallic_paint_new(preset="copper")
    assert material.paint_node(cube.active_material).node_tree == node.node_tree  # once in a file


def test_paint_node_that_does_not_compile_leaves_nothing(
    editor: bpy.types.Area, uncompiled: str
) -> None:
    before, nodes = held(), editor.spaces.active.edit_tree.nodes.keys()
    with pytest.raises(RuntimeError, match=uncompiled) as refusal:
        bpy.ops.node.metallic_paint_add()
    assert "Traceback" not in str(refusal.value)
    assert held() == before
    assert editor.spaces.active.edit_tree.nodes.keys() == nodes


@pytest.fixture
def older(addon: Addon, cube: bpy.types.Object) -> bpy.types.ShaderNodeGroup:
    """An animated paint of an older shader, made before the compiler fails."""
    bpy.ops.material.metallic_paint_new()
    node = addon("paint.material").paint_node(cube.active_material)
    node.inputs["Tilt"].keyframe_insert("default_value", frame=1)
    node.node_tree["metallic_paint_source"] = "older"
    assert addon("paint.migration").has_outdated()
    return node


def test_update_that_does_not_compile_leaves_the_paints_as_they_are(
    addon: Addon, older: bpy.types.ShaderNodeGroup, uncompiled: str
) -> None:
    node, tree, before = older, older.id_data, held()
    group, links = node.node_tree, len(tree.links)
    with pytest.raises(RuntimeError, match=uncompiled) as refusal:
        bpy.ops.material.metallic_paint_update()
    assert "Traceback" not in str(refusal.value)
    assert held() == before
    assert (node.node_tree, len(tree.links)) == (group, links)
    number = node.inputs.keys().index("Tilt")
    [path] = {
        curve.data_path for curves in addon("paint.animation").curves(tree) for curve in curves
    }
    assert path == f'nodes["{node.name}"].inputs[{number}].default_value'


def test_a_blender_without_osl_is_not_offered_it(
    addon: Addon, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(addon("paint.material"), "has_osl", lambda: False)
    assert "built without Open Shading" in addon("paint.material").missing(bpy.context.scene)
    with pytest.raises(RuntimeError, match="built without Open Shading Language"):
        bpy.ops.scene.metallic_paint_use_osl()


# --- the scene ---------------------------------------------------------------------------------


def test_update_lights_reports_what_fit_says(
    addon: Addon, cube: bpy.types.Object, capfd: pytest.CaptureFixture[str]
) -> None:
    bpy.ops.material.metallic_paint_new()
    bpy.ops.object.light_add(type="POINT")
    capfd.readouterr()
    assert bpy.ops.scene.metallic_paint_update_lights() == {"FINISHED"}
    assert "light 1: Point" in capfd.readouterr().out
    assert "light 1: Point" in addon("scene.needs").said()


def test_update_lights_refuses_without_paint() -> None:
    with pytest.raises(RuntimeError, match="no metallic paint"):
        bpy.ops.scene.metallic_paint_update_lights()


def test_one_button_puts_the_scene_on_cycles_with_osl(addon: Addon) -> None:
    scene = bpy.context.scene
    missing = addon("paint.material").missing
    assert "does not render with Cycles" in missing(scene)
    scene.render.engine = "CYCLES"
    assert "Open Shading Language is off" in missing(scene)
    scene.render.engine = "BLENDER_WORKBENCH"
    assert bpy.ops.scene.metallic_paint_use_osl() == {"FINISHED"}
    assert missing(scene) == ""
    assert (scene.render.engine, scene.cycles.device) == ("CYCLES", "CPU")
    assert scene.cycles.shading_system


@pytest.mark.parametrize(
    ("device", "warning"),
    [
        ("OPTIX", "on the GPU by OptiX: the paint is tested on the CPU only"),
        ("METAL", "by Metal, which has no Open Shading Language"),
        ("NONE", ""),
    ],
)
def test_each_kind_of_gpu_is_named(
    addon: Addon, monkeypatch: pytest.MonkeyPatch, device: str, warning: str
) -> None:
    """Devices that this machine's Blender does not know of are set where Cycles is asked."""
    material = addon("paint.material")
    bpy.ops.scene.metallic_paint_use_osl()
    monkeypatch.setattr(material, "gpu", lambda _: device)
    missing = material.missing(bpy.context.scene)
    assert warning in missing
    assert bool(missing) == bool(warning)


@pytest.mark.parametrize(
    "call",
    [
        "material.metallic_paint_new", "scene.metallic_paint_update_lights",
        "material.metallic_paint_update", "scene.metallic_paint_report",
        "scene.metallic_paint_use_osl",
    ],
)  # fmt: skip
def test_without_the_add_on_of_cycles_operators_say_so(
    addon: Addon,
    cube: bpy.types.Object,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    call: str,
) -> None:
    bpy.ops.material.metallic_paint_new()
    addon("paint.material").node_group()["metallic_paint_source"] = "older"
    addon_utils.disable("cycles")
    try:
        space, _, name = call.partition(".")
        with pytest.raises(RuntimeError, match="Enable the add-on Cycles Render Engine first"):
            getattr(getattr(bpy.ops, space), name)()
        bpy.ops.object.light_add(type="SUN")
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
        assert addon("scene.carrier").values() == []
        before = bpy.data.scenes.keys()
        monkeypatch.setattr(addon("paint.shader"), "LIBRARY", Path("/nowhere"))  # so it compiles
        with pytest.raises(TypeError, match="CYCLES"):
            addon("paint.material").create(addon("paint").Paint())
        assert bpy.data.scenes.keys() == before
    finally:
        addon_utils.enable("cycles")
    bpy.context.view_layer.update()
    assert len(addon("scene.carrier").values()) == 1


def test_a_gpu_is_warned_of(addon: Addon) -> None:
    scene, missing = bpy.context.scene, addon("paint.material").missing
    bpy.ops.scene.metallic_paint_use_osl()
    scene.cycles.device = "GPU"
    assert missing(scene) == ""  # without a GPU Cycles takes the CPU
    bpy.context.preferences.addons["cycles"].preferences.compute_device_type = "CUDA"
    assert "by CUDA, which has no Open Shading Language" in missing(scene)
    bpy.ops.scene.metallic_paint_use_osl()
    assert missing(scene) == ""


def test_update_paints_refuses_where_all_are_new(cube: bpy.types.Object) -> None:
    bpy.ops.material.metallic_paint_new()
    with pytest.raises(RuntimeError, match=r"of today's version"):
        bpy.ops.material.metallic_paint_update()
