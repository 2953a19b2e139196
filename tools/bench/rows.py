# SPDX-License-Identifier: Apache-2.0
"""What is measured, and the form in which the programs that measure hand it to the report."""

from __future__ import annotations

import json
import math
import statistics
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from common import bars, files
from common.processes import BUILD

ABSENT = "absent"
RENDERED = ("samples", "growth", "noise", ABSENT)  # within one Blender
INSTRUCTIONS, ERROR = "instructions", "error"  # in the first Blender alone
CORE = "core"
LONG = (ABSENT, INSTRUCTIONS)  # not with --quick
PARTS = ("waits", "memory", *RENDERED, INSTRUCTIONS, ERROR, CORE)
WORK = BUILD / "bench"
SERIES = WORK / "error"  # the pictures


@dataclass(frozen=True)
class Row:
    """A quantity of which each repetition gave a value; its median is held against the limit.

    Nearly always a ratio of two processor times taken one after the other. A row of a curve has
    the place on it.
    """

    quantity: str
    values: Sequence[float]
    limit: float | None = None
    unit: str = "1"
    bound: str = "at most"
    orientation: str = ""  # the median figure behind the ratio, with its unit
    curve: str = ""
    at: float = 0

    @property
    def median(self) -> float:
        return statistics.median(self.values)

    @property
    def quartiles(self) -> tuple[float, float]:
        if len(self.values) < 2:
            return self.values[0], self.values[0]
        low, _, high = statistics.quantiles(self.values, n=4, method="inclusive")
        return low, high

    def bars(self, where: str) -> Iterator[bars.Bar]:
        if self.limit is not None:
            judge = bars.at_least if self.bound == "at least" else bars.at_most
            yield judge(f"{where}: {self.quantity}", self.median, self.limit, self.unit)


@dataclass(frozen=True)
class Found:
    """The rows of one part, measured in one Blender; the core's in none."""

    part: str
    blender: str
    rows: Sequence[Row]

    def bars(self) -> Iterator[bars.Bar]:
        where = f"Blender {self.blender}, {self.part}" if self.blender else self.part
        for row in self.rows:
            yield from row.bars(where)


def write(found: Sequence[Found], path: Path) -> None:
    files.write(path, json.dumps([asdict(part) for part in found]))


def read(path: Path) -> list[Found]:
    return parse(json.loads(path.read_text(encoding="utf-8")))


def parse(parts: Sequence[dict[str, Any]]) -> list[Found]:
    return [
        Found(part["part"], part["blender"], [Row(**row) for row in part["rows"]]) for part in parts
    ]


def by_turns(
    names: Iterable[str], measure: Callable[[str], float], repetitions: int
) -> dict[str, list[float]]:
    """What is measured of each, one after the other and round again."""
    found: dict[str, list[float]] = {name: [] for name in names}
    for _ in range(repetitions):
        for name, taken in found.items():
            taken.append(measure(name))
    return found


def ratios(numerators: Sequence[float], denominators: Sequence[float]) -> list[float]:
    return [a / b if b > 0 else math.nan for a, b in zip(numerators, denominators, strict=True)]


def seconds(times: Sequence[float]) -> str:
    """Their median, as a table shows it."""
    return f"{statistics.median(times):.3f} s"


def nanoseconds(times: Sequence[float]) -> str:
    """Likewise, of times in seconds."""
    return f"{statistics.median(times) * 1e9:.0f} ns"
