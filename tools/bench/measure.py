# SPDX-License-Identifier: Apache-2.0
"""Measures one part in this Blender; run.py asks for all of them."""

from __future__ import annotations

import argparse
from pathlib import Path

from common import blender_env

blender_env.prepare()

import bpy  # noqa: E402
from pictures import render_scene  # noqa: E402

from bench.growth import growth  # noqa: E402
from bench.rows import Found, write  # noqa: E402
from bench.samples import samples  # noqa: E402

MEASURES = {"samples": samples, "growth": growth}


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
