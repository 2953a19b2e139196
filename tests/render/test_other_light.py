# SPDX-License-Identifier: Apache-2.0
"""The flakes under world and area light: renders against quadrature of the core's BRDF."""

from __future__ import annotations

import dataclasses
import math

import bpy
import numpy as np
import pytest
import verify_scenes
from metallic_paint import verify
from metallic_paint.paint import Flakes, Paint, core_paint

core = pytest.importorskip("metallic_paint_core")

SAMPLES = 160
SIZE = 32


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


def half_sphere(n: int) -> np.ndarray:
    """n² directions about +z, (n², 3), each of the same share of cos dω."""
    cosine = np.sqrt((np.arange(n) + 0.5) / n)[:, None]
    phi = 2 * np.pi * (np.arange(n) + 0.5) / n
    sine = np.sqrt(1 - cosine**2)
    return np.stack(
        [sine * np.cos(phi), sine * np.sin(phi), np.broadcast_to(cosine, (n, n))], axis=-1
    ).reshape(-1, 3)


def albedo(paint: Paint, view: np.ndarray, seen: object = None) -> np.ndarray:
    """Integral of f cos over the half sphere (or the part that `seen` keeps): the RGB radiance
    under a world of radiance 1."""
    light = half_sphere(400)
    normal = np.broadcast_to([0.0, 0.0, 1.0], light.shape)
    views = np.broadcast_to(view, light.shape)
    f = core.flake_brdf(core_paint(paint), normal, views, light)
    kept = np.ones(len(light)) if seen is None else seen(light)
    return (f * kept[:, None]).mean(axis=0) * np.pi


def pixels(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and its standard error, RGB, of a picture filled by one plane."""
    flat = image.reshape(-1, 3).astype(float)
    return flat.mean(axis=0), flat.std(axis=0) / math.sqrt(len(flat))


def expect_equal(image: np.ndarray, expected: np.ndarray, relative: float = 0.01) -> None:
    mean, error = pixels(image)
    assert (np.abs(mean - expected) <= 4 * error + 2e-3 * expected).all(), (mean, error, expected)
    assert (np.abs(mean - expected) <= relative * expected + 1e-6).all(), (mean, expected)


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
    """Towards the orthographic camera: the same at every point."""
    samples, probe.scene.cycles.samples = probe.scene.cycles.samples, 1
    view = probe.image(verify.VIEW)[SIZE // 2, SIZE // 2].astype(float)
    probe.scene.cycles.samples = samples
    return view / np.linalg.norm(view)


def add_area_light(size: float, height: float) -> bpy.types.Object:
    """A square lamp towards +x, facing the origin."""
    data = bpy.data.lights.new("Area", "AREA")
    data.size, data.energy = size, 100
    item = bpy.data.objects.new("Area", data)
    item.location = (0.8 * height, 0, height)
    item.rotation_euler = item.location.to_track_quat("Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(item)
    bpy.context.view_layer.update()
    return item


def shines(lamp: bpy.types.Object) -> object:
    """Whether a direction from the origin meets the square lamp."""
    matrix = np.array(lamp.matrix_world)
    centre, axes = matrix[:3, 3], matrix[:3, :3]
    half = lamp.data.size / 2

    def seen(light: np.ndarray) -> np.ndarray:
        facing = light @ axes[:, 2]
        distance = (centre @ axes[:, 2]) / np.where(facing > 0, facing, np.inf)
        at = light * distance[:, None] - centre
        return (facing > 0) & (np.abs(at @ axes[:, 0]) < half) & (np.abs(at @ axes[:, 1]) < half)

    return seen


def radiance_of_lamp(probe: verify.Probe, lamp: bpy.types.Object) -> float:
    """By what a white Lambertian plane shows: L times the mean of cos over pi."""
    plane = next(o for o in probe.scene.objects if o.type == "MESH")
    white = bpy.data.materials.new("White")
    if white.node_tree is None:
        white.use_nodes = True
    white.node_tree.nodes.clear()
    diffuse = white.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
    out = white.node_tree.nodes.new("ShaderNodeOutputMaterial")
    white.node_tree.links.new(diffuse.outputs[0], out.inputs["Surface"])
    painted, plane.data.materials[0] = plane.data.materials[0], white
    shown = float(verify.render(probe.scene).mean())
    plane.data.materials[0] = painted
    return shown / shines(lamp)(half_sphere(1000)).mean()


@pytest.mark.parametrize("k", range(len(PAINTS)))
def test_under_a_world_of_one_radiance_the_flakes_show_their_albedo(k: int) -> None:
    elevation = (90, 60, 35, 20)[k % 4]
    probe = scene_with(PAINTS[k], elevation=elevation)
    view = view_of(probe)
    add_world(1.0)
    expect_equal(probe.image(verify.LOBE), albedo(PAINTS[k], view))


@pytest.mark.parametrize("k", range(0, len(PAINTS), 2))
def test_what_is_scattered_several_times_is_the_cores(k: int) -> None:
    paint = dataclasses.replace(
        PAINTS[k],
        coating=("colors", "aluminium", "tio2-on-mica", "fe2o3-on-silica")[k // 2 % 4],
        second=dataclasses.replace(
            Flakes(), flakes_per_mm2=500 * (k % 3), coating="tio2-on-silica"
        ),
        substrate_color=(0.1, 0.5, 0.9),
    )
    probe = scene_with(paint, elevation=(90, 60, 35, 20)[k % 4])
    expected = core.mixture(core_paint(paint), (0.1, 0.5, 0.9), view_of(probe)[2])
    probe.scene.cycles.samples = 1
    inner = {"diffuse": verify.DIFFUSE, "glossy": verify.GLOSSY, "alpha": verify.ROUGHNESS}
    for name, diagnostic in inner.items():
        shown = probe.image(diagnostic).reshape(-1, 3)
        wanted = np.broadcast_to(expected[name], shown.shape)
        # Rounding in float, which core/mixture.h's test holds to 2e-5, and of the view.
        np.testing.assert_allclose(shown, wanted, rtol=0, atol=1e-4)


@pytest.mark.parametrize("k", range(0, len(PAINTS), 4))
def test_an_area_light_shows_in_the_flakes(k: int) -> None:
    probe = scene_with(PAINTS[k], elevation=60, width=0.01)
    view = view_of(probe)
    probe.scene.cycles.samples = 1024  # a standard error of a quarter per cent
    lamp = add_area_light(2.0, 1.5)
    radiance = radiance_of_lamp(probe, lamp)
    expect_equal(probe.image(verify.LOBE), radiance * albedo(PAINTS[k], view, shines(lamp)))


def test_no_listed_light_is_seen_in_the_lobe() -> None:
    lamps = (
        verify_scenes.sun("Sun", 60, 110, 5.0),
        verify_scenes.lamp("Point", "POINT", (0.5, 0.4, 0.9), 0.2),
    )
    bpy.ops.wm.read_factory_settings(use_empty=True)
    spec = verify_scenes.Scene("listed", lamps, orthographic=True)
    item = verify_scenes.build(bpy.context.scene, spec, SIZE)
    for lamp in bpy.data.lights:
        lamp.cycles.use_multiple_importance_sampling = True
    probe = verify.Probe(bpy.context.scene, [item.active_material])
    probe.scene.cycles.samples = SAMPLES
    probe.scene.cycles.max_bounces = probe.scene.cycles.glossy_bounces = 1
    assert probe.image(verify.SPARKLES).max() > 0
    assert probe.image(verify.LOBE).max() == 0


def test_a_light_beyond_the_slots_lights_the_mean() -> None:
    paint = dataclasses.replace(PAINTS[3], tilt=0.3)
    probe = scene_with(paint, elevation=60)
    probe.scene.cycles.samples = 2048  # most of the cones miss so small a light
    view = view_of(probe)
    add = verify_scenes.sun("Unlisted", 70, -90, 0.53)
    sun = add(probe.scene)  # no lights.fill: it stays out of the slots
    bpy.context.view_layer.update()
    towards = np.array(sun.matrix_world)[:3, 2].astype(float)
    f = core.flake_brdf(core_paint(paint), np.array([[0.0, 0, 1]]), view[None], towards[None])[0]
    expect_equal(probe.image(verify.LOBE), f * towards[2] * sun.data.energy, relative=0.05)


def test_all_lights_at_once_are_the_sum_of_each() -> None:
    paint = dataclasses.replace(PAINTS[0], substrate_color=(0.1, 0.2, 0.3))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    sun = verify_scenes.sun("Sun", 60, 110, 0.53)
    spec = verify_scenes.Scene("all", (sun,), paint=paint, orthographic=True, distance=2)
    item = verify_scenes.build(bpy.context.scene, spec, SIZE)
    probe = verify.Probe(bpy.context.scene, [item.active_material])
    scene = probe.scene
    scene.cycles.samples = SAMPLES
    area = add_area_light(2.0, 1.5)
    add_world(0.5)
    world, lamp = scene.world, scene.objects["Sun"]

    def shown(*, sun: bool, sky: bool, square: bool) -> np.ndarray:
        lamp.hide_render, area.hide_render = not sun, not square
        scene.world = world if sky else None
        return verify.render(scene)

    parts = [
        shown(sun=True, sky=False, square=False),
        shown(sun=False, sky=True, square=False),
        shown(sun=False, sky=False, square=True),
    ]
    joint = shown(sun=True, sky=True, square=True)
    difference = (joint - sum(parts)).reshape(-1, 3).astype(float)
    error = difference.std(axis=0) / math.sqrt(len(difference))
    assert (np.abs(difference.mean(axis=0)) <= 4 * error).all(), (difference.mean(axis=0), error)
    assert (error < 0.01 * joint.mean(axis=(0, 1))).all(), "noise hides nothing"
