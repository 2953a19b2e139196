# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on knows of a parameter; the parameters themselves are in table.py."""

from __future__ import annotations

from dataclasses import dataclass

Color = tuple[float, float, float]


@dataclass(frozen=True)
class Parameter:
    """How one field of a paint is named, bounded and explained: see parameters.toml."""

    shader: str  # the shader's name of it
    label: str
    panel: str
    minimum: float
    maximum: float
    description: str
    choices: tuple[str, ...] = ()  # words whose positions are the shader's integers
    unit: str = ""  # as it stands behind the range
    subtype: str = "NONE"  # of Blender's socket
    is_color: bool = False  # chosen as a colour, and so in 0..1
    useful: tuple[float, float] | None = None  # where a slider ends; one may type what lies beyond

    @property
    def slider(self) -> tuple[float, float]:
        return self.useful or (self.minimum, self.maximum)
