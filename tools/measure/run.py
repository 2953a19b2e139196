# SPDX-License-Identifier: Apache-2.0
"""Measures a paint as the paint industry does, or fits one to what was measured; with a report."""

from __future__ import annotations

import argparse
from pathlib import Path

from common import environments
from common.processes import ROOT, TOOLS, StepFailedError, run_measurement, run_program
from common.report_folder import MEASURE, check_file, fit_folder
from metallic_paint.paint import presets

SECONDS = 1800
DIAMETER = 20.0  # um, as Flake Diameter's own default
DIAMETERS = (1.0, 1000.0)


def main() -> int:
    parser = argparse.ArgumentParser(prog="paint measure", description=__doc__)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "preset", metavar="PRESET", nargs="?",
        help=f"a JSON file, or one of {', '.join(presets.names())}",
    )  # fmt: skip
    what.add_argument(
        "--fit", metavar="NAME",
        help="fit a paint to a measured BRDF: one of MERL's metallic paints by name, or a file, "
        ".csv (theta_light, theta_view, phi in degrees; red, green, blue in 1/sr) or .binary "
        "(MERL's)",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=Path, metavar="DIR",
        help="folder for README.md and its pictures (out/measure/PRESET, out/measure/fit-NAME)",
    )  # fmt: skip
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the numbers to FILE too")
    parser.add_argument(
        "--quick", action="store_true", help="a tenth of the photons, flakes or steps"
    )
    parser.add_argument(
        "--diameter", type=float, default=DIAMETER, metavar="UM",
        help=f"of --fit: of the flakes, which no BRDF tells ({DIAMETER:g})",
    )  # fmt: skip
    arguments = parser.parse_args()

    if not DIAMETERS[0] <= arguments.diameter <= DIAMETERS[1]:
        raise StepFailedError(
            f"--diameter is {arguments.diameter:g}, but must be from {DIAMETERS[0]:g} to "
            f"{DIAMETERS[1]:g} um."
        )
    given = arguments.preset or arguments.fit
    name = Path(given).stem
    if arguments.preset:
        try:
            presets.load(given)
        except presets.PresetError as error:
            raise StepFailedError(str(error)) from error
    kind = MEASURE if arguments.preset else fit_folder(name)
    out = arguments.out or ROOT / "out" / "measure" / (name if arguments.preset else f"fit-{name}")
    kind.check(out)
    if arguments.json:
        check_file(arguments.json, out)
    environments.prepare_measure()
    report = [environments.ACCURACY.python, TOOLS]
    report += ["measure.report"] if arguments.preset else ["measure.fit_report"]
    report += [given, "--out", out, *["--quick"] * arguments.quick]
    if arguments.fit:
        report += ["--diameter", str(arguments.diameter)]
    if arguments.json:
        report += ["--json", arguments.json]
    return run_measurement("The measurement", report, seconds=SECONDS)


if __name__ == "__main__":
    run_program(main)
