# SPDX-License-Identifier: Apache-2.0
"""What the parts of the shader cost where a scene does not use them: nothing, within 3 %.

For each part: the time per sample of the shader with the part absent through its inputs, over that
of a shader from whose text the part is cut. And the whole against a Principled BSDF. Run it on a
quiet machine, from a Python with bpy (build/env-3.11):

    build/env-3.11/bin/python tests/benchmark/shader_parts.py --repetitions 12

Times are slopes: what 60 more samples take, of one thread, without the start of a render, in
processor time. The variants alternate; the least time of each is the one that nothing disturbed.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

import blender_env

blender_env.prepare()

import bars  # noqa: E402
import bpy  # noqa: E402
import verify_scenes  # noqa: E402
from metallic_paint import lights, material, shader, verify  # noqa: E402
from metallic_paint.paint import Paint  # noqa: E402

FEW, MANY = 4, 64  # samples
LIMIT = 1.03

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
    text = cut("  if (SecondFlakesPerMm2", "  float scattering")(text)
    text = cut("  if (layer.species > 1) {", "  Flakes some = flakes[kind];")(text)
    text = replace("Flakes some = flakes[kind];", "Flakes some = flakes[0];")(text)
    loop = "for (int i = 0; i < layer.species; ++i) {"
    return replace(loop, "{\n    int i = 0;")(text)


def one_slot(text: str) -> str:
    text = re.sub(r"  ADD_SLOT\([1-7],.*\n", "", text)
    text = cut("  group_lights(seen, leader", "\n  // Changes with")(text)
    text = cut("      for (int j = 0; j < lights; ++j) {", "      color radiance")(text)
    text = cut("  float reach = angular_radius(seen[group]);\n  for", "  return reach",
               "  float reach = angular_radius(seen[group]);\n")(text)  # fmt: skip
    return re.sub(r"\b(seen|leader|slot)\[8\]", r"\1[1]", text)


def no_library(text: str) -> str:
    text = cut("  if (coating.kind > COATING_COLORS) {", "  float x = max(1.0 - cos_alpha")(text)
    text = cut("  if (!is_clear(coating.kind))", "}", "  return coating.transmittance;\n")(text)
    return re.sub(r"(float CoatingLibrary\[\] = \{).*?\}", r"\1 0.0 }", text, flags=re.DOTALL)


def no_diagnostics(text: str) -> str:
    return re.sub(r"\bDiagnostic (!=|==) SHOW_", r"0 \1 SHOW_", text)


PARTS: dict[str, Text] = {
    "second and third species": one_species,
    "other light": cut("  if (OtherLight > 0.5", "  if (Diagnostic == SHOW_LOBE)"),
    "light slots 2 to 8": one_slot,
    "texture": cut("  if (TextureContrast > 0.0) {", "  SeenLight seen"),
    "orange peel": cut("  if (slope > 0.0)", "  float cos_view"),
    "published composition": cut("      if (Composition ==", "      if (Diagnostic == SHOW_IRR"),
    "coating library": no_library,
    "diagnostics": no_diagnostics,
}


def everything(text: str) -> str:
    for edit in PARTS.values():
        text = edit(text)
    return text


@dataclass
class Variant:
    """A material, and its least times by number of samples."""

    material: bpy.types.Material
    least: dict[int, float] = field(default_factory=dict)

    @property
    def first(self) -> float:
        """Time of a picture of one sample: almost all of it is compilation."""
        return self.least[1]

    def slope(self, pixels: int) -> float:
        """ns per sample."""
        return (self.least[MANY] - self.least[FEW]) / (MANY - FEW) / pixels * 1e9


class Bench:
    def __init__(self, size: int) -> None:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = bpy.context.scene
        spec = verify_scenes.Scene("bench", (verify_scenes.SUN,), orthographic=True, width=0.2)
        self.plane = verify_scenes.build(self.scene, spec, size)
        verify.make_noiseless(self.scene)
        self.scene.render.threads_mode, self.scene.render.threads = "FIXED", 1
        self.pixels = size * size
        lights.show_other_light(False)

    def painted(self, edit: Text = str) -> Variant:
        """A paint whose shader has the edited text."""
        whole = shader.source
        shader.source = lambda: edit(whole())
        try:
            return Variant(material.create(Paint()))
        finally:
            shader.source = whole

    def time(self, variant: Variant, samples: int) -> float:
        material.assign(self.plane, variant.material)
        self.scene.cycles.samples = samples
        start = time.process_time()
        verify.render(self.scene)
        return time.process_time() - start

    def race(self, variants: list[Variant], repetitions: int) -> None:
        for _ in range(repetitions):
            for samples in (1, FEW, MANY):
                for variant in variants:
                    taken = self.time(variant, samples)
                    variant.least[samples] = min(taken, variant.least.get(samples, taken))


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
    parser.add_argument("--repetitions", type=int, default=6)
    parser.add_argument("--size", type=int, default=128, help="pixels along each side of a picture")
    parser.add_argument("--only", default="", metavar="TEXT", help="only parts with it in the name")
    parser.add_argument("--json", type=Path, help="the report")
    arguments = parser.parse_args()
    bench = Bench(arguments.size)
    report = []

    cuts = {name: edit for name, edit in {**PARTS, "all of these": everything}.items()
            if arguments.only in name}  # fmt: skip
    no_mixture = cut("  color diffused = mixture", "  if (TextureContrast",
                     "  color diffused = substrate;\n")  # fmt: skip
    whole = bench.painted()
    without = {name: bench.painted(edit) for name, edit in cuts.items()}
    others = {
        "mixture (present; cut)": bench.painted(no_mixture),
        "Principled, metallic, coat": Variant(principled()),
    }
    bench.race([whole, *without.values(), *others.values()], arguments.repetitions)

    time_of_whole = whole.slope(bench.pixels)
    print(f"the paint, one sun and no other light: {time_of_whole:.0f} ns per sample, "
          f"start {whole.first:.2f} s")  # fmt: skip
    print(f"{'part':<28}{'ns where cut':>14}{'paint over it':>15}{'start, s':>10}")
    for name, variant in {**without, **others}.items():
        taken = variant.slope(bench.pixels)
        ratio = time_of_whole / taken
        print(f"{name:<28}{taken:>14.0f}{ratio:>15.3f}{variant.first:>10.2f}")
        if name in cuts:
            title = f"{name}: time of the paint without it over time where it is cut from the text"
            report.append(bars.at_most(title, ratio, LIMIT))
    if arguments.json:
        bars.write(report, arguments.json)
    return 0 if all(bar.holds for bar in report) else 1


if __name__ == "__main__":
    try:
        code = main()
    except Exception:
        traceback.print_exc()
        code = 3
    blender_env.finish(code)
