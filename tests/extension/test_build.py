# SPDX-License-Identifier: Apache-2.0
"""./paint extension: what it writes, and how it refuses."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent


def test_output_must_be_a_folder(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("mine")
    command = [sys.executable, ROOT / "tools" / "extension.py", "--out", file]
    run = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (run.returncode, run.stderr) == (1, f"--out {file}: not a folder.\n")
    assert file.read_text() == "mine"


def test_zip_is_named_by_version_and_platform_and_holds_no_trace_of_this_machine() -> None:
    version = (ROOT / "VERSION").read_text().strip()
    [file] = (ROOT / "build" / "extension").iterdir()
    assert file.name.startswith(f"metallic_paint-{version}-linux-")
    with zipfile.ZipFile(file) as zipped:
        texts = [name for name in zipped.namelist() if name.endswith((".py", ".toml", ".txt"))]
        assert "blender_manifest.toml" in texts
        for name in texts:
            content = zipped.read(name).decode()
            assert str(ROOT) not in content, name
            assert "$" not in content or not name.endswith(".toml")
        library = zipped.read("assets/metallic_paint.blend")
    assert str(ROOT).encode() not in library
