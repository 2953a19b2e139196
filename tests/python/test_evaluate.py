# SPDX-License-Identifier: Apache-2.0
"""What a caller of the bindings relies on: shapes, errors, and the model's own identities."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Callable
from typing import Any

import metallic_paint_core as core
import numpy as np
import parameters
import pytest
import seeds

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


def pixels(bad: float) -> np.ndarray:
    return np.array([[0, 0], [1, 0], [2, 0], [3, bad], [4, 0]])


def slants(bad: float) -> np.ndarray:
    depth = np.zeros((5, 1, 3))
    depth[4, 0, 2] = bad
    return depth


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


def assert_same(one: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> None:
    for name, array in one.items():
        np.testing.assert_array_equal(array, other[name], err_msg=name)


# Other types, other orders in memory: the same numbers. float32 and int32 are read where they are.
@pytest.mark.parametrize("precision", ["float", "double"])
def test_the_same_numbers_give_the_same_results_in_every_type(precision: str) -> None:
    singles = {name: np.float32(array) for name, array in scene().items() if name != "pixel"}
    singles["view"] *= np.float32(0.9996)  # not a float64 that was rounded
    pixel = scene()["pixel"]
    ways = [
        singles | {"pixel": pixel.astype(np.int32)},
        {name: np.float64(array) for name, array in singles.items()} | {"pixel": pixel},
        {name: np.asfortranarray(array) for name, array in singles.items()}
        | {"pixel": np.asfortranarray(pixel.astype(np.int32))},
        {name: array.astype(">f4") for name, array in singles.items()} | {"pixel": pixel.tolist()},
    ]
    results = [core.evaluate(core.Paint(), [SUN], precision=precision, **way) for way in ways]
    assert (results[0]["mean_count"] > 0).all()
    for result in results[1:]:
        assert_same(result, results[0])


def test_a_paint_that_changed_between_two_calls_is_another() -> None:
    paint = core.Paint(tilt=0.1)
    before = core.evaluate(paint, [SUN], **scene())
    paint.tilt = 0.2
    after = core.evaluate(paint, [SUN], **scene())
    assert (before["mean_radiance"] != after["mean_radiance"]).all()
    assert_same(after, core.evaluate(core.Paint(tilt=0.2), [SUN], **scene()))
    paint.tilt = 1000
    with pytest.raises(ValueError, match="tilt is 1000"):
        core.evaluate(paint, [SUN], **scene())


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


@pytest.mark.parametrize("anchor", ["pixel", "surface"])
def test_mean_of_many_pixels_is_the_closed_form(anchor: str) -> None:
    n = 200_000
    places = scene(n, own_position=seeds.fresh(14).uniform(-1, 1, (n, 3)))
    result = core.evaluate(core.Paint(flake_area_spread=0.5, anchor=anchor), [SUN], **places)
    mean, variance = result["mean_radiance"][0, 0], result["variance"][:, 0].mean(axis=0)
    deviation = (result["radiance"][:, 0].mean(axis=0) - mean) / np.sqrt(variance / n)
    # Two-sided, three colours: by chance once in a million; the pixels' deviates are fixed.
    assert np.abs(deviation).max() < 5.1


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


@pytest.mark.parametrize("name", ["sparkle", "validate", "__doc__", "__class__"])
def test_an_unknown_field_is_named(name: str) -> None:
    with pytest.raises(TypeError, match=f"Paint has no field {name}"):
        core.Paint(**{name: 1})


TABLE = parameters.read()


def wrong_kinds() -> list[tuple[str, object, str]]:
    """Of each parameter, values that are none of its, and what each must be."""
    cases = []
    for row in TABLE.all:
        if row.choices:
            other = core.DepthModel.thinned if row.name == "orientation" else core.Orientation.ggx
            values = ("phong", "", None, True, 1.5, -1, len(row.choices), other, ("ggx",))
            must = f"{', '.join(row.choices[:-1])} or {row.choices[-1]}"
        elif row.type == "int":
            values = (2**40, -(2**31) - 1, 1.5, np.float32(1.5), "a", None, True)
            must = "a whole number from -2^31 to 2^31 - 1"
        else:
            triple = ((1, 2), (1, 2, 3, 4), "abc", ("a", 1, 1), (1, True, 1), 0.5, None)
            values = triple if row.is_triple else ("a", None, (1, 2), 1j, True)
            must = "three numbers" if row.is_triple else "a number"
            must += f" from {row.range[0]:.9g} to {row.range[1]:.9g} {row.unit}".rstrip()
        cases += [(row.name, value, must) for value in values]
    return cases


@pytest.mark.parametrize(
    ("name", "value", "must"),
    [*wrong_kinds(), ("frame", 2**40, "a whole number from -2^31 to 2^31 - 1")],
)
def test_a_field_of_a_wrong_kind_is_named(name: str, value: object, must: str) -> None:
    message = f"^{re.escape(f'{name} is {reprlib.repr(value)}, but must be {must}.')}$"
    with pytest.raises(ValueError, match=message):
        core.Paint(**{name: value})
    with pytest.raises(ValueError, match=message):
        setattr(core.Paint(), name, value)


def fields_of(kind: type) -> list[str]:
    return [n for c in kind.__mro__ for n, field in vars(c).items() if isinstance(field, property)]


def test_every_field_takes_its_own_value() -> None:
    paint = core.Paint()
    own = [row.name for row in TABLE.flakes]
    assert sorted(fields_of(core.FlakeSpecies)) == sorted(own)
    paints = [row.name for row in TABLE.paint]
    assert sorted(fields_of(core.Paint)) == sorted([*own, *paints, "more", "frame"])
    assert core.Paint(**{name: getattr(paint, name) for name in fields_of(core.Paint)}) == paint


@pytest.mark.parametrize("row", [row for row in TABLE.all if row.choices], ids=lambda row: row.name)
def test_a_choice_takes_its_enumerator_its_word_and_its_number(row: parameters.Parameter) -> None:
    for number, word in enumerate(row.choices):
        enumerator = getattr(core, row.choice)[word.replace("-", "_")]
        for given in (enumerator, word, number):
            assert getattr(core.Paint(**{row.name: given}), row.name) is enumerator


@pytest.mark.parametrize("row", TABLE.all, ids=lambda row: row.name)
def test_defaults_are_those_of_the_table(row: parameters.Parameter) -> None:
    wanted = tuple(row.number) if row.is_triple else row.number
    paint = core.Paint()
    assert getattr(paint, row.name) == wanted
    if row in TABLE.flakes:
        if row.default_of_further is not None:
            wanted = row.default_of_further
        assert [getattr(more, row.name) for more in paint.more] == [wanted] * 2


def test_a_bad_species_is_named() -> None:
    good = core.FlakeSpecies(flakes_per_mm2=5)
    with pytest.raises(ValueError, match=r"^more\[1\].tilt is 0, but must be from 1e-06"):
        core.Paint(more=[good, core.FlakeSpecies(tilt=0)])
    with pytest.raises(ValueError, match=r"^more is .*, but must be two FlakeSpecies"):
        core.Paint(more=[good])


def test_moments_of_several_species_add_up() -> None:
    """Each alone as the first one, at the optical depth of all together."""
    species = [
        {"flakes_per_mm2": 800.0, "flake_diameter_um": 30.0, "tilt": 0.2},
        {"flakes_per_mm2": 20.0, "flake_diameter_um": 90.0, "flake_color": (0.2, 0.5, 0.9)},
        {"flakes_per_mm2": 5000.0, "orientation": core.Orientation.ggx, "tilt": 0.3},
    ]
    places = scene(200) | {"slant_depth": np.full((200, 1, 3), 0.7)}
    lamp = [core.Light(core.LightKind.parallel, (0.1, 0.2, 1), 0.01)]
    together = core.Paint(**species[0], more=[core.FlakeSpecies(**s) for s in species[1:]])
    found = core.evaluate(together, lamp, **places)
    alone = [core.evaluate(core.Paint(**s), lamp, **places) for s in species]
    for name in ("mean_count", "mean_radiance", "variance"):
        total = sum(one[name] for one in alone)
        assert total.min() > 0
        np.testing.assert_allclose(found[name], total, rtol=1e-13)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"normal": np.zeros((4, 3))}, r"normal has the shape \(4, 3\), but must be \(5, 3\)"),
        ({"view": np.full((5, 3), 1.0)}, r"length of view\[0\] is 1.73205081, but must be 1"),
        ({"footprint": np.array([1, 1, -1, 1, 1])}, r"footprint\[2\] is -1, but must be from 0"),
        ({"position": np.full((5, 3), np.nan)}, r"position\[0\] is nan"),
        ({"position": "here"}, r"position is 'here', but must be an array of numbers"),
        ({"position": [[0, 0], [0]]}, r"position is \[\[0, 0\], \[0\]\], but must be an array"),
        ({"view": np.full((5, 3), 1j)}, r"view is array.*, but must be an array of numbers"),
        ({"footprint": [[1.0]]}, r"footprint has the shape \(1, 1\), but must be one-dimensional"),
        ({"footprint": 1.0}, r"footprint has the shape \(\), but must be one-dimensional"),
        ({"pixel": pixels(0.5)}, r"pixel\[3\] is 0.5, but must be a whole number from -2\^31"),
        ({"pixel": pixels(np.nan)}, r"pixel\[3\] is nan, but must be a whole number"),
        ({"pixel": pixels(np.inf)}, r"pixel\[3\] is inf, but must be a whole number"),
        ({"pixel": pixels(2.0**31)}, r"pixel\[3\] is 2147483648, but .* to 2\^31 - 1"),
        ({"pixel": pixels(2**40)}, r"pixel\[3\] is 1099511627776, but must be a whole number"),
        ({"pixel": pixels(2**70)}, r"pixel\[3\] is 1.18059162071741\d*e\+21, but must be a whole"),
        ({"pixel": np.zeros((5, 3))}, r"pixel has the shape \(5, 3\), but must be \(5, 2\)"),
        ({"slant_depth": slants(-1)}, r"slant_depth\[4\] is -1, but must be from 0 to 1e\+30"),
        ({"slant_depth": slants(np.nan)}, r"slant_depth\[4\] is nan, but must be from 0 to 1e\+30"),
        ({"slant_depth": slants(np.inf)}, r"slant_depth\[4\] is inf, but must be from 0 to 1e\+30"),
        ({"slant_depth": np.zeros((5, 3))}, r"slant_depth has the shape \(5, 3\), but must be"),
        ({"precision": "half"}, r"precision is 'half', but must be 'float' or 'double'"),
    ],
)
def test_a_bad_array_is_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        core.evaluate(core.Paint(), [SUN], **scene(**changes))


@pytest.mark.parametrize("kind", [np.int8, np.int64, np.uint64, np.float32, np.float64, object])
def test_whole_pixels_of_every_kind_are_the_same(kind: type) -> None:
    pixel = np.array([[0, 1], [2, 3], [4, 5], [6, 7], [8, 9]])
    want = core.evaluate(core.Paint(), [SUN], **scene(pixel=pixel))
    found = core.evaluate(core.Paint(), [SUN], **scene(pixel=pixel.astype(kind)))
    np.testing.assert_array_equal(found["radiance"], want["radiance"])


def test_pixels_reach_the_ends_of_32_bits() -> None:
    ends = [-(2.0**31), 2.0**31 - 1]
    assert core.evaluate(core.Paint(), [SUN], **scene(1, pixel=[ends]))["count"].shape == (1, 1)


NAN, INF = float("nan"), float("inf")
UP = [[0, 0, 1.0]]


@pytest.mark.parametrize(
    ("function", "arguments", "message"),
    [
        *(
            (core.count_deviate, (mean, 0, 0.5), rf"mean is {mean:g}, but must be from 0 to inf")
            for mean in (-1, NAN, -INF)
        ),
        *(
            (core.count_deviate, (1, slots, 0.5), rf"slots is {text}, but must be .* from 0 to 16")
            for slots, text in [
                (-3, "-3"),
                (17, "17"),
                (1.5, "1.5"),
                (2**40, "1099511627776"),
                (NAN, "nan"),
                (INF, "inf"),
            ]
        ),
        *(
            (function, (*before, value), rf"{name} is {value:g}, but must be above 0 and at most 1")
            for function, before, name in [
                (core.count_deviate, (1, 0), "uniform"),
                (core.normal_quantile, (), "probability"),
            ]
            for value in (0, -0.5, 1.5, NAN, INF)
        ),
        *(
            (function, arguments(value), rf"cos_theta is {value:g}, but must be from 0 to 1")
            for function, arguments in [
                (core.fresnel_transmittance, lambda value: (value, 1.5)),
                (core.mean_projected_area, lambda value: (core.Paint(), value)),
            ]
            for value in (-0.1, 1.1, NAN, INF)
        ),
        (
            core.fresnel_transmittance,
            (1 + 1e-15, 1.5),
            r"cos_theta is 1 \(1.000000000000001\d*\), but",
        ),
        *(
            (core.fresnel_transmittance, (1, eta), rf"eta is {eta:g}, but must be from 0.1 to 10")
            for eta in (0, 0.05, 11, -1.5, NAN, INF)
        ),
        *(
            (core.orientation_density, (core.Paint(), beta), rf"beta is {beta:g}, but .* to 1.5707")
            for beta in (-0.1, 1.6, NAN, INF)
        ),
        (core.count_deviate, ("a", 0, 0.5), "mean is 'a', but must be an array of numbers"),
        (core.count_deviate, (1, "a", 0.5), "slots is 'a', but must be an array of numbers"),
        (core.count_deviate, (1, 0, 1j), "uniform is 1j, but must be an array of numbers"),
        (core.normal_quantile, ("a",), "probability is 'a', but must be an array of numbers"),
        (core.fresnel_transmittance, (1, "a"), "eta is 'a', but must be an array of numbers"),
        (core.count_deviate, ([1, 1], [0] * 3, 1), r"mean, slots and uniform have the shapes"),
        (core.fresnel_transmittance, ([1, 1], [1] * 3), r"cos_theta and eta have the shapes"),
        *(
            (
                core.flake_brdf,
                (core.Paint(), *(bad if name == field else UP for name in names)),
                rf"length of {field}\[0\] is {length}, but must be 1 to a thousandth",
            )
            for names in [("normal", "view", "light")]
            for field in names
            for bad, length in [
                ([[0, 0, 0]], "0"),
                ([[0, 0, 1.01]], "1.01"),
                ([[0, NAN, 1]], "nan"),
                ([[0, INF, 1]], "inf"),
            ]
        ),
        (core.flake_brdf, (core.Paint(), [0, 0, 1], UP, UP), r"normal has .* must be \(n, 3\)"),
        (core.flake_brdf, (core.Paint(), UP, UP * 2, UP), r"view has .* must be \(1, 3\)"),
        (core.white_noise, ([0, 0, 0], [0]), r"position has .* must be \(n, 3\)"),
        (core.white_noise, (UP, [0, 0]), r"w has the shape \(2,\), but must be \(1,\)"),
        (core.white_noise, (UP, ["a"]), r"w is \['a'\], but must be an array of numbers"),
    ],
)
def test_a_bad_argument_is_named(
    function: Callable[..., object], arguments: tuple, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        function(*arguments)


def test_white_noise_is_blenders() -> None:
    """The Color of the node in 4D, as a render shows it."""
    [color] = core.white_noise([(1, 2, 3)], [4])
    np.testing.assert_allclose(color, (0.0847689733, 0.470878571, 0.622283518), rtol=1e-8)


def test_the_ends_of_the_ranges_are_in_range() -> None:
    assert core.count_deviate(INF, 16, 1) == 16
    assert np.isfinite(core.count_deviate([0, 1, 1e300], 0, 1e-15)).all()
    assert np.isfinite(core.normal_quantile([1e-300, 1])).all()
    assert np.isfinite(core.fresnel_transmittance([[0], [1]], [0.1, 1, 10])).all()
    assert np.isfinite(core.orientation_density(core.Paint(), [0, np.pi / 2])).all()
    assert np.isfinite(core.mean_projected_area(core.Paint(), [0, 1])).all()
    assert np.isfinite(core.flake_brdf(core.Paint(), UP, [[0, 0, 1.0004]], UP)).all()


def test_nine_lights_are_too_many() -> None:
    with pytest.raises(ValueError, match="lights holds 9, but must hold at most 8"):
        core.evaluate(core.Paint(), [SUN] * 9, **scene())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((core.LightKind.parallel, (0, 0, 0), 0.1), "length of light.vector is 0"),
        ((core.LightKind.parallel, (0, 0, 1), 1.5), "light.size is 1.5, but must be from 0 to 1"),
        ((core.LightKind.positional, (0, 0, 1), -1), "light.size is -1, but must be from 0"),
        ((7, (0, 0, 1), 0.1), "light.kind is 7, but must be a LightKind: unused, parallel"),
        ((core.LightKind.parallel, (0, 1), 0.1), r"light.vector is \(0, 1\), but must be three"),
        ((core.LightKind.parallel, (0, 0, 1), "a"), "light.size is 'a', but must be a number"),
    ],
)
def test_a_bad_light_is_named(arguments: tuple, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        core.Light(*arguments)


def test_every_public_name_is_documented() -> None:
    for name in core.__all__:
        if name != "__version__":
            assert getattr(core, name).__doc__
