# SPDX-License-Identifier: Apache-2.0
"""Instructions, which Valgrind counts in Blender: alike in each run, whatever else is running.

An instruction is no time: a quotient takes longer than a sum, and a core does several at once.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from common.environments import Blender
from common.processes import TOOLS, run_measurement, say

from bench.rows import INSTRUCTIONS, Found, Row

PRINCIPLED, PAINT = "Principled", "the paint"
ONE_SPECIES, TWO_SPECIES = "one species", "two species"
STARTS = "Principled, which starts Cycles too"
LIGHTS = (1, 2, 8)
SIZE = 32  # pixels along each side
FEW, MANY = 1, 33  # samples in a pixel
FIRST = 0  # in a name, of the picture that compiles
_COMPILED = "???"  # what Valgrind calls code that is in no file, as a compiled shader's


def picture_name(what: str, samples: int) -> str:
    return f"{what}, {samples}"


def instructions(blender: Blender, work: Path) -> Found:
    say(f"Counting instructions in Blender {blender.version} (ten minutes)…")
    file = work / "callgrind"
    program = ["valgrind", "--tool=callgrind", "--instr-atstart=no", "--quiet"]
    program += [f"--callgrind-out-file={file}", blender.python, TOOLS, "bench.counted"]
    run_measurement("Counting instructions", program)
    counted = dict(map(read, work.glob("callgrind.*")))
    return Found(INSTRUCTIONS, blender.version, list(rows(counted)))


def read(file: Path) -> tuple[str, tuple[int, int]]:
    """The picture's name, its instructions, and of these the compiled shaders' own."""
    picture = ""
    objects: dict[str, str] = {}
    whole = compiled = 0
    inside = called = False
    with file.open(encoding="utf-8") as lines:
        for line in lines:
            if found := re.match(r"desc: Trigger: dump (.*)", line):
                picture = found[1].strip()
            elif found := re.match(r"(c?)ob=(\(\d+\))(?: (.*))?", line):
                if found[3]:
                    objects[found[2]] = found[3].strip()
                if not found[1]:
                    inside = objects[found[2]] == _COMPILED
            elif line.startswith("calls="):
                called = True  # the next line counts what the callee did, once more
            elif found := re.match(r"[\d+*-]\S* (\d+)$", line):
                if not called:
                    whole += int(found[1])
                    compiled += inside * int(found[1])
                called = False
    return picture, (whole, compiled)


def rows(counted: dict[str, tuple[int, int]]) -> Iterator[Row]:
    def per_sample(what: str) -> tuple[float, float]:
        few, many = (counted[picture_name(what, samples)] for samples in (FEW, MANY))
        samples = SIZE * SIZE * (MANY - FEW)
        return (many[0] - few[0]) / samples, (many[1] - few[1]) / samples

    def over(quantity: str, a: float, b: float) -> Row:
        unit = 1e6 if b > 1e6 else 1
        behind = " / ".join(f"{n / unit:,.0f}{' million' * (unit > 1)}" for n in (a, b))
        return Row(quantity, [a / b], orientation=behind)

    first, again, paint = (counted[picture_name(w, FIRST)][0] for w in (STARTS, PRINCIPLED, PAINT))
    yield over("before the first sample, in a fresh Blender: the paint over Principled",
               paint + (first - again), first)  # fmt: skip
    whole, own = per_sample(PAINT)
    metal, _ = per_sample(PRINCIPLED)
    yield over("sun and world: the paint over Principled", whole, metal)
    yield over("sun and world: of the paint all but its compiled shader, over Principled",
               whole - own, metal)  # fmt: skip
    two, one = (per_sample(what)[0] for what in (TWO_SPECIES, ONE_SPECIES))
    yield over("sun and world: two species over one species", two, one)
    lit = {n: per_sample(f"{PAINT} under {n} lights")[0] for n in LIGHTS}
    for n in LIGHTS[1:]:
        yield over(f"suns: each further one of {n}, over the paint under one",
                   (lit[n] - lit[LIGHTS[0]]) / (n - LIGHTS[0]), lit[LIGHTS[0]])  # fmt: skip
