# SPDX-License-Identifier: Apache-2.0
"""The shader where verify's scenes do not go: extreme values, other cameras, mirrors, frames."""

from __future__ import annotations

import dataclasses

import bpy
import numpy as np
import pytest
from bench.shared import LINKED, link_to_property, sockets_of
from many_paints import ManyPaints
from metallic_paint import verify
from metallic_paint.paint import Paint, Parameter, material
from verification import scenes

SIZE = 32
SCENE = next(s for s in scenes.SCENES if s.name == "thinned, sphere")


def probe_of(spec: scenes.Scene = SCENE) -> verify.Probe:
    scene = bpy.context.scene
    item = scenes.build(scene, spec, SIZE)
    return verify.Probe(scene, [item.active_material])


def assert_sound(probe: verify.Probe, what: object) -> None:
    """Every inner value finite and not negative, by the shader's own word: Cycles blackens NaN."""
    hit = (probe.image(verify.VIEW) ** 2).sum(axis=-1) > 0.5
    assert hit.any(), what
    assert (probe.image(verify.SOUND)[hit] == 1).all(), what
    lit = probe.image(verify.SPARKLES)
    assert (np.isfinite(lit) & (lit >= 0)).all(), what


DEFAULTS = sockets_of(Paint())
NUMBERS = [each for each in LINKED.values() if not each.choices]
PAINTS = {"one species": SCENE.paint, "three species": scenes.THREE}


def at(value: float, parameter: Parameter) -> float | tuple[float, ...]:
    """The value, for as many numbers as the parameter has."""
    several = isinstance(DEFAULTS[parameter.label], tuple)
    return (value,) * 3 if several else value


@pytest.mark.long
@pytest.mark.parametrize("paint", PAINTS.values(), ids=PAINTS)
def test_values_beyond_their_range_stay_sound(subtests: pytest.Subtests, paint: Paint) -> None:
    """Too small, too large, no number: the least, the most, the default."""
    cases = [(each, value) for each in NUMBERS for value in (-1e30, 1e30, np.nan)]
    many = ManyPaints(
        [sockets_of(paint) | {each.label: at(value, each)} for each, value in cases],
        scenes.SUN,
        size=12,
    )
    sound = many.probe.image(verify.SOUND)
    for i, (each, value) in enumerate(cases):
        with subtests.test(each.label, value=value):
            hit = many.of(i).hit
            assert hit.any()
            assert (sound[hit] == 1).all()


@pytest.mark.long
def test_no_number_is_the_default_and_what_lies_beyond_the_nearest_end(
    subtests: pytest.Subtests,
) -> None:
    """In every input that takes numbers: pixel by pixel as with that value itself."""
    cases = [
        (each.label, at(value, each), wanted)
        for each in NUMBERS
        for value, wanted in (
            (np.nan, DEFAULTS[each.label]),
            (-1e30, at(each.minimum, each)),
            (1e30, at(each.maximum, each)),
        )
    ]
    paint = dataclasses.replace(
        scenes.THREE, third=dataclasses.replace(scenes.THREE.third, orientation="gaussian"),
        orange_peel=0.02, coat_roughness=0.3, texture_contrast=0.1,
        composition="published",  # of which the sparkles compare with the coat's highlight
    )  # fmt: skip
    plain = sockets_of(paint)
    pearls = plain | {"Coating": 9, "Coating 2": 9, "Coating 3": 9}  # which alone have a film
    ggx = plain | {"Orientation": 2}
    bases = {"Coating (nm)": pearls, "Coating (nm) 2": pearls, "Coating (nm) 3": pearls}
    paints = [bases.get(label, plain) for label, *_ in cases]
    cases += [("Tilt", 1e30, 1.0), ("Tilt", np.nan, DEFAULTS["Tilt"])]  # being a roughness
    paints += [ggx, ggx]
    many = ManyPaints(paints, scenes.SUN, size=10)
    spheres = [item for item in many.probe.scene.objects if item.type == "MESH"]
    for polygon in spheres[0].data.polygons:
        polygon.use_smooth = False  # smooth normals may differ in a last bit from render to render

    def pictures(values: list[float | tuple[float, ...]]) -> list[np.ndarray]:
        for sphere, (label, *_), value in zip(spheres, cases, values, strict=True):
            sphere[label] = value
            sphere.update_tag()
        shown = (verify.MEAN_RADIANCE, verify.DIFFUSE, verify.GLOSSY, verify.SPARKLES)
        return [many.probe.image(each) for each in shown]

    before = pictures([plain[label] for label, *_ in cases])
    given = pictures([value for _, value, _ in cases])
    wanted = pictures([value for *_, value in cases])
    seen = set()
    for i, (label, value, _) in enumerate(cases):
        hit = many.of(i).hit
        with subtests.test(label, value=value):
            assert hit.any()
            for one, other in zip(given, wanted, strict=True):
                np.testing.assert_array_equal(one[hit], other[hit])
        if any((one[hit] != other[hit]).any() for one, other in zip(before, given, strict=True)):
            seen.add(label)
    assert seen == {label for label, *_ in cases}


@pytest.mark.long
@pytest.mark.parametrize("value", [-1e30, 1e30, np.nan])
def test_constants_beyond_their_range_stay_sound(value: float) -> None:
    """All at once; without links OSL computes with them while it compiles."""
    probe = probe_of()
    for each in NUMBERS:
        given = at(value, each)
        probe.set(each.label, (*given, 1) if each.is_color else given)
    assert_sound(probe, value)


@pytest.mark.long
def test_a_linked_normal_may_be_any_vector(subtests: pytest.Subtests) -> None:
    """Any length is as good as one; what has no direction is as if there were no link."""
    probe = probe_of()
    hit = (probe.image(verify.VIEW) ** 2).sum(axis=-1) > 0.5
    unlinked = probe.image(verify.NORMAL)[hit]
    [item] = [each for each in probe.scene.objects if each.type == "MESH"]
    for label in (material.NORMAL, material.COAT_NORMAL):
        link_to_property(probe.nodes[0].inputs[label], "normal")
    along = np.array([0.36, -0.48, 0.8])
    for size in (1, 2, 1e-20, 1e30, 0, np.inf, np.nan):
        item["normal"] = (along * size).tolist()
        with subtests.test(size=size):
            expected = along if 0 < size < np.inf else unlinked
            assert np.abs(probe.image(verify.NORMAL)[hit] - expected).max() < 1e-6
            assert (probe.image(verify.SOUND)[hit] == 1).all()


@pytest.mark.long
@pytest.mark.parametrize("orientation", [0, 1, 2, 7, -7])
@pytest.mark.parametrize("tilt", [1e-6, 1.0, 100.0])
def test_every_orientation_is_sound_from_a_spike_to_flat(orientation: int, tilt: float) -> None:
    probe = probe_of()
    probe.set("Orientation", orientation)
    probe.set("Tilt", tilt)
    assert_sound(probe, (orientation, tilt))


@pytest.mark.long
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_paint_does_not_depend_on_the_units_of_the_scene(scale: float) -> None:
    """A scene scaled with its metres per unit shows the same expected count."""
    counts = []
    for factor in (1.0, scale):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        probe = probe_of()
        for item in probe.scene.objects:
            item.location *= factor
            item.scale *= factor
        data = probe.scene.camera.data
        data.clip_start, data.clip_end = 0.01 * factor, 100 * factor
        probe.scene.camera.scale = (1, 1, 1)
        probe.set("Model Scale", 1 / factor)
        counts.append(probe.image(verify.MEAN_COUNT)[..., 0])
    both = (counts[0] > 0) & (counts[1] > 0)
    assert both.mean() > 0.3
    assert np.median(np.abs(counts[1][both] / counts[0][both] - 1)) < 1e-3


@pytest.mark.long
def test_a_panoramic_camera_sees_finite_sparkles() -> None:
    probe = probe_of()
    probe.scene.camera.data.type = "PANO"
    assert probe.image(verify.PIXEL)[..., 0].max() > 0
    assert_sound(probe, "panorama")
    assert probe.image(verify.MEAN_RADIANCE).max() > 0


@pytest.mark.long
def test_paint_seen_in_a_mirror_sparkles() -> None:
    """A mirror beside the sphere shows another side of it."""
    probe = probe_of()
    scene = probe.scene
    scene.camera.data.angle *= 4
    scene.render.resolution_x = scene.render.resolution_y = 128
    bpy.ops.mesh.primitive_plane_add(
        size=1.2, location=(1.0, 0.2, 0), rotation=(np.pi / 2, 0, -np.pi / 4)
    )
    mirror = bpy.data.materials.new("Mirror")
    if mirror.node_tree is None:
        mirror.use_nodes = True
    shader = mirror.node_tree.nodes["Principled BSDF"]
    shader.inputs["Metallic"].default_value, shader.inputs["Roughness"].default_value = 1, 0
    material.assign(bpy.context.object, mirror)
    direct = probe.image(verify.SPARKLES)
    scene.cycles.max_bounces = scene.cycles.glossy_bounces = 2
    reflected = probe.image(verify.SPARKLES)
    assert np.isfinite(reflected).all()
    assert ((reflected.max(axis=-1) > 0) & (direct.max(axis=-1) == 0)).sum() > 3


@pytest.mark.long
def test_a_frame_draws_anew_and_a_seed_too() -> None:
    probe = probe_of()
    first = probe.image(verify.COUNT)
    np.testing.assert_array_equal(probe.image(verify.COUNT), first)
    for socket in ("Frame", "Seed"):
        probe.set(socket, 12)
        assert (probe.image(verify.COUNT) != first).any()
        probe.set(socket, scenes.CANDY.seed if socket == "Seed" else 0)
    np.testing.assert_array_equal(probe.image(verify.COUNT), first)


@pytest.mark.long
def test_a_border_render_shows_the_sparkles_of_the_frame() -> None:
    probe = probe_of()
    whole = probe.image(verify.COUNT)
    render = probe.scene.render
    render.use_border, render.use_crop_to_border = True, False
    render.border_min_x, render.border_max_x = 0.25, 0.75
    render.border_min_y, render.border_max_y = 0.25, 0.75
    part = probe.image(verify.COUNT)
    inner = slice(SIZE // 4, 3 * SIZE // 4)
    np.testing.assert_array_equal(part[inner, inner], whole[inner, inner])


def test_the_paint_holds_no_emission() -> None:
    """Cycles takes every mesh for a lamp whose shader holds the closure."""
    probe = probe_of()
    group = probe.nodes[0].node_tree
    script = next(node for node in group.nodes if node.type == "SCRIPT")
    assert '"emission"' not in script.bytecode


def test_paint_has_a_highlight_and_a_substrate() -> None:
    spec = SCENE
    dark = Paint(substrate_color=(0, 0, 0), flakes_per_mm2=0)
    light = Paint(substrate_color=(0.8, 0.1, 0.1), flakes_per_mm2=0)
    pictures = []
    for paint in (dark, light):
        probe = probe_of()
        material.apply(probe.materials[0], paint)
        pictures.append(probe.picture())
        bpy.ops.wm.read_factory_settings(use_empty=True)
    assert spec.paint is not None
    assert pictures[0].max() < 1e-3
    red, green = pictures[1][..., 0].mean(), pictures[1][..., 1].mean()
    assert red > 5 * green > 0
