# SPDX-License-Identifier: GPL-3.0-or-later
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


@contextmanager
def registered(module: ModuleType) -> Iterator[None]:
    bpy.utils.register_class(MATERIAL_PT_metallic_paint)
    module.register()
    try:
        yield
    finally:
        module.unregister()
        bpy.utils.unregister_class(MATERIAL_PT_metallic_paint)


class Layout:
    """Takes what a panel draws, as text: headless Blender draws nothing."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def label(self, *, text: str = "", **_: object) -> None:
        self.texts.append(text)

    def operator(self, name: str, **_: object) -> object:
        category, _, operator = name.partition(".")
        getattr(getattr(bpy.ops, category), operator).get_rna_type()  # KeyError if there is none
        self.texts.append(name)
        return self

    def prop(self, owner: object, name: str, **_: object) -> None:
        getattr(owner, name)
        self.texts.append(name)

    def template_preview(self, *_: object, **__: object) -> None:
        pass

    def progress(self, *, text: str = "", **_: object) -> None:
        self.texts.append(text)

    def column(self, **_: object) -> Layout:
        return self

    row = box = column


def drawn(panel: type[bpy.types.Panel]) -> list[str]:
    """What the panel would show in the present context."""
    layout = Layout()
    stand_in = type("Drawn", (), {"layout": layout})()
    panel.draw(stand_in, bpy.context)
    return layout.texts
