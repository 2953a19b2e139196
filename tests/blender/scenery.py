# SPDX-License-Identifier: Apache-2.0
"""What the tests' scenes are made of."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np

WIDTH, HEIGHT = 2048, 1024  # of a world's image, in pixels


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


def nest_paint(painted: bpy.types.Material) -> None:
    """Puts the material's paint into a node group of the artist's."""
    tree = painted.node_tree
    [paint] = [node for node in tree.nodes if node.type == "GROUP"]
    outer = bpy.data.node_groups.new("Mine", "ShaderNodeTree")
    outer.interface.new_socket("Surface", in_out="OUTPUT", socket_type="NodeSocketShader")
    inner = outer.nodes.new("ShaderNodeGroup")
    inner.node_tree = paint.node_tree
    outer.links.new(inner.outputs[0], outer.nodes.new("NodeGroupOutput").inputs[0])
    paint.node_tree = outer
    tree.links.new(paint.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])


def link_paint(thing: bpy.types.Object, file: Path) -> bpy.types.Material:
    """Gives the thing its material again, linked from the new file; the file's own paints go."""
    bpy.data.libraries.write(str(file), {thing.active_material})
    name = thing.active_material.name
    for each in (*bpy.data.materials, *bpy.data.node_groups):
        bpy.data.batch_remove([each])
    with bpy.data.libraries.load(str(file), link=True) as (_, here):
        here.materials = [name]
    thing.active_material = here.materials[0]
    return here.materials[0]


def override_paint(thing: bpy.types.Object, file: Path) -> bpy.types.Material:
    """Gives the thing a library override of its material, which the new file then has."""
    thing.active_material = overridden = link_paint(thing, file).override_create()
    return overridden


def link_namesake(thing: bpy.types.Object, file: Path) -> bpy.types.Object:
    """Into the scene: the thing as it is now, linked from the new file."""
    bpy.data.libraries.write(str(file), {thing})
    with bpy.data.libraries.load(str(file), link=True) as (there, here):
        here.objects = there.objects
    [linked] = here.objects
    bpy.context.scene.collection.objects.link(linked)
    assert linked.name == thing.name
    return linked


def elevations() -> np.ndarray:
    """Of the image's rows, lowest first, (HEIGHT, 1)."""
    return math.pi * ((np.arange(HEIGHT) + 0.5) / HEIGHT - 0.5)[:, None]


def directions() -> np.ndarray:
    """Of the image's pixels, lowest row first."""
    up = elevations()
    turn = -2 * math.pi * ((np.arange(WIDTH) + 0.5) / WIDTH - 0.5)[None, :]
    return np.stack(
        [np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up) + 0 * turn], -1
    )


def solid_angles() -> np.ndarray:
    """Of the pixels of each row, (HEIGHT, 1)."""
    return 2 * math.pi / WIDTH * math.pi / HEIGHT * np.cos(elevations())


def disc(towards: np.ndarray, radius: float, sun: float, rest: float | np.ndarray) -> np.ndarray:
    near = directions() @ (towards / np.linalg.norm(towards)) > math.cos(radius)
    return np.where(near, sun, rest).astype(np.float32)


def world_of(light: np.ndarray) -> bpy.types.ShaderNodeTexEnvironment:
    world = bpy.data.worlds.new("World")
    if world.node_tree is None:
        world.use_nodes = True
    bpy.context.scene.world = world
    tree = world.node_tree
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    image = bpy.data.images.new("Sky", WIDTH, HEIGHT, float_buffer=True)
    pixels = np.ones((HEIGHT, WIDTH, 4), np.float32)
    pixels[..., :3] = light[..., None]
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    node.image = image
    tree.links.new(node.outputs[0], tree.nodes["Background"].inputs["Color"])
    return node
