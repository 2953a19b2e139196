# SPDX-License-Identifier: Apache-2.0
"""The whole paint at numpy arrays: shade() under listed lights, reflectance() under all others."""

from __future__ import annotations

import metallic_paint_core as core
import numpy as np
import pytest
import seeds

SUN = core.Light(core.LightKind.parallel, (0.3, 0.1, 1.0), 0.02)
LAMP = core.Light(core.LightKind.positional, (0.0, 2.0, 3.0), 0.1)
BELOW = core.Light(core.LightKind.parallel, (0.0, 0.0, -1.0), 0.02)


def places(n: int = 5, **changes: object) -> dict[str, object]:
    random = seeds.fresh(6)
    view = random.normal(size=(n, 3)) * 0.3 + [0, 0, 1]
    return {
        "position": random.uniform(-1, 1, (n, 3)),
        "normal": np.broadcast_to([0.0, 0.0, 1.0], (n, 3)),
        "view": view / np.linalg.norm(view, axis=1, keepdims=True),
        "footprint": np.full(n, 1e-6),
        "pixel": np.arange(2 * n).reshape(n, 2),
        **changes,
    }


PAINT = core.Paint(substrate_color=(0.3, 0.2, 0.1), coat_roughness=0.4, texture_contrast=0.3)


def test_radiance_is_coat_over_flakes_over_mixture() -> None:
    at = places()
    found = core.shade(PAINT, [SUN, LAMP, BELOW], **at)
    drawn = core.evaluate(PAINT, [SUN, LAMP, BELOW], **at)
    np.testing.assert_array_equal(found["sparkles"], drawn["radiance"])
    below = found["coat_rest"][:, None, None] * (found["sparkles"] + found["scattered"])
    np.testing.assert_allclose(found["radiance"], found["shine"][..., None] + below, rtol=1e-12)
    mean = found["radiance"] + found["coat_rest"][:, None, None] * (
        drawn["mean_radiance"] - drawn["radiance"]
    )
    np.testing.assert_allclose(found["mean_radiance"], mean, rtol=1e-9, atol=1e-12)
    assert (found["shine"][:, :2] > 0).all()
    assert (found["radiance"][:, 2] == 0).all()


def test_albedo_is_the_reflectance_over_all_lights() -> None:
    n = 200  # n² directions, each of the same share of cos dω
    cosine = np.sqrt((np.arange(n) + 0.5) / n)[:, None]
    phi = 2 * np.pi * (np.arange(n) + 0.5) / n
    sine = np.sqrt(1 - cosine**2)
    each = (sine * np.cos(phi), sine * np.sin(phi), np.broadcast_to(cosine, (n, n)))
    light = np.stack(each, axis=-1).reshape(-1, 3)
    found = core.reflectance(PAINT, light, **places(1))
    whole = np.pi * (found["reflectance"][0] / light[:, 2:]).mean(axis=0)
    np.testing.assert_allclose(whole, found["albedo"][0], atol=3e-3)
    assert (found["mirror"] == 0).all()


def test_a_smooth_coat_is_a_mirror_besides() -> None:
    at = places()
    found = core.reflectance(core.Paint(), [[0, 0, 1]], **at)
    cosine = at["view"][:, 2]
    passed = core.fresnel_transmittance(cosine, np.full(len(cosine), 1.5))
    np.testing.assert_allclose(found["mirror"], 1 - passed, rtol=1e-12)


def test_the_orange_peel_is_fixed_to_the_object() -> None:
    paint = core.Paint(orange_peel=0.05)
    at = places()
    moved = {**at, "position": np.asarray(at["position"]) + 7}
    here = core.shade(paint, [], **at)["coat_normal"]
    assert (here != at["normal"]).any()
    kept = core.shade(paint, [], **moved, own_position=at["position"])["coat_normal"]
    np.testing.assert_array_equal(kept, here)


def test_a_pixel_without_surface_shows_nothing() -> None:
    at = places(2, normal=np.zeros((2, 3)))
    assert (core.shade(PAINT, [SUN], **at)["radiance"] == 0).all()
    assert (core.reflectance(PAINT, [[0, 0, 1]], **at)["albedo"] == 0).all()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"view": np.ones((5, 3))}, r"length of view\[0\] is 1.73"),
        ({"coat_normal": np.ones((5, 3))}, r"length of coat_normal\[0\] is 1.73"),
        ({"coat_normal": np.ones((4, 3))}, r"coat_normal has the shape \(4, 3\)"),
        ({"own_position": np.full((5, 3), np.nan)}, r"own_position\[0\] is nan"),
        ({"own_axes": np.ones((5, 3, 3))}, r"length of own_axes\[0\] is 1.73"),
        ({"own_axes": np.ones((5, 3))}, r"own_axes has the shape \(5, 3\)"),
        ({"instance": np.full(5, 0.5)}, r"instance\[0\] is 0.5"),
    ],
)
def test_bad_places_are_named(changes: dict, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        core.shade(PAINT, [SUN], **places(**changes))
    with pytest.raises(ValueError, match=said):
        core.reflectance(PAINT, [[0, 0, 1]], **places(**changes))


def test_bad_lights_are_named() -> None:
    with pytest.raises(ValueError, match="lights holds 9, but must hold at most 8"):
        core.shade(PAINT, [SUN] * 9, **places())
    with pytest.raises(ValueError, match=r"length of light\[1\] is 2"):
        core.reflectance(PAINT, [[0, 0, 1], [0, 0, 2]], **places())
