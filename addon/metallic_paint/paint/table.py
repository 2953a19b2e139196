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
        "Flakes in the whole depth of the layer under one square millimetre of surface",
        unit="1/mm2", useful=(0, 100000),
    ),
    "flake_diameter_um": Parameter(
        "FlakeDiameterUm", "Flake Diameter (µm)", "Flakes", 0.001, 100000,
        "Diameter of the disk that has the mean area of the flakes, in micrometres",
        unit="um", useful=(1, 2000),
    ),
    "flake_area_spread": Parameter(
        "FlakeAreaSpread", "Flake Area Spread", "Flakes", 0, 100,
        "Standard deviation of the flakes' area divided by its mean",
        useful=(0, 2),
    ),
    "orientation": Parameter(
        "Orientation", "Orientation", "Flakes", 0, 2,
        "How the flakes' tilt is distributed: 0 Gaussian in the tilt angle, 1 Beckmann, 2 GGX",
        choices=("gaussian", "beckmann", "ggx"),
    ),
    "tilt": Parameter(
        "Tilt", "Tilt", "Flakes", 1e-6, 100,
        "How far the flakes lie out of the surface: radians for a Gaussian, roughness alpha (at "
        "most 1) for Beckmann and GGX",
        unit="rad (gaussian)", useful=(0.01, 1),
    ),
    "flake_spread": Parameter(
        "FlakeSpread", "Flake Spread", "Flakes", 0, 0.5,
        "Angular radius by which one flake, being wavy, spreads the light that it reflects",
        unit="rad", subtype="ANGLE", useful=(0, 0.17453292519943295),
    ),
    "flake_color": Parameter(
        "FlakeColor", "Flake Color", "Flakes", 0, 1,
        "Reflectance of a flake at normal incidence. Only with Coating 0",
        is_color=True,
    ),
    "flake_edge_color": Parameter(
        "FlakeEdgeColor", "Flake Edge Color", "Flakes", 0, 1,
        "Reflectance of a flake at grazing incidence. Only with Coating 0",
        is_color=True,
    ),
    "flake_transmission": Parameter(
        "FlakeTransmission", "Flake Transmission", "Flakes", 0, 1,
        "Transmittance of a flake at every angle: with either reflectance at most 1. Only with "
        "Coating 0",
        is_color=True,
    ),
    "coating": Parameter(
        "FlakeCoating", "Coating", "Flakes", 0, 14,
        "0 colors: the three above. Otherwise a measured metal, or a pearl pigment with the "
        "interference colours of its film, as in a binder of index 1.5: 1 aluminium, 2 silver, 3 "
        "gold, 4 copper, 5 bronze, 6 brass, 7 chromium, 8 nickel, 9 tio2-on-mica, 10 "
        "tio2-on-silica, 11 tio2-on-thin-silica, 12 fe2o3-on-mica, 13 fe2o3-on-silica, 14 "
        "fe2o3-on-aluminium",
        choices=("colors", "aluminium", "silver", "gold", "copper", "bronze", "brass", "chromium",
                 "nickel", "tio2-on-mica", "tio2-on-silica", "tio2-on-thin-silica", "fe2o3-on-mica",
                 "fe2o3-on-silica", "fe2o3-on-aluminium"),
    ),
    "coating_nm": Parameter(
        "FlakeCoatingNm", "Coating (nm)", "Flakes", 0, 200,
        "Thickness of a pearl pigment's film of titanium dioxide or iron oxide, in nanometres",
        unit="nm",
    ),
}


PAINT_PARAMETERS = {
    "binder_ior": Parameter(
        "BinderIor", "IOR", "Binder", 0.1, 10,
        "Refractive index of the binder relative to what surrounds the paint",
        useful=(1, 2.5),
    ),
    "layer_thickness_um": Parameter(
        "LayerThicknessUm", "Layer Thickness (µm)", "Binder", 0, 1e6,
        "Thickness of the layer that holds the flakes, in micrometres",
        unit="um", useful=(0, 1000),
    ),
    "binder_absorption_per_mm": Parameter(
        "BinderAbsorptionPerMm", "Absorption (1/mm)", "Binder", 0, 1e6,
        "How much of red, green and blue the binder absorbs per millimetre of path",
        unit="1/mm", useful=(0, 200),
    ),
    "rayleigh_per_mm": Parameter(
        "RayleighPerMm", "Rayleigh (1/mm)", "Binder", 0, 1e6,
        "Weight of the scattering by pigment particles, per millimetre",
        unit="1/mm", useful=(0, 20),
    ),
    "diffraction": Parameter(
        "Diffraction", "Diffraction", "Sparkle", 0, 1,
        "0 none. 1 disc: a flake spreads light as a disc of its diameter diffracts it, besides "
        "its own Flake Spread",
        choices=("none", "disc"),
    ),
    "depth_model": Parameter(
        "DepthModel", "Depth Model", "Sparkle", 0, 2,
        "0 attenuated: every sparkle is dimmed by its own depth. 1 thinned: deep flakes are left "
        "out instead, with the same mean. 2 correlated: what hides a flake from the observer "
        "often hides it from the light as well, so dense layers are brighter, as real ones are",
        choices=("attenuated", "thinned", "correlated"),
    ),
    "radiometry": Parameter(
        "Radiometry", "Radiometry", "Sparkle", 0, 1,
        "0 exact: energy is conserved. 1 published: the formulas of the paper to the letter",
        choices=("exact", "published"),
    ),
    "composition": Parameter(
        "Composition", "Composition", "Sparkle", 0, 1,
        "0 exact: sparkles add to the rest of the light. 1 published: of each light in the slots "
        "a pixel takes the brighter of both",
        choices=("exact", "published"),
    ),
    "anchor": Parameter(
        "Anchor", "Anchor", "Sparkle", 0, 1,
        "What the sparkles belong to. 0 pixel: every pixel draws its own, as in the paper; they "
        "stay where they are in the picture. 1 surface: they ride on the paint",
        choices=("pixel", "surface"),
    ),
    "cells_per_pixel": Parameter(
        "CellsPerPixel", "Cells per Pixel", "Sparkle", 1, 64,
        "With Anchor surface: so many cells of the paint, each with sparkles of its own, lie in a "
        "pixel. More show them sharper and want more samples",
    ),
    "instances": Parameter(
        "Instances", "Instances", "Sparkle", 0, 1,
        "With Anchor surface. 0 same: copies of an object have the same flakes. 1 own: each has "
        "flakes of its own, by the Random of Object Info",
        choices=("same", "own"),
    ),
    "sparkle_contrast": Parameter(
        "SparkleContrast", "Sparkle Contrast", "Lights", 0, 1,
        "How much the sparkles of the lights in the slots stand out: 1 as flakes do, 0 not at "
        "all, only their mean is left. With Composition exact, the paint stays as bright",
        subtype="FACTOR",
    ),
    "seed": Parameter(
        "Seed", "Seed", "Sparkle", -2147483648, 2147483647,
        "Another number, another set of flakes",
    ),
    "substrate_color": Parameter(
        "SubstrateColor", "Substrate Color", "Substrate", 0, 1,
        "Diffuse reflectance of what lies under the flakes",
        is_color=True,
    ),
    "texture_contrast": Parameter(
        "TextureContrast", "Texture Contrast", "Substrate", 0, 1,
        "Relative deviation, from place to place, of the light that is scattered several times or "
        "by the substrate, seen over 1 mm²; finer pixels see more, the finest even more than they "
        "receive",
        subtype="FACTOR", useful=(0, 0.5),
    ),
    "coat_roughness": Parameter(
        "CoatRoughness", "Coat Roughness", "Binder", 0, 1,
        "Roughness of the surface of the binder. It blurs the highlight, and the flakes seen "
        "through it: sparkles become more and dimmer",
        subtype="FACTOR",
    ),
    "orange_peel": Parameter(
        "OrangePeel", "Orange Peel", "Binder", 0, 1,
        "Slope (root mean square) of the waves that spraying leaves in the binder's surface. Good "
        "car paint has some 0.1°",
        unit="rad", subtype="ANGLE", useful=(0, 0.17453292519943295),
    ),
    "orange_peel_mm": Parameter(
        "OrangePeelMm", "Orange Peel Size (mm)", "Binder", 0.001, 1e6,
        "Wavelength of those waves, in millimetres",
        unit="mm", useful=(0.1, 100),
    ),
}

TILT_AS_ROUGHNESS = Parameter(
    "Tilt", "Tilt", "Flakes", 1e-6, 1,
    "How far the flakes lie out of the surface: radians for a Gaussian, roughness alpha (at "
    "most 1) for Beckmann and GGX",
    unit="(roughness of beckmann and ggx)", useful=(0.01, 1),
)
