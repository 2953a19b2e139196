# SPDX-License-Identifier: Apache-2.0
"""Pictures whose instructions Valgrind counts: the program that instructions.py runs under it.

Callgrind counts nothing until it is told to, and writes a file of each picture, whose trigger has
the picture's name.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable

from common import blender_env

blender_env.prepare()

import bpy  # noqa: E402
from metallic_paint.paint import material  # noqa: E402
from pictures import render_scene  # noqa: E402
from verification import scenes  # noqa: E402

from bench import materials  # noqa: E402
from bench.growth import SUNS  # noqa: E402
from bench.instructions import (  # noqa: E402
    FEW,
    FIRST,
    LIGHTS,
    MANY,
    ONE_SPECIES,
    PAINT,
    PRINCIPLED,
    SIZE,
    STARTS,
    TWO_SPECIES,
    picture_name,
)
from bench.samples import ONE, TWO  # noqa: E402
from bench.samples import PAINT as BY_DEFAULT  # noqa: E402
from bench.stage import Stage  # noqa: E402

CONTENDERS: dict[str, Callable[[], bpy.types.Material]] = {
    PRINCIPLED: materials.principled,
    PAINT: lambda: material.create(BY_DEFAULT),
    ONE_SPECIES: lambda: material.create(ONE),
    TWO_SPECIES: lambda: material.create(TWO),
}


def count(stage: Stage, contender: str, name: str, samples: int) -> None:
    """The contender's picture, in a file that is called so."""
    _control("--instr=on")
    stage.render(contender, samples)
    _control(f"--dump={name}")
    _control("--instr=off")


def _control(order: str) -> None:
    subprocess.run(["callgrind_control", order, str(os.getpid())], check=True, capture_output=True)


def count_all() -> None:
    for picture, name in ((STARTS, PRINCIPLED), (PRINCIPLED, PRINCIPLED), (PAINT, PAINT)):
        alone = Stage([scenes.SUN], sky=1, threads=1)
        alone.add(name, [CONTENDERS[name]()], SIZE)
        alone.fit()
        count(alone, name, picture_name(picture, FIRST), FEW)
    together = Stage([scenes.SUN], sky=1, threads=1)
    for name, make in CONTENDERS.items():
        together.add(name, [make()], SIZE)
    together.fit()
    for name in CONTENDERS:
        together.render(name, FEW)  # compiles
        for samples in (FEW, MANY):
            count(together, name, picture_name(name, samples), samples)
    lit = Stage(SUNS, threads=1)
    lit.add(PAINT, [material.create(BY_DEFAULT)], SIZE)
    for lights in LIGHTS:
        lit.light_with(lights)
        lit.render(PAINT, FEW)
        for samples in (FEW, MANY):
            count(lit, PAINT, picture_name(f"{PAINT} under {lights} lights", samples), samples)


def main() -> None:
    with render_scene.quiet():
        count_all()


if __name__ == "__main__":
    render_scene.run(main)
