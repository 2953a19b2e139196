# SPDX-License-Identifier: Apache-2.0
"""Renders one strip of ./paint manual to a JPEG."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from common import blender_env

blender_env.prepare()

import bpy  # noqa: E402
import numpy as np  # noqa: E402
from metallic_paint.paint import material  # noqa: E402

from pictures import gallery_scenes as scenes  # noqa: E402
from pictures import render_scene  # noqa: E402
from pictures.gallery_pictures import Photographer, write  # noqa: E402
from pictures.manual import BESIDE, NEAR_MM, STRIPS, Strip  # noqa: E402

PIXELS = 168  # along each side of a shot
SAMPLES = 16
NEAR_EXPOSURE = -3.5  # stops: flakes that mirror the sun are as bright as the picture allows
MOST_BYTES = 59_000  # of a strip


def shoot(strip: Strip) -> np.ndarray:
    """The shots side by side, (h, w, 3) of 8 bits."""
    photographer = Photographer(quick=False, names=(), as_photographs=False)
    scene = photographer.scene(PIXELS, PIXELS, SAMPLES, exposure=NEAR_EXPOSURE if strip.near else 0)
    scene.render.use_persistent_data = True  # the paint stays compiled
    ball = scenes.close_up(scene, NEAR_MM * 1e-3) if strip.near else scenes.small_swatch(scene)
    label = scenes.add_label(scene, "", plate=strip.near)
    render_scene.paint_objects([ball], next(iter(strip.paints().values())))
    shots = strip.sockets()
    varied = link_varied(ball.data.materials[0], list(shots.values()))
    pictures = []
    for words, values in shots.items():
        for name in varied:
            ball[name] = values[name]
        ball.update_tag()
        label.data.body = words
        pictures.append(photographer.shoot(scene, words))
    return np.concatenate(pictures, axis=1)


def link_varied(painted: bpy.types.Material, shots: Sequence[dict[str, Any]]) -> list[str]:
    """Feeds the sockets whose value some shot changes from properties of the object, by label."""
    own = shots[0] | BESIDE
    varied = [name for name in own if any(shot[name] != own[name] for shot in shots)]
    tree, node = painted.node_tree, material.paint_node(painted)
    for name in varied:
        source = tree.nodes.new("ShaderNodeAttribute")
        source.attribute_type, source.attribute_name = "OBJECT", name
        socket = node.inputs[name]
        if name in (material.NORMAL, material.COAT_NORMAL):
            socket = add_bump(tree, socket)
        kind = {"RGBA": "Color", "VECTOR": "Vector"}.get(socket.type, "Fac")
        tree.links.new(source.outputs[kind], socket)
    return varied


def add_bump(tree: bpy.types.NodeTree, normal: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    """Wrinkles some millimetres wide for that socket; returns the one that takes their strength."""
    place, noise, bump = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "TexNoise", "Bump")
    )
    noise.inputs["Scale"].default_value = 200  # per metre
    bump.inputs["Distance"].default_value = 3e-3
    tree.links.new(place.outputs["Object"], noise.inputs["Vector"])
    tree.links.new(noise.outputs[0], bump.inputs["Height"])
    tree.links.new(bump.outputs[0], normal)
    return bump.inputs["Strength"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("strip", choices=STRIPS)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    with render_scene.quiet():
        write(shoot(STRIPS[arguments.strip]), arguments.out, MOST_BYTES)


if __name__ == "__main__":
    render_scene.run(main)
