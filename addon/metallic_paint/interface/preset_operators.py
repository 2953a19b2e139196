# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets in the interface: a grid and a menu of swatches, applying, loading and saving.

Own presets are the files in the add-on's folder of the user; a file from elsewhere is loaded, or
put there. A swatch is a picture beside the presets that ship; without it the entry is mere text.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import unicodedata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
import bpy.utils.previews
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from .. import ADD_ON
from ..paint import PARAMETERS, Paint, PaintError, animation, live, material, presets
from . import operators

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

SWATCHES = Path(__file__).parent.parent / "swatches"

_MOST_LETTERS = 48  # of four bytes at most, so that a file may have the name

CHOSEN = "metallic_paint_preset"  # the property of group nodes that the grid of swatches sets

# Of the grid, as Blender draws it: swatches in a row, pixels of one at the scale 1, and around all.
_IN_A_ROW, _POPUP_UNIT, _POPUP_MARGIN = 8, 21, 40
_LARGEST, _LABELLED = 6.0, 5.3  # scales; from the second on the longest name is not cut

_previews: list[bpy.utils.previews.ImagePreviewCollection] = []  # one while registered


def own_folder(create: bool = False) -> Path:
    """Where the user's presets are; it outlives an update of the add-on."""
    if ADD_ON.startswith("bl_ext."):
        folder = bpy.utils.extension_path_user(ADD_ON, path="presets", create=create)
    else:  # run from the repository
        path = f"{ADD_ON}/presets"
        folder = bpy.utils.user_resource("CONFIG", path=path, create=create)
    return Path(folder)


def own() -> list[Path]:
    return sorted(own_folder().glob("*.json"))


def own_file(context: bpy.types.Context) -> Path:
    """Where the paint is saved unless one says otherwise: named after its material, and new."""
    owner = operators.active_material(context)
    letters = unicodedata.normalize("NFC", owner.name.lower())[:_MOST_LETTERS]
    name = "".join(each if each.isalnum() or each == "_" else "-" for each in letters)
    folder = own_folder(create=True)
    numbered = (f"{name}-{i}" if i > 1 else name for i in itertools.count(1))
    return next(path for each in numbered if not (path := folder / f"{each}.json").exists())


def swatch(name: str) -> int:
    """The number of the preset's icon, or 0, which is none."""
    file = SWATCHES / f"{name}.jpg"
    if not _previews or not file.is_file():
        return 0
    pictures = _previews[0]
    if name not in pictures:
        pictures.load(name, str(file), "IMAGE")
    return pictures[name].icon_id


@functools.cache
def _shipped() -> dict[str, Paint]:
    return {name: presets.load(name) for name in presets.names()}


@functools.cache  # Blender keeps no strings of its own
def _items() -> list[Any]:  # the stubs know icons by their names alone
    """The presets, and the values as they are, which is no choice.

    Blender shows eight in a row: the last row, below which a low window ends, has these alone.
    """
    names = enumerate(_shipped(), 1)
    choices = [(name, operators.title(name), "", swatch(name), number) for number, name in names]
    return [*choices, ("own", "Own Values", "What the paint is now", "MATERIAL", 0)]


def _chosen(node: bpy.types.ShaderNodeGroup) -> int:
    """The preset whose values the paint has."""
    try:
        paint = material.paint_of(node)
    except PaintError:
        return 0
    return next((i for i, each in enumerate(_shipped().values(), 1) if each == paint), 0)


def _choose(node: bpy.types.ShaderNodeGroup, number: int) -> None:
    if number:
        # One of an older version stays: the panel offers to update it.
        with contextlib.suppress(PaintError):
            material.apply(node, list(_shipped().values())[number - 1])


def draw_swatches(layout: bpy.types.UILayout, node: bpy.types.ShaderNodeGroup) -> None:
    """The swatch of the paint's preset; a click on it opens the grid of all."""
    if not SWATCHES.is_dir():
        return
    column = layout.column()
    column.enabled = node.id_data.is_editable
    if _chosen(node) == 0:
        column.label(text="Click to choose a paint:")  # there is no picture of it
    popup = _popup_scale()
    has_room = popup >= _LABELLED
    column.template_icon_view(node, CHOSEN, show_labels=has_room, scale=5, scale_popup=popup)


def _popup_scale() -> float:
    """As large as the window is wide enough for."""
    window = bpy.context.window
    if window is None or bpy.app.background:
        return _LARGEST
    width = window.width / bpy.context.preferences.system.ui_scale
    return min(max((width - _POPUP_MARGIN) / (_IN_A_ROW * _POPUP_UNIT), 1), _LARGEST)


def _apply(
    operator: bpy.types.Operator, context: bpy.types.Context, name_or_path: str
) -> set[OperatorReturnItems]:
    node = operators.paint_node(context)
    tree = node.id_data
    try:
        material.apply(node, presets.load(name_or_path))
    except (presets.PresetError, PaintError) as error:
        operator.report({"ERROR"}, str(error))
        return {"CANCELLED"}
    given = {socket.name for curve, socket, _ in animation.of_inputs(tree, node) if not curve.mute}
    given |= {
        link.to_socket.name
        for link in tree.links
        if link.to_node == node and not link.is_muted and live.is_linked(link.to_socket)
    }
    given |= {*live.animated(node)}
    kept = [each.label for each in PARAMETERS.values() if each.label in given]
    if kept:
        operator.report({"WARNING"}, f"Linked or animated, not the preset's: {', '.join(kept)}.")
    return {"FINISHED"}


class MATERIAL_OT_metallic_paint_apply_preset(operators.ChangesPaint):
    """Give the active material's paint the values of this preset"""

    bl_idname = "material.metallic_paint_apply_preset"
    bl_label = "Apply Preset"
    bl_options = {"REGISTER", "UNDO"}

    preset: StringProperty(name="Preset", description="Name or file of a preset")

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        return _apply(self, context, self.preset)


# The stubs have check and invoke of these helpers return nothing.
class MATERIAL_OT_metallic_paint_load_preset(  # type: ignore[misc]
    operators.ChangesPaint, ImportHelper
):
    """Give the active material's paint the values of a preset's file"""

    bl_idname = "material.metallic_paint_load_preset"
    bl_label = "Load Preset"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})

    def invoke(  # type: ignore[override]
        self, context: bpy.types.Context, event: bpy.types.Event
    ) -> set[OperatorReturnItems]:
        self.filepath = f"{own_folder(create=True)}/"
        return super().invoke(context, event)

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        return _apply(self, context, bpy.path.abspath(self.filepath))


class MATERIAL_OT_metallic_paint_save_preset(  # type: ignore[misc]
    bpy.types.Operator, ExportHelper
):
    """Save the active material's paint as a preset: in the folder of own presets, where the menu \
finds it, or elsewhere, to share it"""

    bl_idname = "material.metallic_paint_save_preset"
    bl_label = "Save Preset"
    bl_options = {"REGISTER"}

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})
    description: StringProperty(name="Description", description="What the paint is, in a sentence")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return operators.on_paint(cls, context)

    def invoke(  # type: ignore[override]
        self, context: bpy.types.Context, event: bpy.types.Event
    ) -> set[OperatorReturnItems]:
        self.filepath = str(own_file(context))
        return super().invoke(context, event)

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        path = bpy.path.abspath(self.filepath)
        if not path:
            self.report({"ERROR"}, "The file to save the preset in has no name.")
            return {"CANCELLED"}
        try:
            presets.save(material.paint_of(operators.paint_node(context)), path, self.description)
        except (presets.PresetError, PaintError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except OSError as error:
            self.report({"ERROR"}, f"{path} cannot be written: {error.strerror}.")
            return {"CANCELLED"}
        self.report({"INFO"}, f"Saved {path}.")
        return {"FINISHED"}


class MATERIAL_MT_metallic_paint_presets(bpy.types.Menu):
    bl_label = "Presets"

    def draw(self, context: bpy.types.Context) -> None:
        """Applies to the material's paint; where there is none, a new paint of the preset."""
        layout = self.layout
        painted = operators.paint_node(context) is not None
        chosen = MATERIAL_OT_metallic_paint_apply_preset if painted else (
            operators.MATERIAL_OT_metallic_paint_new
        )  # fmt: skip
        for name in presets.names():
            text = operators.title(name)
            icon = swatch(name)
            layout.operator(chosen.bl_idname, text=text, icon_value=icon).preset = name
        if mine := own():
            layout.separator()
        for path in mine:
            text = operators.title(path.name)
            layout.operator(chosen.bl_idname, text=text, icon="FILE").preset = str(path)
        layout.separator()
        for of_files in (
            MATERIAL_OT_metallic_paint_load_preset,
            MATERIAL_OT_metallic_paint_save_preset,
        ):
            layout.operator(of_files.bl_idname, text=f"{of_files.bl_label}…")


_CLASSES = (
    MATERIAL_OT_metallic_paint_apply_preset,
    MATERIAL_OT_metallic_paint_load_preset,
    MATERIAL_OT_metallic_paint_save_preset,
    MATERIAL_MT_metallic_paint_presets,
)


def register() -> None:
    for each in _CLASSES:
        bpy.utils.register_class(each)
    _previews.append(bpy.utils.previews.new())
    swatches = bpy.props.EnumProperty(
        name="Preset",
        description="Give the paint the values of a preset",
        items=lambda _node, _context: _items(),
        get=_chosen,
        set=_choose,
        options=set(),  # no animation: keys belong on the sockets
    )
    setattr(bpy.types.ShaderNodeGroup, CHOSEN, swatches)


def unregister() -> None:
    delattr(bpy.types.ShaderNodeGroup, CHOSEN)
    _items.cache_clear()  # its icons go
    bpy.utils.previews.remove(_previews.pop())
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
