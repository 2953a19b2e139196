# SPDX-License-Identifier: Apache-2.0
"""What the panels, menus and preferences show, with a layout that records (see recording.py)."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from types import SimpleNamespace

import addon_utils
import bpy
import pytest
import seeds
from package import Addon
from recording import Layout, drawn


@pytest.fixture
def cube() -> bpy.types.Object:
    bpy.ops.mesh.primitive_cube_add()
    return bpy.context.object


def panels() -> list[type]:
    """Those that are seen: at the top of the tab for a paint, at its foot for a new one."""
    both = (bpy.types.MATERIAL_PT_metallic_paint, bpy.types.MATERIAL_PT_metallic_paint_new)
    return [each for each in both if each.poll(bpy.context)]


def panel() -> Layout:
    [seen] = panels()
    return drawn(seen)


def test_panel_is_for_objects_with_a_surface(cube: bpy.types.Object) -> None:
    assert panels() == [bpy.types.MATERIAL_PT_metallic_paint_new]
    bpy.ops.object.camera_add()
    assert not panels()
    bpy.ops.object.delete()
    assert not panels()


def test_panel_of_a_paint_stands_above_those_of_blender(cube: bpy.types.Object) -> None:
    bpy.ops.material.metallic_paint_new()
    [seen] = panels()
    assert seen == bpy.types.MATERIAL_PT_metallic_paint
    assert seen.bl_options == {"HIDE_HEADER"}  # those are above all others
    cube.active_material = bpy.data.materials.new("Plain")
    assert panels() == [bpy.types.MATERIAL_PT_metallic_paint_new]


def test_panel_offers_a_new_paint_until_there_is_one(cube: bpy.types.Object) -> None:
    assert "material.metallic_paint_new" in panel().names
    bpy.ops.material.metallic_paint_new()
    assert "material.metallic_paint_new" not in panel().names
    assert panel().menus == ["MATERIAL_MT_metallic_paint_presets"]


@pytest.mark.parametrize("engine", ["CYCLES", "BLENDER_WORKBENCH"])
def test_warning_stands_with_its_button(cube: bpy.types.Object, engine: str) -> None:
    bpy.context.scene.render.engine = engine
    warning = "Open Shading Language is off" if engine == "CYCLES" else "not render with Cycles"
    assert warning in " ".join(panel().texts)
    assert "scene.metallic_paint_use_osl" in panel().names
    bpy.ops.scene.metallic_paint_use_osl()
    assert warning not in " ".join(panel().texts)
    assert "scene.metallic_paint_use_osl" not in panel().names


def test_panel_tells_what_the_last_fit_said(cube: bpy.types.Object) -> None:
    diagnostics = bpy.types.MATERIAL_PT_metallic_paint_diagnostics
    assert "scene.metallic_paint_update_lights" not in drawn(diagnostics).names
    bpy.ops.material.metallic_paint_new()
    bpy.ops.object.light_add(type="SUN")
    bpy.context.view_layer.objects.active = cube
    shown = drawn(diagnostics)
    assert "scene.metallic_paint_update_lights" in shown.names
    assert "light 1: Sun" in shown.texts
    assert all(len(text) <= 60 for text in shown.texts)


def test_panel_names_the_files_of_linked_paints(
    addon: Addon, cube: bpy.types.Object, tmp_path: Path
) -> None:
    bpy.ops.material.metallic_paint_new(preset="gold")
    slots = addon("scene.lights")
    slots.node_group()["metallic_paint_looks"] = False
    file = str(tmp_path / "gold.blend")
    bpy.data.libraries.write(file, {cube.active_material})
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(file, link=True) as (_, into):
        into.materials = ["Gold"]
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.active_material = into.materials[0]
    shown = " ".join(panel().texts)
    assert "gold.blend: they cannot be edited" in shown
    assert "Mark one as an asset in that file" in shown


def test_panel_has_the_values_of_a_paint_within_a_node_group(
    addon: Addon, cube: bpy.types.Object
) -> None:
    bpy.ops.material.metallic_paint_new()
    tree = cube.active_material.node_tree
    [paint] = [node for node in tree.nodes if node.type == "GROUP"]
    outer = bpy.data.node_groups.new("Mine", "ShaderNodeTree")
    outer.nodes.new("ShaderNodeGroup").node_tree = paint.node_tree
    paint.node_tree = outer
    for of in (bpy.types.MATERIAL_PT_metallic_paint, bpy.types.NODE_PT_metallic_paint):
        shown = drawn(of)
        assert "material.metallic_paint_new" not in shown.names
        text = " ".join(shown.texts)
        assert "flakes cover" in text
        assert "Of the node group “Mine”: what changes here changes wherever that is used." in text
    bpy.ops.material.metallic_paint_apply_preset(preset="gold")
    material, presets = addon("paint.material"), addon("paint.presets")
    assert material.paint_of(cube.active_material) == presets.load("gold")


def test_panel_offers_no_osl_where_there_is_none(
    addon: Addon, cube: bpy.types.Object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(addon("paint.material"), "has_osl", lambda: False)
    shown = panel()
    assert "built without Open Shading Language" in " ".join(shown.texts)
    assert "scene.metallic_paint_use_osl" not in shown.names


def test_panel_says_where_the_paint_shows(
    addon: Addon, cube: bpy.types.Object, monkeypatch: pytest.MonkeyPatch
) -> None:
    def view(shading: str) -> SimpleNamespace:
        space = SimpleNamespace(shading=SimpleNamespace(type=shading))
        return SimpleNamespace(type="VIEW_3D", spaces=SimpleNamespace(active=space))

    def shown(*shadings: str) -> bool:
        context = SimpleNamespace(
            screen=SimpleNamespace(areas=[view(each) for each in shadings]),
            scene=bpy.context.scene, object=cube,
        )  # fmt: skip
        texts = drawn(bpy.types.MATERIAL_PT_metallic_paint, context).texts
        return "A preview: the sparkles themselves show in Rendered view." in texts

    bpy.ops.scene.metallic_paint_use_osl()
    assert not shown("SOLID")
    bpy.ops.material.metallic_paint_new()
    assert shown("SOLID", "MATERIAL")
    assert not shown("SOLID", "RENDERED")
    assert not shown()


def value_panels() -> list[type]:
    names = ("flakes", "second_flakes", "third_flakes", "binder", "substrate", "sparkle", "lights")
    return [getattr(bpy.types, f"MATERIAL_PT_metallic_paint_{name}") for name in names]


def test_choices_are_chosen_by_words(addon: Addon, cube: bpy.types.Object) -> None:
    assert not any(each.poll(bpy.context) for each in value_panels())
    bpy.ops.material.metallic_paint_new()
    assert all(each.poll(bpy.context) for each in value_panels())
    material = addon("paint.material")
    node = material.paint_node(cube.active_material)
    choices = addon("interface.knobs").CHOICES
    drawn_names = [name for each in value_panels() for name in drawn(each).properties]
    assert len(drawn_names) >= len(addon("paint").PARAMETERS)
    assert sorted(set(drawn_names) - {"default_value"}) == sorted(choices)
    for name, parameter in choices.items():
        for number, word in enumerate(parameter.choices):
            setattr(node, name, word)
            assert node.inputs[parameter.label].default_value == number
        node.inputs[parameter.label].default_value = 1
        assert getattr(node, name) == parameter.choices[1]
    node.inputs["Coating"].default_value = -1
    assert node.metallic_paint_coating == "colors"
    assert not node.keys()


def test_labels_of_choices_have_their_room_in_a_narrow_panel(
    addon: Addon, cube: bpy.types.Object, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Blender gives a choice's label a third of the row, and cuts it."""
    bpy.ops.material.metallic_paint_new()
    sparkle = bpy.types.MATERIAL_PT_metallic_paint_sparkle
    assert "Depth Model" in drawn(sparkle).labels
    monkeypatch.setattr(addon("interface.panel"), "_width", lambda: 270)
    narrow = drawn(sparkle)
    assert "Depth Model:" in narrow.texts
    assert "Depth Model" not in narrow.labels


def test_what_artists_change_first_stands_in_the_panel(
    addon: Addon, cube: bpy.types.Object
) -> None:
    bpy.ops.material.metallic_paint_new()
    node = addon("paint.material").paint_node(cube.active_material)
    node.inputs["Coating"].default_value = 0
    common = ["Size (µm)", "Per mm²", "Sparkle", "Lacquer", "Roughness"]
    assert panel().labels == ["Flakes", "Color", *common]
    node.metallic_paint_coating = "aluminium"
    assert panel().labels == ["Flakes", *common]
    node.metallic_paint_coating = "tio2-on-mica"
    assert panel().labels == ["Flakes", "Film (nm)", *common]


def test_tint_is_the_color_after_one_way_through_the_layer(
    addon: Addon, cube: bpy.types.Object
) -> None:
    bpy.ops.material.metallic_paint_new()
    node = addon("paint.material").paint_node(cube.active_material)
    random = seeds.fresh(700)
    for _ in range(20):
        thickness = node.inputs["Layer Thickness (µm)"].default_value = random.uniform(1, 500)
        color = random.uniform(0.01, 1, 3).tolist()
        node.metallic_paint_tint = color
        assert tuple(node.metallic_paint_tint) == pytest.approx(color, rel=1e-5)
        absorption = node.inputs["Absorption (1/mm)"].default_value
        for per_mm, share in zip(absorption, color, strict=True):
            assert math.exp(-per_mm * thickness / 1000) == pytest.approx(share, rel=1e-5)
    node.metallic_paint_tint = (0, 0.5, 1)
    assert 0 < node.metallic_paint_tint[0] < 1 / 255
    assert node.inputs["Absorption (1/mm)"].default_value[2] == 0
    kept = tuple(node.inputs["Absorption (1/mm)"].default_value)
    node.inputs["Layer Thickness (µm)"].default_value = 0
    node.metallic_paint_tint = (0.5, 0.5, 0.5)
    assert tuple(node.inputs["Absorption (1/mm)"].default_value) == kept
    assert "Lacquer" not in panel().labels


def test_amount_is_said_in_words(addon: Addon, cube: bpy.types.Object) -> None:
    bpy.ops.material.metallic_paint_new()
    node = addon("paint.material").paint_node(cube.active_material)
    node.inputs["Flake Diameter (µm)"].default_value = 20
    area = math.pi / 4 * 0.02**2  # mm²
    for covered, said in (
        (0, "No flakes."),
        (0.001, "Sparse: flakes cover under 1% of the surface."),
        (0.05, "Sparse: flakes cover 5% of the surface."),
        (0.5, "Medium: flakes cover 39% of the surface."),
        (1.5, "Dense: flakes overlap and cover 78% of the surface."),
    ):
        node.inputs["Flakes per mm²"].default_value = covered / area
        assert said in " ".join(panel().texts)
    node.inputs["Flakes per mm² 2"].default_value = 1.5 / area
    node.inputs["Flake Diameter (µm) 2"].default_value = 20
    assert "cover 95%" in " ".join(panel().texts)


def test_panels_stand_without_the_add_on_of_cycles(cube: bpy.types.Object) -> None:
    bpy.ops.material.metallic_paint_new()
    bpy.ops.object.light_add(type="SUN")
    bpy.context.view_layer.objects.active = cube
    addon_utils.disable("cycles")
    try:
        bpy.context.view_layer.update()
        shown = " ".join(panel().texts)
        assert "does not render with Cycles" in shown
        for name in dir(bpy.types):
            if name.startswith("MATERIAL_PT_metallic_paint"):
                kind = getattr(bpy.types, name)
                if not hasattr(kind, "poll") or kind.poll(bpy.context):
                    drawn(kind)
    finally:
        addon_utils.enable("cycles")


def test_notice_of_older_paints(addon: Addon, cube: bpy.types.Object) -> None:
    bpy.ops.material.metallic_paint_new()
    assert "material.metallic_paint_update" not in panel().names
    addon("paint.material").node_group()["metallic_paint_source"] = "older"
    assert "material.metallic_paint_update" in panel().names
    assert "This file holds paints of an older version." in panel().texts


def test_panel_offers_a_rest_position_to_what_deforms(cube: bpy.types.Object) -> None:
    bpy.ops.material.metallic_paint_new()
    assert "scene.metallic_paint_add_rest_position" not in panel().names
    cube.modifiers.new("Wobble", "WAVE")
    shown = panel()
    assert "Cube deforms (Wobble): without a rest position" in " ".join(shown.texts)
    assert "scene.metallic_paint_add_rest_position" in shown.names
    assert bpy.ops.scene.metallic_paint_add_rest_position() == {"FINISHED"}
    assert "scene.metallic_paint_add_rest_position" not in panel().names
    cube.modifiers.new("Remesh", "REMESH")
    shown = panel()
    assert "Cube is made anew (Remesh) and has no rest position" in " ".join(shown.texts)
    assert "scene.metallic_paint_add_rest_position" not in shown.names


def test_panel_in_the_shader_editor(cube: bpy.types.Object) -> None:
    of = bpy.types.NODE_PT_metallic_paint
    for kind, shown in (("OBJECT", True), ("WORLD", False)):
        space = SimpleNamespace(tree_type="ShaderNodeTree", shader_type=kind)
        assert of.poll(SimpleNamespace(space_data=space)) == shown
    assert "material.metallic_paint_new" in drawn(of).names


def test_add_menu_has_the_paint(addon: Addon) -> None:
    for kind, entries in (("OBJECT", ["node.metallic_paint_add"]), ("WORLD", [])):
        layout = Layout()
        space = SimpleNamespace(shader_type=kind)
        addon("interface.panel")._draw_add(
            SimpleNamespace(layout=layout), SimpleNamespace(space_data=space)
        )
        assert layout.names == entries


def test_preset_menu_applies_to_a_paint_or_makes_one(addon: Addon, cube: bpy.types.Object) -> None:
    names = addon("paint.presets").names()
    for action in ("new", "apply_preset"):
        menu = drawn(bpy.types.MATERIAL_MT_metallic_paint_presets)
        chosen = [values["preset"] for name, values in menu.operators
                  if name == f"material.metallic_paint_{action}"]  # fmt: skip
        assert chosen == names
        assert menu.names[len(names) :] == [
            "material.metallic_paint_load_preset", "material.metallic_paint_save_preset"
        ]  # fmt: skip
        bpy.ops.material.metallic_paint_new()


def test_swatches_show_the_preset_and_choose_one(addon: Addon, cube: bpy.types.Object) -> None:
    assert not panel().icon_views
    bpy.ops.material.metallic_paint_new(preset="lime")
    assert panel().icon_views == ["metallic_paint_preset"]
    material, presets = addon("paint.material"), addon("paint.presets")
    node = material.paint_node(cube.active_material)
    assert node.metallic_paint_preset == "lime"
    for name in presets.names():
        node.metallic_paint_preset = name
        assert material.paint_of(node) == presets.load(name)
        assert node.metallic_paint_preset == name
    node.inputs["Tilt"].default_value *= 1.5
    assert node.metallic_paint_preset == "own"
    before = material.paint_of(node)
    node.metallic_paint_preset = "own"
    assert material.paint_of(node) == before
    assert not node.keys()


def test_preset_menu_lists_own_presets(addon: Addon, cube: bpy.types.Object) -> None:
    bpy.ops.material.metallic_paint_new(preset="lime")
    file = addon("interface.preset_operators").own_folder(create=True) / "my-lime.json"
    bpy.ops.material.metallic_paint_save_preset(filepath=str(file))
    try:
        menu = drawn(bpy.types.MATERIAL_MT_metallic_paint_presets)
        assert "My Lime" in menu.texts
        assert {"preset": str(file)} in [values for _, values in menu.operators]
    finally:
        file.unlink()


# --- the asset library -------------------------------------------------------------------------


def preferences(addon: Addon) -> Layout:
    return drawn(addon("interface.library").MetallicPaintPreferences)


def test_asset_library_comes_and_goes_by_buttons(addon: Addon) -> None:
    libraries = bpy.context.preferences.filepaths.asset_libraries
    before = libraries.keys()
    assert preferences(addon).names == ["preferences.metallic_paint_add_library"]
    with pytest.raises(RuntimeError, match="The asset library is not there"):
        bpy.ops.preferences.metallic_paint_remove_library()
    assert bpy.ops.preferences.metallic_paint_add_library() == {"FINISHED"}
    assert libraries.keys() == [*before, "Metallic Paint"]
    assert libraries["Metallic Paint"].import_method in ("APPEND", "APPEND_REUSE")
    assert preferences(addon).names == ["preferences.metallic_paint_remove_library"]
    with pytest.raises(RuntimeError, match="there already"):
        bpy.ops.preferences.metallic_paint_add_library()
    assert bpy.ops.preferences.metallic_paint_remove_library() == {"FINISHED"}
    assert libraries.keys() == before


def test_asset_library_is_known_behind_a_symbolic_link(
    addon: Addon, installed: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "link").symlink_to(installed)
    source = (installed / "paint" / "shader.py").read_text()
    file = tmp_path / "link" / "paint" / "shader.py"
    lines = [line for line in source.splitlines() if line.startswith(("_PACKAGE = ", "LIBRARY = "))]
    exec("\n".join(lines), {"__file__": str(file), "Path": Path}, found := {})
    monkeypatch.setattr(addon("interface.library"), "FOLDER", found["LIBRARY"].parent)
    bpy.ops.preferences.metallic_paint_add_library()
    try:
        assert preferences(addon).names == ["preferences.metallic_paint_remove_library"]
    finally:
        libraries = bpy.context.preferences.filepaths.asset_libraries
        libraries.remove(libraries["Metallic Paint"])


def test_build_without_library_says_so(
    addon: Addon, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(addon("interface.library"), "FOLDER", tmp_path / "none")
    with pytest.raises(RuntimeError, match="comes without an asset library"):
        bpy.ops.preferences.metallic_paint_add_library()


def test_asset_library_holds_every_preset(
    addon: Addon, cube: bpy.types.Object, installed: Path
) -> None:
    material, presets = addon("paint.material"), addon("paint.presets")
    folder = installed / "assets"
    catalogs = (folder / "blender_assets.cats.txt").read_text().splitlines()
    [catalog] = [line.split(":")[0] for line in catalogs if line.count(":") == 2]
    with bpy.data.libraries.load(
        str(folder / "metallic_paint.blend"), link=False, assets_only=True
    ) as (there, here):
        here.materials = there.materials
    assert len(here.materials) == len(presets.names())
    paints = sorted(here.materials, key=lambda painted: painted.name)
    for name, painted in zip(presets.names(), paints, strict=True):
        assert material.paint_of(painted) == presets.load(name)
        assert painted.asset_data.catalog_id == catalog
        assert painted.asset_data.description
        assert tuple(painted.preview.image_size) == (128, 128)
    assert not [thing for thing in bpy.data.objects if thing != cube]
    cube.active_material = here.materials[0]
    bpy.ops.object.light_add(type="SUN")
    assert len(addon("scene.carrier").values()) == 1
    assert len(addon("scene.lights").groups()) == 1
    assert not addon("paint.migration").has_outdated()


# --- words -------------------------------------------------------------------------------------


def test_labels_are_in_title_case_and_tooltips_end_without_a_full_stop(addon: Addon) -> None:
    kinds = [getattr(bpy.types, name) for name in dir(bpy.types) if "metallic_paint" in name]
    operators = [kind for kind in kinds if issubclass(kind, bpy.types.Operator)]
    assert len(operators) >= 10
    for kind in operators:
        assert kind.__doc__, kind
        assert not kind.__doc__.endswith("."), kind
        small = {"a", "as", "for", "from", "of", "on", "the", "to", "with"}
        words = [word for word in kind.bl_label.split() if word not in small]
        assert all(word[0].isupper() for word in words), kind.bl_label


def test_manifest_names_what_the_zip_holds(installed: Path) -> None:
    manifest = tomllib.loads((installed / "blender_manifest.toml").read_text())
    assert manifest["id"] == "metallic_paint"
    assert "wheels" not in manifest  # Blender refuses it whole where none fits its Python
