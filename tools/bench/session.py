# SPDX-License-Identifier: Apache-2.0
"""What one artist waits for in one fresh Blender: the program that waits.py runs again and again.

Processor times in seconds of pictures of one sample, so small that they cost nothing themselves.
"""

from __future__ import annotations

import argparse
import json
import resource
import statistics
import time
from pathlib import Path

from common import blender_env

blender_env.prepare()

import bpy  # noqa: E402
from metallic_paint.paint import live, material, presets  # noqa: E402
from pictures import render_scene  # noqa: E402
from verification import scenes  # noqa: E402

from bench import materials, shared  # noqa: E402
from bench.paints import of_flakes, varied  # noqa: E402
from bench.stage import Stage  # noqa: E402

SIZE = 16  # pixels along each side
FRAMES = 4
STEP = 0.01  # rad, of the sun; of roughness and tilt the same number


def make(contender: str, count: int) -> list[bpy.types.Material]:
    if contender == "principled":
        made = [materials.principled() for _ in range(count)]
        for i, each in enumerate(made):
            each.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value += STEP * i
        return made
    if contender == "shared":
        return [shared.linked_paint()]
    if contender == "presets":
        paints = [presets.load(name) for name in presets.names()[:count]]
    elif contender in ("varied", "live"):
        paints = varied(count)
    else:
        paints = [of_flakes(float(contender))]
    made = [material.create(paint) for paint in paints]
    if contender == "live":
        for each, paint in zip(made, paints, strict=True):
            live.begin(material.paint_node(each), paint)
    return made


def stand(stage: Stage, contender: str, made: list[bpy.types.Material], count: int) -> None:
    """The materials on one object; or one on as many objects, each with a preset of its own."""
    stage.add("all", made, SIZE)
    if contender == "shared":
        names = presets.names()[:count]
        things = [bpy.data.objects["all"]]
        for name in names[1:]:
            stage.add(name, made, SIZE)
            things.append(bpy.data.objects[name])
        for thing, name in zip(things, names, strict=True):
            shared.give(thing, shared.sockets_of(presets.load(name)))


def step_slider(contender: str, made: bpy.types.Material) -> None:
    if contender == "shared":
        thing = bpy.data.objects["all"]
        shared.give(thing, {"Tilt": thing["Tilt"] + STEP})
    elif material.has_paint(made):
        tilt = material.paint_node(made).inputs["Tilt"]
        live.set_value(tilt, live.value(tilt) + STEP)
    else:
        made.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value += STEP


def wait(contender: str, count: int, steps: int) -> dict[str, float]:
    stage = Stage([scenes.SUN], sky=1.0)
    start = time.process_time()
    made = make(contender, count)
    waits = {"made": time.process_time() - start}
    stand(stage, contender, made, count)
    stage.fit()
    [sun] = stage.lamps
    waits["first"] = stage.render("all", 1)
    waits["peak"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0  # bytes
    if not steps:
        return waits
    sliders, moves, frames = [], [], []
    for _ in range(steps):
        step_slider(contender, made[0])
        sliders.append(stage.render("all", 1))
    for _ in range(steps):
        sun.rotation_euler.x += STEP
        moves.append(stage.render("all", 1))
    for frame in range(FRAMES * steps):
        sun.rotation_euler.x += STEP
        sun.keyframe_insert("rotation_euler", frame=frame)
    stage.render("all", 1)
    for frame in range(FRAMES * steps):
        stage.scene.frame_set(frame)
        frames.append(stage.render("all", 1))
    return waits | {
        "slider": statistics.median(sliders),
        "move": statistics.median(moves),
        "frame": statistics.median(frames),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "contender", help="principled, varied, live, presets, shared, or a number of flakes per m²"
    )
    parser.add_argument("--count", type=int, default=1, help="paints or materials")
    parser.add_argument("--steps", type=int, default=0, help="of sliders and lamps")
    parser.add_argument("--json", type=Path, required=True)
    arguments = parser.parse_args()
    with render_scene.quiet():
        waits = wait(arguments.contender, arguments.count, arguments.steps)
    arguments.json.write_text(json.dumps(waits), encoding="utf-8")


if __name__ == "__main__":
    render_scene.run(main)
