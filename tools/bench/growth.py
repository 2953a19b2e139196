# SPDX-License-Identifier: Apache-2.0
"""Time per sample against all that may grow."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import metallic_paint_core as core
import numpy as np
from metallic_paint.paint import Paint, core_paint, material
from pictures.render_scene import say
from verification import scenes

from bench.paints import of_flakes, shrunk, varied
from bench.rows import Row, nanoseconds, ratios
from bench.samples import ONE, TWO
from bench.stage import TOWARDS_CAMERA, WIDTH, Stage

FLAKES = (1e3, 1e6, 1e9, 1e12, 1e15)  # per m²
COUNTS = (0.01, 0.1, 1, 10, 100, 1e4, 1e6)  # ⟨N⟩ of a pixel
LIGHTS = (1, 2, 4, 8)
SIZES = (64, 128, 256, 512)  # pixels along each side
SUNS = tuple(scenes.sun(f"Sun {i}", 45 + 4 * i, 60 + 14 * i, 0.53) for i in range(max(LIGHTS)))

FLAT = 1.05  # the dearest over the cheapest, at most
OVER_COUNTS = 2
FURTHER_LIGHT = 0.15  # of the paint's time under one


@dataclass(frozen=True)
class Effort:
    size: int
    samples: int
    repetitions: int
    materials: tuple[int, ...]  # painted ones in a picture


FULL = Effort(128, 1 << 17, 5, (1, 5, 20))
QUICK = Effort(64, 1 << 15, 2, (1, 5))


def growth(quick: bool) -> Iterator[Row]:
    effort = QUICK if quick else FULL
    for measure in (flakes, counts, lights, species, resolution, painted_materials):
        say(f"  {measure.__name__.replace('_', ' ')}")
        yield from measure(effort)


def curve(
    name: str, times: Mapping[float, Sequence[float]], most: float | None = None
) -> Iterator[Row]:
    """Each over the first; with a limit, the dearest over the cheapest."""
    first = next(iter(times.values()))
    rows = [
        Row(name, ratios(taken, first), orientation=nanoseconds(taken), curve=name, at=at)
        for at, taken in times.items()
    ]
    yield from rows
    if most is not None:
        medians = [row.median for row in rows]
        yield Row(f"{name}: the dearest over the cheapest", [max(medians) / min(medians)], most)


def race(stage: Stage, effort: Effort, places: Sequence[float]) -> dict[float, list[float]]:
    """Of the stage's views, which stand at these places of the curve."""
    stage.fit()
    times = stage.race(effort.samples, effort.repetitions)
    return dict(zip(places, times.values(), strict=True))


def flakes(effort: Effort) -> Iterator[Row]:
    """At equal ⟨N⟩: pixels shrink as flakes multiply."""
    stage = Stage([scenes.SUN])
    for number in FLAKES:
        painted = material.create(of_flakes(number))
        stage.add(f"{number:g}", [painted], effort.size, width=WIDTH * shrunk(number))
    yield from curve("flakes per m² at equal ⟨N⟩", race(stage, effort, FLAKES), FLAT)


def counts(effort: Effort) -> Iterator[Row]:
    """One paint, seen from nearer and farther."""
    stage = Stage([scenes.SUN])
    painted = material.create(Paint())
    per_area = mean_count_per_area(Paint(), stage)
    for mean_count in COUNTS:
        pixel = math.sqrt(mean_count / per_area * TOWARDS_CAMERA.z)
        stage.add(f"{mean_count:g}", [painted], effort.size, width=pixel * effort.size)
    yield from curve("⟨N⟩ of a pixel", race(stage, effort, COUNTS), OVER_COUNTS)


def mean_count_per_area(paint: Paint, stage: Stage) -> float:
    """⟨N⟩ of the stage's sun for one m² of the plane, as the core has it."""
    [sun] = stage.lamps
    stage.scene.view_layers[0].update()
    light = core.Light(
        core.LightKind.parallel, sun.matrix_world.col[2][:3], math.sin(sun.data.angle / 2)
    )
    wide = 1 / paint.flakes_per_mm2  # m²: a pixel with a million flakes
    found = core.evaluate(
        core_paint(paint), [light], position=np.zeros((1, 3)), normal=[[0, 0, 1]],
        view=[list(TOWARDS_CAMERA)], footprint=[wide], pixel=[[0, 0]],
    )  # fmt: skip
    return float(found["mean_count"][0, 0]) / wide


def lights(effort: Effort) -> Iterator[Row]:
    stage = Stage(SUNS)
    stage.add("the paint", [material.create(Paint())], effort.size)
    times: dict[float, list[float]] = {count: [] for count in LIGHTS}
    for _ in range(effort.repetitions):
        for count, taken in times.items():
            stage.light_with(int(count))
            taken.append(stage.per_sample("the paint", effort.samples))
    yield from curve("lights", times)
    for count in (LIGHTS[1], LIGHTS[-1]):
        more = [
            (many - one) / (one * (count - LIGHTS[0]))
            for one, many in zip(times[LIGHTS[0]], times[count], strict=True)
        ]
        yield Row(f"lights: each further one of {count}, over the paint under one", more,
                  FURTHER_LIGHT)  # fmt: skip


def species(effort: Effort) -> Iterator[Row]:
    stage = Stage([scenes.SUN])
    for i, paint in enumerate((ONE, TWO, scenes.THREE), 1):
        stage.add(f"{i} species", [material.create(paint)], effort.size)
    yield from curve("species of flakes", race(stage, effort, (1, 2, 3)))


def resolution(effort: Effort) -> Iterator[Row]:
    """The same pixels, more of them."""
    stage = Stage([scenes.SUN])
    painted = material.create(Paint())
    for size in SIZES:
        stage.add(f"{size} pixels", [painted], size, width=WIDTH * size / SIZES[0])
    more = dataclasses.replace(effort, samples=max(effort.samples, 2 * max(SIZES) ** 2))
    yield from curve("pixels along a side", race(stage, more, SIZES))


def painted_materials(effort: Effort) -> Iterator[Row]:
    """As many strips of the picture, with so many paints by turns."""
    stage = Stage([scenes.SUN])
    made = [material.create(paint) for paint in varied(max(effort.materials))]
    for count in effort.materials:
        strips = [made[i % count] for i in range(max(effort.materials))]
        stage.add(f"{count} materials", strips, effort.size)
    yield from curve("painted materials in a picture", race(stage, effort, effort.materials))
