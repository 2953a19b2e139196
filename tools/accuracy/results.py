# SPDX-License-Identifier: Apache-2.0
"""The measurements of tests/benchmark/trade: times, errors, pictures, and which choice wins."""

from __future__ import annotations

import json
import math
import statistics
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import flip_evaluator
import numpy as np

ERRORS = ("count", "mean", "deviation", "distribution")
DRAW = "draw"
TOGETHER = "all together"
# Not choices between ways to the same thing: the shader has float alone, ε is the paint's own, and
# the last shows the sum of all.
NOT_JUDGED = ("number type", "flake spread ε", TOGETHER)
# The first ships; the others are the paper's.
DEPTH_MODELS = ("correlated", "attenuated", "thinned")
FLAKE_SIZE = "flake diameter over layer thickness"  # varied against traced flakes
# No picture in float tells smaller relative errors from none.
EXACT = 2.0**-24
# Tables are made once for a picture of so many pixels.
PIXELS_PER_TABLE = 1e6


@dataclass
class Choice:
    group: str
    name: str
    exact: bool
    shipped: bool
    numbers: str  # which random numbers it shares with the exact choice: same, counts or own
    nanoseconds: dict[str, float] = field(default_factory=dict)  # by scene, as all below
    ratios: dict[str, float] = field(
        default_factory=dict
    )  # of the time to its group's shipped choice's
    errors: dict[str, dict[str, float]] = field(default_factory=dict)
    flip: dict[str, float] = field(default_factory=dict)
    rmse: dict[str, float] = field(default_factory=dict)
    dominated_by: str | None = None

    @property
    def time(self) -> float:
        """The geometric mean of the ratios."""
        return math.exp(statistics.fmean(math.log(r) for r in self.ratios.values()))

    def worst(self, error: str) -> float:
        return max(errors[error] for errors in self.errors.values())

    @property
    def distribution(self) -> list[float]:
        """Its error in each scene."""
        return [errors["distribution"] for errors in self.errors.values()]

    @property
    def error(self) -> float:
        return max(self.distribution)


@dataclass
class Traced:
    """The nearest scene with each flake traced, beside the model's."""

    nanoseconds: float  # of a pixel
    brightness: float  # of the flakes over the model's
    brightness_error: float  # its standard error
    compared: dict[str, tuple[float, float]]  # two pictures' FLIP and RMSE
    choices: list[tuple[Choice, float, dict[str, float]]]  # nanoseconds, errors


class Results:
    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.data = json.loads((folder / "measurements.json").read_text())
        self.size = self.data["size"]
        self.scenes = {scene["name"]: scene for scene in self.data["scenes"]}
        self.choices: list[Choice] = []
        self.copies: dict[str, list[float]] = {}  # by scene: times of the copies of what ships
        self.floor_flip: dict[str, dict[str, float]] = {}
        for name, scene in self.scenes.items():
            self._read(name, scene)
        for group in self.groups:
            self._judge(self.of(group))

    @property
    def groups(self) -> list[str]:
        return list(dict.fromkeys(choice.group for choice in self.choices))

    def of(self, group: str) -> list[Choice]:
        return [choice for choice in self.choices if choice.group == group]

    def shipped(self, group: str) -> Choice:
        return next(choice for choice in self.of(group) if choice.shipped)

    @cached_property
    def tolerance(self) -> float:
        """By so much may two times differ and count as equal.

        Some groups' shipped choices are one program and others draw the same by code compiled
        apart: what they differ by is the machine and the compiler.
        """
        logs = [[math.log(time) for time in times] for times in self.copies.values()]
        means = [statistics.fmean(each) for each in zip(*logs, strict=True)]  # over scenes
        centre = statistics.median(means)
        return max(0.01, *(abs(mean - centre) for mean in means))

    @cached_property
    def traced(self) -> Traced:
        data = self.data["traced"]
        files = [[f"traced-{kind}{seed}.raw" for seed in (1, 2)] for kind in ("", "model-")]
        pictures, models = ([self.seen("traced", file) for file in of] for of in files)
        flakes, modelled = (
            [np.fromfile(self.folder / f, np.float32).reshape(-1, 3).sum(1, float) for f in of]
            for of in files
        )
        brightness = sum(flakes).sum() / sum(modelled).sum()
        # Half the square of two draws' difference is what to expect of their variance.
        errors = [np.sqrt(((a - b) ** 2).sum()) / (a + b).sum() for a, b in (flakes, modelled)]
        choices = []
        for option in data["options"]:
            of = next(c for c in self.of(option["group"]) if c.name == option["name"])
            choices.append((of, of.nanoseconds[data["scene"]], option["error"]))
        return Traced(
            nanoseconds=1e9 * data["seconds"],
            brightness=float(brightness),
            brightness_error=float(brightness * math.hypot(*errors)),
            compared={
                "every flake traced : other seed": _apart(*pictures),
                "every flake traced : what ships": _apart(pictures[0], models[0]),
                "what ships : other seed": _apart(*models),
            },
            choices=choices,
        )

    def _read(self, name: str, scene: dict) -> None:
        options = scene["options"]
        self.copies[name] = [statistics.median(o["seconds"]) for o in options if o["copy"]]
        shipped = {o["group"]: _times(o) for o in options if o["shipped"]}
        exact = {o["group"]: self.seen(name, o["picture"]) for o in options if o["exact"]}
        for option in options:
            key = (option["group"], option["name"])
            choice = next((c for c in self.choices if (c.group, c.name) == key), None)
            if choice is None:
                flags = (option["exact"], option["shipped"], option["numbers"])
                choice = Choice(*key, *flags)
                self.choices.append(choice)
            times = _times(option)
            pairs = zip(times, shipped[option["group"]], strict=True)
            choice.ratios[name] = statistics.median(time / once for time, once in pairs)
            choice.nanoseconds[name] = 1e9 * statistics.median(times)
            choice.errors[name] = option["error"]
            found, reference = self.seen(name, option["picture"]), exact[option["group"]]
            choice.flip[name] = flip(reference, found)
            choice.rmse[name] = rmse(reference, found)
        whole = self.seen(name, f"{name}-exact.raw")
        self.floor_flip[name] = {
            numbers: flip(whole, self.seen(name, f"{name}-{numbers}.raw"))
            for numbers in ("counts", "own")
        }

    def seen(self, scene: str, file: str) -> np.ndarray:
        """The picture in linear light, white in the sun being 1: the flakes over dull ground."""
        base = np.fromfile(self.folder / f"{scene}-base.raw", np.float32)
        shape = (math.isqrt(base.size),) * 2
        radiance = np.fromfile(self.folder / file, np.float32).reshape(*shape, 3)
        return math.pi * radiance + base.reshape(*shape, 1)

    def _judge(self, choices: list[Choice]) -> None:
        for choice in choices:
            better = [other for other in choices if self._dominates(other, choice)]
            if better:
                choice.dominated_by = min(better, key=lambda c: (c.error, c.time)).name

    def _dominates(self, a: Choice, b: Choice) -> bool:
        pairs = zip(a.distribution, b.distribution, strict=True)
        differences = [x - y if max(x, y) > EXACT else 0.0 for x, y in pairs]
        faster = a.time < b.time / (1 + self.tolerance)
        slower = a.time > b.time * (1 + self.tolerance)
        return not slower and max(differences) <= 0 and (faster or min(differences) < 0)


def fluctuation(share: dict[str, float]) -> float:
    """E[s^2]/E[s]^2 of what the layer leaves of a sparkle."""
    return share["square"] / share["mean"] ** 2


def _apart(reference: np.ndarray, picture: np.ndarray) -> tuple[float, float]:
    return flip(reference, picture), rmse(reference, picture)


def _times(option: dict) -> list[float]:
    """Of a pixel, in each round."""
    table = option["seconds_to_make"] / PIXELS_PER_TABLE
    return [seconds + table for seconds in option["seconds"]]


def encoded(linear: np.ndarray) -> np.ndarray:
    """As a screen shows it: clipped, in sRGB."""
    x = np.clip(linear, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055).astype(np.float32)


def flip_map(reference: np.ndarray, picture: np.ndarray, *, colours: bool = False) -> np.ndarray:
    shown = (encoded(reference), encoded(picture))
    return flip_evaluator.evaluate(*shown, "LDR", applyMagma=colours)[0]


def flip(reference: np.ndarray, picture: np.ndarray) -> float:
    """Andersson et al. 2020, at the evaluator's own viewing distance (67 pixels per degree)."""
    if np.array_equal(reference, picture):
        return 0.0
    return float(flip_map(reference, picture).mean())


def rmse(reference: np.ndarray, picture: np.ndarray) -> float:
    """In linear light, of the reference's mean."""
    difference = picture.astype(float) - reference
    return float(np.sqrt((difference**2).mean()) / reference.mean())
