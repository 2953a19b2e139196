# SPDX-License-Identifier: Apache-2.0
"""Time per sample: the whole paint beside what artists use instead."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass

from metallic_paint.paint import Paint, material
from pictures.render_scene import say
from verification import scenes

from bench import materials
from bench.absent_parts import PIXEL_ANCHOR, WHOLE, operations
from bench.rows import Row, nanoseconds, ratios
from bench.stage import Lamp, Stage

PAINT = Paint()
TWO = dataclasses.replace(scenes.THREE, third=PAINT.third)
ONE = dataclasses.replace(TWO, second=PAINT.second)

# Of Principled without OSL under a sun and an even world, at most: what the paint may take on every
# device. Below 1.06 of Principled nothing is in reach, as Cycles and the closures alone take that
# (instructions.py). Hence no bar over other flakes, which take 0.8 to 1.3 of Principled.
OF_PRINCIPLED = 2.5
OF_ONE_SPECIES = 1.2


@dataclass(frozen=True)
class Light:
    name: str
    lamps: tuple[Lamp, ...]
    sky: float
    limit: float | None = None  # over Principled without OSL


LIGHTS = (
    Light("sun and world", (scenes.SUN,), 1, OF_PRINCIPLED),
    Light("a sun", (scenes.SUN,), 0),
    Light("a world", (), 1),
)


def samples(quick: bool) -> Iterator[Row]:
    size, samples_taken, repetitions = (64, 1 << 15, 3) if quick else (128, 1 << 18, 5)
    for light in LIGHTS:
        say(f"  under {light.name}")
        stage = Stage(light.lamps, light.sky)
        metal, cells = materials.principled(), materials.coated_voronoi(PAINT)
        stage.add("the paint", [material.create(PAINT)], size)
        stage.add("Principled", [metal], size)
        stage.add("Voronoi flakes", [cells], size)
        stage.add("noise flakes", [materials.noise_flakes(PAINT)], size)
        stage.add("one species", [material.create(ONE)], size)
        stage.add("two species", [material.create(TWO)], size)
        stage.add("Principled without OSL", [metal], size, osl=False)
        stage.add("Voronoi flakes without OSL", [cells], size, osl=False)
        stage.fit()
        yield from compare(light, stage.race(samples_taken, repetitions))
    say("  anchors")
    yield from anchors(size, samples_taken, repetitions)


OF_PIXEL = 1.1  # the surface anchor's samples and operations, at most
OF_COUNTS = 2.0  # a close-up's samples
CLOSE = 1e-3  # m, the width of a picture whose pixels are smaller than flakes


def anchors(size: int, samples_taken: int, repetitions: int) -> Iterator[Row]:
    """Under a sun, each with the paint that ships."""
    stage = Stage((scenes.SUN,))
    stage.add("surface", [material.create(PAINT)], size)
    stage.add("pixel", [material.create(dataclasses.replace(PAINT, anchor="pixel"))], size)
    stage.add("close-up", [material.create(PAINT)], size, width=CLOSE)
    stage.fit()
    times = stage.race(samples_taken, repetitions)
    for name, other, limit in (("surface", "pixel", OF_PIXEL), ("close-up", "surface", OF_COUNTS)):
        behind = f"{nanoseconds(times[name])} / {nanoseconds(times[other])}"
        yield Row(f"a sun: {name} over {other}", ratios(times[name], times[other]), limit,
                  orientation=behind)  # fmt: skip
    kept, by_pixels = operations(WHOLE), operations(PIXEL_ANCHOR)
    yield Row("a sun: operations with Anchor surface over pixel", [kept / by_pixels], OF_PIXEL,
              orientation=f"{kept} / {by_pixels}")  # fmt: skip


def compare(light: Light, times: dict[str, list[float]]) -> Iterator[Row]:
    def over(name: str, other: str, limit: float | None = None) -> Row:
        behind = f"{nanoseconds(times[name])} / {nanoseconds(times[other])}"
        what = f"{light.name}: {name} over {other}"
        return Row(what, ratios(times[name], times[other]), limit, orientation=behind)

    yield over("the paint", "Principled")
    yield over("the paint", "Principled without OSL", light.limit)
    yield over("the paint", "Voronoi flakes")
    yield over("the paint", "Voronoi flakes without OSL")
    yield over("the paint", "noise flakes")
    yield over("two species", "one species", OF_ONE_SPECIES)
