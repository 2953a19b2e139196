# SPDX-License-Identifier: Apache-2.0
"""The form that every report command writes: a list of bars as JSON.

Each bar is {"name", "value", "unit", "limit", "holds"}: what was measured and where, the figure,
its unit ("1" for a pure number), the figure it may not pass (the name ends in "at least" or
"at most"), and whether it holds. A value that could not be measured is null and does not hold.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from common import files
from common.processes import say


@dataclass(frozen=True)
class Bar:
    name: str
    value: float | None
    unit: str
    limit: float
    holds: bool

    def __str__(self) -> str:
        value = "not measured" if self.value is None else f"{self.value:.6g}"
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{'ok  ' if self.holds else 'MISS'} {self.name} {self.limit:g}{unit}: {value}"


def at_least(name: str, value: float, limit: float, unit: str = "1") -> Bar:
    return _bar(f"{name}, at least", value, limit, unit, value >= limit)


def at_most(name: str, value: float, limit: float, unit: str = "1") -> Bar:
    return _bar(f"{name}, at most", value, limit, unit, value <= limit)


def _bar(name: str, value: float, limit: float, unit: str, holds: bool) -> Bar:
    finite = math.isfinite(value)
    return Bar(name, float(value) if finite else None, unit, limit, bool(holds and finite))


def conclude(judged: Sequence[Bar], file: Path | None, report: Path, start: float) -> int:
    """Says each bar and where the report is, begun at that time.monotonic(); the exit code."""
    if file:
        write(judged, file)
    say("")
    for bar in judged:
        say(str(bar))
    missed = sum(not bar.holds for bar in judged)
    say(f"\n{len(judged) - missed} bars hold, {missed} do not.")
    say(f"{report}, {time.monotonic() - start:.0f} s in all")
    return 1 if missed else 0


def write(rows: Sequence[Any], path: Path) -> None:
    """Writes dataclasses, bars or others."""
    files.write(path, json.dumps([asdict(row) for row in rows], indent=2) + "\n")
