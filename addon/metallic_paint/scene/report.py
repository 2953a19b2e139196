# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene's paints compute, what the camera sees of their flakes, and what would spoil them.

Rays from the active camera find where each painted object shows (sight.py); there the core says how
many flakes and sparkles a pixel has, and how bright one sparkle is (expected.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import bpy

from .. import denoise
from ..native import core_missing
from ..paint import PARAMETERS, PaintError, live, material
from . import lights, needs, placed, reach, rest_position
from .expected import Expected, expect
from .sight import POLYGONAL, Camera, Effort, SightError, effort_for, look

INFO: Final = "INFO"
WARNING: Final = "WARNING"
ERROR: Final = "ERROR"
Line = tuple[str, str]  # level and sentence

_MANY = 100.0  # sparkles a pixel whose sum deviates by a tenth or less
_FEW = 1.0  # in the whole picture
_SMALLEST, _LARGEST = 0.005, 100.0  # metres: sizes of what one paints
_CONTRAST = PARAMETERS["sparkle_contrast"].label


def report(scene: bpy.types.Scene) -> list[Line]:
    """Sentences about the scene's paints, each with its level: INFO, WARNING or ERROR.

    Fits the paints to the scene, as needs.fit does.
    """
    lines = list(_render_settings(scene))
    fitted = needs.fit(scene)
    for sentence in str(fitted).splitlines():
        lines.append((INFO, sentence[0].upper() + sentence[1:].rstrip(".") + "."))
    if lights.groups() and not (fitted.lights.slots or fitted.lights.sky):
        lines.append(
            (WARNING, "Nothing sparkles: add a sun, spot, point or area light that renders.")
        )
    lines += _lamps_of_sets(scene)
    if outdated := denoise.outdated(scene):
        lines.append((WARNING, f"{outdated}."))
    lines += [(WARNING, text) for text in reach.dark(fitted.lights.slots)]
    lines += [
        (INFO, f"No driver follows {name}: a render without the add-on has its sparkles as now.")
        for name in dict.fromkeys(each.name for each in fitted.lights.placed if not each.followed)
    ]
    layers = placed.used_layers(scene)
    for layer in layers:
        layer.update()  # fit may have had nothing to do
    lines += [(WARNING, text) for text in map(reach.overridden, layers) if text]
    shown = {thing: layer for layer in layers for thing in placed.rendered(layer)}
    painted = [
        thing for thing, layer in shown.items()
        if lights.is_painted(thing.evaluated_get(layer.depsgraph))
    ]  # fmt: skip
    if not painted:
        multiplied = (thing for layer in layers for thing in placed.instanced(layer))
        if any(map(lights.is_painted, multiplied)):
            lines.append((INFO, "Painted only as instances: nothing can be foretold."))
        else:
            lines.append((WARNING, "No object that renders is painted."))
    if len(lights.painted_scenes()) > 1:
        text = (
            "More than one scene uses paints, which have the lights of one at a time: "
            "without this add-on, the scene that was fitted or saved last."
        )
        lines.append((WARNING, text))
    unseen = [
        thing.name
        for thing, layer in shown.items()
        if thing.type in POLYGONAL and not thing.visible_get(view_layer=layer)
    ]
    if unseen:
        text = (
            f"Hidden in the viewport, but rendered: {', '.join(unseen)}. What these hide or shade"
        )
        lines.append((INFO, f"{text} is not foretold."))
    surfaces = [each for thing in painted for each in _surfaces(thing, shown[thing])]
    unknown = {each: each.unknown() for each in surfaces}
    known = [each for each, line in unknown.items() if line is None]
    lines += _left_behind(scene, painted, known)
    objects = sum(len(layer.depsgraph.object_instances) for layer in layers)
    effort = effort_for(len(known), objects)
    chosen = _largest(scene, known, effort.objects)
    brightest = 0.0
    for each, line in unknown.items():
        if line is not None:
            lines.append(line)
            continue
        found, brightness = _about(scene, each, fitted.lights, effort, each in chosen)
        lines += found
        brightest = max(brightest, brightness)
    if left_out := len(known) - len(chosen):
        sentence = f"Left out, being smaller in the picture: {left_out} more painted surfaces."
        lines.append((INFO, sentence))
    lines += _clamping(scene, brightest, len(fitted.lights.placed) + bool(fitted.other_light))
    if not known or any(_sparkles(each.node) for each in known):
        lines += _denoising(scene)
    return lines


# --- settings ----------------------------------------------------------------------------------


def _render_settings(scene: bpy.types.Scene) -> Iterator[Line]:
    missing = material.missing(scene)
    if scene.render.engine != "CYCLES":
        yield ERROR, missing
        return
    if missing:
        shows = (
            material.has_osl()
            and scene.cycles.shading_system
            and material.gpu(scene) in ("NONE", "OPTIX")
        )
        yield WARNING if shows else ERROR, missing


def _lamps_of_sets(scene: bpy.types.Scene) -> Iterator[Line]:
    behind = scene.background_set
    while behind:
        shown = (each for layer in placed.used_layers(behind) for each in placed.rendered(layer))
        if any(each.type == "LIGHT" for each in shown):
            yield WARNING, f"The lights of the Background Set {behind.name} make no sparkles."
        behind = behind.background_set


def _clamping(scene: bpy.types.Scene, brightest: float, sources: int) -> Iterator[Line]:
    """Cycles clamps each sample, and gives one that picks a lamp among others their weight too."""
    if scene.render.engine != "CYCLES":
        return
    direct, indirect = scene.cycles.sample_clamp_direct, scene.cycles.sample_clamp_indirect
    sample = brightest * max(sources, 1)
    if direct > 0 and sample > direct:
        yield (
            WARNING,
            (
                f"Clamp Direct {direct:g} cuts sparkles, of which a sample may bring "
                f"{_number(sample)} W/m²/sr. 0 switches it off."
            ),
        )
    if indirect > 0 and brightest > indirect:
        yield INFO, f"Clamp Indirect {indirect:g} dims sparkles that are seen in other surfaces."


def _denoising(scene: bpy.types.Scene) -> Iterator[Line]:
    if scene.render.engine != "CYCLES":
        return
    if scene.cycles.use_denoising and not denoise.is_set_up(scene):
        label = denoise.SET_UP
        yield WARNING, f"Denoising takes sparkles for noise: “{label}” keeps them."


# --- objects -----------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Surface:
    """A paint on an object that renders."""

    label: str
    layer: bpy.types.ViewLayer
    thing: bpy.types.Object
    painted: bpy.types.Material
    node: bpy.types.ShaderNodeGroup

    def unknown(self) -> Line | None:
        """Why nothing can be foretold of it."""
        if file := material.linked_from(self.node):
            linked = f"the paint is linked from {file} and keeps the lights that it has there."
            return WARNING, f"{self.label}: {linked}"
        try:
            material.paint_of(self.node)
        except PaintError as error:
            return ERROR, f"{self.label}: {error}"
        return None


def _sparkles(node: bpy.types.ShaderNodeGroup) -> bool:
    contrast = node.inputs[_CONTRAST]
    return live.is_linked(contrast) or live.value(contrast) > 0


def _left_behind(
    scene: bpy.types.Scene, painted: list[bpy.types.Object], surfaces: list[_Surface]
) -> Iterator[Line]:
    """Sparkles that do not ride on what moves or deforms."""
    for thing in painted:
        if about := rest_position.about(thing):
            yield WARNING, about
    of_pixels = dict.fromkeys(
        each.painted.name
        for each in surfaces
        if _sparkles(each.node) and not material.rides(each.node)
    )
    if not of_pixels:
        return
    names = ", ".join(of_pixels)
    if scene.render.use_motion_blur:
        yield (
            WARNING,
            (
                f"Motion blur under the pixel anchor ({names}): sparkles of what moves stay sharp. "
                "With Anchor surface they streak."
            ),
        )
    if scene.camera is not None and getattr(scene.camera.data, "type", "") == "PANO":
        yield (
            WARNING,
            (
                f"Panoramic cameras under the pixel anchor ({names}): sparkles are squares. "
                "With Anchor surface they are not."
            ),
        )


def _surfaces(thing: bpy.types.Object, layer: bpy.types.ViewLayer) -> list[_Surface]:
    slots = thing.evaluated_get(layer.depsgraph).material_slots  # geometry nodes may add some
    materials = dict.fromkeys(slot.material.original for slot in slots if slot.material)
    painted = [each for each in materials if material.has_paint(each)]
    return [
        _Surface(
            thing.name if len(painted) == 1 else f"{thing.name}, {each.name}",
            layer, thing, each, material.paint_node(each),
        )
        for each in painted
    ]  # fmt: skip


def _largest(scene: bpy.types.Scene, surfaces: list[_Surface], number: int) -> list[_Surface]:
    """Those whose boxes are largest in the picture; without a camera, the first."""
    try:
        camera = Camera.of(scene)
    except SightError:
        return surfaces[:number]

    def area(surface: _Surface) -> float:
        left, bottom, right, top = camera.box(surface.thing) or (0, 0, 0, 0)
        return (right - left) * (top - bottom)

    return sorted(surfaces, key=area, reverse=True)[:number]


def _about(
    scene: bpy.types.Scene,
    surface: _Surface,
    in_slots: lights.Report,
    effort: Effort,
    looked_at: bool,
) -> tuple[list[Line], float]:
    """Lines about a painted object, and how bright a pixel of it may sparkle."""
    label, thing, node = surface.label, surface.thing, surface.node
    lines: list[Line] = []
    if thing.is_shadow_catcher or thing.holdout_get(view_layer=surface.layer):
        text = (
            f"{label} is a Holdout or Shadow Catcher (Object > Visibility): no paint is rendered."
        )
        return [(WARNING, text)], 0.0
    unit = scene.unit_settings.scale_length * node.inputs[material.MODEL_SCALE].default_value
    size = max(thing.dimensions) * unit
    if not _SMALLEST <= size <= _LARGEST:
        lines.append((WARNING, f"{label} is {_length(size)} large: is its Model Scale right?"))
    if not looked_at:
        return lines, 0.0
    try:
        seen = look(scene, surface.layer, thing, surface.painted, unit, effort)
    except SightError as error:
        return [*lines, (INFO, f"{label}: {error}")], 0.0
    if seen is None:
        return [*lines, (INFO, f"{label}: the camera does not see it.")], 0.0
    expected = expect(scene, material.paint_of(node), seen, in_slots.placed)
    lines += _judge(label, node, expected)
    if _sparkles(node):
        missing = reach.lacking(scene, surface.layer, thing, seen, in_slots)
        lines += [(WARNING, text) for text in missing]
    return lines, expected.brightness or 0.0


def _judge(label: str, node: bpy.types.ShaderNodeGroup, expected: Expected) -> Iterator[Line]:
    held = f"{label}: {_number(expected.flakes)} flakes a pixel"
    if not _sparkles(node):
        yield INFO, f"{held}. With {_CONTRAST} 0 they show their mean, no sparkles."
        return
    if expected.sparkles is None:
        yield INFO, f"{held}."
        yield INFO, f"{label}: sparkles cannot be foretold. {core_missing()}"
        return
    yield (
        INFO,
        (
            f"{held}, {_number(expected.sparkles)} sparkles in the middle and "
            f"{_number(expected.most_sparkles)} where there are most."
        ),
    )
    linked = [each.name for each in node.inputs if each.type != "VECTOR" and live.is_linked(each)]
    if linked:
        yield INFO, f"{label}: the numbers do not follow what is linked to {', '.join(linked)}."
    if expected.most_sparkles > _MANY:
        yield (
            WARNING,
            (
                f"{label}: the sparkles are too many and too small to be seen, they merge into the "
                "mean. Come nearer, render larger, or take fewer and larger flakes."
            ),
        )
    if expected.in_picture < _FEW:
        yield (
            WARNING,
            (
                f"{label}: no sparkle is to be expected in the picture "
                f"({_number(expected.in_picture)} of all its pixels). Turn the object or a lamp so "
                "that it mirrors, or take more flakes or a wider tilt."
            ),
        )


# --- words -------------------------------------------------------------------------------------


def _number(x: float) -> str:
    """Two digits, without powers of ten where one reads it better."""
    if x == 0 or 1e-3 <= x < 1e6:
        return f"{float(f'{x:.2g}'):,g}" if x < 1e5 else f"{float(f'{x:.2g}'):,.0f}"
    return f"{x:.1e}"


def _length(meters: float) -> str:
    for unit, factor in (("km", 1e-3), ("m", 1), ("cm", 1e2), ("mm", 1e3)):
        if meters * factor >= 1:
            return f"{_number(meters * factor)} {unit}"
    return f"{_number(meters * 1e6)} µm"
