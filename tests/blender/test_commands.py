# SPDX-License-Identifier: Apache-2.0
"""The commands that make pictures, run as a user runs them, at tiny sizes."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO
import pytest
from common.processes import ROOT, TOOLS
from mathutils import Vector
from metallic_paint.paint import presets
from pictures import render

pytestmark = pytest.mark.long

QUICK = ("--width", 64, "--samples", 1)
SECONDS = 120  # a tool that takes longer hangs
EARLIER = "a picture of yesterday"

PLY = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
"""
EXPORTERS: dict[str, Callable[[str], object]] = {
    ".obj": lambda file: bpy.ops.wm.obj_export(filepath=file),
    ".ply": lambda file: bpy.ops.wm.ply_export(filepath=file, export_normals=True),
    ".stl": lambda file: bpy.ops.wm.stl_export(filepath=file),
    ".glb": lambda file: bpy.ops.export_scene.gltf(filepath=file),
}


def tool(name: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command(name, *arguments), capture_output=True, text=True, timeout=SECONDS, check=False
    )


def command(name: str, *arguments: object) -> list[str]:
    return [sys.executable, str(TOOLS), f"pictures.{name}", *map(str, arguments)]


def rendered(*arguments: object) -> str:
    """What a render says that has to succeed."""
    done = tool("render", *arguments, "--paint", "silver-coarse")
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    return done.stdout


def picture(file: Path) -> np.ndarray:
    return OpenImageIO.ImageBuf(str(file)).get_pixels(OpenImageIO.FLOAT)


def assert_shows_something(file: Path, size: tuple[int, int]) -> None:
    image = picture(file)
    assert image.shape[1::-1] == size
    assert np.isfinite(image).all()
    assert (image >= 0).all()
    assert image[..., :3].max() > 0


def add_ball(name: str = "Ball", *, smooth: bool = True) -> bpy.types.Object:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.2)
    ball = bpy.context.object
    ball.name = name
    if smooth:
        ball.data.shade_smooth()
    return ball


def add_camera_and_sun(energy: float = 3.0) -> None:
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 48, 32
    for name, data, away in (
        ("Eye", bpy.data.cameras.new("Eye"), Vector((0, -1, 0.2))),
        ("Noon", bpy.data.lights.new("Noon", "SUN"), Vector((0.3, -0.6, 1))),
    ):
        thing = bpy.data.objects.new(name, data)
        thing.location = away
        thing.rotation_euler = away.to_track_quat("Z", "Y").to_euler()
        scene.collection.objects.link(thing)
    bpy.data.lights["Noon"].energy = energy
    scene.camera = bpy.data.objects["Eye"]


def save_blend(file: Path) -> Path:
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    return file


# --- pictures --------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", EXPORTERS)
def test_a_mesh_of_each_format_stands_in_the_studio(tmp_path: Path, suffix: str) -> None:
    add_ball()
    mesh, out = tmp_path / f"ball{suffix}", tmp_path / "new folder" / "ball.exr"
    EXPORTERS[suffix](str(mesh))
    said = rendered(mesh, "--out", out, *QUICK)
    assert_shows_something(out, (64, 36))
    spec = OpenImageIO.ImageBuf(str(out)).spec()
    assert (spec.channelnames, str(spec.format)) == (("R", "G", "B", "A"), "float")
    for part in ("Painting 1 object, 0.4 × 0.4 × 0.4 m", "100 %", "silver-coarse",
                 "64 × 36 pixels", "1 samples", "light 1: ", str(out)):  # fmt: skip
        assert part in said
    assert "Sample" not in said  # Cycles' own lines


def test_a_name_may_be_as_long_as_the_system_lets_it(tmp_path: Path, triangle: Path) -> None:
    out = tmp_path / ("x" * 251 + ".png")
    rendered(triangle, "--out", out, *QUICK)
    assert_shows_something(out, (64, 36))


def test_a_png_has_the_size_asked_for(tmp_path: Path) -> None:
    add_ball()
    mesh, out = tmp_path / "ball.obj", tmp_path / "ball.png"
    EXPORTERS[".obj"](str(mesh))
    said = rendered(mesh, "--out", out, *QUICK, "--height", 48)
    assert_shows_something(out, (64, 48))
    assert "view transform" in said


@pytest.mark.parametrize("suffix", [".glb", ".obj"])
def test_a_mesh_in_millimetres_has_its_true_size(tmp_path: Path, suffix: str) -> None:
    add_ball()
    mesh, out = tmp_path / f"ball{suffix}", tmp_path / "ball.png"
    EXPORTERS[suffix](str(mesh))
    said = rendered(mesh, "--out", out, *QUICK, "--scale", "0.001")
    assert "Painting 1 object, 0.0004 × 0.0004 × 0.0004 m" in said
    assert_shows_something(out, (64, 36))


def test_a_blend_keeps_its_camera_lights_size_and_samples(tmp_path: Path) -> None:
    add_ball("Left"), add_ball("Right")
    add_camera_and_sun()
    bpy.context.scene.cycles.samples = 3
    file, out = save_blend(tmp_path / "two.blend"), tmp_path / "two.exr"
    said = rendered(file, "--out", out)
    assert_shows_something(out, (48, 32))
    assert "Painting 2 objects" in said
    assert "3 samples" in said
    assert "light 1: Noon" in said
    assert "light 2" not in said


def test_a_blend_without_camera_and_lights_gets_the_studio(tmp_path: Path) -> None:
    add_ball("Left"), add_ball("Right")
    file, out = save_blend(tmp_path / "two.blend"), tmp_path / "two.exr"
    said = rendered(file, "--out", out, *QUICK, "--object", "Right", "Right")
    assert_shows_something(out, (64, 36))
    assert "Painting 1 object," in said
    assert "light 1: " in said


def test_the_demo_writes_one_picture_in_two_files(tmp_path: Path) -> None:
    done = tool("demo", "--out", tmp_path, *QUICK)
    assert done.returncode == 0, done.stderr
    assert_shows_something(tmp_path / "demo.exr", (64, 36))
    assert_shows_something(tmp_path / "demo.png", (64, 36))
    assert sorted(tmp_path.iterdir()) == [tmp_path / "demo.exr", tmp_path / "demo.png"]
    linear, encoded = (picture(tmp_path / f"demo.{suffix}") for suffix in ("exr", "png"))
    brightness = [image[..., :3].mean(axis=-1).ravel() for image in (linear, encoded)]
    assert np.corrcoef(np.argsort(np.argsort(brightness)))[0, 1] > 0.9  # of the ranks


# --- shading ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("suffix", "smooth"),
    [(".obj", True), (".ply", True), (".glb", True), (".obj", False), (".glb", False)],
)
def test_shading_is_as_the_file_says(tmp_path: Path, suffix: str, smooth: bool) -> None:
    """A PLY has one normal for each vertex: Blender writes no flat faces."""
    ball = add_ball(smooth=smooth)
    file = tmp_path / f"ball{suffix}"
    EXPORTERS[suffix](str(file))
    del ball
    assert is_smooth(file) == smooth


def test_without_normals_edges_under_30_degrees_are_smooth(tmp_path: Path) -> None:
    add_ball(smooth=False)
    bpy.ops.wm.stl_export(filepath=str(tmp_path / "ball.stl"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.wm.obj_export(filepath=str(tmp_path / "cube.obj"), export_normals=False)
    assert is_smooth(tmp_path / "ball.stl")
    assert not is_smooth(tmp_path / "cube.obj")


def is_smooth(file: Path) -> bool:
    """Whether the corners' normals differ from the faces' normals somewhere."""
    (thing,) = render.meshes(render.import_mesh(file))
    mesh = thing.data
    return any(
        (mesh.corner_normals[i].vector - face.normal).length > 0.05
        for face in mesh.polygons
        for i in face.loop_indices
    )


# --- what goes wrong -------------------------------------------------------------------------


def assert_fails(
    out: Path, arguments: Sequence[object], sentence: str, code: int = 1, name: str = "render"
) -> None:
    """One sentence, the exit code, and the earlier picture as it was."""
    before = sorted(out.parent.iterdir()) if out.parent.is_dir() else None
    done = tool(name, *arguments)
    assert done.returncode == code, done.stderr
    assert sentence in done.stderr.splitlines()[-1]  # Blender itself may have spoken before
    assert "Traceback" not in done.stderr
    if before is not None:
        assert sorted(out.parent.iterdir()) == before
    if out.is_file():
        assert out.read_text() == EARLIER


@pytest.fixture
def out(tmp_path: Path) -> Path:
    file = tmp_path / "out" / "picture.png"
    file.parent.mkdir()
    file.write_text(EARLIER)
    return file


@pytest.fixture
def triangle(tmp_path: Path) -> Path:
    file = tmp_path / "triangle.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    return file


def test_the_paint_must_exist(out: Path, triangle: Path) -> None:
    arguments = [triangle, "--paint", "mauve", "--out", out]
    assert_fails(
        out, arguments, "'mauve' is neither a file nor a preset; the presets are bass-boat"
    )
    assert_fails(out, ["--preset", "mauve", "--out", out.parent], "neither a file", name="demo")


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("none.obj", None, "none.obj cannot be read: No such file or directory."),
        ("model.fbx", "", "model.fbx: a model's name ends in .obj, .glb, .ply, .stl or .blend."),
        ("empty.obj", "# nothing\n", "empty.obj holds no faces to paint."),
        ("points.obj", "v 0 0 0\nv 1 0 0\n", "points.obj holds no faces to paint."),
        ("bad.ply", "no ply", "bad.ply cannot be read: "),
        ("bad.stl", "no stl", "bad.stl "),
        ("bad.glb", "no glb", "bad.glb cannot be read: "),
        ("bad.blend", "no blend", "bad.blend cannot be read: "),
        ("dot.ply", PLY + "1 1 1\n" * 3 + "3 0 1 2\n", "what is to be painted has no extent."),
    ],
)
def test_the_model_must_be_readable(
    tmp_path: Path, out: Path, name: str, content: str | None, sentence: str
) -> None:
    if content is not None:
        (tmp_path / name).write_text(content)
    assert_fails(out, [tmp_path / name, "--paint", "copper", "--out", out, *QUICK], sentence)


def test_the_picture_must_be_writable(out: Path, triangle: Path) -> None:
    for file, sentence in (
        (out.with_suffix(".jpg"), "picture.jpg: a picture's name ends in .exr or .png."),
        (out / "deep" / "picture.png", "cannot be written: Not a directory."),
        (out.parent.with_suffix(".png"), "cannot be written: it is a folder."),
        (out.with_stem("x" * 252), "cannot be written: File name too long."),
    ):
        if "folder" in sentence:
            file.mkdir()
        assert_fails(out, [triangle, "--paint", "copper", "--out", file], sentence)
    assert_fails(out, ["--out", out], "cannot be written", name="demo")


def test_the_paints_that_the_help_names_exist() -> None:
    script = (ROOT / "paint").read_text()
    (text,) = re.findall(r"<<'TEXT'\n(.*?)\nTEXT\n", script, re.DOTALL)
    named = set(re.findall(r"--paint +(\S+)", text)) - {"PRESET"}
    assert named
    assert named <= set(presets.names())


def test_wrong_usage_has_a_code_of_its_own(out: Path, triangle: Path) -> None:
    whole = [triangle, "--paint", "copper", "--out", out]
    assert_fails(out, whole[:1], "required: --paint, --out", code=2)
    assert_fails(out, [*whole, "--scale", "inf"], "invalid number above 0", code=2)
    for option, value, most in (
        ("--samples", 0, 16777216),
        ("--width", 65537, 65536),
        ("--height", "tall", 65536),
    ):
        sentence = f"argument {option}: invalid whole number from 1 to {most} value: '{value}'"
        assert_fails(out, [*whole, option, value], sentence, code=2)
    assert_fails(out, ["--samples", 10**11], "from 1 to 16777216 value: '100000000000'", 2, "demo")


def test_named_objects_must_exist_and_hold_paint(tmp_path: Path, out: Path, triangle: Path) -> None:
    add_ball()
    add_camera_and_sun()
    file = save_blend(tmp_path / "ball.blend")
    whole = [file, "--paint", "copper", "--out", out, "--object"]
    assert_fails(out, [*whole, "Bull"], "no object 'Bull'; its meshes are 'Ball'.")
    assert_fails(out, [*whole, "Noon"], "'Noon' (LIGHT) cannot hold a material")
    arguments = [triangle, "--paint", "copper", "--out", out, "--object", "Ball"]
    assert_fails(out, arguments, "--object names objects of a .blend")


def test_scale_is_for_meshes(tmp_path: Path, out: Path) -> None:
    file = tmp_path / "model.blend"
    file.write_text("")
    arguments = [file, "--paint", "silver-coarse", "--out", out, "--scale", 2]
    assert_fails(out, arguments, "--scale is for a mesh; ")


def test_a_scale_may_be_too_large(out: Path, triangle: Path) -> None:
    triangle.write_text("v 0 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 3\n")
    arguments = [triangle, "--paint", "copper", "--out", out, "--scale", 1e38]
    assert_fails(out, arguments, "triangle.obj: what is to be painted has no finite extent.")


def test_coordinates_must_be_numbers(tmp_path: Path, out: Path) -> None:
    add_ball().data.vertices[0].co.x = float("nan")
    file = save_blend(tmp_path / "ball.blend")
    arguments = [file, "--paint", "copper", "--out", out, *QUICK]
    assert_fails(out, arguments, "'Ball' has coordinates that are no finite numbers.")


def test_a_flat_model_lies_on_the_ground(tmp_path: Path) -> None:
    (tmp_path / "flat.ply").write_text(PLY + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    rendered(tmp_path / "flat.ply", "--out", tmp_path / "flat.png", *QUICK)
    assert_shows_something(tmp_path / "flat.png", (64, 36))


def test_a_paint_that_is_all_black_fails(tmp_path: Path, out: Path) -> None:
    add_ball()
    add_camera_and_sun(energy=0)
    file = save_blend(tmp_path / "night.blend")
    arguments = [file, "--paint", "copper", "--out", out, *QUICK]
    assert_fails(out, arguments, "All the paint in the picture is black")


# As every command that needs Blender begins.
BEGIN = """
import signal
import sys
sys.path.insert(0, sys.argv[1])
signal.signal(signal.SIGINT, signal.default_int_handler)  # whatever our starter ignores
from common import blender_env

blender_env.prepare()
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_while_blender_is_imported_leaves_nothing(
    tmp_path: Path, number: signal.Signals
) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", BEGIN, TOOLS],
        env=os.environ | {"TMPDIR": str(tmp_path)},
        stderr=subprocess.PIPE,
        text=True,
    )
    while not list(tmp_path.iterdir()) and process.poll() is None:
        time.sleep(0.01)
    time.sleep(0.1)
    process.send_signal(number)
    _, said = process.communicate(timeout=SECONDS)
    assert process.returncode == 128 + number
    assert said.endswith("\nInterrupted.\n")
    assert not list(tmp_path.iterdir())


# The signal comes as soon as there is a folder to leave behind, before the import.
AT_ONCE = """
import os, tempfile
make = tempfile.mkdtemp
def make_and_send(**given):
    folder = make(**given)
    os.kill(os.getpid(), int(sys.argv[2]))
    return folder
tempfile.mkdtemp = make_and_send
"""


def test_an_interruption_just_before_blender_is_imported_leaves_nothing(tmp_path: Path) -> None:
    begin = BEGIN.replace("from common", f"{AT_ONCE}\nfrom common")
    ended = subprocess.run(
        [sys.executable, "-c", begin, TOOLS, str(signal.SIGTERM.value)],
        env=os.environ | {"TMPDIR": str(tmp_path)},
        stderr=subprocess.PIPE,
        text=True,
        timeout=SECONDS,
    )
    assert ended.returncode == 128 + signal.SIGTERM
    assert ended.stderr.endswith("\nInterrupted.\n")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_render_leaves_the_earlier_picture(
    out: Path, triangle: Path, number: signal.Signals
) -> None:
    arguments = [triangle, "--paint", "copper", "--out", out, "--samples", 100_000]
    process = subprocess.Popen(
        command("render", *arguments), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    try:
        assert process.stdout is not None
        for line in process.stdout:
            if "0 %" in line:
                break
        process.send_signal(number)
        said, _ = process.communicate(timeout=SECONDS)
    finally:
        process.kill()
    assert process.returncode == 128 + number, said
    assert "Interrupted" in said
    assert list(out.parent.iterdir()) == [out]
    assert out.read_text() == EARLIER
