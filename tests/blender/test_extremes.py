# SPDX-License-Identifier: Apache-2.0
"""Renders at the ends of what a scene and a paint can be: every pixel sound, no fireflies, and
still the core's counts."""

from __future__ import annotations

import dataclasses
import math
import random
from collections.abc import Callable
from typing import Any

import bpy
import numpy as np
import pytest
import seeds
from bench.shared import sockets_of
from many_paints import ManyPaints
from metallic_paint import verify
from metallic_paint.native import core_lights
from metallic_paint.paint import (
    COATINGS,
    INT_MAX,
    INT_MIN,
    NO_FLAKES,
    Flakes,
    Paint,
    Parameter,
    core_paint,
    material,
)
from metallic_paint.scene import lights
from verification import scenes
from verification.scenes import SILVER, SUN, Scene, lamp, sun

SIZE = 24
FRAMES = 1_048_574  # Blender's last


def probe_of(spec: Scene) -> verify.Probe:
    scene = bpy.context.scene
    item = scenes.build(scene, spec, SIZE)
    return verify.Probe(scene, [item.active_material])


def mirror_ceiling(light: Any, position: np.ndarray) -> np.ndarray:  # noqa: ANN401
    """(n,): 1/Ω, T of the light in a perfect mirror; nothing for a light of no size."""
    sine = np.full(len(position), light.size)
    if light.kind == 2:
        away = np.linalg.norm(position.astype(float) - light.vector, axis=1)
        sine = np.minimum(light.size / np.maximum(away, 1e-300), 1)
    half = sine**2 / (2 * (1 + np.sqrt((1 - sine) * (1 + sine))))  # sin²(Δ/2)
    return 1 / np.maximum(4 * math.pi * half, 1e-300)


@dataclasses.dataclass(frozen=True)
class Shown:
    """What the shader says of the light in slot 0. NaN is black in a picture: ask for SOUND."""

    sound: np.ndarray
    count: np.ndarray | None = None
    radiance: np.ndarray | None = None

    @classmethod
    def by(cls, probe: verify.Probe, counts: bool = True, radiances: bool = True) -> Shown:
        return cls(
            probe.image(verify.SOUND),
            probe.image(verify.COUNT)[..., 0] if counts else None,
            probe.image(verify.RADIANCE) if radiances else None,
        )


def geometry_of(probe: verify.Probe) -> verify.Geometry:
    geometry = probe.geometry()
    assert geometry.hit.mean() > 0.1, "the paint is in the picture"
    return geometry


def check(shown: Shown, paint: Paint, geometry: verify.Geometry, frame: int = 0) -> None:
    """What is shown of the pixels that the geometry has, which hold the paint."""
    hit = geometry.hit
    sound = shown.sound[hit]
    assert (sound == 1).all(), f"{(sound != 1).any(axis=-1).sum()} unsound pixels of {hit.sum()}"
    slots = core_lights()
    if shown.radiance is not None:
        radiance = shown.radiance[hit]
        assert (np.isfinite(radiance) & (radiance >= 0)).all()
        ceiling = mirror_ceiling(slots[0], geometry.position[hit])
        if paint.radiometry == "exact":  # published measures Ω as π Δ²
            # 1e-5: some dozens of roundings in float.
            assert (radiance.max(axis=-1) <= ceiling * (1 + 1e-5)).all()
    if shown.count is not None:
        as_the_core = core_paint(paint, frame=frame)
        predicted = verify.predict(as_the_core, slots, geometry, "float")
        none = np.zeros((*hit.shape, 3))
        found = verify.compare(
            as_the_core, slots, geometry, predicted, 0, 0, shown.count, none[..., 0], none, none
        )
        assert found.unexplained == 0


def check_picture(probe: verify.Probe, paint: Paint, frame: int = 0, counts: bool = True) -> None:
    check(Shown.by(probe, counts=counts), paint, geometry_of(probe), frame)


def with_paint(**fields: object) -> Paint:
    return dataclasses.replace(SILVER, **fields)


# --- paints ---------------------------------------------------------------------------------------

# A sphere shows every angle to the light and to the observer, grazing ones included.
SPHERE = Scene("sphere", (SUN,), shape="sphere", width=1, distance=5, scale=(0.5, 0.5, 0.5))
PAINTS = {
    "no refraction": with_paint(binder_ior=1.0),
    "a hair of refraction": with_paint(binder_ior=1 + 1e-6),
    "a hair of it the other way": with_paint(binder_ior=1 - 1e-6),
    "total reflection outside": with_paint(binder_ior=0.5),
    "a dense binder": with_paint(binder_ior=4.0),
    "no flakes": with_paint(flakes_per_mm2=0),
    "a billion flakes": with_paint(flakes_per_mm2=1e9, flake_area_spread=0),
    "specks": with_paint(flake_diameter_um=1e-3, flakes_per_mm2=1e9),
    "plates": with_paint(flake_diameter_um=1e5, flakes_per_mm2=1e-3, flake_area_spread=100),
    "no depth": with_paint(layer_thickness_um=0, binder_absorption_per_mm=(1e6, 0, 1)),
    "a metre of ink": with_paint(layer_thickness_um=1e6, binder_absorption_per_mm=(1e6, 1, 0)),
    "milk": with_paint(rayleigh_per_mm=1e6, layer_thickness_um=1e6),
    "a spike": with_paint(tilt=1e-6, flake_spread=0),
    "perfectly flat flakes": with_paint(tilt=100, flake_spread=0),
    "wavy flakes": with_paint(tilt=0.02, flake_spread=0.5),
    "ggx spike": with_paint(orientation="ggx", tilt=1e-6),
    "beckmann at its widest": with_paint(orientation="beckmann", tilt=1),
    "gold leaf": with_paint(coating="gold", flake_diameter_um=1e4, flakes_per_mm2=1e3),
    "pearl without a film": with_paint(coating="tio2-on-mica", coating_nm=0),
    "pearl of the thickest film": with_paint(coating="fe2o3-on-silica", coating_nm=200),
    "three species of no flakes": with_paint(flakes_per_mm2=0, third=Flakes(flakes_per_mm2=1e-30)),
    "three species of all sizes": with_paint(
        second=Flakes(flakes_per_mm2=1e9, flake_diameter_um=1e-3),
        third=Flakes(flakes_per_mm2=1e-3, flake_diameter_um=1e5, tilt=1e-6),
    ),
    "uneven white": with_paint(
        flakes_per_mm2=0, substrate_color=(1, 1, 1), texture_contrast=1, binder_ior=1.0
    ),
    "rough sea": with_paint(orange_peel=1, orange_peel_mm=1e-3, coat_roughness=1e-6),
    "the greatest of all": with_paint(composition="published", substrate_color=(1, 1, 1)),
    "clear flakes": with_paint(
        flake_color=(0, 0, 0), flake_edge_color=(0, 0, 0), flake_transmission=(1, 1, 1)
    ),
}


def random_paint(chance: random.Random) -> Paint:
    def decades(least: float, most: float, zero: float = 0.0) -> float:
        if chance.random() < zero:
            return 0.0
        return min(max(10 ** chance.uniform(math.log10(least), math.log10(most)), least), most)

    def anything(parameter: Parameter, default: object) -> Any:  # noqa: ANN401
        if parameter.choices:
            return chance.choice(parameter.choices)
        if isinstance(default, tuple):
            return tuple(chance.uniform(parameter.minimum, parameter.maximum) for _ in range(3))
        if parameter.minimum > 0:
            return decades(parameter.minimum, parameter.maximum)
        return decades(1e-9 * parameter.maximum, parameter.maximum, zero=0.25)

    def with_others(of: type[Flakes], fields: dict[str, Any]) -> dict[str, Any]:
        """With the parameters that no line here knows, anywhere in their range."""
        others = of.parameters.keys() - fields.keys() - {"seed"}
        if of is Paint:
            others -= Flakes.parameters.keys()
        return fields | {n: anything(of.parameters[n], getattr(of, n)) for n in sorted(others)}

    def species() -> dict[str, Any]:
        orientation = chance.choice(["gaussian", "beckmann", "ggx"])
        transmission = tuple(chance.random() for _ in range(3))
        reflectance = [tuple(chance.random() * (1 - t) for t in transmission) for _ in range(2)]
        fields = {
            "flakes_per_mm2": decades(1e-3, 1e9),
            "flake_diameter_um": decades(1e-3, 1e5),
            "flake_area_spread": decades(1e-2, 100, zero=0.2),
            "orientation": orientation,
            "tilt": decades(1e-6, 100 if orientation == "gaussian" else 1),
            "flake_spread": decades(1e-6, 0.5, zero=0.2),
            "flake_color": reflectance[0],
            "flake_edge_color": reflectance[1],
            "flake_transmission": transmission,
            "coating": chance.choice(["colors", *COATINGS]),
            "coating_nm": chance.uniform(0, 200),
        }
        return with_others(Flakes, fields)

    more = [Flakes(**species()) if chance.random() < 0.3 else NO_FLAKES for _ in range(2)]
    own = species()
    paint = {
        "binder_ior": decades(0.1, 10),
        "layer_thickness_um": decades(1e-3, 1e6, zero=0.1),
        "binder_absorption_per_mm": tuple(decades(1e-3, 1e6, zero=0.2) for _ in range(3)),
        "rayleigh_per_mm": decades(1e-3, 1e6, zero=0.5),
        "sparkle_contrast": decades(1e-3, 1, zero=0.2),
        "substrate_color": tuple(chance.random() for _ in range(3)),
        "texture_contrast": decades(1e-6, 1, zero=0.5),
        "coat_roughness": decades(1e-6, 1, zero=0.3),
        "orange_peel": decades(1e-6, 1, zero=0.5),
        "orange_peel_mm": decades(1e-3, 1e6),
    }
    return Paint(**own, **with_others(Paint, paint), second=more[0], third=more[1])


def test_every_paint_is_sound(subtests: pytest.Subtests) -> None:
    """Under a sun of no size, the sun, and one that fills the sky; there with a smooth lobe too."""
    chance = random.Random(int(seeds.fresh(400).integers(2**32)))
    seed = chance.randint(INT_MIN, INT_MAX)
    paints = PAINTS | {f"random {i}": random_paint(chance) for i in range(55)}  # with them, 9 x 9
    many = ManyPaints([sockets_of(paint) for paint in paints.values()], SUN, SIZE)
    many.probe.set("Seed", seed)
    for angle in (0.0, 0.53, 180.0):
        many.lamp.data.angle = math.radians(angle)
        shown = Shown.by(many.probe)
        for i, (name, paint) in enumerate(paints.items()):
            with subtests.test(name, angle=angle):
                geometry = many.of(i)
                assert geometry.hit.sum() > SIZE**2 / 2, "the paint is in the picture"
                check(shown, dataclasses.replace(paint, seed=seed), geometry)
    lights.show_other_light(True, uneven=True)
    shown = Shown.by(many.probe, counts=False, radiances=False)
    for i, (name, paint) in enumerate(paints.items()):
        with subtests.test(name, lobe="smooth"):
            check(shown, paint, many.of(i))


@pytest.mark.long
def test_paints_of_constants_are_sound(subtests: pytest.Subtests) -> None:
    """Some of them without links: OSL computes with their values while it compiles."""
    probe = probe_of(SPHERE)
    geometry = geometry_of(probe)
    for name, paint in list(PAINTS.items())[::6]:
        with subtests.test(name):
            material.apply(probe.materials[0], paint)
            check(Shown.by(probe), paint, geometry)


# --- places ---------------------------------------------------------------------------------------


PLANE = Scene("plane", ())
# A plane so large that it fills the picture all the same.
GRAZED = Scene("grazed plane", (), elevation=0.01, width=1e-4, scale=(2000, 2000, 1))


def from_camera(spec: Scene, turn: float) -> Callable:
    """A sun as high as the camera, turned from it about the plane's normal, in degrees."""
    e = math.radians(spec.elevation)
    x, y, z = 0.1, -math.cos(e), math.sin(e)  # as scenes.build places the camera
    elevation = math.degrees(math.atan2(z, math.hypot(x, y)))
    return sun("Sun", elevation, math.degrees(math.atan2(y, x)) + turn, 0.53)


PLACES = {
    PLANE: {
        "the observer is the light": from_camera(PLANE, 0),
        "a mirror view": from_camera(PLANE, 180),
        "grazing light": sun("Sun", 0.001, 40, 0.53),
        "a point of no size": lamp("Point", "POINT", (-0.5, 0.4, 0.9)),
        "a point larger than its distance": lamp("Point", "POINT", (-0.5, 0.4, 0.9), 100),
        "a point in the surface": lamp("Point", "POINT", (0.01, 0.01, 0), 0.001),
        "a lamp far away": lamp("Point", "POINT", (-5e5, 4e5, 9e5), 1e4, 1e15),
    },
    GRAZED: {
        "grazing view": SUN,
        "both grazing, from one side": from_camera(GRAZED, 0),
        "both grazing, from opposite sides": from_camera(GRAZED, 180),
    },
    Scene("pixels far smaller than a flake", (), width=1e-6, distance=0.01): {"sun": SUN},
    Scene("a far camera", (), width=1e3, distance=1e6): {"sun": SUN},
    Scene("a vast plane", (), width=1e6, distance=1e6, orthographic=True): {"sun": SUN},
}


@pytest.mark.long
@pytest.mark.parametrize("spec", PLACES, ids=lambda spec: spec.name)
def test_every_place_is_sound(subtests: pytest.Subtests, spec: Scene) -> None:
    probe = probe_of(spec)
    geometry = geometry_of(probe)
    for name, add_lamp in PLACES[spec].items():
        with subtests.test(name):
            light = add_lamp(probe.scene)
            lights.fill(probe.scene)
            try:
                check(Shown.by(probe), SILVER, geometry)
                picture = probe.picture()
                assert (np.isfinite(picture) & (picture >= 0)).all()
            finally:
                bpy.data.objects.remove(light)


@pytest.mark.long
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_a_scene_in_another_unit_is_sound(scale: float) -> None:
    """The paint's footprint is in metres, whatever the scene's unit is: only the shader knows."""
    probe = probe_of(SPHERE)
    for item in probe.scene.objects:
        item.location *= scale
        if item.type == "MESH":
            item.scale *= scale
    data = probe.scene.camera.data
    data.clip_start, data.clip_end = 0.01 * scale, 100 * scale
    probe.set("Model Scale", 1 / scale)
    check_picture(probe, SILVER)


@pytest.mark.long
def test_a_scene_far_from_its_origin_is_sound() -> None:
    """A million units away a float knows places to 6 cm."""
    probe = probe_of(dataclasses.replace(SPHERE, scale=(50, 50, 50), distance=500, width=100))
    for item in probe.scene.objects:
        item.location.x += 1e6
    check_picture(probe, SILVER, counts=False)


@pytest.mark.long
def test_the_last_pixels_of_a_huge_picture_are_sound() -> None:
    probe = probe_of(dataclasses.replace(PLANE, lamps=(SUN,)))
    render = probe.scene.render
    render.resolution_x = render.resolution_y = 65536
    render.use_border = render.use_crop_to_border = True
    render.border_min_x = render.border_min_y = 1 - SIZE / 65536
    render.border_max_x = render.border_max_y = 1.0
    assert probe.image(verify.PIXEL)[..., 1:].max() == 65535
    check_picture(probe, SILVER, counts=False)


@pytest.mark.long
def test_the_first_and_the_last_frame_and_seed_are_drawn() -> None:
    probe = probe_of(SPHERE)
    geometry = geometry_of(probe)
    for frame, seed in [(-FRAMES, INT_MIN), (FRAMES, INT_MAX)]:
        probe.scene.frame_set(frame)
        probe.set("Frame", frame)
        probe.set("Seed", seed)
        check(Shown.by(probe), with_paint(seed=seed), geometry, frame=frame)


@pytest.mark.long
@pytest.mark.parametrize("smooth", [False, True])
def test_faces_of_no_area_harm_no_other(smooth: bool) -> None:
    probe = probe_of(SPHERE)
    item = next(o for o in probe.scene.objects if o.type == "MESH")
    corners = [vertex.co[:] for vertex in item.data.vertices]
    faces = [tuple(polygon.vertices) for polygon in item.data.polygons]
    n = len(corners)
    corners += [(0, 0, 1.1), (0, 0, 1.1), (0, 0, 1.1), (0, 0.1, 1.1), (0, 0.2, 1.1)]
    faces += [(n, n + 1, n + 2), (n, n + 3, n + 4), (0, 1, n)]
    mesh = bpy.data.meshes.new("Degenerate")
    mesh.from_pydata(corners, [], faces)
    for polygon in mesh.polygons:
        polygon.use_smooth = smooth
    mesh.materials.append(probe.materials[0])
    item.data = mesh
    lights.fill(probe.scene)
    check_picture(probe, SILVER)
