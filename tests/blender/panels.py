# SPDX-License-Identifier: Apache-2.0
"""Sub-panels need a parent: a module of the add-on registered alone, beneath an empty one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

import bpy


class MATERIAL_PT_metallic_paint(bpy.types.Panel):  # noqa: N801
    """Stands for the extension's own panel."""

    bl_label = "Metallic Paint"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"

    def draw(self, context: bpy.types.Context) -> None:
        pass


class MATERIAL_PT_metallic_paint_diagnostics(MATERIAL_PT_metallic_paint):  # noqa: N801
    pass


@contextmanager
def registered(module: ModuleType) -> Iterator[None]:
    bpy.utils.register_class(MATERIAL_PT_metallic_paint)
    bpy.utils.register_class(MATERIAL_PT_metallic_paint_diagnostics)
    module.register()
    try:
        yield
    finally:
        module.unregister()
        bpy.utils.unregister_class(MATERIAL_PT_metallic_paint_diagnostics)
        bpy.utils.unregister_class(MATERIAL_PT_metallic_paint)
