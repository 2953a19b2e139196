# SPDX-License-Identifier: Apache-2.0
"""What a small shader with headers of osl/ computes in Blender, as a picture."""

from __future__ import annotations

from pathlib import Path

import bpy
from metallic_paint import verify
from metallic_paint.paint import shader


def plane_that_shows(
    source: str, size: int, folder: Path
) -> tuple[bpy.types.Scene, bpy.types.ShaderNodeScript]:
    """A plane that fills the picture of size x size and shows the shader's output Shown."""
    scene = bpy.context.scene
    verify.make_noiseless(scene)
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True
    scene.render.resolution_x = scene.render.resolution_y = size
    bpy.ops.mesh.primitive_plane_add(size=4)
    plane = bpy.context.object
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (0, 0, 1)
    scene.collection.objects.link(camera)
    scene.camera = camera

    file = folder / "probe.osl"
    file.write_text(source)
    text = bpy.data.texts.new("probe.osl")
    text.write(shader.flatten(file))
    material = bpy.data.materials.new("Probe")
    if material.node_tree is None:
        material.use_nodes = True  # Blender 4.5
    tree = material.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeScript")
    emission = tree.nodes.new("ShaderNodeEmission")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    shader.compile_into(node, text)
    tree.links.new(node.outputs["Shown"], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    plane.data.materials.append(material)
    return scene, node
