# SPDX-License-Identifier: Apache-2.0
"""Fits a paint to a measured BRDF and makes the report of ./paint measure --fit."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from common import bars
from common.processes import StepFailedError, run_program, say
from common.report_folder import REPORT, ReportFolder, fit_folder, table
from metallic_paint.paint import presets

from measure import brdf as measured
from measure import fit_plots
from measure.brdf import Brdf, BrdfError
from measure.fit import NUMBERS, Fit, fit, lightness, measured_lightness, residual, rms
from measure.report import Figure

STEPS, QUICK_STEPS = 60, 12  # of each search
SEEN = 3.0  # L*: an error of a zone that the report names; side by side one sees less
INCIDENCES = ((0, 20), (20, 50), (50, 81))  # zones, degrees: of the angle nearer to the horizon
OFFSETS = ((0, 5), (5, 20), (20, 50), (50, 180))  # from the mirror direction

# What our paint has in each zone of the offset, and so what it cannot follow.
CAUSES = (
    "the image of the lamp: our coat mirrors as Fresnel and one roughness tell, colourless, over "
    "the flakes' lobe; a surface of two roughnesses, or a metal's own mirror, is not of our model",
    "the lobe: one law of tilts under one coat makes its width, and the coat's refraction its "
    "growth with the angle of the light",
    "the flank: one law of tilts has one tail, and the depth model dims it as discs would",
    "far from the mirror direction: what the substrate and several mirrorings scatter is nearly "
    "even there, whatever the paint",
)
GRAZING = (
    "; light and view near the horizon: there the coat reflects by Fresnel's law, and the lobes of "
    "measured fits differ the most"
)

NOTES = """\
- **Lightness**: 116 times the cube root of the radiance under one lamp, of which a white diffuser
  that faces it shows 1. It holds the cosine of the light. Errors are in its steps, over red, green
  and blue alike; "error" is the mean, "RMS" the root of the mean square.
- **Where**: {where}. Angles beyond 80° from the normal are left out, as measurements there are
  not trusted.
- **What a BRDF does not say**: the size of the flakes. Flake Diameter is what --diameter gives, and
  Flakes per mm² and Layer Thickness follow from it. Nor does it tell sparkles, texture and orange
  peel; set them by eye. It tells tilt, coat roughness and IOR to a percent or so, where a paint of
  ours was measured; more flakes of a darker colour, or under a lacquer that absorbs more, look
  alike.
- **Ranges** of the search: IOR 1.3 to 1.8, for other binders are no lacquers; the edge colour
  between the flake's own and white, as metals have it; one species of flakes.
- Our paint is not quite reciprocal where its coat is rough and one direction grazes. It is fitted
  with the angle of incidence on the side of the view.
"""


@dataclass(frozen=True)
class Zone:
    incidence: tuple[int, int]
    offset: int  # of OFFSETS
    places: int
    error: float  # steps of L*
    rms: float
    apart: float  # RMS between two fits of the same measurement; NaN if there is one only

    @property
    def name(self) -> str:
        low, high = OFFSETS[self.offset]
        return f"incidence {self.incidence[0]}° to {min(self.incidence[1], 80)}°, " + (
            f"{low}° to {high}° off the mirror direction" if high < 180
            else f"more than {low}° off the mirror direction"
        )  # fmt: skip


def zones(brdf: Brdf, found: Fit) -> Iterator[Zone]:
    off = residual(found.paint, brdf)
    apart = np.full_like(off, np.nan)
    if brdf.second:
        other = lightness(brdf.second(brdf.light, brdf.view) * brdf.light[:, 2:])
        apart = other - measured_lightness(brdf)
    lowest = np.minimum(brdf.light[:, 2], brdf.view[:, 2])
    incidence = np.degrees(np.arccos(np.clip(brdf.view[:, 2], -1, 1)))
    if brdf.is_scattered:
        incidence = np.degrees(np.arccos(np.clip(lowest, -1, 1)))
    mirror = brdf.view * np.array([-1.0, -1, 1])
    offset = np.degrees(np.arccos(np.clip(np.sum(mirror * brdf.light, axis=1), -1, 1)))
    for low, high in INCIDENCES:
        for i, (near, far) in enumerate(OFFSETS):
            here = (incidence >= low) & (incidence < high) & (offset >= near) & (offset < far)
            if here.any():
                yield Zone((low, high), i, int(here.sum()), float(off[here].mean()),
                           rms(off[here]), rms(apart[here]))  # fmt: skip


def figures(brdf: Brdf, found: Fit, judged: list[Zone]) -> Iterator[Figure]:
    yield Figure("RMS error", found.error, "L*", None)
    if brdf.second:
        other = lightness(brdf.second(brdf.light, brdf.view) * brdf.light[:, 2:])
        yield Figure("RMS between two fits", rms(other - measured_lightness(brdf)), "L*", None)
    for zone in judged:
        yield Figure(f"error, {zone.name}", zone.error, "L*", None)
        yield Figure(f"RMS error, {zone.name}", zone.rms, "L*", None)


def report(brdf: Brdf, found: Fit, judged: list[Zone], kind: ReportFolder) -> Iterator[str]:
    curves, spheres, preset = kind.pictures
    yield kind.mark
    yield f"# {brdf.name}, fitted"
    yield ""
    yield (
        f"Measured: {brdf.source}. The nearest paint is [{preset}]({preset}) (Load Preset), "
        f"**{found.error:.1f} steps of L\\*** off in root mean square."
    )
    yield ""
    if brdf.second:
        apart = next(f.value for f in figures(brdf, found, judged) if "between" in f.name)
        yield (
            f"How sure is the measured side? Two papers fitted the same measurement; theirs differ "
            f"by {apart:.1f}, here from the second, Löw et al. 2012."
        )
        yield ""
    yield f"![BRDF along the plane of incidence, measured and fitted]({curves})"
    yield ""
    yield f"![Spheres under one lamp, measured and fitted]({spheres})"
    yield ""
    yield "## The paint"
    yield ""
    yield from table(["field", "value"], parameters(found))
    yield "## Where it errs"
    yield ""
    head = ["incidence", "off the mirror direction", "places", "error", "RMS"]
    yield from table(
        [*head, "RMS between two fits"] if brdf.second else head,
        ([f"{z.incidence[0]}° to {min(z.incidence[1], 80)}°",
          f"{OFFSETS[z.offset][0]}° to {OFFSETS[z.offset][1]}°", str(z.places),
          f"{z.error:+.1f}".replace("-", "−"), f"{z.rms:.1f}",
          *([f"{z.apart:.1f}"] if brdf.second else [])] for z in judged),
    )  # fmt: skip
    yield "## What it does not reach, and why"
    yield ""
    yield from unreached(found, judged)
    yield ""
    yield "## What the numbers are"
    yield ""
    where = (
        "at the file's own rows" if brdf.is_scattered
        else f"{len(brdf.light)} pairs of directions, at incidences of "
        f"{', '.join(map(str, measured.INCIDENCES))}° and {measured.OFFSETS[0]}° to "
        f"{measured.OFFSETS[-1]}° about the mirror direction"
    )  # fmt: skip
    yield NOTES.format(where=where)


def parameters(found: Fit) -> Iterator[list[str]]:
    fields = ("flakes_per_mm2", "flake_diameter_um", "orientation", "tilt", "flake_color",
              "flake_edge_color", "layer_thickness_um", "binder_absorption_per_mm", "binder_ior",
              "coat_roughness", "substrate_color")  # fmt: skip
    for name in fields:
        value = getattr(found.paint, name)
        text = ", ".join(f"{x:g}" for x in value) if isinstance(value, tuple) else f"{value}"
        yield [name, text]
    yield ["covered area per area", f"{found.paint.flake_coverage:.3g}"]


def unreached(found: Fit, judged: list[Zone]) -> Iterator[str]:
    far = sorted((z for z in judged if z.rms > SEEN), key=lambda z: -z.rms)
    if not far:
        yield f"Nothing: no zone is off by more than {SEEN:g} steps of L\\*."
    for zone in far:
        if zone.rms <= zone.apart:
            why = "no more than two fits of the same measurement differ there"
        else:
            why = CAUSES[zone.offset] + (GRAZING if zone.incidence[0] >= INCIDENCES[-1][0] else "")
        yield f"- **{zone.name}** ({zone.rms:.1f}): {why}."
    if found.at_end:
        ends = {n.name: n for n in NUMBERS}
        yield ""
        yield (
            "These stand at an end of the search's range; the BRDF asks for more or tells nothing: "
            + ", ".join(f"{n} ({ends[n].low:g} to {ends[n].high:g})" for n in found.at_end) + "."
        )  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--diameter", type=float, required=True)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()

    try:
        brdf = measured.load(arguments.name)
    except BrdfError as error:
        raise StepFailedError(str(error)) from error
    found = fit(brdf, arguments.diameter, QUICK_STEPS if arguments.quick else STEPS, say)
    judged = list(zones(brdf, found))
    kind = fit_folder(brdf.name)
    with kind.fill(arguments.out) as folder:
        fit_plots.draw_curves(brdf, found.paint, folder / kind.pictures[0])
        fit_plots.draw_spheres(brdf, found.paint, folder / kind.pictures[1])
        presets.save(found.paint, folder / kind.pictures[2],
                     f"Fitted to {brdf.source}: {brdf.name}")  # fmt: skip
        (folder / REPORT).write_text("\n".join(report(brdf, found, judged, kind)) + "\n")
    if arguments.json:
        bars.write(list(figures(brdf, found, judged)), arguments.json)
    say("")
    for line in unreached(found, judged):
        say(line.replace("**", "").replace("\\", ""))
    say(f"\nThe paint is {found.error:.1f} steps of L* off. Report and preset are in "
        f"{arguments.out / REPORT}.")  # fmt: skip
    return 0


if __name__ == "__main__":
    run_program(main)
