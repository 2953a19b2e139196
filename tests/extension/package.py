# SPDX-License-Identifier: Apache-2.0
"""The extension as Blender names it once it is installed."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

NAME = "bl_ext.user_default.metallic_paint"
Addon = Callable[[str], ModuleType]  # the fixture addon
