# SPDX-License-Identifier: Apache-2.0
"""The shader's random integers against the core's, bit by bit."""

from __future__ import annotations

from pathlib import Path

import bpy
import metallic_paint_core as core
import numpy as np
from common import bars
from metallic_paint import verify
from metallic_paint.paint import material, shader

SIZE = 1024  # pixels along each side: 2^20 points a stream
# Stride and offset of the points, then light, species, frame, seed and draw: near the origin on
# both sides of zero; over the whole range of int, wrapping; at its ends.
STREAMS = (
    (1, -512, 0, 0, 0, 0, 0),
    (7368787, -1234567891, 7, 2, -3, 123456789, 16),
    (1, 2147483135, 3, 1, 2147483647, -2147483648, 5),
)


def check(label: str) -> bars.Bar:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    node = _build(scene)
    equal = total = 0
    for stride, offset, light, species, frame, seed, draw in STREAMS:
        names = ("Stride", "Offset", "Light", "Species", "Frame", "Seed", "Draw")
        values = (stride, offset, light, species, frame, seed, draw)
        for name, value in zip(names, values, strict=True):
            node.inputs[name].default_value = value
        halves = []
        for part in range(3):
            node.inputs["Part"].default_value = part
            halves.append(verify.render(scene))
        halves = np.concatenate(halves, axis=-1)[..., :8].astype(np.uint32)
        words = halves[..., 0::2] | halves[..., 1::2] << 16
        y, x = (np.mgrid[0:SIZE, 0:SIZE] * stride + offset).astype(np.uint32).astype(np.int32)
        expected = core.hash_words(
            x.ravel(), y.ravel(), light=light, species=species, frame=frame, seed=seed, draw=draw
        )
        equal += int((words.reshape(-1, 4) == expected).all(axis=1).sum())
        total += len(expected)
    return bars.at_least(
        f"{label}, hash: points of {total} with the same 128 bits", equal, total, "points"
    )


def _build(scene: bpy.types.Scene) -> bpy.types.Node:
    """A square that fills the picture and emits the hash."""
    material.set_up_cycles(scene)
    verify.make_noiseless(scene)
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    bpy.ops.mesh.primitive_plane_add(size=4)
    painted = bpy.data.materials.new("Hash")
    if painted.node_tree is None:
        painted.use_nodes = True
    nodes, links = painted.node_tree.nodes, painted.node_tree.links
    nodes.clear()
    text = bpy.data.texts.new("hash_probe.osl")
    text.write(shader.flatten(Path(__file__).with_name("hash_probe.osl")))
    script = nodes.new("ShaderNodeScript")
    shader.compile_into(script, text)
    emission, out = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    links.new(script.outputs[0], emission.inputs["Color"])
    links.new(emission.outputs[0], out.inputs["Surface"])
    material.assign(bpy.context.object, painted)
    data = bpy.data.cameras.new("Camera")
    data.type, data.ortho_scale = "ORTHO", 2
    scene.camera = bpy.data.objects.new("Camera", data)
    scene.camera.location.z = 1
    scene.collection.objects.link(scene.camera)
    return script
