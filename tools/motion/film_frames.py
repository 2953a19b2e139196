# SPDX-License-Identifier: Apache-2.0
"""Renders the film's frames in one material, motion after motion, to a file of arrays."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path

from common import blender_env

blender_env.prepare()

import bpy  # noqa: E402, F401 (mathutils is a part of it)
import numpy as np  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402
from pictures import render_scene  # noqa: E402
from pictures.render_scene import say  # noqa: E402

from motion.rows import FILMED, MATERIALS  # noqa: E402
from motion.scenes import BEHIND_CAMERA, PIXEL, RIGHT, TOWARDS_CAMERA, UP, Stage  # noqa: E402

SIZE, FRAMES = 144, 24
QUICK_SIZE, QUICK_FRAMES = 48, 6
SAMPLES = 12
BALL = 0.02  # radius, m
SKY = 0.3  # radiance from everywhere
WHITE = 5.0  # radiance that the film shows as white; sparkles are brighter

Place = Callable[[int], None]  # sets a frame


def turntable(stage: Stage, frames: int) -> Place:
    """A ball turns by a quarter of a degree in a frame: a flake flashes for some frames."""
    _show_ball(stage, 1.3 * BALL)
    still = stage.thing.matrix_world.copy()

    def place(frame: int) -> None:
        turned = Matrix.Rotation(math.radians(0.25) * frame, 4, UP)
        stage.thing.matrix_world = turned @ still

    return place


def sun(stage: Stage, frames: int) -> Place:
    """It moves by half a degree in a frame."""
    _show_ball(stage, 1.3 * BALL)

    def place(frame: int) -> None:
        stage.turn_sun(Matrix.Rotation(math.radians(0.5) * frame, 3, UP) @ BEHIND_CAMERA)

    return place


def pan(stage: Stage, frames: int) -> Place:
    """The camera slides by two pixels in a frame, nearer to the ball."""
    _show_ball(stage, stage.size * PIXEL)
    middle = stage.camera.location.copy()

    def place(frame: int) -> None:
        stage.camera.location = middle - (2 * frame - frames) * PIXEL * RIGHT

    return place


def _show_ball(stage: Stage, width: float) -> None:
    """The middle of a ball, in a picture so many metres wide."""
    stage.add_ball(BALL, Vector())
    stage.turn_sun(BEHIND_CAMERA)
    stage.camera.data.ortho_scale = width


def dolly(stage: Stage, frames: int) -> Place:
    """From 0.3 m to 30 m, in each frame farther by the same factor, before a plane."""
    stage.add_plane(200)
    stage.look_through_lens(math.radians(6))

    def place(frame: int) -> None:
        stage.camera.location = 0.3 * 100 ** (frame / (frames - 1)) * TOWARDS_CAMERA

    return place


SHOTS = dict(zip(FILMED, (turntable, dolly, pan, sun), strict=True))


def film(motion: str, material: str, size: int, frames: int) -> np.ndarray:
    """(frames, size, size, 3), 8 bits, row 0 at the top."""
    stage = Stage(size)
    stage.set_sky(SKY)
    place = SHOTS[motion](stage, frames)
    stage.put_on(material)
    shots = []
    for frame in range(frames):
        place(frame)
        shots.append(stage.picture(SAMPLES, seed=frame)[::-1])
    return (255 * np.clip(np.array(shots) / WHITE, 0, 1) ** (1 / 2.2)).astype(np.uint8)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("material", choices=MATERIALS)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    size, frames = (QUICK_SIZE, QUICK_FRAMES) if arguments.quick else (SIZE, FRAMES)
    films = {}
    with render_scene.quiet():
        for motion in FILMED:
            say(f"  {motion}")
            films[motion] = film(motion, arguments.material, size, frames)
    np.savez(arguments.out, **films)


if __name__ == "__main__":
    render_scene.run(main)
