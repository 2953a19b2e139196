# SPDX-License-Identifier: Apache-2.0
"""What the parts of the shader cost where a scene does not use them: nothing, within 3 %.

For each part: the time per sample of the shader with the part absent through its inputs, over that
of a shader from whose text the part is cut; sparkles are absent where a world is the only light.
And the whole against a Principled BSDF. Run it on a quiet machine, from a Python with bpy
(build/env-4.5):

    build/env-4.5/bin/python tests/benchmark/shader_parts.py

Before the times stand the operations that OSL keeps of the shader once it has folded constants: a
figure without noise. Where it is the same, the absent part is gone, and no time is taken of it;
otherwise it is still there, compiled but not run. --operations takes no times.

Times are processor times of a render that finds its shader compiled. Machines drift by more than
3 % within seconds, so each is taken next to one of the whole paint; the ratio of both, in the
median over the repetitions, is what counts, and the quartiles beside it say how sure it is.
"""

from __future__ import annotations

import argparse
import os
import re
import statistics
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "addon")]

from common import blender_env  # noqa: E402

blender_env.prepare()

import bpy  # noqa: E402
from common import bars  # noqa: E402
from metallic_paint import verify  # noqa: E402
from metallic_paint.paint import (  # noqa: E402
    Paint,
    material,
    shader,
)
from metallic_paint.scene import lights  # noqa: E402
from verification import scenes  # noqa: E402

SAMPLES = 32  # of two threads: one thread leaves another spinning
LIMIT = 1.03
WHOLE = "the paint"

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
    text = cut("  if (SecondFlakesPerMm2", "  Layer flake_layer = make_layer")(text)
    text = cut("  if (layer.species > 1) {", "  Flakes some = flakes[kind];")(text)
    text = replace("Flakes some = flakes[kind];", "Flakes some = flakes[0];")(text)
    loop = "for (int i = 0; i < layer.species; ++i) {"
    return replace(loop, "for (int i = 0; i < 1; ++i) {")(text)


def one_slot(text: str) -> str:
    text = re.sub(r"  ADD_SLOT\([1-7],.*\n", "", text)
    text = cut(
        "  if (lights > 1)\n    group_lights(seen, leader", "\n  // The flakes under the listed"
    )(text)
    text = cut("      for (int j = 0; j < lights; ++j) {", "      float rho")(text)
    text = cut("  float reach = angular_radius(seen[group]);\n  for", "  return reach",
               "  float reach = angular_radius(seen[group]);\n")(text)  # fmt: skip
    return re.sub(r"\b(seen|leader|slot)\[8\]", r"\1[1]", text)


def no_library(text: str) -> str:
    text = cut("  if (coating.kind > COATING_COLORS) {", "  float x = max(1.0 - cos_alpha")(text)
    text = cut("  if (!is_clear(coating.kind))\n    return color(0.0)", "}",
               "  return coating.transmittance;\n")(text)  # fmt: skip
    text = cut("  if (is_clear(coating.kind)) {", "  int sides")(text)
    return re.sub(r"(float CoatingLibrary\[\] = \{).*?\}", r"\1 0.0 }", text, flags=re.DOTALL)


def no_sparkles(text: str) -> str:
    text = cut("  ADD_SLOT(0,", "  // The flakes under the listed")(text)
    return cut("  if (lights > 0) {", "  // The flakes under all other")(text)


def full_contrast(text: str) -> str:
    text = replace("  return expected.contrast;", "  return 1.0;")(text)
    text = replace("expected.contrast * clamp(", "clamp(")(text)
    return replace("blurred || !(layer.sparkle_contrast > 0.0)", "blurred")(text)


PARTS: dict[str, Text] = {
    "second and third species": one_species,
    "other light": cut("  if (OtherLight > 0.5", "  // Cycles scales these"),
    "light slots 2 to 8": one_slot,
    "texture": cut(
        "  if (given.texture_contrast > 0.0)", "  stack.diffuse = stack.diffuse * stack"
    ),
    "orange peel": cut("  if (given.orange_peel > 0.0)\n    coat_n", "  if (inner_product(coat_n"),
    "published composition": cut("      if (paint.composition ==", "      // Their cone holds"),
    "sparkle contrast": full_contrast,
    "coating library": no_library,
}


# Which a paint always has.
only_the_substrate = cut(
    "  Mixture scattered = mixture(", "  stack.diffuse = scattered",
    "  Mixture scattered = no_mixture();\n"
    "  scattered.diffuse_albedo = given.substrate_color;\n",
)  # fmt: skip

# Under a world, without a lamp in the slots: the whole paint and the part.
WHOLE_UNLIT = "the paint, no sparkling light"
UNLIT_PARTS: dict[str, Text] = {"sparkles": no_sparkles}


def everything(text: str) -> str:
    for edit in PARTS.values():
        text = edit(text)
    return text


class Bench:
    def __init__(self, size: int, lit: bool = True) -> None:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = bpy.context.scene
        lamps = (scenes.SUN,) if lit else ()
        spec = scenes.Scene("bench", lamps, orthographic=True, width=0.2)
        self.plane = scenes.build(self.scene, spec, size)
        verify.make_noiseless(self.scene)
        self.scene.render.threads_mode, self.scene.render.threads = "FIXED", 2
        self.samples = SAMPLES * size * size
        lights.show_other_light(not lit)
        if not lit:
            self.scene.world = bpy.data.worlds.new("World")

    def painted(self, edit: Text = str) -> bpy.types.Material:
        """A paint whose shader has the edited text."""
        whole = shader.source
        shader.source = lambda: edit(whole())
        try:
            return material.create(Paint())
        finally:
            shader.source = whole

    def time(self, painted: bpy.types.Material) -> float:
        """ns of one processor per sample."""
        material.assign(self.plane, painted)
        self._render(1)  # compiles
        return min(self._render(SAMPLES) for _ in range(2)) / self.samples * 1e9

    def compiling(self, painted: bpy.types.Material) -> float:
        """s of one processor for a picture of one sample from scratch: mostly compiling."""
        material.assign(self.plane, painted)
        self.scene.render.use_persistent_data = False
        return self._render(1)

    def _render(self, samples: int) -> float:
        self.scene.cycles.samples = samples
        start = os.times().user
        verify.render(self.scene)
        return os.times().user - start


def show_operations(name: str) -> None:
    """Renders one sample of the variant, after which OSL prints its statistics."""
    bench = Bench(8, lit=not is_unlit(name))
    material.assign(bench.plane, bench.painted(cuts()[name]))
    bpy.ops.render.render()


def operations(name: str) -> int:
    """That OSL keeps of the variant's shader, in a process of its own."""
    ran = subprocess.run(
        [sys.executable, __file__, "--show-operations", name],
        env={**os.environ, "OSL_OPTIONS": "statistics:level=1"},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return int(re.search(r"Optimized \d+ ops to (\d+)", ran.stdout + ran.stderr)[1])


def cuts() -> dict[str, Text]:
    lit = {WHOLE: str, **PARTS, "all of these": everything}
    return {**lit, WHOLE_UNLIT: str, **UNLIT_PARTS}


def is_unlit(name: str) -> bool:
    return name == WHOLE_UNLIT or name in UNLIT_PARTS


def principled() -> bpy.types.Material:
    made = bpy.data.materials.new("Principled")
    if made.node_tree is None:
        made.use_nodes = True
    node = made.node_tree.nodes["Principled BSDF"]
    node.inputs["Metallic"].default_value = 1
    node.inputs["Roughness"].default_value = 0.3
    node.inputs["Coat Weight"].default_value = 1
    return made


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=9)
    parser.add_argument("--size", type=int, default=128, help="pixels along each side of a picture")
    parser.add_argument("--only", default="", metavar="TEXT", help="only parts with it in the name")
    parser.add_argument("--operations", action="store_true", help="count, without times")
    parser.add_argument("--json", type=Path, help="the report")
    parser.add_argument("--show-operations", choices=cuts(), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.show_operations:
        show_operations(arguments.show_operations)
        return 0
    wholes = (WHOLE, WHOLE_UNLIT)
    chosen = {name: edit for name, edit in cuts().items() if arguments.only in name}
    chosen = {name: edit for name, edit in cuts().items() if name in chosen or name in wholes}

    print(f"{'variant':<30}{'operations':>12}{'the paint over it':>19}")
    whole = {name: operations(name) for name in wholes}
    left = {}
    report = []
    for name, edit in chosen.items():
        kept = whole[name] if name in whole else operations(name)
        ratio = whole[WHOLE_UNLIT if is_unlit(name) else WHOLE] / kept
        print(f"{name:<30}{kept:>12}{ratio:>19.3f}", flush=True)
        if ratio != 1 or name in whole:
            left[name] = edit
        else:
            title = f"{name}: operations of the paint without it over those where it is cut"
            report.append(bars.at_most(title, ratio, LIMIT))
    if not arguments.operations:
        report += race(left, arguments.size, arguments.repetitions)
    if arguments.json:
        bars.write(report, arguments.json)
    return 0 if all(bar.holds for bar in report) else 1


def race(chosen: dict[str, Text], size: int, repetitions: int) -> list[bars.Bar]:
    unlit = {name: edit for name, edit in chosen.items() if is_unlit(name)}
    lit = {name: edit for name, edit in chosen.items() if name not in unlit}
    print(f"\n{'variant':<30}{'ns per sample':>14}{'the paint over it':>19}{'quartiles':>15}")
    return race_in(Bench(size), lit, repetitions) + (
        race_in(Bench(size, lit=False), unlit, repetitions) if len(unlit) > 1 else []
    )


def race_in(bench: Bench, chosen: dict[str, Text], repetitions: int) -> list[bars.Bar]:
    bench.scene.render.use_persistent_data = True  # keeps the shader compiled
    variants = {name: bench.painted(edit) for name, edit in chosen.items()}
    whole = variants.pop(next(iter(chosen)))
    variants["the paint again, for noise"] = bench.painted()
    if WHOLE in chosen:
        variants["mixture (present; cut)"] = bench.painted(only_the_substrate)
        variants["Principled, metallic, coat"] = principled()

    report = []
    for name, variant in variants.items():
        pairs = [(bench.time(whole), bench.time(variant)) for _ in range(repetitions)]
        low, ratio, high = statistics.quantiles((a / b for a, b in pairs), n=4)
        taken = statistics.median(b for _, b in pairs)
        print(f"{name:<30}{taken:>14.0f}{ratio:>19.3f}{low:>9.3f}{high:>6.3f}", flush=True)
        if name in PARTS or name in UNLIT_PARTS:
            title = f"{name}: time of the paint without it over time where it is cut from the text"
            report.append(bars.at_most(title, ratio, LIMIT))
    compiled = [statistics.median(bench.compiling(each) for _ in range(3)) for each in
                (whole, principled())]  # fmt: skip
    print("compiling and one sample: {:.2f} s, Principled's {:.2f} s".format(*compiled))
    return report


if __name__ == "__main__":
    blender_env.run(main)
