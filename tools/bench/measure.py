# SPDX-License-Identifier: Apache-2.0
"""Measures one part in this Blender; run.py asks for all of them."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from common import blender_env

blender_env.prepare()

import bpy  # noqa: E402
from pictures import render_scene  # noqa: E402

from bench import equal_error  # noqa: E402
from bench.absent_parts import absent_parts  # noqa: E402
from bench.error import render_all  # noqa: E402
from bench.growth import growth  # noqa: E402
from bench.noise import noise  # noqa: E402
from bench.rows import ABSENT, ERROR, SERIES, Found, Row, write  # noqa: E402
from bench.samples import samples  # noqa: E402


def absent(_quick: bool) -> Iterator[Row]:
    yield from absent_parts()


def error(quick: bool) -> Iterator[Row]:
    """The report draws the pictures' errors too."""
    render_all(SERIES, quick)
    yield from equal_error.rows(equal_error.load_all(SERIES))


MEASURES = {"samples": samples, "growth": growth, "noise": noise, ABSENT: absent, ERROR: error}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("part", choices=MEASURES)
    parser.add_argument("--json", type=Path, required=True)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    with render_scene.quiet():
        rows = list(MEASURES[arguments.part](arguments.quick))
    blender = "{}.{}".format(*bpy.app.version)
    write([Found(arguments.part, blender, rows)], arguments.json)


if __name__ == "__main__":
    render_scene.run(main)
