# SPDX-License-Identifier: Apache-2.0
"""Presets in the interface: apply, load, save, own folder; bad files change nothing."""

from __future__ import annotations

import json
from pathlib import Path

import bpy
import pytest
from package import Addon


@pytest.fixture
def painted() -> bpy.types.Material:
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.material.metallic_paint_new(preset="gold")
    return bpy.context.object.active_material


def test_apply_sets_the_paint_node_alone_and_tells_what_it_does_not_reach(
    addon: Addon, painted: bpy.types.Material, capfd: pytest.CaptureFixture[str]
) -> None:
    material, presets = addon("paint.material"), addon("paint.presets")
    tree = painted.node_tree
    other = tree.nodes.new("ShaderNodeBsdfPrincipled")
    noise = tree.nodes.new("ShaderNodeTexNoise")
    paint = material.paint_node(painted)
    tree.links.new(noise.outputs[0], paint.inputs["Tilt"])
    tree.links.new(noise.outputs[0], paint.inputs["Normal"])  # which no preset has
    paint.inputs["IOR"].driver_add("default_value")
    paint.inputs["Flake Spread"].driver_add("default_value").mute = True
    tree.links.new(noise.outputs[0], paint.inputs["Flake Area Spread"]).is_muted = True
    paint.inputs["Substrate Color"].keyframe_insert("default_value", frame=1)
    for name in presets.names():
        capfd.readouterr()
        assert bpy.ops.material.metallic_paint_apply_preset(preset=name) == {"FINISHED"}
        said = capfd.readouterr().out
        assert "not the preset's: Tilt, IOR, Substrate Color." in said
        assert material.paint_of(painted) == presets.load(name)
    assert paint.inputs["Tilt"].links[0].from_node == noise
    assert other.inputs["Roughness"].default_value == 0.5


def test_apply_has_nothing_to_tell_of_plain_values(
    painted: bpy.types.Material, capfd: pytest.CaptureFixture[str]
) -> None:
    bpy.ops.material.metallic_paint_apply_preset(preset="lime")
    assert "preset" not in capfd.readouterr().out


def test_apply_takes_the_active_one_of_two_paints(
    addon: Addon, painted: bpy.types.Material
) -> None:
    material, presets = addon("paint.material"), addon("paint.presets")
    first = material.paint_node(painted)
    second = material.add_node(painted.node_tree, presets.load("gold"))
    painted.node_tree.nodes.active = second
    bpy.ops.material.metallic_paint_apply_preset(preset="lime")
    assert material.paint_of(first) == presets.load("gold")
    assert material.paint_of(second) == presets.load("lime")


def test_saved_paint_loads_as_it_was(
    addon: Addon, painted: bpy.types.Material, tmp_path: Path
) -> None:
    material, presets = addon("paint.material"), addon("paint.presets")
    file = tmp_path / "mine.json"
    node = material.paint_node(painted)
    node.inputs["Tilt"].default_value = 0.123
    assert bpy.ops.material.metallic_paint_save_preset(filepath=str(file), description="Mine") == {
        "FINISHED"
    }
    assert json.loads(file.read_text())["paint"]["tilt"] == 0.123
    assert json.loads(file.read_text())["description"] == "Mine"
    expected = material.paint_of(painted)
    bpy.ops.material.metallic_paint_apply_preset(preset="lime")
    assert bpy.ops.material.metallic_paint_load_preset(filepath=str(file)) == {"FINISHED"}
    assert material.paint_of(painted) == expected == presets.load(file)


BAD = {
    "no JSON": ("{", "is no JSON"),
    "a field out of range": ('{"schema_version": 1, "paint": {"tilt": 1000}}',
                             "paint.tilt is 1000, but must be from"),
    "a field of the second species": (
        '{"schema_version": 1, "paint": {"second": {"coating": "lead"}}}',
        "paint.second.coating is 'lead', but must be colors, aluminium"),
    "an unknown field": ('{"schema_version": 1, "paint": {"glitter": 1}}', "paint.glitter"),
    "NaN": ('{"schema_version": 1, "paint": {"tilt": NaN}}', "paint.tilt is nan, but must be from"),
    "a future version": ('{"schema_version": 99, "paint": {}}', "schema_version is 99"),
}  # fmt: skip


@pytest.mark.parametrize("which", BAD)
def test_bad_file_is_explained_and_changes_nothing(
    addon: Addon, painted: bpy.types.Material, tmp_path: Path, which: str
) -> None:
    text, complaint = BAD[which]
    file = tmp_path / "bad.json"
    file.write_text(text)
    before = addon("paint.material").paint_of(painted)
    with pytest.raises(RuntimeError) as error:
        bpy.ops.material.metallic_paint_load_preset(filepath=str(file))
    assert complaint in str(error.value)
    assert addon("paint.material").paint_of(painted) == before


def test_missing_file_is_explained(painted: bpy.types.Material, tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="neither a file nor a preset"):
        bpy.ops.material.metallic_paint_load_preset(filepath=str(tmp_path / "none.json"))


def test_saving_where_nothing_can_be_written(painted: bpy.types.Material, tmp_path: Path) -> None:
    file = tmp_path / "none" / "a.json"
    with pytest.raises(RuntimeError, match="cannot be written: No such file"):
        bpy.ops.material.metallic_paint_save_preset(filepath=str(file))
    assert not file.exists()


def test_saving_an_impossible_paint_names_the_field(
    addon: Addon, painted: bpy.types.Material, tmp_path: Path
) -> None:
    node = addon("paint.material").paint_node(painted)
    node.inputs["Coating"].default_value = 0
    node.inputs["Flake Color"].default_value = (0.9, 0.9, 0.9, 1)
    node.inputs["Flake Transmission"].default_value = (0.5, 0.5, 0.5, 1)
    with pytest.raises(RuntimeError, match=r"flake_color \+ flake_transmission is 1.4"):
        bpy.ops.material.metallic_paint_save_preset(filepath=str(tmp_path / "a.json"))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("action", ["apply", "load", "save"])
def test_a_paint_of_an_older_version_stays_as_it_is(
    addon: Addon, painted: bpy.types.Material, tmp_path: Path, action: str
) -> None:
    material, presets = addon("paint.material"), addon("paint.presets")
    group = material.paint_node(painted).node_tree
    group["metallic_paint"] = material.VERSION - 1
    file = presets.FOLDER / "lime.json" if action == "load" else tmp_path / "mine.json"
    given = {"preset": "lime"} if action == "apply" else {"filepath": str(file)}
    run = getattr(bpy.ops.material, f"metallic_paint_{action}_preset")
    with pytest.raises(RuntimeError, match="is of an older version: update it first"):
        run(**given)
    group["metallic_paint"] = material.VERSION
    assert material.paint_of(painted) == presets.load("gold")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("action", ["apply", "load", "save"])
def test_operators_refuse_without_a_paint(action: str, tmp_path: Path) -> None:
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.active_material = bpy.data.materials.new("plain")
    run = getattr(bpy.ops.material, f"metallic_paint_{action}_preset")
    with pytest.raises(RuntimeError, match="active material has no metallic paint"):
        run()


def test_own_presets_outlive_the_package(
    addon: Addon, painted: bpy.types.Material, installed: Path
) -> None:
    painted.name = "My Gold/2"
    file = addon("interface.preset_operators").own_file(bpy.context)
    assert file.name == "my-gold-2.json"
    assert file.parent.is_dir()
    assert installed not in file.parents


def test_own_presets_keep_accents_and_never_share_a_file(
    painted: bpy.types.Material, addon: Addon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    operators = addon("interface.preset_operators")
    monkeypatch.setattr(operators, "own_folder", lambda create: tmp_path)
    painted.name = "Flocon d'été/2"
    first = operators.own_file(bpy.context)
    assert first == tmp_path / "flocon-d-été-2.json"
    first.touch()
    painted.name = "flocon d été.2"
    assert operators.own_file(bpy.context) == tmp_path / "flocon-d-été-2-2.json"


def test_a_paint_within_a_group_is_saved_under_the_name_of_its_material(
    painted: bpy.types.Material, addon: Addon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    operators = addon("interface.preset_operators")
    monkeypatch.setattr(operators, "own_folder", lambda create: tmp_path)
    node = addon("paint.material").paint_node(painted)
    outer = bpy.data.node_groups.new("Mine", "ShaderNodeTree")
    outer.nodes.new("ShaderNodeGroup").node_tree = node.node_tree
    node.node_tree = outer
    copy = painted.copy()  # another material of the group
    for shown, name in ((painted, "First"), (copy, "Second")):
        bpy.context.object.active_material, shown.name = shown, name
        assert operators.own_file(bpy.context) == tmp_path / f"{name.lower()}.json"


def test_saving_without_a_name(painted: bpy.types.Material) -> None:
    with pytest.raises(RuntimeError, match="has no name"):
        bpy.ops.material.metallic_paint_save_preset(filepath="")


def test_every_preset_has_a_swatch(addon: Addon) -> None:
    for name in addon("paint.presets").names():
        addon("interface.preset_operators").swatch(name)  # icons have no numbers without a window
        assert tuple(addon("interface.preset_operators")._previews[0][name].image_size) == (
            128,
            128,
        )
    assert addon("interface.preset_operators").swatch("no-such") == 0
