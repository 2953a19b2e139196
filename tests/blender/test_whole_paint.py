# SPDX-License-Identifier: Apache-2.0
"""The paint with all its parts: energy, composition, highlight, substrate, texture."""

from __future__ import annotations

import dataclasses

import bpy
import metallic_paint_core as core
import numpy as np
import pytest
from gate import first_of
from measure import goniophotometer
from metallic_paint import verify
from metallic_paint.native import core_lights
from metallic_paint.paint import Flakes, Paint, core_paint, material, presets
from metallic_paint.scene import lights, needs
from verification import scenes

SIZE = 64
WHITE = (1.0, 1.0, 1.0)
SPHERE = scenes.Scene(
    "whole paint", (), shape="sphere", orthographic=True, width=0.28, scale=(0.15, 0.15, 0.15)
)

PLANE = dataclasses.replace(SPHERE, shape="plane", width=0.04, scale=(1, 1, 1), elevation=80)


def probe_of(spec: scenes.Scene) -> verify.Probe:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    item = scenes.build(bpy.context.scene, spec, SIZE)
    return verify.Probe(bpy.context.scene, [item.active_material])


def white_world() -> bpy.types.ShaderNodeTree:
    world = bpy.data.worlds.new("World")
    if world.node_tree is None:
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    bpy.context.scene.world = world
    return world.node_tree


# --- energy ------------------------------------------------------------------------------------

METAL = Paint(flake_color=WHITE, flake_edge_color=WHITE, substrate_color=WHITE, flakes_per_mm2=2000)
LOSSLESS = {
    "metal over white": METAL,
    "few flakes": dataclasses.replace(METAL, flakes_per_mm2=300, tilt=0.3),
    "many": dataclasses.replace(METAL, flakes_per_mm2=12_000, tilt=0.08, coat_roughness=0.1),
    "a rough coat": dataclasses.replace(METAL, coat_roughness=0.5),
    "a matt coat": dataclasses.replace(METAL, coat_roughness=1.0, binder_ior=1.7),
    "orange peel": dataclasses.replace(METAL, orange_peel=0.12),
    "wide GGX": dataclasses.replace(METAL, orientation="ggx", tilt=0.5, binder_ior=1.7),
    "flakes that let light through": dataclasses.replace(
        METAL, flake_color=(0.3, 0.5, 0.7), flake_edge_color=(0.3, 0.5, 0.7),
        flake_transmission=(0.7, 0.5, 0.3), rayleigh_per_mm=0.5,
    ),
    "pearl": dataclasses.replace(METAL, coating="tio2-on-mica", coating_nm=115),
    "a flip pearl and metal": dataclasses.replace(
        METAL, coating="tio2-on-thin-silica", coating_nm=70,
        second=Flakes(flakes_per_mm2=500, flake_color=WHITE, flake_edge_color=WHITE, tilt=0.3),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", first_of(LOSSLESS))
def test_a_lossless_paint_vanishes_in_a_white_world(name: str) -> None:
    """On a plane from above, aslant and grazing."""
    for elevation in (85, 45, 17):
        probe = probe_of(dataclasses.replace(PLANE, paint=LOSSLESS[name], elevation=elevation))
        white_world()
        probe.scene.cycles.max_bounces, probe.scene.cycles.samples = 1, 64
        picture = probe.picture().reshape(-1, 3)
        error = picture.std(axis=0) / np.sqrt(len(picture))
        assert (error < 0.002).all(), error
        off = np.abs(picture.mean(axis=0) - 1)
        assert (off < 0.01 + 3 * error).all(), (elevation, picture.mean(axis=0))


# --- flop --------------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.parametrize("name", ["silver-fine", "candy-red", "copper"])
def test_the_flop_is_that_of_the_random_walk(name: str) -> None:
    """Lightness under a sun at 45 degrees, so far away that no flake shows.

    The walk takes the ways to observer and light for independent.
    """
    paint = dataclasses.replace(presets.load(name), depth_model="attenuated")
    angles = (15, 25, 45, 75, 110)
    found = []
    for aspecular in angles:
        # Beyond the normal, the camera is on the sun's side.
        beyond = aspecular > 45
        lamps = (scenes.sun("Sun", 45, -90 if beyond else 90),)
        elevation = 135 - aspecular if beyond else 45 + aspecular
        probe = probe_of(
            dataclasses.replace(PLANE, paint=paint, lamps=lamps, elevation=elevation, width=1)
        )
        needs.fit(probe.scene)
        probe.scene.cycles.samples = 4
        irradiance = bpy.data.lights["Sun"].energy * np.sin(np.radians(45))
        found.append(np.pi * probe.picture().reshape(-1, 3).mean(axis=0) / irradiance)
    detectors = [goniophotometer.direction(np.radians(45 - a)) for a in angles]
    walk = core.random_walk(
        core_paint(paint), goniophotometer.direction(-np.radians(45)), detectors=detectors,
        substrate=paint.substrate_color, photons=400_000,
    )  # fmt: skip
    lightness = goniophotometer.lab(np.array(found))[:, 0]
    wanted = goniophotometer.lab(np.pi * walk["brdf"])[:, 0]
    # Of silver-fine at 110 degrees it is 5; a Lambertian lobe alone would be 24 off.
    np.testing.assert_allclose(lightness, wanted, rtol=0, atol=6)


@pytest.mark.long
@pytest.mark.parametrize("elevation", [60, 20, 9, 6, 4])
def test_a_sun_at_any_slant_lights_the_substrate_as_the_core_says(elevation: float) -> None:
    """At 6 degrees on the slope of diffuse_toon; a binder with a colour of its own."""
    paint = Paint(flakes_per_mm2=0, binder_ior=1.6, binder_absorption_per_mm=(0, 3, 30))
    lamps = (scenes.sun("Sun", elevation, 30, 0),)
    probe = probe_of(dataclasses.replace(PLANE, paint=paint, lamps=lamps, elevation=50))
    needs.fit(probe.scene)
    picture = probe.picture()
    geometry = probe.geometry()
    shade = core.shade(core_paint(paint), core_lights(), **geometry.places())
    wanted = bpy.data.lights["Sun"].energy * shade["radiance"][:, 0]
    np.testing.assert_allclose(picture[geometry.hit], wanted, rtol=1e-4)


@pytest.mark.long
@pytest.mark.parametrize("view", [(50, 30), (70, -60), (20, 20)])
def test_a_sun_sees_the_substrate_by_the_holes_it_comes_by_as_the_core_says(view: tuple) -> None:
    """Black flakes: what is seen is the substrate. The camera looks from an azimuth of 0."""
    paint = Paint(
        flakes_per_mm2=3000, flake_diameter_um=20, flake_color=(0, 0, 0),
        flake_edge_color=(0, 0, 0), substrate_color=(0.9, 0.5, 0.2),
    )  # fmt: skip
    elevation, azimuth = view
    lamps = (scenes.sun("Sun", 45, azimuth, 0),)
    probe = probe_of(dataclasses.replace(PLANE, paint=paint, lamps=lamps, elevation=elevation))
    needs.fit(probe.scene)
    picture, geometry = probe.picture(), probe.geometry()
    shade = core.shade(core_paint(paint), core_lights(), **geometry.places())
    assert shade["returned"].min() > 1e-3
    wanted = bpy.data.lights["Sun"].energy * shade["radiance"][:, 0]
    np.testing.assert_allclose(picture[geometry.hit], wanted, rtol=1e-4)


@pytest.mark.long
@pytest.mark.parametrize("view", [(50, 150), (25, 150), (20, 60)])
def test_a_sun_shines_on_what_flakes_mirror_often_as_the_core_says(view: tuple) -> None:
    """Over black, beside the highlight, where no single flake sparkles."""
    paint = Paint(
        flakes_per_mm2=8000, flake_diameter_um=20, flake_color=(0.95, 0.9, 0.8), tilt=0.1,
        orientation="gaussian", substrate_color=(0, 0, 0),
    )  # fmt: skip
    elevation, azimuth = view
    lamps = (scenes.sun("Sun", 80 if elevation > 30 else 12, azimuth, 0),)
    probe = probe_of(dataclasses.replace(PLANE, paint=paint, lamps=lamps, elevation=elevation))
    needs.fit(probe.scene)
    probe.set("Sparkle Contrast", 0)
    picture, geometry = probe.picture(), probe.geometry()
    smooth = dataclasses.replace(paint, sparkle_contrast=0)
    shade = core.shade(core_paint(smooth), core_lights(), **geometry.places())
    assert shade["glossy"].min() > 0.02
    wanted = bpy.data.lights["Sun"].energy * shade["radiance"][:, 0]
    np.testing.assert_allclose(picture[geometry.hit], wanted, rtol=3e-4)


# --- composition -------------------------------------------------------------------------------

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
LIT = dataclasses.replace(
    SPHERE,
    lamps=(scenes.lamp("Point", "POINT", (-0.3, -0.6, 0.7)),),
    paint=Paint(substrate_color=(0.6, 0.4, 0.3), flakes_per_mm2=250, coat_roughness=0.5, tilt=0.3),
)
# Near enough for single sparkles, and the lamp where the plane's middle mirrors it.
NEAR = dataclasses.replace(
    LIT, shape="plane", scale=(1, 1, 1), width=0.03, elevation=50,
    lamps=(scenes.lamp("Point", "POINT", (-0.06, 0.39, 0.46)),),
    # Of an index at which rough facets neither hide the sparkles nor outshine them.
    paint=dataclasses.replace(LIT.paint, binder_ior=1.1),
)  # fmt: skip


@pytest.mark.parametrize("composition", first_of(["exact", "published"]))
def test_a_pixel_shows_the_sum_or_the_greater_of_sparkles_and_the_rest(composition: str) -> None:
    """The rest is what the same paint shows where its slots are empty, so that nothing sparkles."""
    # Whole pixels sparkle or do not: of cells, the mean of a pixel would hide which.
    paint = dataclasses.replace(NEAR.paint, anchor="pixel")
    probe = probe_of(dataclasses.replace(NEAR, paint=paint))
    probe.scene.cycles.pixel_filter_type = "BOX"
    lights.show_other_light(False)  # or, without its slot, the flakes would show the lamp's mean
    sparkles = probe.image(verify.SPARKLES) @ LUMINANCE  # whole, as they are with "exact"

    def shown(name: str) -> np.ndarray:
        probe.set("Composition", ("exact", "published").index(name))
        return probe.picture() @ LUMINANCE

    added, found = shown("exact"), shown(composition)
    lights._build(lights.node_group(), [], [])
    rest, alone = shown(composition), shown("exact")
    # A rough coat lets a little more of them out than the smooth one that they are drawn for, of
    # this plane everywhere as much.
    bright = sparkles > alone
    more = float(np.median((added - alone)[bright] / sparkles[bright]))
    assert 1 < more < 1.02
    sparkles = sparkles * more
    # Both kinds of pixel are there, also within the highlight.
    highlight = rest > np.quantile(rest, 0.8)
    for where in (highlight, ~highlight & (rest > 0)):
        assert ((sparkles > rest) & where).sum() > 10
    assert ((sparkles < rest) & (rest > 0)).sum() > 10
    wanted = sparkles + rest if composition == "exact" else np.maximum(sparkles, rest)
    # Published, the shader takes the highlight from its own formula: 1e-4 off Cycles' at most.
    rounding = 1e-5 if composition == "exact" else 2e-3
    np.testing.assert_allclose(found, wanted, rtol=rounding)
    # No sparkle is darker than what is around it would be without.
    assert (found >= rest * (1 - rounding)).all()


# --- highlight ---------------------------------------------------------------------------------

CONE_MARGIN = 1e-3  # of osl/cones.h
MIRROR = Paint(flakes_per_mm2=0, substrate_color=(0, 0, 0), binder_ior=3)


def mirrored_directions(probe: verify.Probe) -> np.ndarray:
    """(h, w, 3): where each pixel's mirror looks, by a world whose radiance is its direction."""
    tree = white_world()
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    half = tree.nodes.new("ShaderNodeVectorMath")
    half.operation = "MULTIPLY_ADD"
    half.inputs[1].default_value = half.inputs[2].default_value = (0.5, 0.5, 0.5)
    tree.links.new(coordinates.outputs["Generated"], half.inputs[0])
    tree.links.new(half.outputs[0], tree.nodes["Background"].inputs["Color"])
    probe.scene.cycles.max_bounces = 1
    picture = probe.picture()
    # Twice a radiance less its own constant: the length of a direction is 1.
    tree.links.remove(tree.nodes["Background"].inputs["Color"].links[0])
    reflectance = probe.picture()
    return 2 * picture / reflectance - 1


@pytest.mark.long
@pytest.mark.parametrize("hit", [False, True], ids=["lamp only sampled", "lamp hit by rays too"])
def test_a_smooth_coat_mirrors_a_listed_light_once(hit: bool) -> None:
    """Its disc, in each sample: what lamp sampling finds, and no ray that hits the lamp besides."""
    probe = probe_of(
        dataclasses.replace(SPHERE, lamps=(scenes.sun("Sun", 60, 110, 40),), paint=MIRROR)
    )
    sun = bpy.data.objects["Sun"].data
    sun.cycles.use_multiple_importance_sampling = hit
    probe.scene.cycles.max_bounces = 1  # or no ray that the coat mirrors would meet the lamp
    picture = probe.picture()
    geometry = probe.geometry()
    shade = core.shade(core_paint(MIRROR), core_lights(), **geometry.places())
    # Cycles gives each direction of the disc the same share; energy weighs them by the cosine.
    irradiance = sun.energy * 2 / (1 + np.cos(sun.angle / 2))
    wanted = np.zeros(picture.shape)
    wanted[geometry.hit] = shade["shine"][:, 0, np.newaxis] * irradiance
    disc = wanted.max(axis=-1) > 0
    assert disc.sum() > 20
    edge = (picture.max(axis=-1) > 0) != disc  # where rounding decides
    assert edge.sum() <= 1
    if not hit:
        np.testing.assert_allclose(picture[~edge], wanted[~edge], rtol=1e-3)
        return
    # A ray into the cone's rim misses the lamp, and then half of its light: of such rays the share
    # q is expected.
    q = 1 - (1 + CONE_MARGIN / (sun.angle / 2)) ** -2
    mean = (picture[disc & ~edge] / wanted[disc & ~edge]).mean()
    assert mean == pytest.approx(1, abs=4 * np.sqrt(q / disc.sum()) / 2)


@pytest.mark.long
@pytest.mark.parametrize("slope", [0.01, 0.05])
@pytest.mark.parametrize("scale", [(1, 1, 1), (8, 1, 0.5)], ids=["even scale", "uneven scale"])
def test_orange_peel_tilts_the_mirror_by_its_slope(slope: float, scale: tuple) -> None:
    paint = dataclasses.replace(MIRROR, orange_peel=slope, orange_peel_mm=1.5)
    probe = probe_of(dataclasses.replace(PLANE, paint=paint, scale=scale))
    mirrored = mirrored_directions(probe)
    view = probe.geometry().view
    normal = mirrored + view
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    slopes = normal[..., :2] / normal[..., 2:]
    # 27 x 27 waves: their mean square is known to some 4 %.
    assert np.sqrt((slopes**2).sum(axis=-1).mean()) == pytest.approx(slope, rel=0.15)
    np.testing.assert_allclose(slopes.mean(axis=(0, 1)), 0, atol=slope / 8)
    # Neighbours 0.4 wavelengths apart look alike, pixels 4 wavelengths apart do not. Upwards, where
    # the plane is seen aslant, neighbours lie farther apart by a third.
    for each, alike in ((slopes, 0.3), (slopes.swapaxes(0, 1), 0.15)):
        near = (each[:, :-1] * each[:, 1:]).mean() / (each**2).mean()
        far = (each[:, :-10] * each[:, 10:]).mean() / (each**2).mean()
        assert near > alike
        assert abs(far) < 0.2


@pytest.mark.long
def test_a_coat_normal_turns_the_highlight_and_not_the_flakes() -> None:
    spec = dataclasses.replace(LIT, paint=dataclasses.replace(LIT.paint, coat_roughness=0.3))
    probe = probe_of(spec)
    whole, sparkles = probe.picture(), probe.image(verify.SPARKLES)
    tree = probe.materials[0].node_tree
    geometry = tree.nodes.new("ShaderNodeNewGeometry")
    add = tree.nodes.new("ShaderNodeVectorMath")
    add.inputs[1].default_value = (0.5, 0, 0)
    tree.links.new(geometry.outputs["Normal"], add.inputs[0])
    normalize = tree.nodes.new("ShaderNodeVectorMath")
    normalize.operation = "NORMALIZE"
    tree.links.new(add.outputs[0], normalize.inputs[0])
    tree.links.new(normalize.outputs[0], probe.nodes[0].inputs[material.COAT_NORMAL])
    np.testing.assert_array_equal(probe.image(verify.SPARKLES), sparkles)
    moved = probe.picture() - sparkles

    def column(image: np.ndarray) -> float:
        bright = image.sum(axis=-1) > 0.7 * image.sum(axis=-1).max()
        return float(np.nonzero(bright)[1].mean())

    assert column(moved) < column(whole - sparkles) - SIZE / 16


# --- substrate and texture ---------------------------------------------------------------------


@pytest.mark.long
def test_a_texture_can_drive_the_substrate() -> None:
    paint = dataclasses.replace(LIT.paint, flakes_per_mm2=0, binder_ior=1)
    probe = probe_of(dataclasses.replace(LIT, paint=paint))
    image = bpy.data.images.new("Halves", 2, 1, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels[:] = (0.8, 0.1, 0.1, 1, 0.1, 0.1, 0.8, 1)
    tree = probe.materials[0].node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image, texture.interpolation = image, "Closest"
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Window"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], probe.nodes[0].inputs["Substrate Color"])
    albedo = probe.image(verify.DIFFUSE)
    middle = SIZE // 2
    np.testing.assert_allclose(albedo[middle, middle - 8], (0.8, 0.1, 0.1), atol=1e-3)
    np.testing.assert_allclose(albedo[middle, middle + 8], (0.1, 0.1, 0.8), atol=1e-3)


@pytest.mark.long
def test_texture_makes_the_diffuse_light_uneven_and_keeps_its_mean() -> None:
    paint = dataclasses.replace(LIT.paint, texture_contrast=0.05, anchor="pixel")
    plane = dataclasses.replace(PLANE, lamps=LIT.lamps, width=0.05, elevation=50, paint=paint)
    probe = probe_of(plane)
    factor = probe.image(verify.TEXTURE)[..., 0]
    side_mm = 50 / SIZE
    deviation = 0.05 / side_mm / np.sqrt(np.sin(np.radians(plane.elevation)) ** -1)
    # 4096 pixels: the deviation is known to 1.1 %, the mean to deviation/64.
    assert factor.std() == pytest.approx(deviation, rel=0.06)
    assert factor.mean() == pytest.approx(1, abs=4 * deviation / SIZE)
    probe.set("Texture Contrast", 0.0)
    even = probe.image(verify.DIFFUSE)
    probe.set("Texture Contrast", 0.05)
    np.testing.assert_allclose(probe.image(verify.DIFFUSE), even * factor[..., None], rtol=1e-5)
