# SPDX-License-Identifier: Apache-2.0
"""The virtual instruments of ./paint measure against what is known in closed form.

Tests of random numbers are seeded. The errors come from 16 batches: of Student's t with 15 degrees
of freedom, 37 independent comparisons all stay below 5 in 99.4 % of cases (Sidak).
"""

from __future__ import annotations

import dataclasses
import math

import metallic_paint_core as core
import numpy as np
import pytest
import seeds
from measure import goniophotometer, sparkle_camera
from measure.goniophotometer import BATCHES, CURVE, LUMINANCE
from metallic_paint.paint import Paint, core_paint, presets

pytestmark = pytest.mark.long

ERRORS = 5
NO_FLAKES = Paint(flakes_per_mm2=0, substrate_color=(0.5, 0.5, 0.5))


def goniogram(paint: Paint, photons: int = 16_000) -> goniophotometer.Goniogram:
    batches = list(goniophotometer.aspecular_walks(paint, photons))
    return goniophotometer.goniogram(np.array(batches))


def test_lab_has_the_values_of_tables() -> None:
    colours = np.array([(0.0, 0, 0), (1, 1, 1), (0.184187, 0.184187, 0.184187), (1, 0, 0)])
    table = [(0, 0, 0), (100, 0, 0), (50, 0, 0), (53.24, 80.09, 67.20)]
    # The four digits of the matrix of IEC 61966-2-1 leave some hundredths.
    np.testing.assert_allclose(goniophotometer.lab(colours), table, atol=0.03)
    assert (goniophotometer.lab(colours[0]) == 0).all()


def test_flop_index_is_its_formula_and_always_a_number_that_says_something() -> None:
    flop = goniophotometer.flop_index
    assert flop(2, 1, 1) == pytest.approx(2.69)
    assert flop(100, 30, 20) / flop(60, 30, 20) == pytest.approx(2**1.11)
    assert flop(100, 30, 20) / flop(100, 60, 20) == pytest.approx(2**0.86)
    assert flop(0, 0, 0) == flop(50, 50, 50) == flop(40, 45, 50) == 0
    assert math.isnan(flop(1, 0, 0))
    assert math.isnan(flop(1, 1e-30, 0))


def test_jackknife_of_a_mean_is_its_standard_error() -> None:
    values = seeds.fresh(5).normal(size=BATCHES)
    mean = goniophotometer.jackknife(BATCHES, lambda kept: values[kept].mean())
    assert mean.value == pytest.approx(values.mean())
    assert mean.error == pytest.approx(values.std(ddof=1) / math.sqrt(BATCHES))


def test_a_bare_diffuser_has_its_albedo_at_every_angle_and_no_flop() -> None:
    bare = goniogram(dataclasses.replace(NO_FLAKES, binder_ior=1))
    np.testing.assert_allclose(bare.reflectance.value, 0.5, rtol=1e-9)
    assert bare.flop_index.value < 1e-6


def test_a_solid_colour_under_lacquer_has_next_to_no_flop() -> None:
    # Only the lacquer's surface tells the angles apart: at 65° it passes 10 % less than at 30°.
    assert goniogram(NO_FLAKES).flop_index.value < 1


def test_thin_flakes_show_their_brdf_at_the_angles_said() -> None:
    paint = Paint(flakes_per_mm2=1, tilt=0.3, substrate_color=(0, 0, 0))  # one flake in 3000 areas
    curve = goniogram(paint, photons=400_000).reflectance
    up, light = goniophotometer.direction(0), goniophotometer.direction(-goniophotometer.LIGHT)
    views = [goniophotometer.direction(goniophotometer.LIGHT - math.radians(a)) for a in CURVE]
    n = len(CURVE)
    brdf = core.flake_brdf(core_paint(paint), [up] * n, views, [light] * n)
    ratio = curve.value[:, 0] / (np.pi * brdf[:, 0])
    error = curve.error[:, 0] / curve.value[:, 0]
    assert (np.abs(ratio - 1) < ERRORS * error).all()
    # The same few flakes are seen from every angle; light that meets two of them is 1/3000.
    np.testing.assert_allclose(ratio, ratio.mean(), rtol=2e-3)
    assert abs(CURVE[np.argmax(curve.value[:, 0])]) <= 10


def test_the_silvers_flop_as_silvers_do() -> None:
    silver = goniogram(presets.load("silver-coarse")).flop_index
    assert 10 < silver.value < 17  # high-flop paints: 15 to 17
    assert 0 < silver.error < 1


def test_sparkle_area_is_the_probability_of_a_sparkle() -> None:
    # Small flakes of one size: Poisson, so 1 - exp(-<N>); over this background all of them show.
    paint = Paint(flakes_per_mm2=2000, flake_diameter_um=10, flake_area_spread=0)
    light = math.radians(15)
    up = [goniophotometer.direction(0)]
    lamp = core.Light(
        core.LightKind.parallel, goniophotometer.direction(light),
        math.sin(sparkle_camera.LAMP_RADIUS),
    )  # fmt: skip
    mean = core.evaluate(
        core_paint(dataclasses.replace(paint, anchor="pixel")), [lamp],
        position=[(0, 0, 0)], normal=up, view=up,
        footprint=[sparkle_camera.PIXEL**2], pixel=[(0, 0)],
    )["mean_count"].item()  # fmt: skip
    assert 0.005 < mean < 0.2
    background = np.full((BATCHES, 3), 0.05)
    found = sparkle_camera.sparkle(paint, light, background, 64)
    assert abs(found.area.value + math.expm1(-mean)) < ERRORS * found.area.error
    assert found.picture.min() == pytest.approx(0.05)
    assert found.intensity.value > 1


def test_what_does_not_sparkle_has_no_intensity_and_what_is_black_no_grain() -> None:
    black = np.zeros((BATCHES, 3))
    found = sparkle_camera.sparkle(NO_FLAKES, 0.3, black + 0.1, 16)
    assert found.area.value == found.area.error == 0
    assert math.isnan(found.intensity.value)
    even = sparkle_camera.dome_luminance(NO_FLAKES, 64)
    assert sparkle_camera.graininess(even, black + 0.1).value == 0
    assert math.isnan(sparkle_camera.graininess(even, black).value)


def test_flakes_under_a_dome_are_as_bright_as_the_walk_says() -> None:
    # Reciprocity: towards the normal under a dome of luminance 1, as much as comes back in all
    # directions of light from the normal. The walk's flakes are independent: "attenuated".
    paint = presets.load("deep-blue")
    squares = sparkle_camera.dome_luminance(paint, 4096, "attenuated").mean(axis=1)
    walk = core.random_walk(core_paint(paint), (0, 0, 1), photons=200_000)
    albedo = walk["albedo_single_flake"] @ LUMINANCE
    error = walk["albedo_single_flake_error"] @ LUMINANCE + squares.std(ddof=1) / math.sqrt(BATCHES)
    assert abs(squares.mean() - albedo) < ERRORS * error
