# SPDX-License-Identifier: Apache-2.0
"""The Python environments under build/, brought up to date only when their inputs changed.

Run as a program, this prepares the Blender that every machine can have.
"""

from __future__ import annotations

import fcntl
import hashlib
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from common.processes import BUILD, ROOT, StepFailedError, run_program, run_step, say

REQUIREMENTS = ROOT / "requirements"
WHEEL_SOURCES = ("CMakeLists.txt", "VERSION", "pyproject.toml", "core", "bindings")


@dataclass(frozen=True)
class Environment:
    name: str
    requirements: Path
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
        """Holds the digest of what pip installed; only a whole environment has it."""
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
            REQUIREMENTS / f"blender-{self.version}.txt",
            f"Blender {self.version}",
            " (350 MB, once)",
        )

    @property
    def python(self) -> Path:
        return self.environment.python


FIRST_BLENDER = Blender("4.5", "3.11")  # the Python of Debian 12
BLENDERS = (FIRST_BLENDER, Blender("5.2", "3.13"))
BLENDER_BETWEEN = Blender("5.0", "3.11")  # only the extension is tested here, with its own wheel
TOOLS = Environment("tools", REQUIREMENTS / "tools.txt", "the formatters and linters")
ACCURACY = Environment(
    "accuracy", REQUIREMENTS / "accuracy.txt", "FLIP and the plots", " (80 MB, once)"
)
TYPES = Environment(
    "types", REQUIREMENTS / "types.txt", "the type checker and Blender's types", " (35 MB, once)"
)
FUZZER = Environment("fuzz", REQUIREMENTS / "fuzz.txt", "the fuzzer")
WHEELS = Environment("wheels", REQUIREMENTS / "wheels.txt", "auditwheel")


def prepare_tool(environment: Environment) -> None:
    """One that runs in the Python at hand, without Blender."""
    with alone():
        extra = _build_requirements() if environment is ACCURACY else []
        _install(environment, Path(sys.executable), extra)


def prepare_measure() -> None:
    """The plots' environment and in it the bindings: no Blender."""
    prepare_tool(ACCURACY)
    with alone():
        _install_bindings(ACCURACY, "{}.{}".format(*sys.version_info))


def prepare(blender: Blender, *, bindings: bool = True) -> None:
    python = find_python(blender.python_version)
    if python is None:
        raise StepFailedError(
            f"Blender {blender.version} needs a Python {blender.python_version} with its venv "
            "module and its headers, and there is none here."
        )
    with alone():
        _install(blender.environment, python, _build_requirements() if bindings else [])
        if bindings:
            _install_bindings(blender.environment, blender.python_version)


def prepare_blenders() -> list[Blender]:
    """Prepares every Blender whose Python is on this machine."""
    prepared = []
    for blender in BLENDERS:
        if blender is FIRST_BLENDER or find_python(blender.python_version):
            prepare(blender)
            prepared.append(blender)
        else:
            say(f"Blender {blender.version} is left out: no Python {blender.python_version} here.")
    return prepared


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
    """Keeps two runs in one tree from changing build/ at the same time. It does not nest."""
    BUILD.mkdir(exist_ok=True)
    with (BUILD / ".lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            say("Waiting for another run that is building here…")
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _install(environment: Environment, python: Path, extra: list[str]) -> None:
    digest = digest_of(_with_included(environment.requirements), extra)
    whole = environment.python.exists() and environment.installed.is_file()
    if whole and _is_current(environment.installed, digest):
        return
    if whole:
        say(f"Bringing the packages of {environment.contents} up to date…")
    else:
        say(f"Installing {environment.contents}{environment.note}…")
        environment.installed.unlink(missing_ok=True)
        run_step(
            f"Making the Python environment {environment.folder.name}",
            [python, "-m", "venv", "--clear", environment.folder],
            f"venv-{environment.name}.log",
        )
    pip = [environment.python, "-m", "pip", "install", "--progress-bar=off"]
    run_step(
        f"Installing {environment.contents}",
        [*pip, "-r", environment.requirements, *extra],
        f"pip-{environment.name}.log",
    )
    environment.installed.write_text(digest)


def wheels(python_version: str) -> Path:
    """Where the bindings' wheel for that Python is, for all environments that have it."""
    return BUILD / f"wheels-{python_version}"


def _install_bindings(environment: Environment, python_version: str) -> None:
    stamp = environment.folder / ".bindings"
    sources = digest_of((ROOT / name for name in WHEEL_SOURCES), _build_requirements())
    digest = digest_of([], [sources, environment.installed.read_text()])
    built = wheels(python_version)
    is_built = _is_current(built / ".sources", sources)
    if is_built and _is_current(stamp, digest):
        return
    pip = [environment.python, "-m", "pip"]
    if not is_built:
        say(f"Building the bindings for Python {python_version}…")
        shutil.rmtree(built, ignore_errors=True)
        strict = "--config-settings=cmake.define.METALLIC_PAINT_WERROR=ON"
        options = ["--no-deps", "--no-build-isolation", strict, "--wheel-dir", built]
        run_step(
            "Building the bindings",
            [*pip, "wheel", *options, ROOT],
            f"wheel-{python_version}.log",
        )
        (built / ".sources").write_text(sources)
    run_step(
        "Installing the bindings",
        [*pip, "install", "--no-deps", "--force-reinstall", *built.glob("*.whl")],
        f"install-{environment.name}.log",
    )
    stamp.write_text(digest)


def _build_requirements() -> list[str]:
    """What builds the wheel, named in one place, installed beside Blender for quick rebuilds."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["build-system"]["requires"]


def _with_included(requirements: Path) -> Iterator[Path]:
    yield requirements
    for line in requirements.read_text().splitlines():
        if line.startswith("-r "):
            yield from _with_included(requirements.parent / line.removeprefix("-r ").strip())


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
    prepare(FIRST_BLENDER)
    return 0


if __name__ == "__main__":
    run_program(main)
