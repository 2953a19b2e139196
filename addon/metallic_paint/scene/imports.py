# SPDX-License-Identifier: GPL-3.0-or-later
"""What an append brings along: a paint refers to the lamps of its file, and they stay behind.

Blender appends all that the drivers of the carrier look at, with parents and targets, and puts
these objects into the scene, which they would light. Paste tells nothing of why an object came, so
of pasted lamps only those go that stand where a lamp of this file stands already. The shader too
stays behind where this file has it.
"""

from __future__ import annotations

from collections.abc import Collection

import bpy
from bpy.app.handlers import persistent

from ..paint import material
from . import carrier, lights


@persistent
def _imported(context: bpy.types.BlendImportContext, *_: object) -> None:
    arrived = {item.id: item.import_info for item in context.import_items if item.id is not None}
    fed = [tree for tree in (*carrier.all_of_file(), *lights.groups()) if tree in arrived]
    sources = [each for tree in fed for each in carrier.sources_of(tree)]
    there = [lamp for lamp in lights.in_slots() if lamp not in arrived]
    for tree in fed:
        carrier.forget_lights(tree)
    unasked = [
        thing
        for thing, info in arrived.items()
        if isinstance(thing, (bpy.types.Object, bpy.types.Collection))
        and thing.library is None
        and ("INDIRECT_USAGE" in info or any(_is_twin(thing, lamp) for lamp in there))
    ]
    bpy.data.batch_remove(_unused(unasked, sources, {*arrived} - {*fed}))
    material.share(  # what was asked for by name, Blender goes on to use
        [
            thing
            for thing, info in arrived.items()
            if isinstance(thing, bpy.types.ShaderNodeTree) and "INDIRECT_USAGE" in info
        ]
    )


def _unused(
    unasked: Collection[bpy.types.ID],
    sources: Collection[bpy.types.Object],
    holders: Collection[bpy.types.ID],
) -> list[bpy.types.ID]:
    """Sources that none of the holders uses, and step by step what only these use."""
    users = {
        thing: {user for user in used if user in holders}
        for thing, used in bpy.data.user_map(subset=set(unasked)).items()
    }
    unused: list[bpy.types.ID] = []
    while more := [
        thing
        for thing in unasked
        if thing not in unused and users[thing] <= {*unused} and (thing in sources or users[thing])
    ]:
        unused += more
    return unused


def _is_twin(lamp: bpy.types.ID, other: bpy.types.Object) -> bool:
    if not isinstance(lamp, bpy.types.Object) or lamp.type != "LIGHT":
        return False
    one, two = lamp.data, other.data
    same = one.type == two.type and one.energy == two.energy and one.color == two.color
    return same and lamp.matrix_basis == other.matrix_basis  # the world's is not known yet


def register() -> None:
    bpy.app.handlers.blend_import_post.append(_imported)


def unregister() -> None:
    if _imported in bpy.app.handlers.blend_import_post:
        bpy.app.handlers.blend_import_post.remove(_imported)
