# SPDX-License-Identifier: Apache-2.0
"""The tests get the paint's group compiled, from a library as the extension's is: to compile its
text anew took two seconds of each test that paints.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import bpy
import pytest
from common.processes import BUILD
from metallic_paint.paint import material, shader

__all__ = ["compiled_shader"]


@pytest.fixture(scope="session", autouse=True)
def compiled_shader() -> None:
    """Made by the first process that asks for this text in this Blender."""
    digest = material.digest(shader.source())
    folder = BUILD / "test-library" / f"{bpy.app.version_string}-{digest[:16]}"
    library = folder / shader.LIBRARY.name
    if not folder.exists():
        folder.parent.mkdir(parents=True, exist_ok=True)
        made = Path(tempfile.mkdtemp(dir=folder.parent))
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.data.libraries.write(str(made / library.name), {material.node_group()}, fake_user=True)
        (made / library.name).with_suffix(shader.DIGEST).write_text(digest, encoding="ascii")
        try:
            made.rename(folder)
        except OSError:  # another process was sooner
            shutil.rmtree(made)
    shader.LIBRARY = library
