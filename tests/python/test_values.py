# SPDX-License-Identifier: Apache-2.0
"""Paints, species and lights are values: equal by their fields, and whole in copies and pickles."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import metallic_paint_core as core
import parameters
import pytest

TABLE = parameters.read()
SPECIES = core.FlakeSpecies(tilt=0.3, flake_color=(0.1, 0.2, 0.3), coating="gold")
PAINT = core.Paint(binder_ior=1.6, anchor="pixel", frame=7, more=[SPECIES, core.FlakeSpecies()])
LIGHT = core.Light(core.LightKind.area, (1, 2, 3), 0.25, (0, 0, -0.5))
VALUES = [SPECIES, PAINT, LIGHT]
COPIES = [copy.copy, copy.deepcopy] + [
    lambda value, protocol=protocol: pickle.loads(pickle.dumps(value, protocol))
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1)
]


def another(row: parameters.Parameter) -> Any:  # noqa: ANN401
    """A value that is not the default."""
    if row.choices:
        return (row.choices.index(row.default) + 1) % len(row.choices)
    if row.type == "int":
        return row.default + 1
    of_three = row.default if row.is_triple else (row.default,)
    numbers = [0.5 * number if number else 0.125 for number in of_three]
    return numbers if row.is_triple else numbers[0]


@pytest.mark.parametrize("value", VALUES)
@pytest.mark.parametrize("copied", COPIES)
def test_a_copy_is_equal_and_of_the_same_class(value: Any, copied: Callable) -> None:  # noqa: ANN401
    other = copied(value)
    assert other is not value
    assert type(other) is type(value)
    assert other == value


@pytest.mark.parametrize(
    ("kind", "row"),
    [(core.FlakeSpecies, row) for row in TABLE.flakes] + [(core.Paint, row) for row in TABLE.all],
    ids=lambda each: getattr(each, "__name__", None) or each.name,
)
def test_each_field_counts_and_is_copied(kind: type, row: parameters.Parameter) -> None:
    one = kind()
    other = copy.copy(one)
    setattr(other, row.name, another(row))
    assert one == kind()
    assert one != other
    for copied in COPIES:
        assert getattr(copied(other), row.name) == getattr(other, row.name)
        assert copied(other) == other


def test_frame_and_further_species_count() -> None:
    assert core.Paint(frame=1) != core.Paint()
    assert core.Paint(more=[SPECIES, SPECIES]) != core.Paint(more=[SPECIES, core.FlakeSpecies()])


@pytest.mark.parametrize(
    "other",
    [
        core.Light(core.LightKind.positional, (1, 2, 3), 0.25, (0, 0, -0.5)),
        core.Light(core.LightKind.area, (1, 2, 4), 0.25, (0, 0, -0.5)),
        core.Light(core.LightKind.area, (1, 2, 3), 0.5, (0, 0, -0.5)),
        core.Light(core.LightKind.area, (1, 2, 3), 0.25, (0, 0.5, 0)),
    ],
)
def test_each_field_of_a_light_counts(other: core.Light) -> None:
    assert other != LIGHT
    assert len({LIGHT, other, copy.copy(LIGHT)}) == 2


@pytest.mark.parametrize("value", VALUES)
def test_nothing_else_is_equal(value: object) -> None:
    assert all(value != other for other in (None, 1, "paint", {}, *VALUES) if other is not value)
    assert core.FlakeSpecies() != core.Paint()  # whose first species it is
    assert core.Paint() != core.FlakeSpecies()


@pytest.mark.parametrize("value", [SPECIES, PAINT])
def test_what_may_change_has_no_hash(value: object) -> None:
    with pytest.raises(TypeError, match="unhashable"):
        hash(value)


def test_a_paint_out_of_range_stays_what_it_is_in_a_copy() -> None:
    wrong = core.Paint()
    wrong.tilt = -1
    assert copy.copy(wrong).tilt == -1
    with pytest.raises(ValueError, match=r"^tilt is -1"):
        copy.copy(wrong).validate()


def test_a_pickle_of_a_version_with_fewer_fields_has_the_defaults_for_the_rest() -> None:
    paint = core.Paint.__new__(core.Paint)
    paint.__setstate__({"tilt": 0.3})
    assert paint == core.Paint(tilt=0.3)


def test_a_pickle_with_an_unknown_field_names_it() -> None:
    with pytest.raises(TypeError, match=r"^Paint has no field sheen$"):
        core.Paint.__new__(core.Paint).__setstate__({"sheen": 1})
