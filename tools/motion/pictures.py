# SPDX-License-Identifier: Apache-2.0
"""Puts the frames of all materials side by side: a film of all motions, and a strip of each."""

from __future__ import annotations

import argparse
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from common.processes import run_program
from PIL import Image, ImageDraw, ImageFont

from motion.rows import FILM, FILMED, MATERIALS, strip_of

GAP = 4  # pixels between panels
HEAD = 20  # of the words above them
DARK = (24, 24, 24)
MILLISECONDS = 83  # of a frame: 12 in a second
MOST_FILM, MOST_STRIP = 1_900_000, 190_000  # bytes: a picture of the repository is small
COLUMNS = 6  # of a strip
# Frames from a column of a strip to the next; how much its panels, a frame's middle, are enlarged.
STRIPS = {"turntable": (2, 3), "dolly": (4, 1), "pan": (1, 3), "sun": (2, 3)}

Panels = Sequence[np.ndarray]


def sheet(rows: Sequence[Panels], heads: Sequence[str], sides: Sequence[str]) -> Image.Image:
    """Panels of one size, with words above each column and in the corner of each row."""
    h, w = rows[0][0].shape[:2]
    size = (len(rows[0]) * (w + GAP) - GAP, HEAD + len(rows) * (h + GAP) - GAP)
    picture = Image.new("RGB", size, DARK)
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(13)
    for i, row in enumerate(rows):
        for j, panel in enumerate(row):
            picture.paste(Image.fromarray(panel), (j * (w + GAP), HEAD + i * (h + GAP)))
    for j, words in enumerate(heads):
        draw.text((j * (w + GAP) + w / 2, HEAD / 2), words, "white", font, anchor="mm")
    for i, words in enumerate(sides):
        at = (4, HEAD + i * (h + GAP) + h - 4)
        draw.text(at, words, "white", font, anchor="ld", stroke_width=2, stroke_fill=DARK)
    return picture


def middle(frame: np.ndarray, times: int) -> np.ndarray:
    """The middle of the frame, each of its pixels so many wide; as large as the frame."""
    size = frame.shape[0] // times
    low = (frame.shape[0] - size) // 2
    part = frame[low : low + size, low : low + size]
    return part.repeat(times, axis=0).repeat(times, axis=1)


def strip(motion: str, films: dict[str, dict[str, np.ndarray]]) -> Image.Image:
    step, times = STRIPS[motion]
    frames = range(0, len(films[MATERIALS[0]][motion]), step)[:COLUMNS]
    rows = [[middle(films[name][motion][k], times) for k in frames] for name in MATERIALS]
    return sheet(rows, [f"frame {k}" for k in frames], MATERIALS)


def film(films: dict[str, dict[str, np.ndarray]]) -> list[Image.Image]:
    count = len(films[MATERIALS[0]][FILMED[0]])
    return [
        sheet(
            [[films[name][motion][k] for name in MATERIALS] for motion in FILMED], MATERIALS, FILMED
        )
        for k in range(count)
    ]


def write(pictures: Sequence[Image.Image], file: Path, most: int) -> None:
    """As good as the bytes allow."""
    kind, first, others = file.suffix[1:], pictures[0], list(pictures[1:])
    kind = {"jpg": "JPEG"}.get(kind, kind)
    more = {"save_all": True, "append_images": others, "duration": MILLISECONDS, "loop": 0}
    for quality in range(95, 20, -10):
        bytes_ = io.BytesIO()
        first.save(bytes_, kind, quality=quality, **(more if others else {"subsampling": 0}))
        if bytes_.tell() <= most:
            break
    file.write_bytes(bytes_.getvalue())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=Path, required=True, help="folder of film_frames.py's")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    films = {name: dict(np.load(arguments.frames / f"{name}.npz")) for name in MATERIALS}
    write(film(films), arguments.out / FILM, MOST_FILM)
    for motion in FILMED:
        write([strip(motion, films)], arguments.out / strip_of(motion), MOST_STRIP)
    return 0


if __name__ == "__main__":
    run_program(main)
