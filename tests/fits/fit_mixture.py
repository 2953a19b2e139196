# SPDX-License-Identifier: Apache-2.0
"""Fits the constants of the mixture that stand for finite flakes anew, and tells what they err.

    python3 tests/fits/fit_mixture.py

traces fresh random paints, fits to half of them, and prints the constants as the headers have them
and as fitted, and the errors of both on each half. Some 16 minutes of one core, 14 of them for the
traces (scaled from 40 paints of 10000 photons). --traces FILE keeps the traces, or takes them from
there. Some dozens of paints are too few: the fit then follows their noise.

Nothing in the core changes: whoever wants the numbers copies them to core/mixture.h,
core/diffuse_lobe.h and the headers of the same names in osl/, then runs ./paint test. What is
fitted to independent flakes (kEdge and others) stays: docs/fits.md tries other values.
"""

from __future__ import annotations

import argparse
import random
import tempfile
from pathlib import Path

from fits import BUILD, ROOT, build, run, tell, with_headers

CORE = ROOT / "core"


def copy_headers(folder: Path) -> None:
    """With variables for constants."""
    for name in ("mixture.h", "diffuse_lobe.h"):
        text = (CORE / name).read_text()
        (folder / name).write_text(text.replace("inline constexpr double", "inline double"))
    # It includes both, and a header looks beside itself first.
    (folder / "whole_paint.h").write_text((CORE / "whole_paint.h").read_text())


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--paints", type=int, default=200, metavar="N")
    parser.add_argument("--photons", type=int, default=40000, metavar="N", help="of each light")
    parser.add_argument("--seed", type=int, metavar="SEED", help="of the first paint")
    parser.add_argument("--traces", type=Path, metavar="FILE", help="keep the traces, or take them")
    arguments = parser.parse_args()
    build("metallic_paint_core_compiled")
    seed = random.randrange(2**32) if arguments.seed is None else arguments.seed
    traces = arguments.traces or BUILD / "traces.txt"
    with tempfile.TemporaryDirectory() as folder:
        copy_headers(Path(folder))
        tell("building mixture_fit")
        program = with_headers(Path(folder), "mixture_fit")
        if not (arguments.traces and traces.exists()):
            counts = (arguments.paints, arguments.photons, seed)
            run(program, "trace", traces, *map(str, counts))
        print(run(program, "fit", traces))


if __name__ == "__main__":
    main()
