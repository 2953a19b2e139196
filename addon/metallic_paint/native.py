# SPDX-License-Identifier: GPL-3.0-or-later
"""The native module, metallic_paint_core, as the add-on uses it: the paint works without it.

The extension has it in a folder of its own, compiled for each Python; Python's import takes the
file whose name fits. As a wheel of the manifest it would do so too, but Blender refuses an
extension whole, none of whose wheels fits its Python.
"""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from .scene import carrier

if TYPE_CHECKING:
    from metallic_paint_core._native import Light

_NAME = "metallic_paint_core"
_OWN = Path(__file__).with_name(_NAME)  # in the zip; in the repository it is installed


def core_missing() -> str:
    """Why the native module cannot be used, in a sentence; empty where it can.

    From then on, Python knows it by its name.
    """
    try:
        _load()
    except ImportError as error:
        return _why_not(error)
    return ""


def core_lights() -> list[Light]:
    """The slots in use, as the core takes them; that of a light scaled to nothing is unused."""
    import metallic_paint_core as core

    found = []
    for kind, vector, size, facing in carrier.values():
        points = facing if kind == carrier.AREA else vector
        known = kind == carrier.POSITIONAL or any(points)
        found.append(core.Light(core.LightKind(kind if known else 0), vector, size, facing))
    return found


def _load() -> None:
    if _NAME in sys.modules or not _OWN.is_dir():
        importlib.import_module(_NAME)
        return
    spec = importlib.util.spec_from_file_location(
        _NAME, _OWN / "__init__.py", submodule_search_locations=[str(_OWN)]
    )
    module = sys.modules[_NAME] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[_NAME]
        raise


def _why_not(error: ImportError) -> str:
    if error.name == _NAME:
        return "This build of the add-on has no native module for this Blender."
    built_for = {  # _native.cpython-311-x86_64-linux-gnu.so, _native.cp311-win_amd64.pyd
        (int(found[1]), int(found[2]))
        for file in _OWN.glob("_native.*")
        if (found := re.match(r"_native\.cp(?:ython-)?(\d)(\d+)", file.name))
    }
    if built_for and sys.version_info[:2] not in built_for:
        pythons = " and ".join(f"{major}.{minor}" for major, minor in sorted(built_for))
        here = f"{sys.version_info.major}.{sys.version_info.minor}"
        return (
            f"This build of the add-on has its native module for Python {pythons}; this Blender "
            f"has Python {here}."
        )
    return f"The native module {_NAME} cannot be loaded: {error}."
