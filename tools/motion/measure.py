# SPDX-License-Identifier: Apache-2.0
"""Measures the sparkles of one motion in this Blender; run.py makes bars and tables of the rows."""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from common import blender_env

blender_env.prepare()

import bpy  # noqa: E402
import numpy as np  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402
from pictures import render_scene  # noqa: E402
from pictures.render_scene import say  # noqa: E402

from motion import law_of_pixels, layer  # noqa: E402
from motion.rows import MATERIALS, MEASURED, Row  # noqa: E402
from motion.scenes import (  # noqa: E402
    BEHIND_CAMERA,
    MEAN,
    PAINT,
    PIXEL,
    RIGHT,
    TOWARDS_CAMERA,
    TOWARDS_SUN,
    UP,
    Stage,
    cones_turned,
)

SAMPLES, MORE_SAMPLES = 64, 256
MEAN_SAMPLES = 16  # of the closed form, which is all but free of noise
SHIFT = 2  # pixels that the surface moves in a frame
QUARTER = 0.25  # of the cone: what the half-way direction may turn in a frame
FAR_AWAY = 60  # frames after which it has turned by many cones

Layers = dict[str, list[np.ndarray]]  # of each material, frame by frame


@dataclass(frozen=True)
class Effort:
    size: int  # pixels along each side of a picture
    frames: int
    distances: int  # of the dolly, in an octave
    mean_error: float  # standard error that a mean of the dolly may have


FULL = Effort(size=112, frames=6, distances=2, mean_error=0.0025)
QUICK = Effort(size=48, frames=4, distances=1, mean_error=0.02)


# ---- Frames that show the same surface, warped upon each other ----


def pan(effort: Effort) -> Iterator[Row]:
    """The camera slides along a plane."""
    stage = Stage(effort.size)
    stage.add_plane(1)
    start = stage.camera.location.copy()

    def place(frame: float) -> None:
        stage.camera.location = start - frame * SHIFT * PIXEL * RIGHT

    rows, seen = compare_frames(stage, place, SHIFT, effort.frames)
    yield from rows
    flicker = {name: layer.flicker(each, SHIFT) for name, each in seen.items()}
    yield Row("flicker of the warped frames", flicker)
    for other, limit in (("pixel", 0.1), ("Voronoi", 1)):
        times = {"surface": flicker["surface"] / flicker[other]}
        yield Row(f"flicker over that of {other}", times, limit, "at most")
    place(0)
    shots = []
    for frame in (1, 25):
        stage.scene.frame_set(frame)
        shots.append(stage.shoot(SAMPLES))
    same = {"surface": float((shots[0] == shots[1]).mean())}
    yield Row("nothing moves: share of pixels as in another frame", same, 1, "at least")


RADIUS = 1000  # pixels: so large that the whole picture moves alike, within 0.2 % of the shift


def turntable(effort: Effort) -> Iterator[Row]:
    """A ball turns; the picture is the middle of it, the sun behind the camera."""
    stage = Stage(effort.size)
    stage.turn_sun(BEHIND_CAMERA)
    radius, step = RADIUS * PIXEL, SHIFT / RADIUS
    stage.add_ball(radius, -radius * TOWARDS_CAMERA)
    still = stage.thing.matrix_world.copy()
    centre = Matrix.Translation(still.translation)

    def place(frame: float) -> None:
        turned = Matrix.Rotation(frame * step, 4, UP)
        stage.thing.matrix_world = centre @ turned @ centre.inverted() @ still

    back = Matrix.Rotation(-step, 3, UP)  # how all else moves for one who sits on the ball
    after = back @ TOWARDS_CAMERA, back @ BEHIND_CAMERA
    yield turn_row(cones_turned(TOWARDS_CAMERA, (TOWARDS_CAMERA, BEHIND_CAMERA), after))
    rows, _ = compare_frames(stage, place, SHIFT, effort.frames // 2)
    yield from rows
    yield from turn_away_and_back(stage, place)


def sun(effort: Effort) -> Iterator[Row]:
    """The sun moves over a plane, and with it the half-way direction."""
    stage = Stage(effort.size)
    stage.add_plane(1)
    across = TOWARDS_SUN.orthogonal()

    def towards(angle: float) -> Vector:
        return Matrix.Rotation(angle, 3, across) @ TOWARDS_SUN

    def cones(angle: float) -> float:
        after = TOWARDS_CAMERA, towards(angle)
        return cones_turned(Vector((0, 0, 1)), (TOWARDS_CAMERA, TOWARDS_SUN), after)

    step = QUARTER * 1e-3 / cones(1e-3)

    def place(frame: float) -> None:
        stage.turn_sun(towards(frame * step))

    yield turn_row(cones(step))
    rows, _ = compare_frames(stage, place, 0, effort.frames // 2)
    yield from rows
    yield from turn_away_and_back(stage, place)


def turn_row(cones: float) -> Row:
    return Row("turn of the half-way direction in a frame, in cones", {"surface": cones})


def compare_frames(
    stage: Stage, place: Callable[[float], None], shift: int, frames: int
) -> tuple[list[Row], Layers]:
    """Each frame has samples of its own. place() moves the surface `shift` pixels right a frame.

    The surface anchor's material comes last and stays on.
    """
    stage.put_on(MEAN)
    means = []
    for frame in range(frames):
        place(frame)
        means.append(stage.shoot(MEAN_SAMPLES))

    def layers(name: str, samples: int, count: int) -> list[np.ndarray]:
        found = []
        for frame in range(count):
            place(frame)
            picture = stage.shoot(samples, seed=frame + 1)
            mean = layer.smooth(picture) if name == "Voronoi" else means[frame]
            found.append(picture - mean)
        return found

    seen = {}
    for name in MATERIALS:
        say(f"  {name}")
        stage.put_on(name)
        seen[name] = layers(name, SAMPLES, frames)
    finer = layers("surface", MORE_SAMPLES, 2)
    warped = {name: layer.neighbours(each, shift) for name, each in seen.items()}
    more = {"surface": layer.neighbours(finer, shift)}
    what = "correlation of neighbouring frames"
    rows = [
        Row(f"{what}, warped, {SAMPLES} samples", warped, 0.9, "at least"),
        Row(f"{what}, warped, {MORE_SAMPLES} samples", more, 0.95, "at least"),
    ]
    if shift:
        same = {name: layer.neighbours(each, 0) for name, each in seen.items()}
        rows.append(Row(f"{what}, at the same pixel", same))
    return rows, seen


def turn_away_and_back(stage: Stage, place: Callable[[float], None]) -> Iterator[Row]:
    """With the material that is on, the surface anchor's."""
    shots = []
    for frame in (0, FAR_AWAY, 0):
        place(frame)
        shots.append(stage.shoot(SAMPLES))
    start, away, back = shots
    changed = layer.correlation(start - layer.smooth(start), away - layer.smooth(away))
    yield Row(
        "turned far away: correlation with the start, at the same pixel", {"surface": changed}
    )
    same = {"surface": float((start == back).mean())}
    yield Row("turned back: share of pixels as at the start", same, 1, "at least")


# ---- Motion blur ----

STREAK = 8  # pixels


def blur(effort: Effort) -> Iterator[Row]:
    """A plane moves past the camera, or the camera past the plane, while the shutter is open."""
    stage = Stage(effort.size)
    stage.add_plane(1)
    stage.put_on(MEAN)
    mean = stage.shoot(MEAN_SAMPLES).mean()
    stage.scene.render.use_motion_blur = True
    stage.scene.render.motion_blur_shutter = 0.5  # of a frame
    along: dict[str, dict[str, np.ndarray]] = {"object": {}, "camera": {}}
    for name in ("pixel", "surface"):
        say(f"  {name}")
        stage.put_on(name)
        for moved, thing in (("object", stage.thing), ("camera", stage.camera)):
            still = thing.location.copy()
            for frame in range(-1, 4):  # about each key but the outermost the motion is even
                thing.location = still + (frame - 1) * 2 * STREAK * PIXEL * RIGHT
                thing.keyframe_insert("location", frame=frame)
            stage.scene.frame_set(1)
            a, b = (stage.shoot(SAMPLES, seed) - mean for seed in (1, 2))
            along[moved][name] = layer.autocorrelation(a, b, STREAK)
            thing.animation_data_clear()
            thing.location = still
    for moved, streaks in along.items():
        half = {name: float(streak[STREAK // 2 - 1]) for name, streak in streaks.items()}
        yield Row(f"moved {moved}: autocorrelation at half the streak", half)
    apart = {
        name: float(np.abs(streak - along["camera"][name]).max())
        for name, streak in along["object"].items()
    }
    yield Row("autocorrelations apart, of all distances along the streak", apart, 0.1, "at most")


# ---- Dolly ----

NEAREST, FARTHEST = 0.3, 30.0
SLOPE = 0.05  # of the lens: half the picture's width over the distance
LAMP = math.radians(30)  # so wide that many of the few flakes in a pixel are lit
FEW_SAMPLES = 8


def dolly(effort: Effort) -> Iterator[Row]:
    """The camera draws back from a plane. Nearest, a pixel holds one flake."""
    size = 2 * effort.size
    pixel = 2 * SLOPE * NEAREST / size
    one_flake = TOWARDS_CAMERA.z / (pixel * 1e3) ** 2  # on the plane that the camera looks down at
    # A coat of index 1, which mirrors nothing: the lamp's own image would lie over the flakes.
    sparse = dataclasses.replace(PAINT, flakes_per_mm2=one_flake, binder_ior=1)
    stage = Stage(size, sparse, LAMP)
    stage.add_plane(200)
    stage.look_through_lens(2 * math.atan(SLOPE))
    count = round(effort.distances * math.log2(FARTHEST / NEAREST)) + 1
    distances = np.geomspace(NEAREST, FARTHEST, count)

    def place(distance: float) -> None:
        stage.camera.location = distance * TOWARDS_CAMERA

    closed = []
    stage.put_on(MEAN)
    for distance in distances:
        place(distance)
        closed.append(stage.shoot(FEW_SAMPLES))
    stage.put_on("surface")
    found = []
    for distance, mean in zip(distances, closed, strict=True):
        say(f"  {distance:.2g} m")
        place(distance)
        found.append(moments(stage, mean, effort.mean_error))
    means, errors, variances = np.transpose(found)
    # Poisson: a pixel of d times the width has d^2 times the flakes.
    steps = np.abs(np.diff(np.log(variances * distances**2)))
    off = np.abs(means - 1)
    yield Row("mean off the closed form, of all distances", {"surface": off.max()}, 0.01, "at most")
    yield Row("its standard error, of all distances", {"surface": errors.max()})
    yield Row("step of the variance per flake, of all distances", {"surface": steps.max()}, 0.1,
              "at most")  # fmt: skip


def moments(stage: Stage, closed: np.ndarray, most_error: float) -> tuple[float, float, float]:
    """Mean of the pixels over the closed form, its standard error, and their variance.

    Of as many places of the plane as the error asks for. The variance is the covariance of two
    renders with other samples: their noise drops out.
    """
    first, second = [], []
    error = math.inf
    while error > most_error:
        stage.thing.location.x = len(first)
        for seed, shots in ((1, first), (2, second)):
            shots.append(stage.shoot(FEW_SAMPLES, seed) / closed)
        both = (np.array(first) + np.array(second)) / 2
        error = both.std() / math.sqrt(both.size)
    stage.thing.location.x = 0
    return both.mean(), error, np.cov(np.ravel(first), np.ravel(second))[0, 1]


# ---- Panorama ----

AROUND = 1024  # pixels
HORIZON = 35  # degrees below it the picture begins, and goes on for effort.size pixels


def panorama(effort: Effort) -> Iterator[Row]:
    """An equirectangular camera over a plane, of which the picture is the part below the sun."""
    stage = Stage(effort.size)
    stage.add_plane(1)
    stage.look_around(AROUND, below=math.radians(HORIZON))
    stage.put_on(MEAN)
    mean = stage.shoot(MEAN_SAMPLES)
    apart = {}
    for name in ("pixel", "surface"):
        say(f"  {name}")
        stage.put_on(name)
        a, b = (stage.shoot(SAMPLES, seed) - mean for seed in (1, 2))
        # Cycles' filter is 3 pixels wide, and all but nothing from 2 on: a cell that both show is
        # too wide.
        across, down = (layer.autocorrelation(*pair, 2)[1] for pair in ((a, b), (a.T, b.T)))
        apart[name] = float(max(across, down))
    yield Row("correlation of pixels two apart", apart, 0.1, "at most")


# ---- Mean and variance of pixels that stand still ----


def law(effort: Effort) -> Iterator[Row]:
    """The first Blender has all presets."""
    whole = effort is FULL and bpy.app.version < (5,)
    names = law_of_pixels.PRESETS if whole else law_of_pixels.PRESETS[:1]
    yield from law_of_pixels.law(2 * effort.size // 3, names)


MEASURES = dict(zip(MEASURED, (turntable, dolly, pan, sun, blur, panorama, law), strict=True))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("motion", choices=MEASURED)
    parser.add_argument("--json", type=Path, required=True)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    with render_scene.quiet():
        rows = list(MEASURES[arguments.motion](QUICK if arguments.quick else FULL))
    report = {
        "blender": bpy.app.version_string.removesuffix(" LTS"),
        "rows": [dataclasses.asdict(row) for row in rows],
    }
    arguments.json.write_text(json.dumps(report), encoding="utf-8")


if __name__ == "__main__":
    render_scene.run(main)
