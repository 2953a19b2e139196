# SPDX-License-Identifier: Apache-2.0
"""The flakes under world and area light: renders against quadrature of the core's BRDF."""

from __future__ import annotations

import dataclasses
import math

import bpy
import numpy as np
import pytest
import verify_scenes
from metallic_paint import lights, material, verify
from metallic_paint.paint import Paint

core = pytest.importorskip("metallic_paint_core")

SAMPLES = 256
SIZE = 48


def scene_with(paint: Paint, **changes: object) -> verify.Probe:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    spec = verify_scenes.Scene("other light", (), paint=paint, orthographic=True, **changes)
    item = verify_scenes.build(bpy.context.scene, spec, SIZE)
    probe = verify.Probe(bpy.context.scene, [item.active_material])
    probe.scene.cycles.samples = SAMPLES
    probe.scene.cycles.max_bounces = probe.scene.cycles.glossy_bounces = 1
    return probe


def add_world(radiance: float) -> None:
    world = bpy.data.worlds.new("World")
    if world.node_tree is None:
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = radiance
    bpy.context.scene.world = world


def albedo(paint: Paint, view: np.ndarray, seen: object = None) -> np.ndarray:
    """Integral of f cos over the half sphere (or the part that `seen` keeps): the RGB radiance
    under a world of radiance 1."""
    n = 400
    cosine = np.sqrt((np.arange(n) + 0.5) / n)[:, None]
    phi = 2 * np.pi * (np.arange(n) + 0.5) / n
    sine = np.sqrt(1 - cosine**2)
    light = np.stack(
        [sine * np.cos(phi), sine * np.sin(phi), np.broadcast_to(cosine, (n, n))], axis=-1
    ).reshape(-1, 3)
    normal = np.broadcast_to([0.0, 0.0, 1.0], light.shape)
    views = np.broadcast_to(view, light.shape)
    f = core.flake_brdf(verify.core_paint(paint), normal, views, light)
    kept = np.ones(len(light)) if seen is None else seen(light)
    return (f * kept[:, None]).sum(axis=0) * np.pi / n**2


def pixels(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and its standard error, RGB, of a picture filled by one plane."""
    flat = image.reshape(-1, 3).astype(float)
    return flat.mean(axis=0), flat.std(axis=0) / math.sqrt(len(flat))


def expect_equal(image: np.ndarray, expected: np.ndarray) -> None:
    mean, error = pixels(image)
    assert (np.abs(mean - expected) <= 4 * error + 2e-3 * expected).all(), (mean, error, expected)
    assert (np.abs(mean - expected) <= 0.01 * expected + 1e-6).all(), (mean, expected)


def random_paint(random: np.random.Generator) -> Paint:
    orientation = ("gaussian", "beckmann", "ggx")[random.integers(3)]
    colour = tuple(random.uniform(0.4, 0.95, 3))
    return Paint(
        flakes_per_mm2=float(np.exp(random.uniform(np.log(300), np.log(10_000)))),
        flake_diameter_um=float(random.uniform(5, 30)),
        orientation=orientation,
        tilt=float(np.exp(random.uniform(np.log(0.05), np.log(0.5)))),
        flake_color=colour,
        flake_edge_color=(0.95, 0.95, 0.95),
        binder_ior=float(random.uniform(1.3, 1.8)),
        binder_absorption_per_mm=tuple(random.uniform(0, 10, 3)),
        seed=int(random.integers(1000)),
    )


PAINTS = [random_paint(np.random.default_rng(k)) for k in range(20)]


def view_of(probe: verify.Probe) -> np.ndarray:
    geometry = probe.geometry()
    return geometry.view[geometry.hit][0].astype(float)


@pytest.mark.parametrize("k", range(len(PAINTS)))
def test_under_a_world_of_one_radiance_the_flakes_show_their_albedo(k: int) -> None:
    elevation = (90, 60, 35, 20)[k % 4]
    probe = scene_with(PAINTS[k], elevation=elevation)
    view = view_of(probe)
    add_world(1.0)
    expect_equal(probe.image(verify.LOBE), albedo(PAINTS[k], view))
