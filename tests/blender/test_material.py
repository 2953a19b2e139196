# SPDX-License-Identifier: Apache-2.0
"""The node group, the material, and the shader's text inside."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import OpenImageIO
import pytest
from metallic_paint.interface import knobs
from metallic_paint.paint import (
    PANELS,
    PARAMETERS,
    Flakes,
    Paint,
    PaintError,
    material,
    presets,
    shader,
    shader_value,
    value_of,
)
from metallic_paint.scene import lights, needs

Render = Callable[[], np.ndarray]


def everything_else() -> Paint:
    """No parameter has its default, and no two species share a number."""
    fields: dict[str, dict[str, Any]] = {"": {}, "second": {}, "third": {}}
    for number, (name, parameter) in enumerate(PARAMETERS.items()):
        species, _, field = name.rpartition(".")
        default = value_of(Paint(), name)
        share = 0.1 + 0.3 * number / len(PARAMETERS)
        least, most = parameter.slider
        between = float(f"{least + share * (most - least):.3g}")
        value: object = between
        if parameter.choices:
            value = next(word for word in reversed(parameter.choices) if word != default)
        elif isinstance(default, tuple):
            value = tuple(round(between + i, 5) for i in (0.01, 0.02, 0.03))
        elif isinstance(default, int):
            value = 23
        fields[species][field] = value
    paint = fields.pop("")
    return Paint(**paint, **{name: Flakes(**values) for name, values in fields.items()})


EVERYTHING_ELSE = everything_else()


def probe(body: str) -> str:
    """A shader with the paint's parameters that emits what the body assigns to `value`."""
    paint = Paint()
    parameters = ["int Frame = 0", "int CurrentFrame = 0", "float OtherLight = 0",
                  "float MetersPerUnit = 1", "normal Normal = N",
                  "normal CoatNormal = Normal", "vector RestPosition = 0"]  # fmt: skip
    for name, parameter in PARAMETERS.items():
        default = shader_value(parameter, value_of(paint, name))
        if isinstance(default, tuple):
            parameters.append(f"color {parameter.shader} = color{default}")
        else:
            parameters.append(f"{type(default).__name__} {parameter.shader} = {default}")
    for slot in range(1, lights.SLOTS + 1):
        kind, vector, size, facing = lights.slot_names(slot)
        parameters += [f"float {kind} = 0", f"vector {vector} = 0", f"float {size} = 0"]
        parameters.append(f"vector {facing} = 0")
    return (
        f"shader metallic_paint({', '.join(parameters)},\n"
        "output float Rendered = 1, output closure color BSDF = 0)\n"
        f"{{ color value = 0; {body} BSDF = value * emission(); }}\n"
    )


@pytest.fixture
def use_source(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    return lambda text: monkeypatch.setattr(shader, "source", lambda: text)


@pytest.fixture
def plane() -> bpy.types.Object:
    """A plane rising along y, seen from above by an orthographic camera, in a Cycles scene."""
    scene = bpy.context.scene
    material.set_up_cycles(scene)
    scene.cycles.samples = 1
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = 1
    camera.location.z = 5
    mesh = bpy.data.meshes.new("Plane")
    mesh.from_pydata([(-1, -1, -0.5), (1, -1, -0.5), (1, 1, 0.5), (-1, 1, 0.5)], [], [range(4)])
    thing = bpy.data.objects.new("Plane", mesh)
    for each in (camera, thing):
        scene.collection.objects.link(each)
    scene.camera = camera
    return thing


NORMAL_OF_PLANE = np.array([0, -1, 2]) / 5**0.5


@pytest.fixture
def render(tmp_path: Path) -> Render:
    """Renders the scene to an array (rows, columns, RGB)."""

    def run() -> np.ndarray:
        bpy.context.scene.render.filepath = str(tmp_path / "picture.exr")
        bpy.ops.render.render(write_still=True)
        return OpenImageIO.ImageBuf(str(tmp_path / "picture.exr")).get_pixels()[:, :, :3]

    return run


def interface() -> dict[str, bpy.types.NodeTreeInterfaceItem]:
    return {item.name: item for item in material.node_group().interface.items_tree}


def script_node() -> bpy.types.ShaderNodeScript:
    return next(node for node in material.node_group().nodes if node.type == "SCRIPT")


def script_inputs() -> dict[str, bpy.types.NodeSocket]:
    return {socket.identifier: socket for socket in script_node().inputs}


# --- interface --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_parameter_is_a_socket_with_panel_range_and_explanation(name: str) -> None:
    parameter = PARAMETERS[name]
    item = interface()[parameter.label]
    assert item.parent.name == parameter.panel
    assert item.description == parameter.description
    if not parameter.is_color:
        least, most = parameter.slider
        assert parameter.minimum <= least < most <= parameter.maximum
        assert (item.min_value, item.max_value) == pytest.approx((least, most))


def test_a_value_beyond_its_slider_may_be_typed_and_stays(tmp_path: Path) -> None:
    """Blender's own rule: a socket's range bounds the slider alone."""
    beyond = {"Flakes per mm²": 1e9, "IOR": 0.5, "Layer Thickness (µm)": 1e6, "Tilt": 1e-6}
    painted = material.create(Paint())
    painted.use_fake_user = True
    for label, value in beyond.items():
        item = interface()[label]
        assert not item.min_value <= value <= item.max_value
        material.paint_node(painted).inputs[label].default_value = value
    file = str(tmp_path / "beyond.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    bpy.ops.wm.open_mainfile(filepath=file)
    [painted] = bpy.data.materials
    inputs = material.paint_node(painted).inputs
    assert {label: inputs[label].default_value for label in beyond} == pytest.approx(beyond)


@pytest.mark.parametrize("name", PARAMETERS)
def test_the_defaults_of_shader_group_and_paint_are_the_same(name: str) -> None:
    parameter = PARAMETERS[name]
    expected = shader_value(parameter, value_of(Paint(), name))
    for socket in (script_inputs()[parameter.shader], interface()[parameter.label]):
        assert value_in(socket) == pytest.approx(expected)


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_socket_is_wired_to_its_parameter(name: str) -> None:
    parameter = PARAMETERS[name]
    (link,) = script_inputs()[parameter.shader].links
    assert (link.from_node.type, link.from_socket.name) == ("GROUP_INPUT", parameter.label)


def test_panels_stand_in_order_and_are_closed() -> None:
    items = material.node_group().interface.items_tree
    panels = [item for item in items if item.item_type == "PANEL"]
    assert [panel.name for panel in panels] == list(PANELS)
    assert all(panel.default_closed for panel in panels)


def test_the_paint_that_ships_shows_no_inner_values() -> None:
    group = material.node_group()
    (script,) = (node for node in group.nodes if node.type == "SCRIPT")
    assert [socket.name for socket in script.outputs] == ["Rendered", "BSDF"]
    for tree_or_node in (interface(), script.inputs.keys()):
        assert not [name for name in tree_or_node if name.startswith("Diagn") or name == "Shown"]


def test_light_slots_are_no_sockets_of_the_group() -> None:
    labels = interface()
    slots = [name for slot in range(1, 9) for name in lights.slot_names(slot)]
    assert not [label for label in labels if label.replace(" ", "") in slots]


def test_every_socket_explains_itself() -> None:
    silent = [item.name for item in interface().values() if not item.description]
    assert silent == ["BSDF"]


def test_labels_are_short_enough_for_the_editor() -> None:
    assert max(map(len, interface())) <= 24


def value_in(socket: bpy.types.NodeSocket) -> float | tuple[float, ...]:
    value = socket.default_value
    return value if isinstance(value, int | float) else tuple(value)[:3]


# --- material ---------------------------------------------------------------------------------


@pytest.mark.parametrize("paint", [Paint(), EVERYTHING_ELSE, *map(presets.load, presets.names())])
def test_a_material_has_the_values_of_its_paint(paint: Paint) -> None:
    node = material.paint_node(material.create(paint))
    for name, parameter in PARAMETERS.items():
        expected = shader_value(parameter, value_of(paint, name))
        assert value_in(node.inputs[parameter.label]) == pytest.approx(expected), name


def test_the_panels_coverage_is_that_of_the_paint() -> None:
    """Which flakes of uneven area exceed: those of a negative area are left out."""
    more = Flakes(flakes_per_mm2=200, flake_diameter_um=40, flake_area_spread=3)
    paint = Paint(flakes_per_mm2=1000, flake_diameter_um=20, flake_area_spread=2, second=more)
    node = material.paint_node(material.create(paint))
    covered = sum(each.flake_coverage for each in paint.species)
    assert knobs.coverage(node) == pytest.approx(covered)
    value = node.id_data.nodes.new("ShaderNodeValue")
    node.id_data.links.new(value.outputs[0], node.inputs["Flake Area Spread 2"])
    assert knobs.coverage(node) is None


def test_every_field_differs_in_the_other_paint() -> None:
    assert not [n for n in PARAMETERS if value_of(EVERYTHING_ELSE, n) == value_of(Paint(), n)]


def test_applying_a_paint_changes_one_material_only() -> None:
    one, other = material.create(Paint()), material.create(Paint())
    material.apply(one, Paint(seed=5))
    material.apply(material.paint_node(other), Paint(seed=6))
    assert material.paint_node(one).inputs["Seed"].default_value == 5
    assert material.paint_node(other).inputs["Seed"].default_value == 6


def test_paints_share_one_group_one_shader_and_one_set_of_lights() -> None:
    one, other = material.create(Paint()), material.create(presets.load("gold"))
    assert material.paint_node(one).node_tree == material.paint_node(other).node_tree
    assert sorted(group.name for group in bpy.data.node_groups) == [material.NAME, lights.NAME]
    assert len(bpy.data.texts) == 1


def test_a_material_without_paint_takes_no_paint() -> None:
    plain = bpy.data.materials.new("Plain")
    for act in (material.paint_of, lambda each: material.apply(each, Paint())):
        with pytest.raises(PaintError, match="'Plain' has no Metallic Paint node: add one"):
            act(plain)


@pytest.mark.parametrize(
    ("version", "reason"),
    [(material.VERSION - 1, "older version: update it"), (material.VERSION, "older version"),
     (material.VERSION + 1, "newer version: update the add-on")],
)  # fmt: skip
def test_a_paint_of_another_version_is_neither_read_nor_changed(version: int, reason: str) -> None:
    painted = bpy.data.materials.new("Other")
    if painted.node_tree is None:
        painted.use_nodes = True  # Blender 4.5
    node = painted.node_tree.nodes.new("ShaderNodeGroup")
    node.node_tree = bpy.data.node_groups.new(material.NAME, "ShaderNodeTree")
    node.node_tree["metallic_paint"] = version
    first = next(iter(PARAMETERS.values())).label  # apply would set it, and miss the second
    node.node_tree.interface.new_socket(first, in_out="INPUT", socket_type="NodeSocketFloat")
    for act in (material.paint_of, lambda each: material.apply(each, Paint())):
        with pytest.raises(PaintError, match=f"The paint is of an? {reason}"):
            act(painted)
    assert node.inputs[first].default_value == 0


def test_assigning_paints_the_whole_object(plane: bpy.types.Object) -> None:
    for name in ("Old", "Older"):
        plane.data.materials.append(bpy.data.materials.new(name))
    plane.material_slots[0].link = "OBJECT"
    plane.data.polygons[0].material_index = 1
    paint = material.create(Paint())
    material.assign(plane, paint)
    assert [slot.material for slot in plane.material_slots] == [paint]
    assert plane.data.polygons[0].material_index == 0


def test_an_empty_cannot_be_painted() -> None:
    with pytest.raises(PaintError, match=r"'Nothing' \(EMPTY\) cannot hold a material: paint"):
        material.assign(bpy.data.objects.new("Nothing", None), material.create(Paint()))


def test_nothing_but_the_explicit_call_changes_the_scenes_engine() -> None:
    scene = bpy.context.scene
    before = scene.render.engine, scene.cycles.shading_system
    assert before[0] != "CYCLES"
    material.create(Paint())
    lights.fill(scene)
    assert (scene.render.engine, scene.cycles.shading_system) == before
    assert list(bpy.data.scenes) == [scene]
    material.set_up_cycles(scene)
    assert (scene.render.engine, scene.cycles.shading_system) == ("CYCLES", True)


def test_a_lit_paint_is_neither_black_nor_infinite(plane: bpy.types.Object, render: Render) -> None:
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    bpy.context.scene.collection.objects.link(sun)
    material.assign(plane, material.create(Paint(substrate_color=(0.5, 0.5, 0.5))))
    lights.fill(bpy.context.scene)
    picture = render()
    assert np.isfinite(picture).all()
    assert picture.mean() > 0.01


def test_a_saved_file_has_no_undefined_node_and_keeps_the_bytecode(tmp_path: Path) -> None:
    material.create(Paint()).use_fake_user = True
    before = script_node().bytecode
    assert before
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "paint.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "paint.blend"), use_scripts=False)
    trees = [*bpy.data.node_groups, *(each.node_tree for each in bpy.data.materials)]
    nodes = [node for tree in trees for node in tree.nodes]
    assert {"SCRIPT", "GROUP"} <= {node.type for node in nodes}
    assert not [node.name for node in nodes if node.bl_idname == "NodeUndefined"]
    assert script_node().bytecode == before
    material.create(Paint())
    assert len(bpy.data.node_groups) == 2


# --- what reaches the shader ------------------------------------------------------------------


@pytest.mark.long
def test_an_unconnected_normal_is_the_surfaces(
    plane: bpy.types.Object, render: Render, use_source: Callable[[str], None]
) -> None:
    use_source(probe("value = color(Normal[0], Normal[1], Normal[2]);"))
    paint = material.create(Paint())
    material.assign(plane, paint)
    np.testing.assert_allclose(render()[8, 8], NORMAL_OF_PLANE, atol=1e-6)
    # Cycles never looks at the hidden value, so nobody can spoil it.
    material.paint_node(paint).inputs["Normal"].default_value = (0.3, 0.4, 0.5)
    np.testing.assert_allclose(render()[8, 8], NORMAL_OF_PLANE, atol=1e-6)


@pytest.mark.long
def test_an_unconnected_normal_is_the_surfaces_inside_an_artists_group_too(
    plane: bpy.types.Object, render: Render, use_source: Callable[[str], None]
) -> None:
    use_source(probe("value = color(Normal[0], Normal[1], Normal[2]);"))
    outer = bpy.data.node_groups.new("Outer", "ShaderNodeTree")
    outer.interface.new_socket("Normal", in_out="INPUT", socket_type="NodeSocketVector")
    outer.interface.new_socket("BSDF", in_out="OUTPUT", socket_type="NodeSocketShader")
    inside, out = outer.nodes.new("NodeGroupInput"), outer.nodes.new("NodeGroupOutput")
    inner = outer.nodes.new("ShaderNodeGroup")
    inner.node_tree = material.node_group()
    outer.links.new(inside.outputs["Normal"], inner.inputs["Normal"])
    outer.links.new(inner.outputs["BSDF"], out.inputs["BSDF"])
    paint = material.create(Paint())
    material.paint_node(paint).node_tree = outer
    paint.node_tree.links.new(
        paint.node_tree.nodes[material.NAME].outputs[0],
        paint.node_tree.nodes["Material Output"].inputs["Surface"],
    )
    material.assign(plane, paint)
    np.testing.assert_allclose(render()[8, 8], NORMAL_OF_PLANE, atol=1e-6)


@pytest.mark.long
def test_a_connected_normal_is_taken(
    plane: bpy.types.Object, render: Render, use_source: Callable[[str], None]
) -> None:
    use_source(probe("value = color(Normal[0], Normal[1], Normal[2]);"))
    paint = material.create(Paint())
    material.assign(plane, paint)
    nodes, links = paint.node_tree.nodes, paint.node_tree.links
    geometry, turned = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeVectorMath")
    turned.operation = "MULTIPLY"
    turned.inputs[1].default_value = (1, -1, 1)
    links.new(geometry.outputs["Normal"], turned.inputs[0])
    links.new(turned.outputs[0], material.paint_node(paint).inputs["Normal"])
    np.testing.assert_allclose(render()[8, 8], NORMAL_OF_PLANE * [1, -1, 1], atol=1e-6)


@pytest.mark.long
def test_an_unconnected_rest_position_is_none_and_a_connected_one_is_taken(
    plane: bpy.types.Object, render: Render, use_source: Callable[[str], None]
) -> None:
    use_source(probe("value = color(RestPosition[0], RestPosition[1], RestPosition[2]);"))
    paint = material.create(Paint())
    material.assign(plane, paint)
    np.testing.assert_array_equal(render()[8, 8], 0)
    nodes, links = paint.node_tree.nodes, paint.node_tree.links
    place = nodes.new("ShaderNodeCombineXYZ")
    for i, value in enumerate((0.25, 2, 3)):
        place.inputs[i].default_value = value
    links.new(place.outputs[0], material.paint_node(paint).inputs[material.REST_POSITION])
    np.testing.assert_array_equal(render()[8, 8], [0.25, 2, 3])


@pytest.mark.long
def test_the_shader_knows_how_long_a_unit_of_the_scene_is(
    plane: bpy.types.Object, render: Render, use_source: Callable[[str], None]
) -> None:
    use_source(probe("value = MetersPerUnit;"))
    paint = material.create(Paint())
    material.assign(plane, paint)
    assert render()[8, 8, 0] == 1
    bpy.context.scene.unit_settings.scale_length = 0.25
    lights.fill(bpy.context.scene)
    assert render()[8, 8, 0] == 0.25
    material.paint_node(paint).inputs[material.MODEL_SCALE].default_value = 8
    assert render()[8, 8, 0] == 2


@pytest.mark.long
def test_the_shader_knows_the_scenes_frame_where_the_paint_is_new_in_every_frame(
    plane: bpy.types.Object, render: Render, use_source: Callable[[str], None]
) -> None:
    """Elsewhere the compiler knows it to be 0, and leaves it out."""
    use_source(probe("value = color(Frame, CurrentFrame, isconstant(CurrentFrame));"))
    scene = bpy.context.scene
    paint = material.create(Paint())
    material.assign(plane, paint)
    node = material.paint_node(paint)
    node.inputs["Frame"].default_value = 5
    scene.frame_set(30)
    needs.fit(scene)
    assert render()[8, 8].tolist() == [5, 0, 1]
    node.inputs[material.NEW_IN_EVERY_FRAME].default_value = True
    needs.fit(scene)
    assert render()[8, 8].tolist() == [5, 30, 0]
    scene.frame_set(-3, subframe=0.75)
    assert render()[8, 8].tolist() == [5, -3, 0]


def test_every_value_of_a_paint_reaches_the_shader(
    plane: bpy.types.Object, render: Render, use_source: Callable[[str], None]
) -> None:
    shown = "".join(
        f"if (Frame == {i}) value = {parameter.shader};"
        for i, parameter in enumerate(PARAMETERS.values())
    )
    use_source(probe(shown))
    paint = material.create(EVERYTHING_ELSE)
    material.assign(plane, paint)
    for i, (name, parameter) in enumerate(PARAMETERS.items()):
        material.paint_node(paint).inputs["Frame"].default_value = i
        expected = shader_value(parameter, value_of(EVERYTHING_ELSE, name))
        np.testing.assert_allclose(render()[8, 8], expected, rtol=1e-6, err_msg=name)


# --- compiling --------------------------------------------------------------------------------


def test_a_shader_that_does_not_compile_is_an_error_with_the_compilers_words(
    use_source: Callable[[str], None], capfd: pytest.CaptureFixture[str]
) -> None:
    use_source("shader metallic_paint(output closure color BSDF = 0) { BSDF = unheard_of; }")
    with pytest.raises(RuntimeError, match=r"metallic_paint\.osl does not compile.*'unheard_of'"):
        material.create(Paint())
    assert not bpy.data.node_groups
    assert not bpy.data.texts
    assert not bpy.data.materials
    assert "unheard_of" in "".join(capfd.readouterr())  # the console has it too
    for stream in (1, 2):
        os.write(stream, b"heard again")
    assert capfd.readouterr() == ("heard again", "heard again")


def test_a_shader_that_lacks_a_parameter_is_an_error(use_source: Callable[[str], None]) -> None:
    use_source(probe("").replace("int Seed = 0,", ""))
    with pytest.raises(shader.CompileError, match=r"lacks the parameters Seed: .* anew\."):
        material.node_group()
    assert not bpy.data.node_groups


def test_a_shader_with_an_unknown_parameter_is_an_error(
    use_source: Callable[[str], None],
) -> None:
    use_source(probe("").replace("int Seed = 0,", "int Seed = 0, float Glitter = 1,"))
    with pytest.raises(shader.CompileError, match=r"unknown parameters Glitter: .* anew\."):
        material.node_group()


@pytest.mark.long
def test_a_new_shader_leaves_the_paints_that_are_there_alone(
    use_source: Callable[[str], None],
) -> None:
    use_source(probe("value = 1;"))
    old = material.create(Paint())
    bytecode = script_node().bytecode
    use_source(probe("value = 2;"))
    new = material.create(Paint())
    old_group, new_group = (material.paint_node(each).node_tree for each in (old, new))
    assert old_group != new_group
    assert old_group.nodes[material.NAME].bytecode == bytecode
    assert new_group.nodes[material.NAME].bytecode != bytecode


# --- one text ---------------------------------------------------------------------------------


def write(folder: Path, **files: str) -> Path:
    for name, text in files.items():
        file = folder / name.replace("__", "/").replace("_", ".")
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")
    return folder / "main.osl"


def test_a_header_is_written_out_once_and_a_table_each_time(tmp_path: Path) -> None:
    main = write(
        tmp_path,
        main_osl='#include "a.h"\n#include "b.h"\nmain\n',
        a_h='  #  include "b.h"  // first\na { \n#include "../t.inc"\n}\n',
        b_h='b { \n#include "t.inc"\n}\n',
        t_inc="1, 2\n",
    )
    (tmp_path / "a.h").write_text((tmp_path / "a.h").read_text().replace("../t", "t"))
    assert shader.flatten(main) == "b { \n1, 2\n}\na { \n1, 2\n}\n\nmain\n"


def test_a_pragma_once_has_no_place_in_one_text(tmp_path: Path) -> None:
    """Blender's oslc crashes on it there."""
    main = write(tmp_path, main_osl='#include "a.h"\nmain\n', a_h="// a\n#pragma once\na\n")
    assert shader.flatten(main) == "// a\na\nmain\n"


def test_a_path_is_relative_to_the_file_that_includes_it(tmp_path: Path) -> None:
    main = write(
        tmp_path,
        main_osl='#include "sub/a.h"\n',
        sub__a_h='#include "../c.h"\n#include "b.h"\n',
        sub__b_h='#include "../c.h"\nb\n',
        c_h="c\n",
    )
    assert shader.flatten(main) == "c\n\nb\n"


def test_the_compilers_own_headers_stay_included(tmp_path: Path) -> None:
    text = '#include "stdcycles.h"\n#include <stdosl.h>\nmain\n'
    assert shader.flatten(write(tmp_path, main_osl=text)) == text


def test_a_flat_text_stays_as_it_is(tmp_path: Path) -> None:
    assert shader.flatten(write(tmp_path, main_osl=shader.source())) == shader.source()


def test_a_missing_header_is_named(tmp_path: Path) -> None:
    main = write(tmp_path, main_osl='#include "a.h"\n', a_h='#include "gone.h"\n')
    with pytest.raises(FileNotFoundError, match=r"a\.h includes 'gone\.h', and there is no .*gone"):
        shader.flatten(main)


def test_a_table_that_includes_itself_is_an_error(tmp_path: Path) -> None:
    main = write(tmp_path, main_osl='#include "t.inc"\n', t_inc='#include "t.inc"\n')
    with pytest.raises(ValueError, match=r"t\.inc includes itself"):
        shader.flatten(main)


def test_the_shader_of_an_installed_package_comes_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package, repository = tmp_path / "package", tmp_path / "repository"
    for folder in (package, repository):
        folder.mkdir()
    monkeypatch.setattr(shader, "FOLDERS", (package, repository))
    with pytest.raises(FileNotFoundError, match=r"metallic_paint\.osl is in none of .*package"):
        shader.source()
    (repository / shader.FILE).write_text("repository")
    assert shader.source() == "repository"
    (package / shader.FILE).write_text("package")
    assert shader.source() == "package"


@pytest.mark.parametrize(
    ("paint", "expected"),
    [
        (Paint(flakes_per_mm2=1e5, flake_color=(0.1, 0.2, 0.3)), (0.1, 0.2, 0.3)),
        (Paint(flakes_per_mm2=1e5, coating="gold"), (1.0, 0.67627144, 0.26692858)),
        (
            Paint(
                flakes_per_mm2=1e5,
                coating="tio2-on-silica",
                coating_nm=80,
                substrate_color=(0, 0, 0),
            ),
            (0.34735715, 0.39661428, 0.051442858),
        ),
        (Paint(flakes_per_mm2=0, substrate_color=(0.3, 0.2, 0.1)), (0.3, 0.2, 0.1)),
        (
            Paint(
                flakes_per_mm2=1e5,
                flake_color=(0.5, 0.5, 0.5),
                binder_absorption_per_mm=(0, 0, 100),
                layer_thickness_um=10,
            ),
            (0.5, 0.5, 0.5 * np.exp(-1)),
        ),
    ],
    ids=["colour", "metal", "pearl", "substrate", "tinted"],
)
def test_the_solid_view_shows_the_paints_colour(
    paint: Paint, expected: tuple[float, float, float]
) -> None:
    assert material.create(paint).diffuse_color[:3] == pytest.approx(expected)


def test_a_material_that_is_more_than_the_paint_keeps_its_colour() -> None:
    painted = material.create(Paint())
    node, tree = material.paint_node(painted), painted.node_tree
    tree.links.clear()
    before = tuple(painted.diffuse_color)
    material.apply(node, presets.load("candy-red"))
    assert tuple(painted.diffuse_color) == before
    tree.links.new(node.outputs["BSDF"], tree.nodes["Material Output"].inputs["Surface"])
    material.apply(node, presets.load("candy-red"))
    red, green, blue, _ = painted.diffuse_color
    assert red > 3 * max(green, blue)
