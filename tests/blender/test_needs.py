# SPDX-License-Identifier: Apache-2.0
"""What a scene requires of the paint, and that what is left out is not missed in the picture."""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import numpy as np
import pytest
from metallic_paint import verify
from metallic_paint.paint import Paint, material
from metallic_paint.scene import lights, needs
from scenery import add_lamp, show_as_instance
from verification import scenes

STANDARD_ERRORS = 4.0  # two-sided: passed by chance once in 16,000
SIZE = 48


def add_sun(name: str = "Sun", **values: object) -> bpy.types.Object:
    return add_lamp("SUN", name, **values)


def add_mesh(corners: list, faces: list, name: str = "Mesh") -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], faces)
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def paint(thing: bpy.types.Object) -> bpy.types.Object:
    material.assign(thing, material.create(Paint()))
    return thing


def add_quad(name: str = "Quad") -> bpy.types.Object:
    return add_mesh([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [range(4)], name)


def add_ball(**values: object) -> bpy.types.Object:
    bpy.ops.mesh.primitive_uv_sphere_add(**values)
    return bpy.context.object


@pytest.fixture
def ball() -> bpy.types.Object:
    """A painted ball of radius 1 about the origin, the whole scene; light does not bounce."""
    bpy.context.scene.cycles.max_bounces = 0
    return paint(add_ball(segments=32, ring_count=16))


def fit() -> needs.Needs:
    return needs.fit(bpy.context.scene)


def other() -> tuple[str, ...]:
    return fit().other_light


def socket() -> float:
    """What reaches the shader."""
    return lights.constant(lights.OTHER_LIGHT)


def new_world(**inputs: object) -> bpy.types.World:
    world = bpy.data.worlds.new("World")
    if world.node_tree is None:
        world.use_nodes = True
    for name, value in inputs.items():
        world.node_tree.nodes["Background"].inputs[name].default_value = value
    bpy.context.scene.world = world
    return world


def emitting(**inputs: object) -> bpy.types.Material:
    made = bpy.data.materials.new("Emitting")
    if made.node_tree is None:
        made.use_nodes = True
    node = made.node_tree.nodes.new("ShaderNodeEmission")
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    return made


# --- alone under suns -------------------------------------------------------------------------


def test_under_suns_without_bounces_it_needs_no_other_light(ball: bpy.types.Object) -> None:
    add_sun()
    assert other() == ()
    assert socket() == 0


def test_filling_the_lights_alone_leaves_other_light_as_it_is(ball: bpy.types.Object) -> None:
    lights.fill(bpy.context.scene)
    assert socket() == 1
    fit()
    lights.fill(bpy.context.scene)
    assert socket() == 0


def test_it_is_right_again_after_lights_come_and_go(ball: bpy.types.Object) -> None:
    lamp = add_lamp("AREA", "Softbox", location=(0, 0, 5), spread=1)
    assert other() == ("lights without a slot",)
    assert socket() == 3
    lamp.data.cycles.use_multiple_importance_sampling = False
    assert not needs.is_fitted(bpy.context.scene)
    fit()
    assert socket() == 2  # rays do not meet it
    bpy.data.objects.remove(lamp)
    assert other() == ()
    assert socket() == 0


def test_a_world_that_no_view_layer_shows_lights_nothing(ball: bpy.types.Object) -> None:
    new_world(Color=(1, 1, 1, 1))
    assert other() == ("the world",)
    bpy.context.view_layer.use_sky = False
    assert not needs.is_fitted(bpy.context.scene)
    assert other() == ()


def test_a_background_set_may_shine(ball: bpy.types.Object) -> None:
    add_sun()
    assert other() == ()
    bpy.context.scene.background_set = bpy.data.scenes.new("Stage")
    assert not needs.is_fitted(bpy.context.scene)
    assert other() == ("the background set",)
    assert socket() == 3


def test_without_a_painted_object_nothing_is_left_out() -> None:
    add_quad()
    material.create(Paint())  # which no object has
    assert "no object is painted" in other()[0]


# --- the world --------------------------------------------------------------------------------

BLACK, GREY = (0, 0, 0, 1), (0.1, 0, 0, 1)


@pytest.mark.parametrize(
    ("inputs", "shines"),
    [
        ({"Color": BLACK, "Strength": 1}, False),
        ({"Color": GREY, "Strength": 0}, False),
        ({"Color": GREY, "Strength": 1e-6}, True),
    ],
)
def test_a_black_world_is_none(ball: object, inputs: dict[str, object], shines: bool) -> None:
    new_world(**inputs)
    assert other() == (("the world",) if shines else ())


def test_a_world_whose_surface_is_unlinked_is_none(ball: object) -> None:
    tree = new_world(Color=GREY, Strength=1).node_tree
    tree.links.clear()
    assert other() == ()


@pytest.mark.parametrize("input_name", ["Color", "Strength"])
def test_a_world_fed_by_nodes_may_shine(ball: object, input_name: str) -> None:
    tree = new_world(Color=GREY, Strength=1).node_tree
    value = tree.nodes.new("ShaderNodeValue")
    tree.links.new(value.outputs[0], tree.nodes["Background"].inputs[input_name])
    assert other() == ("the world",)


def test_under_a_world_that_may_be_uneven_a_lobe_calms_the_flakes(ball: object) -> None:
    tree = new_world(Color=GREY, Strength=1).node_tree
    fit()
    assert socket() == 1
    image = tree.nodes.new("ShaderNodeTexEnvironment")
    tree.links.new(image.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    assert not needs.is_fitted(bpy.context.scene)
    fit()
    assert socket() == 3


def test_an_animated_world_may_shine(ball: object) -> None:
    background = new_world(Color=GREY, Strength=0).node_tree.nodes["Background"]
    background.inputs["Strength"].keyframe_insert("default_value", frame=1)
    assert other() == ("the world",)


def test_a_volume_in_the_world_may_shine(ball: object) -> None:
    tree = new_world(Color=BLACK, Strength=0).node_tree
    scatter = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(scatter.outputs[0], tree.nodes["World Output"].inputs["Volume"])
    assert other() == ("the world",)


# --- lights without a slot --------------------------------------------------------------------


def test_lights_beyond_the_slots_light_the_mean(ball: object) -> None:
    for i in range(16):
        add_sun(f"Sun {i}")
    found = fit()
    assert found.other_light == ("lights without a slot",)
    assert "16 lights: 8 sparkle, 8 light the mean." in str(found)


def test_an_instanced_light_without_a_slot_lights_the_mean(ball: object) -> None:
    show_as_instance(add_lamp("AREA", "Lamp", location=(0, 0, 5), spread=1))
    found = fit()
    assert "lights without a slot" in found.other_light
    assert "No sparkles are computed: none of these lights has a slot." in str(found)


def test_a_hidden_light_counts_only_if_it_may_appear(ball: object) -> None:
    lamp = add_lamp("AREA", "Flash", spread=1)
    lamp.hide_render = True
    assert other() == ()
    lamp.keyframe_insert("hide_render", frame=1)
    assert other() == ("lights without a slot",)
    lamp.data.type = "SUN"
    assert other() == ()  # it has a slot, and sparkles when it appears


# --- neighbours -------------------------------------------------------------------------------


@pytest.mark.parametrize("painted", [False, True])
def test_a_neighbour_shows_in_the_flakes_if_light_bounces(ball: object, painted: bool) -> None:
    quad = add_quad()
    if painted:
        paint(quad)
    bpy.context.scene.cycles.max_bounces = 4
    assert other() == ("their neighbours",)
    bpy.context.scene.cycles.glossy_bounces = 0
    assert other() == ()
    assert "and no neighbours: its light does not bounce" in str(fit())
    bpy.context.scene.cycles.glossy_bounces = 4
    bpy.context.scene.cycles.max_bounces = 0
    assert other() == ()


def test_a_hidden_neighbour_is_none(ball: object) -> None:
    quad = add_quad()
    quad.hide_render = True
    bpy.context.scene.cycles.max_bounces = 4
    assert other() == ("the paint itself",)
    quad.hide_render, quad.hide_viewport = False, True
    assert other() == ("their neighbours",)


def test_instances_are_neighbours(ball: bpy.types.Object) -> None:
    collection = bpy.data.collections.new("Cars")
    collection.objects.link(paint(add_quad()))
    bpy.context.scene.collection.objects.unlink(bpy.data.objects["Quad"])
    empty = bpy.data.objects.new("Instancer", None)
    bpy.context.scene.collection.objects.link(empty)
    bpy.context.scene.cycles.max_bounces = 4
    assert other() == ("the paint itself",)
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    assert "their neighbours" in other()


@pytest.mark.parametrize(
    ("inputs", "emits"),
    [
        ({"Color": GREY, "Strength": 1}, True),
        ({"Color": BLACK, "Strength": 1}, False),
        ({"Color": GREY, "Strength": 0}, False),
    ],
)
def test_what_emits_is_light_without_a_bounce(
    ball: object, inputs: dict[str, object], emits: bool
) -> None:
    bpy.context.scene.cycles.max_bounces = 0
    quad = add_quad()
    material.assign(quad, emitting(**inputs))
    assert other() == (("objects that may emit",) if emits else ())


def plain(made: bpy.types.Material) -> None:
    pass


def principled(made: bpy.types.Material) -> None:
    node = made.node_tree.nodes["Principled BSDF"]
    node.inputs["Emission Color"].default_value = GREY
    node.inputs["Emission Strength"].default_value = 0.1


def linked(made: bpy.types.Material) -> None:
    value = made.node_tree.nodes.new("ShaderNodeValue")
    node = made.node_tree.nodes["Principled BSDF"]
    made.node_tree.links.new(value.outputs[0], node.inputs["Emission Strength"])


def group(made: bpy.types.Material) -> None:
    tree = bpy.data.node_groups.new("Artist's", "ShaderNodeTree")
    tree.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketShader")
    made.node_tree.nodes.new("ShaderNodeGroup").node_tree = tree


def script(made: bpy.types.Material) -> None:
    text = bpy.data.texts.new("glow.osl")
    text.write("shader glow(output closure color Out = 0) { Out = emission(); }")
    bpy.context.scene.render.engine = "CYCLES"
    made.node_tree.nodes.new("ShaderNodeScript").script = text


@pytest.mark.parametrize(
    ("change", "emits"),
    [(plain, False), (principled, True), (linked, True), (group, True), (script, True)],
)
def test_what_may_emit_counts_as_emitting(
    ball: object, change: Callable[[bpy.types.Material], None], emits: bool
) -> None:
    bpy.context.scene.cycles.max_bounces = 0
    made = bpy.data.materials.new("Any")
    if made.node_tree is None:
        made.use_nodes = True
    change(made)
    material.assign(add_quad(), made)
    assert other() == (("objects that may emit",) if emits else ())


def test_a_volume_is_light_without_a_bounce(ball: object) -> None:
    bpy.context.scene.cycles.max_bounces = 0
    made = bpy.data.materials.new("Fog")
    if made.node_tree is None:
        made.use_nodes = True
    material.assign(add_quad(), made)
    assert other() == ()
    scatter = made.node_tree.nodes.new("ShaderNodeVolumeScatter")
    out = made.node_tree.nodes["Material Output"]
    made.node_tree.links.new(scatter.outputs[0], out.inputs["Volume"])
    assert "volumes" in other()


# --- the paint sees itself --------------------------------------------------------------------


def test_alone_it_may_see_itself_if_light_bounces(ball: object) -> None:
    add_sun()
    assert other() == ()
    bpy.context.scene.cycles.max_bounces = 4
    assert other() == ("the paint itself",)
    assert socket() == 1
    add_quad()
    assert other() == ("their neighbours",)


def test_a_file_without_paint_of_its_own_gets_no_slots() -> None:
    for group in list(bpy.data.node_groups):
        bpy.data.node_groups.remove(group)
    add_sun()
    assert str(fit()) == "This file has no metallic paint of its own."
    assert lights.groups() == []


# --- what it says -----------------------------------------------------------------------------


def test_it_says_what_it_left_out(ball: object) -> None:
    scene = bpy.context.scene
    assert "A library, as no scene has a camera: " in str(fit())
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    assert str(fit()) == (
        "No sparkles are computed: no light renders.\n"
        "The flakes show no world or other lights: the scene has none; and no neighbours: its "
        "light does not bounce (Light Paths, Total or Glossy is 0)."
    )
    scene.cycles.max_bounces = 4
    add_sun()
    new_world(Color=GREY, Strength=1)
    add_lamp("AREA", "Grid", spread=1)
    add_lamp("AREA", "Softbox")
    add_quad()
    assert str(fit()) == (
        "light 1: Sun\n"
        "light 2: Softbox\n"
        "no sparkles from Grid: its Spread is below 90°, so parts of it are dark\n"
        "3 lights: 2 sparkle, 1 lights the mean.\n"
        "The flakes also show the world, lights without a slot, area lights where they look wide "
        "and their neighbours."
    )


# --- the picture ------------------------------------------------------------------------------


def scene_of(
    lamps: tuple, samples: int, **changes: object
) -> tuple[bpy.types.Scene, bpy.types.Object]:
    scene = bpy.context.scene
    spec = scenes.Scene("needs", lamps, **{"width": 0.4, **changes})
    item = scenes.build(scene, spec, SIZE)
    verify.make_noiseless(scene)
    scene.cycles.samples, scene.cycles.max_bounces = samples, 4
    return scene, item


def picture(scene: bpy.types.Scene, *, other_light: bool, seed: int) -> np.ndarray:
    lights.show_other_light(other_light)
    scene.cycles.seed = seed
    return verify.render(scene).astype(float)


def expect_same(one: np.ndarray, two: np.ndarray, noise: float = 0.01) -> None:
    """Pictures of independent samples: their mean difference over the pixels is noise."""
    difference = (one - two).mean(axis=-1).ravel()
    error = difference.std() / math.sqrt(difference.size)
    assert abs(difference.mean()) <= STANDARD_ERRORS * error + 1e-7 * one.mean()
    assert error < noise * one.mean(), "noise hides nothing"


BALL = {"shape": "sphere", "scale": (0.15, 0.15, 0.15)}


@pytest.mark.long
def test_under_a_sun_alone_the_picture_misses_nothing() -> None:
    # A mirror would show the sun itself, in a few noisy pixels.
    scene, _ = scene_of((scenes.SUN,), 16, **BALL, paint=Paint(coat_roughness=0.3))
    assert needs.fit(scene).other_light == ("the paint itself",)  # convex: nothing comes back
    whole = picture(scene, other_light=True, seed=1)
    assert whole.max() > 0.1
    expect_same(picture(scene, other_light=False, seed=2), whole)


@pytest.mark.long
def test_left_out_where_it_is_needed_would_be_missed() -> None:
    """The comparison above can fail."""
    scene, _ = scene_of((scenes.SUN,), 16, **BALL)
    new_world(Color=(1, 1, 1, 1), Strength=1)
    assert needs.fit(scene).other_light[0] == "the world"
    whole = picture(scene, other_light=True, seed=1)
    assert picture(scene, other_light=False, seed=2).mean() < 0.8 * whole.mean()


@pytest.mark.long
def test_without_a_light_that_sparkles_the_slots_are_not_missed() -> None:
    """Black with all left out; under a world, the same whether a far dark sun has a slot or not."""
    scene, _ = scene_of((), 64, **BALL)
    found = needs.fit(scene)
    assert "No sparkles are computed" in str(found)
    assert picture(scene, other_light=False, seed=1).max() == 0
    new_world(Color=(1, 1, 1, 1), Strength=1)
    needs.fit(scene)
    without = picture(scene, other_light=True, seed=1)
    scenes.sun("Dark", 60, 110)(scene).data.energy = 0
    assert needs.fit(scene).lights.slots == (scene.objects["Dark"],)
    expect_same(without, picture(scene, other_light=True, seed=2))


@pytest.mark.long
def test_twenty_lights_are_the_sum_of_those_that_sparkle_and_those_that_do_not() -> None:
    names = [f"Sun {i:02}" for i in range(20)]
    suns = [scenes.sun(n, 40 + 2 * i, 18 * i, 6) for i, n in enumerate(names)]
    scene, _ = scene_of(tuple(suns), 128, **BALL, paint=Paint(tilt=0.3))
    scene.cycles.max_bounces = 0
    for lamp in names:  # a flake's narrow cone seldom holds the sun that a sample picks
        scene.objects[lamp].data.cycles.use_multiple_importance_sampling = True
    found = needs.fit(scene)
    assert "20 lights: 8 sparkle, 12 light the mean." in str(found)
    whole = picture(scene, other_light=True, seed=1)
    parts = np.zeros_like(whole)
    for seed, shown in enumerate((found.lights.slots, tuple(found.lights.left_out)), 2):
        for lamp in names:
            scene.objects[lamp].hide_render = scene.objects[lamp] not in shown
        parts += picture(scene, other_light=True, seed=seed)
    expect_same(whole, parts, noise=0.03)
    # And without a slot each sun lights the mean: the same light, the slots empty.
    for lamp in names:
        scene.objects[lamp].hide_render = False
    lights._build(lights.node_group(), [], [])
    expect_same(whole, picture(scene, other_light=True, seed=4), noise=0.03)


# --- far away ---------------------------------------------------------------------------------


def plane_to_the_horizon() -> verify.Probe:
    """From where the number of sparkles fluctuates to a thousand kilometres away."""
    flakes = Paint(flake_area_spread=0, depth_model="thinned")  # equals: N alone fluctuates
    sun = scenes.sun("Sun", 30, 80, 0.53)
    scene, plane = scene_of((sun,), 1, elevation=20, distance=20, paint=flakes)
    plane.scale = (1e6, 1e6, 1)
    scene.camera.data.angle = math.radians(35)
    scene.camera.data.clip_end = 1e7
    scene.render.resolution_x, scene.render.resolution_y = 64, 128
    return verify.Probe(scene, [plane.active_material])


@pytest.mark.long
def test_far_away_the_mean_takes_over_without_a_seam() -> None:
    probe = plane_to_the_horizon()
    hit = probe.geometry().hit
    count = probe.image(verify.MEAN_COUNT)[..., 0]
    drawn, mean = (probe.image(d)[..., 1] for d in (verify.RADIANCE, verify.MEAN_RADIANCE))
    far, near = hit & (count > 65536), hit & (count < 32768)
    blend = hit & ~far & ~near
    assert min(far.sum(), near.sum()) > 500
    assert blend.sum() > 100
    np.testing.assert_allclose(drawn[far], mean[far], rtol=1e-6)
    ratio = drawn / np.where(mean > 0, mean, 1)
    for some in (near & (count > 2000), blend):
        off = ratio[some] - 1
        assert off.std() > 0, "still drawn"
        assert abs(off.mean()) <= STANDARD_ERRORS * off.std() / math.sqrt(off.size)
    # No step from row to row, beyond the fluctuation of the drawn rows: 1/sqrt(N) of each pixel.
    rows = (near & (count > 2000)).any(axis=1) | blend.any(axis=1) | far.any(axis=1)
    inside = [np.where(hit[i], ratio[i], 0).sum() / hit[i].sum() for i in np.nonzero(rows)[0]]
    error = [1 / math.sqrt(count[i][hit[i]].min() * hit[i].sum()) for i in np.nonzero(rows)[0]]
    steps = np.abs(np.diff(inside))
    assert (steps <= STANDARD_ERRORS * np.hypot(error[1:], error[:-1]) + 1e-6).all()
