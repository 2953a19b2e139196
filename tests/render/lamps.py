# SPDX-License-Identifier: Apache-2.0
"""Lamps for the tests' scenes."""

from __future__ import annotations

from pathlib import Path

import bpy


def add_lamp(kind: str, name: str, **values: object) -> bpy.types.Object:
    """A lamp in the scene; the values are its data's, or else the object's."""
    lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, kind))
    bpy.context.scene.collection.objects.link(lamp)
    for key, value in values.items():
        setattr(lamp.data if hasattr(lamp.data, key) else lamp, key, value)
    return lamp


def link_namesake(lamp: bpy.types.Object, file: Path) -> bpy.types.Object:
    """Into the scene: the lamp as it is now, linked from the new file."""
    bpy.data.libraries.write(str(file), {lamp})
    with bpy.data.libraries.load(str(file), link=True) as (there, here):
        here.objects = there.objects
    [linked] = here.objects
    bpy.context.scene.collection.objects.link(linked)
    assert linked.name == lamp.name
    return linked
