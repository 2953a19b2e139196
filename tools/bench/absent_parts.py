# SPDX-License-Identifier: Apache-2.0
"""What the parts of the shader cost where a scene does not use them: nothing, within 3 %.

For each part: the shader with the part absent through its inputs, beside one from whose text the
part is cut; sparkles are absent where a world is the only light. First the operations that OSL
keeps of the shader once it has folded constants: a figure without noise. Where it is the same, the
absent part is gone; otherwise it is still there, compiled but not run, and the time per sample
tells what that costs.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator

import bpy
from common.processes import TOOLS
from metallic_paint.paint import Paint, material, shader
from pictures.render_scene import say
from verification import scenes

from bench.rows import Row, ratios
from bench.stage import Stage

LIMIT = 1.03
WHOLE, WHOLE_UNLIT = "the paint", "the paint without a lamp"

Text = Callable[[str], str]


def cut(start: str, end: str, instead: str = "") -> Text:
    """Cuts from the only place of `start` up to the next `end`, which stays."""

    def edit(text: str) -> str:
        assert text.count(start) == 1, start
        begin = text.index(start)
        return text[:begin] + instead + text[text.index(end, begin) :]

    return edit


def replace(old: str, new: str) -> Text:
    def edit(text: str) -> str:
        assert old in text, old
        return text.replace(old, new)

    return edit


def one_species(text: str) -> str:
    text = replace("#define SPECIES 3", "#define SPECIES 1")(text)
    text = replace("{color(0.0), color(0.0), color(0.0)}", "{color(0.0)}")(text)
    text = cut("  Flakes second;\n  if (Second", "  Layer flake_layer = make_layer",
               "  Flakes second = no_such_flakes();\n  Flakes third = second;\n")(text)  # fmt: skip
    text = cut("  if (second.areal_density > 0.0)\n    layer", "  layer.first = first;")(text)
    for more in ("second", "third"):
        text = replace(f"  add_blocking(layer, {more}, library);\n", "")(text)
    return text


def one_slot(text: str) -> str:
    text = re.sub(r"  ADD_SLOT\([1-7],.*\n", "", text)
    text = cut("  if (several || melting)", "\n  PixelSparkles drawn[8];")(text)
    return re.sub(r"\b(seen|leader|slot|drawn|in_lobes)\[8\]", r"\1[1]", text)


def no_library(text: str) -> str:
    text = cut("  if (coating.kind > COATING_COLORS) {", "    float x = max(1.0 - cos_alpha",
               "  {\n")(text)  # fmt: skip
    text = cut("  if (is_clear(coating.kind)) {\n    int absorbing", "  return passed;")(text)
    text = cut("        if (on_silica) {", "      }\n    }\n  }\n  return sum;")(text)
    text = cut("  if (is_on_silica(coating.kind)) {", "  float cos_exit = clamp(")(text)
    return re.sub(r"(float CoatingLibrary\[\] = \{).*?\}", r"\1 0.0 }", text, flags=re.DOTALL)


def no_sparkles(text: str) -> str:
    text = cut("  ADD_SLOT(0,", "  PixelSparkles drawn[8];", "  int leader[8];\n")(text)
    text = cut("  if (lights > 0)  // a constant", "\n  // The flakes under all other")(text)
    text = cut("    if (lights > 0)\n      lobes_beside", "    flakes = lean")(text)
    return cut("listed_sparkles(drawn, view", "  closure color mixed", "0;\n")(text)


def full_contrast(text: str) -> str:
    return replace("blurred ? 0.0 : layer.sparkle_contrast", "blurred ? 0.0 : 1.0")(text)


PARTS: dict[str, Text] = {
    "second and third species": one_species,
    "other light": cut(
        "  SmoothPart parts[SPECIES];\n  float rise",
        "\n  // The coat over the flakes over",
        "  closure color lobe = 0;\n",
    ),
    "light slots 2 to 8": one_slot,
    "texture": cut(
        "  if (given.texture_contrast > 0.0)", "  stack.diffuse = stack.diffuse * stack"
    ),
    "orange peel": cut("  if (given.orange_peel > 0.0)\n    coat_n", "  if (inner_product(coat_n"),
    "published composition": cut("    if (paint.composition ==", "    drawn[i] = here;"),
    "sparkle contrast": full_contrast,
    "coating library": no_library,
}


# Which a paint always has, for what they cost.
PRESENT: dict[str, Text] = {
    "mixture": cut(
        "  Mixture scattered = mixture(", "  stack.diffuse = scattered",
        "  Mixture scattered = no_mixture();\n"
        "  scattered.diffuse_albedo = given.substrate_color;\n",
    ),
}  # fmt: skip

# Under a world, without a lamp in the slots.
UNLIT_PARTS: dict[str, Text] = {"sparkles": no_sparkles}


# The deviates of pixels: what the choice of the anchor costs.
PIXEL_ANCHOR = "the paint with Anchor pixel"
on_pixels = replace("layer.anchor = given.anchor;", "layer.anchor = ANCHOR_PIXEL;")


def everything(text: str) -> str:
    for edit in PARTS.values():
        text = edit(text)
    return text


def cuts() -> dict[str, Text]:
    lit = {WHOLE: str, **PARTS, "all of these": everything}
    return {**lit, WHOLE_UNLIT: str, **UNLIT_PARTS}


def is_unlit(name: str) -> bool:
    return name == WHOLE_UNLIT or name in UNLIT_PARTS


def stage_of(name: str) -> Stage:
    return Stage((), sky=1) if is_unlit(name) else Stage([scenes.SUN])


def painted(edit: Text, paint: Paint | None = None) -> bpy.types.Material:
    """The paint, or the one that ships, whose shader has the edited text."""
    whole = shader.source
    shader.source = lambda: edit(whole())
    try:
        return material.create(paint or Paint())
    finally:
        shader.source = whole


def show(name: str) -> None:
    """Renders one sample of the variant, after which OSL prints its statistics."""
    stage = stage_of(name)
    stage.add(name, [painted({**cuts(), PIXEL_ANCHOR: on_pixels}[name])], 8)
    stage.fit()
    stage.scene.render.use_persistent_data = False
    stage.render(name, 1)


def operations(name: str) -> int:
    """That OSL keeps of the variant's shader, in a process of its own."""
    ran = subprocess.run(
        [sys.executable, TOOLS, "bench.show_operations", name],
        env={**os.environ, "OSL_OPTIONS": "statistics:level=1"},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return int(re.search(r"Optimized \d+ ops to (\d+)", ran.stdout + ran.stderr)[1])


def absent_parts() -> Iterator[Row]:
    whole = {name: operations(name) for name in (WHOLE, WHOLE_UNLIT)}
    left: dict[str, Text] = {}
    for name, edit in cuts().items():
        if name in whole:
            continue
        say(f"  {name}")
        of_whole, kept = whole[WHOLE_UNLIT if is_unlit(name) else WHOLE], operations(name)
        gone = of_whole == kept
        yield Row(f"{name}, absent, over the paint without its text: operations", [of_whole / kept],
                  LIMIT if gone else None, orientation=f"{of_whole} / {kept}")  # fmt: skip
        if not gone:
            left[name] = edit
    for whole_name in whole:
        unlit = is_unlit(whole_name)
        if still := {n: e for n, e in left.items() if is_unlit(n) == unlit}:
            yield from race(whole_name, still)


def race(whole: str, chosen: dict[str, Text]) -> Iterator[Row]:
    """Times of those that are still there, and the noise of such times."""
    again = f"{whole} again"
    present = PRESENT if whole == WHOLE else {}
    stage = stage_of(whole)
    for name, edit in {whole: str, again: str, **present, **chosen}.items():
        stage.add(name, [painted(edit)], 128)
    stage.fit()
    times = stage.race(1 << 17, 7)

    def over(what: str, name: str, limit: float | None = None) -> Row:
        return Row(f"{what}: time per sample", ratios(times[whole], times[name]), limit)

    yield over(f"{whole} over itself", again)
    for name in present:
        yield over(f"{name}, over the paint without it", name)
    for name in chosen:
        yield over(f"{name}, absent, over the paint without its text", name, LIMIT)
