# SPDX-License-Identifier: Apache-2.0
"""Renders one strip of ./paint manual to a JPEG."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import blender_env

blender_env.prepare()

import bpy  # noqa: E402
import gallery_scenes as scenes  # noqa: E402
import numpy as np  # noqa: E402
import render_scene  # noqa: E402
from gallery_pictures import Studio, write  # noqa: E402
from manual import NEAR_MM, STRIPS, Strip  # noqa: E402
from metallic_paint import material  # noqa: E402
from metallic_paint.paint import PARAMETERS, Paint, shader_value, value_of  # noqa: E402

PIXELS = 168  # along each side of a shot
SAMPLES = 16
NEAR_EXPOSURE = -3.5  # stops: flakes that mirror the sun are as bright as the picture allows
MOST_BYTES = 59_000  # of a strip


def shoot(strip: Strip) -> np.ndarray:
    """The shots side by side, (h, w, 3) of 8 bits."""
    studio = Studio(quick=False, names=())
    scene = studio.scene(PIXELS, PIXELS, SAMPLES, exposure=NEAR_EXPOSURE if strip.near else 0)
    scene.render.use_persistent_data = True  # the paint stays compiled
    ball = scenes.close_up(scene, NEAR_MM * 1e-3) if strip.near else scenes.small_swatch(scene)
    label = scenes.add_label(scene, "", plate=strip.near)
    paints = strip.paints()
    render_scene.paint_objects([ball], next(iter(paints.values())))
    varied = link_varied(ball.data.materials[0], list(paints.values()))
    shots = []
    for words, paint in paints.items():
        for name in varied:
            ball[name] = shader_value(PARAMETERS[name], value_of(paint, name))
        ball.update_tag()
        label.data.body = words
        shots.append(studio.shoot(scene, words))
    return np.concatenate(shots, axis=1)


def link_varied(painted: bpy.types.Material, paints: Sequence[Paint]) -> list[str]:
    """Feeds what differs between the paints from properties of the object, named as the fields."""
    varied = [name for name in PARAMETERS if len({value_of(paint, name) for paint in paints}) > 1]
    tree, node = painted.node_tree, material.paint_node(painted)
    for name in varied:
        source = tree.nodes.new("ShaderNodeAttribute")
        source.attribute_type, source.attribute_name = "OBJECT", name
        socket = node.inputs[PARAMETERS[name].label]
        kind = {"RGBA": "Color", "VECTOR": "Vector"}.get(socket.type, "Fac")
        tree.links.new(source.outputs[kind], socket)
    return varied


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("strip", choices=STRIPS)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    with render_scene.quiet():
        write(shoot(STRIPS[arguments.strip]), arguments.out, MOST_BYTES)


if __name__ == "__main__":
    render_scene.run(main)
