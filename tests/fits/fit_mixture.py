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
import importlib.util
import itertools
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

from fits import BUILD, ROOT, build, run, tell, with_headers

CORE = ROOT / "core"
FIRST_STEP = 0.15  # of each constant, about the header's
EVALUATIONS = 50  # of the cost for each constant, at most
LEAST_GAIN = 1e-4  # of the cost


def with_variables() -> dict[str, str]:
    """Texts of the headers, with variables for constants."""
    return {
        name: (CORE / name).read_text().replace("inline constexpr double", "inline double")
        for name in ("mixture.h", "diffuse_lobe.h")
    }


def go_on_with_scipy() -> None:
    """Begins anew in the environment that has it, where this Python does not."""
    if importlib.util.find_spec("scipy"):
        return
    sys.path.insert(0, str(ROOT / "tools"))
    from common import environments

    environments.prepare_tool(environments.ACCURACY)
    os.execv(environments.ACCURACY.python, [environments.ACCURACY.python, *sys.argv])


class Traces:
    """mixture_fit.cpp, which has read them."""

    def __init__(self, program: Path, traces: Path) -> None:
        self._process = subprocess.Popen(
            [program, "answer", traces], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.groups = dict(self._group() for _ in range(2))

    def ask(self, question: str) -> str:
        self._process.stdin.write(f"{question}\n")
        self._process.stdin.flush()
        return self._answer()

    def _answer(self) -> str:
        if line := self._process.stdout.readline():
            return line
        raise SystemExit("mixture_fit has ended; what it lacks stands above")

    def _group(self) -> tuple[str, dict[str, float]]:
        name, *constants = self._answer().split()
        return name, dict(zip(constants[::2], map(float, constants[1::2]), strict=True))


def fit(traces: Traces, group: str) -> list[float]:
    """Nelder and Mead's simplex; the traces keep the constants of the least cost."""
    from scipy.optimize import OptimizeResult, minimize

    start = list(traces.groups[group].values())
    corners = [start]
    for i, value in enumerate(start):
        corners.append([*start[:i], value * (1 + FIRST_STEP), *start[i + 1 :]])

    def cost(values: list[float]) -> float:
        return float(traces.ask(" ".join([group, *map(repr, map(float, values))])))

    steps = itertools.count(1)

    def say(intermediate_result: OptimizeResult) -> None:
        if (step := next(steps)) % 10 == 0:
            tell(f"{group}: {step} steps, cost {intermediate_result.fun:.5f}")

    # Any distance of the corners will do: their costs decide.
    stop = {"fatol": LEAST_GAIN * cost(start), "xatol": float("inf")}
    stop |= {"maxfev": EVALUATIONS * len(start), "initial_simplex": corners}
    found = minimize(cost, start, method="Nelder-Mead", options=stop, callback=say).x.tolist()
    cost(found)
    return found


def fit_and_print(traces: Traces) -> None:
    def errors(when: str) -> str:
        return traces.ask(f"errors fitted half, {when}") + traces.ask(f"check other half, {when}")

    rows = errors("before")
    fitted = {group: fit(traces, group) for group in traces.groups}
    rows += errors("after")
    print("| constant | in the header | fitted |\n| --- | ---: | ---: |")
    for group, constants in traces.groups.items():
        for (name, value), new in zip(constants.items(), fitted[group], strict=True):
            print(f"| {name} | {value:g} | {new:.4g} |")
    print(
        "\n| | radiances | within 5 % | within 10 % | mean error, relative | albedos | error of M, "
        f"95 % |\n| --- | ---: | ---: | ---: | ---: | ---: | ---: |\n{rows}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--paints", type=int, default=200, metavar="N")
    parser.add_argument("--photons", type=int, default=40000, metavar="N", help="of each light")
    parser.add_argument("--seed", type=int, metavar="SEED", help="of the first paint")
    parser.add_argument("--traces", type=Path, metavar="FILE", help="keep the traces, or take them")
    arguments = parser.parse_args()
    go_on_with_scipy()
    build("metallic_paint_core_compiled")
    seed = random.randrange(2**32) if arguments.seed is None else arguments.seed
    traces = arguments.traces or BUILD / "traces.txt"
    with tempfile.TemporaryDirectory() as folder:
        tell("building mixture_fit")
        program = with_headers(with_variables(), Path(folder), "mixture_fit")
        if not (arguments.traces and traces.exists()):
            counts = (arguments.paints, arguments.photons, seed)
            run(program, "trace", traces, *map(str, counts))
        fit_and_print(Traces(program, traces))


if __name__ == "__main__":
    main()
