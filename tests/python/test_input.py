# SPDX-License-Identifier: Apache-2.0
"""What may stand for a number or an array; the rest is refused in words, not lost in silence."""

from __future__ import annotations

import decimal
import fractions
import itertools
import re
from collections.abc import Callable
from typing import Any

import metallic_paint_core as core
import numpy as np
import pytest

UP = [[0.0, 0.0, 1.0]]
COSINES = [0.25, 0.5, 1.0]
MASKED = np.ma.array(COSINES, mask=[False, True, False])


def transmittance(cosines: object) -> np.ndarray:
    return core.fresnel_transmittance(cosines, 1.5)


@pytest.mark.parametrize(
    "cosines",
    [
        np.array(COSINES, np.float16),
        np.array(COSINES, np.longdouble),
        np.array(COSINES, ">f8"),
        np.array(COSINES, ">f4"),
        np.array(COSINES, object),
        np.array([[c, 7] for c in COSINES])[:, 0],  # not contiguous
        np.array(COSINES[::-1])[::-1],
        [fractions.Fraction(1, 4), decimal.Decimal("0.5"), 1],
        tuple(COSINES),
        memoryview(np.array(COSINES)),
    ],
)
def test_every_kind_of_number_is_the_same_number(cosines: object) -> None:
    np.testing.assert_array_equal(transmittance(cosines), transmittance(COSINES))


def test_arrays_may_be_read_only_and_are_left_alone() -> None:
    given = np.array(COSINES)
    given.flags.writeable = False
    transmittance(given)
    np.testing.assert_array_equal(given, COSINES)


def test_booleans_are_0_and_1() -> None:
    np.testing.assert_array_equal(transmittance([False, True]), transmittance([0, 1]))


def test_no_numbers_give_no_results() -> None:
    assert transmittance([]).shape == (0,)
    assert transmittance(np.zeros((0, 3))).shape == (0, 3)
    assert core.flake_brdf(core.Paint(), *[np.zeros((0, 3))] * 3).shape == (0, 3)
    assert core.white_noise(np.zeros((0, 3)), []).shape == (0, 3)
    assert core.library_coating([], [], []).shape == (2, 0, 3)


@pytest.mark.parametrize(
    ("cosines", "message"),
    [
        (MASKED, r"cos_theta is masked_array\(.*\), but must be without a mask"),
        ([MASKED, COSINES], r"cos_theta is \[masked.*, but must be without a mask"),
        ([1.0, np.ma.masked], r"cos_theta is \[1.0, masked\], but must be without a mask"),
        (np.ma.masked, r"cos_theta is masked, but must be without a mask"),
        (np.ma.array(COSINES), r"cos_theta is masked_array\(.*\), but must be without a mask"),
        (None, r"cos_theta is None, but must be an array of numbers"),
        ([0.5, None], r"cos_theta\[1\] is None, but must be a number"),
        ([[0.5, 1.0], [1.0, None]], r"cos_theta\[1\] is None, but must be a number"),
        (np.array([0.5, "1"], object), r"cos_theta\[1\] is '1', but must be a number"),
        ("1", r"cos_theta is '1', but must be an array of numbers"),
        (["1", "1"], r"cos_theta is \['1', '1'\], but must be an array of numbers"),
        (b"1", r"cos_theta is b'1', but must be an array of numbers"),
        (np.array([1j]), r"cos_theta is array\(\[0.\+1.j\]\), but must be an array of numbers"),
        ([0.5, 1j], r"cos_theta is \[0.5, 1j\], but must be an array of numbers"),
        (np.array([0.5, 1j], object), r"cos_theta\[1\] is 1j, but must be a number"),
        (
            np.array([0.5, np.complex128(1 + 1j)], object),
            r"cos_theta\[1\] is .*1\+1j.*, but must be a number",
        ),
        (np.array(["2020-01-01"], "M8[D]"), r"cos_theta is array.*, but must be an array of"),
        (np.zeros(2, "V4"), r"cos_theta is array.*, but must be an array of numbers"),
        ([[1.0, 1.0], [1.0]], r"cos_theta is \[\[1.0, 1.0\], \[1.0\]\], but must be an array"),
        ((c for c in COSINES), r"cos_theta is <generator .*, but must be an array of numbers"),
        ({0.5}, r"cos_theta is \{0.5\}, but must be an array of numbers"),
        ([0.5, 10**400], r"cos_theta\[1\] is 10+\.\.\.0+, but must be a number up to 1.8e308"),
        ([10**5000], r"cos_theta\[0\] is .*, but must be a number up to 1.8e308"),
        (np.longdouble("1e4000"), r"cos_theta is inf, but must be from 0 to 1"),
    ],
)
@pytest.mark.filterwarnings("ignore:overflow encountered in cast:RuntimeWarning")
def test_what_is_no_array_of_numbers_is_named(cosines: object, message: str) -> None:
    with pytest.raises(ValueError, match=f"(?s)^{message}"):
        transmittance(cosines)


def test_a_list_that_holds_itself_is_no_array() -> None:
    endless: list[object] = []
    endless.append(endless)
    with pytest.raises(ValueError, match=r"^cos_theta\b.*, but must be"):
        transmittance(endless)


@pytest.mark.parametrize(
    "value",
    [
        np.ma.masked,
        np.ma.array(0.3),
        np.complex128(0.3 + 1j),
        np.complex64(0.3),
        np.array(0.3 + 1j),
        np.array([0.3]),
        np.str_("0.3"),
        np.datetime64("2020-01-01"),
        None,
        "0.3",
        b"0.3",
    ],
)
def test_what_is_no_number_is_named(value: object) -> None:
    with pytest.raises(ValueError, match=r"(?s)^tilt is .*, but must be (a number|without a mask)"):
        core.Paint(tilt=value)
    with pytest.raises(ValueError, match=r"(?s)^footprint is .*, but must be (a number|without)"):
        core.explicit_flakes(core.Paint(), UP[0], UP[0], 0.1, value, 1)


@pytest.mark.parametrize("value", [np.float32(0.25), np.array(0.25), decimal.Decimal("0.25")])
def test_a_number_may_be_of_any_kind(value: object) -> None:
    assert core.Paint(tilt=value).tilt == 0.25


@pytest.mark.parametrize("value", [(0, 0), [0, 0, 0, 0], np.zeros((3, 1)), np.zeros((1, 3)), 0, {}])
def test_three_numbers_are_three(value: object) -> None:
    with pytest.raises(ValueError, match=r"(?s)^light is .*, but must be three numbers"):
        core.random_walk(core.Paint(), value)
    with pytest.raises(ValueError, match=r"(?s)^light\.vector is .*, but must be three numbers"):
        core.Light(core.LightKind.parallel, value, 0)


def evaluate(**changes: Any) -> object:  # noqa: ANN401
    n = 1
    arguments = {
        "paint": core.Paint(),
        "lights": [],
        "position": np.zeros((n, 3)),
        "normal": UP,
        "view": UP,
        "footprint": np.full(n, 1e-7),
        "pixel": np.zeros((n, 2)),
    }
    return core.evaluate(**(arguments | changes))


PLACES = {
    "position": np.zeros((1, 3)),
    "normal": UP,
    "view": UP,
    "footprint": [1e-7],
    "pixel": [[0, 0]],
}
NEEDS_PAINT: list[Callable[[Any], object]] = [
    lambda paint: evaluate(paint=paint),
    lambda paint: core.explicit_flakes(paint, UP[0], UP[0], 0.1, 1e-7, 1),
    lambda paint: core.random_walk(paint, UP[0], photons=2),
    lambda paint: core.flake_brdf(paint, UP, UP, UP),
    lambda paint: core.shade(paint, [], **PLACES),
    lambda paint: core.reflectance(paint, UP, **PLACES),
    lambda paint: core.orientation_density(paint, 0),
    lambda paint: core.mean_projected_area(paint, 1),
    lambda paint: core.mixture(paint, UP[0], 1),
]


@pytest.mark.parametrize("call", NEEDS_PAINT)
@pytest.mark.parametrize("value", [None, "red", {}, core.FlakeSpecies(), core.Paint])
def test_a_paint_of_another_type_is_named(call: Callable[[Any], object], value: object) -> None:
    kind = type(value).__name__
    with pytest.raises(TypeError, match=rf"^paint is of the type {kind}, but must be a Paint\.$"):
        call(value)


LIGHT = core.Light(core.LightKind.parallel, (0, 0, 1), 0.1)


@pytest.mark.parametrize(
    ("lights", "message"),
    [
        (LIGHT, "lights is of the type Light, but must be a sequence of Light"),
        (None, "lights is of the type NoneType, but must be a sequence of Light"),
        (iter([LIGHT]), "lights is of the type list_iterator, but must be a sequence of Light"),
        (itertools.repeat(LIGHT), "lights is of the type repeat, but must be a sequence of Light"),
        ([LIGHT, None], r"lights\[1\] is of the type NoneType, but must be a Light"),
        ("sun", r"lights\[0\] is of the type str, but must be a Light"),
    ],
)
def test_lights_of_another_type_are_named(lights: object, message: str) -> None:
    with pytest.raises(TypeError, match=f"^{message}\\.$"):
        evaluate(lights=lights)
    with pytest.raises(TypeError, match=f"^{message}\\.$"):
        core.shade(core.Paint(), lights, **PLACES)


@pytest.mark.parametrize("value", [None, 3, "half", b"float", ["float"]])
def test_a_word_that_is_no_choice_is_named(value: object) -> None:
    shown = re.escape(repr(value))
    with pytest.raises(ValueError, match=rf"^precision is {shown}, .* 'float' or 'double'\.$"):
        evaluate(precision=value)
    some = "'none', 'attenuated', 'thinned' or 'discs'"
    with pytest.raises(ValueError, match=rf"^shadowing is {shown}, but must be {some}\.$"):
        core.explicit_flakes(core.Paint(), UP[0], UP[0], 0.1, 1e-7, 1, shadowing=value)


class NoMemory:
    def __array__(self, dtype: object = None, copy: object = None) -> np.ndarray:
        raise MemoryError

    def __float__(self) -> float:
        raise MemoryError


def test_out_of_memory_is_out_of_memory() -> None:
    with pytest.raises(MemoryError):
        transmittance(NoMemory())
    with pytest.raises(MemoryError):
        core.Paint(tilt=NoMemory())
    zeros = np.broadcast_to(np.zeros(1), (2**40,))  # 8 TB as an array of its own, 8 bytes as it is
    with pytest.raises(MemoryError):
        transmittance(zeros)


def test_results_beyond_all_addresses_are_refused() -> None:
    rows = [np.ones([2**16 if i == k else 1 for i in range(4)]) for k in range(3)]
    with pytest.raises((ValueError, MemoryError)):
        core.count_deviate(rows[0], rows[1] * 0, rows[2])
