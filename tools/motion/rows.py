# SPDX-License-Identifier: Apache-2.0
"""What is measured and filmed, and the form in which measure.py hands it to run.py."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from common import bars

MATERIALS = ("pixel", "Voronoi", "surface")  # the paint by its anchor, and flakes made of nodes
FILMED = ("turntable", "dolly", "pan", "sun")
MEASURED = (*FILMED, "blur", "panorama", "law")
FILM = "motion.webp"


def strip_of(motion: str) -> str:
    return f"{motion}.jpg"


@dataclass(frozen=True)
class Row:
    """A quantity of a motion in each material that has it. A limit is the surface anchor's."""

    quantity: str
    values: dict[str, float]
    limit: float | None = None
    bound: str = ""  # "at least" or "at most"

    def bars(self, where: str) -> Iterator[bars.Bar]:
        if self.limit is not None:
            judge = bars.at_least if self.bound == "at least" else bars.at_most
            yield judge(f"{where}: {self.quantity}", self.values["surface"], self.limit)
