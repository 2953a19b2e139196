# SPDX-License-Identifier: Apache-2.0
"""Runs tools/verify.py in every Blender at hand and makes one report of their parts."""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path

import environments
from processes import (
    BUILD,
    ROOT,
    StepFailedError,
    describe,
    run_limited,
    say,
    stop_children_on_sigterm,
)

SECONDS = 4 * 3600
FIELDS = {"name", "value", "unit", "limit", "holds"}


def verify(blender: environments.Blender, arguments: list[str]) -> tuple[int, list[dict]]:
    """The exit code of one Blender's run and its part of the report."""
    part = BUILD / "verify" / f"blender-{blender.version}.json"
    part.parent.mkdir(parents=True, exist_ok=True)
    part.unlink(missing_ok=True)
    out = ROOT / "out" / "verify" / f"blender-{blender.version}"
    out.mkdir(parents=True, exist_ok=True)
    say(f"Verifying in Blender {blender.version}…")
    script = ROOT / "tools" / "verify.py"
    command = [blender.python, script, "--json", part, "--out", out, *arguments]
    code = run_limited(command, seconds=SECONDS)
    return code, _read(part) if part.is_file() else []


def _read(part: Path) -> list[dict]:
    bars = json.loads(part.read_text())
    for bar in bars:
        if bar.keys() != FIELDS:
            raise StepFailedError(
                f"{part.relative_to(ROOT)} holds a bar with the fields {sorted(bar)}; "
                f"the report's form is {sorted(FIELDS)}."
            )
    return bars


def _make_folder(file: Path) -> None:
    """Finds out before hours of rendering whether the report can be written."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StepFailedError(f"--json {file}: no folder to write to ({error}).") from error


def write_whole(file: Path, text: str) -> None:
    """Leaves the earlier file in place until the new one is complete."""
    partial = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        partial.write_text(text)
        partial.replace(file)
    finally:
        partial.unlink(missing_ok=True)


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="paint verify", description="Compares renders with the core, pixel by pixel."
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the report to FILE too")
    arguments, others = parser.parse_known_args()
    file = arguments.json
    if file:
        _make_folder(file)

    report, broken = [], []
    for blender in environments.prepare_blenders():
        code, bars = verify(blender, others)
        report += bars
        if code not in (0, 1) or not bars:
            broken.append(f"Blender {blender.version} ({describe(code)})")
    if broken:
        raise StepFailedError(f"No whole report: the run failed in {', '.join(broken)}.")
    if file:
        write_whole(file, json.dumps(report, indent=2) + "\n")
    missed = [bar["name"] for bar in report if not bar["holds"]]
    say(f"{len(report) - len(missed)} bars hold, {len(missed)} do not.")
    return 1 if missed else 0


if __name__ == "__main__":
    stop_children_on_sigterm()
    try:
        sys.exit(main())
    except StepFailedError as error:
        sys.exit(str(error))
