# SPDX-License-Identifier: Apache-2.0
"""Each test has the extension installed from the zip that a user gets, in an empty scene."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

from blender_session import *  # noqa: F403

# isort: split
import addon_utils
import bpy
import pytest
from package import NAME, Addon

ROOT = Path(__file__).resolve().parent.parent.parent


def pytest_configure() -> None:
    """What is not in the zip is not there."""
    sys.path.remove(str(ROOT / "addon"))


@pytest.fixture(scope="session")
def installed() -> Path:
    """The folder that Blender unpacked the zip into."""
    zips = sorted((ROOT / "build" / "extension").glob("metallic_paint-*.zip"))
    assert len(zips) == 1, "Build one zip: ./paint extension --out build/extension"
    bpy.ops.extensions.package_install_files(
        filepath=str(zips[0]), repo="user_default", enable_on_install=True
    )
    return Path(importlib.import_module(NAME).__file__).parent


@pytest.fixture(autouse=True)
def enabled(installed: Path, empty_scene: None) -> Iterator[None]:
    assert addon_utils.enable(NAME, default_set=True) is not None
    yield
    addon_utils.disable(NAME, default_set=True)


@pytest.fixture
def addon() -> Addon:
    """The extension's module of that name."""
    return lambda name: importlib.import_module(f"{NAME}.{name}")
