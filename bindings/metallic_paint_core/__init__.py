# SPDX-License-Identifier: Apache-2.0
"""The metallic-paint model over numpy arrays: the reference that the shader is checked against.

Arrays may be anything numpy can turn into one of numbers; results are float64 unless stated. Bad
input raises ValueError with a sentence that names the field, the value and the range, an argument
of a wrong class TypeError. Ctrl-C ends every call at once. The model is `core/`, its symbols and
formulas are in docs/model; each docstring names its source there.
"""

from ._native import (
    Anchor,
    CoatingKind,
    Composition,
    DepthModel,
    Diffraction,
    FlakeSpecies,
    Instances,
    Light,
    LightKind,
    Orientation,
    Paint,
    Radiometry,
    __version__,
    count_deviate,
    evaluate,
    explicit_flakes,
    flake_brdf,
    fresnel_transmittance,
    hash_words,
    library_coating,
    mean_projected_area,
    mixture,
    normal_quantile,
    orientation_density,
    pixel_texture,
    random_walk,
    reflectance,
    shade,
)

__all__ = [
    "Anchor",
    "CoatingKind",
    "Composition",
    "DepthModel",
    "Diffraction",
    "FlakeSpecies",
    "Instances",
    "Light",
    "LightKind",
    "Orientation",
    "Paint",
    "Radiometry",
    "__version__",
    "count_deviate",
    "evaluate",
    "explicit_flakes",
    "flake_brdf",
    "fresnel_transmittance",
    "hash_words",
    "library_coating",
    "mean_projected_area",
    "mixture",
    "normal_quantile",
    "orientation_density",
    "pixel_texture",
    "random_walk",
    "reflectance",
    "shade",
]
