# SPDX-License-Identifier: Apache-2.0
"""What the zip holds, and that it comes and goes without a trace."""

from __future__ import annotations

import importlib
from pathlib import Path

import addon_utils
import bpy
import pytest
from package import NAME, Addon

pytestmark = pytest.mark.every_blender

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


def test_native_module_comes_from_the_zip(installed: Path) -> None:
    core = importlib.import_module("metallic_paint_core")
    user = Path(bpy.utils.user_resource("EXTENSIONS"))
    assert user in Path(core.__file__).parents


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
