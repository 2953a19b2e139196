# SPDX-License-Identifier: Apache-2.0
"""The light slots: which lights have one, what stands in it, and that it follows the scene."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO
import pytest
import seeds
from mathutils import Euler, Matrix, Vector
from metallic_paint.paint import Paint, material, shader
from metallic_paint.scene import carrier, lights, needs
from scenery import add_lamp, show_as_instance

Place = Callable[..., bpy.types.Object]
EPSILON = 2e-6  # of a direction in single precision


@pytest.fixture
def place() -> Place:
    """Puts a light into the scene: place("SUN", "Name", rotation_euler=…, energy=…)."""
    return add_lamp


@pytest.fixture
def painted() -> bpy.types.Object:
    """A painted quad of 2 m around the origin."""
    return paint_quad("Painted")


def paint_quad(name: str) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [range(4)])
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    material.assign(thing, material.create(Paint()))
    return thing


def camera_above(pixels: int = 16) -> None:
    """A Cycles scene, seen orthographically from above, one metre wide."""
    scene = bpy.context.scene
    material.set_up_cycles(scene)
    scene.cycles.samples = 1
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.render.resolution_x = scene.render.resolution_y = pixels
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = 1
    camera.location.z = 5
    scene.collection.objects.link(camera)
    scene.camera = camera


def render(file: Path) -> np.ndarray:
    bpy.context.scene.render.filepath = str(file)
    bpy.ops.render.render(write_still=True)
    return read(file)


def read(file: Path) -> np.ndarray:
    return OpenImageIO.ImageBuf(str(file)).get_pixels()[:, :, :3]


def slot(number: int) -> tuple[float, tuple[float, ...], float]:
    """Kind, vector and size as the render sees them."""
    kind = round(lights.constant(lights.slot_names(number)[0]))
    if not kind:
        return 0, (0, 0, 0), 0
    x, y, z, size = seen_at(bpy.data.objects["Painted"], carrier.path(number, kind))
    return kind, (x, y, z), size


def seen_at(thing: bpy.types.Object, path: str) -> tuple[float, ...]:
    """What an Attribute node finds there."""
    shown = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return tuple(np.array(shown.path_resolve(path), np.float32).tolist())


def drivers() -> list[bpy.types.Driver]:
    animation = carrier.only().animation_data
    return [curve.driver for curve in animation.drivers] if animation else []


def fill() -> lights.Report:
    return lights.fill(bpy.context.scene)


def named(*names: str) -> tuple[bpy.types.Object, ...]:
    return tuple(bpy.data.objects[name] for name in names)


def names(lamps: Iterable[bpy.types.Object]) -> list[str]:
    return [lamp.name for lamp in lamps]


# --- what stands in a slot --------------------------------------------------------------------


def test_a_sun_is_the_direction_towards_it_and_the_sine_of_its_radius(
    place: Place, painted: bpy.types.Object
) -> None:
    turn = Euler((0.4, -0.3, 1.2))
    place("SUN", "Sun", rotation_euler=turn, location=(7, 8, 9), angle=0.5, scale=(3, 3, 3))
    assert fill().slots == named("Sun")
    kind, vector, size = slot(1)
    assert kind == carrier.PARALLEL
    assert vector == pytest.approx((turn.to_matrix() @ Vector((0, 0, 1)))[:], abs=EPSILON)
    assert size == pytest.approx(math.sin(0.25))


@pytest.mark.parametrize("kind", ["POINT", "SPOT"])
def test_a_point_or_spot_light_is_its_position_and_the_radius_of_its_data(
    kind: str, place: Place, painted: bpy.types.Object
) -> None:
    place(kind, "Lamp", location=(1, 2, 3), scale=(4, 4, 4), shadow_soft_size=0.3)
    fill()
    number, vector, size = slot(1)
    assert (number, size) == (carrier.POSITIONAL, pytest.approx(0.3))
    assert vector == pytest.approx((1, 2, 3))


@pytest.mark.long
def test_cycles_does_not_scale_the_radius_of_a_lamp(place: Place, tmp_path: Path) -> None:
    """Why the slot has the radius of the data, whatever the object's scale."""
    camera_above(64)
    bpy.context.scene.cycles.samples = 4
    lamp = place("POINT", "Lamp", shadow_soft_size=0.2, energy=10, visible_camera=True)
    pixels = []
    for scale in ((1, 1, 1), (2, 2, 2), (2, 1, 0.5)):
        lamp.scale = scale
        pixels.append((render(tmp_path / "lamp.exr")[:, :, 0] > 0).sum())
    assert pixels[0] == pytest.approx(math.pi * 0.2**2 * 64**2, rel=0.2)
    assert pixels == pixels[:1] * 3


@pytest.mark.long
@pytest.mark.parametrize(
    "scale", [(1, 1, 1), (1, 2, 0.7), (-1, 1, 1), (1, -1, 1), (-2, 1, 0.5), (0.1, 0.1, 0.1)]
)
def test_a_sun_is_where_cycles_takes_its_light_from_under_any_parent(
    scale: tuple[float, float, float], place: Place, tmp_path: Path
) -> None:
    camera_above()
    quad = paint_quad("White")
    white = bpy.data.materials.new("White")
    if white.node_tree is None:
        white.use_nodes = True
    nodes = white.node_tree.nodes
    nodes.clear()
    diffuse, out = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
    white.node_tree.links.new(diffuse.outputs[0], out.inputs["Surface"])
    material.assign(quad, white)
    paint_quad("Painted").location.x = 50
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.rotation_euler, parent.scale = (0.2, 0.1, 0.4), scale
    place("SUN", "Sun", rotation_euler=(0.5, 0.3, 0), parent=parent, energy=math.pi, angle=0)
    fill()
    cosine = slot(1)[1][2]
    assert cosine > 0.3
    assert render(tmp_path / "white.exr")[8, 8, 0] == pytest.approx(cosine, rel=1e-5)


def test_unused_slots_are_zero_and_have_no_drivers(place: Place, painted: object) -> None:
    place("POINT", "Lamp", location=(1, 2, 3))
    fill()
    for number in range(2, lights.SLOTS + 1):
        assert slot(number) == (0, (0, 0, 0), 0)
    assert len(drivers()) == 4


@pytest.mark.parametrize("kind", ["SUN", "POINT", "SPOT"])
def test_drivers_need_no_python(kind: str, place: Place, painted: object) -> None:
    for i in range(lights.SLOTS):
        place(kind, f"Lamp {i}")
    fill()
    assert len(drivers()) == 4 * lights.SLOTS  # x, y, z and size
    for driver in drivers():
        assert driver.is_simple_expression
        assert driver.is_valid


def test_values_are_right_at_once_even_where_no_paint_is(place: Place) -> None:
    lamp = place("POINT", "Lamp", location=(1, 2, 3), shadow_soft_size=0.5)
    fill()
    lamp.location = (4, 5, 6)
    fill()
    assert carrier.values() == [(carrier.POSITIONAL, Vector((4, 5, 6)), 0.5, Vector((0, 0, 0)))]


def test_a_light_that_moves_is_followed(place: Place, painted: object) -> None:
    lamp = place("POINT", "Lamp")
    fill()
    size = lamp.data.shadow_soft_size
    lamp.location = (4, 5, 6)
    assert slot(1) == (carrier.POSITIONAL, (4, 5, 6), pytest.approx(size))


def test_a_constrained_light_is_followed(place: Place, painted: object) -> None:
    target = bpy.data.objects.new("Target", None)
    bpy.context.scene.collection.objects.link(target)
    target.location = (0, 3, 4)
    sun = place("SUN", "Sun", location=(0, 0, 0))
    constraint = sun.constraints.new("TRACK_TO")
    constraint.target, constraint.track_axis, constraint.up_axis = target, "TRACK_Z", "UP_Y"
    fill()
    assert slot(1)[1] == pytest.approx((0, 0.6, 0.8), abs=EPSILON)
    target.location = (3, 0, 4)
    assert slot(1)[1] == pytest.approx((0.6, 0, 0.8), abs=EPSILON)


@pytest.mark.parametrize("turn", [1e-4, 4e-4, 1e-3])
def test_drivers_round_nothing(turn: float, place: Place, painted: object) -> None:
    """Near an axis, and near nothing."""
    place("SUN", "A sun", rotation_euler=(turn, 0, 0), angle=turn)
    place("POINT", "B lamp", location=(turn, 1 + turn, 0), shadow_soft_size=turn)
    fill()
    bpy.context.view_layer.update()
    assert slot(1)[1] == pytest.approx((0, -turn, 1), rel=1e-4)
    assert slot(1)[2] == pytest.approx(turn / 2)
    assert slot(2)[1] == pytest.approx((turn, 1 + turn, 0))
    assert slot(2)[2] == pytest.approx(turn)


@pytest.mark.long
def test_a_light_without_a_size_is_followed(
    place: Place, painted: bpy.types.Object, tmp_path: Path
) -> None:
    """An attribute of size 0 would look like one that is missing."""
    camera_above()
    sun = place("SUN", "A sun", angle=0)
    lamp = place("POINT", "B lamp", shadow_soft_size=0)
    fill()
    show_slots(painted.active_material)
    sun.rotation_euler, lamp.location = (0.5, 0, 0), (1, 2, 3)
    shown = shown_slots(render(tmp_path / "moved.exr"))
    assert shown == pytest.approx([0, -math.sin(0.5), math.cos(0.5), 1, 2, 3, 0], abs=1e-6)


def test_a_light_of_no_extent_at_all_gives_no_driver_error(place: Place, painted: object) -> None:
    place("SUN", "Sun", scale=(0, 0, 0))
    fill()
    assert slot(1)[1] == (0, 0, 0)
    assert all(driver.is_valid for driver in drivers())


@pytest.mark.parametrize("shape", ["SQUARE", "RECTANGLE", "DISK", "ELLIPSE"])
def test_an_area_light_is_its_disc_and_its_normal(
    place: Place, painted: object, shape: str
) -> None:
    """Scaled by the object, as Cycles scales it; and followed without a fit."""
    random = seeds.fresh(610)
    lamp = place("AREA", "Area", shape=shape)
    data = lamp.data
    fill()
    assert all(driver.is_simple_expression and driver.is_valid for driver in drivers())
    for _ in range(3):
        lamp.location = random.uniform(-3, 3, 3)
        lamp.rotation_euler = random.uniform(-3, 3, 3)
        lamp.scale = random.uniform(0.5, 2, 3)
        data.size, data.size_y = random.uniform(0.1, 2, 2)
        bpy.context.view_layer.update()
        matrix = np.array(lamp.matrix_world)
        sides = [data.size, data.size_y if shape in ("RECTANGLE", "ELLIPSE") else data.size]
        u, v = sides * np.linalg.norm(matrix[:3, :2], axis=0)
        area = u * v * (math.pi / 4 if shape in ("DISK", "ELLIPSE") else 1)
        reach = max(u, v) / 2 if shape in ("DISK", "ELLIPSE") else math.hypot(u, v) / 2
        number, place_, size = slot(1)
        assert number == carrier.AREA
        assert place_ == pytest.approx(lamp.location, abs=1e-5)
        assert size == pytest.approx(math.sqrt(area / math.pi), rel=1e-5)
        facing = np.array(seen_at(bpy.data.objects["Painted"], carrier.facing_path(1)))[:3]
        normal = -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
        np.testing.assert_allclose(facing, normal * reach, rtol=1e-5, atol=1e-5)
        carried = carrier.values()
        fill()  # says the same
        np.testing.assert_allclose(carrier.values()[0][3], facing, rtol=1e-5, atol=1e-5)
        assert carried[0][0] == carrier.AREA


# --- which lights -----------------------------------------------------------------------------


def test_slots_are_ordered_by_name(place: Place) -> None:
    for name, energy in (("B", 3), ("C", 2), ("A", 1)):
        place("SUN", name, energy=energy)
    assert fill().slots == named("A", "B", "C")


def test_an_area_light_that_is_partly_dark_has_no_slot_and_is_told(place: Place) -> None:
    softbox = place("AREA", "Softbox", energy=1e6, spread=math.radians(89))
    window = place("AREA", "Window")
    window.data.cycles.is_portal = True
    report = fill()
    assert report.slots == ()
    why = "its Spread is below 90°, so parts of it are dark"
    assert report.left_out[softbox] == why
    assert report.left_out[window] == "a portal is a window for the world's light"
    assert f"no sparkles from Softbox: {why}" in str(report)


def test_a_light_that_no_flake_mirrors_takes_no_slot_from_others(place: Place) -> None:
    for i in range(8):
        place("POINT", f"Fill {i}", energy=100, location=(0, 0, 3)).visible_glossy = False
    place("POINT", "Key", energy=50, location=(0, 0, 3))
    report = fill()
    assert report.slots == named("Key")
    assert {*report.left_out.values()} == {
        "its Ray Visibility has Glossy off, so no flake mirrors it"
    }


def test_area_lights_come_after_the_others(place: Place) -> None:
    place("AREA", "A")
    place("SUN", "B")
    assert fill().slots == named("B", "A")


def test_the_nearest_and_best_facing_area_lights_have_the_slots(place: Place) -> None:
    """Of nine of one power: the one that looks away is left out."""
    for i in range(9):
        place("AREA", f"Area {i}", location=(0, 0, 5 + i), energy=10)
    bpy.data.objects["Area 0"].rotation_euler = (math.pi, 0, 0)
    assert [lamp.name for lamp in fill().left_out] == ["Area 0"]


def test_a_light_that_does_not_render_has_no_slot(place: Place) -> None:
    place("SUN", "Shown")
    place("SUN", "Hidden").hide_render = True
    excluded, hidden = (bpy.data.collections.new(name) for name in ("Excluded", "Off"))
    for collection in (excluded, hidden):
        bpy.context.scene.collection.children.link(collection)
        light = place("SUN", f"In {collection.name}")
        bpy.context.scene.collection.objects.unlink(light)
        collection.objects.link(light)
    inner = bpy.data.collections.new("Inner")
    excluded.children.link(inner)
    light = place("SUN", "Deep inside")
    bpy.context.scene.collection.objects.unlink(light)
    inner.objects.link(light)
    bpy.context.view_layer.layer_collection.children["Excluded"].exclude = True
    hidden.hide_render = True
    report = fill()
    assert (report.slots, report.left_out) == (named("Shown"), {})


def appears_at(frame: int, lamp: bpy.types.Object) -> None:
    for at, hidden in ((1, True), (frame, False)):
        lamp.hide_render = hidden
        lamp.keyframe_insert("hide_render", frame=at)
    bpy.context.scene.frame_set(1)


@pytest.mark.long
def test_a_light_that_appears_later_sparkles_then(
    place: Place, painted: object, tmp_path: Path
) -> None:
    camera_above(32)
    place("SUN", "Always", rotation_euler=(0.1, 0.1, 0), energy=0)
    appears_at(5, place("SUN", "Later", rotation_euler=(0.1, -0.1, 0), energy=3))
    assert fill().slots == named("Always", "Later")
    assert render(tmp_path / "hidden.exr").max() == 0
    bpy.context.scene.frame_set(5)
    shown = render(tmp_path / "shown.exr")
    assert shown.std() > 0.01 * shown.mean()


def test_lights_that_show_now_win_over_those_that_appear_later(
    place: Place, painted: object
) -> None:
    later = place("SUN", "A later one", energy=100)
    appears_at(5, later)
    for i in range(lights.SLOTS):
        place("SUN", f"Sun {i}", energy=1)
    report = fill()
    assert report.left_out == {later: "8 other lights have the slots"}
    bpy.data.objects.remove(bpy.data.objects["Sun 3"])
    assert later in fill().slots


def test_a_light_hidden_in_the_viewport_only_has_a_slot(place: Place, painted: object) -> None:
    lamp = place("POINT", "Lamp", location=(1, 2, 3))
    lamp.hide_viewport = True
    assert fill().slots == named("Lamp")
    assert slot(1)[1] == (1, 2, 3)
    lamp.location.x = 5
    assert slot(1)[1] == (5, 2, 3)


def test_lights_of_every_view_layer_have_slots(place: Place) -> None:
    scene = bpy.context.scene
    collection = bpy.data.collections.new("Second only")
    scene.collection.children.link(collection)
    light = place("SUN", "Sun", rotation_euler=(0.5, 0, 0))
    scene.collection.objects.unlink(light)
    collection.objects.link(light)
    first = scene.view_layers[0]
    second = scene.view_layers.new("Second")
    first.layer_collection.children[collection.name].exclude = True
    second.layer_collection.children[collection.name].exclude = False
    assert fill().slots == named("Sun")
    [(_, vector, *_)] = carrier.values()
    assert vector[:] == pytest.approx((0, -math.sin(0.5), math.cos(0.5)), abs=EPSILON)
    second.use = False
    assert fill().slots == ()


def test_of_more_than_eight_lights_the_brightest_at_the_paint_stay(
    place: Place, painted: object
) -> None:
    for i in range(10):
        place("SUN", f"Sun {i}", energy=1 + (7 * i) % 10)
    report = fill()
    assert len(report.slots) == lights.SLOTS
    assert min(lamp.data.energy for lamp in report.slots) == 3
    assert names(report.slots) == sorted(names(report.slots))
    assert set(report.left_out.values()) == {"8 brighter lights have the slots"}
    assert {lamp.data.energy for lamp in report.left_out} == {1, 2}


@pytest.mark.parametrize(
    ("values", "stays"),
    [
        # A lamp of 4π·d² W sends 1 W/m² to a distance of d; the other lights send 1 W/m².
        ({"location": (0, 0, 10), "energy": 4 * math.pi * 100 * 1.1}, True),
        ({"location": (0, 0, 10), "energy": 4 * math.pi * 100 * 0.9}, False),
        # The distance is that to the nearest point of the painted box, not to its centre.
        ({"location": (11, 0, 0), "energy": 4 * math.pi * 100 * 1.1}, True),
        ({"location": (11, 0, 0), "energy": 4 * math.pi * 100 * 0.9}, False),
        ({"location": (0, 0, 0.01), "energy": 1}, True),
        ({"location": (0, 0, 10), "energy": 4 * math.pi * 100, "exposure": 0.2}, True),
        ({"location": (0, 0, 10), "energy": 4 * math.pi * 100, "exposure": -0.2}, False),
        ({"location": (0, 0, 10), "energy": 4 * math.pi * 200, "color": (0.1, 0.6, 0)}, True),
        ({"location": (0, 0, 10), "energy": 4 * math.pi * 200, "color": (0.1, 0.4, 0)}, False),
    ],
)
def test_a_lamp_competes_with_its_irradiance_on_the_nearest_paint(
    values: dict[str, object], stays: bool, place: Place, painted: object
) -> None:
    for i in range(lights.SLOTS):
        place("SUN", f"Sun {i}", energy=1)
    place("POINT", "Lamp", shadow_soft_size=0, **values)
    assert ("Lamp" in names(fill().slots)) == stays


@pytest.mark.parametrize(
    ("kind", "energy"),
    [("SUN", 3), ("POINT", 48 * math.pi), ("SPOT", 48 * math.pi), ("AREA", 12 * math.pi)],
)
def test_irradiance_falls_with_the_square_of_the_distance(kind: str, energy: float) -> None:
    light = bpy.data.lights.new("Light", kind)
    light.energy, light.color, light.exposure = energy, (0.1, 0.5, 0.2), 1
    falls = 1 if kind == "SUN" else 1 / 4
    found = lights.irradiance(light, np.array([4.0, 16.0]))
    np.testing.assert_allclose(found, [3, 3 * falls], rtol=1e-6)
    assert lights.irradiance(light, 4.0) == pytest.approx(3)


@pytest.mark.parametrize(
    ("tilt", "stays"), [(0, True), (0.5, True), (0.7, False), (math.pi, False)]
)
def test_a_spot_competes_only_where_its_cone_meets_paint(
    tilt: float, stays: bool, place: Place, painted: object
) -> None:
    """A cone of 0.5 rad about the axis, 10 m above a box of radius √2: they meet up to 0.64."""
    for i in range(lights.SLOTS):
        place("SUN", f"Sun {i}", energy=1)
    place("SPOT", "Spot", location=(0, 0, 10), rotation_euler=(tilt, 0, 0), energy=1e5,
          spot_size=1.0)  # fmt: skip
    assert ("Spot" in names(fill().slots)) == stays


def test_only_paint_counts_when_lights_compete(place: Place, painted: object) -> None:
    unpainted = paint_quad("Unpainted")
    material.assign(unpainted, bpy.data.materials.new("Plain"))
    unpainted.location.x = 100
    for i in range(lights.SLOTS):
        place("SUN", f"Sun {i}", energy=1)
    place("POINT", "Lamp", location=(100, 0, 1), energy=100)
    assert "Lamp" not in names(fill().slots)
    material.assign(unpainted, material.create(Paint()))
    assert "Lamp" in names(fill().slots)


def test_an_instance_of_a_painted_object_counts_too(place: Place, painted: object) -> None:
    show_as_instance(painted).location.x = 100
    paint_quad("Plain").data.materials.clear()
    for i in range(lights.SLOTS):
        place("SUN", f"Sun {i}", energy=1)
    place("POINT", "At the car", location=(100, 0, 1), energy=100)
    place("POINT", "Elsewhere", location=(0, 0, 1), energy=200)
    report = fill()
    assert "At the car" in names(report.slots)
    assert "Elsewhere" in names(report.left_out)


# --- again and again --------------------------------------------------------------------------


def test_filling_again_leaves_nothing_of_before(place: Place, painted: object) -> None:
    sun = place("SUN", "A sun", angle=0.5)
    place("POINT", "B lamp", location=(1, 2, 3))
    fill()
    fill()
    assert len(drivers()) == 8
    bpy.data.objects.remove(sun)
    assert fill().slots == named("B lamp")
    assert slot(1)[:2] == (carrier.POSITIONAL, (1, 2, 3))
    assert slot(2) == (0, (0, 0, 0), 0)
    assert len(drivers()) == 4
    bpy.data.objects.remove(bpy.data.objects["B lamp"])
    assert fill().slots == ()
    assert slot(1) == (0, (0, 0, 0), 0)
    assert not drivers()


def test_a_light_that_becomes_another_kind_is_filled_anew(place: Place, painted: object) -> None:
    lamp = place("SUN", "Lamp", location=(1, 2, 3))
    fill()
    lamp.data.type = "POINT"
    lamp.data.shadow_soft_size = 0.5
    fill()
    assert slot(1) == (carrier.POSITIONAL, (1, 2, 3), pytest.approx(0.5))
    assert all(driver.is_valid for driver in drivers())


def test_a_linked_light_may_share_the_name_of_a_local_one(
    tmp_path: Path, place: Place, painted: object
) -> None:
    place("AREA", "Light", spread=1)
    file = str(tmp_path / "lights.blend")
    bpy.data.libraries.write(file, {bpy.data.objects["Light"]})
    own = bpy.data.objects["Light"]
    own.data.type = "SUN"
    with bpy.data.libraries.load(file, link=True) as (there, here):
        here.objects = there.objects
    [linked] = here.objects
    bpy.context.scene.collection.objects.link(linked)
    report = fill()
    assert linked.name == own.name
    assert report.slots == (own,)
    assert list(report.left_out) == [linked]
    assert needs.fit(bpy.context.scene).other_light
    assert str(report).splitlines()[0] == "light 1: Light"
    assert "no sparkles from Light [lights.blend]: its Spread" in str(report)


def test_the_slots_are_those_of_the_scene_filled_last(place: Place) -> None:
    place("SUN", "Sun")
    fill()
    other = bpy.data.scenes.new("Other")
    other.unit_settings.scale_length = 0.5
    assert lights.fill(other).slots == ()
    assert lights.constant("Light1Kind") == 0
    assert lights.constant(lights.METERS_PER_UNIT) == 0.5


# --- who carries the values -------------------------------------------------------------------


def carries(thing: bpy.types.Object) -> bool:
    return carrier.is_attached([thing])


def moved_lamp_is_seen_at(thing: bpy.types.Object) -> bool:
    lamp = bpy.data.objects["Lamp"]
    lamp.location = (4, 5, 6)
    return seen_at(thing, carrier.path(1, carrier.POSITIONAL))[:3] == (4, 5, 6)


def test_copies_and_joined_objects_carry_the_values(place: Place, painted: object) -> None:
    place("POINT", "Lamp")
    fill()
    copy = painted.copy()
    bpy.context.scene.collection.objects.link(copy)
    assert moved_lamp_is_seen_at(copy)
    bpy.ops.mesh.primitive_plane_add()
    with bpy.context.temp_override(selected_editable_objects=[bpy.context.object, copy]):
        bpy.ops.object.join()
    fill()
    bpy.data.objects["Lamp"].location = (0, 0, 0)
    assert moved_lamp_is_seen_at(bpy.context.object)


def test_an_appended_object_carries_the_values_of_this_file(tmp_path: Path, place: Place) -> None:
    file = save_paint(tmp_path, place)
    paint_quad("Painted")
    place("POINT", "Lamp")
    with bpy.data.libraries.load(file, link=False) as (_, here):
        here.objects = ["Foreign"]
    [foreign] = here.objects
    bpy.context.scene.collection.objects.link(foreign)
    assert len(carrier.all_of_file()) == 1  # the one that came along
    fill()
    assert len(carrier.all_of_file()) == 1
    assert moved_lamp_is_seen_at(foreign)
    assert moved_lamp_is_seen_at(bpy.data.objects["Painted"])


def test_every_object_that_shows_a_paint_carries_them(place: Place, painted: object) -> None:
    """By a slot of the object, by geometry nodes, and by geometry nodes' inputs; no other does."""
    paint = painted.active_material
    plain = bpy.data.objects.new("Plain", bpy.data.meshes.new("Plain"))
    by_slot = bpy.data.objects.new("By slot", plain.data)
    plain.data.materials.append(None)
    by_slot.material_slots[0].link = "OBJECT"
    by_slot.material_slots[0].material = paint
    tree = bpy.data.node_groups.new("Paints", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    tree.nodes.new("GeometryNodeSetMaterial").inputs["Material"].default_value = paint
    outer = bpy.data.node_groups.new("Outer", "GeometryNodeTree")
    outer.nodes.new("GeometryNodeGroup").node_tree = tree
    by_nodes = bpy.data.objects.new("By nodes", bpy.data.meshes.new("Empty"))
    by_nodes.modifiers.new("Nodes", "NODES").node_group = outer
    asked = bpy.data.node_groups.new("Asks", "GeometryNodeTree")
    socket = asked.interface.new_socket("M", in_out="INPUT", socket_type="NodeSocketMaterial")
    by_input = bpy.data.objects.new("By input", bpy.data.meshes.new("Empty"))
    modifier = by_input.modifiers.new("Nodes", "NODES")
    modifier.node_group = asked
    if hasattr(modifier, "properties"):  # Blender 5.2
        getattr(modifier.properties.inputs, socket.identifier).value = paint
    else:
        modifier[socket.identifier] = paint
    fill()
    assert [carries(each) for each in (painted, by_slot, by_nodes, by_input)] == [True] * 4
    assert not carries(plain)


def test_a_paint_on_another_object_is_noticed(place: Place, painted: object) -> None:
    scene = bpy.context.scene
    material.set_up_cycles(scene)
    needs.fit(scene)
    assert needs.is_fitted(scene)
    bpy.data.objects.new("Spare", painted.data)  # in no scene yet
    assert not needs.is_fitted(scene)
    needs.fit(scene)
    assert needs.is_fitted(scene)


def test_a_lamp_that_hangs_on_the_painted_object_is_followed(
    place: Place, painted: bpy.types.Object, capfd: pytest.CaptureFixture[str]
) -> None:
    lamp = place("POINT", "Lamp", parent=painted, location=(0, 0, 1))
    fill()
    painted.location = (1, 2, 3)
    assert slot(1)[1] == (1, 2, 4)
    lamp.location.z = 2
    assert slot(1)[1] == (1, 2, 5)
    assert "cycle" not in "".join(capfd.readouterr()).lower()


@pytest.mark.long
def test_an_object_without_them_shows_the_lights_where_they_stood_when_one_came_last(
    place: Place, painted: bpy.types.Object, tmp_path: Path
) -> None:
    camera_above()
    sun = place("SUN", "A sun", rotation_euler=(0.5, 0, 0))
    lamp = place("POINT", "B lamp", location=(1, 2, 3), shadow_soft_size=0.5)
    fill()
    show_slots(painted.active_material)
    stood = [*sun.matrix_world.col[2].xyz, 1, 2, 3, 0.5]
    for name in painted.keys():  # noqa: SIM118  # an object is no mapping
        del painted[name]
    sun.rotation_euler, lamp.location, lamp.data.shadow_soft_size = (0, 1, 0), (7, 8, 9), 0.25
    assert shown_slots(render(tmp_path / "left.exr")) == pytest.approx(stood, abs=1e-6)
    fill()
    now = [*sun.matrix_world.col[2].xyz, 7, 8, 9, 0.25]
    assert shown_slots(render(tmp_path / "found.exr")) == pytest.approx(now, abs=1e-6)


def test_what_an_empty_instances_carries_them(
    place: Place, painted: bpy.types.Object, tmp_path: Path
) -> None:
    camera_above()
    place("SUN", "A sun")
    lamp = place("POINT", "B lamp", location=(1, 2, 3), shadow_soft_size=0.5)
    show_as_instance(painted)
    fill()
    show_slots(painted.active_material)
    lamp.location = (7, 8, 9)
    shown = shown_slots(render(tmp_path / "instance.exr"))
    assert shown == pytest.approx([0, 0, 1, 7, 8, 9, 0.5], abs=1e-6)


def test_overridden_and_instanced_objects_of_another_file_see_the_lights_of_this_one(
    place: Place, tmp_path: Path
) -> None:
    """Where the other file's paint knows a light of that kind; also in the saved file."""
    place("POINT", "Foreign lamp")
    show_as_instance(paint_quad("Foreign"))
    fill()
    file = str(tmp_path / "foreign.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    paint_quad("Painted")
    place("POINT", "Lamp")
    with bpy.data.libraries.load(file, link=True) as (_, here):
        here.collections = ["Instanced"]
    [linked] = here.collections
    empty = bpy.data.objects.new("Empty", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", linked
    bpy.context.scene.collection.objects.link(empty)
    linked.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer)

    def seeing() -> list[bpy.types.Object]:
        overridden = [each for each in bpy.data.objects if each.override_library]
        return [*overridden, bpy.data.objects["Empty"], bpy.data.objects["Painted"]]

    assert len(seeing()) == 3
    fill()
    for thing in seeing():
        bpy.data.objects["Lamp"].location = (0, 0, 0)
        assert moved_lamp_is_seen_at(thing)
    shot = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=shot)
    bpy.ops.wm.open_mainfile(filepath=shot)
    assert len(seeing()) == 3
    assert all(map(carries, seeing()))


def test_a_group_of_an_older_version_is_left_to_its_paints(place: Place) -> None:
    place("SUN", "Sun")
    older = lights.node_group()
    older["metallic_paint_lights"] = 3
    fill()
    [group] = lights.groups()
    assert group != older
    assert lights.version(older) == 3


# --- one group per file -----------------------------------------------------------------------


def light_groups() -> list[str]:
    return [group.name for group in bpy.data.node_groups if group.name.startswith(lights.NAME)]


def save_paint(tmp_path: Path, place: Place) -> str:
    """A file with a paint lit by a lamp; afterwards the scene is empty again."""
    place("POINT", "Foreign lamp")
    paint_quad("Foreign")
    fill()
    file = str(tmp_path / "foreign.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return file


def test_an_appended_paint_joins_the_lights_of_the_file(tmp_path: Path, place: Place) -> None:
    file = save_paint(tmp_path, place)
    paint_quad("Painted")
    place("SUN", "Sun")
    fill()
    with bpy.data.libraries.load(file, link=False) as (there, here):
        here.materials = there.materials
    assert len(light_groups()) == 2
    report = fill()
    assert (report.slots, report.left_out, report.read_only) == (named("Sun"), {}, ())
    assert light_groups() == [lights.NAME]
    for paint in bpy.data.materials:
        inner = material.paint_node(paint).node_tree.nodes[lights.NAME]
        assert inner.node_tree == lights.node_group()


def test_a_linked_paint_that_cannot_be_filled_is_told(tmp_path: Path, place: Place) -> None:
    """One of a file that is no library."""
    file = save_paint(tmp_path, place)
    bpy.ops.wm.open_mainfile(filepath=file)
    lights.node_group()["metallic_paint_looks"] = False
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(file, link=True) as (there, here):
        here.materials = there.materials
    report = fill()
    assert report.read_only == (file,)
    assert str(report) == f"paints linked from {file} do not see these lights"


# --- in the render ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("number", "constant"), [(1, [1, 0, 0]), (2, [1, 1, 0])], ids=["a used slot", "an unused slot"]
)
def test_the_compiler_knows_which_slots_are_used_and_not_where_their_lights_are(
    number: int,
    constant: list[int],
    place: Place,
    painted: bpy.types.Object,
    tmp_path: Path,
) -> None:
    """So OSL leaves out unused slots, and compiles nothing when a light moves."""
    camera_above()
    place("SUN", "Sun", angle=0.5, rotation_euler=(0.5, 0, 0))
    fill()
    text = bpy.data.texts.new("constant.osl")
    text.write(
        "shader constant(float Kind = 0, vector Vector = 0, float Size = 0, float Varying = 0,"
        " output closure color BSDF = 0)\n"
        "{ BSDF = color(isconstant(Kind), isconstant(Vector) || isconstant(Size),"
        " isconstant(Varying)) * emission(); }"
    )
    tree = painted.active_material.node_tree
    script, group = tree.nodes.new("ShaderNodeScript"), tree.nodes.new("ShaderNodeGroup")
    geometry = tree.nodes.new("ShaderNodeNewGeometry")
    shader.compile_into(script, text)
    group.node_tree = lights.node_group()
    for name, socket in zip(lights.slot_names(number), script.inputs, strict=False):
        tree.links.new(group.outputs[name], socket)
    tree.links.new(geometry.outputs["Backfacing"], script.inputs["Varying"])
    tree.links.new(script.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    assert render(tmp_path / "constant.exr")[8, 8].tolist() == constant


RENDER_ALONE = """
import os, sys
import bpy
sys.path = [path for path in sys.path if "addon" not in path and "tools" not in path]
bpy.ops.wm.open_mainfile(filepath=sys.argv[1], use_scripts=False)
for name in ("metallic_paint", "oslquery"):
    try:
        __import__(name)
    except ImportError:
        pass
    else:
        print("can import", name, flush=True)
        os._exit(1)
bpy.context.scene.render.filepath = sys.argv[2]
bpy.ops.render.render(animation=True)
sys.stdout.flush()
os._exit(0)
"""


@pytest.mark.long
def test_a_machine_without_add_on_or_permission_to_run_scripts_follows_animated_lights(
    place: Place, painted: bpy.types.Object, tmp_path: Path
) -> None:
    """A sun under a mirrored, turning parent and a moving lamp that grows, at three frames."""
    camera_above()
    scene = bpy.context.scene
    parent = bpy.data.objects.new("Parent", None)
    parent.scale = (-1, 1, 2)
    scene.collection.objects.link(parent)
    place("SUN", "A sun", parent=parent, rotation_euler=(0.3, 0.2, 0), angle=0.4)
    lamp = place("POINT", "B lamp", shadow_soft_size=0.1)
    for frame, amount in ((1, 0.0), (11, 1.0)):
        parent.rotation_euler.x = amount
        parent.keyframe_insert("rotation_euler", frame=frame)
        lamp.location = (amount, 2 * amount, 3)
        lamp.keyframe_insert("location", frame=frame)
        lamp.data.shadow_soft_size = 0.1 + amount
        lamp.data.keyframe_insert("shadow_soft_size", frame=frame)
    fill()
    show_slots(painted.active_material)
    scene.frame_start, scene.frame_end, scene.frame_step = 1, 11, 5
    expected = {}
    for frame in (1, 6, 11):
        scene.frame_set(frame)
        sun = Matrix(bpy.data.objects["A sun"].matrix_world).col[2].xyz.normalized()
        expected[frame] = [*sun, *lamp.matrix_world.translation, lamp.data.shadow_soft_size]
    assert (Vector(expected[1][:3]) - Vector(expected[11][:3])).length > 0.5
    render_alone(tmp_path)
    for frame, values in expected.items():
        picture = read(tmp_path / f"frame_{frame:04}.exr")
        assert shown_slots(picture) == pytest.approx(values, abs=1e-5), f"frame {frame}"


@pytest.mark.long
def test_a_machine_without_the_add_on_renders_the_same_picture(
    place: Place, painted: bpy.types.Object, tmp_path: Path
) -> None:
    camera_above(32)
    bpy.context.scene.frame_end = 1
    place("SUN", "Sun", rotation_euler=(0.1, 0.1, 0), energy=3)
    place("POINT", "Lamp", location=(0.2, 0, 4), energy=500)
    fill()
    here = render(tmp_path / "here.exr")
    assert here.max() > 0
    assert here.std() > 0.01 * here.mean()
    render_alone(tmp_path)
    np.testing.assert_array_equal(read(tmp_path / "frame_0001.exr"), here)


def render_alone(folder: Path) -> None:
    """Saves the file and renders its frames in a process that has nothing but Blender."""
    file = folder / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    result = subprocess.run(
        [sys.executable, "-c", RENDER_ALONE, str(file), str(folder / "frame_")],
        capture_output=True, text=True, timeout=120, cwd=folder,
        env={"BLENDER_USER_RESOURCES": str(folder), "PATH": ""},
    )  # fmt: skip
    assert result.returncode == 0, result.stdout + result.stderr


def show_slots(paint: bpy.types.Material) -> None:
    """Makes the material emit slot 1's vector, slot 2's vector and slot 2's size in stripes."""
    text = bpy.data.texts.new("stripes.osl")
    text.write(
        "shader stripes(vector One = 0, vector Two = 0, float Size = 0,"
        " output closure color BSDF = 0)\n"
        '{ point p = transform("NDC", P);\n'
        "  vector value = p[0] < 0.33 ? One : (p[0] < 0.66 ? Two : vector(Size));\n"
        "  BSDF = color(value[0], value[1], value[2]) * emission(); }"
    )
    tree = paint.node_tree
    script, group = tree.nodes.new("ShaderNodeScript"), tree.nodes.new("ShaderNodeGroup")
    shader.compile_into(script, text)
    group.node_tree = lights.node_group()
    for source, name in (("Light1Vector", "One"), ("Light2Vector", "Two"), ("Light2Size", "Size")):
        tree.links.new(group.outputs[source], script.inputs[name])
    tree.links.new(script.outputs[0], tree.nodes["Material Output"].inputs["Surface"])


def shown_slots(picture: np.ndarray) -> list[float]:
    """The three stripes of show_slots in a picture of camera_above."""
    return [*picture[8, 2], *picture[8, 8], picture[8, 13, 0]]
