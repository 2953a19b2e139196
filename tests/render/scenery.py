# SPDX-License-Identifier: Apache-2.0
"""What the tests' scenes are made of."""

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


def show_as_instance(thing: bpy.types.Object) -> bpy.types.Object:
    """Takes the thing out of the scene, where an empty shows it; returns the empty."""
    collection = bpy.data.collections.new("Instanced")
    collection.objects.link(thing)
    bpy.context.scene.collection.objects.unlink(thing)
    empty = bpy.data.objects.new("Instancer", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    bpy.context.scene.collection.objects.link(empty)
    return empty


def link_namesake(lamp: bpy.types.Object, file: Path) -> bpy.types.Object:
    """Into the scene: the lamp as it is now, linked from the new file."""
    bpy.data.libraries.write(str(file), {lamp})
    with bpy.data.libraries.load(str(file), link=True) as (there, here):
        here.objects = there.objects
    [linked] = here.objects
    bpy.context.scene.collection.objects.link(linked)
    assert linked.name == lamp.name
    return linked
