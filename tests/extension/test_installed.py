# SPDX-License-Identifier: Apache-2.0
"""What the zip holds, and that it comes and goes without a trace."""

from __future__ import annotations

import importlib
import shutil
import sys
import sysconfig
from pathlib import Path

import addon_utils
import bpy
import pytest
from package import NAME, Addon

ROOT = Path(__file__).resolve().parent.parent.parent
NATIVE = "metallic_paint_core"
SUFFIX = sysconfig.get_config_var("EXT_SUFFIX")  # with Python's version and the platform
HANDLERS = ("depsgraph_update_post", "load_post", "save_pre", "undo_pre", "undo_post", "redo_pre",
            "redo_post", "render_init", "render_complete", "render_cancel")  # fmt: skip


def ours() -> dict[str, int]:
    """How many of our functions and classes Blender holds."""
    lists = {name: getattr(bpy.app.handlers, name) for name in HANDLERS}
    found = {
        name: sum(each.__module__.startswith(NAME) for each in functions)
        for name, functions in lists.items()
    }
    found["menu"] = sum(
        each.__module__.startswith(NAME)
        for each in bpy.types.NODE_MT_shader_node_add_all._dyn_ui_initialize()
    )
    found["classes"] = sum("metallic_paint" in name.lower() for name in dir(bpy.types))
    return found


def test_zip_holds_what_the_paint_needs(installed: Path, addon: Addon) -> None:
    assert "stdcycles.h" in addon("paint.shader").source()
    assert (installed / "osl").is_dir()
    assert len(addon("paint.presets").names()) >= 24
    for name in addon("paint.presets").names():
        assert (installed / "swatches" / f"{name}.jpg").is_file(), name
    assert (installed / "LICENSES" / "GPL-3.0-or-later.txt").is_file()
    assert not list(installed.rglob("tests"))


def test_native_module_comes_from_the_zip(installed: Path, addon: Addon) -> None:
    assert addon("native").core_missing() == ""
    core = importlib.import_module(NATIVE)
    assert Path(core.__file__).parent == installed / NATIVE
    assert core.__version__ == (ROOT / "VERSION").read_text().strip()


@pytest.fixture
def modules(installed: Path, addon: Addon, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the add-on looks for the native module, which nobody has imported: all but itself."""
    folder = tmp_path / NATIVE
    folder.mkdir()
    shutil.copy(installed / NATIVE / "__init__.py", folder)
    monkeypatch.setattr(addon("native"), "_OWN", folder)
    for name in [name for name in sys.modules if name.partition(".")[0] == NATIVE]:
        monkeypatch.delitem(sys.modules, name)
    return folder


def test_native_modules_for_other_pythons_are_named(modules: Path, addon: Addon) -> None:
    """By their files' names on any system: Python does not even open them."""
    for name in ("cpython-398-x86_64-linux-gnu.so", "cpython-398-darwin.so", "cp399-win_amd64.pyd"):
        (modules / f"_native.{name}").write_text("not opened")
    assert addon("native").core_missing() == (
        "This build of the add-on has its native module for Python 3.98 and 3.99; this Blender "
        f"has Python {sys.version_info.major}.{sys.version_info.minor}."
    )
    assert NATIVE not in sys.modules


def test_a_native_module_for_another_python_under_our_name_is_refused(
    installed: Path, modules: Path, addon: Addon
) -> None:
    ours = modules / f"_native{SUFFIX}"
    others = [file for file in (installed / NATIVE).glob("_native.*") if file.name != ours.name]
    for content in [b"", b"not a library", *(file.read_bytes() for file in others)]:
        ours.unlink(missing_ok=True)  # a library that is mapped may not change
        ours.write_bytes(content)
        said = addon("native").core_missing()
        assert said.startswith("The native module metallic_paint_core cannot be loaded: "), said
        assert NATIVE not in sys.modules


def test_disabling_leaves_nothing_and_enabling_brings_it_back() -> None:
    before = ours()
    assert all(before.values()), before
    for _ in range(2):
        addon_utils.disable(NAME)
        assert not any(ours().values()), ours()
        assert addon_utils.enable(NAME) is not None
        assert ours() == before


def test_register_and_unregister_twice(addon: Addon) -> None:
    package = importlib.import_module(NAME)
    before = ours()
    for _ in range(2):
        package.unregister()
        assert not any(ours().values()), ours()
        package.register()
        assert ours() == before
