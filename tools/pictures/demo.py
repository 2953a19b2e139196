# SPDX-License-Identifier: Apache-2.0
"""Renders the demo model in one of the paints, to demo.exr and demo.png."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from common import blender_env

START = time.monotonic()
blender_env.prepare()

import bpy  # noqa: E402

from pictures import demo_model, render_scene, studio  # noqa: E402

PRESET = "deep-blue"


def main() -> None:
    parser = argparse.ArgumentParser(prog="paint demo", description=__doc__)
    parser.add_argument(
        "--preset", default=PRESET, metavar="P", help=f"name or JSON file of a paint ({PRESET})"
    )
    render_scene.add_arguments(parser)
    parser.add_argument(
        "--out", type=Path, default=Path("out"), metavar="DIR", help="folder for the files (out)"
    )
    arguments = parser.parse_args()

    paint = render_scene.load_paint(arguments.preset)
    files = [arguments.out / "demo.exr", arguments.out / "demo.png"]
    render_scene.check_outputs(files)
    with render_scene.quiet():
        render_scene.say("Building the car…")
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        render_scene.set_up_studio(scene)
        render_scene.set_up(scene, arguments.samples, arguments.width, None)
        car = demo_model.build_car(scene)
        render_scene.paint_objects([car], paint)
        studio.build(scene, car)
        render_scene.denoise_all_but_sparkles(scene)
        render_scene.render(scene, files, arguments.preset)
        render_scene.say(f"{time.monotonic() - START:.0f} s in all")


if __name__ == "__main__":
    render_scene.run(main)
