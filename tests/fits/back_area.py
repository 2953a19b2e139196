# SPDX-License-Identifier: Apache-2.0
"""The constants of narrow_back_area in core/orientation.h, and what they err.

    python3 tests/fits/back_area.py

fits them anew to the integral above gaussian_back_area, for tilts from 0.004 to 0.4 rad and
elevations up to 5.5 tilts: the least largest error, by least squares whose weights grow where the
error is large. Needs numpy; a few seconds.
"""

from __future__ import annotations

from itertools import pairwise
from math import erfc, pi

import numpy as np

WIDEST, REACH = 0.4, 12  # rad; tilts, as core/orientation.h has it for double
CURVED = [(i, j) for i in range(7) for j in range(5) if i + j <= 6]  # powers of b0 and of the tilt
BEYOND = range(3)  # powers of b0
ROUNDS = 300

NODE, WEIGHT = np.polynomial.legendre.leggauss(160)
NODE, WEIGHT = (NODE + 1) / 2, WEIGHT / 2


def norm(tilt: float) -> float:
    limit = min(pi / 2, REACH * tilt)
    b = limit * NODE
    return float(limit * np.sum(WEIGHT * np.exp(-0.5 * (b / tilt) ** 2) * np.sin(b)))


def back_area(b0: float, tilt: float) -> float:
    width = min(pi / 2, b0 + REACH * tilt) - b0
    b = b0 + width * NODE**2
    a, c = np.sin(b0) * np.cos(b), np.cos(b0) * np.sin(b)
    ratio = np.clip(a / np.maximum(c, 1e-300), -1, 1)
    back = np.sqrt(np.maximum((c - a) * (c + a), 0)) - a * np.arccos(ratio)
    ring = NODE * np.exp(-0.5 * (b / tilt) ** 2) * np.sin(b) * back
    return float(2 * width * np.sum(WEIGHT * ring) / (pi * norm(tilt)))


def at_small_angles(b0: float, tilt: float) -> float:
    y = b0 / tilt
    density, tail = np.exp(-y * y / 2) / np.sqrt(2 * pi), erfc(y / np.sqrt(2)) / 2
    return float(tilt * (density - y * tail))


def between(low: float, high: float, count: int) -> np.ndarray:
    """Denser near both ends."""
    return low + (high - low) * (1 - np.cos(np.linspace(0, pi, count))) / 2


def terms(b0: np.ndarray, tilt: np.ndarray) -> np.ndarray:
    small = np.array([at_small_angles(*each) for each in zip(b0, tilt, strict=True)])
    missing = np.exp(-0.5 * (pi / 2 / tilt) ** 2)  # 1 - below
    return np.stack(
        [b0**i * tilt**j * small for i, j in CURVED] + [b0**i * missing for i in BEYOND], axis=1
    )


def cases(tilts: int, elevations: int) -> tuple[np.ndarray, np.ndarray]:
    """The terms (n, m) at so many places, and the area (n,)."""
    places = [
        (b0, tilt)
        for tilt in between(0.004, WIDEST, tilts)
        for b0 in between(0, min(5.5 * tilt, pi / 2 - 1e-9), elevations)
    ]
    return terms(*np.array(places).T), np.array([back_area(*place) for place in places])


def fitted() -> np.ndarray:
    of_each, exact = cases(41, 61)
    weight = np.ones(len(exact))
    constants = np.zeros(of_each.shape[1])
    for _ in range(ROUNDS):
        constants = np.linalg.lstsq(of_each * weight[:, None], exact * weight, rcond=None)[0]
        error = np.abs(of_each @ constants - exact)
        weight *= np.sqrt(0.3 + error / error.max())
        weight /= weight.max()
    return constants


def main() -> None:
    constants = fitted().astype(np.float32)
    of_each, exact = cases(83, 121)  # between those of the fit too
    error = np.abs(of_each @ constants.astype(float) - exact).max()
    starts = [k for k, (_, j) in enumerate(CURVED) if j == 0]
    for i, (start, end) in enumerate(pairwise([*starts, len(CURVED)])):
        print(f"c{i}, by powers of the tilt:", *(f"{c:.9g}" for c in constants[start:end]))
    print("beyond, by powers of b0:", *(f"{c:.9g}" for c in constants[len(CURVED) :]))
    print(f"largest error {error:.2g}, without float's rounding of the formula")


if __name__ == "__main__":
    main()
