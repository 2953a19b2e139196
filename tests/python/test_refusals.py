# SPDX-License-Identifier: Apache-2.0
"""Add-on and core know the same paints: same defaults, same ranges, one sentence for a bad value.

The add-on checks without the native module: both take their limits and words from parameters.toml.
"""

from __future__ import annotations

import math
from typing import Any

import metallic_paint_core as core
import parameters
import pytest
from metallic_paint.paint import PARAMETERS, Flakes, Paint, PaintError, core_paint, shader_value

TABLE = parameters.read()
BLACK = dict.fromkeys(("flake_color", "flake_edge_color", "flake_transmission"), (0.0, 0.0, 0.0))


def values_of(row: parameters.Parameter) -> list[Any]:
    """Good ones, bad ones, and what is just one or the other."""
    if row.choices:
        return [*row.choices, "phong", "", None, [], 1.5, -1, len(row.choices), True]
    if row.type == "int":
        least, most = row.range
        return [least, most, least - 1, most + 1, 1.5, "1", None, True, math.nan]
    ends = [
        number
        for end in row.range
        for number in (end, math.nextafter(end, -math.inf), math.nextafter(end, math.inf))
    ]
    numbers = [*ends, -1, 2 * row.range[1] + 1, math.nan, math.inf, -math.inf, 10**400]
    wrong = ["a", None, True, [1.0]]
    if not row.is_triple:
        return [*numbers, *wrong]
    beside = [0.0, 0.0, 0.0]
    triples = [[*beside[:i], number, *beside[i + 1 :]] for number in numbers for i in range(3)]
    return [*triples, *wrong, 0.5, [0.1, 0.2], [0, 0, 0, 1], ["a", 0, 0], [0, True, 0]]


def said_by(make: Any, **fields: Any) -> str:  # noqa: ANN401
    try:
        make(**fields)
    except (PaintError, ValueError) as error:
        return str(error)
    return ""


@pytest.mark.parametrize("row", TABLE.all, ids=lambda row: row.name)
def test_core_and_addon_say_the_same_of_every_value(row: parameters.Parameter) -> None:
    refused = 0
    for value in values_of(row):
        if row.choices and type(value) is int and 0 <= value < len(row.choices):
            continue  # the core alone knows the numbers of the words
        said = said_by(Paint, **(BLACK | {row.name: value}))
        assert said == said_by(core.Paint, **(BLACK | {row.name: value})), value
        refused += bool(said)
        assert not said or (said.startswith(row.name) and said.endswith("."))
    assert refused >= 4
    assert said_by(Paint, **BLACK) == said_by(core.Paint, **BLACK) == ""


@pytest.mark.parametrize("orientation", ["gaussian", "beckmann", "ggx"])
@pytest.mark.parametrize("tilt", [0, 1e-6, 1, 1.0000001, 1.01, 100, 101, math.nan])
def test_a_tilt_that_is_a_roughness_has_its_own_range(orientation: str, tilt: float) -> None:
    fields = {"orientation": orientation, "tilt": tilt}
    assert said_by(Paint, **fields) == said_by(core.Paint, **fields)


@pytest.mark.parametrize("edge", ["", "edge_"])
@pytest.mark.parametrize(
    ("most", "taken"),
    [(0.7, True), (0.7000001, True), (0.7000002, False), (0.71, False), (0.5, True)],
)
def test_a_sum_of_colours_may_be_off_by_the_rounding_of_floats(
    edge: str, most: float, taken: bool
) -> None:
    fields = BLACK | {"flake_transmission": (0.3,) * 3, f"flake_{edge}color": (0.1, most, 0.0)}
    said = said_by(Paint, **fields)
    assert said == said_by(core.Paint, **fields)
    assert (said == "") == taken
    if not taken:
        assert said.startswith(f"flake_{edge}color + flake_transmission is 1.0")
        assert said_by(Paint, **fields, coating="gold") == ""
        assert said_by(core.Paint, **fields, coating="gold") == ""


@pytest.mark.parametrize("row", TABLE.all, ids=lambda row: row.name)
def test_defaults_are_the_same(row: parameters.Parameter) -> None:
    flakes = Flakes() if row in TABLE.flakes else Paint()
    default = getattr(flakes, row.name)
    assert shader_value(PARAMETERS[row.name], default) == getattr(core.Paint(), row.name)
    converted = core_paint(Paint(second=Flakes()))
    assert getattr(converted, row.name) == getattr(core.Paint(), row.name)
    if row in TABLE.flakes:
        plain, none = converted.more
        assert getattr(plain, row.name) == getattr(core.FlakeSpecies(), row.name)
        assert getattr(none, row.name) == getattr(core.Paint().more[1], row.name)
