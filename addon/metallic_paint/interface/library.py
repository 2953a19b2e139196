# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets as an asset library, which a button in the add-on's preferences makes known.

The list of libraries belongs to the user's preferences: only the buttons change it.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from .. import ADD_ON
from ..paint import shader

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

FOLDER = shader.LIBRARY.parent
NAME = "Metallic Paint"


def _known() -> bpy.types.UserAssetLibrary | None:
    libraries = bpy.context.preferences.filepaths.asset_libraries
    here = (each for each in libraries if each.path and Path(each.path).resolve() == FOLDER)
    return next(here, None)


class PREFERENCES_OT_metallic_paint_add_library(bpy.types.Operator):
    """Show the presets in the Asset Browser, as the library Metallic Paint"""

    bl_idname = "preferences.metallic_paint_add_library"
    bl_label = "Add Asset Library"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        if not FOLDER.is_dir():
            cls.poll_message_set("This build of the add-on comes without an asset library")
            return False
        if _known():
            cls.poll_message_set("The asset library is there already")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        libraries = context.preferences.filepaths.asset_libraries
        library = libraries.new(name=NAME, directory=str(FOLDER))
        if library.import_method == "PACK":  # Blender 5: linked, so not edited here
            library.import_method = "APPEND"
        context.preferences.is_dirty = True
        return {"FINISHED"}


class PREFERENCES_OT_metallic_paint_remove_library(bpy.types.Operator):
    """Remove the library Metallic Paint from the Asset Browser; materials in use stay"""

    bl_idname = "preferences.metallic_paint_remove_library"
    bl_label = "Remove Asset Library"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        if not _known():
            cls.poll_message_set("The asset library is not there")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[OperatorReturnItems]:
        context.preferences.filepaths.asset_libraries.remove(_known())
        context.preferences.is_dirty = True
        return {"FINISHED"}


class MetallicPaintPreferences(bpy.types.AddonPreferences):
    bl_idname = ADD_ON

    def draw(self, _context: bpy.types.Context) -> None:
        button: type[bpy.types.Operator] = PREFERENCES_OT_metallic_paint_add_library
        if _known():
            button = PREFERENCES_OT_metallic_paint_remove_library
        self.layout.operator(button.bl_idname, icon="ASSET_MANAGER")


register, unregister = bpy.utils.register_classes_factory(
    (
        PREFERENCES_OT_metallic_paint_add_library,
        PREFERENCES_OT_metallic_paint_remove_library,
        MetallicPaintPreferences,
    )
)
