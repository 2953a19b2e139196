# SPDX-License-Identifier: Apache-2.0
"""Films sparkles in motion and measures whether they ride on the paint.

Turntable, dolly, pan, a moving sun, motion blur and a panorama, with both anchors and beside flakes
made of nodes; and the mean and variance of pixels that stand still.
"""

from __future__ import annotations

import argparse
import json
import shutil
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from common import bars, environments
from common.environments import FIRST_BLENDER, Blender
from common.processes import (
    BUILD,
    ROOT,
    TOOLS,
    run_measurement,
    run_program,
    say,
)
from common.report_folder import MOTION, REPORT, check_file, table

from motion.rows import FILM, FILMED, MATERIALS, MEASURED, Row, strip_of

WORK = BUILD / "motion"

ABOUT = """\
Three materials side by side: the paint with its sparkles anchored to the pixels of the picture, as
the paper has them; anchored to the surface; and flakes made of nodes, as many and as tilted: the
cells of a Voronoi texture turn the normal of a glossy metal. All under one sun of half a degree,
through Cycles' Blackman-Harris filter with the width of 1.5 pixels (it is three pixels wide).

The **sparkle layer** is the picture less the paint with Sparkle Contrast 0 (of the Voronoi flakes,
less the smooth surface nearest to the picture). Frames are rendered with other random samples each.
**Warped** means laid upon each other as the surface moves, by whole pixels. **Flicker** is the
share of the layer's variance with which a place of the surface changes over the frames: 0 where
sparkles stay, 1 where every frame has others. Bars hold for the surface anchor.
"""

CAPTIONS = {
    "turntable": "A turning ball. The strip shows every second frame, enlarged: half a degree. A "
    "flake sparkles while its mirror direction passes the eye, for some frames, then others do. "
    "Measured on the middle of a large ball, two pixels a frame; the turn is told in radii of the "
    "cone in which a flake sparkles.",
    "dolly": "From 0.3 m to 30 m before a plane, every fourth frame. Measured with fewer flakes, "
    "one in a pixel at first, under a lamp of 30°. The variance per flake is the variance of the "
    "pixels over their mean, times the squared distance.",
    "pan": "The camera slides two pixels a frame. The strip shows the middle of frames one after "
    "the other, enlarged.",
    "sun": "A moving sun; every second frame, enlarged. Measured on a plane, where the half-way "
    "direction turns by a quarter of the cone in a frame.",
    "blur": "The object or the camera moves by eight pixels while the shutter is open. From two "
    "renders each, so that the samples' noise drops out.",
    "law": "Planes under a sun, orthographic, four presets (in Blender 5 one): the mean and the "
    "variance of pixels over footprints of 0.01 to a million flakes, slants to 50 to 1 and three "
    "turns of the view against the cells' lattice; 64 samples, fewer and more pixels where flakes "
    "are rarer than pixels. The variance is that of point flakes through the same filter; where a "
    "cell has fewer than 64 flake areas, of discs that hide each other from the observer.",
    "panorama": "An equirectangular camera near a plane. The pixel anchor shows a mosaic there: a "
    "panorama's raster is another one than the shader's.",
}


@dataclass(frozen=True)
class Found:
    """The rows of one motion in one Blender."""

    blender: str
    motion: str
    rows: list[Row]

    def bars(self) -> Iterator[bars.Bar]:
        for row in self.rows:
            yield from row.bars(f"Blender {self.blender}, {self.motion}")


def measure(blender: Blender, motion: str, quick: bool) -> Found:
    part = WORK / f"{motion}-{blender.version}.json"
    program = [blender.python, TOOLS, "motion.measure", motion, "--json", part]
    _run(f"Measuring {motion} in Blender {blender.version}", [*program, *["--quick"] * quick])
    read = json.loads(part.read_text(encoding="utf-8"))
    return Found(read["blender"], motion, [Row(**row) for row in read["rows"]])


def film(folder: Path, quick: bool) -> None:
    for material in MATERIALS:
        program = [FIRST_BLENDER.python, TOOLS, "motion.film_frames", material]
        program += ["--out", WORK / f"{material}.npz"]
        _run(f"Filming {material}", [*program, *["--quick"] * quick])
    program = [environments.ACCURACY.python, TOOLS, "motion.pictures"]
    _run("Cutting the film", [*program, "--frames", WORK, "--out", folder])


def _run(what: str, command: list[str | Path]) -> None:
    say(f"{what}…")
    run_measurement(what, command)


def report(found: Sequence[Found]) -> Iterator[str]:
    yield from (MOTION.mark, "", "# Sparkles in motion", "", f"![the film]({FILM})", "", ABOUT)
    for motion in MEASURED:
        yield from (f"## {motion.capitalize()}", "", CAPTIONS[motion], "")
        if motion in FILMED:
            yield from (f"![{motion}]({strip_of(motion)})", "")
        parts = [part for part in found if part.motion == motion]
        yield from table(
            ["", "Blender", *MATERIALS, "bar"],
            (
                [row.quantity, part.blender, *(_number(row.values.get(m)) for m in MATERIALS),
                 _bar(row)]
                for rows in zip(*(part.rows for part in parts), strict=True)
                for part, row in zip(parts, rows, strict=True)
            ),
        )  # fmt: skip


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3f}".replace("-", "−")


def _bar(row: Row) -> str:
    return "" if row.limit is None else f"{row.bound} {row.limit:g}"


def main() -> int:
    parser = argparse.ArgumentParser(prog="paint motion", description=__doc__)
    parser.add_argument(
        "--out", type=Path, default=ROOT / "out" / "motion", metavar="DIR",
        help="folder for README.md, the film and its strips (out/motion)",
    )  # fmt: skip
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the bars to FILE too")
    parser.add_argument(
        "--quick", action="store_true", help="small pictures and few, in the first Blender alone"
    )
    arguments = parser.parse_args()

    start = time.monotonic()
    quick = arguments.quick
    MOTION.check(arguments.out)
    if arguments.json:
        check_file(arguments.json, arguments.out)
    environments.prepare_tool(environments.ACCURACY)
    if quick:
        environments.prepare(FIRST_BLENDER)
    blenders = [FIRST_BLENDER] if quick else environments.prepare_blenders()
    shutil.rmtree(WORK, ignore_errors=True)
    WORK.mkdir(parents=True)
    with MOTION.fill(arguments.out) as folder:
        found = [measure(b, motion, quick) for b in blenders for motion in MEASURED]
        film(folder, quick)
        (folder / REPORT).write_text("\n".join(report(found)), encoding="utf-8")
    judged = [bar for part in found for bar in part.bars()]
    return bars.conclude(judged, arguments.json, arguments.out / REPORT, start)


if __name__ == "__main__":
    run_program(main)
