# SPDX-License-Identifier: Apache-2.0
"""The figures of the report of ./paint bench."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from accuracy.results import flip
from common.figures import COLOUR, DARK, STYLE, save
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter, NullLocator, StrMethodFormatter

from bench import equal_error
from bench.rows import SERIES, Found, Row

COLOURS = (COLOUR, "C1")  # of the Blenders
METHODS = dict(zip((equal_error.PAINT, *equal_error.OTHERS), (COLOUR, DARK, "C1", "C2"),
                   strict=True))  # fmt: skip
GREY_LEVEL = 0.2  # linear
MOST_LINEAR, MOST_TICKS = 32, 6  # of a curve whose every place is named
NARROW = 1e3  # a scale on which there is room to name 1, 2 and 5 of each decade


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
        least, most = axes.get_xlim()
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if most < least * NARROW else (1,)))
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


def draw_error(found: Sequence[Found], file: Path) -> None:
    """Errors against time where flakes in a pixel are few and many, and what follows for all."""
    by_flakes = equal_error.load_all(SERIES)
    few, many = min(by_flakes), max(by_flakes)
    middle = sorted(by_flakes)[len(by_flakes) // 2]
    with plt.rc_context(STYLE):
        figure, grid = plt.subplots(2, 3, figsize=(12, 7), layout="constrained")
        for axes, flakes, what, errors in (
            (grid[0, 0], few, "RMSE, of the mean", equal_error.Series.rmse),
            (grid[0, 1], many, "RMSE, of the mean", equal_error.Series.rmse),
            (grid[0, 2], middle, "FLIP", lambda series: series.errors(_flip)),
            (grid[1, 0], many, "error of the mean", _errors(equal_error.of_mean)),
            (grid[1, 1], many, "error of the variance", _errors(equal_error.of_variance)),
        ):
            for method, colour in METHODS.items():
                series = by_flakes[flakes][method]
                axes.plot(series.times * 1e6, errors(series), "o-", ms=4, color=colour,
                          label=method)  # fmt: skip
            axes.set_title(f"{what}: {flakes:g} flakes in a pixel", loc="left", fontweight="bold")
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.yaxis.set_minor_formatter(NullFormatter())
            axes.set_xlabel("processor time of a pixel, µs")
        _factors(grid[1, 2], found[0])
        figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
        save(figure, file)


def _errors(
    error: Callable[[np.ndarray, np.ndarray], float],
) -> Callable[[equal_error.Series], np.ndarray]:
    return lambda series: series.errors(error)


def _flip(converged: np.ndarray, picture: np.ndarray) -> float:
    """With the mean a middle grey."""
    exposure = GREY_LEVEL / float(converged.mean())
    return flip(exposure * converged, exposure * picture)


def _factors(axes: Axes, found: Found) -> None:
    for other in equal_error.OTHERS:
        rows = [row for row in found.rows if row.curve == equal_error.curve_of(other)]
        axes.plot([row.at for row in rows], [row.median for row in rows], "o-", ms=4,
                  color=METHODS[other])  # fmt: skip
    axes.axhline(1, color=DARK, lw=0.8)
    axes.axhline(equal_error.LEAST, color=DARK, lw=1.5, ls="--")
    axes.set_title(f"time to an RMSE of {equal_error.ERROR:g}, over the paint's", loc="left",
                   fontweight="bold")  # fmt: skip
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("flakes in a pixel; dashed: the bar over explicit flakes")


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
