# SPDX-License-Identifier: Apache-2.0
"""Waits and memory: each in fresh Blenders, the contenders by turns."""

from __future__ import annotations

import json
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from common.environments import Blender
from common.processes import TOOLS, say

from bench.processes import run
from bench.rows import Found, Row, ratios, seconds

MANY = 20
FEW_FLAKES, MANY_FLAKES = "1e3", "1e15"  # per m²
ABOVE = 0.05  # s of the paint's wait above Principled's, at most


@dataclass(frozen=True)
class Session:
    contender: str
    count: int = 1
    steps: int = 0


ONE_METAL, ONE_PAINT = Session("principled", steps=3), Session("varied", steps=3)
METALS, VARIED, PRESETS = (Session(c, MANY) for c in ("principled", "varied", "presets"))
FEW, DENSE = Session(FEW_FLAKES), Session(MANY_FLAKES)
SESSIONS = (ONE_METAL, ONE_PAINT, METALS, VARIED, PRESETS, FEW, DENSE)


def waits(blender: Blender, work: Path, quick: bool) -> list[Found]:
    found: dict[Session, dict[str, list[float]]] = {session: {} for session in SESSIONS}
    repetitions = 1 if quick else 3
    for i in range(repetitions):
        say(f"  round {i + 1} of {repetitions}")
        for session, values in found.items():
            for name, value in _hold(blender, session, work / "session.json").items():
                values.setdefault(name, []).append(value)
    return [
        Found("waits", blender.version, _waits(found)),
        Found("memory", blender.version, _memory(found)),
    ]


def _hold(blender: Blender, session: Session, file: Path) -> dict[str, float]:
    program = [blender.python, TOOLS, "bench.session", session.contender, "--json", file]
    program += ["--count", str(session.count), "--steps", str(session.steps)]
    run("A session in a fresh Blender", program)
    return json.loads(file.read_text(encoding="utf-8"))


def _waits(found: dict[Session, dict[str, list[float]]]) -> list[Row]:
    metal, paint = found[ONE_METAL], found[ONE_PAINT]
    first = metal["first"]

    def over_first(what: str, times: Sequence[float], limit: float | None) -> Row:
        behind = f"{seconds(times)} / {seconds(first)}"
        return Row(f"{what} over Principled's first", ratios(times, first), limit,
                   orientation=behind)  # fmt: skip

    def above(what: str, name: str) -> Row:
        more = [a - b for a, b in zip(paint[name], metal[name], strict=True)]
        behind = f"{seconds(paint[name])} − {seconds(metal[name])}"
        return Row(f"{what} above Principled's", more, ABOVE, "s", orientation=behind)

    return [
        over_first("before the first sample: one paint", paint["first"], 5),
        over_first(f"before the first sample: {MANY} paints of other values",
                   found[VARIED]["first"], 60),
        over_first(f"before the first sample: {MANY} presets", found[PRESETS]["first"], 60),
        over_first(f"before the first sample: {MANY} Principled", found[METALS]["first"], None),
        over_first("after a slider's step: the paint", paint["slider"], 5),
        over_first("after a slider's step: Principled", metal["slider"], None),
        above("after a lamp's move", "move"),
        above("in each frame with a moving lamp", "frame"),
        over_first("making the material, once in a file", paint["made"], None),
    ]  # fmt: skip


def _memory(found: dict[Session, dict[str, list[float]]]) -> list[Row]:
    def over(what: str, a: Session, b: Session, limit: float | None = None) -> Row:
        bytes_a, bytes_b = found[a]["peak"], found[b]["peak"]
        behind = " / ".join(
            f"{statistics.median(each) / 1e6:.0f} MB" for each in (bytes_a, bytes_b)
        )
        return Row(f"peak memory: {what}", ratios(bytes_a, bytes_b), limit, orientation=behind)

    return [
        over("one paint over one Principled", ONE_PAINT, ONE_METAL),
        over(f"{MANY} presets over {MANY} Principled", PRESETS, METALS),
        over(f"{MANY} paints over one", VARIED, ONE_PAINT),
        over(f"{MANY_FLAKES} flakes per m² over {FEW_FLAKES}", DENSE, FEW, 1.05),
    ]
