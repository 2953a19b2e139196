# SPDX-License-Identifier: Apache-2.0
"""The figures of the report of ./paint accuracy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from common.figures import COLOUR, DARK, GREY, STYLE, save
from matplotlib.axes import Axes

from accuracy.results import (
    DEPTH_MODELS,
    DRAW,
    EXACT,
    TOGETHER,
    Choice,
    Results,
    encoded,
    flip_map,
    fluctuation,
)

NONE = EXACT / 4  # where an error of nothing is drawn
DEPTH_LINES = (("-", COLOUR), ("--", "C1"), (":", "C2"))
PARTS = {"coverage": "coverage D·H·⟨S⟩"}


def draw_all(results: Results, folder: Path) -> None:
    with plt.rc_context(STYLE):
        _choices(results, folder / "choices.png")
        _draws(results, folder / "draws.png")
        _depth(results, folder / "depth.png")
        _pictures(results, folder / "pictures.png")


def _choices(results: Results, file: Path) -> None:
    groups = [group for group in results.groups if "ε" not in group]
    figure, grid = plt.subplots(4, 2, figsize=(11.5, 12.5), layout="constrained", sharey=True)
    *panels, last = grid.flat
    for spare in panels[len(groups) :]:
        spare.set_axis_off()
    for axes, group in zip(panels[: len(groups)], groups, strict=True):
        points = [(c, c.time, max(c.error, NONE)) for c in results.of(group)]
        front = sorted((time, error) for c, time, error in points if not c.dominated_by)
        axes.step(*zip(*front, strict=True), where="post", color=COLOUR, lw=1.2, alpha=0.6)
        _panel(axes, group, points)
    _against_traced(last, results)
    shown = []
    for marker, face, edge, text in (
        ("*", COLOUR, COLOUR, "what ships"),
        ("o", COLOUR, COLOUR, "on the front: nothing is both as fast and as exact"),
        ("o", "white", GREY, "dominated: another choice is as fast and as exact, or better"),
    ):
        size = 13 if marker == "*" else 8
        shown += last.plot([], [], marker, mfc=face, mec=edge, ms=size, label=text)
    figure.legend(handles=shown, loc="outside upper center", fontsize=10, ncols=3)
    figure.supxlabel("time of a pixel, of what ships (geometric mean of the scenes)")
    figure.supylabel(
        "error of the distribution of a pixel's radiance, in its standard deviations "
        "(worst scene); at the foot: none"
    )
    save(figure, file)


def _against_traced(axes: Axes, results: Results) -> None:
    """No front: noise hides what tells most of the choices apart."""
    traced, data = results.traced, results.data["traced"]
    once = results.shipped(TOGETHER).nanoseconds[data["scene"]]
    far = Choice(TOGETHER, "every flake traced", True, False, "own")
    points = [
        (replace(choice, dominated_by=None), ns / once, errors["distribution"])
        for choice, ns, errors in traced.choices
    ]
    points.append((far, traced.nanoseconds / once, NONE))
    noise = data["floor"]["distribution"]
    axes.axhline(noise, color=GREY, ls=":", lw=1.2)
    axes.text(0.98, noise, "noise", color=GREY, va="bottom", ha="right", fontsize=8.5,
              transform=axes.get_yaxis_transform())  # fmt: skip
    _panel(
        axes,
        f"against traced flakes, scene “{data['scene']}”",
        points,
    )


# By the ratio of the longest to the shortest time.
TICKS = {
    12: (0.6, 0.8, 1, 1.25, 2, 3, 5),
    300: (0.5, 1, 2, 5, 10, 50),
    float("inf"): (1, 10, 100, 1e3, 1e4, 1e5),
}


def _panel(axes: Axes, title: str, points: list[tuple[Choice, float, float]]) -> None:
    for choice, time, error in points:
        face, edge = ("white", GREY) if choice.dominated_by else (COLOUR, COLOUR)
        marker, size = ("*", 15) if choice.shipped else ("o", 7)
        axes.plot(time, error, marker, mfc=face, mec=edge, ms=size, mew=1.3, clip_on=False)
    axes.set_title(title, loc="left", fontweight="bold")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(NONE / 1.6, 1e3)
    axes.set_yticks([NONE, 1e-6, 1e-4, 1e-2, 1], ["none", "10⁻⁶", "10⁻⁴", "10⁻²", "1"])
    times = [time for _, time, _ in points]
    low, high = min(*times, 0.8), max(*times, 1.25)
    axes.set_xlim(low / 1.06, high * (high / low) ** 0.08)
    ticks = next(ticks for room, ticks in TICKS.items() if high / low < room)
    ticks = [t for t in ticks if low / 1.05 <= t <= high]
    axes.set_xticks(ticks, [f"{t:,g}" for t in ticks])
    axes.minorticks_off()
    _labels(axes, points)


def _labels(axes: Axes, points: list[tuple[Choice, float, float]]) -> None:
    """Names to the right of the panel, as high as their points as far as they do not collide."""
    bottom, top = np.log(axes.get_ylim())
    wanted = [(np.log(error) - bottom) / (top - bottom) for _, _, error in points]
    order = sorted(range(len(points)), key=lambda i: (wanted[i], -points[i][1]))
    gap = min(0.105, 1 / len(points))
    heights = [wanted[i] for i in order]
    for i in range(1, len(heights)):  # upwards, then back down from the top
        heights[i] = max(heights[i], heights[i - 1] + gap)
    heights[-1] = min(heights[-1], 1.0)
    for i in reversed(range(len(heights) - 1)):
        heights[i] = min(heights[i], heights[i + 1] - gap)
    for i, height in zip(order, heights, strict=True):
        choice, time, error = points[i]
        axes.annotate(
            choice.name, (time, error), (1.04, height), "data", "axes fraction", va="center",
            fontsize=8.5, color=GREY if choice.dominated_by else DARK,
            fontweight="bold" if choice.shipped else "normal", annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": "#c8c8c8", "lw": 0.7, "shrinkB": 4},
        )  # fmt: skip


def _draws(results: Results, file: Path) -> None:
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.5, 4.3), layout="constrained")
    for index, law in enumerate(results.data["laws"]):
        rows, colour = law["rows"], f"C{index}"
        counts = [row["count"] for row in rows]
        left.plot(counts, [row["distance"] for row in rows], ".-", color=colour, label=law["name"])
        right.plot(counts, [row["skewness"] for row in rows], ".-", color=colour)
        right.plot(counts, [row["papers_skewness"] for row in rows], ":", color=colour)
    noise = [row["noise"] for row in rows]
    left.plot(counts, noise, ":", color=GREY, label="two samples of one law")
    left.set_title("Kolmogorov's distance of the draw from the paper's sum", loc="left")
    right.set_title("skewness; dotted: of the paper's sum", loc="left")
    left.legend(fontsize=8)
    left.set_yscale("log")
    right.set_yscale("symlog", linthresh=1e-2)
    for axes in (left, right):
        axes.set_xscale("log")
        axes.set_xlabel("mean count ⟨N⟩")
    save(figure, file)


def _depth(results: Results, file: Path) -> None:
    cases = results.data["explicit"]
    varied = list(dict.fromkeys(case["varied"] for case in cases))
    figure, grid = plt.subplots(
        3, len(varied), figsize=(16, 8.5), layout="constrained", sharey="row"
    )
    for column, what in enumerate(varied):
        of = [case for case in cases if case["varied"] == what]
        x = [case["value"] for case in of]
        mean, spread, law = grid[:, column]
        for model, (line, colour) in zip(DEPTH_MODELS, DEPTH_LINES, strict=True):
            style = {"linestyle": line, "color": colour, "label": model}
            mean.plot(x, [case[model]["mean"] for case in of], **style)
            spread.plot(x, [fluctuation(case[model]) for case in of], **style)
            law.plot(x, [case["distance"][model] for case in of], **style)
        style = {"linestyle": "", "marker": "o", "color": DARK, "label": "traced flakes"}
        mean.plot(x, [case["traced"]["mean"] for case in of], **style)
        spread.plot(x, [fluctuation(case["traced"]) for case in of], **style)
        style |= {"mfc": "none", "label": "traced flakes, other seed (noise)"}
        law.plot(x, [case["distance"]["floor"] for case in of], **style)
        for axes in (mean, spread, law):
            if "degrees" not in what:
                axes.set_xscale("log")
                axes.set_xticks(x, [f"{v:g}" for v in x])
            axes.minorticks_off()
        law.set_xlabel(PARTS.get(what, what))
    grid[0, 0].set_ylabel("mean share that the layer\nleaves of a sparkle, E[s]")
    grid[1, 0].set_ylabel("fluctuation of the share,\nE[s²]/E[s]²")
    grid[2, 0].set_ylabel("distance of a pixel's law\nfrom the traced one, in σ")
    grid[0, 0].legend(loc="lower left")
    grid[2, 0].legend(loc="upper left", fontsize=8)
    for axes in grid[0]:
        axes.set_ylim(0, 1.02)
    save(figure, file)


def _pictures(results: Results, file: Path) -> None:
    """What the errors look like: pictures and their FLIP maps."""
    shown = [
        (TOGETHER, "everything exact, in double"), (TOGETHER, "as shipped"),
        (DRAW, "N × mean sparkle"), (DRAW, "mean only, no draw"),
        ("radiometry", "published"), ("depth", "thinned"),
    ]  # fmt: skip
    scenes = ("near", "middle", "far")
    figure, grid = plt.subplots(
        len(scenes), 2 * len(shown) - 1, figsize=(15.5, 5.2), layout="constrained"
    )
    for row, scene in enumerate(scenes):
        options = {(o["group"], o["name"]): o for o in results.scenes[scene]["options"]}
        exact = results.seen(scene, options[shown[0]]["picture"])
        cells = list(grid[row])
        for number, key in enumerate(shown):
            picture = results.seen(scene, options[key]["picture"])
            axes = cells.pop(0)
            axes.imshow(_middle(encoded(picture)), interpolation="nearest")
            axes.set_title(key[1] if row == 0 else "", fontsize=8)
            if number == 0:
                axes.set_ylabel(scene, fontsize=11)
                continue
            axes = cells.pop(0)
            errors = flip_map(exact, picture)
            axes.imshow(_middle(errors), cmap="magma", vmin=0, vmax=1, interpolation="nearest")
            axes.set_title(f"FLIP {errors.mean():.3f}", fontsize=8)
    for axes in grid.flat:
        axes.set_xticks([])
        axes.set_yticks([])
        axes.grid(visible=False)
    save(figure, file)


CROP = 112  # pixels along a side


def _middle(picture: np.ndarray) -> np.ndarray:
    """The part about the brightest place, up and to the right of the ball's middle."""
    room = max(len(picture) - CROP, 0)
    top, left = room * 3 // 10, room * 7 // 10
    return picture[top : top + CROP, left : left + CROP]
