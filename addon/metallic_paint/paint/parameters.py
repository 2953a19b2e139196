# SPDX-License-Identifier: GPL-3.0-or-later
"""Paints, whose parameters table.py lists, each with its unit and its range; they check themselves.

Bad values are refused in the words of the core. Nothing here needs Blender or the core.
"""

from __future__ import annotations

import dataclasses
import math
import numbers
import operator
import reprlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, TypeGuard

from . import table
from .parameter import Color, Parameter
from .table import FLAKE_PARAMETERS, MOST_OF_A_SUM, PAINT_PARAMETERS

if TYPE_CHECKING:
    import metallic_paint_core

FLAKES, BINDER, SUBSTRATE, SPARKLE, LIGHTS = "Flakes", "Binder", "Substrate", "Sparkle", "Lights"
SECOND, THIRD = "Second Flakes", "Third Flakes"
PANELS = (FLAKES, SECOND, THIRD, BINDER, SUBSTRATE, SPARKLE, LIGHTS)

COATINGS = FLAKE_PARAMETERS["coating"].choices
INT_MIN, INT_MAX = -(2**31), 2**31 - 1

_Value = float | int | str | Color


class PaintError(ValueError):
    """A paint that cannot be, in a sentence with field, value and range; or none where one must."""


def _refusal(name: str, value: str, range_: str) -> PaintError:
    return PaintError(f"{name} is {value}, but must be {range_}.")


def _checked(name: str, value: object, parameter: Parameter, default: _Value) -> _Value:
    """The value, if the parameter may have it."""
    if parameter.choices:
        if isinstance(value, str) and value in parameter.choices:
            return value
        *others, last = parameter.choices
        raise _refusal(name, shown(value), f"{', '.join(others)} or {last}")
    range_ = f"from {_plain(parameter.minimum)} to {_plain(parameter.maximum)} {parameter.unit}"
    range_ = range_.rstrip()
    if isinstance(default, tuple):
        if not isinstance(value, Sequence) or len(value) != 3 or not all(map(_is_real, value)):
            raise _refusal(name, shown(value), f"three numbers {range_}")
        r, g, b = map(float, value)
        return (
            _within(f"{name}.r", r, parameter, range_),
            _within(f"{name}.g", g, parameter, range_),
            _within(f"{name}.b", b, parameter, range_),
        )
    if isinstance(default, int):
        if _is_whole(value) and parameter.minimum <= value <= parameter.maximum:
            return int(value)
        raise _refusal(name, shown(value), "a whole number from -2^31 to 2^31 - 1")
    if not _is_real(value):
        raise _refusal(name, shown(value), f"a number {range_}")
    return _within(name, float(value), parameter, range_)


def _is_whole(value: object) -> TypeGuard[int]:
    return isinstance(value, numbers.Integral) and not isinstance(value, bool)


def _is_real(value: object) -> TypeGuard[float]:
    """Whether it is a number that a float can be."""
    if not isinstance(value, numbers.Real) or isinstance(value, bool):
        return False
    try:
        float(value)
    except OverflowError:
        return False
    return True


def _within(name: str, value: float, parameter: Parameter, range_: str) -> float:
    if parameter.minimum <= value <= parameter.maximum:  # false for NaN
        return value
    text = _plain(value)
    # All digits where these are those of the limit that the value misses.
    if text in (_plain(parameter.minimum), _plain(parameter.maximum)):
        text += f" ({value:.17g})"
    raise _refusal(name, text, range_)


def _plain(value: float) -> str:
    return f"{value:.9g}"


def shown(value: object) -> str:
    """Short and printable, whatever the value: reprlib goes down a few levels only."""
    text = reprlib.repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def coverage(per_mm2: float, diameter_um: float, area_spread: float) -> float:
    """Of flakes of one species, their area per area of surface."""
    area_mm2 = math.pi / 4 * (diameter_um * 1e-3) ** 2
    s = area_spread  # E[max(0, 1 + s w)], w a standard normal deviate
    if s > 0:
        above = (1 + math.erf(1 / (s * math.sqrt(2)))) / 2
        area_mm2 *= above + s * math.exp(-0.5 / s**2) / math.sqrt(2 * math.pi)
    return per_mm2 * area_mm2


@dataclass(frozen=True)
class Flakes(table.FlakeFields):
    """One species of flakes. Colours are linear RGB; every field is checked on construction."""

    parameters: ClassVar[dict[str, Parameter]] = FLAKE_PARAMETERS

    def __post_init__(self) -> None:
        if self.orientation in ("beckmann", "ggx"):
            _checked("tilt", self.tilt, table.TILT_AS_ROUGHNESS, 0.0)
        for name, parameter in self.parameters.items():
            value = _checked(name, getattr(self, name), parameter, getattr(type(self), name))
            object.__setattr__(self, name, value)
        if self.coating == "colors":
            for name in ("flake_color", "flake_edge_color"):
                sums = map(operator.add, getattr(self, name), self.flake_transmission)
                if (most := max(sums)) > MOST_OF_A_SUM:
                    raise _refusal(f"{name} + flake_transmission", _plain(most),
                                   "at most 1 in every channel")  # fmt: skip

    @property
    def flake_coverage(self) -> float:
        """Flake area per area of surface (the model's D H ⟨S⟩), dimensionless."""
        return coverage(self.flakes_per_mm2, self.flake_diameter_um, self.flake_area_spread)


NO_FLAKES = Flakes(flakes_per_mm2=0)


@dataclass(frozen=True)
class Paint(table.PaintFields, Flakes):
    """A metallic paint, whose own flakes are the first species of up to three."""

    parameters: ClassVar[dict[str, Parameter]] = FLAKE_PARAMETERS | PAINT_PARAMETERS

    second: Flakes = NO_FLAKES
    third: Flakes = NO_FLAKES

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("second", "third"):
            if not isinstance(getattr(self, name), Flakes):
                raise _refusal(name, shown(getattr(self, name)), "Flakes")

    @property
    def species(self) -> tuple[Flakes, ...]:
        """All three, the paint's own first."""
        return (self, self.second, self.third)


def _of_species(field: str, number: int, panel: str) -> dict[str, Parameter]:
    return {
        f"{field}.{name}": dataclasses.replace(
            parameter,
            shader=f"{field.title()}{parameter.shader}",
            label=f"{parameter.label} {number}",
            panel=panel,
        )
        for name, parameter in FLAKE_PARAMETERS.items()
    }


# By field; those of the second and third species as "second.tilt".
PARAMETERS: dict[str, Parameter] = {
    **FLAKE_PARAMETERS,
    **PAINT_PARAMETERS,
    **_of_species("second", 2, SECOND),
    **_of_species("third", 3, THIRD),
}


def value_of(paint: Paint, name: str) -> float | int | str | Color:
    """The value of one of PARAMETERS."""
    return operator.attrgetter(name)(paint)


def shader_value(parameter: Parameter, value: float | str | Color) -> float | int | Color:
    """A field's value as the shader takes it: words become integers."""
    return parameter.choices.index(value) if isinstance(value, str) else value


def core_paint(paint: Paint, frame: int = 0) -> metallic_paint_core.Paint:
    """The paint as the core takes it."""
    import metallic_paint_core as core

    def fields(flakes: Flakes) -> dict[str, object]:
        return {name: getattr(flakes, name) for name in flakes.parameters}

    more = [core.FlakeSpecies(**fields(flakes)) for flakes in (paint.second, paint.third)]
    return core.Paint(**fields(paint), more=more, frame=frame)
