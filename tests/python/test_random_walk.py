# SPDX-License-Identifier: Apache-2.0
"""The random walk from Python: shapes, repeatability, errors. Its physics: tests/core."""

from __future__ import annotations

from typing import Any

import metallic_paint_core as core
import numpy as np
import pytest

pytestmark = pytest.mark.long

LIGHT = (0.6, 0.0, 0.8)


def test_shapes_follow_detectors_and_bins() -> None:
    walk = core.random_walk(
        core.Paint(),
        LIGHT,
        detectors=[(0, 0, 1), (0, 0.6, 0.8)],
        photons=1000,
        theta_bins=2,
        phi_bins=5,
    )
    shapes = {"albedo": (3,), "absorbed": (3,), "truncated": (3,), "bins": (2, 5, 3)}
    for component in ("single_flake", "substrate", "mixture"):
        shapes |= {f"albedo_{component}": (3,), f"brdf_{component}": (2, 3)}
    shapes["brdf"] = (2, 3)
    errors = {f"{name}_error": shape for name, shape in shapes.items()}
    found = {name: np.shape(value) for name, value in walk.items()}
    assert found == shapes | errors | {"specular": (), "truncated_walks": ()}
    np.testing.assert_allclose(walk["bins"].sum(axis=(0, 1)), walk["albedo"], rtol=1e-12)


def test_detectors_and_bins_may_be_left_out() -> None:
    walk = core.random_walk(core.Paint(), LIGHT, photons=10)
    assert walk["brdf"].shape == (0, 3)
    assert walk["bins"].shape == (0, 0, 3)


def test_a_walk_repeats_itself() -> None:
    first, second, other = (
        core.random_walk(core.Paint(), LIGHT, photons=2000, seed=seed) for seed in (3, 3, 2**64 - 1)
    )
    np.testing.assert_array_equal(first["albedo"], second["albedo"])
    assert (first["albedo"] != other["albedo"]).all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"light": (0, 0, 2)}, r"length of light is 2, but must be 1 to a thousandth"),
        ({"light": (1, 0, 0)}, r"light.z is 0, but must be above 0"),
        ({"light": (0, 1)}, r"light is \(0, 1\), but must be three numbers"),
        ({"substrate": (0, 0, 1.5)}, r"substrate.b is 1.5, but must be from 0 to 1"),
        ({"detectors": [0, 0, 1]}, r"detectors has the shape \(3,\), but must be \(n, 3\)"),
        ({"detectors": [(0, 0, -1)]}, r"detectors\[0\].z is -1, but must be above 0"),
        ({"photons": 1}, "photons is 1, but must be from 2 to 1e12"),
        ({"photons": -1}, "photons is -1, but must be a whole number from 2 to 1e12"),
        ({"photons": 1e6}, "photons is 1000000.0, but must be a whole number"),
        ({"theta_bins": 3}, "theta_bins x phi_bins is 3 x 0, but must be 0 x 0 or from 1 to 16384"),
        ({"seed": -1}, r"seed is -1, but must be a whole number from 0 to 2\^64 - 1"),
        ({"seed": np.float32(1.5)}, r"seed is .*1.5.*, but must be a whole number"),
    ],
)
def test_a_bad_scene_is_named(changes: dict[str, Any], message: str) -> None:
    scene: dict[str, Any] = {"light": LIGHT, "photons": 10} | changes
    with pytest.raises(ValueError, match=message):
        core.random_walk(core.Paint(), **scene)
