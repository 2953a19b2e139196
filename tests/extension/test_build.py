# SPDX-License-Identifier: Apache-2.0
"""./paint extension: what it writes, and how it refuses.

Installed here is the zip without the native module for this Python.
"""

from __future__ import annotations

import importlib
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import bpy
import pytest
from common import environments
from common.environments import BLENDERS
from package import NAME
from recording import drawn

ROOT = Path(__file__).resolve().parent.parent.parent
MANIFEST = "blender_manifest.toml"
FOREIGN = "windows-x64"
VERSION = (ROOT / "VERSION").read_text().strip()
PYTHONS = [
    each.python_version for each in BLENDERS if environments.find_python(each.python_version)
]


def run(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, ROOT / "tools", "extension.build", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


def contents(file: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(file) as zipped:
        return {name: zipped.read(name) for name in zipped.namelist()}


def is_native(name: str) -> bool:
    return name.startswith("metallic_paint_core/")


@pytest.fixture(scope="session")
def own() -> Path:
    [file] = (ROOT / "build" / "extension").iterdir()
    return file


@pytest.fixture(scope="session")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("foreign")
    built = run("--platform", FOREIGN, "--out", out)
    assert built.returncode == 0, built.stdout + built.stderr
    [file] = out.iterdir()
    return file


@pytest.fixture(scope="session")
def installed(own: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """As in a Blender newer than the zip: the module for this Python is one for Python 3.99."""
    older = tmp_path_factory.mktemp("older") / own.name
    ours = "-{}{}-".format(*sys.version_info)
    with zipfile.ZipFile(older, "w") as zipped:
        for name, content in contents(own).items():
            zipped.writestr(name.replace(ours, "-399-") if is_native(name) else name, content)
    bpy.ops.extensions.package_install_files(
        filepath=str(older), repo="user_default", enable_on_install=True
    )
    return Path(importlib.import_module(NAME).__file__).parent


@pytest.fixture
def no_core(monkeypatch: pytest.MonkeyPatch) -> None:
    """No test has imported it from the environment, which has it too."""
    for name in [name for name in sys.modules if name.partition(".")[0] == "metallic_paint_core"]:
        monkeypatch.delitem(sys.modules, name)


@pytest.mark.long
def test_output_must_be_a_folder(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("mine")
    refused = run("--out", file)
    assert (refused.returncode, refused.stderr) == (1, f"--out {file}: not a folder.\n")
    assert file.read_text() == "mine"


@pytest.mark.long
def test_unknown_platform_is_refused_with_the_known_ones() -> None:
    refused = run("--platform", "amiga")
    assert refused.returncode == 2
    for name in ("amiga", FOREIGN, "macos-arm64"):
        assert name in refused.stderr.splitlines()[-1]


@pytest.mark.long
def test_zip_is_named_by_version_and_platform_and_holds_no_trace_of_this_machine(
    own: Path, foreign: Path
) -> None:
    assert own.name.startswith(f"metallic_paint-{VERSION}-linux-")
    assert foreign.name == f"metallic_paint-{VERSION}-{FOREIGN}.zip"
    for file in (own, foreign):
        held = contents(file)
        texts = [name for name in held if name.endswith((".py", ".toml", ".txt"))]
        assert MANIFEST in texts
        for name in texts:
            content = held[name].decode()
            assert str(ROOT) not in content, name
            assert "$" not in content or not name.endswith(".toml")


def test_asset_library_holds_no_trace_of_this_machine(own: Path, tmp_path: Path) -> None:
    """Once uncompressed: the paint's bytecode would name its compiler's files."""
    packed, plain = tmp_path / "packed.blend", tmp_path / "plain.blend"
    packed.write_bytes(contents(own)["assets/metallic_paint.blend"])
    bpy.ops.wm.open_mainfile(filepath=str(packed))
    bpy.ops.wm.save_as_mainfile(filepath=str(plain), compress=False, copy=True)
    content = plain.read_bytes()
    assert b"OpenShadingLanguage 1.00" in content
    assert str(ROOT).encode() not in content
    assert b"%line{" not in content  # nor the hints that tell where an operation comes from


@pytest.mark.long
def test_foreign_zip_differs_by_platform_and_native_module_only(own: Path, foreign: Path) -> None:
    ours, theirs = contents(own), contents(foreign)
    our_manifest, manifest = (tomllib.loads(each.pop(MANIFEST).decode()) for each in (ours, theirs))
    native = set(filter(is_native, ours))
    assert native
    assert manifest == our_manifest | {"platforms": [FOREIGN]}
    assert theirs.keys() == ours.keys() - native
    assert [name for name in theirs if theirs[name] != ours[name]] == []


@pytest.mark.long
def test_native_module_is_in_the_zip_for_each_python_and_taken_from_given_wheels(
    own: Path, tmp_path: Path
) -> None:
    """As a build farm has them. The library inside stays one for Linux: nobody looks."""
    native = {name: content for name, content in contents(own).items() if is_native(name)}
    given, out = tmp_path / "given", tmp_path / "out"
    given.mkdir()
    wheels = [next((ROOT / "build").glob(f"wheels-{python}/*.whl")) for python in PYTHONS]
    for wheel in wheels:
        python = wheel.name.split("-")[2]
        shutil.copy(wheel, given / f"metallic_paint_core-0-{python}-{python}-win_amd64.whl")
        shutil.copy(wheel, given / f"metallic_paint_core-0-{python}-{python}-win_arm64.whl")
    assert len(native) == 1 + len(wheels)  # with __init__.py
    built = run("--platform", FOREIGN, "--wheels", given, "--out", out)
    assert built.returncode == 0, built.stdout + built.stderr
    theirs = contents(out / f"metallic_paint-{VERSION}-{FOREIGN}.zip")
    assert {name: theirs[name] for name in theirs if is_native(name)} == native


@pytest.mark.long
def test_folder_of_wheels_must_be_one(tmp_path: Path) -> None:
    refused = run("--wheels", tmp_path / "none")
    said = f"--wheels {tmp_path / 'none'}: not a folder.\n"
    assert (refused.returncode, refused.stderr) == (1, said)


@pytest.mark.long
def test_this_blender_finds_the_foreign_zip_valid_and_refuses_it(
    foreign: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    scripts = Path(bpy.utils.system_resource("SCRIPTS"))
    tool = scripts / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    command = [sys.executable, "-B", tool, "validate", foreign]
    assert subprocess.run(command, timeout=60, check=False).returncode == 0
    bpy.ops.extensions.package_install_files(filepath=str(foreign), repo="user_default")
    assert f"isn't one of ({FOREIGN})" in capfd.readouterr().out


@pytest.mark.long
def test_shader_survives_the_encodings_of_other_systems(foreign: Path) -> None:
    """Blender writes it for the compiler in that of the system, which need not be UTF-8."""
    for name, content in contents(foreign).items():
        if name.startswith(("osl/", "core/")):
            assert content.isascii(), name


@pytest.mark.usefixtures("no_core")
def test_paint_works_without_the_native_module(installed: Path) -> None:
    assert not [*(installed / "metallic_paint_core").glob("*-{}{}-*".format(*sys.version_info))]
    assert not [*Path(bpy.utils.user_resource("EXTENSIONS")).glob(".local/lib/*/site-packages/*")]
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = 16
    bpy.ops.object.light_add(type="SUN")
    bpy.ops.object.camera_add(location=(0, 0, 0.4))
    scene.camera = bpy.context.object
    bpy.ops.mesh.primitive_plane_add(size=0.1)
    bpy.ops.scene.metallic_paint_use_osl()
    assert bpy.ops.material.metallic_paint_new(preset="silver-coarse") == {"FINISHED"}
    assert bpy.context.object.active_material.name == "Silver Coarse"
    assert bpy.ops.scene.metallic_paint_report() == {"FINISHED"}
    shown = " ".join(drawn(bpy.types.MATERIAL_PT_metallic_paint_report).texts)
    assert "flakes a pixel" in shown
    assert "sparkles cannot be foretold" in shown
    assert "3.99; this Blender has Python" in shown


@pytest.mark.usefixtures("no_core")
def test_verify_says_that_there_is_no_native_module_for_this_python() -> None:
    shown = drawn(bpy.types.MATERIAL_PT_metallic_paint_verify)
    text = " ".join(shown.texts)
    assert text.startswith("This build of the add-on has its native module for Python 3.")
    here = "{}.{}".format(*sys.version_info)
    assert text.endswith(f"3.99; this Blender has Python {here}. The paint works without it.")
    assert not shown.names
    assert not bpy.ops.scene.metallic_paint_verify.poll()
