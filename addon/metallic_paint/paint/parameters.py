# SPDX-License-Identifier: GPL-3.0-or-later
"""The parameters of a paint, one for one those of the shader, each with its unit and its range.

This is the one place for names, defaults, ranges and explanations: presets, sockets and tests
read them from the fields' metadata. Nothing here needs Blender.
"""

from __future__ import annotations

import dataclasses
import math
import numbers
import operator
import reprlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeGuard

if TYPE_CHECKING:
    import metallic_paint_core

Color = tuple[float, float, float]

FLAKES, BINDER, SUBSTRATE, SPARKLE, LIGHTS = "Flakes", "Binder", "Substrate", "Sparkle", "Lights"
SECOND, THIRD = "Second Flakes", "Third Flakes"
PANELS = (FLAKES, SECOND, THIRD, BINDER, SUBSTRATE, SPARKLE, LIGHTS)

COATINGS = (
    "colors", "aluminium", "silver", "gold", "copper", "bronze", "brass", "chromium", "nickel",
    "tio2-on-mica", "tio2-on-silica", "tio2-on-thin-silica", "fe2o3-on-mica", "fe2o3-on-silica",
    "fe2o3-on-aluminium",
)  # fmt: skip

INT_MIN, INT_MAX = -(2**31), 2**31 - 1


class PaintError(ValueError):
    """A paint that cannot be, said in a sentence with field, value and range."""


@dataclass(frozen=True)
class Parameter:
    """How one field of a paint is named, bounded and explained."""

    shader: str  # the shader's name of it
    label: str
    panel: str
    minimum: float
    maximum: float
    description: str
    choices: tuple[str, ...] = ()  # words whose positions are the shader's integers
    subtype: str = "NONE"  # of Blender's socket
    is_color: bool = False  # chosen as a colour, and so in 0..1
    useful: tuple[float, float] | None = None  # where a slider ends; one may type what lies beyond

    @property
    def slider(self) -> tuple[float, float]:
        return self.useful or (self.minimum, self.maximum)


def _field(default: Any, *args: Any, **kwargs: Any) -> Any:  # noqa: ANN401
    return dataclasses.field(default=default, metadata={"parameter": Parameter(*args, **kwargs)})


def _check_fields(checked: Flakes) -> None:
    for field in dataclasses.fields(checked):
        if parameter := field.metadata.get("parameter"):
            value = getattr(checked, field.name)
            value = _checked(field.name, value, field.default, parameter)
            object.__setattr__(checked, field.name, value)


def _checked(
    name: str, value: object, default: object, parameter: Parameter
) -> float | int | str | tuple[float, ...]:
    if parameter.choices:
        if value not in parameter.choices:
            raise PaintError(
                f"{name} is {shown(value)} and must be one of {', '.join(parameter.choices)}."
            )
        return value
    if isinstance(default, tuple):
        if isinstance(value, str) or not isinstance(value, Sequence) or len(value) != 3:
            raise PaintError(f"{name} is {shown(value)} and must be three numbers.")
        return tuple(
            float(_number(f"{name}[{i}]", channel, parameter)) for i, channel in enumerate(value)
        )
    if isinstance(default, int):
        if isinstance(value, bool) or not isinstance(value, numbers.Integral):
            raise PaintError(f"{name} is {shown(value)} and must be a whole number.")
        return int(_number(name, value, parameter))
    return float(_number(name, value, parameter))


def _is_real(value: object) -> TypeGuard[float]:
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def _number(name: str, value: object, parameter: Parameter) -> float:
    if not _is_real(value):
        raise PaintError(f"{name} is {shown(value)} and must be a number.")
    if not parameter.minimum <= value <= parameter.maximum:  # false for NaN too
        raise PaintError(
            f"{name} is {shown(value)} and must lie in "
            f"{parameter.minimum:g}..{parameter.maximum:g}."
        )
    return value


def _check_energy(reflectance: str, r: Color, transmittance: str, t: Color) -> None:
    for i in range(3):
        if r[i] + t[i] > 1:
            raise PaintError(
                f"{reflectance}[{i}] + {transmittance}[{i}] is {r[i]} + {t[i]} and must lie in "
                "0..1: a flake cannot give back more light than it receives."
            )


def shown(value: object) -> str:
    """Short and printable, whatever the value: reprlib goes down a few levels only."""
    text = reprlib.repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


@dataclass(frozen=True)
class Flakes:
    """One species of flakes. Colours are linear RGB; every field is checked on construction."""

    # fmt: off
    flakes_per_mm2: float = _field(
        3000.0, "FlakesPerMm2", "Flakes per mm²", FLAKES, 0, 1e9,
        "Flakes in the whole depth of the layer under one square millimetre of surface",
        useful=(0, 1e5),
    )
    flake_diameter_um: float = _field(
        20.0, "FlakeDiameterUm", "Flake Diameter (µm)", FLAKES, 1e-3, 1e5,
        "Diameter of the disk that has the mean area of the flakes, in micrometres",
        useful=(1, 2000),
    )
    flake_area_spread: float = _field(
        0.3, "FlakeAreaSpread", "Flake Area Spread", FLAKES, 0, 100,
        "Standard deviation of the flakes' area divided by its mean",
        useful=(0, 2),
    )
    orientation: str = _field(
        "gaussian", "Orientation", "Orientation", FLAKES, 0, 2,
        "How the flakes' tilt is distributed: 0 Gaussian in the tilt angle, 1 Beckmann, 2 GGX",
        choices=("gaussian", "beckmann", "ggx"),
    )
    tilt: float = _field(
        0.15, "Tilt", "Tilt", FLAKES, 1e-6, 100,
        "How far the flakes lie out of the surface: radians for a Gaussian, roughness alpha "
        "(at most 1) for Beckmann and GGX",
        useful=(0.01, 1),
    )
    flake_spread: float = _field(
        0.005, "FlakeSpread", "Flake Spread", FLAKES, 0, 0.5,
        "Angular radius by which one flake, being wavy, spreads the light that it reflects",
        subtype="ANGLE", useful=(0, math.radians(10)),
    )
    flake_color: Color = _field(
        (0.91, 0.92, 0.92), "FlakeColor", "Flake Color", FLAKES, 0, 1,
        "Reflectance of a flake at normal incidence. Only with Coating 0", is_color=True,
    )
    flake_edge_color: Color = _field(
        (1.0, 1.0, 1.0), "FlakeEdgeColor", "Flake Edge Color", FLAKES, 0, 1,
        "Reflectance of a flake at grazing incidence. Only with Coating 0", is_color=True,
    )
    flake_transmission: Color = _field(
        (0.0, 0.0, 0.0), "FlakeTransmission", "Flake Transmission", FLAKES, 0, 1,
        "Transmittance of a flake at every angle: with either reflectance at most 1. Only with "
        "Coating 0",
        is_color=True,
    )
    coating: str = _field(
        "colors", "FlakeCoating", "Coating", FLAKES, 0, len(COATINGS) - 1,
        "0 colors: the three above. Otherwise a measured metal, or a pearl pigment with the "
        "interference colours of its film, as in a binder of index 1.5: " + ", ".join(
            f"{number} {name}" for number, name in enumerate(COATINGS) if number
        ),
        choices=COATINGS,
    )
    coating_nm: float = _field(
        60.0, "FlakeCoatingNm", "Coating (nm)", FLAKES, 0, 200,
        "Thickness of a pearl pigment's film of titanium dioxide or iron oxide, in nanometres",
    )
    # fmt: on

    def __post_init__(self) -> None:
        _check_fields(self)
        if self.orientation != "gaussian" and self.tilt > 1:
            raise PaintError(
                f"tilt is {self.tilt} and must lie in 1e-06..1, being the roughness alpha of "
                f"orientation {self.orientation!r}."
            )
        if self.coating == "colors":
            transmitted = "flake_transmission", self.flake_transmission
            _check_energy("flake_color", self.flake_color, *transmitted)
            _check_energy("flake_edge_color", self.flake_edge_color, *transmitted)

    @property
    def flake_coverage(self) -> float:
        """Flake area per area of surface (the model's D H ⟨S⟩), dimensionless."""
        area_mm2 = math.pi / 4 * (self.flake_diameter_um * 1e-3) ** 2
        s = self.flake_area_spread  # E[max(0, 1 + s w)], w a standard normal deviate
        if s > 0:
            above = (1 + math.erf(1 / (s * math.sqrt(2)))) / 2
            area_mm2 *= above + s * math.exp(-0.5 / s**2) / math.sqrt(2 * math.pi)
        return self.flakes_per_mm2 * area_mm2


NO_FLAKES = Flakes(flakes_per_mm2=0)


@dataclass(frozen=True)
class Paint(Flakes):
    """A metallic paint, whose own flakes are the first species of up to three."""

    second: Flakes = NO_FLAKES
    third: Flakes = NO_FLAKES
    # fmt: off
    binder_ior: float = _field(
        1.5, "BinderIor", "IOR", BINDER, 0.1, 10,
        "Refractive index of the binder relative to what surrounds the paint",
        useful=(1, 2.5),
    )
    layer_thickness_um: float = _field(
        30.0, "LayerThicknessUm", "Layer Thickness (µm)", BINDER, 0, 1e6,
        "Thickness of the layer that holds the flakes, in micrometres",
        useful=(0, 1000),
    )
    binder_absorption_per_mm: Color = _field(
        (0.0, 0.0, 0.0), "BinderAbsorptionPerMm", "Absorption (1/mm)", BINDER, 0, 1e6,
        "How much of red, green and blue the binder absorbs per millimetre of path",
        useful=(0, 200),
    )
    rayleigh_per_mm: float = _field(
        0.0, "RayleighPerMm", "Rayleigh (1/mm)", BINDER, 0, 1e6,
        "Weight of the scattering by pigment particles, per millimetre",
        useful=(0, 20),
    )
    diffraction: str = _field(
        "disc", "Diffraction", "Diffraction", SPARKLE, 0, 1,
        "0 none. 1 disc: a flake spreads light as a disc of its diameter diffracts it, besides "
        "its own Flake Spread",
        choices=("none", "disc"),
    )
    depth_model: str = _field(
        "attenuated", "DepthModel", "Depth Model", SPARKLE, 0, 1,
        "0 attenuated: every sparkle is dimmed by its own depth. 1 thinned: deep flakes are left "
        "out instead, with the same mean",
        choices=("attenuated", "thinned"),
    )
    radiometry: str = _field(
        "exact", "Radiometry", "Radiometry", SPARKLE, 0, 1,
        "0 exact: energy is conserved. 1 published: the formulas of the paper to the letter",
        choices=("exact", "published"),
    )
    composition: str = _field(
        "exact", "Composition", "Composition", SPARKLE, 0, 1,
        "0 exact: sparkles add to the rest of the light. 1 published: of each light in the slots a "
        "pixel takes the brighter of both",
        choices=("exact", "published"),
    )
    sparkle_contrast: float = _field(
        1.0, "SparkleContrast", "Sparkle Contrast", LIGHTS, 0, 1,
        "How much the sparkles of the lights in the slots stand out: 1 as flakes do, 0 not at all, "
        "only their mean is left. With Composition exact, the paint stays as bright",
        subtype="FACTOR",
    )
    seed: int = _field(
        0, "Seed", "Seed", SPARKLE, INT_MIN, INT_MAX, "Another number, another set of flakes",
    )
    substrate_color: Color = _field(
        (0.02, 0.02, 0.02), "SubstrateColor", "Substrate Color", SUBSTRATE, 0, 1,
        "Diffuse reflectance of what lies under the flakes", is_color=True,
    )
    texture_contrast: float = _field(
        0.0, "TextureContrast", "Texture Contrast", SUBSTRATE, 0, 1,
        "Relative deviation, from place to place, of the light that is scattered several times or "
        "by the substrate, seen over 1 mm²; finer pixels see more, the finest even more than they "
        "receive", subtype="FACTOR", useful=(0, 0.5),
    )
    coat_roughness: float = _field(
        0.0, "CoatRoughness", "Coat Roughness", BINDER, 0, 1,
        "Roughness of the surface of the binder. It blurs the highlight only: flakes are seen as "
        "through a smooth coat", subtype="FACTOR",
    )
    orange_peel: float = _field(
        0.0, "OrangePeel", "Orange Peel", BINDER, 0, 1,
        "Slope (root mean square) of the waves that spraying leaves in the binder's surface. Good "
        "car paint has some 0.1°", subtype="ANGLE", useful=(0, math.radians(10)),
    )
    orange_peel_mm: float = _field(
        3.0, "OrangePeelMm", "Orange Peel Size (mm)", BINDER, 1e-3, 1e6,
        "Wavelength of those waves, in millimetres",
        useful=(0.1, 100),
    )
    # fmt: on

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("second", "third"):
            if not isinstance(getattr(self, name), Flakes):
                raise PaintError(f"{name} is {shown(getattr(self, name))} and must be Flakes.")

    @property
    def species(self) -> tuple[Flakes, ...]:
        """All three, the paint's own first."""
        return (self, self.second, self.third)


def _parameters(of: type[Flakes]) -> dict[str, Parameter]:
    return {
        field.name: field.metadata["parameter"]
        for field in dataclasses.fields(of)
        if "parameter" in field.metadata
    }


def _of_species(field: str, number: int, panel: str) -> dict[str, Parameter]:
    return {
        f"{field}.{name}": dataclasses.replace(
            parameter,
            shader=f"{field.title()}{parameter.shader}",
            label=f"{parameter.label} {number}",
            panel=panel,
        )
        for name, parameter in _parameters(Flakes).items()
    }


# By field; those of the second and third species as "second.tilt".
PARAMETERS: dict[str, Parameter] = {
    **_parameters(Paint),
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
        known = {name: getattr(flakes, name) for name in _parameters(type(flakes))}
        known["orientation"] = core.Orientation[flakes.orientation]
        known["coating"] = COATINGS.index(flakes.coating)
        return known

    all_fields = fields(paint)
    all_fields["composition"] = core.Composition[paint.composition]
    all_fields["diffraction"] = core.Diffraction[paint.diffraction]
    all_fields["depth_model"] = core.DepthModel[paint.depth_model]
    all_fields["radiometry"] = core.Radiometry[paint.radiometry]
    more = [core.FlakeSpecies(**fields(flakes)) for flakes in (paint.second, paint.third)]
    return core.Paint(**all_fields, more=more, frame=frame)
