# SPDX-License-Identifier: Apache-2.0
"""These tests need Python and the core's bindings: no Blender, which they could not import."""

import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.modules["bpy"] = None

NOBODY = 65534


@pytest.fixture
def closed() -> Iterator[Path]:
    """A folder with a file, both closed to us; root, to whom nothing is, becomes another user."""
    user = os.geteuid()
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "file").touch(0)
        for path in (Path(folder, "file"), Path(folder)):
            path.chmod(0)
        if user == 0:
            os.setresuid(NOBODY, NOBODY, user)
        try:
            yield Path(folder)
        finally:
            os.setresuid(user, user, user)
            Path(folder).chmod(0o700)
