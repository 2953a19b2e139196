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
    # How many flakes lie under a square millimetre of paint, in the whole depth of its layer; 0 to
    # 1e9 1/mm2
    flakes_per_mm2: float
    # Diameter, in micrometres, of a disc with the mean area of the flakes; 0.001 to 100000 um
    flake_diameter_um: float
    # How unequal the flakes are: the standard deviation of their area, divided by its mean; 0 to
    # 100
    flake_area_spread: float
    # How the flakes' tilts are distributed: 0 Gaussian, 1 Beckmann, 2 GGX
    orientation: Orientation
    # How far the flakes lie out of the surface: radians for 0 Gaussian, roughness (at most 1) for 1
    # Beckmann and 2 GGX; 1e-6 to 100 rad (gaussian), 1e-6 to 1 (roughness of beckmann and ggx)
    tilt: float
    # Angle from the middle to the edge of the beam that one flake, being wavy, mirrors; 0 to 0.5
    # rad
    flake_spread: float
    # Colour that a flake reflects when it is seen face on; 0 to 1
    flake_color: Colour
    # Colour that a flake reflects at a grazing angle, where one looks flat along it; 0 to 1
    flake_edge_color: Colour
    # Share of the light that a flake lets through, at every angle; 0 to 1
    flake_transmission: Colour
    # What the flakes are made of
    coating: CoatingKind
    # Thickness of a pearl pigment's film of titanium dioxide or iron oxide, in nanometres; 0 to 200
    # nm
    coating_nm: float

    def __init__(self, **fields: object) -> None: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]

class Paint(FlakeSpecies):
    more: Sequence[FlakeSpecies]  # the second and the third species
    # Refractive index of the binder, the lacquer that holds the flakes, relative to what surrounds
    # the paint; 0.1 to 10
    binder_ior: float
    # Thickness of the layer that holds the flakes, in micrometres; 0 to 1e6 um
    layer_thickness_um: float
    # How much red, green and blue the binder absorbs per millimetre of path; 0 to 1e6 1/mm
    binder_absorption_per_mm: Colour
    # How much light fine white pigment in the binder scatters, per millimetre; 0 to 1e6 1/mm
    rayleigh_per_mm: float
    # What spreads the light of a flake besides Flake Spread: 0 none, 1 disc, the diffraction at its
    # edge
    diffraction: Diffraction
    # How flakes are hidden by those above them
    depth_model: DepthModel
    # 0 exact: the paint sends back as much light as it should
    radiometry: Radiometry
    # 0 exact: sparkles add to the rest of the light
    composition: Composition
    # What the sparkles belong to
    anchor: Anchor
    # Into how many cells of the paint, each with sparkles of its own, a pixel is divided; 1 to 64
    cells_per_pixel: float
    # 0 same: copies of an object sparkle alike
    instances: Instances
    # How much the sparkles of the lights in the slots stand out: 1 as those of real flakes, 0 not
    # at all, which leaves an even sheen; 0 to 1
    sparkle_contrast: float
    # Another number gives the paint another set of flakes
    seed: int
    # Colour of the matt ground under the flakes; 0 to 1
    substrate_color: Colour
    # Grain in the soft light between the sparkles, which the substrate and the layer scatter; 0 to
    # 1
    texture_contrast: float
    # Roughness of the binder's surface; 0 to 1
    coat_roughness: float
    # Slope (root mean square) of the waves that spraying leaves in the binder's surface; 0 to 1 rad
    orange_peel: float
    # Wavelength of the waves of Orange Peel, in millimetres; 0.001 to 1e6 mm
    orange_peel_mm: float
    frame: int

    def __init__(self, **fields: object) -> None: ...
    def validate(self) -> None: ...
