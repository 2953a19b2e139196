# SPDX-License-Identifier: Apache-2.0
"""The core's speed, over numpy arrays and in one thread."""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import metallic_paint_core as core
import numpy as np
from common.processes import run_program
from metallic_paint.paint import Paint, core_paint

from bench.rows import CORE, Found, Row, ratios, write

SMALL, LARGE = 0.1, 1e4  # ⟨N⟩
MANY = 1 << 15  # pixels in a batch
CALLS = 300
FEW, MORE = 1, 65  # pixels in a call: their difference is work, the rest is the call

MOST_MAKING, MOST_CALL = 0.05, 2e-6  # s


def processor_time(call: Callable[[], object], count: int = 1) -> float:
    """s of one call."""
    start = time.process_time()
    for _ in range(count):
        call()
    return (time.process_time() - start) / count


class Batch:
    """Pixels of a level paint under one sun, each with about that ⟨N⟩."""

    def __init__(self, mean_count: float, pixels: int) -> None:
        self.paint = core_paint(Paint())
        towards = np.array([math.sin(0.4), 0, math.cos(0.4)])
        sun = core.Light(core.LightKind.parallel, -towards * [1, 1, -1], math.sin(0.00465))
        self.lights = [sun]
        column = np.arange(pixels, dtype=np.int32)
        self.places = {
            "position": np.zeros((pixels, 3)), "normal": np.tile([0.0, 0.0, 1.0], (pixels, 1)),
            "view": np.tile(towards, (pixels, 1)), "footprint": np.ones(pixels),
            "pixel": np.stack([column % 256, column // 256], axis=1),
        }  # fmt: skip
        self.places["footprint"] *= mean_count / self.evaluate("double")["mean_count"][0, 0]

    def evaluate(self, precision: str) -> dict[str, np.ndarray]:
        return core.evaluate(self.paint, self.lights, precision=precision, **self.places)


def speed(program: Path, repetitions: int) -> dict[str, list[dict]]:
    """The repetitions of each of the program's measurements."""
    options = ["--benchmark_format=json", f"--benchmark_repetitions={repetitions}"]
    options += ["--benchmark_enable_random_interleaving=true", "--benchmark_min_time=0.1"]
    said = subprocess.run([program, *options], capture_output=True, text=True, check=True).stdout
    found: dict[str, list[dict]] = {}
    for each in json.loads(said)["benchmarks"]:
        if each["run_type"] == "iteration":
            found.setdefault(each["run_name"], []).append(each)
    return found


def rows(program: Path, repetitions: int) -> list[Row]:
    in_one_thread = speed(program, repetitions)

    found = []
    for words, mean_count in (("small", SMALL), ("large", LARGE)):
        batch = Batch(mean_count, MANY)
        rates = {t: [each["items_per_second"] / 1e6
                     for each in in_one_thread[f"{t}, {words} mean count"]]
                 for t in ("double", "float")}  # fmt: skip
        times: dict[str, list[float]] = {"float": [], "double": []}
        for _ in range(repetitions):
            for precision, taken in times.items():
                each = processor_time(lambda b=batch, p=precision: b.evaluate(p))
                taken.append(each / MANY)
        where = f"{words} ⟨N⟩"
        found += [
            Row(f"{where}: pixel–lights in a float batch, per core",
                [1e-6 / each for each in times["float"]], unit="million/s"),
            Row(f"{where}: rate of a float batch over a batch in double",
                ratios(times["double"], times["float"])),
            Row(f"{where}: pixel–lights in float, one thread", rates["float"], unit="million/s"),
            Row(f"{where}: pixel–lights in double, one thread", rates["double"], unit="million/s"),
        ]  # fmt: skip
    small = {n: Batch(SMALL, n) for n in (FEW, MORE)}
    calls = []
    for _ in range(repetitions):
        few, more = (
            processor_time(lambda b=batch: b.evaluate("float"), CALLS) for batch in small.values()
        )
        calls.append(few - (more - few) * FEW / (MORE - FEW))
    making = {t: [each["cpu_time"] * 1e-9 for each in in_one_thread[f"making a paint, {t}"]]
              for t in ("float", "double")}  # fmt: skip
    return [
        *found,
        Row("making a paint, float", making["float"], MOST_MAKING, "s"),
        Row("making a paint, double", making["double"], MOST_MAKING, "s"),
        Row("a call over numpy arrays, without its work", calls, MOST_CALL, "s"),
    ]  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program", type=Path, help="tests/benchmark/speed, built")
    parser.add_argument("--json", type=Path, required=True)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    found = rows(arguments.program, 3 if arguments.quick else 9)
    write([Found(CORE, "", found)], arguments.json)
    return 0


if __name__ == "__main__":
    run_program(main)
