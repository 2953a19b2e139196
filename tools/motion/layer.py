# SPDX-License-Identifier: Apache-2.0
"""What is measured of the sparkle layer: a picture less what it is on average.

Arrays (height, width), row 0 at the bottom. Layers have the mean 0, so no mean is taken off here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def correlation(a: np.ndarray, b: np.ndarray) -> float:
    """NaN where a layer has no sparkles."""
    with np.errstate(invalid="ignore"):
        return float((a * b).sum() / np.sqrt((a * a).sum() * (b * b).sum()))


def warped(layers: Sequence[np.ndarray], shift: int) -> np.ndarray:
    """The surface that all frames show, (frames, h, w): it moves `shift` pixels right in each."""
    last = len(layers) - 1
    width = layers[0].shape[1] - abs(shift) * last
    starts = (shift * frame if shift > 0 else -shift * (last - frame) for frame in range(last + 1))
    return np.stack([layer[:, x : x + width] for layer, x in zip(layers, starts, strict=True)])


def neighbours(layers: Sequence[np.ndarray], shift: int) -> float:
    """Correlation of each frame with the next, over all of them, warped with the motion."""
    pairs = [warped(layers[i : i + 2], shift) for i in range(len(layers) - 1)]
    return correlation(np.concatenate([a for a, _ in pairs]), np.concatenate([b for _, b in pairs]))


def flicker(layers: Sequence[np.ndarray], shift: int) -> float:
    """Share of the layer's variance with which a place of the surface changes in time.

    0 for sparkles that stay, 1 where every frame has others.
    """
    seen = warped(layers, shift)
    return float(seen.var(axis=0, ddof=1).mean() / (seen**2).mean())


def autocorrelation(a: np.ndarray, b: np.ndarray, lags: int) -> np.ndarray:
    """Along x, at 1..lags pixels, from two renders with other samples: their noise drops out."""
    at = [
        (a[:, lag:] * b[:, : b.shape[1] - lag] + b[:, lag:] * a[:, : a.shape[1] - lag]).mean()
        for lag in range(lags + 1)
    ]
    return np.array(at[1:]) / at[0]


def smooth(picture: np.ndarray) -> np.ndarray:
    """The quadric in x and y nearest to it: the mean of a material that has none in closed form."""
    y, x = np.mgrid[-1 : 1 : picture.shape[0] * 1j, -1 : 1 : picture.shape[1] * 1j]
    terms = np.stack([x**0, x, y, x * x, x * y, y * y], axis=-1).reshape(-1, 6)
    return (terms @ np.linalg.lstsq(terms, picture.ravel(), rcond=None)[0]).reshape(picture.shape)
