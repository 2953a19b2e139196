# SPDX-License-Identifier: Apache-2.0
"""The form of the sources: formatters, linters, types, and the licence line of each."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from common.processes import BUILD, ROOT

PROGRAMS = Path(sys.prefix) / "bin"
NOT_OURS = {"build", "out", "__pycache__"}
SOURCE_SUFFIXES = {".cpp", ".h", ".osl", ".py", ".pyi", ".sh", ".cmake"}
SOURCE_NAMES = {"CMakeLists.txt", "pyproject.toml", "paint", "run"}
GPL_FOLDERS = {"addon"}


def sources(folder: Path = ROOT) -> Iterator[Path]:
    for path in sorted(folder.iterdir()):
        hidden = path.name.startswith(".") and path.name != ".ci"
        if path.is_dir() and not hidden and path.name not in NOT_OURS:
            yield from sources(path)
        elif path.is_file() and (path.suffix in SOURCE_SUFFIXES or path.name in SOURCE_NAMES):
            yield path


def assert_content(*command: str | Path) -> None:
    """That a program finds nothing to complain of."""
    done = subprocess.run(
        command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    assert done.returncode == 0, done.stdout


def test_python_is_formatted() -> None:
    assert_content(PROGRAMS / "ruff", "format", "--diff", "--no-cache", ROOT)


def test_python_has_no_lint() -> None:
    assert_content(PROGRAMS / "ruff", "check", "--no-cache", ROOT)


def test_cpp_is_formatted() -> None:
    """The shader's headers are not C++."""
    files = [file for file in sources() if file.suffix in {".cpp", ".h"}]
    cpp = [file for file in files if file.relative_to(ROOT).parts[0] != "osl"]
    assert cpp
    assert_content(PROGRAMS / "clang-format", "--dry-run", "--Werror", *cpp)


def test_shell_scripts_have_no_lint() -> None:
    shellcheck = shutil.which("shellcheck")
    if shellcheck is None:
        pytest.skip("no shellcheck here")
    scripts = [file for file in sources() if file.name in {"paint", "run"}]
    assert scripts
    assert_content(shellcheck, *scripts)


def test_types_of_the_add_on_are_those_of_blender_and_of_the_native_module() -> None:
    options = ["--config-file", ROOT / "pyproject.toml", "--cache-dir", BUILD / "mypy"]
    assert_content(sys.executable, "-m", "mypy", *options, ROOT / "addon" / "metallic_paint")


def test_every_source_begins_with_its_licence() -> None:
    lacking = []
    for file in sources():
        name = file.relative_to(ROOT)
        licence = "GPL-3.0-or-later" if name.parts[0] in GPL_FOLDERS else "Apache-2.0"
        line = f"SPDX-License-Identifier: {licence}"
        if not any(text.endswith(line) for text in file.read_text().splitlines()[:3]):
            lacking.append(f"{name} lacks the line “{line}” at its top.")
    assert not lacking
