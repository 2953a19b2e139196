# SPDX-License-Identifier: Apache-2.0
"""Lights that collection instances, geometry nodes, particles, vertices and faces show."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from gate import first_of
from mathutils import Euler
from metallic_paint import denoise, verify
from metallic_paint.paint import Paint, material
from metallic_paint.scene import carrier, lights, needs, placed
from metallic_paint.scene.report import report
from metallic_paint.verify.job import run
from scenery import add_lamp, show_as_instance


def stage(**values: object) -> bpy.types.Scene:
    """A painted quad under an orthographic camera, half a metre wide."""
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=2)
    material.set_up_cycles(scene)
    material.assign(bpy.context.object, material.create(Paint(tilt=0.2, **values), "Painted"))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale, camera.location.z = "ORTHO", 0.5, 5
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = 64
    verify.make_noiseless(scene)
    return scene


def update() -> None:
    bpy.context.view_layer.update()


KINDS = {
    "SUN": {"energy": 2.0, "angle": 0.01},
    "POINT": {"energy": 20.0, "shadow_soft_size": 0.01},
    "SPOT": {"energy": 20.0, "shadow_soft_size": 0.01},
    "AREA": {"energy": 20.0, "size": 0.04, "shape": "DISK"},
}
PLACE = {"location": (0.2, -0.1, 1.3), "rotation_euler": (0.2, 0.1, 0.4)}


def lamp_of(kind: str, name: str = "Lamp", **values: object) -> bpy.types.Object:
    lamp = add_lamp(kind, name, **(KINDS[kind] | PLACE | values))
    lamp.data.cycles.use_multiple_importance_sampling = False
    return lamp


def unlike(one: np.ndarray, other: np.ndarray) -> float:
    """The share of pixels that differ by more than rounding."""
    return float((np.abs(one - other) > 1e-4 * (one + other) + 1e-6).any(axis=-1).mean())


def picture() -> np.ndarray:
    return verify.render(bpy.context.scene)


def placed_directly(found: list[placed.Placed]) -> np.ndarray:
    """The picture with the lamps themselves where the instances were; these are gone."""
    matrices = [(each.lamp.data, each.matrix.copy()) for each in found]
    for each in found:
        if each.instancer is not None:
            each.instancer.hide_render = True
            if each.instancer.type == "MESH":
                each.instancer.modifiers.clear()
                each.instancer.instance_type = "NONE"
    for each in {each.lamp for each in found}:
        each.hide_render = True
    for i, (data, matrix) in enumerate(matrices):
        lamp = bpy.data.objects.new(f"Real {i}", data)
        lamp.matrix_world = matrix
        bpy.context.scene.collection.objects.link(lamp)
    found_now = needs.fit(bpy.context.scene).lights
    assert len(found_now.placed) == len(found)
    assert not any(each.instancer for each in found_now.placed)
    return picture()


def turn(empty: bpy.types.Object) -> None:
    empty.location, empty.rotation_euler = (0.1, 0.2, 0.3), Euler((0.3, -0.2, 0.5))
    empty.scale = (1.2, 1.2, 1.2)
    empty.instance_collection.instance_offset = (0.05, -0.1, 0.02)


@pytest.mark.parametrize("kind", first_of(KINDS))
def test_a_collection_instance_sparkles_as_the_lamp_itself_would(kind: str) -> None:
    """In every pixel, also after it moved, which drivers alone follow."""
    scene = stage()
    lamp = lamp_of(kind)
    empty = show_as_instance(lamp)
    [found] = needs.fit(scene).lights.placed
    assert found.followed
    assert (found.lamp, found.instancer) == (lamp, empty)
    assert all(curve.driver.is_simple_expression for curve in carrier.only().animation_data.drivers)
    turn(empty)
    lamp.location.x += 0.1
    update()
    assert needs.is_fitted(scene)
    shown = picture()
    [moved] = placed.instances_in([bpy.context.view_layer])
    assert (moved.matrix.translation - found.matrix.translation).length > 0.1
    np.testing.assert_allclose(
        carrier.values()[0][1], carrier.numbers_of(moved)[:3], atol=2e-6, rtol=2e-6
    )
    real = placed_directly([moved])
    assert (shown > 0).any(axis=-1).mean() > 0.1
    assert unlike(shown, real) < 2e-3  # a count on the edge of float rounding
    assert shown.mean() == pytest.approx(real.mean(), rel=1e-3)


def triangle(name: str) -> bpy.types.Object:
    """Unpainted and out of the camera's sight: what it multiplies stands on its three corners."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(0.9, 0, 0), (-0.3, 0.8, 0.1), (0, -0.9, 0.4)], [], [(0, 1, 2)])
    thing = bpy.data.objects.new(name, mesh)
    thing.location = (0, 0, 1)
    thing.visible_shadow = thing.visible_camera = False
    bpy.context.scene.collection.objects.link(thing)
    return thing


def by_nodes(lamp: bpy.types.Object) -> bpy.types.Object:
    """The lamp on each point of a mesh, at an angle, by geometry nodes."""
    thing = triangle("Nodes")
    tree = bpy.data.node_groups.new("Swarm", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    inside, out = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    info = tree.nodes.new("GeometryNodeObjectInfo")
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = lamp, True
    on_points = tree.nodes.new("GeometryNodeInstanceOnPoints")
    on_points.inputs["Rotation"].default_value = (0.2, 0.1, 0)
    tree.links.new(inside.outputs[0], on_points.inputs["Points"])
    tree.links.new(info.outputs["Geometry"], on_points.inputs["Instance"])
    tree.links.new(on_points.outputs[0], out.inputs[0])
    thing.modifiers.new("Swarm", "NODES").node_group = tree
    put_away(lamp)
    return thing


def by_particles(lamp: bpy.types.Object) -> bpy.types.Object:
    thing = triangle("Emitter")
    thing.modifiers.new("Particles", "PARTICLE_SYSTEM")
    settings = thing.particle_systems[0].settings
    settings.count, settings.frame_start, settings.frame_end = 3, 1, 1
    settings.render_type, settings.instance_object = "OBJECT", lamp
    settings.particle_size, settings.effector_weights.gravity = 1, 0.1
    put_away(lamp)
    bpy.context.scene.frame_set(2)
    return thing


def by_vertices(lamp: bpy.types.Object) -> bpy.types.Object:
    thing = triangle("Vertices")
    lamp.parent, thing.instance_type = thing, "VERTS"
    return thing


def by_faces(lamp: bpy.types.Object) -> bpy.types.Object:
    thing = triangle("Faces")
    lamp.parent, thing.instance_type = thing, "FACES"
    return thing


def within_another(lamp: bpy.types.Object) -> bpy.types.Object:
    inner = show_as_instance(lamp)
    inner.location.x = 0.1
    return show_as_instance(inner)


def put_away(lamp: bpy.types.Object) -> None:
    """Into a collection that no scene shows."""
    bpy.data.collections.new("Store").objects.link(lamp)
    bpy.context.scene.collection.objects.unlink(lamp)


Way = Callable[[bpy.types.Object], bpy.types.Object]
WAYS = (
    (by_nodes, "AREA"), (by_particles, "POINT"), (by_vertices, "POINT"), (by_faces, "AREA"),
    (within_another, "POINT"),
)  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize(("way", "kind"), WAYS)
def test_instances_that_no_driver_follows_sparkle_where_they_are(way: Way, kind: str) -> None:
    """In every pixel as lamps there would, once they are looked at again."""
    scene = stage()
    thing = way(lamp_of(kind, location=(0.1, 0.1, 0.2)))
    found = needs.fit(scene)
    assert all(each.instancer == thing and not each.followed for each in found.lights.placed)
    assert str(found).count("a render without the add-on") == len(found.lights.placed)
    told = [text for _, text in report(scene) if "No driver follows" in text]
    assert told == [f"No driver follows {found.lights.placed[0].name}: a render without the add-on "
                    "has its sparkles as now."]  # fmt: skip
    before = carrier.values()
    thing.location.x += 0.2
    scene.frame_set(scene.frame_current + 1)
    assert needs.is_fitted(scene)
    assert carrier.values() == before
    late = picture()
    lights.renew(bpy.context.view_layer.depsgraph)
    update()
    assert needs.is_fitted(scene)
    shown = picture()
    real = placed_directly(placed.lights([bpy.context.view_layer]))
    assert shown.max() > 0
    assert unlike(shown, real) < 2e-3  # a count on the edge of float rounding
    assert unlike(late, real) > 0.1  # or nothing was to be renewed


def test_what_moves_in_a_swarm_needs_no_new_drivers_and_what_comes_does() -> None:
    scene = stage()
    thing = by_nodes(lamp_of("POINT", location=(0, 0, 0)))
    needs.fit(scene)
    assert len(carrier.not_followed()) == 3
    thing.data.vertices[0].co.z += 0.1
    update()
    assert needs.is_fitted(scene)
    thing.data.vertices.add(1)
    thing.data.update()
    update()
    assert not needs.is_fitted(scene)
    assert len(needs.fit(scene).lights.placed) == 4
    bpy.data.objects.remove(
        thing.modifiers[0].node_group.nodes["Object Info"].inputs[0].default_value
    )
    assert carrier.has_lost_lamp()
    assert needs.fit(scene).lights.placed == ()
    assert carrier.values() == []


def test_of_many_the_brightest_have_the_slots_and_the_rest_is_told_in_a_line() -> None:
    scene = stage()
    lamp = lamp_of("POINT", location=(0, 0, 0))
    thing = by_nodes(lamp)
    thing.data.vertices.add(17)
    for i, vertex in enumerate(thing.data.vertices):
        vertex.co = (0.1 * i, 0, 0)
    thing.data.update()
    own = lamp_of("POINT", "Own", energy=1e4)
    found = needs.fit(scene)
    assert len(found.lights.placed) == lights.SLOTS
    assert own in found.lights.slots
    numbers = [each.number[-1] for each in found.lights.placed if each.instancer]
    assert len(numbers) == 7
    nearest = {vertex.index for vertex in thing.data.vertices if vertex.co.x < 0.1 * 10}
    assert {*numbers} < nearest  # within the box of the quad all are as near: 1 m
    text = str(found)
    assert "no sparkles from 13 times Lamp in Nodes: 8 brighter lights have the slots" in text
    assert "21 lights: 8 sparkle, 13 light the mean." in text
    assert "lights without a slot" in found.other_light


def test_a_light_that_is_not_rendered_has_none() -> None:
    scene = stage()
    lamp = lamp_of("POINT")
    empty = show_as_instance(lamp)
    empty.hide_render = True
    assert needs.fit(scene).lights.placed == ()
    empty.hide_render, lamp.hide_render = False, True
    assert needs.fit(scene).lights.placed == ()
    lamp.hide_render = False
    lamp.data.type = "AREA"
    lamp.data.spread = 1
    assert "Spread" in needs.fit(scene).lights.left_out[lamp]


@pytest.mark.parametrize("way", ["instancer", "subcollection", "nested"])
def test_a_light_of_a_collection_that_is_not_rendered_has_none(way: str) -> None:
    """Neither where the collection holds the instancer, nor where it holds the lamp."""
    scene = stage()
    empty = show_as_instance(lamp_of("POINT"))
    dark = bpy.data.collections.new("Dark")
    if way == "subcollection":
        inner = empty.instance_collection
        inner.children.link(dark)
        dark.objects.link(bpy.data.objects["Lamp"])
        inner.objects.unlink(bpy.data.objects["Lamp"])
    else:
        if way == "nested":
            show_as_instance(empty).instance_collection.children.link(dark)
        else:
            scene.collection.children.link(dark)
        empty.users_collection[0].objects.unlink(empty)
        dark.objects.link(empty)
    assert len(needs.fit(scene).lights.placed) == 1
    dark.hide_render = True
    assert not needs.is_fitted(scene)
    assert needs.fit(scene).lights.placed == ()


@pytest.mark.parametrize("way", ["eye", "viewport", "nested"])
def test_an_instance_that_the_viewport_hides_sparkles_in_a_render(way: str) -> None:
    scene = stage()
    empty = show_as_instance(lamp_of("POINT"))
    outer = show_as_instance(empty) if way == "nested" else empty
    update()
    turn(outer)
    shown = needs.fit(scene).lights.placed
    numbers = carrier.values()
    if way == "eye":
        outer.hide_set(True)
    else:
        empty.hide_viewport = True
    update()
    assert needs.fit(scene).lights.placed == shown
    for (_, place, *_), (_, was, *_) in zip(carrier.values(), numbers, strict=True):
        assert (place - was).length < 1e-6
    outer.location.x += 0.1
    update()
    lights.renew(bpy.context.view_layer.depsgraph)
    assert carrier.values()[0][1].x == pytest.approx(numbers[0][1].x + 0.1, abs=1e-6)


def test_two_instances_and_the_lamp_itself_have_a_slot_each() -> None:
    scene = stage()
    lamp = lamp_of("SUN")
    one = show_as_instance(lamp)
    two = bpy.data.objects.new("Two", None)
    two.instance_type, two.instance_collection = "COLLECTION", one.instance_collection
    scene.collection.objects.link(two)
    scene.collection.objects.link(lamp)
    found = needs.fit(scene).lights.placed
    assert [each.name for each in found] == ["Lamp", "Lamp in Instancer", "Lamp in Two"]
    assert lights.in_slots() == [lamp]
    two.rotation_euler.x = 0.5
    update()
    directions = [values[1] for values in carrier.values()]
    assert (directions[0] - directions[1]).length < 1e-6
    turned = Euler((0.5, 0, 0)).to_matrix() @ directions[1]
    assert (directions[2] - turned).length < 1e-6


@pytest.mark.long
def test_verify_lights_instances_one_by_one() -> None:
    scene = stage()
    by_nodes(lamp_of("POINT", location=(0, 0, 0.2)))
    show_as_instance(lamp_of("SUN", "Sun"))
    needs.fit(scene)
    found = run(scene, scene.objects["Plane"], 24)
    assert found.agrees, str(found)
    assert found.pixels >= 4 * 24 * 24
    assert found.same_count == found.pixels


def test_denoising_takes_the_light_of_instances_for_sparkles() -> None:
    scene = stage()
    lamp = lamp_of("SUN")
    show_as_instance(lamp)
    denoise.set_up(scene)
    assert lamp.lightgroup == denoise.LIGHT_GROUP
    assert denoise.outdated(scene) == ""
    denoise.remove(scene)
    assert lamp.lightgroup == ""
    assert not any("metallic" in key for key, _ in lamp.items())
