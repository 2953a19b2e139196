# SPDX-License-Identifier: Apache-2.0
"""The Python environments under build/, which uv makes and keeps as requirements/ says.

Run as a program, this prepares the Blender that every machine can have, to take pictures: without
the core, which takes a minute or two to compile.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import IO

from common.processes import (
    BUILD,
    ROOT,
    StepFailedError,
    run_program,
    run_step,
    say,
    telling_time,
)

REQUIREMENTS = ROOT / "requirements"
WHEEL_SOURCES = ("CMakeLists.txt", "VERSION", "pyproject.toml", "core", "bindings")
OWN = BUILD / "env-paint" / "bin"  # of ./paint, which installs uv there
# pip's settings, of which a machine may have some, and uv's of the same meaning.
PIP_AND_UV = {
    "index-url": "UV_DEFAULT_INDEX",
    "extra-index-url": "UV_INDEX",
    "find-links": "UV_FIND_LINKS",
    "cert": "SSL_CERT_FILE",
}


@dataclass(frozen=True)
class Environment:
    name: str
    requirements: tuple[str, ...]
    contents: str
    note: str = ""

    @property
    def folder(self) -> Path:
        return BUILD / f"env-{self.name}"

    @property
    def python(self) -> Path:
        return self.folder / "bin" / "python"

    @property
    def installed(self) -> Path:
        """Holds the digest of what was installed; only a whole environment has it."""
        return self.folder / ".requirements"


@dataclass(frozen=True)
class Blender:
    """A Blender as a Python module, which fits one version of Python only."""

    version: str
    python_version: str

    @property
    def environment(self) -> Environment:
        return Environment(
            self.version,
            (f"blender-{self.version}.txt",),
            f"Blender {self.version}",
            " (350 MB, once)",
        )

    @property
    def python(self) -> Path:
        return self.environment.python


FIRST_BLENDER = Blender("4.5", "3.11")  # the Python of Debian 12
BLENDERS = (FIRST_BLENDER, Blender("5.2", "3.13"))
BLENDER_BETWEEN = Blender("5.0", "3.11")  # only the extension is tested here, with its own wheel
FORM = Environment(
    "tools",
    ("tools.txt", "types.txt", "pytest.txt"),
    "the formatters, the linters and the type checker",
    " (35 MB, once)",
)
ACCURACY = Environment("accuracy", ("accuracy.txt",), "FLIP and the plots", " (80 MB, once)")
FUZZER = Environment("fuzz", ("fuzz.txt", "pytest.txt"), "the fuzzer")
WEBSITE = Environment("site", ("site.txt", "pytest.txt"), "MkDocs", " (30 MB, once)")


def prepare_tool(environment: Environment) -> None:
    """One that runs in the Python at hand, without Blender."""
    with alone():
        extra = _build_requirements() if environment is ACCURACY else []
        _install(environment, Path(sys.executable), extra)


def prepare_measure() -> None:
    """The plots' environment and in it the bindings: no Blender."""
    prepare_tool(ACCURACY)
    with alone():
        _install_bindings(ACCURACY, FIRST_BLENDER.python_version)


def prepare(blender: Blender, *, bindings: bool = True) -> None:
    python = find_python(blender.python_version)
    if python is None:
        raise StepFailedError(f"Blender {blender.version} cannot be had: {lack_of(blender)}.")
    with alone():
        _install(blender.environment, python, _build_requirements())
        if bindings:
            _install_bindings(blender.environment, blender.python_version)


def lack_of(blender: Blender) -> str:
    """What this machine lacks to run that Blender, or nothing."""
    version = blender.python_version
    has_all = find_python(version) is not None
    return "" if has_all else f"no Python {version} with its venv module and headers here"


def prepare_blenders() -> list[Blender]:
    """Prepares every Blender whose Python is on this machine."""
    prepared = []
    for blender in BLENDERS:
        if blender is FIRST_BLENDER or find_python(blender.python_version):
            prepare(blender)
            prepared.append(blender)
        else:
            say(f"Blender {blender.version} is left out: {lack_of(blender)}.")
    return prepared


@cache
def find_python(version: str) -> Path | None:
    on_path = shutil.which(f"python{version}")
    candidates = [Path(sys.executable), *([Path(on_path)] if on_path else [])]
    candidates += sorted(Path.home().glob(f".pyenv/versions/{version}*/bin/python{version}"))
    return next((python for python in candidates if _is_usable(python, version)), None)


def _is_usable(python: Path, version: str) -> bool:
    command = [python, Path(__file__).with_name("usable_python.py"), version]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


@contextmanager
def alone() -> Iterator[None]:
    """Keeps two runs in one tree from changing build/ at the same time. It does not nest.

    Whoever may not write there runs what is installed, and needs no lock.
    """
    with ExitStack() as stack:
        try:
            with suppress(OSError):
                BUILD.mkdir(exist_ok=True)
                _lock(stack.enter_context((BUILD / ".lock").open("w")))
            yield
        except PermissionError as error:
            raise StepFailedError(f"{error.filename}: {error.strerror}.") from error


def _lock(file: IO[str]) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        say("Waiting for another run that is building here…")
        fcntl.flock(file, fcntl.LOCK_EX)


def _install(environment: Environment, python: Path, extra: Sequence[str] = ()) -> None:
    """Asks uv only where a list changed: to it bpy, whose wheel has a wrong tag, is never there."""
    files = [REQUIREMENTS / name for name in environment.requirements]
    digest = digest_of(_with_included(files), extra)
    if environment.python.exists() and _is_current(environment.installed, digest):
        return
    if not environment.installed.exists():
        say(f"Installing {environment.contents}{environment.note}…")
        _uv(
            f"Making the Python environment {environment.folder.name}",
            ["venv", "--clear", "--python", python, environment.folder],
            f"venv-{environment.name}.log",
        )
    else:
        say(f"Bringing the packages of {environment.contents} up to date…")
    lists = [part for file in files for part in ("-r", file)]
    _uv(
        f"Installing {environment.contents}",
        ["pip", "install", "--python", environment.python, *lists, *extra],
        f"install-{environment.name}.log",
    )
    environment.installed.write_text(digest)


def wheel_of(python_version: str) -> Path:
    """The bindings' wheel for that Python, which serves all environments that have it."""
    [wheel] = _wheels(python_version).glob("*.whl")
    return wheel


def _wheels(python_version: str) -> Path:
    return BUILD / f"wheels-{python_version}"


def _install_bindings(environment: Environment, python_version: str) -> None:
    stamp, built = environment.folder / ".bindings", _wheels(python_version)
    sources = digest_of((ROOT / name for name in WHEEL_SOURCES), _build_requirements())
    digest = digest_of([], [sources, environment.installed.read_text()])
    is_built = _is_current(built / ".sources", sources)
    if is_built and _is_current(stamp, digest):
        return
    if not is_built:
        say(f"Compiling the core for Python {python_version} (a minute or two)…")
        shutil.rmtree(built, ignore_errors=True)
        # In the environment itself, so that CMake finds the same paths again.
        options = ["--no-build-isolation", "-C", "cmake.define.METALLIC_PAINT_WERROR=ON"]
        _uv(
            "Compiling the core",
            ["build", "--wheel", "--python", environment.python, *options, "-o", built, ROOT],
            f"wheel-{python_version}.log",
        )
        (built / ".sources").write_text(sources)
    _uv(
        "Installing the core",
        ["pip", "install", "--python", environment.python, "--no-deps", "--reinstall",
         wheel_of(python_version)],
        f"bindings-{environment.name}.log",
    )  # fmt: skip
    stamp.write_text(digest)


def _uv(what: str, arguments: Sequence[str | Path], log_name: str) -> None:
    with telling_time(what):
        run_step(what, ["env", *_uv_settings(), OWN / "uv", *arguments], log_name)


@cache
def _uv_settings() -> list[str]:
    """uv fetches no Python, and looks for packages where pip would, whose settings it ignores."""
    pip = [OWN / "python", "-m", "pip", "config", "list"]
    said = subprocess.run(pip, capture_output=True, text=True, check=False).stdout
    settings = {"UV_PYTHON_DOWNLOADS": "never"}
    for line in said.splitlines():  # global.index-url='…', and :env:. last, which prevails
        name, _, value = line.partition("=")
        if (setting := PIP_AND_UV.get(name.rpartition(".")[2])) and setting not in os.environ:
            settings[setting] = value.strip("'\"")
    return [f"{name}={value}" for name, value in settings.items()]


def _build_requirements() -> list[str]:
    """What builds the wheel, named in one place, installed beside Blender for quick rebuilds."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["build-system"]["requires"]


def _with_included(lists: Iterable[Path]) -> Iterator[Path]:
    for file in lists:
        yield file
        for line in file.read_text().splitlines():
            if line.startswith("-r "):
                yield from _with_included([file.parent / line.removeprefix("-r ").strip()])


def digest_of(paths: Iterable[Path], words: Iterable[str] = ()) -> str:
    """Of these files, of all that the folders among them hold, and of words."""
    digest = hashlib.sha256("\n".join(words).encode())
    files = (file for path in paths for file in (path.rglob("*") if path.is_dir() else [path]))
    for file in sorted(files):
        if file.is_file() and "__pycache__" not in file.parts:
            digest.update(f"\n{file.relative_to(ROOT)}\n".encode() + file.read_bytes())
    return digest.hexdigest()


def _is_current(stamp: Path, digest: str) -> bool:
    return stamp.is_file() and stamp.read_text() == digest


def main() -> int:
    prepare(FIRST_BLENDER, bindings=False)
    return 0


if __name__ == "__main__":
    run_program(main)
