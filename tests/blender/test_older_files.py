# SPDX-License-Identifier: Apache-2.0
"""A file of 0.1.0, whose paint knew the pixel anchor alone: version 4 of the node group.

The add-on of that day wrote of-0.1.0.blend, with its compiled shader: a ball in silver-coarse under
a sun.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import bpy
import numpy as np
import pytest
from metallic_paint import verify
from metallic_paint.paint import Paint, animation, material, migration, presets
from metallic_paint.scene import needs
from scenery import override_paint

FILE = Path(__file__).with_name("of-0.1.0.blend")


@pytest.fixture
def scene() -> bpy.types.Scene:
    with bpy.data.libraries.load(str(FILE)) as (there, here):
        here.scenes = there.scenes
    [scene] = here.scenes
    bpy.context.window.scene = scene
    verify.make_noiseless(scene)
    return scene


def node_in(scene: bpy.types.Scene) -> bpy.types.ShaderNodeGroup:
    return material.paint_node(scene.objects["Sphere"].active_material)


def test_update_lets_its_sparkles_ride_and_says_so(scene: bpy.types.Scene) -> None:
    assert migration.has_outdated()
    assert not material.rides(node_in(scene))
    assert str(migration.update()).splitlines() == [
        "Paints updated: 1.",
        "Sparkles now ride on the surface: set Anchor to pixel to have them on the pixels.",
    ]
    assert material.rides(node_in(scene))
    paint = dataclasses.replace(presets.load("silver-coarse"), depth_model="attenuated")
    assert material.paint_of(node_in(scene)) == paint


def test_with_the_anchor_set_back_the_updated_picture_differs_in_where_flakes_lie(
    scene: bpy.types.Scene,
) -> None:
    before = verify.render(scene)
    migration.update()
    needs.fit(scene)  # as the operator does
    node_in(scene).inputs["Anchor"].default_value = 0
    after = verify.render(scene)
    # What is scattered several times has lobes of another shape now: 0.065 was the most seen.
    same = np.isclose(after, before, rtol=1e-3, atol=0.1).all(axis=-1)
    assert same.mean() > 0.9  # all but where the one or the other has a sparkle: 94 %
    few, many = sorted(int(((each.max(axis=-1) > 1) & ~same).sum()) for each in (before, after))
    assert few > 10
    assert many - few < 4 * np.sqrt(few + many)  # of two Poisson counts: 20 and 24


def test_a_later_update_leaves_the_anchor_as_it_is_and_says_nothing_of_it(
    scene: bpy.types.Scene,
) -> None:
    migration.update()
    node_in(scene).inputs["Anchor"].default_value = 0
    node_in(scene).node_tree["metallic_paint_source"] = "older"
    assert str(migration.update()) == "Paints updated: 1."
    assert not material.rides(node_in(scene))


def outdate(node: bpy.types.ShaderNodeGroup) -> None:
    """Of an older version, whose first socket was another: numbers of sockets mean others today."""
    node.node_tree = group = node.node_tree.copy()
    group["metallic_paint"], group["metallic_paint_source"] = material.VERSION - 1, "older"
    first = group.interface.new_socket("Glitter", in_out="INPUT", socket_type="NodeSocketFloat")
    group.interface.move(first, 0)


def test_animation_that_paints_share_stays_on_its_sockets() -> None:
    """As that of a copied material, and of two paints in one material."""
    painted = material.create(Paint())
    tree = painted.node_tree
    nodes = [material.paint_node(painted), material.add_node(tree, Paint())]
    for node in nodes:
        outdate(node)
    for node, label in zip(nodes, ("Tilt", "Orange Peel"), strict=True):
        node.inputs[label].keyframe_insert("default_value", frame=1)
        node.inputs["Seed"].driver_add("default_value").driver.expression = "42"
    nodes[0].inputs["Glitter"].keyframe_insert("default_value", frame=1)
    copy = painted.copy()
    assert copy.node_tree.animation_data.action_slot == tree.animation_data.action_slot
    report = migration.update()
    assert (report.updated, report.lost) == (4, {"Glitter"})
    for of in (tree, copy.node_tree):
        for name, label in zip([node.name for node in nodes], ("Tilt", "Orange Peel"), strict=True):
            driven = animation.of_inputs(of, of.nodes[name])
            assert sorted(socket.name for _, socket, _ in driven) == sorted(["Seed", label])
        assert sum(len(curves) for curves in animation.curves(of)) == 4


def test_a_muted_link_stays_muted(scene: bpy.types.Scene) -> None:
    node = node_in(scene)
    tree = node.id_data
    noise = tree.nodes.new("ShaderNodeTexNoise")
    for label, muted in (("Tilt", True), ("Flake Spread", False)):
        tree.links.new(noise.outputs[0], node.inputs[label]).is_muted = muted
    node.outputs["BSDF"].links[0].is_muted = True
    migration.update()
    node = node_in(scene)
    muted = {each.name: each.links[0].is_muted for each in node.inputs if each.is_linked}
    assert muted == {"Tilt": True, "Flake Spread": False}
    assert node.outputs["BSDF"].links[0].is_muted


def test_an_overridden_paint_stays(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """Opened again, it had the values of the old sockets on today's of the same numbers."""
    painted = override_paint(scene.objects["Sphere"], tmp_path / "theirs.blend")
    group = material.paint_node(painted).node_tree
    report = migration.update()
    assert (report.updated, report.linked) == (0, 2)  # with what it overrides
    assert "Linked paints stay as they are: 2. Update the files" in str(report)
    assert material.paint_node(painted).node_tree == group
