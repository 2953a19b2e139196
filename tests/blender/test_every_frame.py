# SPDX-License-Identifier: Apache-2.0
"""Paints that are new in every frame: which objects have the scene's frame, and when."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from metallic_paint.paint import Paint, material
from metallic_paint.paint.parameters import INT_MAX, INT_MIN
from metallic_paint.scene import carrier, needs
from scenery import link_paint, nest_paint


@pytest.fixture
def painted() -> bpy.types.Object:
    """A cube that is new in every frame, not yet fitted."""
    material.set_up_cycles(bpy.context.scene)
    return paint_cube("Painted")


def paint_cube(name: str) -> bpy.types.Object:
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.name = name
    material.assign(bpy.context.object, material.create(Paint(), name))
    switch_of(bpy.context.object).default_value = True
    return bpy.context.object


def switch_of(thing: bpy.types.Object) -> bpy.types.NodeSocketBool:
    return material.paint_node(thing.active_material).inputs[material.NEW_IN_EVERY_FRAME]


def fit() -> None:
    needs.fit(bpy.context.scene)


def is_fitted() -> bool:
    return needs.is_fitted(bpy.context.scene)


def has_driver() -> bool:
    animation = carrier.only().animation_data
    return animation is not None and len(animation.drivers) > 0


def frames_seen_by(thing: bpy.types.Object) -> list[float]:
    """What the paint on the object finds at two frames."""
    seen = []
    for frame in (3, 8):
        bpy.context.scene.frame_set(frame)
        shown = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
        seen.append(shown.path_resolve(carrier.FRAME_PATH))
    return seen


def test_who_does_not_ask_for_the_frame_does_not_pay(painted: bpy.types.Object) -> None:
    """A driver that follows it would have Blender evaluate all painted objects in every frame."""
    switch_of(painted).default_value = False
    fit()
    assert not has_driver()
    switch_of(painted).default_value = True
    assert not is_fitted()
    fit()
    assert is_fitted()
    assert has_driver()
    fit()
    assert len(carrier.only().animation_data.drivers) == 1
    switch_of(painted).default_value = False
    assert not is_fitted()
    fit()
    assert not has_driver()
    assert "Frame" not in carrier.only()


@pytest.mark.parametrize("by", ["a link", "a key", "a group"])
def test_who_may_ask_for_the_frame_has_it(painted: bpy.types.Object, by: str) -> None:
    switch = switch_of(painted)
    tree = painted.active_material.node_tree
    if by == "a group":
        nest_paint(painted.active_material)
        [group] = [each for each in bpy.data.node_groups if each.name == "Mine"]
        [node] = filter(material.is_paint, group.nodes)
        switch = node.inputs[material.NEW_IN_EVERY_FRAME]
        switch.default_value = True
    else:
        switch.default_value = False
        if by == "a link":
            tree.links.new(tree.nodes.new("ShaderNodeValue").outputs[0], switch)
        else:
            switch.keyframe_insert("default_value", frame=1)
    fit()
    assert frames_seen_by(painted) == [3, 8]


def test_it_needs_no_python(painted: bpy.types.Object) -> None:
    fit()
    [curve] = carrier.only().animation_data.drivers
    assert curve.driver.is_simple_expression
    assert curve.driver.is_valid


def test_lamps_that_come_and_go_leave_it_alone(painted: bpy.types.Object) -> None:
    fit()
    bpy.ops.object.light_add(type="SUN")
    sun = bpy.context.object
    fit()
    assert frames_seen_by(painted) == [3, 8]
    bpy.data.objects.remove(sun)
    fit()
    assert is_fitted()
    assert frames_seen_by(painted) == [3, 8]


def test_after_undo_it_is_followed_again(painted: bpy.types.Object) -> None:
    fit()
    needs.let_go()
    assert not is_fitted()
    fit()
    assert is_fitted()
    assert frames_seen_by(painted) == [3, 8]


def test_copies_have_it(painted: bpy.types.Object) -> None:
    fit()
    copy = painted.copy()
    bpy.context.scene.collection.objects.link(copy)
    assert frames_seen_by(copy) == [3, 8]


@pytest.mark.parametrize("link", [True, False])
def test_what_comes_from_another_file_has_it(
    painted: bpy.types.Object, link: bool, tmp_path: Path
) -> None:
    fit()
    file = str(tmp_path / "theirs.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(file, link=link) as (_, here):
        here.objects = ["Painted"]
    [theirs] = here.objects
    bpy.context.scene.collection.objects.link(theirs)
    fit()
    assert frames_seen_by(theirs) == [3, 8]


def test_a_linked_paint_on_an_object_of_this_file_has_it(
    painted: bpy.types.Object, tmp_path: Path
) -> None:
    link_paint(painted, tmp_path / "theirs.blend")
    other = paint_cube("Ours")
    switch_of(other).default_value = False
    fit()
    assert frames_seen_by(painted) == [3, 8]


@pytest.mark.parametrize(
    ("own", "current", "sum_"), [(7, 3, 10), (INT_MAX, 1, INT_MIN), (INT_MIN, -1, INT_MAX)]
)
def test_the_core_is_told_the_sum_that_the_shader_has(
    painted: bpy.types.Object, own: int, current: int, sum_: int
) -> None:
    node = material.paint_node(painted.active_material)
    node.inputs["Frame"].default_value = own
    bpy.context.scene.frame_set(current)
    assert material.frame_of(node, bpy.context.scene) == sum_
    switch_of(painted).default_value = False
    assert material.frame_of(node, bpy.context.scene) == own
    assert np.int32(sum_) == sum_
