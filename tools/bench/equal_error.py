# SPDX-License-Identifier: Apache-2.0
"""Time to equal error: each method's pictures against its own converged one."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.rows import Row

PAINT, EXPLICIT = "the paint", "explicit flakes"
OTHERS = (EXPLICIT, "Voronoi flakes", "noise flakes")
ERROR = 0.1  # of the mean: what a picture may be off, root mean square
LEAST = 100  # times sooner than explicit flakes
_BETWEEN = ", flakes in a pixel "  # of a file's name, method and number


def name_of(method: str, flakes: float) -> str:
    return f"{method}{_BETWEEN}{flakes:g}"


@dataclass(frozen=True)
class Series:
    """One view's pictures (n, h, w, 3), their samples in a pixel, and the converged picture."""

    seconds: float  # of one processor, for a sample of a pixel
    samples: np.ndarray
    pictures: np.ndarray
    converged_samples: int
    converged: np.ndarray

    def save(self, file: Path) -> None:
        np.savez(file, **self.__dict__)

    @classmethod
    def load(cls, file: Path) -> Series:
        with np.load(file) as data:
            return cls(**{name: data[name] for name in data.files})

    @property
    def times(self) -> np.ndarray:
        """s of one processor, for a pixel."""
        return self.seconds * self.samples

    def errors(self, error: Callable[[np.ndarray, np.ndarray], float]) -> np.ndarray:
        return np.array([error(self.converged, picture) for picture in self.pictures])

    def rmse(self) -> np.ndarray:
        """In linear light, of the mean.

        The squares of the noise of both pictures add up, and fall with their samples: that of the
        converged one is taken off.
        """
        off = self.errors(lambda a, b: float(np.sqrt(((a - b) ** 2).mean()) / a.mean()))
        return off / np.sqrt(1 + self.samples / self.converged_samples)

    def time_to(self, error: float) -> float:
        """s for a pixel until the picture's RMSE is so small.

        Between pictures as a power law; beyond the last one the error falls as the root of the
        samples.
        """
        times, errors = self.times, self.rmse()
        for i, reached in enumerate(errors):
            if reached <= error:
                if i == 0:
                    return float(times[0])
                share = math.log(error / errors[i - 1]) / math.log(reached / errors[i - 1])
                return float(times[i - 1] * (times[i] / times[i - 1]) ** share)
        return float(times[-1] * (errors[-1] / error) ** 2)


def crossing(factors: dict[float, float]) -> float | None:
    """Where they pass 1, between two places as a power law; none if they do not."""
    places = list(factors)
    for low, high in itertools.pairwise(places):
        if factors[low] < 1 <= factors[high]:
            share = -math.log(factors[low]) / math.log(factors[high] / factors[low])
            return low * (high / low) ** share
    return None


def of_mean(converged: np.ndarray, picture: np.ndarray) -> float:
    """The mean over the pixels, off that of the converged picture, relatively."""
    return abs(float(picture.mean() / converged.mean()) - 1)


def of_variance(converged: np.ndarray, picture: np.ndarray) -> float:
    """The variance between pixels, likewise: noise adds to it."""
    return abs(float(brightness(picture).var() / brightness(converged).var()) - 1)


def brightness(picture: np.ndarray) -> np.ndarray:
    return picture.mean(axis=-1, dtype=float)


def load_all(folder: Path) -> dict[float, dict[str, Series]]:
    """By flakes in a pixel and method."""
    found: dict[float, dict[str, Series]] = {}
    for file in folder.glob("*.npz"):
        method, flakes = file.stem.split(_BETWEEN)
        found.setdefault(float(flakes), {})[method] = Series.load(file)
    return dict(sorted(found.items()))


def curve_of(other: str) -> str:
    return f"time of {other} over the paint's to an RMSE of {ERROR:g}, by flakes in a pixel"


def rows(found: dict[float, dict[str, Series]]) -> Iterator[Row]:
    factors = {
        other: {
            flakes: methods[other].time_to(ERROR) / methods[PAINT].time_to(ERROR)
            for flakes, methods in found.items()
        }
        for other in OTHERS
    }
    for other, by_flakes in factors.items():
        name = curve_of(other)
        for flakes, factor in by_flakes.items():
            yield Row(name, [factor], curve=name, at=flakes)
    for what, quantity in (
        ("mean", lambda picture: brightness(picture).mean()),
        ("standard deviation", lambda picture: brightness(picture).std()),
    ):
        name = f"converged: {what} of the paint over that of explicit flakes, by flakes in a pixel"
        for flakes, methods in found.items():
            ratio = quantity(methods[PAINT].converged) / quantity(methods[EXPLICIT].converged)
            yield Row(name, [float(ratio)], curve=name, at=flakes)
    if (end := crossing(factors[EXPLICIT])) is not None:
        yield Row("flakes in a pixel below which explicit flakes are sooner", [end])
    most = max(found)
    yield Row(f"time of explicit flakes over the paint's, {most:g} flakes in a pixel",
              [factors[EXPLICIT][most]], LEAST, bound="at least")  # fmt: skip
