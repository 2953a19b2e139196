# SPDX-License-Identifier: Apache-2.0
"""Lights follow by themselves: nothing here calls needs.fit or Update Lights.

Without a window Blender runs no timers, so the handlers fit at once; the tests call what the timer
calls.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import FrameType, SimpleNamespace

import addon_utils
import bpy
import numpy as np
import OpenImageIO
import pytest
from mathutils import Matrix
from package import NAME, Addon
from recording import drawn


@pytest.fixture(autouse=True)
def painted() -> bpy.types.Object:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6)
    bpy.ops.material.metallic_paint_new()
    return bpy.context.object


@pytest.fixture
def fits(addon: Addon, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Grows with each fit."""
    needs, counted = addon("scene.needs"), []
    fit = needs.fit
    monkeypatch.setattr(needs, "fit", lambda scene: counted.append(scene.name) or fit(scene))
    return counted


def update() -> None:
    bpy.context.view_layer.update()


def add(kind: str, name: str, x: float = 0) -> bpy.types.Object:
    lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, kind))
    lamp.location.x = x
    bpy.context.scene.collection.objects.link(lamp)
    update()
    return lamp


def slots(addon: Addon) -> list[str]:
    """The names that the last fit told of."""
    lines = addon("scene.needs").said().splitlines()
    return [line.partition(": ")[2] for line in lines if line.startswith("light ")]


def call(name: str) -> None:
    """The add-on's handlers as Blender calls them."""
    for handler in getattr(bpy.app.handlers, name):
        if handler.__module__.startswith(NAME):
            handler(bpy.context.scene, None)


def test_new_lights_get_slots(addon: Addon) -> None:
    for number, kind in enumerate(("SUN", "POINT", "SPOT"), 1):
        add(kind, kind)
        assert len(addon("scene.carrier").values()) == number
    assert slots(addon) == ["POINT", "SPOT", "SUN"]


def test_deleted_lights_leave_their_slot(addon: Addon) -> None:
    lamp = add("SUN", "Sun")
    bpy.data.objects.remove(lamp)
    update()
    assert addon("scene.carrier").values() == []


def test_light_of_the_same_name_takes_over(addon: Addon) -> None:
    lamp = add("POINT", "Lamp", 1)
    data = lamp.data
    bpy.data.objects.remove(lamp)
    bpy.data.lights.remove(data)
    add("POINT", "Lamp", 5)
    [(_, vector, _, _)] = addon("scene.carrier").values()
    assert vector.x == 5


def test_light_with_other_data_takes_its_radius(addon: Addon) -> None:
    lamp = add("POINT", "Lamp")
    lamp.data = bpy.data.lights.new("Other", "POINT")
    lamp.data.shadow_soft_size = 0.75
    update()
    [(_, _, size, _)] = addon("scene.carrier").values()
    assert size == 0.75


def test_renamed_lights_move(addon: Addon) -> None:
    lamp, _ = add("POINT", "A", 1), add("POINT", "B", 2)
    lamp.name = "C"
    update()
    assert slots(addon) == ["B", "C"]
    assert [round(vector.x) for _, vector, *_ in addon("scene.carrier").values()] == [2, 1]


def test_type_changes_follow(addon: Addon) -> None:
    lamp = add("SUN", "Lamp")
    lamp.data.type = "POINT"
    update()
    assert addon("scene.carrier").values()[0][0] == addon("scene.carrier").POSITIONAL
    lamp.data.type = "AREA"
    update()
    size = addon("scene.carrier").values()[0][2]
    lamp.data.shape = "DISK"
    update()
    assert addon("scene.carrier").values()[0][2] < size
    lamp.data.spread = 1
    update()
    assert addon("scene.carrier").values() == []


def test_hidden_lights_leave_their_slot(addon: Addon) -> None:
    lamp = add("SUN", "Sun")
    lamp.hide_render = True
    update()
    assert addon("scene.carrier").values() == []
    lamp.hide_render = False
    update()
    assert slots(addon) == ["Sun"]


def test_excluded_collections_take_their_lights_along(addon: Addon) -> None:
    collection = bpy.data.collections.new("Lamps")
    bpy.context.scene.collection.children.link(collection)
    lamp = add("SUN", "Sun")
    collection.objects.link(lamp)
    bpy.context.scene.collection.objects.unlink(lamp)
    update()
    assert slots(addon) == ["Sun"]
    bpy.context.view_layer.layer_collection.children["Lamps"].exclude = True
    update()
    assert addon("scene.carrier").values() == []


def test_lights_linked_from_another_file(addon: Addon, tmp_path: Path) -> None:
    lamp = add("POINT", "Theirs", 3)
    file = str(tmp_path / "lamps.blend")
    bpy.data.libraries.write(file, {lamp})
    bpy.data.objects.remove(lamp)
    with bpy.data.libraries.load(file, link=True) as (_, into):
        into.objects = ["Theirs"]
    bpy.context.scene.collection.objects.link(into.objects[0])
    update()
    [(_, vector, _, _)] = addon("scene.carrier").values()
    assert vector.x == 3


def test_parented_and_animated_lights_follow_their_parent(addon: Addon) -> None:
    bpy.ops.object.empty_add()
    parent = bpy.context.object
    for frame, x in ((1, 0), (11, 10)):
        parent.location.x = x
        parent.keyframe_insert("location", frame=frame)
    add("POINT", "Lamp").parent = parent
    update()
    for frame, x in ((1, 0), (11, 10)):
        bpy.context.scene.frame_set(frame)
        [(_, vector, _, _)] = addon("scene.carrier").values()
        assert vector.x == pytest.approx(x)


def test_brighter_ninth_light_wins(addon: Addon) -> None:
    lamps = [add("POINT", f"Lamp {i}", 3 + i) for i in range(9)]
    assert "Lamp 8" not in slots(addon)
    lamps[8].data.energy = 1e6
    update()
    assert "Lamp 8" in slots(addon)
    assert "Lamp 7" not in slots(addon)
    lamps[7].location.x = 1.5
    update()
    assert "Lamp 7" in slots(addon)


def test_moving_a_light_needs_the_drivers_alone(
    addon: Addon, fits: list[str], painted: bpy.types.Object
) -> None:
    bpy.ops.mesh.primitive_cube_add(location=(5, 0, 0))
    lamp = add("POINT", "Lamp", 1)
    fits.clear()
    lamp.location.x = 7
    update()
    [(_, vector, _, _)] = addon("scene.carrier").values()
    assert round(vector.x, 5) == 7
    assert fits == []


def test_a_new_size_of_a_light_is_noticed(addon: Addon, painted: bpy.types.Object) -> None:
    sun, lamp = add("SUN", "A sun"), add("POINT", "Lamp", 1)
    sun.data.angle, lamp.data.shadow_soft_size = 0.2, 0.75
    update()
    sizes = [size for _, _, size, _ in addon("scene.carrier").values()]
    assert sizes == pytest.approx([math.sin(0.1), 0.75])


def test_an_object_that_is_painted_by_hand_sees_the_lights(
    addon: Addon, painted: bpy.types.Object, fits: list[str]
) -> None:
    lamp = add("POINT", "Lamp", 1)
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    assert not addon("scene.carrier").is_attached([cube])
    cube.data.materials.append(painted.active_material)
    update()
    lamp.location.x = 7
    update()
    path = addon("scene.carrier").path(1, addon("scene.carrier").POSITIONAL)
    for thing in (cube, painted):
        shown = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
        assert shown.path_resolve(path)[0] == 7
    fits.clear()
    update()
    assert fits == []


def test_a_light_that_moves_grows_or_brightens_leaves_the_paints_alone(
    addon: Addon, painted: bpy.types.Object
) -> None:
    """Blender prepares all paints anew that an update reaches."""
    lamp = add("POINT", "Lamp", 1)
    reached: set[str] = set()

    def note(_: object, depsgraph: bpy.types.Depsgraph) -> None:
        reached.update(update.id.name for update in depsgraph.updates)

    bpy.app.handlers.depsgraph_update_post.append(note)
    try:
        lamp.location.x, lamp.data.shadow_soft_size, lamp.data.energy = 2, 0.5, 5
        update()
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(note)
    assert "Lamp" in reached
    assert painted.active_material.name not in reached


def test_work_after_a_move_does_not_grow_with_the_scene(
    addon: Addon, painted: bpy.types.Object
) -> None:
    """Counted in steps of Python's own, whatever the handlers do."""
    lamp, empty = add("POINT", "Lamp", 1), bpy.data.objects.new("Empty", None)
    bpy.context.scene.collection.objects.link(empty)
    update()
    few = [steps_of_a_move(each) for each in (lamp, empty, painted)]
    for i in range(20):
        more = painted.copy()
        more.data, more.name = painted.data.copy(), f"Painted {i}"
        more.data.materials[0] = addon("paint.material").create(addon("paint").Paint(), f"{i}")
        bpy.context.scene.collection.objects.link(more)
    update()
    many = [steps_of_a_move(each) for each in (lamp, empty, painted)]
    assert max(few) > 0
    assert many == few


def steps_of_a_move(thing: bpy.types.Object) -> int:
    update()  # nothing is left to do
    steps = 0

    def trace(frame: FrameType, event: str, _: object) -> Callable:
        nonlocal steps
        frame.f_trace_opcodes = True
        steps += event == "opcode"
        return trace

    thing.location.y += 1
    before = sys.gettrace()
    sys.settrace(trace)
    try:
        update()
    finally:
        sys.settrace(before)
    return steps


def test_a_changed_paint_is_the_only_one_that_is_read(
    addon: Addon, painted: bpy.types.Object, monkeypatch: pytest.MonkeyPatch
) -> None:
    module, read = addon("paint.material"), []
    module.create(addon("paint").Paint(), "Other")
    update()
    paint_of = module.paint_of
    monkeypatch.setattr(module, "paint_of", lambda of: read.append(of.name) or paint_of(of))
    module.paint_node(painted.active_material).inputs["Tilt"].default_value = 0.2
    update()
    assert read == [painted.active_material.name]


def test_a_light_that_is_shown_and_moved_in_one_step_gets_a_slot(addon: Addon) -> None:
    """No update tells that it is no longer hidden, as it moved besides."""
    lamp = add("POINT", "Lamp", 1)
    lamp.hide_render = True
    update()
    assert slots(addon) == []
    lamp.location.x, lamp.hide_render = 2, False
    update()
    assert slots(addon) == ["Lamp"]


def test_a_step_of_a_live_slider_leaves_the_material_where_cycles_keeps_it(
    addon: Addon, painted: bpy.types.Object
) -> None:
    """A new look in the Solid view would have it compiled anew, in seconds."""
    live, shown = addon("paint.live"), painted.active_material
    node = addon("paint.material").paint_node(shown)
    live.begin(node, addon("paint.material").paint_of(node))
    update()
    for kept in (True, False):
        bpy.context.scene.render.use_persistent_data = kept
        update()
        before = tuple(shown.diffuse_color)
        live.set_value(node.inputs["Substrate Color"], (0.9, 0.1 + 0.2 * kept, 0.1))
        update()
        assert (tuple(shown.diffuse_color) == before) == kept


def test_world_and_neighbours_are_noticed(addon: Addon) -> None:
    bpy.context.scene.cycles.max_bounces = 0
    add("SUN", "Sun")
    assert "The flakes show no world" in addon("scene.needs").said()
    world = bpy.data.worlds.new("World")
    if world.node_tree is None:
        world.use_nodes = True  # Blender 4.5
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 1
    bpy.context.scene.world = world
    update()
    assert "The flakes also show the world" in addon("scene.needs").said()
    bpy.context.scene.world = None
    bpy.context.scene.cycles.max_bounces = 4
    bpy.ops.mesh.primitive_cube_add()
    assert "their neighbours" in addon("scene.needs").said()


def test_emitting_materials_are_noticed(addon: Addon) -> None:
    bpy.context.scene.cycles.max_bounces = 0
    bpy.ops.mesh.primitive_cube_add()
    glow = bpy.data.materials.new("Glow")
    if glow.node_tree is None:
        glow.use_nodes = True  # Blender 4.5
    bpy.context.object.data.materials.append(glow)
    update()
    assert "objects that may emit" not in addon("scene.needs").said()
    glow.node_tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 1
    update()
    assert "objects that may emit" in addon("scene.needs").said()


def test_nothing_is_fitted_twice_or_without_reason(fits: list[str]) -> None:
    add("SUN", "Sun")
    assert len(fits) == 1
    update()
    bpy.context.scene.render.resolution_x = 17
    bpy.context.scene.frame_set(7)
    update()
    assert len(fits) == 1


def test_files_without_paint_are_left_alone(addon: Addon, fits: list[str]) -> None:
    bpy.ops.wm.read_homefile(use_empty=True)
    add("SUN", "Sun")
    assert fits == []
    assert not bpy.data.node_groups


def test_saved_file_has_its_lights(addon: Addon, tmp_path: Path) -> None:
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    bpy.context.scene.collection.objects.link(lamp)  # and no update
    file = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    assert slots(addon) == ["Sun"]


def test_saved_file_knows_where_its_lights_stand(addon: Addon, tmp_path: Path) -> None:
    lamps = [add("POINT", f"Lamp {i}", 3 + i) for i in range(9)]
    lamps[8].location.x = 1.5  # and no update
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    assert "Lamp 8" in slots(addon)


def test_opened_file_is_fitted_if_it_was_changed_elsewhere(addon: Addon, tmp_path: Path) -> None:
    addon_utils.disable(NAME)
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    bpy.context.scene.collection.objects.link(lamp)
    file = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    addon_utils.enable(NAME)
    assert addon("scene.carrier").values() == []
    bpy.ops.wm.open_mainfile(filepath=file)
    assert slots(addon) == ["Sun"]


def test_other_painted_scene_gets_its_own_lights(addon: Addon, painted: bpy.types.Object) -> None:
    add("SUN", "Sun")
    bpy.context.window.scene = bpy.data.scenes.new("Other")
    bpy.context.scene.collection.objects.link(painted)
    update()
    assert addon("scene.carrier").values() == []
    bpy.context.window.scene = bpy.data.scenes["Scene"]
    bpy.ops.object.empty_add()
    assert slots(addon) == ["Sun"]


def test_scene_without_paint_leaves_the_lights_to_the_one_that_was_fitted(
    addon: Addon, painted: bpy.types.Object, tmp_path: Path
) -> None:
    other = bpy.data.scenes.new("A second one")
    other.collection.objects.link(painted)
    add("SUN", "Sun")
    bpy.context.window.scene = bpy.data.scenes.new("A cut")
    bpy.ops.object.empty_add()
    assert slots(addon) == ["Sun"]
    lamp = bpy.data.objects.new("Late", bpy.data.lights.new("Late", "POINT"))
    bpy.data.scenes["Scene"].collection.objects.link(lamp)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    assert slots(addon) == ["Late", "Sun"]


def test_nothing_happens_while_rendering(
    addon: Addon, fits: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(addon("scene.follow"), "REST_SECONDS", 0)
    scene = bpy.context.scene
    bpy.ops.object.camera_add(location=(0, 0, 5))
    scene.camera = bpy.context.object
    bpy.ops.scene.metallic_paint_use_osl()
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.cycles.samples, scene.frame_end = 1, 2
    during: list[int] = []

    def watch(*_: object) -> None:
        before = len(fits)
        scene.world = bpy.data.worlds.new("World")
        call("depsgraph_update_post")
        addon("scene.follow").follow()
        during.append(len(fits) - before)

    bpy.app.handlers.render_pre.append(watch)
    try:
        bpy.ops.render.render(animation=True)
    finally:
        bpy.app.handlers.render_pre.remove(watch)
    assert during == [0, 0]
    assert fits


@pytest.fixture
def jobs(addon: Addon, monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """A Blender with a window, as the add-on sees it: the jobs that it runs."""
    running: set[str] = set()
    app = SimpleNamespace(
        background=False, timers=bpy.app.timers, is_job_running=lambda kind: kind in running
    )
    with_window = SimpleNamespace(app=app, context=bpy.context, data=bpy.data, types=bpy.types)
    monkeypatch.setattr(addon("scene.follow"), "bpy", with_window)
    return running


def test_an_instance_that_no_driver_follows_is_renewed_in_each_frame_of_a_render(
    addon: Addon, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The frames of an animation are the pictures that are rendered there."""
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("Corners")
    mesh.from_pydata([(0, 0, 0), (0.5, 0, 0)], [], [])
    corners = bpy.data.objects.new("Corners", mesh)
    scene.collection.objects.link(corners)
    lamp = add("POINT", "Lamp")
    lamp.parent, corners.instance_type, lamp.data.energy = corners, "VERTS", 500
    for frame, x in ((1, -2.0), (2, 0.0)):
        corners.location = (x, 0, 4)
        corners.keyframe_insert("location", frame=frame)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location.z = 5
    scene.collection.objects.link(camera)
    scene.camera = camera
    addon("paint.material").set_up_cycles(scene)
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    scene.render.resolution_x = scene.render.resolution_y = 32
    addon("verify.probe").write_floats(scene, "OPEN_EXR")
    scene.frame_start, scene.frame_end = 1, 2
    update()  # a new frame tells no handler of what else changed
    scene.frame_set(1)
    carrier, probe = addon("scene.carrier"), addon("verify.probe")
    assert len(carrier.not_followed()) == 2
    scene.render.filepath = str(tmp_path / "frame")
    bpy.ops.render.render(animation=True)
    film = [read(tmp_path / f"frame{frame:04}.exr") for frame in (1, 2)]
    for frame in (1, 2):
        scene.frame_set(frame)
        assert carrier.values()[0][1].x == pytest.approx((-2, 0)[frame - 1])
        np.testing.assert_array_equal(probe.render(scene)[::-1], film[frame - 1])
    values = carrier.values()
    carrier.renew(1, placed_at(addon, lamp, corners, -2))
    assert carrier.values() != values
    monkeypatch.setattr(addon("scene.lights"), "renew", lambda _: None)
    assert (probe.render(scene)[::-1] != film[1]).any()  # or the place would not matter


def test_an_animated_sky_is_followed_from_frame_to_frame(addon: Addon) -> None:
    scene, world = bpy.context.scene, bpy.data.worlds.new("World")
    if world.node_tree is None:
        world.use_nodes = True  # Blender 4.5
    tree = world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    tree.links.new(sky.outputs[0], tree.nodes["Background"].inputs["Color"])
    for frame, up in ((1, 0.2), (10, 1.2)):
        sky.sun_elevation = up
        sky.keyframe_insert("sun_elevation", frame=frame)
    scene.world = world
    update()
    for frame, up in ((1, 0.2), (10, 1.2)):
        scene.frame_set(frame)
        [(_, towards, _, _)] = addon("scene.carrier").values()
        assert math.asin(towards.z) == pytest.approx(up, abs=1e-5)


def placed_at(addon: Addon, lamp: bpy.types.Object, corners: bpy.types.Object, x: float) -> object:
    return addon("scene.placed").Placed(lamp, Matrix.Translation((x, 0, 4)), corners, (0,), False)


def read(file: Path) -> np.ndarray:
    return OpenImageIO.ImageBuf(str(file)).get_pixels(OpenImageIO.FLOAT)[..., :3]


def test_with_a_window_the_timer_fits_once_the_scene_rests(
    addon: Addon, fits: list[str], jobs: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    follow = addon("scene.follow")
    assert bpy.app.timers.is_registered(follow.follow)
    add("SUN", "Sun")
    add("SUN", "Sun 2")
    assert follow.follow() == follow.REST_SECONDS
    assert fits == []
    monkeypatch.setattr(follow, "REST_SECONDS", 0)
    follow.follow()
    follow.follow()
    assert slots(addon) == ["Sun", "Sun 2"]
    assert len(fits) == 1


def test_with_a_window_another_scene_in_it_is_fitted(
    addon: Addon, painted: bpy.types.Object, jobs: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    follow = addon("scene.follow")
    monkeypatch.setattr(follow, "REST_SECONDS", 0)
    add("SUN", "Sun")
    other = bpy.data.scenes.new("Other")
    other.collection.objects.link(painted)
    other.collection.objects.link(bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "SPOT")))
    follow.follow()
    assert slots(addon) == ["Sun"]
    bpy.context.window.scene = other
    follow.follow()
    assert slots(addon) == ["Lamp"]


def test_a_file_that_was_open_before_the_add_on_is_fitted(
    addon: Addon, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(addon("scene.follow"), "REST_SECONDS", 0)
    addon_utils.disable(NAME)
    add("SUN", "Sun")
    addon_utils.enable(NAME)
    assert slots(addon) == []
    addon("scene.follow").follow()
    assert slots(addon) == ["Sun"]


def test_scripts_may_clear_what_calls_the_add_on(addon: Addon) -> None:
    for name in ("depsgraph_update_post", "blend_import_post"):
        calls = getattr(bpy.app.handlers, name)
        for each in [each for each in calls if each.__module__.startswith(NAME)]:
            calls.remove(each)
    bpy.app.timers.unregister(addon("scene.follow").follow)
    addon_utils.disable(NAME)
    assert addon_utils.enable(NAME) is not None
    add("SUN", "Sun")
    assert slots(addon) == ["Sun"]


def test_an_error_is_told_once_and_does_not_end_the_timer(
    addon: Addon,
    painted: bpy.types.Object,
    jobs: set[str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    follow, needs = addon("scene.follow"), addon("scene.needs")
    monkeypatch.setattr(follow, "REST_SECONDS", 0)

    def fail(scene: bpy.types.Scene) -> None:
        raise ValueError("a lamp of lead")

    with monkeypatch.context() as broken:
        broken.setattr(needs, "fit", fail)
        for name in ("Sun", "Sun 2"):
            add("SUN", name)
            assert follow.follow() == follow.REST_SECONDS  # Blender calls it again
        assert slots(addon) == []
        said = capsys.readouterr().err
        assert said.count("Traceback") == 1
        assert said.count("could not follow the last change (a lamp of lead)") == 1
        bpy.context.view_layer.objects.active = painted
        shown = " ".join(drawn(bpy.types.MATERIAL_PT_metallic_paint).texts)
        assert "The lights could not follow the last change" in shown
    add("SUN", "Sun 3")
    follow.follow()
    assert slots(addon) == ["Sun", "Sun 2", "Sun 3"]
    assert follow.trouble() == ""
    shown = " ".join(drawn(bpy.types.MATERIAL_PT_metallic_paint).texts)
    assert "could not follow" not in shown


def test_a_direct_fit_is_not_answered_by_another(addon: Addon, fits: list[str]) -> None:
    add("SUN", "Sun")
    fits.clear()
    bpy.ops.scene.metallic_paint_update_lights()
    assert len(fits) == 1


def test_lights_that_stay_keep_their_drivers(addon: Addon) -> None:
    add("SUN", "Sun")
    fed = addon("scene.carrier").only()
    drivers = [curve.as_pointer() for curve in fed.animation_data.drivers]
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.scene.metallic_paint_update_lights()
    assert [curve.as_pointer() for curve in fed.animation_data.drivers] == drivers
    add("POINT", "Lamp")
    assert len(fed.animation_data.drivers) == 2 * len(drivers)


def test_with_a_window_the_job_tells_that_a_render_ended(
    addon: Addon, jobs: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(addon("scene.follow"), "REST_SECONDS", 0)
    jobs.add("RENDER")
    call("render_init")
    add("SUN", "Sun")
    addon("scene.follow").follow()
    assert slots(addon) == []
    jobs.clear()  # it failed: neither render_complete nor render_cancel
    addon("scene.follow").follow()
    assert slots(addon) == ["Sun"]


@pytest.mark.parametrize("by", ["saving", "loading"])
def test_a_render_that_tells_no_end_ends_with_the_next_file(
    addon: Addon, by: str, tmp_path: Path
) -> None:
    file = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    call("render_init")
    add("SUN", "Sun")
    assert slots(addon) == []
    if by == "saving":
        bpy.ops.wm.save_as_mainfile(filepath=file)
    else:
        bpy.ops.wm.open_mainfile(filepath=file)
        add("SUN", "Sun")
    assert slots(addon) == ["Sun"]


def test_another_scene_is_rendered_with_its_own_lights(
    addon: Addon, painted: bpy.types.Object
) -> None:
    add("SUN", "Sun")
    other = bpy.data.scenes.new("Other")
    lamp = bpy.data.objects.new("Theirs", bpy.data.lights.new("Theirs", "POINT"))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    for thing in (painted, lamp, camera):
        other.collection.objects.link(thing)
    other.camera = camera
    addon("paint.material").set_up_cycles(other)
    other.render.resolution_x = other.render.resolution_y = other.cycles.samples = 1
    assert slots(addon) == ["Sun"]
    during: list[list[str]] = []

    def watch(*_: object) -> None:
        during.append(slots(addon))

    bpy.app.handlers.render_pre.append(watch)
    try:
        bpy.ops.render.render(scene="Other")
    finally:
        bpy.app.handlers.render_pre.remove(watch)
    assert during == [["Theirs"]]
    assert slots(addon) == ["Sun"]


def step(message: str) -> None:
    """Of undo, after Blender's own update."""
    update()
    bpy.ops.ed.undo_push(message=message)


def undo_and_redo(seen: Callable[[], object], states: Sequence[object]) -> None:
    """Back to the first of the states, each of one step, and to the last again."""
    for expected in states[-2::-1]:
        assert bpy.ops.ed.undo() == {"FINISHED"}
        assert seen() == expected
    for expected in states[1:]:
        assert bpy.ops.ed.redo() == {"FINISHED"}
        assert seen() == expected


def test_undo_and_redo_bring_lights_and_paints_back(
    addon: Addon, painted: bpy.types.Object
) -> None:
    for name in ("Nothing yet", "Still nothing"):  # the first makes undo possible
        step(name)
    add("POINT", "Lamp", 1)
    step("Add")
    bpy.data.objects["Lamp"].location.x = 4
    step("Move")
    bpy.data.objects.remove(bpy.data.objects["Lamp"])
    step("Delete")
    places = [[], [1], [4], []]

    def seen() -> list[int]:
        values = addon("scene.carrier").values()
        assert addon("scene.needs").is_fitted(bpy.context.scene)
        assert len(values) == len(slots(addon))
        return [round(vector.x) for _, vector, _, _ in values]

    undo_and_redo(seen, places)


def test_undo_takes_a_paint_away_and_redo_brings_it_back(addon: Addon) -> None:
    for name in ("Nothing yet", "Still nothing"):
        bpy.ops.ed.undo_push(message=name)
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.ed.undo_push(message="Cube")
    bpy.ops.material.metallic_paint_new(preset="gold")
    bpy.ops.ed.undo_push(message="Paint")
    bpy.ops.ed.undo()
    assert bpy.context.object.active_material is None
    bpy.ops.ed.redo()
    paint = addon("paint.material").paint_of(bpy.context.object.active_material)
    assert paint == addon("paint.presets").load("gold")


def test_undo_and_redo_bring_live_values_back(addon: Addon, painted: bpy.types.Object) -> None:
    """Of a paint and of its copy, also where no fit comes between steps, as while it renders."""
    live, material = addon("paint.live"), addon("paint.material")

    def node() -> bpy.types.ShaderNodeGroup:
        return material.paint_node(bpy.context.object.active_material)

    def seen() -> tuple[str, bool, bool, float]:
        assert addon("scene.needs").is_fitted(bpy.context.scene)
        tilt = live.value(node().inputs["Tilt"])
        name = bpy.context.object.active_material.name
        return name, live.is_live(node()), live.is_shared(node()), round(tilt, 6)

    for name in ("Nothing yet", "Still nothing"):
        step(name)
    first = seen()
    bpy.ops.material.metallic_paint_live()
    step("Live")
    states = [first, seen()]
    live.set_value(node().inputs["Tilt"], 0.3)
    step("Value")
    states.append(seen())
    call("render_init")
    bpy.context.object.active_material = bpy.context.object.active_material.copy()
    step("Copy")
    bpy.context.object.location.x = 1
    step("Move")
    call("render_complete")
    states += [seen()] * 2
    bpy.ops.material.metallic_paint_live_single()
    step("Single")
    states.append(seen())
    live.set_value(node().inputs["Tilt"], 0.4)
    step("Value of the copy")
    states.append(seen())
    bpy.ops.material.metallic_paint_live()
    step("Off")
    states.append(seen())
    assert [each[1:] for each in states] == [
        (False, False, 0.15), (True, False, 0.15), (True, False, 0.3), (True, True, 0.3),
        (True, True, 0.3), (True, False, 0.3), (True, False, 0.4), (False, False, 0.4),
    ]  # fmt: skip
    for _ in range(2):
        undo_and_redo(seen, states)


@pytest.mark.parametrize("step", ["undo", "redo"])
def test_what_undo_may_free_is_not_pointed_at(addon: Addon, step: str) -> None:
    lamp, carrier, needs = add("POINT", "Lamp", 1), addon("scene.carrier"), addon("scene.needs")
    before = carrier.values()
    call(f"{step}_pre")
    assert not carrier.only().animation_data
    assert not needs.is_fitted(bpy.context.scene)
    assert carrier.values() == before
    bpy.data.objects.remove(lamp)
    add("POINT", "Other", 2)
    call(f"{step}_post")
    assert needs.is_fitted(bpy.context.scene)
    assert slots(addon) == ["Other"]
    assert carrier.only().animation_data.drivers


def test_the_solid_view_follows_the_paint_unless_its_owner_chose_a_look(
    addon: Addon, painted: bpy.types.Object
) -> None:
    shown = painted.active_material
    socket = addon("paint.material").paint_node(shown).inputs["Substrate Color"]
    before = tuple(shown.diffuse_color)
    socket.default_value = (0.9, 0.1, 0.1, 1)
    update()
    red, green, _, _ = shown.diffuse_color
    assert red - green > 0.05 + before[0] - before[1]
    shown.diffuse_color = (0, 1, 0, 1)
    socket.default_value = (0.1, 0.1, 0.9, 1)
    update()
    assert tuple(shown.diffuse_color) == (0, 1, 0, 1)
