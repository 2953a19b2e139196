# SPDX-License-Identifier: Apache-2.0
"""Measures what the paint costs beside what artists use today, side by side.

Waits, memory, time per sample, growth, time to equal error, and the core's own speed.
"""

from __future__ import annotations

import argparse
import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

from common import bars, environments
from common.benchmark_build import build
from common.environments import FIRST_BLENDER, Blender
from common.kept import keep
from common.processes import ROOT, TOOLS, StepFailedError, run_measurement, run_program, say
from common.report_folder import BENCH, REPORT, check_file

from bench.instructions import instructions
from bench.rows import (
    CORE,
    ERROR,
    INSTRUCTIONS,
    LONG,
    PARTS,
    RENDERED,
    SERIES,
    WORK,
    Found,
    parse,
    read,
    write,
)
from bench.waits import waits

FOUND = "found.json"


def measure(blender: Blender, part: str, quick: bool) -> list[Found]:
    say(f"Measuring {part} in Blender {blender.version}…")
    file = WORK / f"{part}-{blender.version}.json"
    program = [blender.python, TOOLS, "bench.measure", part, "--json", file]
    run_measurement(f"Measuring {part}", [*program, *["--quick"] * quick])
    return read(file)


def measure_core(quick: bool) -> list[Found]:
    say("Measuring the core…")
    file = WORK / f"{CORE}.json"
    with environments.alone():
        program = build("speed")
    command = [environments.ACCURACY.python, TOOLS, "bench.core", program, "--json", file]
    run_measurement("Measuring the core", [*command, *["--quick"] * quick])
    return read(file)


def main() -> int:
    parser = argparse.ArgumentParser(prog="paint bench", description=__doc__)
    parser.add_argument(
        "--out", type=Path, default=ROOT / "out" / "bench", metavar="DIR",
        help="folder for README.md and its plots (out/bench)",
    )  # fmt: skip
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the bars to FILE too")
    parser.add_argument(
        "--quick",
        action="store_true",
        help="few repetitions, in the first Blender alone, no absent parts and no instructions",
    )
    parser.add_argument(
        "--only", default="", metavar="TEXT", help=f"of {', '.join(PARTS)} those with TEXT in them"
    )
    parser.add_argument(
        "--again", action="store_true", help="measures also what was measured on these sources"
    )
    arguments = parser.parse_args()

    start = time.monotonic()
    quick = arguments.quick
    parts = [part for part in PARTS if not (quick and part in LONG)]
    chosen = [part for part in parts if arguments.only in part]
    if not chosen:
        raise StepFailedError(f"--only {arguments.only}: none of {', '.join(parts)}.")
    BENCH.check(arguments.out)
    if arguments.json:
        check_file(arguments.json, arguments.out)
    environments.prepare_measure()
    if quick:
        environments.prepare(FIRST_BLENDER)
    blenders = [FIRST_BLENDER] if quick else environments.prepare_blenders()
    kept = keep("bench", again=arguments.again, quick=quick)
    if not kept:
        shutil.rmtree(WORK, ignore_errors=True)
    SERIES.mkdir(parents=True, exist_ok=True)

    def once(name: str, measure: Callable[[], Sequence[Found]]) -> list[Found]:
        if name in kept:
            say(f"Measured on these sources before: {name}. With --again it is measured anew.")
        else:
            kept.add(name, [asdict(part) for part in measure()])
        return parse(kept[name])

    found: list[Found] = []
    for blender in blenders:
        where = f"in Blender {blender.version}"
        if {"waits", "memory"} & set(chosen):
            both = once(f"waits and memory {where}", partial(waits, blender, WORK, quick))
            found += [part for part in both if part.part in chosen]
        for part in RENDERED:
            if part in chosen:
                found += once(f"{part} {where}", partial(measure, blender, part, quick))
    if INSTRUCTIONS in chosen:
        found += once(INSTRUCTIONS, lambda: [instructions(FIRST_BLENDER, WORK)])
    if ERROR in chosen:
        found += once(ERROR, partial(measure, FIRST_BLENDER, ERROR, quick))
    if CORE in chosen:
        found += once(CORE, partial(measure_core, quick))
    write(found, WORK / FOUND)
    with BENCH.fill(arguments.out) as folder:
        program = [environments.ACCURACY.python, TOOLS, "bench.report", "--found", WORK / FOUND]
        run_measurement("The report", [*program, "--out", folder, *["--quick"] * quick])
    judged = [bar for part in found for bar in part.bars()]
    return bars.conclude(judged, arguments.json, arguments.out / REPORT, start)


if __name__ == "__main__":
    run_program(main)
