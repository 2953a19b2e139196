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
from bench.rows import Row, nanoseconds, ratios
from bench.stage import Lamp, Stage

PAINT = Paint()
TWO = dataclasses.replace(scenes.THREE, third=PAINT.third)
ONE = dataclasses.replace(TWO, second=PAINT.second)

OF_FLAKES = 0.7  # of the other materials with flakes, at most
OF_ONE_SPECIES = 1.2


@dataclass(frozen=True)
class Light:
    name: str
    lamps: tuple[Lamp, ...]
    sky: float
    limits: tuple[float | None, float | None]  # over Principled with OSL and without


LIGHTS = (
    Light("sun and world", (scenes.SUN,), 1, (0.8, 1)),
    Light("a sun", (scenes.SUN,), 0, (0.6, 1)),
    Light("a world", (), 1, (None, None)),
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


def compare(light: Light, times: dict[str, list[float]]) -> Iterator[Row]:
    def over(name: str, other: str, limit: float | None) -> Row:
        behind = f"{nanoseconds(times[name])} / {nanoseconds(times[other])}"
        what = f"{light.name}: {name} over {other}"
        return Row(what, ratios(times[name], times[other]), limit, orientation=behind)

    with_osl, without_osl = light.limits
    yield over("the paint", "Principled", with_osl)
    yield over("the paint", "Principled without OSL", without_osl)
    yield over("the paint", "Voronoi flakes", OF_FLAKES)
    yield over("the paint", "Voronoi flakes without OSL", None)
    yield over("the paint", "noise flakes", OF_FLAKES)
    yield over("two species", "one species", OF_ONE_SPECIES)
