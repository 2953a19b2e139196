# SPDX-License-Identifier: Apache-2.0
"""Waits and memory: each in fresh Blenders, the contenders by turns."""

from __future__ import annotations

import json
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from common.environments import Blender
from common.processes import TOOLS, run_measurement, say

from bench.rows import Found, Row, seconds

MANY = 20
FEW_FLAKES, MANY_FLAKES = "1e3", "1e15"  # per m²
# A wait is not felt where it is at most twice Principled's and 0.05 s longer; a lamp's move, which
# compiles nothing, is held to 0.05 s more. A script that LLVM compiles misses the former: 2 s of
# compiling stand against Principled's 0.1. Ordinary nodes start in 0.02 to 0.04 s (prototypes).
TIMES, ABOVE = 2, 0.05
TIMES_MANY = 20  # Principled's first, for as many paints


@dataclass(frozen=True)
class Session:
    contender: str
    count: int = 1
    steps: int = 0


ONE_METAL, ONE_PAINT = Session("principled", steps=3), Session("varied", steps=3)
LIVE = Session("live", steps=3)
METALS, VARIED, PRESETS = (Session(c, MANY) for c in ("principled", "varied", "presets"))
SHARED = Session("shared", MANY, steps=3)
FEW, DENSE = Session(FEW_FLAKES), Session(MANY_FLAKES)
SHORT = (ONE_METAL, ONE_PAINT, LIVE, METALS, SHARED, FEW, DENSE)
LONG = (PRESETS, VARIED)  # held once: their times are long enough to be sure
Times = dict[Session, dict[str, list[float]]]


def waits(blender: Blender, work: Path, quick: bool) -> list[Found]:
    """With `quick` without the paints that differ in values alone."""
    found: Times = {}
    repetitions = 1 if quick else 3
    for i in range(repetitions):
        say(f"  round {i + 1} of {repetitions}")
        sessions = SHORT if i else (*SHORT, *LONG[: 1 if quick else None])
        for session in sessions:
            values = found.setdefault(session, {})
            for name, value in _hold(blender, session, work / "session.json").items():
                values.setdefault(name, []).append(value)
    return [
        Found("waits", blender.version, wait_rows(found)),
        Found("memory", blender.version, _memory(found)),
    ]


def _hold(blender: Blender, session: Session, file: Path) -> dict[str, float]:
    program = [blender.python, TOOLS, "bench.session", session.contender, "--json", file]
    program += ["--count", str(session.count), "--steps", str(session.steps)]
    run_measurement("A session in a fresh Blender", program)
    return json.loads(file.read_text(encoding="utf-8"))


def wait_rows(found: Times) -> list[Row]:
    metal, paint = found[ONE_METAL], found[ONE_PAINT]
    first = metal["first"]

    def over_first(what: str, times: Sequence[float], limit: float | None = None) -> Row:
        behind = f"{seconds(times)} / {seconds(first)}"
        values = [each / statistics.median(first) for each in times]
        return Row(f"{what} over Principled's first", values, limit, orientation=behind)

    def unfelt(own: Sequence[float]) -> float:
        """Over Principled's first, where Principled itself takes so long."""
        return (TIMES * statistics.median(own) + ABOVE) / statistics.median(first)

    def above(what: str, name: str) -> Row:
        more = [a - b for a, b in zip(paint[name], metal[name], strict=True)]
        behind = f"{seconds(paint[name])} − {seconds(metal[name])}"
        return Row(f"{what} above Principled's", more, ABOVE, "s", orientation=behind)

    what = f"before the first sample: {MANY} presets"
    many = [over_first(what, found[PRESETS]["first"], TIMES_MANY)]
    if VARIED in found:
        what = f"before the first sample: {MANY} paints of other values"
        many.append(over_first(what, found[VARIED]["first"], TIMES_MANY))
    shared, lively = found[SHARED], found[LIVE]
    what = f"before the first sample: {MANY} presets by properties of objects, one material"
    many.append(over_first(what, shared["first"]))
    after_step = unfelt(metal["slider"])
    return [
        over_first("before the first sample: one paint", paint["first"], unfelt(first)),
        over_first("before the first sample: one with live sliders", lively["first"]),
        *many,
        over_first(f"before the first sample: {MANY} Principled", found[METALS]["first"]),
        over_first("after a slider's step: the paint", paint["slider"], after_step),
        over_first("after a step of a live slider: the paint", lively["slider"], after_step),
        over_first("after a slider's step: Principled", metal["slider"]),
        over_first("after a step of an object's property", shared["slider"]),
        above("after a lamp's move", "move"),
        above("in each frame with a moving lamp", "frame"),
        over_first("making the material of the source (the extension has it made)", paint["made"]),
    ]


def _memory(found: Times) -> list[Row]:
    def over(what: str, a: Session, b: Session, limit: float | None = None) -> Row:
        bytes_a, bytes_b = found[a]["peak"], found[b]["peak"]
        behind = " / ".join(
            f"{statistics.median(each) / 1e6:.0f} MB" for each in (bytes_a, bytes_b)
        )
        values = [each / statistics.median(bytes_b) for each in bytes_a]
        return Row(f"peak memory: {what}", values, limit, orientation=behind)

    return [
        over("one paint over one Principled", ONE_PAINT, ONE_METAL),
        over(f"{MANY} presets over {MANY} Principled", PRESETS, METALS),
        over(f"{MANY} presets over one paint", PRESETS, ONE_PAINT),
        over(f"{MANY_FLAKES} flakes per m² over {FEW_FLAKES}", DENSE, FEW, 1.05),
    ]
