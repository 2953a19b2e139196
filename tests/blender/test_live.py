# SPDX-License-Identifier: Apache-2.0
"""Live sliders: the same pixels, nothing compiled for a step, and values that stay with their paint
wherever it goes."""

from __future__ import annotations

import dataclasses
import itertools
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import OpenImageIO
import pytest
from gate import first_of
from metallic_paint import verify
from metallic_paint.interface import knobs, preset_operators
from metallic_paint.interface import live as button
from metallic_paint.paint import PARAMETERS, Flakes, Paint, live, material, presets, value_of
from metallic_paint.paint.parameters import coverage
from metallic_paint.scene import carrier, follow, needs
from metallic_paint.verify.check import check
from recording import Layout
from scenery import add_lamp, link_paint, nest_paint, override_paint

SECONDS = 300
ALONE = Path(__file__).with_name("open_and_render.py")
# Every kind of number: of three species, with a film, a waved and rough coat, and a texture.
RICH = Paint(
    rayleigh_per_mm=2.0, binder_absorption_per_mm=(3.0, 1.0, 6.0), texture_contrast=0.2,
    coat_roughness=0.1, orange_peel=0.02, flake_transmission=(0.01, 0.02, 0.03), tilt=0.3,
    flake_color=(0.8, 0.7, 0.6), flake_edge_color=(0.9, 0.9, 0.9),
    second=Flakes(coating="tio2-on-mica", flakes_per_mm2=500),
    third=Flakes(orientation="beckmann", tilt=0.2, flakes_per_mm2=100),
)  # fmt: skip


@pytest.fixture
def ball() -> bpy.types.Object:
    """Painted candy-red, 4 cm, under a sun and a world."""
    scene = bpy.context.scene
    material.set_up_cycles(scene)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.02)
    bpy.ops.object.shade_smooth()
    thing = bpy.context.object
    thing.name = "Ball"
    material.assign(thing, material.create(presets.load("candy-red"), "Painted"))
    add_lamp("SUN", "Sun", energy=2, angle=math.radians(0.53), rotation_euler=(0.6, 0.2, 0))
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (0.1, 0.1, 0.1)
    add_camera(scene)
    needs.fit(scene)
    return thing


def add_camera(scene: bpy.types.Scene) -> None:
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (0, 0, 1)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 0.05
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = 48
    verify.make_noiseless(scene)
    scene.cycles.samples = 4


def node_of(thing: bpy.types.Object) -> bpy.types.ShaderNodeGroup:
    return material.paint_node(thing.active_material)


def go_live(thing: bpy.types.Object) -> bpy.types.ShaderNodeGroup:
    node = node_of(thing)
    assert live.begin(node, material.paint_of(node))
    needs.fit(bpy.context.scene)
    return node


def picture() -> np.ndarray:
    return verify.render(bpy.context.scene)


def live_labels(node: bpy.types.ShaderNodeGroup) -> set[str]:
    return {socket.name for socket in node.inputs if live.place_of(socket)}


@contextmanager
def operator() -> Iterator[None]:
    button.register()
    try:
        yield
    finally:
        button.unregister()


@pytest.mark.parametrize(
    "paint", first_of([RICH, presets.load("candy-red")]), ids=["rich", "candy-red"]
)
def test_a_live_paint_has_the_same_pixels(ball: bpy.types.Object, paint: Paint) -> None:
    """Constants that OSL folds differ by rounding from numbers that it computes with."""
    node = node_of(ball)
    material.apply(node, paint)
    before = picture()
    assert before.max() > 0.1
    go_live(ball)
    assert material.paint_of(node) == paint
    np.testing.assert_allclose(picture(), before, rtol=2e-3, atol=1e-4)
    step = dataclasses.replace(paint, tilt=2 * paint.tilt, flake_color=(0.3, 0.6, 0.2))
    for name in ("tilt", "flake_color"):
        live.set_value(node.inputs[PARAMETERS[name].label], value_of(step, name))
    assert material.paint_of(node) == step
    stepped = picture()
    assert np.abs(stepped - before).max() > 0.05
    live.end(node)
    assert not live.is_live(node)
    assert material.paint_of(node) == step
    needs.fit(bpy.context.scene)
    np.testing.assert_allclose(picture(), stepped, rtol=2e-3, atol=1e-4)


def test_what_is_there_is_live(ball: bpy.types.Object) -> None:
    """Neither choices, nor what is absent, linked or has keys."""
    node = node_of(ball)
    node.inputs["Flake Spread"].keyframe_insert("default_value", frame=1)
    tree = node.id_data
    tree.links.new(tree.nodes.new("ShaderNodeRGB").outputs[0], node.inputs["Flake Color"])
    go_live(ball)
    assert live_labels(node) == {
        "Flakes per mm²", "Flake Diameter (µm)", "Flake Area Spread", "Tilt", "Flake Edge Color",
        "Layer Thickness (µm)", "Absorption (1/mm)", "Cells per Pixel", "Sparkle Contrast",
        "Substrate Color",
    }  # fmt: skip
    rich = material.create(RICH)
    paint_node = material.paint_node(rich)
    live.begin(paint_node, RICH)
    absent = {"Flake Color 2", "Flake Transmission 2", "Coating (nm)", "Flake Transmission 3"}
    assert not live_labels(paint_node) & absent
    assert live_labels(paint_node) >= {"Coating (nm) 2", "Flake Color 3", "Orange Peel Size (mm)"}


def test_a_step_or_a_key_of_a_live_value_compiles_nothing(
    ball: bpy.types.Object, tmp_path: Path
) -> None:
    """Each program that OSL compiles is written into the folder; a live value in frame 2 has
    another key, and a third picture follows a step of another value.
    """
    node = go_live(ball)
    home, name = live.place_of(node.inputs["Tilt"])
    for frame, tilt in ((1, 0.12), (2, 0.2)):
        home[name] = tilt
        home.keyframe_insert(f'["{name}"]', frame=frame)
    _, other = live.place_of(node.inputs["Layer Thickness (µm)"])
    file = tmp_path / "live.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file), copy=True)
    counter = tmp_path / "count.py"
    counter.write_text(COUNT.format(file=str(file), home=home.name, name=other), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, counter], cwd=tmp_path, capture_output=True, text=True, check=False,
        env={**os.environ, "OSL_OPTIONS": "llvm_output_bitcode=1"}, timeout=SECONDS,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    [line] = [each for each in done.stdout.splitlines() if each.startswith("Programs:")]
    first, *later = map(int, line.split()[1:])
    assert first >= 1
    assert later == [0, 0]
    pictures = [read(tmp_path / f"{i}.exr") for i in range(3)]
    for one, two in itertools.pairwise(pictures):
        assert np.abs(one - two).max() > 0.01


COUNT = """\
import os
from pathlib import Path
import bpy
bpy.ops.wm.open_mainfile(filepath={file!r}, use_scripts=False)
scene = bpy.context.scene
scene.render.use_persistent_data = True
counts = []
def render():
    scene.render.filepath = str(Path(f"{{len(counts)}}.exr").resolve())
    bpy.ops.render.render(write_still=True)
    written = {{file: file.read_text() for file in Path().glob("*.ll")}}
    for file in written:
        file.unlink()
    counts.append(sum("Light1Vector" in text for text in written.values()))
for frame in (1, 2):
    scene.frame_set(frame)
    render()
home = bpy.data.node_groups[{home!r}]
home[{name!r}] *= 3
home.update_tag()
render()
print("Programs:", *counts, flush=True)
os._exit(0)  # an ordinary exit can hang in bpy 4.5
"""


def read(file: Path) -> np.ndarray:
    return OpenImageIO.ImageBuf(str(file)).get_pixels(OpenImageIO.FLOAT)[::-1, :, :3]


def rendered_alone(file: Path, folder: Path) -> np.ndarray:
    """Of a saved file, without the add-on."""
    done = subprocess.run(
        [sys.executable, ALONE, file, folder / "alone", "1"], cwd=folder, capture_output=True,
        text=True, check=False, timeout=SECONDS,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return read(folder / "alone-1.exr")


@pytest.mark.long
def test_a_saved_file_shows_the_live_values_without_the_add_on(
    ball: bpy.types.Object, tmp_path: Path
) -> None:
    node = go_live(ball)
    live.set_value(node.inputs["Absorption (1/mm)"], (30.0, 2.0, 0.5))
    here = picture()
    file = tmp_path / "live.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file), copy=True)
    np.testing.assert_array_equal(rendered_alone(file, tmp_path), here)


@pytest.mark.long
@pytest.mark.parametrize("link", [True, False], ids=["linked", "appended"])
def test_the_material_alone_brings_the_values_of_the_last_save(
    ball: bpy.types.Object, link: bool, tmp_path: Path
) -> None:
    """Whoever saves, settles the values (follow.py); this file has no carrier with them."""
    node = go_live(ball)
    live.set_value(node.inputs["Absorption (1/mm)"], (30.0, 2.0, 0.5))
    here = picture()
    live.settle_all()
    if link:
        link_paint(ball, tmp_path / "theirs.blend")
    else:
        file = str(tmp_path / "theirs.blend")
        bpy.data.libraries.write(file, {ball.active_material})
        for each in (*bpy.data.materials, *bpy.data.node_groups):
            bpy.data.batch_remove([each])
        with bpy.data.libraries.load(file) as (_, into):
            into.materials = ["Painted"]
        ball.active_material = into.materials[0]
    needs.fit(bpy.context.scene)
    np.testing.assert_array_equal(picture(), here)
    assert link or material.paint_of(node_of(ball)).binder_absorption_per_mm == (30.0, 2.0, 0.5)


def test_a_preset_names_what_is_not_its_own(ball: bpy.types.Object) -> None:
    """Live values it sets; those with keys are another's in the next frame."""
    node = go_live(ball)
    home, name = live.place_of(node.inputs["Tilt"])
    told: list[str] = []
    asked = SimpleNamespace(report=lambda _, text: told.append(text))
    context = SimpleNamespace(object=ball, material=ball.active_material)
    assert preset_operators._apply(asked, context, "silver-coarse") == {"FINISHED"}
    assert told == []
    home, name = live.place_of(node.inputs["Tilt"])
    home.keyframe_insert(f'["{name}"]', frame=1)
    preset_operators._apply(asked, context, "candy-red")
    assert told == ["Linked or animated, not the preset's: Tilt."]


def test_saving_settles_the_values(ball: bpy.types.Object, tmp_path: Path) -> None:
    node = go_live(ball)
    live.set_value(node.inputs["Tilt"], 0.25)
    assert node.inputs["Tilt"].default_value == pytest.approx(0.12)
    follow.register()
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "live.blend"), copy=True)
    finally:
        follow.unregister()
    assert node.inputs["Tilt"].default_value == pytest.approx(0.25)
    assert live.value(node.inputs["Tilt"]) == 0.25


@pytest.mark.long
def test_a_copy_has_the_same_sliders_until_it_gets_its_own(ball: bpy.types.Object) -> None:
    """Nothing but a step that can be undone makes a group: undo would free any other."""
    node = go_live(ball)
    live.set_value(node.inputs["Tilt"], 0.25)
    other = ball.copy()
    bpy.context.scene.collection.objects.link(other)
    other.active_material = ball.active_material.copy()
    groups = len(bpy.data.node_groups)
    needs.fit(bpy.context.scene)
    assert needs.is_fitted(bpy.context.scene)
    assert len(bpy.data.node_groups) == groups
    theirs = node_of(other)
    assert live.value(theirs.inputs["Tilt"]) == 0.25
    assert live.is_shared(theirs)
    with operator(), bpy.context.temp_override(object=other, active_object=other):
        assert bpy.ops.material.metallic_paint_live_single() == {"FINISHED"}
        assert not bpy.ops.material.metallic_paint_live_single.poll()
    assert not live.is_shared(node)
    live.set_value(theirs.inputs["Tilt"], 0.4)
    assert live.value(node.inputs["Tilt"]) == 0.25
    needs.fit(bpy.context.scene)
    shown = picture()
    live.end(theirs)
    assert live.value(node.inputs["Tilt"]) == 0.25
    assert theirs.inputs["Tilt"].default_value == pytest.approx(0.4)
    needs.fit(bpy.context.scene)
    np.testing.assert_allclose(picture(), shown, rtol=2e-3, atol=1e-4)


def test_one_of_two_that_share_may_end(ball: bpy.types.Object) -> None:
    node = go_live(ball)
    copy = ball.active_material.copy()
    live.set_value(node.inputs["Tilt"], 0.25)
    live.end(material.paint_node(copy))
    assert live.value(node.inputs["Tilt"]) == 0.25
    assert material.paint_of(copy).tilt == 0.25


@pytest.mark.parametrize("saved", [True, False], ids=["of a save", "not settled"])
def test_an_appended_paint_has_the_values_of_its_file(
    ball: bpy.types.Object, saved: bool, tmp_path: Path
) -> None:
    """The same paint stands here already: that keeps its values and keys, whatever its name."""
    node = go_live(ball)
    live.set_value(node.inputs["Tilt"], 0.3)
    if saved:
        live.settle_all()
    file = str(tmp_path / "theirs.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file, copy=True)
    ball.active_material.name = "Zinnober"
    live.set_value(node.inputs["Tilt"], 0.4)
    home, name = live.place_of(node.inputs["Tilt"])
    home.keyframe_insert(f'["{name}"]', frame=1)
    with bpy.data.libraries.load(file) as (_, into):
        into.objects = ["Ball"]
    bpy.context.scene.collection.objects.link(into.objects[0])
    needs.fit(bpy.context.scene)
    theirs = node_of(into.objects[0])
    assert theirs != node
    assert live.is_live(theirs)
    assert live.value(theirs.inputs["Tilt"]) == pytest.approx(0.3)
    assert live.value(node.inputs["Tilt"]) == pytest.approx(0.4)
    assert live.animated(node) == ["Tilt"]
    assert live.animated(theirs) == []
    assert needs.is_fitted(bpy.context.scene)


def test_a_local_copy_of_a_linked_paint_does_not_move_that(
    ball: bpy.types.Object, tmp_path: Path
) -> None:
    ball.active_material.asset_mark()  # as such it follows the lights of this file
    go_live(ball)
    live.settle_all()
    linked = link_paint(ball, tmp_path / "theirs.blend")
    other = ball.copy()
    bpy.context.scene.collection.objects.link(other)
    other.data = ball.data.copy()
    other.active_material = linked.copy()
    feeder = next(
        each for each in other.active_material.node_tree.nodes if each.name == "Live Sliders"
    )
    feeder.node_tree = feeder.node_tree.copy()
    needs.fit(bpy.context.scene)
    assert needs.is_fitted(bpy.context.scene)
    live.set_value(node_of(other).inputs["Tilt"], 0.5)
    assert live.value(node_of(other).inputs["Tilt"]) == 0.5
    assert live.value(node_of(ball).inputs["Tilt"]) == pytest.approx(0.12)
    assert live.place_of(node_of(ball).inputs["Tilt"]) is None
    assert not live.is_linked(node_of(ball).inputs["Tilt"])
    assert knobs.coverage(node_of(ball)) == pytest.approx(coverage(1900, 28, 0.3))


@pytest.mark.parametrize("use", ["math", "reroute", "output", "two paints", "other input", "muted"])
def test_the_node_may_be_used_as_any_other(ball: bpy.types.Object, use: str) -> None:
    node = go_live(ball)
    tree = node.id_data
    feeder = tree.nodes["Live Sliders"]
    tilt = feeder.outputs["Tilt"]
    if use == "math":
        tree.links.new(tilt, tree.nodes.new("ShaderNodeMath").inputs[0])
    elif use == "reroute":
        reroute = tree.nodes.new("NodeReroute")
        tree.links.new(tilt, reroute.inputs[0])
        tree.links.new(reroute.outputs[0], node.inputs["Tilt"])
    elif use == "output":
        out = tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(tilt, out.inputs["Surface"])
    elif use == "two paints":
        other = material.add_node(tree, Paint())
        for socket in feeder.outputs:
            tree.links.new(socket, other.inputs[socket.name])
    elif use == "other input":
        tree.links.new(tilt, node.inputs["Coat Roughness"])
    else:
        feeder.mute = True
    live.set_value(node.inputs["Layer Thickness (µm)"], 17.0)
    count = len(carrier.only().keys())
    for _ in range(2):
        needs.fit(bpy.context.scene)
        assert needs.is_fitted(bpy.context.scene)
    live.settle_all()
    assert len(carrier.only().keys()) == count
    assert live.is_linked(node.inputs["Tilt"]) == (use in ("reroute", "muted"))
    assert material.paint_of(node).layer_thickness_um == 17.0
    if use == "other input":
        assert material.paint_of(node).coat_roughness == pytest.approx(0.12)
    live.end(node)
    assert material.paint_of(node).layer_thickness_um == 17.0


def test_what_belongs_to_no_paint_goes_with_the_next_save(ball: bpy.types.Object) -> None:
    go_live(ball)
    assert any(name.startswith("Live ") for name in carrier.only().keys())  # noqa: SIM118
    bpy.data.materials.remove(ball.active_material)
    live.settle_all()
    assert not any(name.startswith("Live ") for name in carrier.only().keys())  # noqa: SIM118


def test_lamps_that_come_and_go_leave_live_values_alone(ball: bpy.types.Object) -> None:
    node = go_live(ball)
    home, name = live.place_of(node.inputs["Tilt"])
    home.keyframe_insert(f'["{name}"]', frame=1)
    thickness = node.inputs["Layer Thickness (µm)"]
    driver = home.driver_add(f'["{live.place_of(thickness)[1]}"]').driver
    driver.expression = "20+frame"
    lamp = add_lamp("POINT", "Lamp", location=(1, 1, 1))
    needs.fit(bpy.context.scene)
    bpy.data.objects.remove(lamp)
    needs.fit(bpy.context.scene)
    needs.let_go()  # as before an undo
    assert not needs.is_fitted(bpy.context.scene)
    needs.fit(bpy.context.scene)
    assert needs.is_fitted(bpy.context.scene)
    bpy.context.scene.frame_set(7)
    assert set(live.animated(node)) == {"Tilt", "Layer Thickness (µm)"}
    assert live.value(thickness) == 27


def test_a_preset_is_applied_to_live_values(ball: bpy.types.Object) -> None:
    node = go_live(ball)
    for name in ("white-pearl", "silver-coarse"):
        paint = presets.load(name)
        material.apply(node, paint)
        assert material.paint_of(node) == paint
        assert live.is_live(node)
        needs.fit(bpy.context.scene)
        assert needs.is_fitted(bpy.context.scene)
    home, name = live.place_of(node.inputs["Tilt"])
    home.keyframe_insert(f'["{name}"]', frame=1)
    material.apply(node, presets.load("candy-red"))  # the keys stay with what is live
    assert material.paint_of(node) == presets.load("candy-red")
    assert live.place_of(node.inputs["Tilt"]) == (home, name)


def test_panels_show_and_set_live_values(ball: bpy.types.Object) -> None:
    node = go_live(ball)
    live.set_value(node.inputs["Flakes per mm²"], 100.0)
    layout = Layout()
    knobs.register()
    try:
        words = knobs.draw_first(layout, node)
    finally:
        knobs.unregister()
    home, name = live.place_of(node.inputs["Flakes per mm²"])
    assert f'["{name}"]' in layout.properties
    assert knobs.coverage(node) == pytest.approx(coverage(100, 28, 0.3))
    assert words.startswith("Sparse")
    knobs._set_tint(node, (0.5, 1.0, 0.25))
    np.testing.assert_allclose(knobs._tint(node), (0.5, 1.0, 0.25), rtol=1e-6)
    assert node.inputs["Absorption (1/mm)"].default_value[0] == pytest.approx(1)
    limits = home.id_properties_ui(name).as_dict()
    parameter = PARAMETERS["flakes_per_mm2"]
    assert (limits["min"], limits["soft_max"]) == (parameter.minimum, parameter.slider[1])


def test_the_button_keeps_what_would_be_lost(ball: bpy.types.Object) -> None:
    node = node_of(ball)
    with operator(), bpy.context.temp_override(object=ball, active_object=ball):
        assert bpy.ops.material.metallic_paint_live() == {"FINISHED"}
        assert live.is_live(node)
        home, name = live.place_of(node.inputs["Tilt"])
        home.keyframe_insert(f'["{name}"]', frame=1)
        with pytest.raises(RuntimeError, match="keys or drivers, which would be lost: Tilt"):
            bpy.ops.material.metallic_paint_live()
        assert live.is_live(node)
        home.keyframe_delete(f'["{name}"]', frame=1)
        assert bpy.ops.material.metallic_paint_live() == {"FINISHED"}
        assert not live.is_live(node)
        node.inputs["IOR"].default_value = 0
        with pytest.raises(RuntimeError, match="binder_ior is 0, but must be"):
            bpy.ops.material.metallic_paint_live()


@pytest.mark.long
def test_verify_checks_the_live_values(ball: bpy.types.Object, tmp_path: Path) -> None:
    node = go_live(ball)
    live.set_value(node.inputs["Flakes per mm²"], 400.0)
    scene = bpy.context.scene
    found = check(scene, ball, ball.active_material, 32, tmp_path, lambda *_: None)
    assert found["unexplained"] == 0
    assert found["pixels"] > 0
    assert not [note for note in found["notes"] if "own values" in note]
    assert node.inputs["Flakes per mm²"].default_value == 400  # what it was checked with


@pytest.mark.long
def test_a_paint_within_a_group_can_be_live(ball: bpy.types.Object) -> None:
    nest_paint(ball.active_material)
    needs.fit(bpy.context.scene)
    node = node_of(ball)
    paint = material.paint_of(node)
    before = picture()
    go_live(ball)
    np.testing.assert_allclose(picture(), before, rtol=2e-3, atol=1e-4)
    live.set_value(node.inputs["Tilt"], 0.4)
    assert np.abs(picture() - before).max() > 0.01
    assert material.paint_of(node) == dataclasses.replace(paint, tilt=0.4)


def test_an_overridden_paint_cannot_be_live(ball: bpy.types.Object, tmp_path: Path) -> None:
    """Blender drops its new nodes when the file is opened again."""
    ball.active_material.asset_mark()  # as such it follows the lights of this file
    needs.fit(bpy.context.scene)
    painted = override_paint(ball, tmp_path / "theirs.blend")
    with operator(), pytest.raises(RuntimeError, match="is a library override, whose nodes"):
        bpy.ops.material.metallic_paint_live()
    nodes = sorted(node.name for node in painted.node_tree.nodes)
    live.begin(node_of(ball), material.paint_of(node_of(ball)))
    file = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    bpy.ops.wm.open_mainfile(filepath=file)
    ball = bpy.data.objects["Ball"]
    assert ball.active_material.override_library is not None
    assert sorted(node.name for node in ball.active_material.node_tree.nodes) == nodes


@pytest.mark.long
@pytest.mark.parametrize(
    ("label", "value"),
    [("Flakes per mm²", 0.0), ("Tilt", 1e-6), ("Layer Thickness (µm)", 0.0),
     ("Flake Diameter (µm)", 1e5), ("Absorption (1/mm)", (1e6, 1e6, 1e6)),
     ("Sparkle Contrast", 0.0), ("Flakes per mm²", 1e9)],
)  # fmt: skip
def test_live_values_may_be_extreme(
    ball: bpy.types.Object, label: str, value: float | tuple[float, ...]
) -> None:
    """As sockets may: with the same pixels."""
    node = go_live(ball)
    live.set_value(node.inputs[label], value)
    shown = picture()
    assert np.isfinite(shown).all()
    live.end(node)
    needs.fit(bpy.context.scene)
    np.testing.assert_allclose(shown, picture(), rtol=2e-3, atol=1e-3)
