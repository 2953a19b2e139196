# SPDX-License-Identifier: Apache-2.0
"""Runs verify.py in every Blender at hand and makes one report of their parts."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import fields
from pathlib import Path

from common import bars, environments, files
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
from common.report_folder import check_file

SECONDS = 4 * 3600
OUT = ROOT / "out" / "verify"
FIELDS = {field.name for field in fields(Bar)}


def verify(blender: environments.Blender, arguments: list[str]) -> tuple[int, list[Bar]]:
    """The exit code of one Blender's run and its part of the report."""
    part = BUILD / "verify" / f"blender-{blender.version}.json"
    part.unlink(missing_ok=True)
    out = OUT / f"blender-{blender.version}"
    say(f"Verifying in Blender {blender.version}…")
    program = [blender.python, TOOLS, "verification.verify"]
    command = [*program, "--json", part, "--out", out, *arguments]
    code = run_limited(command, seconds=SECONDS)
    return code, _read(part) if part.is_file() else []


def _read(part: Path) -> list[Bar]:
    found = json.loads(part.read_text())
    for bar in found:
        if bar.keys() != FIELDS:
            raise StepFailedError(
                f"{part.relative_to(ROOT)} holds a bar with the fields {sorted(bar)}; "
                f"the report's form is {sorted(FIELDS)}."
            )
    return [Bar(**bar) for bar in found]


def worst_table(report: Sequence[Bar]) -> Iterator[str]:
    """The lines of a table: of each kind of quantity the worst value over all scenes."""
    kinds: dict[tuple[str, float, str], list[Bar]] = {}
    for bar in report:
        kinds.setdefault((_quantity(bar), bar.limit, bar.unit), []).append(bar)
    rows = [("quantity", "worst", "limit", "scene")]
    for (quantity, limit, unit), alike in kinds.items():
        worst = max(alike, key=_badness)
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


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="paint verify", description="Compares renders with the core, pixel by pixel."
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the report to FILE too")
    arguments, others = parser.parse_known_args()
    file = arguments.json
    if file:
        check_file(file)

    report, broken = [], []
    for blender in environments.prepare_blenders():
        code, found = verify(blender, others)
        report += found
        if code not in (0, 1) or not found:
            broken.append(f"Blender {blender.version} ({describe(code)})")
    if broken:
        raise StepFailedError(f"No whole report: the run failed in {', '.join(broken)}.")
    if file:
        bars.write(report, file)
    text = OUT / "report.txt"
    files.write(text, "".join(f"{bar}\n" for bar in report))
    say("")
    for line in worst_table(report):
        say(line)
    missed = sum(not bar.holds for bar in report)
    say(f"\n{len(report) - missed} bars hold, {missed} do not.")
    say(f"The value of each is in {text.relative_to(ROOT)}.")
    return 1 if missed else 0


if __name__ == "__main__":
    run_program(main)
