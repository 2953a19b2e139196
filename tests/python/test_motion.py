# SPDX-License-Identifier: Apache-2.0
"""The statistics of ./paint motion, on layers whose motion is known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import seeds
from motion import layer
from motion.rows import Row

pytestmark = pytest.mark.long

SIZE = 256
CHANCE = 6 / SIZE  # six standard errors of a correlation of SIZE x SIZE independent pixels

Noise = Callable[..., np.ndarray]


@pytest.fixture
def noise() -> Noise:
    random = seeds.fresh(12)
    return lambda *shape: random.normal(size=shape or (SIZE, SIZE))


@pytest.mark.parametrize("shift", [-3, 2])
def test_what_rides_along_correlates_warped_only(shift: int, noise: Noise) -> None:
    surface = noise()
    frames = [np.roll(surface, shift * k, axis=1) for k in range(4)]
    assert layer.neighbours(frames, shift) == pytest.approx(1)
    assert abs(layer.neighbours(frames, 0)) < CHANCE
    assert layer.flicker(frames, shift) == pytest.approx(0)


def test_what_stays_in_the_picture_correlates_at_the_same_pixel_only(noise: Noise) -> None:
    frames = [noise()] * 4
    assert layer.neighbours(frames, 0) == pytest.approx(1)
    assert abs(layer.neighbours(frames, 2)) < CHANCE
    assert layer.flicker(frames, 2) == pytest.approx(1, abs=CHANCE)


def test_half_the_variance_changes(noise: Noise) -> None:
    surface = noise()
    frames = [surface + noise() for _ in range(8)]
    assert layer.neighbours(frames, 0) == pytest.approx(0.5, abs=CHANCE)
    assert layer.flicker(frames, 0) == pytest.approx(0.5, abs=CHANCE)


def test_a_streak_has_its_autocorrelation_in_spite_of_noise(noise: Noise) -> None:
    """A box of n pixels has the triangle 1 - lag/n. 6 n^2/SIZE: n pixels are one, noise twice."""
    n = 4
    sharp = noise(SIZE, SIZE + n - 1)
    streaks = sum(sharp[:, k : k + SIZE] for k in range(n))
    a, b = streaks + noise(), streaks + noise()
    expected = np.maximum(1 - np.arange(1, 7) / n, 0)
    assert layer.autocorrelation(a, b, 6) == pytest.approx(expected, abs=n * CHANCE)


def test_a_smooth_mean_is_taken_off_whole() -> None:
    y, x = np.mgrid[0:1:20j, 0:1:30j]
    mean = 3 + x - 2 * y + x * y - 0.5 * x**2 + 4 * y**2
    assert layer.smooth(mean) == pytest.approx(mean)


def test_black_frames_have_no_correlation() -> None:
    assert np.isnan(layer.correlation(np.zeros((4, 4)), np.zeros((4, 4))))


def test_a_limit_is_the_surface_anchors() -> None:
    values = {"pixel": 0.0, "surface": 0.95}
    assert list(Row("ride", values).bars("pan")) == []
    [bar] = Row("ride", values, 0.9, "at least").bars("pan")
    assert (bar.name, bar.value, bar.holds) == ("pan: ride, at least", 0.95, True)
    [bar] = Row("flicker", values, 0.9, "at most").bars("pan")
    assert not bar.holds
