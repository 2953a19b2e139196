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
    """A folder of ours that is closed to us; root, to whom nothing is, becomes another user."""
    user = os.geteuid()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if user == 0:
            os.chown(folder, NOBODY, -1)
            os.setresuid(NOBODY, NOBODY, user)
        folder.chmod(0)
        try:
            yield folder
        finally:
            folder.chmod(0o700)
            os.setresuid(user, user, user)
