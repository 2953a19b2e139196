# SPDX-License-Identifier: GPL-3.0-or-later
"""A paint: its parameters, files of them, and the material that shows it."""

from .parameters import (
    BINDER,
    COATINGS,
    FLAKES,
    INT_MAX,
    INT_MIN,
    LIGHTS,
    NO_FLAKES,
    PANELS,
    PARAMETERS,
    SECOND,
    SPARKLE,
    SUBSTRATE,
    THIRD,
    Color,
    Flakes,
    Paint,
    PaintError,
    Parameter,
    core_paint,
    shader_value,
    value_of,
)

__all__ = [
    "BINDER", "COATINGS", "FLAKES", "INT_MAX", "INT_MIN", "LIGHTS", "NO_FLAKES", "PANELS",
    "PARAMETERS", "SECOND", "SPARKLE", "SUBSTRATE", "THIRD", "Color", "Flakes", "Paint",
    "PaintError", "Parameter", "core_paint", "shader_value", "value_of",
]  # fmt: skip
