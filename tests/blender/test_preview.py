# SPDX-License-Identifier: Apache-2.0
"""The preview: what the paint shows where its shader does not run."""

from __future__ import annotations

import dataclasses
import math
import os
import re
import subprocess
import sys

import bpy
import metallic_paint_core as core
import numpy as np
import pytest
import seeds
from common.processes import TOOLS
from metallic_paint.paint import (
    COATINGS,
    PARAMETERS,
    Paint,
    coatings,
    core_paint,
    material,
    presets,
)
from metallic_paint.verify import make_noiseless, render
from verification import scenes

SIZE = 48
SPHERE = scenes.Scene(
    "preview", (), shape="sphere", orthographic=True, width=0.3, scale=(0.15, 0.15, 0.15)
)
# By the cosine of the view, where a ring of the ball is taken together.
RINGS = ((0.97, 1), (0.88, 0.92), (0.68, 0.72), (0.47, 0.53), (0.27, 0.33))

# What decides the sparkles and not their mean, or, of the last line, what the preview leaves out.
WITHOUT_PREVIEW = {
    "anchor", "cells_per_pixel", "instances", "seed",
    "radiometry", "composition", "texture_contrast", "orange_peel", "orange_peel_mm",
}  # fmt: skip


def ball(paint: Paint, shader_runs: bool) -> bpy.types.Material:
    """A ball of the paint under a white world."""
    scene = bpy.context.scene
    painted = scenes.build(scene, SPHERE, SIZE).active_material
    material.apply(painted, paint)
    world = bpy.data.worlds.new("World")
    if world.node_tree is None:
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    scene.world = world
    make_noiseless(scene)
    scene.cycles.shading_system = shader_runs
    scene.cycles.samples = 32
    return painted


def by_angle(picture: np.ndarray) -> np.ndarray:
    """(rings, 3): the mean of each ring."""
    y, x = (np.mgrid[0:SIZE, 0:SIZE] + 0.5) / SIZE * 2 - 1
    cosine = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    return np.array([picture[(cosine > a) & (cosine < b)].mean(0) for a, b in RINGS])


def albedo(paint: Paint) -> np.ndarray:
    """(rings, 3): the core's."""
    cosine = [math.sqrt((a * a + b * b) / 2) for a, b in RINGS]
    count = len(cosine)
    view = [[math.sqrt(1 - c * c), 0, c] for c in cosine]
    return core.reflectance(
        core_paint(paint), [[0, 0, 1]], position=np.zeros((count, 3)),
        normal=[[0, 0, 1]] * count, view=view, footprint=[1e-6] * count,
        pixel=np.zeros((count, 2), np.int32),
    )["albedo"]  # fmt: skip


def random_paint(random: np.random.Generator) -> Paint:
    """One that is usual: from a hint of flakes to a dense layer."""
    diameter = random.uniform(10, 60)
    coverage = np.exp(random.uniform(np.log(0.1), np.log(2)))
    return Paint(
        flake_diameter_um=diameter,
        flakes_per_mm2=coverage / (math.pi / 4 * (diameter * 1e-3) ** 2),
        orientation=str(random.choice(["gaussian", "beckmann", "ggx"])),
        tilt=random.uniform(0.08, 0.2),
        coating=str(random.choice(["colors", *COATINGS[1:9], "tio2-on-mica", "fe2o3-on-mica"])),
        coating_nm=random.uniform(20, 120),
        flake_color=tuple(random.uniform(0.1, 0.95, 3)),
        binder_absorption_per_mm=tuple(random.uniform(0, 30, 3)),
        layer_thickness_um=random.uniform(15, 40),
        substrate_color=tuple(random.uniform(0, 0.5, 3)),
        coat_roughness=float(random.choice([0, 0.3])),
    )


# --- with the shader -------------------------------------------------------------------------


def test_where_the_shader_runs_it_is_all_that_shows() -> None:
    """Bit for bit."""
    random = seeds.fresh(0)
    painted = ball(random_paint(random), shader_runs=True)
    tree = material.paint_node(painted).node_tree
    out = next(node for node in tree.nodes if node.type == "GROUP_OUTPUT")
    mixed = render(bpy.context.scene)
    tree.links.new(tree.nodes[material.NAME].outputs[material.OUTPUT], out.inputs[0])
    assert np.array_equal(mixed, render(bpy.context.scene))
    assert by_angle(mixed).min() > 0


@pytest.mark.long
def test_where_the_shader_runs_cycles_drops_it_before_osl_compiles() -> None:
    statistics = subprocess.run(
        [sys.executable, TOOLS, "bench.show_operations", "the paint"],
        env={**os.environ, "OSL_OPTIONS": "statistics:level=1"},
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    found = re.search(r"Instances: (\d+) requested", statistics)
    assert found
    assert int(found[1]) < 30  # nodes, with those of the light and the world


# --- without it ------------------------------------------------------------------------------


@pytest.mark.long
def test_presets_look_like_their_mean(subtests: pytest.Subtests) -> None:
    """The limits are 1.3 times what is measured: noise of 32 samples, and Blenders differ."""
    painted = ball(Paint(), shader_runs=False)
    errors = {}
    for name in presets.names():
        paint = presets.load(name)
        material.apply(painted, paint)
        errors[name] = by_angle(render(bpy.context.scene)) - albedo(paint)
        with subtests.test(name):
            assert np.abs(errors[name]).max() < 0.1
    assert math.sqrt(np.mean(np.square(list(errors.values())))) < 0.018


@pytest.mark.long
def test_random_paints_look_like_their_mean() -> None:
    random = seeds.fresh(1)
    painted = ball(Paint(), shader_runs=False)
    errors = []
    for _ in range(12):
        paint = random_paint(random)
        material.apply(painted, paint)
        errors.append(by_angle(render(bpy.context.scene)) - albedo(paint))
        assert np.abs(errors[-1]).max() < 0.15, paint
    assert math.sqrt(np.mean(np.square(errors))) < 0.04


@pytest.mark.long
@pytest.mark.parametrize("model_scale", [0.3, 1, 10])
def test_glitter_leaves_the_mean_near_and_far(model_scale: float) -> None:
    """The smallest ring finds some 3000 cells, each of which varies by 0.8 or less: 1.5 % of it."""
    painted = ball(presets.load("silver-coarse"), shader_runs=False)
    inputs = material.paint_node(painted).inputs
    inputs[material.MODEL_SCALE].default_value = model_scale
    glittering = by_angle(render(bpy.context.scene))
    inputs[PARAMETERS["sparkle_contrast"].label].default_value = 0
    assert glittering == pytest.approx(by_angle(render(bpy.context.scene)), abs=0.05)


@pytest.mark.long
def test_glitter_shows_near_by_and_melts_with_distance() -> None:
    """Under a sun, beside a paint without any: the brightness stays."""
    painted = ball(presets.load("silver-coarse"), shader_runs=False)
    bpy.context.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.rotation_euler = bpy.context.scene.camera.rotation_euler
    bpy.context.scene.collection.objects.link(sun)
    inputs = material.paint_node(painted).inputs
    contrast = inputs[PARAMETERS["sparkle_contrast"].label]
    contrast.default_value = 0
    smooth = render(bpy.context.scene)
    contrast.default_value = 1
    glitter = []
    for model_scale in (0.1, 1, 10, 100):
        inputs[material.MODEL_SCALE].default_value = model_scale
        shown = render(bpy.context.scene)
        assert shown.mean() == pytest.approx(smooth.mean(), rel=0.1)  # some 3000 cells, as above
        glitter.append(np.sqrt(np.square(shown - smooth).mean()) / smooth.mean())
    assert glitter == sorted(glitter, reverse=True)
    assert glitter[0] > 0.3
    assert glitter[-1] < 0.01


@pytest.mark.long
def test_no_paint_is_black_or_shines() -> None:
    """Anything that a socket may hold, drawn from its whole range; glitter has its own tests."""
    random = seeds.fresh(2)
    painted = ball(Paint(), shader_runs=False)
    bpy.context.scene.cycles.samples = 4
    node = material.paint_node(painted)
    for _ in range(12):
        for parameter in PARAMETERS.values():
            socket = node.inputs[parameter.label]
            low, high = parameter.minimum, parameter.maximum
            if parameter.choices:
                socket.default_value = int(random.integers(len(parameter.choices)))
            elif socket.type == "INT":
                socket.default_value = int(random.integers(low, high))
            elif socket.type == "RGBA":
                socket.default_value = (*random.uniform(size=3), 1)
            else:
                drawn = low + (high - low) * random.uniform(size=3) ** 8
                socket.default_value = drawn if socket.type == "VECTOR" else drawn[0]
        node.inputs[PARAMETERS["sparkle_contrast"].label].default_value = 0
        shown = by_angle(render(bpy.context.scene))
        assert np.isfinite(shown).all()
        assert 0 < shown.min() <= shown.max() < 1.1


@pytest.mark.long
def test_every_socket_that_decides_the_mean_reaches_it() -> None:
    tree = material.node_group()
    mix = next(node for node in tree.nodes if node.type == "MIX_SHADER")
    links: dict[bpy.types.Node, list[bpy.types.NodeLink]] = {}
    for link in tree.links:
        links.setdefault(link.to_node, []).append(link)
    reached, found = [mix.inputs[1].links[0].from_node], set()
    labels = set()
    while reached:
        node = reached.pop()
        for link in links.get(node, []):
            if link.from_node.type == "GROUP_INPUT":
                labels.add(link.from_socket.name)
            elif link.from_node not in found:
                found.add(link.from_node)
                reached.append(link.from_node)
    decide = {
        parameter.label for name, parameter in PARAMETERS.items() if name not in WITHOUT_PREVIEW
    }
    assert labels == decide | {material.NORMAL, material.COAT_NORMAL, material.MODEL_SCALE}


@pytest.mark.long
def test_a_texture_in_a_socket_shows() -> None:
    paint = dataclasses.replace(Paint(), flakes_per_mm2=6000)
    painted = ball(dataclasses.replace(paint, flake_color=(0.9, 0.2, 0.1)), shader_runs=False)
    red = render(bpy.context.scene)
    material.apply(painted, paint)
    color = painted.node_tree.nodes.new("ShaderNodeRGB")
    color.outputs[0].default_value = (0.9, 0.2, 0.1, 1)
    node = material.paint_node(painted)
    painted.node_tree.links.new(color.outputs[0], node.inputs["Flake Color"])
    assert by_angle(render(bpy.context.scene)) == pytest.approx(by_angle(red), abs=1e-5)


def test_the_table_of_coatings_is_made_once_and_lies_in_the_file() -> None:
    material.create(Paint())
    image = coatings.table()
    assert [each for each in bpy.data.images if each.name.startswith(coatings.TABLE)] == [image]
    assert image.packed_file is not None
