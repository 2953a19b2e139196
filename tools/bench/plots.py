# SPDX-License-Identifier: Apache-2.0
"""The figures of the report of ./paint bench."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
from common.figures import COLOUR, DARK, STYLE, save
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

from bench.rows import Found, Row

COLOURS = (COLOUR, "C1")  # of the Blenders
MOST_LINEAR, MOST_TICKS = 32, 6  # of a curve whose every place is named


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
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_yticks(range(len(rows)), [row.quantity for row in rows])
        axes.invert_yaxis()
        figure.legend(loc="outside upper right", ncols=3)
        save(figure, file)


def draw_growth(found: Sequence[Found], file: Path) -> None:
    """Each curve in a panel, over its first point."""
    curves = list(dict.fromkeys(row.curve for row in found[0].rows if row.curve))
    with plt.rc_context(STYLE):
        figure, grid = plt.subplots(2, (len(curves) + 1) // 2, figsize=(11, 6.4),
                                    layout="constrained", squeeze=False)  # fmt: skip
        for axes in grid.flat[len(curves) :]:
            axes.set_axis_off()
        for axes, curve in zip(grid.flat, curves, strict=False):
            for part, colour in zip(found, COLOURS, strict=False):
                _curve(axes, [row for row in part.rows if row.curve == curve], part.blender, colour)
            axes.set_title(curve, loc="left", fontweight="bold")
            axes.set_ylim(bottom=0)
        grid[0, 0].legend(loc="lower left")
        figure.supylabel("time per sample, of the first point's")
        save(figure, file)


def _curve(axes: Axes, rows: Sequence[Row], blender: str, colour: str) -> None:
    places = [row.at for row in rows]
    _with_quartiles(axes, rows, "y", places, "o-", colour, f"Blender {blender}, quartiles")
    wide = max(places) / min(places)
    axes.set_xscale("log", base=10 if wide > MOST_LINEAR else 2)
    if len(places) < MOST_TICKS and wide <= MOST_LINEAR:
        axes.set_xticks(places, [f"{place:g}" for place in places])
        axes.minorticks_off()


def _ratios(axes: Axes, rows: Sequence[Row], blender: str, colour: str) -> None:
    label = f"Blender {blender}, quartiles"
    _with_quartiles(axes, rows, "x", range(len(rows)), "o", colour, label)


def _with_quartiles(
    axes: Axes, rows: Sequence[Row], along: str, places: Sequence[float], form: str, colour: str,
    label: str,
) -> None:  # fmt: skip
    middle = [row.median for row in rows]
    ends = [row.quartiles for row in rows]
    error = (
        [m - low for m, (low, _) in zip(middle, ends, strict=True)],
        [high - m for m, (_, high) in zip(middle, ends, strict=True)],
    )
    both = (middle, places) if along == "x" else (places, middle)
    axes.errorbar(*both, **{f"{along}err": error}, fmt=form, ms=4, lw=1.5, color=colour,
                  label=label)  # fmt: skip
