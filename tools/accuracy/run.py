# SPDX-License-Identifier: Apache-2.0
"""Measures what each choice of the model costs and errs, and writes a report of it."""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

from common import environments
from common.benchmark_build import build
from common.processes import BUILD, ROOT, TOOLS, run_measurement, run_program
from common.report_folder import ACCURACY, check_file

SECONDS = 1800
MEASUREMENTS = BUILD / "accuracy"


def main() -> int:
    parser = argparse.ArgumentParser(prog="paint accuracy", description=__doc__)
    parser.add_argument(
        "--out", type=Path, default=ROOT / "out" / "accuracy", metavar="DIR",
        help="folder for README.md and its pictures (out/accuracy)",
    )  # fmt: skip
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the bars to FILE too")
    parser.add_argument("--quick", action="store_true", help="smaller pictures and samples")
    arguments = parser.parse_args()

    ACCURACY.check(arguments.out)
    if arguments.json:
        check_file(arguments.json, arguments.out)
    environments.prepare_tool(environments.ACCURACY)
    with environments.alone():
        program = build("trade")
        shutil.rmtree(MEASUREMENTS, ignore_errors=True)
        MEASUREMENTS.mkdir(parents=True)
        measuring = [program, MEASUREMENTS, *["--quick"] * arguments.quick]
        run_measurement("The measurement", measuring, seconds=SECONDS)
        report = [environments.ACCURACY.python, TOOLS, "accuracy.report"]
        report += ["--measurements", MEASUREMENTS, "--out", arguments.out]
        if arguments.json:
            report += ["--json", arguments.json]
        return run_measurement("The report", report, good=(0, 1), seconds=SECONDS)


if __name__ == "__main__":
    run_program(main)
