# SPDX-License-Identifier: Apache-2.0
"""Builds the add-on as Blender's extension: for each platform a zip that works in every Blender.

The native module is in the zip for this machine's platform, or in those that --wheels has it for:
compiled for each Python, of which Blender finds its own. The paint works without it.
"""

from __future__ import annotations

import argparse
import platform
import re
import shutil
import tempfile
import zipfile
from collections.abc import Iterable
from pathlib import Path
from string import Template

from common import environments, files
from common.environments import Blender
from common.processes import (
    BUILD,
    LOGS,
    ROOT,
    TOOLS,
    StepFailedError,
    describe,
    run_limited,
    run_program,
    run_step,
    say,
    tail,
    telling_time,
)

ID = "metallic_paint"
NATIVE = "metallic_paint_core"  # the module, its folder in wheel and zip
MACHINES = {"x86_64": "linux-x64", "aarch64": "linux-arm64"}  # Blender's names of platforms
PLATFORMS = {  # and how a wheel's name ends for each
    "linux-arm64": r"(?<!musl)linux\w*_aarch64",
    "linux-x64": r"(?<!musl)linux\w*_x86_64",
    "macos-arm64": r"macosx_\w+_arm64",
    "macos-x64": r"macosx_\w+_x86_64",
    "windows-arm64": r"win_arm64",
    "windows-x64": r"win_amd64",
}
ADDON = ROOT / "addon" / ID
PRESETS = ADDON / "paint" / "presets"
MANIFEST = ROOT / "addon" / "blender_manifest.toml"
TABLE = ROOT / "core" / "coating_library.inc"  # which the shader includes from there
TESTED = BUILD / "extension"  # where tests/extension finds the zip
LIBRARY = BUILD / "asset-library"
MADE_FROM = (
    ADDON / "paint",
    ADDON / "swatches",
    *(ADDON / "scene" / f"{name}.py" for name in ("carrier", "lights", "sky", "wiring")),
    ROOT / "osl",
    TABLE,
    TOOLS / "extension" / "asset_library.py",
)
MOST_LIBRARY_BYTES = 3_000_000


def own_platform() -> str:
    kind = MACHINES.get(platform.machine())
    if kind is None:
        raise StepFailedError(
            f"This machine is {platform.machine()}; the extension is built on "
            f"{' and '.join(MACHINES)}."
        )
    return kind


def build(blender: Blender, out: Path, kind: str, wheels: Iterable[Path]) -> Path:
    """The zip for this platform, with the native module of these wheels; whole or not at all."""
    version = (ROOT / "VERSION").read_text().strip()
    file = out / f"{ID}-{version}-{kind}.zip"
    with environments.alone(), tempfile.TemporaryDirectory(dir=BUILD) as scratch:
        _make_library(blender)
        folder = Path(scratch) / ID
        _fill(folder)
        for wheel in wheels:
            _unpack(wheel, folder)
        text = Template(MANIFEST.read_text(encoding="utf-8"))
        manifest = text.substitute(version=version, platform=kind)
        (folder / MANIFEST.name).write_text(manifest, encoding="utf-8")
        try:
            with files.whole(file) as unfinished:
                _blenders_tool(blender, "build", "--source-dir", folder,
                               "--output-filepath", unfinished)  # fmt: skip
                _blenders_tool(blender, "validate", unfinished)
        except OSError as error:
            raise StepFailedError(f"{file} cannot be written: {error.strerror}.") from error
    return file


def own_wheels(blenders: Iterable[Blender]) -> list[Path]:
    """The bindings for these Blenders, which were prepared before."""
    return [environments.wheel_of(blender.python_version) for blender in blenders]


def wheels_for(kind: str, folder: Path) -> list[Path]:
    """Those in the folder that run on the platform."""
    fits = re.compile(rf"{NATIVE}-.*{PLATFORMS[kind]}\.whl")
    return sorted(wheel for wheel in folder.iterdir() if fits.fullmatch(wheel.name))


def render_swatches(blender: Blender) -> None:
    say("Rendering the presets' swatches (3 minutes)…")
    program = [blender.python, TOOLS, "extension.asset_library"]
    with telling_time("Rendering the swatches"), files.whole(ADDON / "swatches") as folder:
        folder.mkdir()
        run_step("Rendering the swatches", [*program, folder, "--swatches"], "swatches.log")


def _make_library(blender: Blender) -> None:
    """In the oldest Blender: a newer one's file would warn there."""
    stamp = LIBRARY / ".stamp"
    digest = environments.digest_of(MADE_FROM)
    if stamp.is_file() and stamp.read_text() == digest:
        return
    say("Making the asset library of the presets (when they or the shader changed)…")
    shutil.rmtree(LIBRARY, ignore_errors=True)
    command = [blender.python, TOOLS, "extension.asset_library", LIBRARY]
    with telling_time("Making the asset library"):
        run_step("Making the asset library", command, "asset-library.log")
    size = sum(file.stat().st_size for file in LIBRARY.rglob("*") if file.is_file())
    if size > MOST_LIBRARY_BYTES:
        raise StepFailedError(f"The asset library has {size} bytes, over {MOST_LIBRARY_BYTES}.")
    stamp.write_text(digest)


def _fill(folder: Path) -> None:
    """The package as Blender installs it. The shader lies in it as it does in the repository."""
    shutil.copytree(ADDON, folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "osl", folder / "osl")
    (folder / "core").mkdir()
    shutil.copy(TABLE, folder / "core")
    shutil.copytree(ROOT / "LICENSES", folder / "LICENSES")
    shutil.copytree(LIBRARY, folder / "assets", ignore=shutil.ignore_patterns(".stamp"))


def _unpack(wheel: Path, folder: Path) -> None:
    """The module alone; each Python's is a file of another name, the rest is the same in all."""
    with zipfile.ZipFile(wheel) as packed:
        for name in packed.namelist():
            top = name.partition("/")[0]
            if top == NATIVE and not name.endswith((".pyi", "py.typed")):
                packed.extract(name, folder)
            elif top != NATIVE and not top.endswith(".dist-info"):
                raise StepFailedError(f"{wheel}: {top} would not be found beside the module.")


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
    parser.add_argument(
        "--wheels", type=Path, metavar="DIR",
        help="takes the native module from the wheels in this folder, for any platform",
    )  # fmt: skip
    parser.add_argument(
        "--swatches", action="store_true",
        help="renders the presets' committed swatches anew before, when their look has changed",
    )  # fmt: skip
    asked = parser.parse_args()
    out = asked.out
    if out.exists() and not out.is_dir():
        raise StepFailedError(f"--out {out}: not a folder.")
    if asked.wheels is not None and not asked.wheels.is_dir():
        raise StepFailedError(f"--wheels {asked.wheels}: not a folder.")
    blenders = environments.prepare_blenders()
    own = own_platform()
    if asked.swatches:
        render_swatches(blenders[0])
    for kind in PLATFORMS if asked.platform == "all" else [asked.platform or own]:
        if asked.wheels is not None:
            wheels = wheels_for(kind, asked.wheels)
        else:
            wheels = own_wheels(blenders) if kind == own else []
        file = build(blenders[0], out, kind, wheels)
        pythons = " and ".join(wheel.name.split("-")[2] for wheel in wheels)
        native = f"native module for {pythons}" if wheels else "no native module"
        say(f"{file} ({file.stat().st_size / 1e6:.1f} MB, {native})")
    return 0


if __name__ == "__main__":
    run_program(main)
