# SPDX-License-Identifier: Apache-2.0
"""Measures what the core's fitted formulas err, and what other constants would.

    python3 tests/fits/fits.py

walks through the paints of 200 fresh seeds, which it prints, and writes docs/fits.md: 25 minutes of
one core, and 15 more for all the rest. --walks FILE keeps the walks, or takes them from there.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
BUILD = ROOT / "build" / "fits"
PROGRAMS = BUILD / "tests" / "fits"
OF_THE_PAGE = (
    "mixture_error",
    "mixture_averages",
    "facet_fit",
    "hot_spot_fit",
    "lobe_spread",
    "diffuse_lobe",
    "finite_flakes",
    "reciprocity",
    "returning_fit",
)
HEADER = ROOT / "core" / "mixture.h"

# What stands in core/mixture.h, and what to try in its place.
TRIED = {
    "kForgetting = 400;": [f"kForgetting = {x};" for x in (0, 100, 200, 800, 1600)],
    "kEdge = 0.185,": [f"kEdge = {x}," for x in (0, 0.12, 0.15, 0.22, 0.26)],
    "kEdgeAbsorption = 1.25;": [f"kEdgeAbsorption = {x};" for x in (0, 2.5)],
    "2 * sqrt(z2) / (1 + 2 * z2)": [
        f"T({a}) * sqrt(z2) / (1 + T({b}) * z2)" for a, b in ((1.5, 2), (1.9, 1.2), (2.5, 2))
    ],
    "kNarrowTilt = 0.25;": ["kNarrowTilt = 0;", "kNarrowTilt = 1;"],
    "kFewFlakes = 1e-3;": ["kFewFlakes = 0;", "kFewFlakes = 1e-2;"],
}
# The rows of mixture_error that tell how that does.
TOLD = [
    f"{kind}: error of M, {what}"
    for kind in ("own colours", "library but silica", "library with silica")
    for what in ("root mean square less the walk's own", "95 %")
]

PAGE = """\
<!-- Written by tests/fits/fits.py; every number comes from its run. -->

# What fitted formulas err

What the core's fits and closed forms err against what they stand for, and what other constants
would. `python3 tests/fits/fits.py` writes this page anew, with fresh paints.

## The mixture against the random walk

`tests/fits/mixture_error.cpp`; `tests/core/mixture_scenes.h` has the paints. Of each seed 60 with
colours of their own, 60 with coatings of the library, 20 of each lossless kind, 5 by angle.

| | |
| --- | ---: |
{errors}

## Other constants in the mixture

The same walks, with one piece of `core/mixture.h` replaced: the root mean square of M's error, less
the walk's own, and what 95 % stay below.

| | own colours | 95 % | library but silica | 95 % | library with silica | 95 % |
| --- | ---: | ---: | ---: | ---: | ---: | ---: |
{tried}

## The mixture's closed forms against averages over the flakes' normals

`tests/fits/mixture_averages.cpp`. g, c and o are the three kinds of light of `core/mixture.h`.

{averages}

## The rough coat

`tests/fits/facet_fit.cpp`: the constants of `core/composition.h`.

{facets}

## What both ways share

`tests/fits/hot_spot_fit.cpp`: the constants of `core/hot_spot.h`, and lossless paints with Depth
Model correlated.

{hot_spot}

## The diffuse lobe

`tests/fits/diffuse_lobe.cpp`: `core/diffuse_lobe.h`. The mixture under light at each angle over the
random walk's, for paints whose mixture is mostly this lobe; the share of paints where that is off
1 by more than 0.1; and the error of the whole in L*.

{diffuse}

## The returning lobe

`tests/fits/returning_fit.cpp`: `returning` of `core/mixture.h` beside exp(c k) of
`core/hot_spot.h`, for lights of the whole hemisphere.

{returning}

## The flakes' lobe

`tests/fits/lobe_spread.cpp`: `kWideShare` of `core/flake_lobe.h`.

{lobe}

## The whole paint beside finite flakes

`tests/fits/finite_flakes.cpp`: Depth Model correlated, flakes in their mean and the mixture, beside
discs with any number of mirrorings (`core/reference/disc_walk.h`). Coverages of 0.1 to 3, flakes of
0.1 to 2 layers' thickness, tilts of 0.05 to 0.4. Relative errors of the BRDF, in green, and that of
L* of a white light. Single: the error of single flakes over the whole. Rest: that of all else, of
the model and of the random walk. What is traced worse than 4 % (noise) is left out.

On the light's side substrate and pigment are seen through the holes that their light comes by,
which the walk does not know.

{finite}

## Reciprocity

`tests/fits/reciprocity.cpp`: light and view change places. The mixture's albedos depend on the view
alone and the shapes of its lobes on the light, so it is not reciprocal; flakes in their mean are.

{reciprocity}
"""


def run(*command: str | Path) -> str:
    """What a program prints; its progress goes to the terminal."""
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.rstrip()


def build(*targets: str) -> None:
    run("cmake", "-S", ROOT, "-B", BUILD, "-DCMAKE_BUILD_TYPE=Release")
    for target in targets:
        tell(f"building {target}")
        run("cmake", "--build", BUILD, "--target", target)


def tell(what: str) -> None:
    print(what, file=sys.stderr, flush=True)


def with_headers(headers: dict[str, str], folder: Path, name: str) -> Path:
    """A program built in a folder with other texts of some of the core's headers."""
    core = folder / "core"
    shutil.copytree(HEADER.parent, core)
    for header, text in headers.items():
        (core / header).write_text(text)
    program = folder / name
    run(
        "c++", "-std=c++20", "-O2", "-ffp-contract=off",
        "-I", core, "-I", ROOT / "tests" / "core",
        ROOT / "tests" / "fits" / f"{name}.cpp",
        BUILD / "libmetallic_paint_core_compiled.a", "-lgtest", "-lpthread", "-o", program,
    )  # fmt: skip
    return program


def with_piece(piece: str, instead: str, walks: Path) -> str:
    """The errors that a piece of the mixture's header would have in place of another."""
    tell(f"trying {instead}")
    text = HEADER.read_text()
    if text.count(piece) != 1:
        raise SystemExit(f"{HEADER} holds {piece!r} {text.count(piece)} times, not once.")
    with tempfile.TemporaryDirectory() as folder:
        headers = {HEADER.name: text.replace(piece, instead)}
        program = with_headers(headers, Path(folder), "mixture_error")
        return run(program, "compare", walks)


def row(name: str, errors: str) -> str:
    found = dict(line.strip("| ").split(" | ") for line in errors.splitlines())
    return f"| `{name}` | " + " | ".join(found[told] for told in TOLD) + " |"


def page(walks: Path) -> str:
    errors = run(PROGRAMS / "mixture_error", "compare", walks)
    tried = [
        row(instead, with_piece(piece, instead, walks))
        for piece, others in TRIED.items()
        for instead in others
    ]
    return PAGE.format(
        errors=errors,
        tried="\n".join([row("as it is", errors), *tried]),
        averages=run(PROGRAMS / "mixture_averages"),
        facets=run(PROGRAMS / "facet_fit"),
        hot_spot=run(PROGRAMS / "hot_spot_fit"),
        diffuse=run(PROGRAMS / "diffuse_lobe"),
        returning=run(PROGRAMS / "returning_fit"),
        lobe=run(PROGRAMS / "lobe_spread"),
        finite=run(PROGRAMS / "finite_flakes"),
        reciprocity=run(PROGRAMS / "reciprocity"),
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=200, metavar="N")
    parser.add_argument("--first", type=int, metavar="SEED", help="seeds SEED, SEED + 1, ...")
    parser.add_argument("--walks", type=Path, metavar="FILE", help="keep the walks, or take them")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "fits.md", metavar="FILE")
    arguments = parser.parse_args()
    build(*OF_THE_PAGE)
    walks = arguments.walks or BUILD / "walks.txt"
    if not (arguments.walks and walks.exists()):
        first = [] if arguments.first is None else [str(arguments.first)]
        run(PROGRAMS / "mixture_error", "walk", walks, str(arguments.seeds), *first)
    part = arguments.out.with_suffix(".part")
    part.write_text(page(walks))
    part.replace(arguments.out)


if __name__ == "__main__":
    main()
