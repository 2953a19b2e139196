# SPDX-License-Identifier: Apache-2.0
"""The contenders: what an artist has instead of this paint, as dense and as tilted as it is."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
from metallic_paint.paint import Paint, shader
from motion.scenes import cone, voronoi

FLAKES = Path(__file__).with_name("flakes.osl")


def principled() -> bpy.types.Material:
    """A smooth metal under a clear coat."""
    made = bpy.data.materials.new("Principled")
    if made.node_tree is None:
        made.use_nodes = True  # Blender 4.5
    node = made.node_tree.nodes["Principled BSDF"]
    node.inputs["Metallic"].default_value = 1
    node.inputs["Roughness"].default_value = 0.3
    node.inputs["Coat Weight"].default_value = 1
    return made


def coated_voronoi(paint: Paint) -> bpy.types.Material:
    """The flakes of nodes that ./paint motion films, under a clear coat, as the paint's are."""
    made = voronoi(paint)
    made.node_tree.nodes["Principled BSDF"].inputs["Coat Weight"].default_value = 1
    return made


def noise_flakes(paint: Paint) -> bpy.types.Material:
    """flakes.osl with the paint's number of flakes.

    A plane cuts the balls whose centres lie within their radius: 2 r p/s^2 flakes in an area, r in
    cells, p the presence, s the cell's size.
    """
    made = bpy.data.materials.new("Flakes of a cell noise")
    if made.node_tree is None:
        made.use_nodes = True  # Blender 4.5
    nodes = made.node_tree.nodes
    script = nodes.new("ShaderNodeScript")
    text = bpy.data.texts.new(FLAKES.name)
    text.write(FLAKES.read_text(encoding="utf-8"))
    shader.compile_into(script, text)
    r, p = (script.inputs[name].default_value for name in ("Radius", "Presence"))
    script.inputs["CellSize"].default_value = math.sqrt(2 * r * p / (paint.flakes_per_mm2 * 1e6))
    script.inputs["Tilt"].default_value = paint.binder_ior * paint.tilt
    script.inputs["Spread"].default_value = paint.binder_ior * cone(paint)
    script.inputs["CoatIor"].default_value = paint.binder_ior
    made.node_tree.links.new(script.outputs["BSDF"], nodes["Material Output"].inputs["Surface"])
    return made
