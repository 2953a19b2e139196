# SPDX-License-Identifier: Apache-2.0
"""The brute-force reference as Python sees it; its physics is tested in tests/core."""

from __future__ import annotations

from typing import Any

import metallic_paint_core as core
import numpy as np
import pytest

pytestmark = pytest.mark.long

PAINT = core.Paint(flakes_per_mm2=2000, tilt=0.2)


def trace(**changes: Any) -> dict[str, Any]:  # noqa: ANN401
    scene = {
        "paint": PAINT,
        "view": (0.28, 0, 0.96),
        "light": (-0.28, 0, 0.96),
        "light_radius": 0.05,
        "footprint": 1e-7,
        "pixels": 50,
    }
    return core.explicit_flakes(**(scene | changes))


def test_shapes_and_meaning() -> None:
    traced = trace()
    assert traced["count"].shape == (50,)
    assert traced["radiance"].shape == (50, 3)
    assert traced["mean_share"].shape == traced["mean_square_share"].shape == (3,)
    # 200 flakes in each pixel, a Poisson count: 6 standard deviations.
    assert abs(traced["flakes"] - 10_000) < 600
    assert np.all((traced["radiance"][:, 0] > 0) <= (traced["count"] > 0))
    assert 0 < traced["mean_share"][0] ** 2 < traced["mean_square_share"][0] < 1


def test_every_species_is_traced_and_counted() -> None:
    pearl = core.FlakeSpecies(flakes_per_mm2=1000, tilt=0.2, coating=9, coating_nm=90)
    none = core.FlakeSpecies(flakes_per_mm2=0)
    only_pearl = core.Paint(flakes_per_mm2=0, more=[none, pearl])
    both = core.Paint(flakes_per_mm2=2000, tilt=0.2, more=[none, pearl])
    traced = trace(paint=only_pearl)
    assert abs(traced["flakes"] - 5000) < 430
    assert list(traced["sparkles"] > 0) == [False, False, True]
    # In the colour of the pearl at the one angle that mirrors the light, but for the light's width.
    angle = np.arcsin(0.28 / PAINT.binder_ior)
    colour = core.library_coating([9], [90.0], [np.cos(angle)])[0, 0]
    seen = trace(paint=only_pearl, shadowing="none")["radiance"].sum(axis=0)
    np.testing.assert_allclose(seen / seen.sum(), colour / colour.sum(), rtol=0.02)
    assert list(trace()["sparkles"] > 0) == [True, False, False]
    traced = trace(paint=both)
    assert abs(traced["flakes"] - 15_000) < 740
    assert list(traced["sparkles"] > 0) == [True, False, True]
    assert traced["sparkles"].sum() == traced["count"].sum()


def test_a_seed_repeats_itself() -> None:
    assert np.array_equal(trace(seed=7)["radiance"], trace(seed=7)["radiance"])
    assert not np.array_equal(trace(seed=7)["radiance"], trace(seed=-8)["radiance"])


def test_shadowing_leaves_what_it_says() -> None:
    free = trace(shadowing="none")
    assert np.array_equal(free["mean_share"], [1, 1, 1])
    for shadowing in ("attenuated", "discs"):
        dimmed = trace(shadowing=shadowing)
        assert np.array_equal(dimmed["count"], free["count"])
        assert dimmed["radiance"].sum() < free["radiance"].sum()
    assert trace(shadowing="thinned")["count"].sum() < free["count"].sum()


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("view", (0, 0)),
        ("length of light", (0, 0, 2)),
        ("light_radius", -1),
        ("light_radius", "wide"),
        ("footprint", float("nan")),
        ("pixels", 0),
        ("pixels", -1),
        ("pixels", 1.5),
        ("shadowing", "soft"),
        ("points", 0),
        ("seed", 2**40),
    ],
)
def test_bad_input_is_named(field: str, value: object) -> None:
    with pytest.raises(ValueError, match=f"^{field}"):
        trace(**{field.split()[-1]: value})
