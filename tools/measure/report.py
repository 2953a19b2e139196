# SPDX-License-Identifier: Apache-2.0
"""Runs the virtual instruments over a paint and makes the report of ./paint measure."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from common import bars
from common.processes import StepFailedError, run_program, say
from common.report_folder import MEASURE, REPORT, table
from metallic_paint.paint import Paint, presets

from measure import goniophotometer, plots, sparkle_camera
from measure.goniophotometer import ANGLES, BATCHES, CURVE, Goniogram, Measured
from measure.sparkle_camera import LIGHTS, Sparkle

PHOTONS = 800_000  # L* to 0.1 at every angle of the presets
PICTURE_SIDE = 128  # pixels of each batch
TRACED_PIXELS = 2048  # graininess to 2 %
COLOURS = ("L*", "a*", "b*")

APPROXIMATIONS = f"""\
- **L\\*, a\\*, b\\***: light at 45°, detectors in its plane (ASTM E2194). The angle is aspecular:
  from the mirror direction towards the normal. Photons walk through the whole paint; the mirror
  image of the lamp in the surface is left out, and with it the coat's roughness; flakes are flat
  mirrors, without Flake Spread and diffraction, which matters where Tilt is as small. Beams are
  parallel and detectors points, where an instrument has apertures of some degrees. Three colour
  channels stand for the spectrum: D65, 2° observer. A perfect diffuser has L\\* 100, so near the
  mirror direction a metallic paint has more.
- **Flop index**: 2.69 (L\\*15 − L\\*110)^1.11 / L\\*45^0.86, after D. H. Alman (DuPont, 1987), as
  multi-angle instruments have it: 0 for a solid colour, about 15 for a paint of much flop.
- **Sparkle** is our approximation, since what instruments compute from their pictures is not
  published. The camera looks along the normal, the lamps stand at 15°, 45° and 75° from it and have
  a radius of {math.degrees(sparkle_camera.LAMP_RADIUS):g}° (assumed); the model draws pixels of
  {sparkle_camera.PIXEL * 1e6:.0f} µm, one minute of arc at half a metre (assumed). A pixel sparkles
  if its luminance is above {1 + sparkle_camera.CONTRAST:g} times the picture's median (our
  threshold). Area: the sparkling share of the picture, so fine flakes have more of it. Intensity:
  the sparkles' mean luminance over the median, less one, without a sensor's limit. The numbers
  compare paints with each other, not with an instrument's grades.
- **Graininess** likewise: the standard deviation of the luminance of such pixels over its mean,
  under an even dome. The flakes are traced as discs that hide each other, each counted in the pixel
  of its centre; the substrate and light scattered more than once count as even.
- ± is one standard error, from leaving out one of {BATCHES} independent batches at a time.
"""


@dataclass(frozen=True)
class Figure:
    """A row of --json: "1" is the unit of a pure number, null what cannot be measured."""

    name: str
    value: float | None
    unit: str
    error: float | None  # standard error


@dataclass(frozen=True)
class Measurement:
    goniogram: Goniogram
    sparkles: dict[int, Sparkle]  # by LIGHTS
    graininess: Measured

    def figures(self) -> Iterator[Figure]:
        for angle in ANGLES:
            at = CURVE.index(angle)
            for i, name in enumerate(COLOURS):
                of = self.goniogram.lab
                yield figure(f"{name} at {angle}°", Measured(of.value[at, i], of.error[at, i]), "1")
        yield figure("flop index", self.goniogram.flop_index, "1")
        for light, sparkle in self.sparkles.items():
            yield figure(f"sparkle area at {light}°", percent(sparkle.area), "%")
            yield figure(f"sparkle intensity at {light}°", sparkle.intensity, "1")
        yield figure("graininess", percent(self.graininess), "%")


def percent(measured: Measured) -> Measured:
    return Measured(100 * measured.value, 100 * measured.error)


def figure(name: str, measured: Measured, unit: str) -> Figure:
    value, error = (float(x) if np.isfinite(x) else None for x in (measured.value, measured.error))
    return Figure(name, value, unit, error if value is not None else None)


def shown(of: Figure) -> str:
    """The value with two digits of its error, but four decimals at most."""
    if of.value is None:
        return "–"
    if not of.error:
        return f"{round(of.value, 4) + 0.0:g}" + (" ± ?" if of.error is None else "")
    digits = min(max(1 - math.floor(math.log10(of.error)), 0), 4)
    value = round(of.value, digits) + 0.0  # no −0
    return f"{value:.{digits}f} ± {of.error:.{digits}f}".replace("-", "−")


def counted(what: str, steps: Iterable[np.ndarray]) -> np.ndarray:
    """The batches of a long measurement, with its progress."""
    done = []
    for step in steps:
        done.append(step)
        if len(done) % (BATCHES // 4) == 0:
            say(f"{what}: {100 * len(done) // BATCHES} %")
    return np.array(done)


def measure(paint: Paint, quick: bool) -> Measurement:
    share = 10 if quick else 1
    photons, side = PHOTONS // share, round(PICTURE_SIDE / math.sqrt(share))
    say("Camera under the dome…")
    dome = sparkle_camera.dome_luminance(paint, TRACED_PIXELS // share)
    batches = counted("Goniophotometer", goniophotometer.aspecular_walks(paint, photons))
    say("Camera under the lamps…")
    even = sparkle_camera.normal_walk(paint, photons // 4)
    sparkles = {
        light: sparkle_camera.sparkle(paint, math.radians(light), even.under_lamps[:, i], side)
        for i, light in enumerate(LIGHTS)
    }
    grain = sparkle_camera.graininess(dome, even.under_dome)
    return Measurement(goniophotometer.goniogram(batches), sparkles, grain)


def tables(found: dict[str, Figure]) -> Iterator[str]:
    yield from table(
        ["aspecular angle", *COLOURS],
        ([f"{a}°", *(shown(found[f"{name} at {a}°"]) for name in COLOURS)] for a in ANGLES),
    )
    yield f"Flop index: **{shown(found['flop index'])}**"
    yield ""
    yield from table(
        ["lamp from the normal", "sparkle area, %", "sparkle intensity"],
        (
            [f"{a}°", *(shown(found[f"sparkle {of} at {a}°"]) for of in ("area", "intensity"))]
            for a in LIGHTS
        ),
    )
    yield f"Graininess under diffuse light: **{shown(found['graininess'])} %**"


def report(name: str, found: dict[str, Figure]) -> Iterator[str]:
    yield MEASURE.mark
    yield f"# {name}, measured"
    yield ""
    yield from tables(found)
    yield ""
    yield f"![{name}: lightness, colours and sparkles]({MEASURE.pictures[0]})"
    yield ""
    yield "## What the numbers are"
    yield ""
    yield APPROXIMATIONS


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("preset")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()

    name = Path(arguments.preset).stem
    try:
        found = measure(presets.load(arguments.preset), arguments.quick)
    except ValueError as error:  # a paint beyond what the references trace
        raise StepFailedError(f"{name}: {error}") from error
    figures = {figure.name: figure for figure in found.figures()}
    with MEASURE.fill(arguments.out) as folder:
        plots.draw(name, found, folder / MEASURE.pictures[0])
        (folder / REPORT).write_text("\n".join(report(name, figures)))
    if arguments.json:
        bars.write(list(figures.values()), arguments.json)
    say("")
    for line in tables(figures):
        say(line.replace("**", ""))
    say(f"\nThe report with its plot is {arguments.out / REPORT}.")
    return 0


if __name__ == "__main__":
    run_program(main)
