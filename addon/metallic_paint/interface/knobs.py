# SPDX-License-Identifier: GPL-3.0-or-later
"""The paint's values as an artist thinks of them: words for choices, the tint as a colour.

These properties are stored nowhere: they read and set the node's sockets, or their live values.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import bpy

from ..paint import PARAMETERS, Parameter, live, parameters

TINT = "metallic_paint_tint"
_ABSORPTION = PARAMETERS["binder_absorption_per_mm"].label
_THICKNESS = PARAMETERS["layer_thickness_um"].label
_DARKEST = 1 / (255 * 12.92)  # of a colour's field in linear light: the first step of sRGB's 8 bits

_AS_WRITTEN = {
    "Ggx": "GGX", "Tio2": "TiO2", "Fe2o3": "Fe2O3", " On ": " on ", "Thin Silica": "Thin Silica",
}  # fmt: skip

# By the names of the properties of group nodes that give a paint's numbers their words.
CHOICES = {
    f"metallic_paint_{name.replace('.', '_')}": parameter
    for name, parameter in PARAMETERS.items()
    if parameter.choices
}
_CHOICE_OF = {parameter.label: name for name, parameter in CHOICES.items()}


def _socket(node: bpy.types.ShaderNodeGroup, label: str) -> bpy.types.NodeSocket | None:
    return node.inputs.get(label)


def _choice(parameter: Parameter) -> object:
    def get(node: bpy.types.ShaderNodeGroup) -> int:
        socket = _socket(node, parameter.label)
        return min(max(socket.default_value, 0), len(parameter.choices) - 1) if socket else 0

    def set_(node: bpy.types.ShaderNodeGroup, number: int) -> None:
        node.inputs[parameter.label].default_value = number

    return bpy.props.EnumProperty(
        name=parameter.label,
        description=parameter.description,
        items=[(word, _title(word), "", number) for number, word in enumerate(parameter.choices)],
        get=get,
        set=set_,
        options=set(),  # no animation: keys belong on the socket
    )


def _title(word: str) -> str:
    title = word.replace("-", " ").title()
    for written, as_chemists in _AS_WRITTEN.items():
        title = title.replace(written, as_chemists)
    return title


def _thickness_mm(node: bpy.types.ShaderNodeGroup) -> float:
    """0 where a link decides it."""
    socket = _socket(node, _THICKNESS)
    return 0.0 if socket is None or live.is_linked(socket) else live.value(socket) / 1000


def _tint(node: bpy.types.ShaderNodeGroup) -> list[float]:
    """What light keeps that passes the layer once, straight through (Beer and Lambert)."""
    absorption = _socket(node, _ABSORPTION)
    thickness = _thickness_mm(node)
    if absorption is None:
        return [1.0, 1.0, 1.0]
    return [math.exp(-per_mm * thickness) for per_mm in live.value(absorption)]


def _set_tint(node: bpy.types.ShaderNodeGroup, color: Sequence[float]) -> None:
    """exp(-absorption thickness) = color."""
    absorption, thickness = _socket(node, _ABSORPTION), _thickness_mm(node)
    if absorption is None or thickness <= 0:
        return
    most = PARAMETERS["binder_absorption_per_mm"].maximum
    per_mm = (min(-math.log(min(max(share, _DARKEST), 1)) / thickness, most) for share in color)
    live.set_value(absorption, tuple(per_mm))


def coverage(node: bpy.types.ShaderNodeGroup) -> float | None:
    """Area of all flakes by that of the surface; None where a link decides it."""
    total = 0.0
    for prefix in ("", "second.", "third."):
        names = ("flakes_per_mm2", "flake_diameter_um", "flake_area_spread")
        found = (_socket(node, PARAMETERS[f"{prefix}{name}"].label) for name in names)
        sockets = [socket for socket in found if socket is not None]
        if len(sockets) < len(names):  # of an older version
            continue
        if any(map(live.is_linked, sockets)):
            return None
        total += parameters.coverage(*map(live.value, sockets))
    return total


def in_words(covered: float) -> str:
    """A mean of so many flakes above each point: Poisson leaves exp(-covered) of the surface bare.

    Of the flakes, about half as many lie above another: one in twenty of the sparse ones.
    """
    if covered == 0:
        return "No flakes"
    share = -math.expm1(-covered)
    of_surface = f"{share:.0%} of the surface" if share >= 0.01 else "under 1% of the surface"
    if covered < 0.1:
        return f"Sparse: flakes cover {of_surface}"
    if covered < 1:
        return f"Medium: flakes cover {of_surface}"
    return f"Dense: flakes overlap and cover {of_surface}"


def draw_socket(
    layout: bpy.types.UILayout, node: bpy.types.ShaderNodeGroup, label: str, text: str = ""
) -> None:
    """The node's value, by its word if it is a choice; nothing where the node lacks it."""
    socket = _socket(node, label)
    if socket is None or not hasattr(socket, "default_value") or socket.hide_value:
        return
    row = layout.row()
    row.enabled = node.id_data.is_editable and live.can_be_set(socket)
    where: Any = socket
    which = "default_value"
    if (place := live.place_of(socket)) is not None:
        where, which = place[0], f'["{place[1]}"]'
    if label in _CHOICE_OF:
        _draw_choice(row, node, _CHOICE_OF[label], text or label)
    elif socket.type == "VECTOR":
        row.column(align=True).prop(where, which, text=text or label)
    else:
        row.prop(where, which, text=text or label)


def _draw_choice(
    row: bpy.types.UILayout, node: bpy.types.ShaderNodeGroup, choice: str, text: str
) -> None:
    if row.use_property_split:
        row.prop(node, choice, text=text)
    else:  # in a narrow panel Blender would cut the label: it gets as much as its letters need
        split = row.split(factor=0.1 + 0.03 * len(text))
        split.label(text=f"{text}:")
        split.prop(node, choice, text="")


def draw_first(layout: bpy.types.UILayout, node: bpy.types.ShaderNodeGroup) -> str:
    """What an artist changes first; returns the amount in words, for who draws lines."""
    coating = _socket(node, PARAMETERS["coating"].label)
    draw_socket(layout, node, PARAMETERS["coating"].label, "Flakes")
    if coating is not None and coating.default_value == 0:
        draw_socket(layout, node, PARAMETERS["flake_color"].label, "Color")
    elif coating is not None and _is_film(coating.default_value):
        draw_socket(layout, node, PARAMETERS["coating_nm"].label, "Film (nm)")
    draw_socket(layout, node, PARAMETERS["flake_diameter_um"].label, "Size (µm)")
    draw_socket(layout, node, PARAMETERS["flakes_per_mm2"].label, "Per mm²")
    draw_socket(layout, node, PARAMETERS["sparkle_contrast"].label, "Sparkle")
    absorption = _socket(node, _ABSORPTION)
    if absorption is not None and _thickness_mm(node) > 0:
        row = layout.row()
        row.enabled = node.id_data.is_editable and live.can_be_set(absorption)
        row.prop(node, TINT, text="Lacquer")
    draw_socket(layout, node, PARAMETERS["coat_roughness"].label, "Roughness")
    covered = coverage(node)
    return "" if covered is None else f"{in_words(covered)}."


def _is_film(number: int) -> bool:
    """A pearl pigment, whose colour comes from its film's thickness."""
    words = PARAMETERS["coating"].choices
    return "-on-" in words[min(max(number, 0), len(words) - 1)]


def labels_of(node: bpy.types.ShaderNodeGroup, panel: str) -> list[str]:
    """The sockets of a panel of the node, in its order."""
    if node.node_tree is None:
        return []
    return [
        item.name
        for item in node.node_tree.interface.items_tree
        if isinstance(item, bpy.types.NodeTreeInterfaceSocket)
        and item.in_out == "INPUT"
        and item.parent.name == panel
    ]


def draw_panel(layout: bpy.types.UILayout, node: bpy.types.ShaderNodeGroup, panel: str) -> None:
    """All values of a panel of the node, without the number that its name gives the species."""
    for label in labels_of(node, panel):
        draw_socket(layout, node, label, label.removesuffix(" 2").removesuffix(" 3"))


def register() -> None:
    for name, parameter in CHOICES.items():
        setattr(bpy.types.ShaderNodeGroup, name, _choice(parameter))
    setattr(bpy.types.ShaderNodeGroup, TINT, _tint_property())


def _tint_property() -> object:
    return bpy.props.FloatVectorProperty(  # type: ignore[func-returns-value]
        name="Lacquer",
        description="The lacquer's tint: what is left of white light that went once through the "
        "layer. Sets Absorption for the present Layer Thickness; a thicker layer is darker",
        subtype="COLOR",
        size=3,
        min=0,
        max=1,
        get=_tint,
        set=_set_tint,
        options=set(),  # no animation: keys belong on the socket
    )


def unregister() -> None:
    for name in (*CHOICES, TINT):
        delattr(bpy.types.ShaderNodeGroup, name)
