# SPDX-License-Identifier: Apache-2.0
"""Makes the report of ./paint bench of what was found."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

from common.processes import run_program
from common.report_folder import BENCH, REPORT, table

from bench import plots
from bench.rows import PARTS, Found, Row, read

ABOUT = """\
What the paint costs beside what artists use today. Every figure is a ratio of processor times (or
of memory) measured one after the other in one run, contenders by turns: the median over the
repetitions and the quartiles. Absolute figures are for orientation; they are this machine's, and
change with what else it does. Bars hold for the median.

The contenders:

- **Principled**: Blender's Principled BSDF, metallic, with a coat.
- **Voronoi flakes**: what artists build of nodes. The cells of a Voronoi texture turn the normal of
  a metal under a coat, as many and as tilted as the paint's flakes. The material of
  [./paint motion](../motion/README.md).
- **noise flakes**: an OSL shader in the manner of MaterialX's flake nodes, in our own words
  (`tools/bench/flakes.osl`), equally dense: the flake of highest priority in 27 cells of a noise
  turns the normal of a metal under a coat.
"""

CAPTIONS = {
    "waits": "Pictures of 16 × 16 pixels and one sample, each in a fresh Blender, under a sun and "
    "a world, with persistent data. All of it is preparing: compiling shaders, above all. "
    "Principled's first picture under OSL is the measure. Twenty materials of paint are rendered "
    "once, the rest in each round. Bars are twice what Principled waits and 0.05 s, which nobody "
    "feels, and for twenty paints 20 times its first picture. Cycles compiles a program for each "
    "material, alike or not; one whose sockets are all linked to properties of the objects serves "
    "as many paints as there are objects.",
    "memory": "The most that the fresh Blenders of above had resident after their first picture.",
    "samples": "A painted plane in an orthographic picture, once with few samples and once with "
    "many: the difference of the times, so that preparing drops out. Without other objects and "
    "without bounces. Cycles and the closures alone take as much as Principled (see Instructions), "
    "so no bar asks for less.",
    "growth": "Time per sample under suns, over the first point of each curve; beside it, that "
    "point's time. ⟨N⟩ is the mean count of sparkles in a pixel. With more flakes, flakes and "
    "pixels shrink alike. With more pixels, the picture shows more paint. Further lights are suns "
    "in other places; paints in one picture lie in 20 strips.",
    "noise": "A ball under light of any size, Sparkle Contrast 0: two pictures of other seeds, "
    "their difference over their mean, and that over what Principled has (roughness 0.4). What is "
    "seen at less than 18° is left out.",
    "absent": "What a scene does not use costs nothing: operations that OSL keeps of the shader, "
    "over those where the part is cut from its text, and where these differ, times. The first time "
    "is of two copies of the same shader: noise.",
    "instructions": "What one core does, as Valgrind counts it in the first Blender: within 2 % "
    "the same in every run, while times change with what else the machine does. The same scenes as "
    "above, of one thread. An instruction is no time, but the ratios are alike. What is not the "
    "compiled shader is Cycles itself: rays, lights, random numbers, and the closures that the "
    "paint needs.",
    "error": "A plane under a sun: the paint, Voronoi and noise flakes without a coat, and every "
    "flake of a layer as a disc in a mesh, with the metal of the Voronoi flakes, their tilt as the "
    "binder shows it, and no binder. Each method is held against its own converged picture (other "
    "samples of it), so the error is noise alone; how the converged pictures differ stands below. "
    "Explicit flakes are not waited for: beyond the last picture their error falls as the root of "
    "the samples. The fewer flakes in a pixel, the less is won; a picture that shows single flakes "
    "is one for a mesh. Pictures hold few sparkles where flakes in a pixel are few, so figures "
    "there are rough. In the first Blender.",
    "core": "The sparkles of one sun in a pixel, by the C++ core: in one thread by Google "
    "Benchmark (`tests/benchmark/speed.cpp`), in batches through numpy arrays, where mean and "
    "variance are computed besides. Double is the reference and integrates what float has in "
    "closed form.",
}


# By hand, outside this command's run: a line each, what and why.
TRIED = (
    ("OSL's own settings (`OSL_OPTIONS`: `llvm_optimize` 1 to 3, 12 and 13, `llvm_jit_aggressive`, "
     "`llvm_jit_fma`, `opt_groupdata`, `lazyglobals`, `opt_coalesce_temps`)",
     "0.65 to 0.76 s to the first sample instead of 0.72, noise; `llvm_optimize` 11, 0.82 s and "
     "1.4 times the time per sample; `opt_passes` 1, 0.80 s; `optimize` 1, 9 s"),
    ("several alike materials, so that Cycles shares their program",
     "it does not: 6 copies of one paint take 6 times as long as one (4.1 s and 0.66 s)"),
    ("fewer derivatives", "OSL carries them for one symbol of the shader already"),
    ("the mixture in whole colours instead of a loop over channels",
     "12 exponentials less, and 8,737 LLVM instructions instead of 8,104"),
    ("loops over three channels", "LLVM copies them out: 70 exponentials where OSL keeps 30"),
    ("folding of constants alone, without fewer copies",
     "9,567 operations instead of 12,642, and the same wait: LLVM had folded them"),
    ("OSL's own `exp`, or 2^k by shifts of whole numbers, in place of the polynomial and `exp2`",
     "at most 2 % of the time per sample"),
    ("two lobes of microfacets in place of one for lamps without a slot",
     "the tail they catch is another one for each paint: the rest that random flakes must show "
     "falls from 7 to 6 % only, and the lobes pass the flakes' BRDF twice as much"),
    ("the shader in several script nodes",
     "it is as long as its parts: cut from it one by one, mixture, other light, close flakes and "
     "sparkles save 0.16, 0.08, 0.07 and 0.29 s of 0.82 s, and without all of these it still takes "
     "0.3 s, which each node would take anew"),
    ("loops whose count LLVM cannot know, so that it copies none out",
     "0.82 s to the first sample with and without"),
    ("OSL's passes (`opt_seed_bblock_aliases=0`, or `opt_passes=2`)",
     "OSL's own part of the wait falls to less than half and LLVM's does not grow, though 8,213 "
     "operations remain where 3,926 did; but these are settings of the user's whole Blender"),
    ("the core with `-O3`, or tuned for this processor (`-mtune`)",
     "`-O3` 0 to 2 % faster where sparkles are few and 6 % where they are many; `-mtune` 1 to 4 % "
     "slower"),
    ("lights in View Layer attributes", "each frame compiles every paint anew"),
    ("drivers on each painted object instead of on one datablock",
     "95 to 105 ms a frame with 1,000 objects, instead of 60 to 70"),
)  # fmt: skip

MILLISECOND = 1e-3  # times below it are shown in µs


def report(found: Sequence[Found], quick: bool) -> Iterator[str]:
    yield from (BENCH.mark, "", "# What the paint costs", "", ABOUT)
    if quick:
        yield "**A rough run (`--quick`): few repetitions, in the first Blender alone.**"
        yield ""
    judged = [bar for part in found for bar in part.bars()]
    missed = [bar for bar in judged if not bar.holds]
    yield f"{len(judged) - len(missed)} of {len(judged)} bars hold."
    yield ""
    for part in PARTS:
        parts = [each for each in found if each.part == part]
        if not parts:  # with --only
            continue
        yield from (f"## {TITLES[part]}", "", CAPTIONS[part], "")
        if part in DRAWN:
            yield from (f"![{TITLES[part]}]({part}.png)", "")
        head = ["", "Blender", "median", "quartiles", "bar", "for orientation"]
        yield from table(head, _cells(parts))
    yield from ("## Tried, and did not pay", "")
    yield from table(["what", "why not"], TRIED)


TITLES = {
    "waits": "Waits", "memory": "Memory", "samples": "Time per sample", "growth": "Growth",
    "noise": "Noise",
    "absent": "Absent parts", "instructions": "Instructions", "error": "Time to equal error",
    "core": "The core",
}  # fmt: skip
DRAWN = {
    "waits": plots.draw_ratios, "samples": plots.draw_ratios, "growth": plots.draw_growth,
    "error": plots.draw_error,
}  # fmt: skip


def _cells(parts: Sequence[Found]) -> Iterator[list[str]]:
    curves = dict.fromkeys(row.curve for row in parts[0].rows if row.curve)
    for curve in curves:
        for part in parts:
            rows = [row for row in part.rows if row.curve == curve]
            places = ", ".join(f"{row.at:g}" for row in rows)
            medians = ", ".join(_number(row.median, row) for row in rows)
            yield [f"{curve}: {places}", part.blender, medians, "", "", rows[0].orientation]
    single = [(part, row) for part in parts for row in part.rows if not row.curve]
    for quantity in dict.fromkeys(row.quantity for _, row in single):  # not all in every Blender
        for part, row in single:
            if row.quantity == quantity:
                ends = " to ".join(_number(end, row, False) for end in row.quartiles)
                yield [
                    row.quantity, part.blender, _number(row.median, row), ends, _bar(row),
                    row.orientation,
                ]  # fmt: skip


def _number(value: float, row: Row, with_unit: bool = True) -> str:
    unit = "" if row.unit == "1" else f" {row.unit}"
    if row.unit == "s" and abs(row.median) < MILLISECOND:
        value, unit = value * 1e6, " µs"
    text = f"{value:.3g}" if abs(value) < 100 else f"{value:,.0f}"
    return f"{text}{unit if with_unit else ''}".replace("-", "−")


def _bar(row: Row) -> str:
    if row.limit is None:
        return ""
    holds = all(bar.holds for bar in row.bars(""))
    return f"{row.bound} {_number(row.limit, row)}{'' if holds else ' **missed**'}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--found", type=Path, required=True, help="the file of what was found")
    parser.add_argument("--out", type=Path, required=True, help="an empty folder")
    parser.add_argument("--quick", action="store_true", help="say that it is a rough one")
    arguments = parser.parse_args()
    found = read(arguments.found)
    for part, draw in DRAWN.items():
        if parts := [each for each in found if each.part == part]:
            draw(parts, arguments.out / f"{part}.png")
    (arguments.out / REPORT).write_text("\n".join(report(found, arguments.quick)), encoding="utf-8")
    return 0


if __name__ == "__main__":
    run_program(main)
