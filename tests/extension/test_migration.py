# SPDX-License-Identifier: Apache-2.0
"""Paints of older versions of the node group: values, links and animation go by label."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest
from package import Addon


def old_group(version: int = 1) -> bpy.types.ShaderNodeTree:
    """A group as an older add-on made it: fewer sockets, in another order, one with no heir."""
    group = bpy.data.node_groups.new("Metallic Paint", "ShaderNodeTree")
    group["metallic_paint"], group["metallic_paint_source"] = version, "older"
    script = group.nodes.new("ShaderNodeScript")
    script.script = bpy.data.texts.new("metallic_paint.osl")
    slots = bpy.data.node_groups.new("Metallic Paint Lights", "ShaderNodeTree")
    slots["metallic_paint_lights"] = 1
    group.nodes.new("ShaderNodeGroup").node_tree = slots
    for name, kind in (
        ("Glitter", "Float"), ("Seed", "Int"), ("Flake Color", "Color"), ("Tilt", "Float"),
        ("IOR", "Color"), ("Normal", "Vector"),
    ):  # fmt: skip
        group.interface.new_socket(name, in_out="INPUT", socket_type=f"NodeSocket{kind}")
    group.interface.new_socket("BSDF", in_out="OUTPUT", socket_type="NodeSocketShader")
    return group


@pytest.fixture
def old() -> bpy.types.Material:
    """An object in a paint of the old group, with values, links, keys and a driver."""
    bpy.ops.mesh.primitive_cube_add()
    surface = bpy.data.materials.new("Old")
    if surface.node_tree is None:
        surface.use_nodes = True  # Blender 4.5
    tree = surface.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeGroup")
    node.name, node.node_tree = "Paint", old_group()
    for label, value in (
        ("Seed", 7), ("Flake Color", (0.1, 0.2, 0.3, 1)), ("Tilt", 0.25), ("IOR", (1, 0, 0, 1)),
    ):  # fmt: skip
        node.inputs[label].default_value = value
    out, bump = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeBump")
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(node.outputs["BSDF"], out.inputs["Surface"])
    tree.links.new(bump.outputs["Normal"], node.inputs["Normal"])
    tree.links.new(noise.outputs[0], node.inputs["Glitter"])
    bpy.context.object.active_material = surface
    return surface


def update() -> None:
    assert bpy.ops.material.metallic_paint_update() == {"FINISHED"}


def test_values_are_copied_by_label(addon: Addon, old: bpy.types.Material) -> None:
    assert addon("paint.migration").has_outdated()
    update()
    assert not addon("paint.migration").has_outdated()
    expected = addon("paint").Paint(tilt=0.25, flake_color=(0.1, 0.2, 0.3), seed=7)
    assert addon("paint.material").paint_of(old) == expected  # IOR, once a colour, has its default


def test_links_are_kept(
    addon: Addon, old: bpy.types.Material, capfd: pytest.CaptureFixture[str]
) -> None:
    update()
    node = addon("paint.material").paint_node(old)
    assert node.inputs["Normal"].links[0].from_node.type == "BUMP"
    assert node.outputs["BSDF"].links[0].to_node.type == "OUTPUT_MATERIAL"
    assert sum(socket.is_linked for socket in node.inputs) == 1
    assert "Today's paint has no Glitter" in capfd.readouterr().out


def test_keys_and_drivers_are_kept(
    addon: Addon, old: bpy.types.Material, capfd: pytest.CaptureFixture[str]
) -> None:
    node = old.node_tree.nodes["Paint"]
    for frame, tilt in ((1, 0.1), (11, 0.3)):
        node.inputs["Tilt"].default_value = tilt
        node.inputs["Tilt"].keyframe_insert("default_value", frame=frame)
    node.inputs["Glitter"].keyframe_insert("default_value", frame=1)
    node.inputs["Seed"].driver_add("default_value").driver.expression = "40 + 2"
    update()
    node = addon("paint.material").paint_node(old)
    for frame, tilt in ((1, 0.1), (11, 0.3)):
        bpy.context.scene.frame_set(frame)
        evaluated = old.evaluated_get(bpy.context.evaluated_depsgraph_get())
        inputs = evaluated.node_tree.nodes["Paint"].inputs
        assert inputs["Tilt"].default_value == pytest.approx(tilt)
        assert inputs["Seed"].default_value == 42
        assert inputs["Flakes per mm²"].default_value == 3000


def test_keys_in_the_nonlinear_editor_are_kept(addon: Addon, old: bpy.types.Material) -> None:
    node = old.node_tree.nodes["Paint"]
    for frame, tilt in ((1, 0.1), (11, 0.3)):
        node.inputs["Tilt"].default_value = tilt
        node.inputs["Tilt"].keyframe_insert("default_value", frame=frame)
    animation = old.node_tree.animation_data
    action, slot = animation.action, animation.action_slot
    for number in (1, 2):  # the same action twice, as one repeats it
        strip = animation.nla_tracks.new().strips.new("Tilt", 20 * number - 19, action)
        strip.action_slot, strip.extrapolation = slot, "NOTHING"
    animation.action = None
    update()
    for frame, tilt in ((1, 0.1), (11, 0.3), (31, 0.3)):
        bpy.context.scene.frame_set(frame)
        evaluated = old.evaluated_get(bpy.context.evaluated_depsgraph_get())
        inputs = evaluated.node_tree.nodes["Paint"].inputs
        assert inputs["Tilt"].default_value == pytest.approx(tilt)
        assert inputs["Flakes per mm²"].default_value == 3000


def test_old_groups_and_text_are_gone(old: bpy.types.Material) -> None:
    update()
    assert sorted(bpy.data.node_groups.keys()) == [
        ".Metallic Paint Lights", "Metallic Paint", "Metallic Paint Lights",
    ]  # fmt: skip
    assert len(bpy.data.texts) == 1


def test_paints_inside_groups_are_updated(addon: Addon, old: bpy.types.Material) -> None:
    wrapper = bpy.data.node_groups.new("Wrapper", "ShaderNodeTree")
    inner = wrapper.nodes.new("ShaderNodeGroup")
    inner.node_tree = old.node_tree.nodes["Paint"].node_tree
    inner.inputs["Seed"].default_value = 5
    outer = old.node_tree.nodes.new("ShaderNodeGroup")
    outer.node_tree = wrapper
    update()
    [inner] = wrapper.nodes
    assert inner.node_tree == addon("paint.material").node_group()
    assert inner.inputs["Seed"].default_value == 5


def test_group_that_only_a_fake_user_holds_is_no_reason_to_update(
    addon: Addon, old: bpy.types.Material
) -> None:
    old.node_tree.nodes["Paint"].node_tree.use_fake_user = True
    update()
    assert not addon("paint.migration").has_outdated()


def test_paint_of_a_future_version_stays(addon: Addon, old: bpy.types.Material) -> None:
    group = old.node_tree.nodes["Paint"].node_tree
    group["metallic_paint"] = addon("paint.material").VERSION + 1
    assert not addon("paint.migration").has_outdated()


def test_same_version_with_another_shader_is_updated(addon: Addon) -> None:
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.material.metallic_paint_new(preset="gold")
    painted = bpy.context.object.active_material
    addon("paint.material").paint_node(painted).node_tree["metallic_paint_source"] = "older"
    update()
    assert addon("paint.material").paint_of(painted) == addon("paint.presets").load("gold")


def test_a_paint_that_has_lost_its_light_slots_gets_new_ones(addon: Addon) -> None:
    bpy.ops.mesh.primitive_cube_add()
    assert bpy.ops.material.metallic_paint_new(preset="gold") == {"FINISHED"}
    material = addon("paint.material")
    paint = material.paint_of(bpy.context.object.active_material)
    bpy.data.node_groups.remove(addon("scene.lights").node_group())
    assert addon("paint.migration").has_outdated()
    update()
    assert not addon("paint.migration").has_outdated()
    assert material.paint_of(bpy.context.object.active_material) == paint
    assert addon("scene.lights").is_painted(bpy.context.object)


def test_linked_paints_stay_and_are_told_of(
    addon: Addon, old: bpy.types.Material, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = str(tmp_path / "old.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file, copy=True)
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(file, link=True) as (_, into):
        into.materials = ["Old"]
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.active_material = bpy.data.materials["Old"]
    assert not addon("paint.migration").has_outdated()
    ours = bpy.data.materials.new("Ours")
    if ours.node_tree is None:
        ours.use_nodes = True  # Blender 4.5
    ours.node_tree.nodes.new("ShaderNodeGroup").node_tree = old_group()
    update()
    assert "Linked paints stay as they are: 1" in capfd.readouterr().out
    assert bpy.data.materials["Old"].node_tree.nodes["Paint"].inputs["Seed"].default_value == 7
