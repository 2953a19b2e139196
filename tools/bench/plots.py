# SPDX-License-Identifier: Apache-2.0
"""The figures of the report of ./paint bench."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
from common.figures import COLOUR, DARK, STYLE, save
from matplotlib.axes import Axes
from matplotlib.ticker import LogFormatter, StrMethodFormatter

from bench.rows import Found, Row

COLOURS = (COLOUR, "C1")  # of the Blenders


def draw_ratios(found: Sequence[Found], file: Path) -> None:
    """Every ratio of a part with its quartiles, and where its bar is."""
    with plt.rc_context(STYLE):
        rows = [row for row in found[0].rows if row.unit == "1" and not row.curve]
        figure, axes = plt.subplots(figsize=(9, 1 + 0.32 * len(rows)), layout="constrained")
        for part, colour in zip(found, COLOURS, strict=False):
            by_quantity = {row.quantity: row for row in part.rows}
            _ratios(axes, [by_quantity[row.quantity] for row in rows], part.blender, colour)
        axes.plot([], [], "|", color=DARK, ms=12, mew=2, label="bar")
        for place, row in enumerate(rows):
            if row.limit is not None:
                axes.plot(row.limit, place, "|", color=DARK, ms=12, mew=2)
        axes.axvline(1, color=DARK, lw=0.8)
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axes.xaxis.set_minor_formatter(LogFormatter(minor_thresholds=(2, 0.5)))
        axes.set_yticks(range(len(rows)), [row.quantity for row in rows])
        axes.invert_yaxis()
        figure.legend(loc="outside upper right", ncols=3)
        save(figure, file)


def _ratios(axes: Axes, rows: Sequence[Row], blender: str, colour: str) -> None:
    middle = [row.median for row in rows]
    ends = [row.quartiles for row in rows]
    below = [m - low for m, (low, _) in zip(middle, ends, strict=True)]
    above = [high - m for m, (_, high) in zip(middle, ends, strict=True)]
    axes.errorbar(middle, range(len(rows)), xerr=(below, above), fmt="o", ms=4, lw=1.5,
                  color=colour, label=f"Blender {blender}, quartiles")  # fmt: skip
