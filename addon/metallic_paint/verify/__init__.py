# SPDX-License-Identifier: GPL-3.0-or-later
"""The shader against the core: its inner values, and pictures, pixel by pixel."""

from .comparison import (
    MOST_RADIANCE_ERROR,
    Comparison,
    compare,
    predict,
)
from .diagnostics import (
    CONE,
    COUNT,
    DIFFUSE,
    EXPONENT,
    GLOSSY,
    IRRADIANCE,
    LOBE,
    MEAN_COUNT,
    MEAN_RADIANCE,
    NORMAL,
    PIXEL,
    POSITION,
    RADIANCE,
    RASTER,
    RETURNED,
    ROUGHNESS,
    SOUND,
    SPARKLES,
    TEXTURE,
    VIEW,
)
from .probe import (
    Geometry,
    Probe,
    make_noiseless,
    render,
    render_channels,
    write_floats,
)

__all__ = [
    "CONE", "COUNT", "DIFFUSE", "EXPONENT", "GLOSSY", "IRRADIANCE", "LOBE", "MEAN_COUNT",
    "MEAN_RADIANCE", "MOST_RADIANCE_ERROR", "NORMAL", "PIXEL", "POSITION", "RADIANCE", "RASTER",
    "RETURNED", "ROUGHNESS", "SOUND", "SPARKLES", "TEXTURE", "VIEW", "Comparison", "Geometry",
    "Probe", "compare", "make_noiseless", "predict", "render", "render_channels", "write_floats",
]  # fmt: skip
