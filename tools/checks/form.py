# SPDX-License-Identifier: Apache-2.0
"""The checks of form: formatters, linters, types, and the licence line of every source file."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

from common.environments import TOOLS, TYPES
from common.processes import BUILD, ROOT

NOT_OURS = {"build", "out", "__pycache__"}
SOURCE_SUFFIXES = {".cpp", ".h", ".osl", ".py", ".pyi", ".sh", ".cmake"}
SOURCE_NAMES = {"CMakeLists.txt", "pyproject.toml", "paint", "run"}
GPL_FOLDERS = {"addon"}


def commands() -> dict[str, list[str | Path]]:
    """Each check by name: a command that fails if something is out of form."""
    tools = TOOLS.python.parent
    cpp = [file for file in sources() if file.suffix in {".cpp", ".h"} and not _is_osl(file)]
    scripts = [file for file in sources() if file.name in {"paint", "run"}]
    checks: dict[str, list[str | Path]] = {
        "ruff format": [tools / "ruff", "format", "--diff", "--no-cache", ROOT],
        "ruff check": [tools / "ruff", "check", "--no-cache", ROOT],
        "clang-format": [tools / "clang-format", "--dry-run", "--Werror", *cpp],
    }
    if shellcheck := shutil.which("shellcheck"):
        checks["shellcheck"] = [shellcheck, *scripts]
    return checks


def types() -> list[str | Path]:
    """The add-on's, against those of Blender and of the native module."""
    options = ["--config-file", ROOT / "pyproject.toml", "--cache-dir", BUILD / "mypy"]
    return [TYPES.python, "-m", "mypy", *options, ROOT / "addon" / "metallic_paint"]


def sources() -> Iterator[Path]:
    yield from _sources(ROOT)


def _sources(folder: Path) -> Iterator[Path]:
    for path in sorted(folder.iterdir()):
        hidden = path.name.startswith(".") and path.name != ".ci"
        if path.is_dir() and not hidden and path.name not in NOT_OURS:
            yield from _sources(path)
        elif path.is_file() and (path.suffix in SOURCE_SUFFIXES or path.name in SOURCE_NAMES):
            yield path


def without_licence_line() -> list[str]:
    """One sentence for each source file that does not begin with its licence."""
    complaints = []
    for file in sources():
        name = file.relative_to(ROOT)
        licence = "GPL-3.0-or-later" if name.parts[0] in GPL_FOLDERS else "Apache-2.0"
        line = f"SPDX-License-Identifier: {licence}"
        if not any(text.endswith(line) for text in file.read_text().splitlines()[:3]):
            complaints.append(f"{name} lacks the line “{line}” at its top.")
    return complaints


def _is_osl(file: Path) -> bool:
    return file.relative_to(ROOT).parts[0] == "osl"  # the shader's headers are not C++
