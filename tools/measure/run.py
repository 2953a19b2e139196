# SPDX-License-Identifier: Apache-2.0
"""Measures a paint as the paint industry does, and writes a report with plots."""

from __future__ import annotations

import argparse
from pathlib import Path

from common import environments
from common.processes import ROOT, TOOLS, StepFailedError, run_measurement, run_program
from common.report_folder import MEASURE, check_file
from metallic_paint.paint import presets

SECONDS = 1800


def main() -> int:
    parser = argparse.ArgumentParser(prog="paint measure", description=__doc__)
    parser.add_argument(
        "preset", metavar="PRESET", help=f"a JSON file, or one of {', '.join(presets.names())}"
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR",
        help="folder for README.md and its picture (out/measure/PRESET)",
    )  # fmt: skip
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the numbers to FILE too")
    parser.add_argument("--quick", action="store_true", help="a tenth of the photons and flakes")
    arguments = parser.parse_args()

    out = arguments.out or ROOT / "out" / "measure" / Path(arguments.preset).stem
    try:
        presets.load(arguments.preset)
    except presets.PresetError as error:
        raise StepFailedError(str(error)) from error
    MEASURE.check(out)
    if arguments.json:
        check_file(arguments.json, out)
    environments.prepare_measure()
    report = [environments.ACCURACY.python, TOOLS, "measure.report"]
    report += [arguments.preset, "--out", out, *["--quick"] * arguments.quick]
    if arguments.json:
        report += ["--json", arguments.json]
    return run_measurement("The measurement", report, seconds=SECONDS)


if __name__ == "__main__":
    run_program(main)
