# SPDX-License-Identifier: Apache-2.0
"""Renders the gallery: a sheet of all presets, the car in four lights, near and far, a film."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from common import environments
from common.processes import (
    ROOT,
    TOOLS,
    StepFailedError,
    describe,
    run_limited,
    run_program,
    run_step,
    say,
)
from common.report_folder import GALLERY, REPORT
from metallic_paint.paint import presets

SECONDS = 3600  # for one picture

FILM = "turntable"
CAPTIONS = {
    "swatches": "Paints under a sun and the light of a courtyard (one of the surroundings that "
    "come with Blender). The ball is 40 mm wide: what one sees at arm's length.",
    "car-sun": "deep-blue on a sunny morning (in one of Blender's surroundings): sparkles crowd on "
    "the nose, where the flakes mirror the sun, and thin out towards the dark flank.",
    "car-sky": "silver-coarse under a low sun and the sky: the flop from the light flank to the "
    "dark bonnet.",
    "car-surroundings": "green-purple in a wood (one of Blender's surroundings): green where one "
    "looks straight at it, blue and purple aslant.",
    "car-studio": "candy-red in the studio of `./paint demo`: softboxes, whose edges draw the "
    "body's lines, and a small lamp, about whose mirror image the sparkles crowd.",
    "macro": "Near by, aslant through a lens wide open, in a soft lamp's light: 2.5 mm of "
    "silver-coarse, 1 mm of green-purple, 5 mm of glass-flake-black, 10 mm of bass-boat. Flakes "
    "are seen as such, and are discs of blur where they are out of focus.",
    "distance": "silver-coarse through one lens from 1 m, 10 m and 100 m: sparkles, then a grain, "
    "then the flop alone. The last is enlarged 8 times.",
    FILM: "candy-red on a turntable that swings by five degrees: sparkles ride on the paint, and "
    "flash where the lamp's mirror image passes.",
}


def file_of(picture: str) -> str:
    return f"{picture}.{'webp' if picture == FILM else 'jpg'}"


def chosen(only: str) -> dict[str, list[str]]:
    """The pictures to make, and the presets in each that shows a choice of them."""
    names = presets.names()
    pictures = {picture: names for picture in CAPTIONS if only in picture}
    some = [name for name in names if only in name]
    if not pictures and some:
        pictures = {"swatches": some}
    if not pictures:
        raise StepFailedError(
            f"--only {only}: no picture or preset has that in its name; the pictures are "
            f"{', '.join(CAPTIONS)}."
        )
    return pictures


def report(pictures: Sequence[str], shown: Sequence[str]) -> Iterator[str]:
    """The lines of the folder's index."""
    yield from (GALLERY.mark, "", "# Gallery", "")
    yield (
        "Rendered with Cycles, view transform AgX, all but the sparkles denoised by the add-on, no "
        "clamping of direct light. `./paint gallery` makes it again."
    )
    yield ""
    for picture in pictures:
        yield from (f"![{picture}]({file_of(picture)})", "", CAPTIONS[picture], "")
    if "swatches" in pictures:
        yield from ("| preset | what it is |", "| --- | --- |")
        for name in shown:
            content = json.loads((presets.FOLDER / f"{name}.json").read_text(encoding="utf-8"))
            yield f"| {name} | {content['description']} |"
        yield ""


def make_film(frames: Path) -> None:
    """Of the frames in the file, in its place."""
    environments.prepare_tool(environments.ACCURACY)  # it has Pillow
    command = [environments.ACCURACY.python, TOOLS, "pictures.film", frames]
    run_step("Making the film", [*command, "--out", frames.with_suffix(".webp")], "film.log")
    frames.unlink()


def main() -> int:
    parser = argparse.ArgumentParser(prog="paint gallery", description=__doc__)
    parser.add_argument(
        "--out", type=Path, default=ROOT / "out" / "gallery", metavar="DIR",
        help="folder for README.md and its pictures (out/gallery)",
    )  # fmt: skip
    parser.add_argument(
        "--only", default="", metavar="TEXT",
        help="the pictures with TEXT in their name, or a sheet of the presets with it in theirs",
    )  # fmt: skip
    parser.add_argument(
        "--quick", action="store_true", help="small pictures, few samples, three presets"
    )
    arguments = parser.parse_args()

    start = time.monotonic()
    pictures = chosen(arguments.only)
    shown = next(iter(pictures.values()))
    if arguments.quick:
        shown = shown[:: -(-len(shown) // 3)]
    GALLERY.check(arguments.out)
    program = [sys.executable, TOOLS, "pictures.gallery_pictures"]
    with GALLERY.fill(arguments.out) as folder:
        for number, picture in enumerate(pictures, 1):
            say(f"{picture} ({number} of {len(pictures)})…")
            # One process each: a Blender that has rendered much is slow to end, and may hang.
            file = folder / file_of(picture)
            if picture == FILM:
                file = file.with_suffix(".npy")
            command = [*program, picture, "--out", file]
            command += ["--quick"] * arguments.quick
            code = run_limited([*command, "--presets", *shown], seconds=SECONDS)
            if code != 0:
                raise StepFailedError(f"{picture} failed ({describe(code)}); nothing was written.")
            if picture == FILM:
                make_film(file)
        lines = report(list(pictures), shown)
        (folder / REPORT).write_text("\n".join(lines), encoding="utf-8")
    say(f"{arguments.out / REPORT}, {time.monotonic() - start:.0f} s in all")
    return 0


if __name__ == "__main__":
    run_program(main)
