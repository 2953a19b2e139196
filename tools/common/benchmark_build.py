# SPDX-License-Identifier: Apache-2.0
"""Builds the programs of tests/benchmark."""

from __future__ import annotations

from pathlib import Path

from common.processes import BUILD, ROOT, run_step

FOLDER = BUILD / "tests"


def build(target: str) -> Path:
    """In the folder of the core's tests, configured alike: what is compiled there serves both."""
    options = ["-DMETALLIC_PAINT_WERROR=ON", "-DMETALLIC_PAINT_SANITIZE="]
    run_step(
        "Configuring the measurement",
        ["cmake", "-S", ROOT, "-B", FOLDER, "-G", "Ninja", *options],
        f"configure-{target}.log",
    )
    run_step(
        "Building the measurement",
        ["cmake", "--build", FOLDER, "--target", target],
        f"build-{target}.log",
    )
    return FOLDER / "tests" / "benchmark" / target
