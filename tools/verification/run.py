# SPDX-License-Identifier: Apache-2.0
"""Runs verify.py in every Blender at hand and makes one report of their parts."""

from __future__ import annotations

import argparse
import json
import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import asdict, fields
from pathlib import Path

from common import environments
from common.bars import Bar
from common.processes import (
    BUILD,
    ROOT,
    TOOLS,
    StepFailedError,
    describe,
    run_limited,
    run_program,
    say,
)

SECONDS = 4 * 3600
OUT = ROOT / "out" / "verify"
FIELDS = {field.name for field in fields(Bar)}


def verify(blender: environments.Blender, arguments: list[str]) -> tuple[int, list[Bar]]:
    """The exit code of one Blender's run and its part of the report."""
    part = BUILD / "verify" / f"blender-{blender.version}.json"
    part.parent.mkdir(parents=True, exist_ok=True)
    part.unlink(missing_ok=True)
    out = OUT / f"blender-{blender.version}"
    out.mkdir(parents=True, exist_ok=True)
    say(f"Verifying in Blender {blender.version}…")
    program = [blender.python, TOOLS, "verification.verify"]
    command = [*program, "--json", part, "--out", out, *arguments]
    code = run_limited(command, seconds=SECONDS)
    return code, _read(part) if part.is_file() else []


def _read(part: Path) -> list[Bar]:
    bars = json.loads(part.read_text())
    for bar in bars:
        if bar.keys() != FIELDS:
            raise StepFailedError(
                f"{part.relative_to(ROOT)} holds a bar with the fields {sorted(bar)}; "
                f"the report's form is {sorted(FIELDS)}."
            )
    return [Bar(**bar) for bar in bars]


def worst_table(report: Sequence[Bar]) -> Iterator[str]:
    """The lines of a table: of each kind of quantity the worst value over all scenes."""
    kinds: dict[tuple[str, float, str], list[Bar]] = {}
    for bar in report:
        kinds.setdefault((_quantity(bar), bar.limit, bar.unit), []).append(bar)
    rows = [("quantity", "worst", "limit", "scene")]
    for (quantity, limit, unit), bars in kinds.items():
        worst = max(bars, key=_badness)
        what, _, bound = quantity.rpartition(", ")
        value = "not measured" if worst.value is None else f"{worst.value:.7g}"
        of_unit = "" if unit == "1" else f" {unit}"
        scene = worst.name.removesuffix(f": {quantity}")
        rows.append((what, value, f"{bound} {limit:.7g}{of_unit}", scene))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True))
        yield "  ".join(cells).rstrip()


def _quantity(bar: Bar) -> str:
    return bar.name.rpartition(": ")[2]


def _badness(bar: Bar) -> float:
    if bar.value is None:
        return math.inf
    return -bar.value if bar.name.endswith("at least") else bar.value


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
        write_whole(file, json.dumps([asdict(bar) for bar in report], indent=2) + "\n")
    text = OUT / "report.txt"
    write_whole(text, "".join(f"{bar}\n" for bar in report))
    say("")
    for line in worst_table(report):
        say(line)
    missed = sum(not bar.holds for bar in report)
    say(f"\n{len(report) - missed} bars hold, {missed} do not.")
    say(f"The value of each is in {text.relative_to(ROOT)}.")
    return 1 if missed else 0


if __name__ == "__main__":
    run_program(main)
