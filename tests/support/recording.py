# SPDX-License-Identifier: Apache-2.0
"""A layout that records what a draw function asks for, and refuses what Blender would refuse.

Blender's module has no window, so no interface is drawn for real here: operators, properties, menus
and icons are checked against Blender's own lists instead.
"""

from __future__ import annotations

from types import SimpleNamespace

import bpy

ICONS = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items.keys()


class Layout:
    def __init__(self) -> None:
        self.use_property_split = False
        self.texts: list[str] = []
        self.operators: list[tuple[str, dict[str, object]]] = []
        self.menus: list[str] = []
        self.properties: list[str] = []
        self.icon_views: list[str] = []
        self.labels: list[str] = []  # of the properties

    def column(self, align: bool = False) -> Layout:
        return self

    box = row = column

    def split(self, factor: float) -> Layout:
        assert 0 < factor < 1
        return self

    def separator(self) -> None:
        pass

    def label(self, text: str = "", icon: str = "NONE") -> None:
        assert icon in ICONS, icon
        self.texts.append(text)

    def menu(self, name: str, text: str = "", icon: str = "NONE") -> None:
        assert icon in ICONS, icon
        assert issubclass(getattr(bpy.types, name), bpy.types.Menu)
        self.menus.append(name)

    def operator(
        self,
        name: str,
        text: str = "",
        icon: str = "NONE",
        icon_value: int = 0,
        depress: bool = False,
    ) -> SimpleNamespace:
        assert icon in ICONS, icon
        space, _, function = name.partition(".")
        known = getattr(getattr(bpy.ops, space), function).get_rna_type().properties.keys()
        values: dict[str, object] = {}
        self.operators.append((name, values))
        self.texts.append(text)

        class Properties:
            def __setattr__(self, key: str, value: object) -> None:
                assert key in known, key
                values[key] = value

        return Properties()

    def prop(self, data: object, name: str, text: str = "") -> None:
        if name.startswith("["):  # a property of the datablock's own
            data.path_resolve(name)
        else:
            assert name in data.bl_rna.properties, name
        self.properties.append(name)
        self.labels.append(text)

    def template_icon_view(
        self, data: object, name: str, show_labels: bool, scale: float, scale_popup: float
    ) -> None:
        assert name in data.bl_rna.properties, name
        assert isinstance(show_labels, bool)
        assert min(scale, scale_popup) > 0
        self.icon_views.append(name)

    def progress(self, factor: float = 0.0, text: str = "") -> None:
        assert 0 <= factor <= 1
        self.texts.append(text)

    @property
    def names(self) -> list[str]:
        return [name for name, _ in self.operators]


def drawn(panel: type, context: object = None) -> Layout:
    """What a panel, menu or preferences' class draws in the context."""
    layout = Layout()
    label = getattr(panel, "bl_label", "")
    panel.draw(SimpleNamespace(layout=layout, bl_label=label), context or bpy.context)
    return layout
