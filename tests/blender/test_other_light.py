# SPDX-License-Identifier: Apache-2.0
"""The paint under sun, world and area light: renders against quadrature of the core's values."""

from __future__ import annotations

import dataclasses
import math
from statistics import NormalDist

import bpy
import metallic_paint_core as core
import numpy as np
import pytest
import seeds
from bench import materials as bench_materials
from gate import first_of
from metallic_paint import verify
from metallic_paint.native import core_lights
from metallic_paint.paint import COATINGS, NO_FLAKES, Flakes, Paint, core_paint, material, presets
from metallic_paint.scene import lights, needs
from scenery import WIDTH as IMAGE_WIDTH
from scenery import disc, solid_angles, world_of
from verification import scenes

SAMPLES = 160
SIZE = 32
# Of the 600 comparisons (20 paints, two Blenders) one errs by chance in one of 10,000 runs.
STANDARD_ERRORS = NormalDist().inv_cdf(1 - 1e-4 / (2 * 600))


def scene_with(paint: Paint, size: int = SIZE, **changes: object) -> verify.Probe:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    seen = {"lamps": (), "orthographic": True, **changes}
    spec = scenes.Scene("other light", paint=paint, **seen)
    item = scenes.build(bpy.context.scene, spec, size)
    probe = verify.Probe(bpy.context.scene, [item.active_material])
    cycles = probe.scene.cycles
    cycles.samples, cycles.max_bounces = SAMPLES, 1
    # Blue noise in the pixels would make their mean surer than its standard error says.
    cycles.sampling_pattern = "TABULATED_SOBOL"
    return probe


def add_world(radiance: float) -> bpy.types.World:
    world = bpy.data.worlds.new("World")
    if world.node_tree is None:
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = radiance
    bpy.context.scene.world = world
    return world


def add_sun(name: str, towards: np.ndarray) -> bpy.types.Object:
    """Of half a degree, as an artist adds it: a mirror meets it too."""
    x, y, z = towards
    elevation, azimuth = math.degrees(math.asin(z)), math.degrees(math.atan2(y, x))
    sun = scenes.sun(name, elevation, azimuth, 0.53)(bpy.context.scene)
    sun.data.cycles.use_multiple_importance_sampling = True
    bpy.context.view_layer.update()
    return sun


def add_area_light(towards: np.ndarray, size: float) -> bpy.types.Object:
    """A square lamp 1.5 away, facing the origin."""
    data = bpy.data.lights.new("Area", "AREA")
    data.size, data.energy = size, 100
    item = bpy.data.objects.new("Area", data)
    item.location = 1.5 * towards
    item.rotation_euler = item.location.to_track_quat("Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(item)
    bpy.context.view_layer.update()
    return item


def view_of(probe: verify.Probe) -> np.ndarray:
    """Towards the orthographic camera: the same at every point."""
    bpy.context.view_layer.update()
    view = np.array(probe.scene.camera.matrix_world)[:3, 2].astype(float)
    return view / np.linalg.norm(view)


def half_sphere(n: int) -> np.ndarray:
    """n² directions about +z, (n², 3), each of the same share of cos dω."""
    cosine = np.sqrt((np.arange(n) + 0.5) / n)[:, None]
    phi = 2 * np.pi * (np.arange(n) + 0.5) / n
    sine = np.sqrt(1 - cosine**2)
    return np.stack(
        [sine * np.cos(phi), sine * np.sin(phi), np.broadcast_to(cosine, (n, n))], axis=-1
    ).reshape(-1, 3)


def flake_brdf(paint: Paint, view: np.ndarray, light: np.ndarray) -> np.ndarray:
    """(n, 3), for lights (n, 3) above the surface."""
    normal = np.broadcast_to([0.0, 0.0, 1.0], light.shape)
    return core.flake_brdf(core_paint(paint), normal, np.broadcast_to(view, light.shape), light)


QUADRATURE = 3e-4  # relative error of the next


def albedo(paint: Paint, view: np.ndarray) -> np.ndarray:
    """Of the flakes alone: their RGB radiance under a world of radiance 1."""
    return np.pi * flake_brdf(paint, view, half_sphere(200)).mean(axis=0)


def mean_of(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and its standard error, RGB, of a picture filled by one plane."""
    flat = image.reshape(-1, 3).astype(float)
    return flat.mean(axis=0), flat.std(axis=0) / math.sqrt(len(flat))


def expect_equal(
    image: np.ndarray,
    expected: np.ndarray,
    bias: float | np.ndarray = 0.0,
    noise: float = 0.005,
) -> None:
    """Within the standard errors besides a bias; they are a small share of the brightest colour."""
    mean, error = mean_of(image)
    off = np.abs(mean - expected)
    assert (error < noise * expected.max()).all(), (mean, error, expected)
    assert (off <= STANDARD_ERRORS * error + bias).all(), (mean, error, expected)


def random_flakes(random: np.random.Generator) -> dict[str, object]:
    return {
        "flakes_per_mm2": float(np.exp(random.uniform(np.log(300), np.log(10_000)))),
        "flake_diameter_um": float(random.uniform(5, 30)),
        "orientation": ("gaussian", "beckmann", "ggx")[random.integers(3)],
        "tilt": float(np.exp(random.uniform(np.log(0.05), np.log(0.5)))),
        "flake_color": tuple(random.uniform(0.4, 0.95, 3)),
        "flake_edge_color": (0.95, 0.95, 0.95),
        "coating": COATINGS[max(random.integers(-5, len(COATINGS)), 0)],
        "coating_nm": float(random.uniform(20, 150)),
    }


def random_paint(k: int) -> Paint:
    """One to three species; metals, pearls and colours; more and less that absorbs."""
    random = seeds.fresh(100 + k)
    more = [Flakes(**random_flakes(random)) for _ in range(k % 3)]
    second, third = [*more, NO_FLAKES, NO_FLAKES][:2]
    return Paint(
        **random_flakes(random),
        second=second,
        third=third,
        binder_ior=float(random.uniform(1.3, 1.8)),
        layer_thickness_um=float(random.uniform(10, 60)),
        binder_absorption_per_mm=tuple(random.uniform(0, 10, 3)),
        rayleigh_per_mm=float(max(random.uniform(-0.5, 0.5), 0)),
        substrate_color=tuple(random.uniform(0, 0.9, 3)),
        seed=int(random.integers(1000)),
    )


PAINTS = [random_paint(k) for k in range(20)]
ELEVATIONS = [float(seeds.fresh(200 + k).uniform(20, 90)) for k in range(20)]


# --- what the core expects ---------------------------------------------------------------------


@dataclasses.dataclass
class Expected:
    """The mean radiance of a paint under single lights, RGB."""

    paint: Paint
    view: np.ndarray

    def __post_init__(self) -> None:
        self.core = core_paint(self.paint)

    def place(self, pixel_m2: float = 1e-6) -> dict[str, np.ndarray]:
        """A pixel that shows so much surface."""
        return {
            "position": np.zeros((1, 3)),
            "normal": np.array([[0.0, 0.0, 1.0]]),
            "view": self.view[None],
            "footprint": np.array([pixel_m2]),
            "pixel": np.zeros((1, 2), dtype=np.int32),
        }

    def world(self, radiance: float) -> np.ndarray:
        anywhere = np.array([[0.0, 0.0, 1.0]])
        return radiance * core.reflectance(self.core, anywhere, **self.place())["albedo"][0]

    def listed(self, light: core.Light, pixel_m2: float) -> np.ndarray:
        """Of a sun, per unit of its irradiance."""
        found = core.shade(self.core, [light], **self.place(pixel_m2))
        return found["mean_radiance"][0, 0]

    def pixel_of(self, light: core.Light, pixels: int) -> float:
        """The area of each of so many pixels that together show a sun within SUN_ERROR, m²."""
        mm2 = 1e-6
        variance = core.evaluate(self.core, [light], **self.place(mm2))["variance"][0, 0]
        scatter = (np.sqrt(variance) / self.listed(light, mm2)).max()
        return mm2 * float(scatter / SUN_ERROR) ** 2 / pixels

    def lamp(self, lamp: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
        """Of a square lamp, and the part of it that its sparkles show more than the BRDF."""
        light, share = points_of(lamp)
        # A Lambertian emitter of that power.
        radiance = lamp.data.energy / (np.pi * lamp.data.size**2)
        whole = core.reflectance(self.core, light, **self.place())
        met = meets(lamp, self.view * [-1, -1, 1]) > 0
        mirrored = radiance * whole["mirror"][0] * met
        more = self.sparkling(lamp, radiance, light, share)
        return radiance * share @ whole["reflectance"][0] + mirrored + more, more

    def sparkling(
        self, lamp: bpy.types.Object, radiance: float, light: np.ndarray, share: np.ndarray
    ) -> np.ndarray:
        """What the closed form of its sparkles has more than the integral over the lamp.

        Each species sparkles by its share, as the core has it: the others are black.
        """
        more = np.zeros(3)
        slot = as_slot(lamp)
        for i, flakes in enumerate(self.paint.species):
            if not flakes.flakes_per_mm2 > 0:
                continue
            alone = core_paint(only(self.paint, i))
            mean = core.evaluate(alone, [slot], **self.place())["mean_radiance"][0, 0]
            width = math.hypot(*slot.facing) / math.hypot(*slot.vector)
            turned = min(2 * self.paint.binder_ior * flakes.tilt, 0.4)
            sparkles = np.clip(2.5 - 2 * width / turned, 0, 1) * (width < 0.5)
            normal, view = (np.broadcast_to(v, light.shape) for v in ([0.0, 0.0, 1.0], self.view))
            f = core.flake_brdf(alone, normal, view, light) * light[:, 2:]
            more += radiance * (mean * share.sum() - sparkles * (share @ f))
        return more

    def apart(self, sun: bpy.types.Object, lamp: bpy.types.Object) -> float:
        """What the sun leaves of the lamp's sparkles."""
        slot = as_slot(lamp)
        distance = math.hypot(*slot.vector)
        cosine = float(towards(sun) @ slot.vector) / distance
        reach = math.asin(min(math.hypot(*slot.facing) / distance, 1))
        gap = math.acos(min(cosine, 1)) - reach - sun.data.angle / 2 - 2e-3
        return min(max(gap / 0.05, 0), 1)


def only(paint: Paint, species: int) -> Paint:
    """The paint with all other flakes black, which hide as much."""
    black = {"flake_color": (0, 0, 0), "flake_edge_color": (0, 0, 0), "coating": "colors"}
    blackened = [
        flakes if i == species else dataclasses.replace(flakes, **black)
        for i, flakes in enumerate(paint.species)
    ]
    first = {field.name: getattr(blackened[0], field.name) for field in dataclasses.fields(Flakes)}
    return dataclasses.replace(paint, **first, second=blackened[1], third=blackened[2])


def as_slot(lamp: bpy.types.Object) -> core.Light:
    """A square lamp."""
    matrix = np.array(lamp.matrix_world).astype(float)
    side = lamp.data.size
    facing = -towards(lamp) * side / math.sqrt(2)
    return core.Light(core.LightKind.area, matrix[:3, 3], side / math.sqrt(math.pi), facing)


def light_of(sun: bpy.types.Object) -> core.Light:
    return core.Light(core.LightKind.parallel, towards(sun), math.sin(sun.data.angle / 2))


def towards(lamp: bpy.types.Object) -> np.ndarray:
    """The unit vector against a lamp's beam."""
    axis = np.array(lamp.matrix_world)[:3, 2].astype(float)
    return axis / np.linalg.norm(axis)


def points_of(lamp: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """Directions (n, 3) from the origin to points of a square lamp, and their solid angles (n,)."""
    n = 150
    matrix = np.array(lamp.matrix_world).astype(float)
    side = lamp.data.size * ((np.arange(n) + 0.5) / n - 0.5)
    x, y = (s.ravel()[:, None] for s in np.meshgrid(side, side))
    points = matrix[:3, 3] + x * matrix[:3, 0] + y * matrix[:3, 1]
    distance = np.linalg.norm(points, axis=1)
    light = points / distance[:, None]
    share = (lamp.data.size / n) ** 2 * (light @ towards(lamp)) / distance**2
    above = light[:, 2] > 0
    return light[above], share[above]


def meets(lamp: bpy.types.Object, light: np.ndarray) -> float:
    """How far inside its edge a direction from the origin meets a square lamp; outside, below 0."""
    matrix = np.array(lamp.matrix_world).astype(float)
    centre, axes = matrix[:3, 3], matrix[:3, :3]
    facing = float(light @ axes[:, 2])
    if facing <= 0:
        return -math.inf
    at = light * (centre @ axes[:, 2] / facing) - centre
    return lamp.data.size / 2 - float(np.abs(at @ axes[:, :2]).max())


# --- the whole paint ---------------------------------------------------------------------------

PIXELS, WIDTH = 96, 0.01
# Relative, of the means under the sun and the lamp. Under the world it is some 0.1 %.
SUN_ERROR, LAMP_ERROR = 0.002, 0.002
MOST_SAMPLES = 144
# Of a lamp's light, beside the standard errors: what lobes show too much in one place they lack in
# another, and cones blur. Of 93 fresh paints 95 % were off by up to 0.84 %, one by 1.04 %, when the
# lobes erred more (ALampsLightIsThatOfTheFlakes in tests/core/smooth_part_test.cpp).
LAMP_BIAS = 0.01


def mirrored(
    paint: Paint, view: np.ndarray, tilt: float, random: np.random.Generator
) -> np.ndarray | None:
    """Where a flake of that tilt to any side sends the view, if it comes out."""
    eta, azimuth = paint.binder_ior, random.uniform(0, 2 * np.pi)
    flake = np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
    inside = view / eta
    inside[2] = np.sqrt(1 - inside[0] ** 2 - inside[1] ** 2)
    out = eta * (2 * (flake @ inside) * flake - inside)
    square = 1 - out[0] ** 2 - out[1] ** 2
    return np.array([out[0], out[1], np.sqrt(square)]) if out[2] > 0 < square else None


def add_lights(
    paint: Paint, view: np.ndarray, random: np.random.Generator
) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A sun, and beside it a square lamp, where flakes mirror them."""
    while True:
        lit = mirrored(paint, view, paint.tilt * random.uniform(0, 1), random)
        beside = mirrored(paint, view, max(paint.tilt * random.uniform(0.5, 1.5), 0.03), random)
        if lit is None or beside is None or min(lit[2], beside[2]) < 0.2:
            continue
        # About as large as what the flakes mirror: of a small one in their tail few samples know.
        half = np.clip(2 * paint.binder_ior * paint.tilt * random.uniform(0.5, 1.5), 0.1, 0.8)
        lamp = add_area_light(lit, 3 * math.tan(half))
        at_all = abs(meets(lamp, view * [-1, -1, 1])) > 2 * WIDTH  # all pixels mirror it, or none
        if at_all and meets(lamp, beside) < -0.1:
            return add_sun("Sun", beside), lamp
        bpy.data.objects.remove(lamp)


def samples_for(probe: verify.Probe, error: float) -> int:
    """How many leave such a relative standard error, by a picture of 8."""
    probe.scene.cycles.samples = 8
    mean, found = mean_of(probe.picture())
    return int(np.clip(8 * (found / mean / error).max() ** 2, 8, MOST_SAMPLES))


def show_pixels_of(pixel_m2: float, view: np.ndarray) -> float:
    """Gives the scene a scale by which a pixel shows so much surface, and returns it."""
    settings = bpy.context.scene.unit_settings
    settings.scale_length = math.sqrt(pixel_m2 * view[2]) / (WIDTH / PIXELS)
    return pixel_m2


@pytest.mark.parametrize("k", first_of(range(len(PAINTS))))
def test_the_mean_under_each_light_is_the_cores_and_all_lights_add(k: int) -> None:
    paint = PAINTS[k]
    probe = scene_with(paint, PIXELS, elevation=ELEVATIONS[k], width=WIDTH)
    scene, view = probe.scene, view_of(probe)
    scene.render.use_persistent_data = True  # compiles for other lights only
    sun, lamp = add_lights(paint, view, seeds.fresh(300 + k))
    world = add_world(0.5)
    expected = Expected(paint, view)

    pixel_m2 = show_pixels_of(expected.pixel_of(light_of(sun), PIXELS**2), view)

    def light(*lit: bpy.types.ID) -> None:
        """These lights alone, and the paint fitted to them."""
        for item in (sun, lamp):
            if item.name in scene.collection.objects:
                scene.collection.objects.unlink(item)
            if item in lit:
                scene.collection.objects.link(item)
        scene.world = world if world in lit else None
        needs.fit(scene)

    def shown(samples: int) -> np.ndarray:
        scene.cycles.samples = samples
        return verify.render(scene)

    light(lamp)
    samples = samples_for(probe, LAMP_ERROR)
    by_lamp = shown(samples)
    light(world)
    by_world = shown(8)
    light(sun, world, lamp)
    joint = shown(samples)
    light(sun)
    by_sun = shown(4)

    of_sun = sun.data.energy * expected.listed(light_of(sun), pixel_m2)
    of_world = expected.world(0.5)
    of_lamp, more = expected.lamp(lamp)
    bias = LAMP_BIAS * of_lamp
    expect_equal(by_sun, of_sun)
    expect_equal(by_world, of_world)
    expect_equal(by_lamp, of_lamp, bias=bias)
    # Near the sun the lamp melts.
    apart = expected.apart(sun, lamp)
    expect_equal(joint, of_sun + of_world + of_lamp + more * (apart - 1), bias=bias)
    rest, error = mean_of(joint - by_sun - by_world - by_lamp - (more * (apart - 1)))
    assert (np.abs(rest) <= STANDARD_ERRORS * error).all(), (rest, error)


IMAGE_SUN = 0.01  # rad, its radius: seven pixels of the image across
IMAGE_ERROR = 0.002  # of the flux of so few pixels, which Cycles interpolates
# Rad, two of its pixels. So near the sun's rim a mirror shows what they interpolate, which the core
# has not: 6 % of a paint was seen. Further in and further out it is as elsewhere.
IMAGE_RIM = 2 * 2 * math.pi / IMAGE_WIDTH


def at_rim(sun: np.ndarray, mirrored_view: np.ndarray) -> bool:
    return abs(np.linalg.norm(sun - mirrored_view) - IMAGE_SUN) < IMAGE_RIM


@pytest.mark.long
@pytest.mark.parametrize("k", range(len(PAINTS)))
def test_the_mean_under_an_image_with_a_sun_is_the_cores(k: int) -> None:
    """That of the sun as a light of its own, and that of the rest of the world."""
    paint, rest, strength = PAINTS[k], 0.5, 3.0
    probe = scene_with(paint, PIXELS, elevation=ELEVATIONS[k], width=WIDTH)
    scene, view = probe.scene, view_of(probe)
    random, lit = seeds.fresh(400 + k), None
    while lit is None or lit[2] < 0.2 or at_rim(lit, view * [-1, -1, 1]):
        lit = mirrored(paint, view, paint.tilt * random.uniform(0, 1), random)
    radiance = rest + strength / (math.pi * IMAGE_SUN**2)
    image = disc(lit, IMAGE_SUN, radiance, rest)
    world_of(image)
    irradiance = float(((image - rest) * solid_angles()).sum())
    needs.fit(scene)
    [slot] = core_lights()
    assert slot.kind == core.LightKind.sky
    expected = Expected(paint, view)
    pixel_m2 = show_pixels_of(expected.pixel_of(slot, PIXELS**2), view)
    needs.fit(scene)
    of_sun = irradiance * expected.listed(slot, pixel_m2)
    whole = of_sun + expected.world(rest)
    scene.cycles.samples = samples_for(probe, LAMP_ERROR)
    bias = LAMP_BIAS * whole + IMAGE_ERROR * of_sun
    expect_equal(verify.render(scene), whole, bias=bias)


# --- its parts ---------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.parametrize("k", [3, 11, 19])
def test_under_a_world_of_one_radiance_the_flakes_show_their_albedo(k: int) -> None:
    probe = scene_with(PAINTS[k], elevation=ELEVATIONS[k])
    add_world(1.0)
    expected = albedo(PAINTS[k], view_of(probe))
    expect_equal(probe.image(verify.LOBE), expected, bias=QUADRATURE * expected)


@pytest.mark.long
@pytest.mark.parametrize("k", range(len(PAINTS)))
def test_a_smooth_lobe_beside_random_flakes_keeps_the_light_under_a_world(k: int) -> None:
    probe = scene_with(PAINTS[k], elevation=ELEVATIONS[k])
    add_world(1.0)
    lights.show_other_light(True)
    expected, error = mean_of(probe.picture())
    lights.show_other_light(True, uneven=True)
    # Where a lobe shows light that no flake is likely to, nothing takes it back: up to 0.6 % of the
    # paint was seen, where tilts are above 0.3.
    expect_equal(probe.picture(), expected, bias=0.01 * expected + STANDARD_ERRORS * error)


# --- its noise ---------------------------------------------------------------------------------


def stage(*lamps: tuple[tuple[float, float, float], float]) -> None:
    """Square lamps, by place and size, that face a ball in the middle of the picture."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    material.set_up_cycles(scene)
    verify.make_noiseless(scene)
    scene.render.resolution_x = scene.render.resolution_y = 64
    scene.render.use_persistent_data = True  # a seed compiles nothing
    for place, size in lamps:
        add_area_light(np.array(place) / 1.5, size)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.lens = 85
    camera.location = (0, -0.7, 0.15)
    camera.rotation_euler = camera.location.to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera


def pictures_of_seeds(samples: int, count: int) -> np.ndarray:
    """Grey."""
    scene = bpy.context.scene
    scene.cycles.samples = samples
    pictures = []
    for seed in range(count):
        scene.cycles.seed = seed
        pictures.append(verify.render(scene).mean(axis=2))
    return np.array(pictures)


def pictures_of_ball(surface: bpy.types.Material, count: int = 6) -> np.ndarray:
    """Grey, at 16 samples, of so many seeds."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.075)
    ball = bpy.context.object
    bpy.ops.object.shade_smooth()
    ball.data.materials.append(surface)
    scene = bpy.context.scene
    needs.fit(scene)
    pictures = pictures_of_seeds(16, count)
    bpy.data.objects.remove(ball)
    return pictures


def noise_on_ball(surface: bpy.types.Material) -> float:
    """What seeds change, over the mean."""
    pictures = pictures_of_ball(surface)
    return float(np.sqrt(np.var(pictures, axis=0, ddof=1).mean()) / pictures.mean())


def calm(preset: str) -> bpy.types.Material:
    return material.create(dataclasses.replace(presets.load(preset), sparkle_contrast=0))


@pytest.mark.long
def test_under_softboxes_it_is_little_noisier_than_a_coated_metal() -> None:
    stage(((0.5, -0.4, 0.4), 0.5), ((-0.6, -0.2, 0.3), 0.4))
    metal = noise_on_ball(bench_materials.principled())
    for name in ("silver-fine", "white-pearl"):
        # 1.2 and 0.5 were measured; with random flakes alone 3.6 and 1.2.
        assert noise_on_ball(calm(name)) < 1.5 * metal


def noise_on_panel(surface: bpy.types.Material, elevation: float) -> float:
    """What seeds change, over the mean: of a flat panel under a softbox beyond it, seen from so
    many degrees above it."""
    bpy.ops.mesh.primitive_plane_add(size=4)
    bpy.context.object.data.materials.append(surface)
    softbox = add_area_light(np.array((0, 2.4, 1.8)), 4.5)
    softbox.data.shape, softbox.data.size_y = "RECTANGLE", 1.6
    softbox.rotation_euler = (0, 0, 0)
    scene = bpy.context.scene
    camera, angle = scene.camera, math.radians(elevation)
    camera.location = (0, -6 * math.cos(angle), 6 * math.sin(angle))
    camera.rotation_euler = (math.pi / 2 - angle, 0, 0)
    camera.data.angle = math.radians(1.2)
    scene.render.resolution_x = scene.render.resolution_y = 24
    needs.fit(scene)
    pictures = pictures_of_seeds(24, 4)
    return float(np.median(np.std(pictures, axis=0, ddof=1)) / np.mean(pictures))


@pytest.mark.parametrize("elevation", first_of([10, 4, 18, 35]))
def test_a_softbox_seen_low_is_no_dirtier_than_on_a_coated_metal(elevation: float) -> None:
    stage()
    metal = noise_on_panel(bench_materials.principled(), elevation)
    for name in ("silver-fine", "deep-blue"):
        stage()
        # 0.6 to 0.9 were measured; without lobes there 10 to 31 at 4 and 10 degrees.
        assert noise_on_panel(calm(name), elevation) < 1.5 * metal


@pytest.mark.long
def test_pixels_without_sparkles_show_a_softbox_as_well() -> None:
    stage(((0.5, -0.4, 0.4), 0.5))
    # It is listed, hence may be shown by sparkles alone, and is too dark to be seen itself.
    add_sun("Sun", np.array([0.2, -0.7, 0.7])).data.energy = 1e-6
    lively, quiet = (
        pictures_of_ball(surface, 20)
        for surface in (material.create(presets.load("silver-coarse")), calm("silver-coarse"))
    )
    noise, quiet_noise = (np.sqrt(np.var(each, axis=0, ddof=1).mean()) for each in (lively, quiet))
    # 2.2 was measured; 3.3 where the lobes are lowered instead of leaning away from the sun.
    assert noise < 2.7 * quiet_noise
    light, quiet_light = (each.sum(axis=(1, 2)) for each in (lively, quiet))
    error = math.hypot(light.std(ddof=1), quiet_light.std(ddof=1)) / math.sqrt(len(light))
    # Leaning lobes show light at their own horizon, where no flakes are: 0.7 % of theirs in 95 %.
    bias = 0.01 * quiet_light.mean()
    assert abs(light.mean() - quiet_light.mean()) < bias + STANDARD_ERRORS * error


NEAR = (0.08, -0.22, 0.21), 0.1


@pytest.mark.long
def test_the_coats_image_of_a_lamp_near_by_is_found_by_few_samples() -> None:
    stage(NEAR)
    # 0.37 was measured; where rays meet the image as seldom as the coat is dim, 1.1.
    assert noise_on_ball(calm("candy-red")) < 0.7 * noise_on_ball(bench_materials.principled())


@pytest.mark.long
def test_the_coats_image_of_a_lamp_keeps_its_light() -> None:
    stage(NEAR)
    paint = calm("candy-red")
    found = []
    for _ in range(2):
        found.append(pictures_of_ball(paint, 40).sum(axis=(1, 2)))
        # Now a mirror shows the image, as rays may not meet every lamp.
        bpy.data.lights.new("Not met", "AREA").cycles.use_multiple_importance_sampling = False
    lobe, mirror = found
    assert mirror.std() > 2 * lobe.std()  # it does make a difference
    error = math.hypot(lobe.std(), mirror.std()) / math.sqrt(len(lobe))
    assert abs(lobe.mean() - mirror.mean()) < STANDARD_ERRORS * error
    assert error < 0.003 * mirror.mean()


@pytest.mark.long
@pytest.mark.parametrize("k", range(2, len(PAINTS), 4))
def test_what_is_scattered_several_times_is_the_cores(k: int) -> None:
    paint = PAINTS[k]
    probe = scene_with(paint, elevation=ELEVATIONS[k])
    expected = core.mixture(core_paint(paint), paint.substrate_color, view_of(probe)[2])
    probe.scene.cycles.samples = 1
    inner = {
        "diffuse": verify.DIFFUSE, "glossy": verify.GLOSSY, "returned": verify.RETURNED,
        "alpha": verify.ROUGHNESS,
    }  # fmt: skip
    for name, diagnostic in inner.items():
        shown = probe.image(diagnostic).reshape(-1, 3)
        wanted = np.broadcast_to(expected[name], shown.shape)
        # Rounding in float, which core/mixture.h's test holds to 2e-5, and of the view.
        np.testing.assert_allclose(shown, wanted, rtol=0, atol=1e-4)


@pytest.mark.long
def test_no_listed_light_is_seen_in_the_lobe() -> None:
    lamps = (
        scenes.sun("Sun", 60, 110, 5.0),
        scenes.lamp("Point", "POINT", (0.5, 0.4, 0.9), 0.2),
    )
    probe = scene_with(Paint(), lamps=lamps)
    for lamp in bpy.data.lights:
        lamp.cycles.use_multiple_importance_sampling = True
    assert probe.image(verify.SPARKLES).max() > 0
    assert probe.image(verify.LOBE).max() == 0


@pytest.mark.long
def test_a_light_beyond_the_slots_lights_the_mean() -> None:
    paint = Paint(tilt=0.3)
    probe = scene_with(paint, elevation=60)
    probe.scene.cycles.samples = 1024  # most of the cones miss so small a light
    view = view_of(probe)
    # No lights.fill: it stays out of the slots.
    sun = add_sun("Unlisted", np.array([0.0, -math.cos(1.22), math.sin(1.22)]))
    light = towards(sun)
    f = flake_brdf(paint, view, light[None])[0]
    expected = f * light[2] * sun.data.energy
    # Wide cones blur what is brighter near the view, where flakes hide one another less.
    expect_equal(probe.image(verify.LOBE), expected, bias=0.007 * expected, noise=0.01)
