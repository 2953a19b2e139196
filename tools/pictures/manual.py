# SPDX-License-Identifier: Apache-2.0
"""Renders the pictures of docs/manual: strips that show what one parameter of a paint does."""

from __future__ import annotations

import argparse
import math
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from common import files
from common.processes import ROOT, TOOLS, StepFailedError, describe, run_limited, run_program, say
from metallic_paint.paint import PARAMETERS, Paint, presets, shader_value, value_of

SECONDS = 600  # for one strip
NEAR_MM = 12

# What a strip sets beside the paint's fields, with the usual values: Model Scale, and for
# each normal the strength of a bump map.
BESIDE = {"Model Scale": 1.0, "Normal": 0.0, "Coat Normal": 0.0}


@dataclass(frozen=True)
class Strip:
    """A preset again and again, each time with other values of its fields."""

    preset: str
    shots: dict[str, dict[str, Any]]  # words below the shot: values of fields and of BESIDE
    near: bool = False  # NEAR_MM of paint; otherwise a ball of 40 mm

    def paints(self) -> dict[str, Paint]:
        base = presets.load(self.preset)
        return {
            words: replace(base, **{name: values[name] for name in values.keys() - BESIDE.keys()})
            for words, values in self.shots.items()
        }

    def sockets(self) -> dict[str, dict[str, Any]]:
        """What the node holds in each shot, by label."""
        return {
            words: {
                parameter.label: shader_value(parameter, value_of(paint, name))
                for name, parameter in PARAMETERS.items()
            }
            | {label: self.shots[words].get(label, usual) for label, usual in BESIDE.items()}
            for words, paint in self.paints().items()
        }


_RED = (0.84, 0.11, 0.09)
_BLACK = (0.0, 0.0, 0.0)

STRIPS = {
    "flakes-per-mm2": Strip(
        "silver-coarse",
        {str(n): {"flakes_per_mm2": n} for n in (30, 300, 3000, 30000)},
        near=True,
    ),
    "flake-diameter": Strip(  # as many as cover the same area
        "silver-coarse",
        {
            f"{um} µm": {"flake_diameter_um": um, "flakes_per_mm2": 2500 * (30 / um) ** 2}
            for um in (10, 20, 40, 100)
        },
        near=True,
    ),
    "flake-area-spread": Strip(
        "silver-coarse", {f"{s:g}": {"flake_area_spread": s} for s in (0, 0.5, 1, 2)}, near=True
    ),
    "orientation": Strip(
        "silver-coarse",
        {kind: {"orientation": kind, "tilt": 0.2} for kind in ("gaussian", "beckmann", "ggx")},
    ),
    "tilt": Strip("silver-coarse", {f"{x:g} rad": {"tilt": x} for x in (0.05, 0.12, 0.25, 0.5)}),
    "flake-spread": Strip(
        "silver-coarse",
        {f"{angle:g}°": {"flake_spread": math.radians(angle)} for angle in (0.1, 0.5, 1.5, 5)},
        near=True,
    ),
    "flake-colors": Strip(
        "silver-coarse",
        {
            "white": {"coating": "colors"},
            "red": {"coating": "colors", "flake_color": _RED},
            "edge too": {"coating": "colors", "flake_color": _RED, "flake_edge_color": _RED},
            "lets half pass": {
                "coating": "colors", "flake_color": (0.45, 0.1, 0.1),
                "flake_edge_color": (0.5, 0.5, 0.5), "flake_transmission": (0.5, 0.5, 0.5),
            },
        },
    ),
    "coating": Strip(
        "silver-coarse",
        {kind: {"coating": kind} for kind in ("aluminium", "gold", "copper", "fe2o3-on-mica")},
    ),
    "coating-nm": Strip(
        "white-pearl",
        {
            f"{nm} nm": {"coating_nm": nm, "substrate_color": _BLACK}
            for nm in (60, 85, 110, 150)
        },
    ),
    "second-flakes": Strip(
        "deep-blue",
        {
            f"{n} aluminium": {
                "second": replace(presets.load("deep-blue").second, flakes_per_mm2=n)
            }
            for n in (0, 500, 1500, 5000)
        },
    ),
    "ior": Strip("deep-blue", {f"{n:g}": {"binder_ior": n} for n in (1.1, 1.3, 1.5, 2)}),
    "layer-thickness": Strip(
        "deep-blue", {f"{um} µm": {"layer_thickness_um": um} for um in (5, 15, 40, 120)}
    ),
    "absorption": Strip(
        "silver-coarse",
        {f"{k} / mm": {"binder_absorption_per_mm": (k, k / 2, 0)} for k in (0, 10, 30, 100)},
    ),
    "rayleigh": Strip(
        "racing-green", {f"{k:g} / mm": {"rayleigh_per_mm": k} for k in (0, 0.5, 2, 8)}
    ),
    "coat-roughness": Strip(
        "graphite-matt", {f"{x:g}": {"coat_roughness": x} for x in (0, 0.2, 0.4, 0.7)}
    ),
    "orange-peel": Strip(
        "racing-green",
        {
            f"{angle}°, {mm} mm": {"orange_peel": math.radians(angle), "orange_peel_mm": mm}
            for angle, mm in ((0, 3), (2, 3), (6, 3), (6, 10))
        },
    ),
    "substrate-color": Strip(
        "silver-coarse",
        {
            words: {"substrate_color": color, "flakes_per_mm2": 300}
            for words, color in (
                ("black", _BLACK), ("red", (0.4, 0.02, 0.02)), ("blue", (0.02, 0.05, 0.4)),
                ("white", (0.8, 0.8, 0.8)),
            )
        },
    ),
    "texture-contrast": Strip(
        "white-pearl", {f"{c:g}": {"texture_contrast": c} for c in (0, 0.03, 0.1, 0.3)}
    ),
    "diffraction": Strip(
        "silver-coarse",
        {
            f"{um} µm, {kind}": {
                "diffraction": kind, "flake_diameter_um": um, "flakes_per_mm2": 1000,
            }
            for um in (10, 30) for kind in ("none", "disc")
        },
        near=True,
    ),
    "depth-model": Strip(
        "silver-coarse",
        {
            kind: {
                "depth_model": kind, "layer_thickness_um": 200,
                "binder_absorption_per_mm": (20, 10, 0),
            }
            for kind in ("attenuated", "thinned", "correlated")
        },
        near=True,
    ),
    "radiometry": Strip(
        "silver-coarse",
        {
            f"{kind}, {x:g} rad": {"radiometry": kind, "tilt": x, "Model Scale": 20}
            for x in (0.12, 0.3) for kind in ("exact", "published")
        },
    ),
    "composition": Strip(
        "silver-coarse",
        {
            f"{kind}, scale {scale}": {
                "composition": kind, "Model Scale": scale, "flakes_per_mm2": 300, "tilt": 0.2,
                "substrate_color": (0.03, 0.5, 0.05),
            }
            for scale in (1, 20) for kind in ("exact", "published")
        },
    ),
    "anchor": Strip(  # pixels of a twelfth of a flake
        "silver-coarse",
        {
            words: {"anchor": words, "flake_diameter_um": 900, "flakes_per_mm2": 2}
            for words in ("pixel", "surface")
        },
        near=True,
    ),
    "cells-per-pixel": Strip(
        "silver-coarse", {str(n): {"cells_per_pixel": n} for n in (1, 5, 20, 64)}, near=True
    ),
    "seed": Strip(
        "silver-coarse",
        {str(number): {"seed": number, "flakes_per_mm2": 500} for number in (0, 1, 2)},
        near=True,
    ),
    "model-scale": Strip("silver-coarse", {f"{x:g}": {"Model Scale": x} for x in (0.2, 1, 5, 20)}),
    "sparkle-contrast": Strip(
        "silver-coarse", {f"{c:g}": {"sparkle_contrast": c} for c in (0, 0.3, 0.6, 1)}
    ),
    "normal": Strip(
        "deep-blue",
        {
            "none": {},
            "Normal": {"Normal": 1, "Coat Normal": 1},  # the coat's unlinked one follows
            "Coat Normal": {"Coat Normal": 1},
        },
    ),
}  # fmt: skip


def chosen(only: str) -> list[str]:
    """The strips with that in their name."""
    names = [name for name in STRIPS if only in name]
    if not names:
        raise StepFailedError(
            f"--only {only}: no picture has that in its name; the pictures are {', '.join(STRIPS)}."
        )
    return names


def main() -> int:
    parser = argparse.ArgumentParser(prog="paint manual", description=__doc__)
    parser.add_argument(
        "--out", type=Path, default=ROOT / "out" / "manual", metavar="DIR",
        help="folder for the pictures, whose other files stay (out/manual)",
    )  # fmt: skip
    parser.add_argument(
        "--only", default="", metavar="TEXT", help="the pictures with TEXT in their name"
    )
    arguments = parser.parse_args()

    start = time.monotonic()
    names = chosen(arguments.only)
    out: Path = arguments.out
    program = [sys.executable, TOOLS, "pictures.manual_pictures"]
    try:
        for number, name in enumerate(names, 1):
            say(f"{name} ({number} of {len(names)})…")
            with files.whole(out / f"{name}.jpg") as picture:
                # One process each, as for the gallery.
                code = run_limited([*program, name, "--out", picture], seconds=SECONDS)
                if code != 0:
                    raise StepFailedError(f"{name} failed ({describe(code)}).")
    except OSError as error:
        raise StepFailedError(f"--out {out}: cannot be written ({error.strerror}).") from error
    say(f"{out}, {time.monotonic() - start:.0f} s in all")
    return 0


if __name__ == "__main__":
    run_program(main)
