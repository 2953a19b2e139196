# SPDX-License-Identifier: Apache-2.0
from importlib import metadata
from pathlib import Path

import metallic_paint_core

VERSION = (Path(__file__).parents[2] / "VERSION").read_text().strip()


def test_module_and_wheel_have_the_version_of_the_repository() -> None:
    assert metallic_paint_core.__version__ == VERSION
    assert metadata.version("metallic-paint-core") == VERSION
