# SPDX-License-Identifier: Apache-2.0
"""The check of an artist's own scene: what it finds, what it leaves alone, and how it ends."""

from __future__ import annotations

import dataclasses
import json
import math
import re
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import panels
import pytest
from metallic_paint import verify
from metallic_paint.interface import verify as interface
from metallic_paint.native import core_missing
from metallic_paint.paint import material, presets, shader
from metallic_paint.scene import lights, needs
from metallic_paint.verify import check
from metallic_paint.verify import job as verify_job
from metallic_paint.verify.check import VerifyError, as_found
from metallic_paint.verify.job import PICTURES, Job, painted_of, run, why_not
from metallic_paint.verify.process import find
from recording import drawn
from scenery import add_lamp, link_namesake, link_paint, nest_paint, show_as_instance

SIZE = 40


@pytest.fixture
def registered() -> Iterator[None]:
    with panels.registered(interface):
        yield


def build() -> bpy.types.Scene:
    """A scene as artists have them: floor, world, area light, bump, three lamps, denoising."""
    scene = bpy.context.scene
    material.set_up_cycles(scene)
    scene.render.resolution_x, scene.render.resolution_y = 640, 360
    bpy.ops.mesh.primitive_plane_add(size=1, location=(0, 0, -0.03))  # without a material
    bpy.ops.mesh.primitive_cube_add(size=0.01, location=(0.02, -0.02, 0.02))
    bpy.context.object.data.materials.append(bpy.data.materials.new("Box"))
    bpy.ops.mesh.primitive_monkey_add(size=0.06)
    bpy.context.object.name = "Monkey"
    bpy.ops.object.shade_smooth()
    paint = material.create(presets.load("silver-coarse"))
    material.assign(bpy.context.object, paint)
    node, tree = material.paint_node(paint), paint.node_tree
    noise = tree.nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value = 4
    bump = tree.nodes.new("ShaderNodeBump")
    bump.inputs["Strength"].default_value = 0.1
    tree.links.new(noise.outputs[0], bump.inputs["Height"])
    tree.links.new(bump.outputs[0], node.inputs[material.NORMAL])
    node.inputs["Frame"].default_value = 7
    add_lamp("SUN", "Sun", energy=3, angle=math.radians(0.53), rotation_euler=(0.9, 0.2, 0))
    add_lamp("POINT", "Point", energy=1, shadow_soft_size=0.01, location=(-0.2, -0.3, 0.3))
    spot = {"location": (0.3, -0.4, 0.3), "rotation_euler": (0.9, 0, 0.65)}
    add_lamp("SPOT", "Spot", energy=2, shadow_soft_size=0.01, spot_size=1, **spot)
    add_lamp("AREA", "Area", energy=1, location=(0, 0, 1))
    scene.world = bpy.data.worlds.new("World")
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -0.3, 0.1), (math.radians(72), 0, 0)
    camera.data.dof.use_dof = True
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.cycles.use_denoising = True
    scene.cycles.film_exposure = 3
    return scene


def state() -> list:
    """Of what a check might change in the file."""
    bpy.context.view_layer.update()
    seen = []
    for scene in bpy.data.scenes:
        for of in (scene.render, scene.cycles, scene.view_layers[0]):
            for prop in of.bl_rna.properties:
                if prop.type in ("BOOLEAN", "INT", "FLOAT", "ENUM", "STRING"):
                    value = getattr(of, prop.identifier)
                    seen.append(
                        (prop.identifier, str(value[:] if hasattr(value, "__len__") else value))
                    )
        seen += [(thing.name, thing.hide_render, thing.is_holdout, str(thing.matrix_world),
                  [slot.material and slot.material.name for slot in thing.material_slots])
                 for thing in scene.objects]  # fmt: skip
        seen.append((scene.world.name, scene.camera.data.dof.use_dof))
    for each in bpy.data.materials:
        tree = each.node_tree
        seen.append((each.name, [(link.from_node.name, link.to_node.name) for link in tree.links]
                     if tree else None))  # fmt: skip
    node = material.paint_node(bpy.data.objects["Monkey"].active_material)
    seen += [str(getattr(s, "default_value", None)) for s in node.inputs if s.type != "RGBA"]
    return seen


def test_an_artists_scene_agrees_and_stays_as_it_is(registered: None) -> None:
    scene = build()
    before = state()
    assert bpy.ops.scene.metallic_paint_verify(size=SIZE) == {"FINISHED"}
    assert state() == before
    text = "\n".join(drawn(interface.MATERIAL_PT_metallic_paint_verify).texts)
    assert "Monkey, Metallic Paint (Scene): pixels " in text
    assert "agree with the core" in text
    assert "DO NOT" not in text
    shown, wanted, difference = (
        np.array(bpy.data.images[f"Metallic Paint {name}"].pixels).reshape(SIZE, SIZE, 4)[..., :3]
        for name in PICTURES
    )
    # Seen 21, as a sample shows one of a pixel's cells; of a Poisson law of that mean, 5 or fewer
    # come once in 30,000 draws.
    assert (shown.max(axis=-1) > 0).sum() > 5
    np.testing.assert_allclose(difference, 100 * np.abs(shown - wanted), atol=1e-4 * shown.max())
    assert scene.name in bpy.data.scenes


@pytest.mark.long
def test_the_numbers_are_those_of_every_pixel() -> None:
    scene = build()
    found = run(scene, scene.objects["Monkey"], SIZE)
    assert found.agrees, str(found)
    left, bottom, right, top = found.region
    assert (right - left, top - bottom) == (SIZE, SIZE)
    assert found.same_count / found.pixels > 0.999
    assert found.pixels > SIZE * SIZE
    assert found.worst_error < 1e-2
    assert found.notes[-1].startswith("The core is metallic_paint_core")


@pytest.mark.long
def test_a_paint_that_is_new_in_every_frame_agrees_at_the_scenes_frame() -> None:
    scene = build()
    node = material.paint_node(scene.objects["Monkey"].active_material)
    node.inputs[material.NEW_IN_EVERY_FRAME].default_value = True
    needs.fit(scene)
    for frame in (12, 13):
        scene.frame_set(frame)
        found = run(scene, scene.objects["Monkey"], SIZE)
        assert found.agrees, str(found)


@pytest.mark.long
def test_links_are_told_and_their_sockets_values_are_checked() -> None:
    scene = build()
    paint = scene.objects["Monkey"].active_material
    checker = paint.node_tree.nodes.new("ShaderNodeTexChecker")
    node = material.paint_node(paint)
    paint.node_tree.links.new(checker.outputs["Color"], node.inputs["Flake Color"])
    found = run(scene, scene.objects["Monkey"], SIZE)
    assert found.agrees, str(found)
    assert "what is linked to Flake Color" in found.notes[0]


@pytest.mark.long
def test_a_wrong_core_is_found_out(tmp_path: Path) -> None:
    """The check of one process, where the core takes another paint than the shader."""
    scene = build()
    thing = scene.objects["Monkey"]
    other = check.core_paint
    check.core_paint = lambda paint, frame: other(paint, frame + 1)
    try:
        values = check.check(scene, thing, thing.active_material, SIZE, tmp_path, lambda *_: None)
    finally:
        check.core_paint = other
    found = as_found(json.loads(json.dumps(values)))
    assert not found.agrees
    assert found.unexplained > 10
    assert "DO NOT agree" in str(found)


@pytest.mark.long
def test_a_wrong_core_under_the_sparkles_is_found_out(tmp_path: Path) -> None:
    scene = build()
    thing = scene.objects["Monkey"]
    other = check.core_paint
    brighter = {"substrate_color": (0.5, 0.5, 0.5)}
    check.core_paint = lambda paint, frame: other(dataclasses.replace(paint, **brighter), frame)
    try:
        values = check.check(scene, thing, thing.active_material, SIZE, tmp_path, lambda *_: None)
    finally:
        check.core_paint = other
    found = as_found(json.loads(json.dumps(values)))
    assert found.unexplained == 0
    assert found.worst_under > 1e-2
    assert not found.agrees


@pytest.mark.long
def test_lamps_that_share_a_name_are_lit_one_by_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = build()
    for name in ("Sun", "Spot", "Area"):
        bpy.data.objects.remove(scene.objects[name])
    own = scene.objects["Point"]
    linked = link_namesake(own, tmp_path / "lamps.blend")
    own.location.x = 0.2
    hidden = add_lamp("POINT", "Hidden", location=(0.2, -0.3, 0.3), hide_render=True)
    hidden.animation_data_create()  # may show it in another frame
    for lamp in (linked, own):
        assert find("objects", lamp.name_full) == lamp
    lit = []
    image = check._Probe.image

    def watched(probe: object, diagnostic: int, *rest: int) -> np.ndarray:
        if diagnostic == verify.SPARKLES:
            lit.append([lamp for lamp in (own, linked, hidden) if not lamp.hide_render])
        return image(probe, diagnostic, *rest)

    monkeypatch.setattr(check._Probe, "image", watched)
    thing = scene.objects["Monkey"]
    check.check(scene, thing, thing.active_material, SIZE, tmp_path, lambda *_: None)
    assert sorted(lit, key=lambda lamps: lamps != [own]) == [[own], [linked]]


@pytest.mark.long
def test_progress_is_told_and_a_stopped_job_leaves_nothing() -> None:
    scene = build()
    job = Job(scene, scene.objects["Monkey"], SIZE)
    try:
        end = time.monotonic() + 120
        while job.progress == 0 and time.monotonic() < end:
            assert not job.poll()
            time.sleep(0.05)
        assert 0 < job.progress < 1
        assert job.what.startswith("Picture")
    finally:
        job.close()
    assert job._process.returncode != 0
    assert not job.folder.exists()


class Manager(dict):
    """The window manager of a Blender that has windows: headless, it has none."""

    windows = ()

    def event_timer_remove(self, timer: object) -> None:
        pass

    def progress_update(self, share: float) -> None:
        assert 0 <= share <= 1

    def progress_end(self) -> None:
        self["ended"] = True


@pytest.fixture
def operator() -> Iterator[SimpleNamespace]:
    """The running operator, with events from the test."""
    cls = interface.SCENE_OT_metallic_paint_verify
    context = SimpleNamespace(window_manager=Manager())
    running = SimpleNamespace(_timer=None, reported=[])
    running.report = lambda kind, text: running.reported.append(text)
    running.cancel = lambda of: cls.cancel(running, of)
    running.send = lambda kind, value="PRESS": cls.modal(
        running, context, SimpleNamespace(type=kind, value=value)
    )
    yield running
    while interface._running:
        interface._running.pop().close()


@pytest.mark.long
def test_the_modal_operator_lets_the_interface_live_until_it_is_done(
    registered: None, operator: SimpleNamespace
) -> None:
    scene = build()
    interface._running.append(Job(scene, scene.objects["Monkey"], SIZE))
    assert operator.send("MOUSEMOVE") == {"PASS_THROUGH"}
    assert "Esc stops" in drawn(interface.MATERIAL_PT_metallic_paint_verify).texts[-1]
    end = time.monotonic() + 120
    while (said := operator.send("TIMER")) == {"PASS_THROUGH"} and time.monotonic() < end:
        time.sleep(0.05)
    assert said == {"FINISHED"}
    assert "agree with the core" in operator.reported[0]
    assert not interface._running
    assert "Metallic Paint Core" in bpy.data.images


def failing(error: Exception) -> tuple[SimpleNamespace, list[bool]]:
    """A job that fails at its end, and whether it was closed."""

    def pictures() -> None:
        raise error

    closed: list[bool] = []
    close = lambda: closed.append(True)  # noqa: E731
    return SimpleNamespace(poll=lambda: True, pictures=pictures, close=close), closed


@pytest.mark.long
@pytest.mark.parametrize("error", [FileNotFoundError("a folder"), VerifyError("cut off")])
def test_a_check_that_fails_at_its_end_makes_room_for_the_next(
    operator: SimpleNamespace, error: Exception
) -> None:
    job, closed = failing(error)
    interface._running.append(job)
    assert operator.send("TIMER") == {"CANCELLED"}
    assert operator.reported == [str(error)]
    assert closed
    assert not interface._running


@pytest.mark.long
def test_an_error_of_ours_is_not_swallowed_and_makes_room_too(operator: SimpleNamespace) -> None:
    job, closed = failing(ValueError("a bug"))
    interface._running.append(job)
    with pytest.raises(ValueError, match="a bug"):
        operator.send("TIMER")
    assert operator.reported == []
    assert closed
    assert not interface._running


@pytest.mark.long
@pytest.mark.parametrize("left", [None, b"", b"\x93NUMPY\x01\x00", b"cut off"])
def test_pictures_that_are_not_whole_are_told(tmp_path: Path, left: bytes | None) -> None:
    if left is not None:
        (tmp_path / "pictures.npy").write_bytes(left)
    with pytest.raises(VerifyError, match="The pictures of the check cannot be read"):
        Job.pictures(SimpleNamespace(folder=tmp_path))


@pytest.mark.long
def test_a_scene_that_cannot_be_copied_is_told(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    scene = build()
    folder = tmp_path / "job"
    folder.mkdir()
    (folder / "scene.blend").mkdir()  # where the copy should go
    monkeypatch.setattr("tempfile.mkdtemp", lambda **_: str(folder))
    with pytest.raises(VerifyError, match="The scene cannot be copied for the check"):
        Job(scene, scene.objects["Monkey"], SIZE)
    assert not folder.exists()


@pytest.mark.long
def test_an_error_in_the_other_blender_comes_with_its_traceback(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = build()
    modules = verify_job._modules()
    broken = tmp_path / "metallic_paint_core.py"
    broken.write_text("raise ValueError('a bug')")
    modules["metallic_paint_core"] = str(broken)
    monkeypatch.setattr(verify_job, "_modules", lambda: modules)
    with pytest.raises(VerifyError, match=r"The other Blender ended: .*ValueError: a bug"):
        run(scene, scene.objects["Monkey"], SIZE)
    assert "Traceback" in capsys.readouterr().err


@pytest.mark.long
def test_escape_stops_the_modal_operator(operator: SimpleNamespace) -> None:
    scene = build()
    job = Job(scene, scene.objects["Monkey"], SIZE)
    interface._running.append(job)
    assert operator.send("ESC", "RELEASE") == {"PASS_THROUGH"}  # of the key that closed a menu
    assert operator.send("ESC") == {"CANCELLED"}
    assert not interface._running
    assert not job.folder.exists()
    assert job._process.returncode is not None


def test_what_shows_as_instances_alone_is_said() -> None:
    scene = build()
    thing = scene.objects["Monkey"]
    thing.hide_render = True
    with pytest.raises(VerifyError, match=r"Monkey does not render\."):
        run(scene, thing, SIZE)
    thing.hide_render = False
    show_as_instance(thing)
    with pytest.raises(VerifyError, match="but as instances, of which nothing can"):
        run(scene, thing, SIZE)


@pytest.mark.long
@pytest.mark.parametrize(  # each is two minutes: Blender compiles a linked paint for each picture
    "what",
    [
        "material",
        "object",
        "override",
    ],
)
def test_a_linked_paint_is_checked_under_the_lights_of_this_file(tmp_path: Path, what: str) -> None:
    scene = build()
    thing = scene.objects["Monkey"]
    if what == "material":
        link_paint(thing, tmp_path / "theirs.blend")
    else:
        file = str(tmp_path / "theirs.blend")
        thing.asset_mark()
        needs.fit(scene)
        bpy.data.libraries.write(file, {thing})
        bpy.data.objects.remove(thing)
        for each in (*bpy.data.materials, *bpy.data.node_groups):
            bpy.data.batch_remove([each])
        with bpy.data.libraries.load(file, link=True) as (_, here):
            here.objects = ["Monkey"]
        [thing] = here.objects
        scene.collection.objects.link(thing)
        if what == "override":
            thing = thing.override_create(remap_local_usages=True)
    needs.fit(scene)
    assert lights.linked_groups()
    assert why_not(scene, thing) == ""
    found = run(scene, thing, SIZE)
    assert found.agrees, str(found)
    assert found.pixels > 100


@pytest.mark.long
def test_a_linked_paint_is_refused_where_it_keeps_the_lights_of_its_file(
    tmp_path: Path,
) -> None:
    scene = build()
    thing = scene.objects["Monkey"]
    lights.node_group()["metallic_paint_looks"] = False
    link_paint(thing, tmp_path / "theirs.blend")
    said = why_not(scene, thing)
    assert re.search(r"linked from .*theirs\.blend and keeps its lights: check it in that", said)
    with pytest.raises(VerifyError, match="keeps its lights"):
        run(scene, thing, SIZE)


def nest_with_tilt(painted: bpy.types.Material, tilt: float) -> None:
    """The paint into a group of the artist's, which has its tilt as an input."""
    paint = material.paint_of(painted)
    nest_paint(painted)
    node = material.paint_node(painted)
    assert material.is_within_group(node)
    material.apply(node, paint)
    group = node.id_data
    group.interface.new_socket("How rough", in_out="INPUT", socket_type="NodeSocketFloat")
    group.links.new(group.nodes.new("NodeGroupInput").outputs["How rough"], node.inputs["Tilt"])
    [outer] = [each for each in painted.node_tree.nodes if each.type == "GROUP"]
    outer.inputs["How rough"].default_value = tilt


@pytest.mark.long
def test_a_paint_within_a_node_group_is_checked_with_what_the_group_is_given() -> None:
    scene = build()
    thing = scene.objects["Monkey"]
    nest_with_tilt(thing.active_material, 0.07)
    assert why_not(scene, thing) == ""
    found = run(scene, thing, SIZE)
    assert found.agrees, str(found)
    assert found.pixels > 100
    assert "Checked as the paint alone, out of the group Mine." in str(found)
    assert "linked to" not in str(found)

    painted = painted_of(thing)
    other = material.create(presets.load("gold"))
    thing.data.materials.append(other)
    assert painted_of(thing) == painted
    check._freeze(painted, scene.view_layers[0])
    node = material.paint_node(painted)
    assert not material.is_within_group(node)
    assert material.paint_of(node) == dataclasses.replace(presets.load("silver-coarse"), tilt=0.07)


def test_what_cannot_be_checked_is_said(registered: None, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = build()
    plane = scene.objects["Plane"]
    bpy.context.view_layer.objects.active = plane
    with pytest.raises(RuntimeError, match="Select an object with a metallic paint"):
        bpy.ops.scene.metallic_paint_verify()
    thing = bpy.context.view_layer.objects.active = scene.objects["Monkey"]
    node = material.paint_node(thing.active_material)
    node.inputs["Tilt"].default_value = 1000
    with pytest.raises(RuntimeError, match=r"tilt is 1000, but must be from"):
        bpy.ops.scene.metallic_paint_verify()
    node.inputs["Tilt"].default_value = 0.1
    node.node_tree["metallic_paint_source"] = "of yesterday"
    with pytest.raises(VerifyError, match="of an older version"):
        run(scene, thing, SIZE)
    node.node_tree["metallic_paint_source"] = material.digest(shader.source())
    for lamp in [each for each in scene.objects if each.type == "LIGHT"]:
        bpy.data.objects.remove(lamp)
    with pytest.raises(VerifyError, match="No sun, spot, point or area light renders"):
        run(scene, thing, SIZE)
    with pytest.raises(RuntimeError, match="No sun, spot, point or area light renders"):
        bpy.ops.scene.metallic_paint_verify()
    scene.camera = None
    with pytest.raises(RuntimeError, match="The scene has no camera"):
        bpy.ops.scene.metallic_paint_verify()
    monkeypatch.setitem(sys.modules, "metallic_paint_core", None)
    with pytest.raises(RuntimeError, match=r"no native module .* The paint works without it"):
        bpy.ops.scene.metallic_paint_verify()
    shown = " ".join(drawn(interface.MATERIAL_PT_metallic_paint_verify).texts)
    assert "no native module" in shown
    assert "works without it" in shown


def test_why_a_native_module_does_not_load_is_said(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """As on a Linux that is older than the one that built it."""
    (tmp_path / "metallic_paint_core.py").write_text("raise ImportError('GLIBC too old')")
    monkeypatch.delitem(sys.modules, "metallic_paint_core", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    assert core_missing() == (
        "The native module metallic_paint_core cannot be loaded: GLIBC too old."
    )
