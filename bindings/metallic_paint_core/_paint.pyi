# SPDX-License-Identifier: Apache-2.0
# Made by tools/parameters.py from parameters.toml: do not edit.
"""Types of the paint in the native module."""

from collections.abc import Sequence
from enum import IntEnum
from typing import ClassVar

class Orientation(IntEnum):
    gaussian = 0
    beckmann = 1
    ggx = 2

class CoatingKind(IntEnum):
    colors = 0
    aluminium = 1
    silver = 2
    gold = 3
    copper = 4
    bronze = 5
    brass = 6
    chromium = 7
    nickel = 8
    tio2_on_mica = 9
    tio2_on_silica = 10
    tio2_on_thin_silica = 11
    fe2o3_on_mica = 12
    fe2o3_on_silica = 13
    fe2o3_on_aluminium = 14

class Diffraction(IntEnum):
    none = 0
    disc = 1

class DepthModel(IntEnum):
    attenuated = 0
    thinned = 1
    correlated = 2

class Radiometry(IntEnum):
    exact = 0
    published = 1

class Composition(IntEnum):
    exact = 0
    published = 1

class Anchor(IntEnum):
    pixel = 0
    surface = 1

class Instances(IntEnum):
    same = 0
    own = 1

class LightKind(IntEnum):
    unused = 0
    parallel = 1
    positional = 2
    area = 3
    sky = 4

Colour = tuple[float, float, float]

class FlakeSpecies:
    # Flakes in the whole depth of the layer under one square millimetre of surface; 0 to 1e9 1/mm2
    flakes_per_mm2: float
    # Diameter of the disk that has the mean area of the flakes, in micrometres; 0.001 to 100000 um
    flake_diameter_um: float
    # Standard deviation of the flakes' area divided by its mean; 0 to 100
    flake_area_spread: float
    # How the flakes' tilt is distributed: 0 Gaussian in the tilt angle, 1 Beckmann, 2 GGX
    orientation: Orientation
    # How far the flakes lie out of the surface: radians for a Gaussian, roughness alpha (at most 1)
    # for Beckmann and GGX; 1e-6 to 100 rad (gaussian), 1e-6 to 1 (roughness of beckmann and ggx)
    tilt: float
    # Angular radius by which one flake, being wavy, spreads the light that it reflects; 0 to 0.5
    # rad
    flake_spread: float
    # Reflectance of a flake at normal incidence. Only with Coating 0; 0 to 1
    flake_color: Colour
    # Reflectance of a flake at grazing incidence. Only with Coating 0; 0 to 1
    flake_edge_color: Colour
    # Transmittance of a flake at every angle: with either reflectance at most 1. Only with Coating
    # 0; 0 to 1
    flake_transmission: Colour
    # 0 colors: the three above. Otherwise a measured metal, or a pearl pigment with the
    # interference colours of its film, as in a binder of index 1.5: 1 aluminium, 2 silver, 3 gold,
    # 4 copper, 5 bronze, 6 brass, 7 chromium, 8 nickel, 9 tio2-on-mica, 10 tio2-on-silica, 11
    # tio2-on-thin-silica, 12 fe2o3-on-mica, 13 fe2o3-on-silica, 14 fe2o3-on-aluminium
    coating: CoatingKind
    # Thickness of a pearl pigment's film of titanium dioxide or iron oxide, in nanometres; 0 to 200
    # nm
    coating_nm: float

    def __init__(self, **fields: object) -> None: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]

class Paint(FlakeSpecies):
    more: Sequence[FlakeSpecies]  # the second and the third species
    # Refractive index of the binder relative to what surrounds the paint; 0.1 to 10
    binder_ior: float
    # Thickness of the layer that holds the flakes, in micrometres; 0 to 1e6 um
    layer_thickness_um: float
    # How much of red, green and blue the binder absorbs per millimetre of path; 0 to 1e6 1/mm
    binder_absorption_per_mm: Colour
    # Weight of the scattering by pigment particles, per millimetre; 0 to 1e6 1/mm
    rayleigh_per_mm: float
    # 0 none. 1 disc: a flake spreads light as a disc of its diameter diffracts it, besides its own
    # Flake Spread
    diffraction: Diffraction
    # 0 attenuated: every sparkle is dimmed by its own depth. 1 thinned: deep flakes are left out
    # instead, with the same mean. 2 correlated: what hides a flake from the observer often hides it
    # from the light as well, so dense layers are brighter, as real ones are
    depth_model: DepthModel
    # 0 exact: energy is conserved. 1 published: the formulas of the paper to the letter
    radiometry: Radiometry
    # 0 exact: sparkles add to the rest of the light. 1 published: of each light in the slots a
    # pixel takes the brighter of both
    composition: Composition
    # What the sparkles belong to. 0 pixel: every pixel draws its own, as in the paper; they stay
    # where they are in the picture. 1 surface: they ride on the paint
    anchor: Anchor
    # With Anchor surface: so many cells of the paint, each with sparkles of its own, lie in a
    # pixel. More show them sharper and want more samples; 1 to 64
    cells_per_pixel: float
    # With Anchor surface. 0 same: copies of an object have the same flakes. 1 own: each has flakes
    # of its own, by the Random of Object Info
    instances: Instances
    # How much the sparkles of the lights in the slots stand out: 1 as flakes do, 0 not at all, only
    # their mean is left. With Composition exact, the paint stays as bright; 0 to 1
    sparkle_contrast: float
    # Another number, another set of flakes
    seed: int
    # Diffuse reflectance of what lies under the flakes; 0 to 1
    substrate_color: Colour
    # Relative deviation, from place to place, of the light that is scattered several times or by
    # the substrate, seen over 1 mm²; finer pixels see more, the finest even more than they receive;
    # 0 to 1
    texture_contrast: float
    # Roughness of the surface of the binder. It blurs the highlight, and the flakes seen through
    # it: sparkles become more and dimmer; 0 to 1
    coat_roughness: float
    # Slope (root mean square) of the waves that spraying leaves in the binder's surface. Good car
    # paint has some 0.1°; 0 to 1 rad
    orange_peel: float
    # Wavelength of those waves, in millimetres; 0.001 to 1e6 mm
    orange_peel_mm: float
    frame: int

    def __init__(self, **fields: object) -> None: ...
    def validate(self) -> None: ...
