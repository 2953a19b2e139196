# SPDX-License-Identifier: Apache-2.0
"""Makes of frames in a file of an array an animated WebP that plays them to and fro."""

from __future__ import annotations

import argparse
import io
from pathlib import Path

import numpy as np
from common.processes import run_program
from PIL import Image

MILLISECONDS = 83  # of a frame: 12 in a second
MOST_BYTES = 1_900_000  # a picture of the repository is small


def encoded(frames: list[Image.Image], most: int = MOST_BYTES) -> bytes:
    """As good as the bytes allow."""
    for quality in range(90, 20, -5):
        film = io.BytesIO()
        frames[0].save(film, "WEBP", save_all=True, append_images=frames[1:], loop=0,
                       duration=MILLISECONDS, quality=quality, method=5)  # fmt: skip
        if film.tell() <= most:
            break
    return film.getvalue()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("frames", type=Path, help="(n, h, w, 3), 8 bits")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    there = [Image.fromarray(frame) for frame in np.load(arguments.frames)]
    arguments.out.write_bytes(encoded([*there, *there[-2:0:-1]]))
    return 0


if __name__ == "__main__":
    run_program(main)
