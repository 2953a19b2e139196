# SPDX-License-Identifier: Apache-2.0
"""Every scene of ./paint verify in small: the shader finds the core's counts and radiances.

The full sizes, with the statistics of the sparkles, are ./paint verify's.
"""

from __future__ import annotations

import dataclasses

import bpy
import numpy as np
import pytest
from metallic_paint import verify
from metallic_paint.native import core_lights
from metallic_paint.paint import core_paint
from metallic_paint.scene import lights
from verification import scenes

SIZE = 48


# Each kind of camera, of light and of anchor, flakes one by one, and a body that bends.
GATE = {
    "three species of flakes", "orthographic, plane, close", "fisheye", "pearls seen one by one",
    "sun, spot and point at once, by pixels", "a disk", "a sky's sun", "bent, with a rest position",
}  # fmt: skip


@pytest.mark.parametrize(
    "spec",
    [
        pytest.param(spec, id=spec.name, marks=[] if spec.name in GATE else pytest.mark.long)
        for spec in scenes.SCENES
    ],
)
def test_pixels_are_those_of_the_core(spec: scenes.Scene) -> None:
    scene = bpy.context.scene
    item = scenes.build(scene, spec, SIZE)
    probe = verify.Probe(scene, [item.active_material])
    geometry, slots = probe.geometry(), core_lights()
    paint = core_paint(spec.paint)
    predicted = verify.predict(paint, slots, geometry, "float")
    lit = next(iter(lights.fill(scene).slots), scene.world)
    assert geometry.hit.mean() > 0.1
    comparison = verify.compare(
        paint,
        slots,
        geometry,
        predicted,
        light=0,
        leader=0,
        count=probe.image(verify.COUNT)[..., 0],
        cone=probe.image(verify.CONE)[..., 0],
        picture=probe.lit_by([lit], verify.SPARKLES),
        irradiance=probe.lit_by([lit], verify.IRRADIANCE),
    )
    assert comparison.same_count == comparison.pixels
    assert comparison.radiance_error.size > 0
    assert comparison.radiance_error.max() < 1e-2


def test_a_wrong_prediction_is_found_out() -> None:
    spec = scenes.SCENES[0]
    scene = bpy.context.scene
    item = scenes.build(scene, spec, SIZE)
    probe = verify.Probe(scene, [item.active_material])
    geometry, slots = probe.geometry(), core_lights()
    paint = core_paint(dataclasses.replace(spec.paint, seed=spec.paint.seed + 1))
    predicted = verify.predict(paint, slots, geometry, "float")
    empty = np.zeros((SIZE, SIZE, 3), np.float32)
    count = probe.image(verify.COUNT)[..., 0]
    comparison = verify.compare(
        paint, slots, geometry, predicted, 0, 0, count, empty[..., 0], empty, empty
    )
    assert comparison.unexplained > 10


@pytest.mark.long
def test_a_panoramas_footprint_is_what_its_pixels_see() -> None:
    """Against the parallelogram between the places that the neighbouring pixels see."""
    spec = next(each for each in scenes.SCENES if each.name == "fisheye")
    scene = bpy.context.scene
    item = scenes.build(scene, spec, 2 * SIZE)
    geometry = verify.Probe(scene, [item.active_material]).geometry()
    place, hit = geometry.position.astype(float), geometry.hit
    across = (place[1:-1, 2:] - place[1:-1, :-2]) / 2
    up = (place[2:, 1:-1] - place[:-2, 1:-1]) / 2
    seen = hit[1:-1, 2:] & hit[1:-1, :-2] & hit[2:, 1:-1] & hit[:-2, 1:-1]
    wanted = np.linalg.norm(np.cross(across, up), axis=-1)[seen]
    off = geometry.footprint[1:-1, 1:-1][seen] / wanted - 1
    assert seen.mean() > 0.5
    # The differentials are a round cone's, and the fisheye's pixels up to 1.2 times as wide as
    # high; the lowest rows lie 80 degrees off the axis of the lens.
    assert np.quantile(np.abs(off), 0.95) < 0.03
    assert np.abs(off).max() < 0.15
