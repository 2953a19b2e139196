# SPDX-License-Identifier: Apache-2.0
"""The scene report foretells what the shader finds, and warns of what spoils sparkles."""

from __future__ import annotations

import math
import re
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
import panels
import pytest
from gate import first_of
from metallic_paint import denoise, verify
from metallic_paint.interface import report as interface
from metallic_paint.paint import material, presets
from metallic_paint.scene import lights, needs, rest_position, sight
from metallic_paint.scene.report import report
from recording import drawn
from scenery import (
    add_lamp,
    disc,
    link_namesake,
    link_paint,
    nest_paint,
    show_as_instance,
    world_of,
)
from verification import scenes

SIZE = 64


@pytest.fixture
def registered() -> Iterator[None]:
    with panels.registered(interface):
        yield


def build(preset: str = "silver-coarse", radius: float = 0.02) -> bpy.types.Scene:
    """A painted ball that fills half the picture's width, under a sun; nothing spoils it."""
    scene = bpy.context.scene
    material.set_up_cycles(scene)
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = 2 * SIZE
    scene.render.resolution_percentage = 50
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=radius)
    bpy.context.object.name = "Ball"
    bpy.ops.object.shade_smooth()
    material.assign(bpy.context.object, material.create(presets.load(preset)))
    add_lamp("SUN", "Sun", energy=3, angle=math.radians(0.53), rotation_euler=(0.7, 0.3, 0))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -20 * radius, 0), (math.radians(90), 0, 0)
    camera.data.angle = 2 * math.atan(0.1)
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


def said(scene: bpy.types.Scene, *levels: str) -> str:
    found = report(scene)
    return "\n".join(text for level, text in found if not levels or level in levels)


def bad(scene: bpy.types.Scene) -> str:
    return said(scene, "WARNING", "ERROR")


def number(pattern: str, text: str) -> float:
    return float(re.search(pattern, text)[1].replace(",", ""))


@pytest.mark.parametrize("camera", first_of(["PERSP", "ORTHO"]))
@pytest.mark.parametrize("radius", first_of([0.02, 0.5]))
def test_flakes_and_sparkles_are_those_that_the_shader_finds(camera: str, radius: float) -> None:
    scene = build(radius=radius)
    scene.camera.data.type, scene.camera.data.ortho_scale = camera, 4 * radius
    node = material.paint_node(scene.objects["Ball"].active_material)
    node.inputs[material.MODEL_SCALE].default_value = 1.5
    text = said(scene)
    node.inputs["Anchor"].default_value = 0  # counts of whole pixels, as the report's are
    probe = verify.Probe(scene, [scene.objects["Ball"].active_material])
    geometry = probe.geometry()
    paint = material.paint_of(node)
    counts = probe.image(verify.MEAN_COUNT)[geometry.hit][:, 0]
    per_m2 = 1e6 * sum(each.flakes_per_mm2 for each in paint.species)
    flakes = np.median(geometry.footprint[geometry.hit]) * per_m2
    assert number(r"Ball: ([\d.,e+]+) flakes a pixel", text) == pytest.approx(flakes, rel=0.1)
    middle = number(r"([\d.,e+-]+) sparkles in the middle", text)
    most = number(r"and ([\d.,e+-]+) where there are most", text)
    # Counts run from 0 to hundreds over the ball: the middle is where they rise steeply.
    assert middle == pytest.approx(np.median(counts), rel=0.3)
    assert most == pytest.approx(np.quantile(counts, 0.9), rel=0.2)


def test_a_sound_scene_has_no_warning() -> None:
    scene = build()
    assert bad(scene) == ""
    assert "Light 1: Sun." in said(scene)


def test_what_a_scene_needs_is_still_fitted_after_the_report() -> None:
    scene = build()
    scene.cycles.max_bounces = 0  # or the ball might show itself
    assert "show no world" in said(scene)
    assert lights.constant(lights.OTHER_LIGHT) == 0


def test_sparkles_that_merge_are_foretold() -> None:
    assert "too many and too small" in bad(build(radius=50))


def test_a_paint_without_sparkles_is_foretold() -> None:
    scene = build()
    node = material.paint_node(scene.objects["Ball"].active_material)
    node.inputs["Flakes per mm²"].default_value = 1e-3
    assert "no sparkle is to be expected" in bad(scene)


def test_a_paint_without_contrast_needs_no_sparkles() -> None:
    scene = build()
    node = material.paint_node(scene.objects["Ball"].active_material)
    node.inputs["Flakes per mm²"].default_value = 1e-3
    scene.cycles.use_denoising = True
    assert "Denoising takes sparkles" in bad(scene)
    node.inputs["Sparkle Contrast"].default_value = 0
    assert bad(scene) == ""
    assert "With Sparkle Contrast 0 they show their mean" in said(scene, "INFO")


def test_clamping_that_cuts_is_named_with_its_value() -> None:
    scene = build()
    scene.cycles.sample_clamp_direct = 0.25
    assert "Clamp Direct 0.25 cuts sparkles" in bad(scene)
    scene.cycles.sample_clamp_direct = 1e6
    assert bad(scene) == ""
    scene.cycles.sample_clamp_indirect = 0.25
    assert "Clamp Indirect 0.25 dims" in said(scene, "INFO")


@pytest.mark.long
def test_clamping_warns_exactly_where_it_cuts() -> None:
    scene = build()
    verify.make_noiseless(scene)
    report(scene)  # fits the paint
    whole = verify.render(scene)
    warned = {}
    for clamp in (0.1, 1, 100):
        scene.cycles.sample_clamp_direct = clamp
        warned[clamp] = "Clamp Direct" in bad(scene)
        lost = 1 - verify.render(scene).sum() / whole.sum()
        assert warned[clamp] == (lost > 0.05), (clamp, lost)
    assert warned[0.1]
    assert not warned[100]


def test_the_device_and_the_shading_language_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = build()
    scene.cycles.shading_system = False
    assert "Open Shading Language is off" in said(scene, "ERROR")
    scene.cycles.shading_system = True
    scene.cycles.device = "GPU"
    monkeypatch.setattr(material, "gpu", lambda _: "HIP")
    assert "HIP, which has no Open Shading Language" in said(scene, "ERROR")
    scene.render.engine = "BLENDER_WORKBENCH"
    assert "does not render with Cycles" in said(scene, "ERROR")


def test_a_denoiser_is_warned_of_unless_sparkles_pass_it_by() -> None:
    scene = build()
    scene.cycles.use_denoising = True
    assert "Denoising takes sparkles" in bad(scene)
    denoise.set_up(scene)
    assert bad(scene) == ""


def test_what_the_pixel_anchor_cannot_do_is_named_for_its_paints_alone() -> None:
    scene = build()
    node = material.paint_node(scene.objects["Ball"].active_material)
    scene.render.use_motion_blur = True
    blur, panorama = (
        "Motion blur under the pixel anchor",
        "Panoramic cameras under the pixel anchor",
    )
    assert "pixel anchor" not in said(scene)
    node.inputs["Anchor"].default_value = 0
    found = bad(scene)
    assert f"{blur} (Metallic Paint): sparkles of what moves stay sharp." in found
    assert panorama not in found
    scene.render.use_motion_blur = False
    scene.camera.data.type = "PANO"
    found = bad(scene)
    assert f"{panorama} (Metallic Paint): sparkles are squares." in found
    assert blur not in found
    node.inputs["Sparkle Contrast"].default_value = 0
    assert "pixel anchor" not in said(scene)
    node.inputs["Sparkle Contrast"].default_value = 1
    node.inputs["Anchor"].default_value = 1
    assert "pixel anchor" not in said(scene)


def test_what_deforms_without_a_rest_position_is_named() -> None:
    scene = build()
    scene.objects["Ball"].modifiers.new("Wobble", "WAVE")
    assert "Ball deforms (Wobble): without a rest position it slides" in bad(scene)
    rest_position.give(scene)
    assert bad(scene) == ""


def test_an_unlikely_size_is_named() -> None:
    scene = build()
    scene.unit_settings.scale_length = 1e-3
    assert "Ball is 40 µm large" in bad(scene)


def test_what_the_camera_does_not_see_is_said() -> None:
    scene = build()
    scene.camera.location.y = 1
    assert "Ball: the camera does not see it" in said(scene, "INFO")
    scene.camera.location.y = -0.4
    bpy.ops.mesh.primitive_plane_add(size=4, location=(0, -0.2, 0), rotation=(math.pi / 2, 0, 0))
    assert "Ball: the camera does not see it" in said(scene, "INFO")
    bpy.context.object.hide_render = True
    assert "flakes a pixel" in said(scene, "INFO")
    scene.camera.data.type = "PANO"
    assert "nothing can be said of the pixels of a PANO camera" in said(scene, "INFO")
    scene.camera = None
    assert "without a camera" in said(scene, "INFO")


def test_what_the_camera_clips_is_not_seen() -> None:
    scene = build()
    scene.camera.data.clip_end = 0.3
    assert "Ball: the camera does not see it" in said(scene, "INFO")


def test_a_painted_object_that_renders_no_paint_is_named() -> None:
    scene = build()
    ball = scene.objects["Ball"]
    for name in ("is_holdout", "is_shadow_catcher"):
        setattr(ball, name, True)
        assert "Ball is a Holdout or Shadow Catcher" in bad(scene)
        setattr(ball, name, False)
    assert bad(scene) == ""


def test_the_lights_of_a_background_set_are_named() -> None:
    scene = build()
    stage = bpy.data.scenes.new("Stage")
    scene.background_set = stage
    assert bad(scene) == ""
    stage.collection.objects.link(scene.objects["Sun"])
    scene.collection.objects.unlink(scene.objects["Sun"])
    assert "The lights of the Background Set Stage make no sparkles." in bad(scene)


def test_a_scene_without_paint_or_lamps_is_warned_of() -> None:
    scene = build()
    bpy.data.objects.remove(scene.objects["Sun"])
    assert "Nothing sparkles" in bad(scene)
    bpy.data.objects.remove(scene.objects["Ball"])
    assert "No object that renders is painted" in bad(scene)


def test_paint_on_instances_alone_is_said() -> None:
    scene = build()
    show_as_instance(scene.objects["Ball"])
    assert "Painted only as instances: nothing can be foretold." in said(scene, "INFO")
    assert "No object that renders is painted" not in bad(scene)


def set_by_nodes(thing: bpy.types.Object) -> None:
    """Geometry nodes give the thing its material, which its mesh has not."""
    tree = bpy.data.node_groups.new("Paint", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    inside, out = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    node = tree.nodes.new("GeometryNodeSetMaterial")
    node.inputs["Material"].default_value = thing.active_material
    tree.links.new(inside.outputs[0], node.inputs["Geometry"])
    tree.links.new(node.outputs[0], out.inputs[0])
    thing.modifiers.new("Paint", "NODES").node_group = tree
    thing.data.materials.clear()


def test_paint_that_geometry_nodes_set_is_foretold() -> None:
    scene = build()
    set_by_nodes(scene.objects["Ball"])
    assert lights.uses_paint(scene)
    text = said(scene)
    assert "flakes a pixel" in text
    assert "painted" not in text


def test_several_scenes_with_paints_are_warned_of() -> None:
    scene = build()
    other = bpy.data.scenes.new("Other")
    assert bad(scene) == ""
    collection = bpy.data.collections.new("Balls")
    collection.objects.link(scene.objects["Ball"])
    empty = bpy.data.objects.new("Instancer", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    other.collection.objects.link(empty)
    assert "More than one scene uses paints" in bad(scene)


def test_the_sun_of_a_world_is_foretold_as_a_sun_lamp_of_its_place_and_size() -> None:
    scene = build()
    sun = scene.objects["Sun"]
    lamps = said(scene, "INFO")
    scene.view_layers[0].update()
    towards = np.array(sun.matrix_world.col[2].xyz)
    sun.hide_render = True
    radius = sun.data.angle / 2
    world_of(disc(towards, radius, sun.data.energy / (math.pi * radius**2), 0))
    assert bad(scene) == ""
    most = [number(r"and ([\d.,e+-]+) where there are most", each)
            for each in (lamps, said(scene, "INFO"))]  # fmt: skip
    assert most[1] == pytest.approx(most[0], rel=0.5)  # of pixels 3 mrad wide
    scene.cycles.sample_clamp_direct = 0.1
    assert "Clamp Direct 0.1 cuts sparkles" in bad(scene)
    add_lamp("POINT", "Point", energy=0.01, location=(0, -1, 1))
    assert "Light 2: the sun of World." in said(scene)


@pytest.mark.parametrize("kind", ["SUN", "AREA"])
def test_a_lamp_scaled_to_nothing_is_left_out(kind: str) -> None:
    scene = build()
    before = [line for line in said(scene).splitlines() if "flakes a pixel" in line]
    add_lamp(kind, "Nothing", scale=(0, 0, 0))
    assert before == [line for line in said(scene).splitlines() if "flakes a pixel" in line]
    bpy.data.objects.remove(scene.objects["Sun"])
    assert "no sparkle is to be expected" in bad(scene)


def test_a_lamp_hidden_at_this_frame_is_foretold_no_sparkles() -> None:
    scene = build()
    sun = scene.objects["Sun"]
    sun.keyframe_insert("hide_render", frame=1)
    assert bad(scene) == ""
    sun.hide_render = True
    sun.keyframe_insert("hide_render", frame=1)
    assert "no sparkle is to be expected" in bad(scene)


def test_without_the_native_module_flakes_are_counted_and_the_reason_is_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = build()
    monkeypatch.setitem(sys.modules, "metallic_paint_core", None)
    text = said(scene)
    assert "flakes a pixel." in text
    assert "sparkles cannot be foretold. This build of the add-on has no native module" in text


def test_values_that_no_paint_can_have_are_named() -> None:
    scene = build()
    node = material.paint_node(scene.objects["Ball"].active_material)
    node.inputs["Coating"].default_value = 0
    node.inputs["Flake Color"].default_value = (1, 1, 1, 1)
    node.inputs["Flake Transmission"].default_value = (1, 1, 1, 1)
    assert "Ball: flake_color + flake_transmission is 2, but must be at most 1" in said(
        scene, "ERROR"
    )


def test_an_older_paint_is_named_and_the_others_are_reported_on() -> None:
    scene = build()
    thing = scene.objects["Ball"]
    older = thing.active_material.copy()
    older.name = "Older"
    node = material.paint_node(older)
    node.node_tree = node.node_tree.copy()
    node.node_tree["metallic_paint"] = material.VERSION - 1
    node.node_tree.interface.clear()
    thing.data.materials.append(older)
    assert bad(scene) == "Ball, Older: The paint is of an older version: update it first."
    assert "Ball, Metallic Paint: " in said(scene, "INFO")


def test_a_linked_paint_that_keeps_its_lights_is_told_of(tmp_path: Path) -> None:
    scene = build()
    lights.node_group()["metallic_paint_looks"] = False
    link_paint(scene.objects["Ball"], tmp_path / "theirs.blend")
    text = said(scene)
    linked = rf"Ball: the paint is linked from {re.escape(str(tmp_path))}.theirs\.blend"
    assert re.search(f"{linked} and keeps the lights that it has there", text)
    assert "flakes a pixel" not in text


def test_a_file_of_such_linked_paints_alone_is_not_told_to_add_lights(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = build()
    lights.node_group()["metallic_paint_looks"] = False
    link_paint(scene.objects["Ball"], tmp_path / "theirs.blend")
    nothing = needs.Needs(lights.Report((), {}, lights.linked_files()), ())
    monkeypatch.setattr(needs, "fit", lambda _: nothing)
    assert not lights.groups()
    text = said(scene)
    assert "keeps the lights that it has there" in text
    assert "Nothing sparkles" not in text
    assert not lights.groups()


def test_a_paint_within_a_node_group_is_foretold_as_any_other() -> None:
    scene = build()
    [foretold] = [line for line in said(scene, "INFO").splitlines() if "flakes a pixel" in line]
    painted = scene.objects["Ball"].active_material
    paint = material.paint_of(painted)
    nest_paint(painted)
    material.apply(material.paint_node(painted), paint)
    assert foretold in said(scene, "INFO").splitlines()


def test_a_blender_without_osl_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = build()
    assert material.has_osl()
    monkeypatch.setattr(material, "has_osl", lambda: False)
    assert "built without Open Shading Language" in said(scene, "ERROR")


def add_balls(number: int, painted: bool) -> None:
    """More of the ball: painted ones behind it, the others outside the picture."""
    ball = bpy.data.objects["Ball"]
    mesh = ball.data
    if not painted:
        mesh = ball.data.copy()
        mesh.materials.clear()
    for i in range(number):
        other = bpy.data.objects.new(f"Other {i}", mesh)
        other.location = (0.004 * i - 0.02, 0.05, 0) if painted else (1 + i, 0, 0)
        bpy.context.scene.collection.objects.link(other)


def test_a_scene_of_ordinary_size_is_reported_on_at_once() -> None:
    scene = build()
    add_balls(10, painted=True)
    add_balls(1000, painted=False)
    begin = time.process_time()
    text = said(scene)
    assert time.process_time() - begin < 4  # 0.5 s; with each ray through the scene, 13 s
    assert text.count("Other") + text.count("Ball") >= 11
    assert "Left out" not in text
    assert re.search(r"Ball: [\d.,]+ flakes a pixel", text)


def test_of_very_many_objects_the_largest_are_looked_at_and_the_rest_is_counted() -> None:
    scene = build()
    add_balls(99, painted=True)
    text = said(scene)
    most = sight.effort_for(100, 102).objects
    assert f"Left out, being smaller in the picture: {100 - most} more painted surfaces." in text
    assert "Ball: " in text
    assert len(set(re.findall(r"^(?:Ball|Other \d+): ", text, re.MULTILINE))) == most


def test_few_rays_through_the_scene_tell_what_stands_before_an_object() -> None:
    scene = build()
    ball = scene.objects["Ball"]
    bpy.ops.mesh.primitive_plane_add(
        size=1, location=(0.505, -0.1, 0), rotation=(math.pi / 2, 0, 0)
    )
    layer = scene.view_layers[0]
    few, all_ = (
        sight.look(scene, layer, ball, ball.active_material, 1,
                          sight.Effort(1, 40, tests))
        for tests in (100, 1600)
    )  # fmt: skip
    assert all_.raster[:, 0].max() < 0.6 * SIZE
    assert few.pixels == pytest.approx(all_.pixels, rel=0.05)
    assert np.median(few.footprint) == pytest.approx(np.median(all_.footprint), rel=0.02)
    bpy.context.object.location.x = 0
    little = sight.Effort(1, 40, 8)
    with pytest.raises(ValueError, match="nothing of it, or little"):
        sight.look(scene, layer, ball, ball.active_material, 1, little)


def test_curves_are_looked_at_by_their_polygons_and_materials() -> None:
    scene = build()
    painted = scene.objects["Ball"].active_material
    bpy.data.objects.remove(scene.objects["Ball"])
    bpy.ops.surface.primitive_nurbs_surface_sphere_add(radius=0.02)
    bpy.context.object.name = "Sphere"
    bpy.context.object.data.materials.append(painted)
    seen = sight.look(scene, scene.view_layers[0], bpy.context.object, painted, 1)
    np.testing.assert_allclose(np.linalg.norm(seen.normal, axis=1), 1, atol=1e-5)
    outwards = seen.position / np.linalg.norm(seen.position, axis=1, keepdims=True)
    assert np.abs((outwards * seen.normal).sum(axis=1)).min() > 0.99
    assert seen.pixels == pytest.approx(math.pi / 4 * (SIZE / 2) ** 2, rel=0.1)
    bpy.context.object.data.materials[0] = None
    bpy.context.object.data.materials.append(painted)
    assert "Sphere: the camera does not see it" in said(scene, "INFO")


def test_hair_is_told_of() -> None:
    """Blender crashes where a ray is cast at it, or at points."""
    scene = build()
    data = bpy.data.hair_curves.new("Strands")
    data.add_curves([2])
    data.points[1].position = (0.02, 0.02, 0.02)
    data.materials.append(scene.objects["Ball"].active_material)
    bpy.data.objects.remove(scene.objects["Ball"])
    scene.collection.objects.link(bpy.data.objects.new("Strands", data))
    assert "Strands: nothing can be foretold of hair and points." in said(scene, "INFO")


def test_what_is_hidden_in_the_viewport_is_told_of() -> None:
    scene = build()
    scene.objects["Ball"].hide_viewport = True
    assert "Ball: it is hidden in the viewport, so nothing can be foretold" in said(scene, "INFO")


def test_the_panel_shows_the_report_after_the_button(registered: None) -> None:
    scene = build()
    panel = interface.MATERIAL_PT_metallic_paint_report
    assert drawn(panel).names == ["scene.metallic_paint_report"]
    assert not any(drawn(panel).texts)
    scene.cycles.sample_clamp_direct = 0.25
    assert bpy.ops.scene.metallic_paint_report() == {"FINISHED"}
    assert any("Clamp Direct" in text for text in drawn(panel).texts)


# --- what reaches the paint --------------------------------------------------------------------


def test_a_material_override_of_the_view_layer_is_named() -> None:
    scene = build()
    scene.view_layers[0].material_override = bpy.data.materials.new("Clay")
    assert "shows everything in Clay: its Material Override hides all paints." in bad(scene)


def test_a_lamp_that_gives_no_light_is_named() -> None:
    scene = build()
    scene.objects["Sun"].data.energy = 0
    assert "Sun gives no light: its Power or Strength is 0." in bad(scene)
    scene.objects["Sun"].data.energy = 3
    scene.objects["Sun"].data.color = (0, 0, 0)
    assert "Sun gives no light: its Color is black." in bad(scene)


def test_a_lamp_whose_nodes_give_no_light_is_named() -> None:
    scene = build()
    data = scene.objects["Sun"].data
    if data.node_tree is None:
        data.use_nodes = True  # Blender 4.5
    tree = data.node_tree
    tree.nodes.clear()
    dark = "Sun gives no light: its nodes give none."
    assert dark in bad(scene)
    emission, out = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputLight")
    tree.links.new(emission.outputs[0], out.inputs[0])
    assert bad(scene) == ""
    emission.inputs["Strength"].default_value = 0
    assert dark in bad(scene)


def add_roof(location: tuple[float, float, float] = (0, 0, 0.1)) -> bpy.types.Object:
    """Two metres wide, above the ball: out of the camera's sight."""
    bpy.ops.mesh.primitive_plane_add(size=2, location=location)
    bpy.context.object.name = "Roof"
    return bpy.context.object


def test_a_roof_before_the_sun_is_named() -> None:
    scene = build()
    roof = add_roof()
    shadow = "Roof keeps Sun from what the camera sees of Ball: in its shadow nothing sparkles."
    assert shadow in bad(scene)
    roof.visible_shadow = False
    assert bad(scene) == ""
    roof.visible_shadow = True
    roof.location.z = -0.1
    assert bad(scene) == ""


def put_into_collection(thing: bpy.types.Object) -> bpy.types.Collection:
    collection = bpy.data.collections.new("Set")
    bpy.context.scene.collection.children.link(collection)
    bpy.context.scene.collection.objects.unlink(thing)
    collection.objects.link(thing)
    return collection


def test_what_stands_in_a_collection_that_is_not_rendered_is_no_wall() -> None:
    scene = build()
    roof = add_roof()
    put_into_collection(roof).hide_render = True
    assert bad(scene) == ""
    roof.location, roof.rotation_euler = (0, -0.2, 0), (math.pi / 2, 0, 0)
    assert "flakes a pixel" in said(scene, "INFO")


def test_a_roof_that_the_viewport_alone_hides_is_told_of() -> None:
    scene = build()
    add_roof()
    bpy.context.object.hide_viewport = True
    hidden = "Hidden in the viewport, but rendered: Roof. What these hide or shade is not foretold."
    assert hidden in said(scene, "INFO")
    scene.objects["Roof"].hide_render = True
    assert "Hidden in the viewport" not in said(scene)


def test_a_clear_pane_before_the_camera_is_no_wall() -> None:
    scene = build()
    pane = add_roof((0, -0.2, 0))
    pane.rotation_euler.x = math.pi / 2
    assert "the camera does not see it" in said(scene, "INFO")
    pane.data.materials.append(clear_material())
    assert "flakes a pixel" in said(scene, "INFO")


def test_a_card_that_only_shines_is_a_wall() -> None:
    scene = build()
    card = new_material("Card")
    add_roof().data.materials.append(card)
    tree = card.node_tree
    tree.nodes.clear()
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(tree.nodes.new("ShaderNodeEmission").outputs[0], out.inputs["Surface"])
    assert "Roof keeps" in bad(scene)
    add = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0], add.inputs[0])
    tree.links.new(add.outputs[0], out.inputs["Surface"])
    assert bad(scene) == ""


def test_a_roof_before_a_sky_is_named_where_its_sun_has_a_slot() -> None:
    scene = build()
    bpy.data.objects.remove(scene.objects["Sun"])
    add_roof()
    scenes.sky(50, 110)(scene)
    shadow = f"Roof keeps the sun of {scene.world.name} from what the camera sees of Ball"
    assert shadow in bad(scene)
    for i in range(lights.SLOTS):
        add_lamp("POINT", f"Point {i}", location=(0, -0.2, 0.05))
    assert shadow not in bad(scene)


def new_material(name: str) -> bpy.types.Material:
    made = bpy.data.materials.new(name)
    if made.node_tree is None:
        made.use_nodes = True
    return made


def clear_material() -> bpy.types.Material:
    clear = new_material("Clear")
    clear.node_tree.nodes.new("ShaderNodeBsdfPrincipled").inputs["Alpha"].default_value = 0.5
    return clear


def test_a_roof_that_lets_light_pass_is_not() -> None:
    scene = build()
    roof = add_roof()
    roof.data.materials.append(clear_material())
    assert bad(scene) == ""


def test_a_sun_without_shadows_passes_a_roof() -> None:
    scene = build()
    add_roof()
    scene.objects["Sun"].data.use_shadow = False
    assert bad(scene) == ""


def test_a_roof_over_a_part_leaves_the_rest() -> None:
    scene = build()
    add_roof((-1.01, 0, 0.1))
    assert bad(scene) == ""


def test_a_lamp_linked_away_from_the_paint_is_named() -> None:
    scene = build()
    sun, ball = scene.objects["Sun"], scene.objects["Ball"]
    others = bpy.data.collections.new("Lit by the sun")
    others.objects.link(bpy.data.objects.new("Other", ball.data))
    sun.light_linking.receiver_collection = others
    assert "Light linking keeps Sun from Ball" in bad(scene)
    others.objects.link(ball)
    assert bad(scene) == ""
    for entry in others.collection_objects:
        entry.light_linking.link_state = "EXCLUDE"
    assert "Light linking keeps Sun from Ball" in bad(scene)
    others.objects.unlink(ball)
    assert bad(scene) == ""


def test_a_linked_namesake_is_another_object(tmp_path: Path) -> None:
    scene = build()
    namesake = link_namesake(scene.objects["Ball"], tmp_path / "theirs.blend")
    scene.collection.objects.unlink(namesake)
    inner, lit = bpy.data.collections.new("Inner"), bpy.data.collections.new("Lit by the sun")
    inner.objects.link(namesake)
    lit.children.link(inner)
    scene.objects["Sun"].light_linking.receiver_collection = lit
    assert "Light linking keeps Sun from Ball" in bad(scene)


def test_what_is_linked_away_from_a_shadow_is_no_roof() -> None:
    scene = build()
    roof = add_roof()
    blockers = bpy.data.collections.new("Blockers")
    blockers.objects.link(scene.objects["Ball"])
    scene.objects["Sun"].light_linking.blocker_collection = blockers
    assert bad(scene) == ""
    blockers.objects.link(roof)
    assert "Roof keeps Sun" in bad(scene)


def test_a_spot_that_shines_past_is_named() -> None:
    scene = build()
    bpy.data.objects.remove(scene.objects["Sun"])
    spot = add_lamp("SPOT", "Spot", energy=5, location=(0, -0.2, 0.3))
    spot.data.spot_size = math.radians(30)
    assert "Spot shines past what the camera sees of Ball: its cone ends." in bad(scene)
    spot.rotation_euler = (math.atan2(0.2, 0.3), 0, 0)
    bpy.context.view_layer.update()
    assert "Spot shines past" not in bad(scene)


@pytest.mark.long
@pytest.mark.parametrize("scale", [(6, 6, 1), (1, 1, 3), (6, 6, 6), (-1, 1, 1)])
def test_a_spots_cone_is_scaled_with_it_as_in_the_picture(scale: tuple[float, ...]) -> None:
    scene = build()
    bpy.data.objects.remove(scene.objects["Sun"])
    spot = add_lamp("SPOT", "Spot", energy=50, location=(0, -3, 1.2), scale=scale)
    spot.data.spot_size, spot.data.spot_blend = math.radians(40), 0
    aim = 10 if scale[2] == 3 else 30  # degrees off the ball
    spot.rotation_euler.x = math.atan2(3, 1.2) - math.radians(aim)
    warned = "its cone ends" in bad(scene)
    verify.make_noiseless(scene)
    assert warned == (verify.render(scene).max() == 0)
    for i in range(lights.SLOTS):
        add_lamp("POINT", f"Point {i}", energy=1e-6, location=(0, -3, 1.2))
    assert (spot in needs.fit(scene).lights.left_out) == warned
