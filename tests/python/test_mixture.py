# SPDX-License-Identifier: Apache-2.0
"""What substrate, pigment and several flakes scatter, through Python."""

import math

import metallic_paint_core as core
import numpy as np
import pytest
import seeds

pytestmark = pytest.mark.long

NAN = float("nan")


PEARL = core.FlakeSpecies(flakes_per_mm2=2000, tilt=0.1, coating=9, coating_nm=90)
METAL = core.FlakeSpecies(flakes_per_mm2=1000, tilt=0.3, coating=3)
# The random walk takes the ways to observer and light for independent.
PAINTS = [
    core.Paint(depth_model="attenuated", **fields)
    for fields in (
        {"flakes_per_mm2": 5000, "flake_color": (0.9, 0.6, 0.3), "rayleigh_per_mm": 0.2},
        {"flakes_per_mm2": 1000, "coating": 12, "coating_nm": 60, "more": [METAL, PEARL]},
    )
]


@pytest.mark.parametrize("paint", PAINTS, ids=["one species", "three of the library"])
def test_it_is_what_the_random_walk_leaves_beside_single_flakes(paint: core.Paint) -> None:
    substrate = (0.1, 0.5, 0.9)
    random = seeds.fresh(7)
    for cosine in (1.0, 0.3):
        light = [math.sqrt(1 - cosine * cosine), 0, cosine]
        seed = int(random.integers(2**63))
        walk = core.random_walk(paint, light, substrate=substrate, photons=200_000, seed=seed)
        expected = walk["albedo"] - walk["albedo_single_flake"]
        mixture = core.mixture(paint, substrate, cosine)
        found = mixture["diffuse"] + mixture["glossy"]
        # The model's own error for these paints is 0.0115 +- 0.0003 (2 million photons). One run in
        # 1e5 finds one of the twelve beyond 5 standard errors of the walk.
        walked = np.hypot(walk["albedo_error"], walk["albedo_single_flake_error"])
        assert (np.abs(found - expected) <= 0.0125 + 5 * walked).all(), f"{cosine=} {seed=}"
        assert (expected > 0.02).all()
        assert (mixture["glossy"] > 0).all()


SHAPES = {"diffuse": (2, 3, 3), "glossy": (2, 3, 3), "returned": (2, 3, 3), "alpha": (2, 3),
          "exponent": (2, 3), "above": (2, 3)}  # fmt: skip


def test_it_has_the_shape_of_the_cosines_with_a_colour_each() -> None:
    cosines = np.linspace(0.1, 1, 6).reshape(2, 3)
    many = core.mixture(core.Paint(), (0.5, 0.5, 0.5), cosines)
    one = core.mixture(core.Paint(), (0.5, 0.5, 0.5), cosines[1, 2])
    for name, shape in SHAPES.items():
        assert many[name].shape == shape
        np.testing.assert_array_equal(many[name][1, 2], one[name])


@pytest.mark.parametrize(
    ("substrate", "cosine", "message"),
    [
        ((0.5, 0.5), 1, "substrate is .* but must be three numbers"),
        ((0.5, 1.5, 0.5), 1, "substrate.* is 1.5, but must be from 0 to 1"),
        ((0.5, 0.5, 0.5), 1.5, "cos_view is 1.5"),
        ((0.5, 0.5, 0.5), NAN, "cos_view is nan"),
        ((0.5, 0.5, 0.5), "a", "cos_view is 'a', but must be an array of numbers"),
    ],
)
def test_a_bad_argument_is_named(substrate: tuple, cosine: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        core.mixture(core.Paint(), substrate, cosine)
