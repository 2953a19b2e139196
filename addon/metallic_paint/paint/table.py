# SPDX-License-Identifier: GPL-3.0-or-later
# Made by tools/parameters.py from parameters.toml: do not edit.
"""The fields of a paint with their defaults, and what is to be known of each."""

from __future__ import annotations

from dataclasses import dataclass

from .parameter import Color, Parameter

# fmt: off
VERSION_OF_DEFAULTS = 3
# By field: a default that was, and the last version of the defaults that had it.
FORMER_DEFAULTS: dict[str, tuple[tuple[int, float | str | Color], ...]] = {
    "depth_model": ((2, "attenuated"),),
    "anchor": ((1, "pixel"),),
}

# Of two colours; 1 but for the rounding of floats.
MOST_OF_A_SUM = 1.0000001192092896

# Nothing, a sun lamp, a point or spot, an area light, or the sun of a world
UNUSED, PARALLEL, POSITIONAL, AREA, SKY = range(5)


@dataclass(frozen=True)
class FlakeFields:
    flakes_per_mm2: float = 3000.0
    flake_diameter_um: float = 20.0
    flake_area_spread: float = 0.3
    orientation: str = "gaussian"
    tilt: float = 0.15
    flake_spread: float = 0.005
    flake_color: Color = (0.91, 0.92, 0.92)
    flake_edge_color: Color = (1.0, 1.0, 1.0)
    flake_transmission: Color = (0.0, 0.0, 0.0)
    coating: str = "colors"
    coating_nm: float = 60.0


@dataclass(frozen=True)
class PaintFields:
    binder_ior: float = 1.5
    layer_thickness_um: float = 30.0
    binder_absorption_per_mm: Color = (0.0, 0.0, 0.0)
    rayleigh_per_mm: float = 0.0
    diffraction: str = "disc"
    depth_model: str = "correlated"
    radiometry: str = "exact"
    composition: str = "exact"
    anchor: str = "surface"
    cells_per_pixel: float = 5.0
    instances: str = "own"
    sparkle_contrast: float = 1.0
    seed: int = 0
    substrate_color: Color = (0.02, 0.02, 0.02)
    texture_contrast: float = 0.0
    coat_roughness: float = 0.0
    orange_peel: float = 0.0
    orange_peel_mm: float = 3.0


FLAKE_PARAMETERS = {
    "flakes_per_mm2": Parameter(
        "FlakesPerMm2", "Flakes per mm²", "Flakes", 0, 1e9,
        "How many flakes lie under a square millimetre of paint, in the whole depth of its layer. "
        "More make a denser, more even sheen: car paint has thousands, glitter has tens",
        unit="1/mm2", useful=(0, 100000),
    ),
    "flake_diameter_um": Parameter(
        "FlakeDiameterUm", "Flake Diameter (µm)", "Flakes", 0.001, 100000,
        "Diameter, in micrometres, of a disc with the mean area of the flakes. Larger flakes "
        "sparkle more brightly: fine aluminium has 11, coarse has 30, glitter has 100 and more",
        unit="um", useful=(1, 2000),
    ),
    "flake_area_spread": Parameter(
        "FlakeAreaSpread", "Flake Area Spread", "Flakes", 0, 100,
        "How unequal the flakes are: the standard deviation of their area, divided by its mean. "
        "With more, a few large flakes stand out among many small ones",
        useful=(0, 2),
    ),
    "orientation": Parameter(
        "Orientation", "Orientation", "Flakes", 0, 2,
        "How the flakes' tilts are distributed: 0 Gaussian, 1 Beckmann, 2 GGX. GGX has the "
        "longest tail, a narrow flop with a wide veil",
        choices=("gaussian", "beckmann", "ggx"),
    ),
    "tilt": Parameter(
        "Tilt", "Tilt", "Flakes", 1e-6, 100,
        "How far the flakes lie out of the surface: radians for 0 Gaussian, roughness (at most 1) "
        "for 1 Beckmann and 2 GGX. Little tilt gathers the sparkles about the highlight and makes "
        "a strong flop, much spreads them over the whole object",
        unit="rad (gaussian)", useful=(0.01, 1),
    ),
    "flake_spread": Parameter(
        "FlakeSpread", "Flake Spread", "Flakes", 0, 0.5,
        "Angle from the middle to the edge of the beam that one flake, being wavy, mirrors. A "
        "wider beam makes more sparkles, each of them dimmer",
        unit="rad", subtype="ANGLE", useful=(0, 0.17453292519943295),
    ),
    "flake_color": Parameter(
        "FlakeColor", "Flake Color", "Flakes", 0, 1,
        "Colour that a flake reflects when it is seen face on. Only with Coating 0",
        is_color=True,
    ),
    "flake_edge_color": Parameter(
        "FlakeEdgeColor", "Flake Edge Color", "Flakes", 0, 1,
        "Colour that a flake reflects at a grazing angle, where one looks flat along it. Only "
        "with Coating 0",
        is_color=True,
    ),
    "flake_transmission": Parameter(
        "FlakeTransmission", "Flake Transmission", "Flakes", 0, 1,
        "Share of the light that a flake lets through, at every angle. What it reflects and lets "
        "through is at most 1 in all. Only with Coating 0",
        is_color=True,
    ),
    "coating": Parameter(
        "FlakeCoating", "Coating", "Flakes", 0, 14,
        "What the flakes are made of. 0 colors: the three above. Otherwise a measured metal, or a "
        "pearl pigment with the interference colours of its film, as in a binder of index 1.5: 1 "
        "aluminium, 2 silver, 3 gold, 4 copper, 5 bronze, 6 brass, 7 chromium, 8 nickel, 9 "
        "tio2-on-mica, 10 tio2-on-silica, 11 tio2-on-thin-silica, 12 fe2o3-on-mica, 13 "
        "fe2o3-on-silica, 14 fe2o3-on-aluminium",
        choices=("colors", "aluminium", "silver", "gold", "copper", "bronze", "brass", "chromium",
                 "nickel", "tio2-on-mica", "tio2-on-silica", "tio2-on-thin-silica", "fe2o3-on-mica",
                 "fe2o3-on-silica", "fe2o3-on-aluminium"),
    ),
    "coating_nm": Parameter(
        "FlakeCoatingNm", "Coating (nm)", "Flakes", 0, 200,
        "Thickness of a pearl pigment's film of titanium dioxide or iron oxide, in nanometres. It "
        "decides the pearl's colour; metals ignore it",
        unit="nm",
    ),
}


PAINT_PARAMETERS = {
    "binder_ior": Parameter(
        "BinderIor", "IOR", "Binder", 0.1, 10,
        "Refractive index of the binder, the lacquer that holds the flakes, relative to what "
        "surrounds the paint. A higher one has a stronger highlight; lacquers have about 1.5",
        useful=(1, 2.5),
    ),
    "layer_thickness_um": Parameter(
        "LayerThicknessUm", "Layer Thickness (µm)", "Binder", 0, 1e6,
        "Thickness of the layer that holds the flakes, in micrometres. In a thicker one, "
        "Absorption and Rayleigh weigh more",
        unit="um", useful=(0, 1000),
    ),
    "binder_absorption_per_mm": Parameter(
        "BinderAbsorptionPerMm", "Absorption (1/mm)", "Binder", 0, 1e6,
        "How much red, green and blue the binder absorbs per millimetre of path. This tints the "
        "lacquer: for a red one, absorb green and blue",
        unit="1/mm", useful=(0, 200),
    ),
    "rayleigh_per_mm": Parameter(
        "RayleighPerMm", "Rayleigh (1/mm)", "Binder", 0, 1e6,
        "How much light fine white pigment in the binder scatters, per millimetre. More is a "
        "milky veil, which lifts the dark flank of the paint",
        unit="1/mm", useful=(0, 20),
    ),
    "diffraction": Parameter(
        "Diffraction", "Diffraction", "Sparkle", 0, 1,
        "What spreads the light of a flake besides Flake Spread: 0 none, 1 disc, the diffraction "
        "at its edge. Sparkles of flakes under 20 micrometres grow wider and dimmer by it",
        choices=("none", "disc"),
    ),
    "depth_model": Parameter(
        "DepthModel", "Depth Model", "Sparkle", 0, 2,
        "How flakes are hidden by those above them. 0 attenuated: the deeper a flake lies, the "
        "dimmer its sparkle. 1 thinned: deep flakes are left out instead, and the paint stays as "
        "bright on average. 2 correlated: most flakes that the camera sees are lit as well, so "
        "dense paints are brighter, as real ones are",
        choices=("attenuated", "thinned", "correlated"),
    ),
    "radiometry": Parameter(
        "Radiometry", "Radiometry", "Sparkle", 0, 1,
        "0 exact: the paint sends back as much light as it should. 1 published: the formulas of "
        "the paper that this paint comes from, to the letter, which differ in brightness",
        choices=("exact", "published"),
    ),
    "composition": Parameter(
        "Composition", "Composition", "Sparkle", 0, 1,
        "0 exact: sparkles add to the rest of the light. 1 published: a pixel shows the brighter "
        "of both, for each light in the slots",
        choices=("exact", "published"),
    ),
    "anchor": Parameter(
        "Anchor", "Anchor", "Sparkle", 0, 1,
        "What the sparkles belong to. 0 pixel: each pixel of the picture has its own, as in the "
        "paper, and they stay there when the object moves. 1 surface: they lie on the paint and "
        "move with it",
        choices=("pixel", "surface"),
    ),
    "cells_per_pixel": Parameter(
        "CellsPerPixel", "Cells per Pixel", "Sparkle", 1, 64,
        "Into how many cells of the paint, each with sparkles of its own, a pixel is divided. "
        "More show sharper sparkles and need more samples: 5 has two thirds of their contrast, 20 "
        "has nine tenths and needs four times the samples. Only with Anchor 1 surface",
    ),
    "instances": Parameter(
        "Instances", "Instances", "Sparkle", 0, 1,
        "0 same: copies of an object sparkle alike. 1 own: every object and instance has flakes "
        "of its own, by its Random of Object Info. Only with Anchor 1 surface",
        choices=("same", "own"),
    ),
    "sparkle_contrast": Parameter(
        "SparkleContrast", "Sparkle Contrast", "Lights", 0, 1,
        "How much the sparkles of the lights in the slots stand out: 1 as those of real flakes, 0 "
        "not at all, which leaves an even sheen. With Composition 0 exact, the paint stays as "
        "bright on average",
        subtype="FACTOR",
    ),
    "seed": Parameter(
        "Seed", "Seed", "Sparkle", -2147483648, 2147483647,
        "Another number gives the paint another set of flakes",
    ),
    "substrate_color": Parameter(
        "SubstrateColor", "Substrate Color", "Substrate", 0, 1,
        "Colour of the matt ground under the flakes. It shows where they leave gaps",
        is_color=True,
    ),
    "texture_contrast": Parameter(
        "TextureContrast", "Texture Contrast", "Substrate", 0, 1,
        "Grain in the soft light between the sparkles, which the substrate and the layer scatter. "
        "At 0.1 this light varies by 10 % from one square millimetre to the next; seen from "
        "nearer by, the grain is stronger",
        subtype="FACTOR", useful=(0, 0.5),
    ),
    "coat_roughness": Parameter(
        "CoatRoughness", "Coat Roughness", "Binder", 0, 1,
        "Roughness of the binder's surface. A rougher one blurs the highlight and what the flakes "
        "mirror: sparkles become more and dimmer, and melt under a matt coat",
        subtype="FACTOR",
    ),
    "orange_peel": Parameter(
        "OrangePeel", "Orange Peel", "Binder", 0, 1,
        "Slope (root mean square) of the waves that spraying leaves in the binder's surface. "
        "Steeper waves bend the highlight more, and ripple the flop. Good car paint has 0.1°, "
        "hammer finish has 7°",
        unit="rad", subtype="ANGLE", useful=(0, 0.17453292519943295),
    ),
    "orange_peel_mm": Parameter(
        "OrangePeelMm", "Orange Peel Size (mm)", "Binder", 0.001, 1e6,
        "Wavelength of the waves of Orange Peel, in millimetres",
        unit="mm", useful=(0.1, 100),
    ),
}

TILT_AS_ROUGHNESS = Parameter(
    "Tilt", "Tilt", "Flakes", 1e-6, 1,
    "How far the flakes lie out of the surface: radians for 0 Gaussian, roughness (at most 1) "
    "for 1 Beckmann and 2 GGX. Little tilt gathers the sparkles about the highlight and makes "
    "a strong flop, much spreads them over the whole object",
    unit="(roughness of beckmann and ggx)", useful=(0.01, 1),
)
