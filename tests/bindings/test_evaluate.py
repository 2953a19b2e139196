# SPDX-License-Identifier: Apache-2.0
"""What a caller of the bindings relies on: shapes, errors, and the model's own identities."""

from __future__ import annotations

from typing import Any

import metallic_paint_core as core
import numpy as np
import pytest

SUN = core.Light(core.LightKind.parallel, (0.3, 0.1, 0.9), 0.00465)
LAMP = core.Light(core.LightKind.positional, (-1, 2, 3), 0.1)


def scene(n: int = 5, **changes: Any) -> dict[str, Any]:  # noqa: ANN401
    view = np.tile([0.28, 0.0, 0.96], (n, 1))
    pixel = np.stack([np.arange(n), -np.arange(n)], axis=1)
    return {
        "position": np.zeros((n, 3)),
        "normal": np.tile([0.0, 0.0, 1.0], (n, 1)),
        "view": view,
        "footprint": np.full(n, 1e-7),
        "pixel": pixel,
    } | changes


def test_shapes_follow_pixels_and_lights() -> None:
    result = core.evaluate(core.Paint(), [SUN, LAMP], **scene(7))
    shapes = {name: array.shape for name, array in result.items()}
    assert shapes == {
        "leader": (7, 2),
        "slots": (7, 2),
        "mean_count": (7, 2),
        "count": (7, 2),
        "radiance": (7, 2, 3),
        "mean_radiance": (7, 2, 3),
        "variance": (7, 2, 3),
    }


def test_no_pixels_and_no_lights_are_no_error() -> None:
    assert core.evaluate(core.Paint(), [SUN], **scene(0))["count"].shape == (0, 1)
    assert core.evaluate(core.Paint(), [], **scene(3))["count"].shape == (3, 0)


@pytest.mark.parametrize("radiometry", list(core.Radiometry))
@pytest.mark.parametrize("orientation", list(core.Orientation))
def test_mean_radiance_is_cosine_times_brdf(
    radiometry: core.Radiometry, orientation: core.Orientation
) -> None:
    paint = core.Paint(
        radiometry=radiometry, orientation=orientation, binder_absorption_per_mm=(1, 10, 30)
    )
    direction = np.array([SUN.vector]) / np.linalg.norm(SUN.vector)
    places = scene(1)
    brdf = core.flake_brdf(paint, places["normal"], places["view"], direction)
    mean = core.evaluate(paint, [SUN], **places)["mean_radiance"][:, 0]
    np.testing.assert_allclose(mean, direction[0, 2] * brdf, rtol=1e-12)


def test_mean_of_many_pixels_is_the_closed_form() -> None:
    n = 200_000
    result = core.evaluate(core.Paint(flake_area_spread=0.5), [SUN], **scene(n))
    mean, variance = result["mean_radiance"][0, 0], result["variance"][0, 0]
    deviation = (result["radiance"][:, 0].mean(axis=0) - mean) / np.sqrt(variance / n)
    assert (
        np.abs(deviation).max() < 4
    )  # two-sided, by chance once in 16,000; the deviates are fixed


def test_two_lights_in_one_another_share_their_sparkles() -> None:
    beside = core.Light(core.LightKind.parallel, (0.3005, 0.1, 0.9), 0.00465)
    result = core.evaluate(core.Paint(), [SUN, beside], **scene())
    assert (result["leader"] == 0).all()
    np.testing.assert_array_equal(result["radiance"][:, 1], result["radiance"][:, 0])


def test_a_light_below_the_horizon_gives_nothing() -> None:
    under = core.Light(core.LightKind.parallel, (0, 0.1, -1), 0.1)
    result = core.evaluate(core.Paint(), [under], **scene())
    assert (result["leader"] == -1).all()
    assert not result["radiance"].any()


def test_a_constant_coating_table_is_the_same_paint() -> None:
    paint = core.Paint(
        flake_color=[0.5] * 3, flake_edge_color=[0.5] * 3, flake_transmission=[0.25] * 3
    )
    table = core.CoatingTable([[0.5] * 3] * 2, [[0.25] * 3] * 2)
    plain = core.evaluate(paint, [SUN], **scene())
    tabulated = core.evaluate(paint, [SUN], **scene(), coating=table)
    np.testing.assert_allclose(tabulated["mean_radiance"], plain["mean_radiance"], rtol=1e-5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"flake_diameter_um": -1}, r"flake_diameter_um is -1, but must be from 0.001 to 100000"),
        ({"tilt": float("nan")}, r"tilt is nan, but must be from 1e-06 to 100 rad"),
        ({"flake_color": (0.5, 2, 0.5)}, r"flake_color.g is 2, but must be from 0 to 1"),
        ({"flake_transmission": (0, 0, 0.5)}, r"flake_color \+ flake_transmission is 1.42"),
        ({"binder_ior": float("inf")}, r"binder_ior is inf, but must be from 0.1 to 10"),
    ],
)
def test_a_bad_paint_is_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        core.Paint(**changes)
    paint = core.Paint()
    for name, value in changes.items():
        setattr(paint, name, value)
    with pytest.raises(ValueError, match=message):
        core.evaluate(paint, [SUN], **scene())


def test_an_unknown_field_is_named() -> None:
    with pytest.raises(TypeError, match="Paint has no field sparkle"):
        core.Paint(sparkle=1)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"normal": np.zeros((4, 3))}, r"normal has the shape \(4, 3\), but must be \[5, 3\]"),
        ({"view": np.full((5, 3), 1.0)}, r"length of view\[0\] is 1.73205081, but must be 1"),
        ({"footprint": np.array([1, 1, -1, 1, 1])}, r"footprint\[2\] is -1, but must be from 0"),
        ({"position": np.full((5, 3), np.nan)}, r"position\[0\] is nan"),
        ({"precision": "half"}, r"precision is 'half', but must be 'float' or 'double'"),
    ],
)
def test_a_bad_array_is_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        core.evaluate(core.Paint(), [SUN], **scene(**changes))


def test_nine_lights_are_too_many() -> None:
    with pytest.raises(ValueError, match="lights holds 9, but must hold at most 8"):
        core.evaluate(core.Paint(), [SUN] * 9, **scene())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((core.LightKind.parallel, (0, 0, 0), 0.1), "length of light.vector is 0"),
        ((core.LightKind.parallel, (0, 0, 1), 1.5), "light.size is 1.5, but must be from 0 to 1"),
        ((core.LightKind.positional, (0, 0, 1), -1), "light.size is -1, but must be from 0"),
    ],
)
def test_a_bad_light_is_named(arguments: tuple, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        core.Light(*arguments)


def test_every_public_name_is_documented() -> None:
    for name in core.__all__:
        if name not in ("__version__", "LightKind"):
            assert getattr(core, name).__doc__
