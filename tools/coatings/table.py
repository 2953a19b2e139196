# SPDX-License-Identifier: Apache-2.0
"""Flake coatings from measured indices: colour against the angle, as a table for the paint.

A flake is a platelet, bare or coated alike on both faces, in the binder: an exact stack of thin
films. Its table holds RGB reflectance and transmittance at cos(alpha) = 0, 1/(n-1), ..., 1, alpha
in the binder, as core/coating.h interpolates them.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from coatings.colorimetry import WAVELENGTHS, linear_srgb
from coatings.thin_film import reflect_and_transmit

Array = NDArray[np.float64]

MATERIALS = json.loads((Path(__file__).parent / "data" / "materials.json").read_text())["materials"]
COATINGS = ("tio2", "rutile", "fe2o3")
# Thickness and its standard deviation in nm: typical of trade pigments, not measured.
PLATELETS = {
    "mica": (500.0, 100.0),
    "silica": (400.0, 20.0),
    "alumina": (300.0, 30.0),
    "glass": (1200.0, 120.0),
    "aluminium": (200.0, 0.0),
    "silver": (200.0, 0.0),
    "gold": (200.0, 0.0),
    "copper": (200.0, 0.0),
    "bronze-90-10": (200.0, 0.0),
    "bronze-70-30": (200.0, 0.0),
    "chromium": (200.0, 0.0),
    "nickel": (200.0, 0.0),
}
NAMES = (*PLATELETS, *(f"{film}-on-{platelet}" for film in COATINGS for platelet in PLATELETS))

BINDER_IOR = 1.5
NODES = 33
DIGITS = 4

# The shader's coatings (CoatingKind in core/coating.h, in its order): a flake of NAMES and its
# platelet's thickness in nm where that is not the usual. Of silica platelets from 200 to 720 nm
# these turn the farthest with the angle: 280 (gold to green, blue to violet), 220 (green to purple)
# and under iron 240 (blue to copper).
METALS = {name: name for name in ("aluminium", "silver", "gold", "copper")} | {
    "bronze": "bronze-90-10",
    "brass": "bronze-70-30",
    "chromium": "chromium",
    "nickel": "nickel",
}
PEARLS = {
    "tio2-on-mica": ("tio2-on-mica", None),
    "tio2-on-silica": ("tio2-on-silica", 280.0),
    "tio2-on-thin-silica": ("tio2-on-silica", 220.0),
    "fe2o3-on-mica": ("fe2o3-on-mica", None),
    "fe2o3-on-silica": ("fe2o3-on-silica", 240.0),
    "fe2o3-on-aluminium": ("fe2o3-on-aluminium", None),
}
PASSING = ("fe2o3-on-mica", "fe2o3-on-silica")  # absorb, and let light through
LIBRARY_NM = np.linspace(0, 200, 41)
# Where max(6 c, 24 c - 12) is whole.
LIBRARY_COSINES = np.concatenate([np.arange(4) / 6, (np.arange(4, 13) + 12) / 24])


def index(material: str) -> NDArray[np.complex128]:
    """n + ik at WAVELENGTHS: the published formula, or linear between the published points."""
    entry = MATERIALS[material]
    if "nk" in entry:
        nm, n, k = np.array(entry["nk"]).T
        return np.interp(WAVELENGTHS, nm, n) + 1j * np.interp(WAVELENGTHS, nm, k)
    c, x = entry["coefficients"], (WAVELENGTHS * 1e-3) ** 2
    if entry["formula"] == "sellmeier":
        square = 1 + sum(b * x / (x - p) for b, p in zip(c[::2], c[1::2], strict=True))
    elif entry["formula"] == "devore":
        square = c[0] + c[1] / (x - c[2])
    else:
        square = np.full_like(x, c[0] ** 2)
    return np.sqrt(square) + 0j


@dataclass(frozen=True)
class Flake:
    platelet: str
    platelet_nm: float
    spread_nm: float = 0.0  # standard deviation of the platelet's thickness, from flake to flake
    coating: str | None = None
    coating_nm: float = 0.0

    def __post_init__(self) -> None:
        if self.platelet not in PLATELETS:
            raise ValueError(f"platelet is {self.platelet!r}, but must be one of {list(PLATELETS)}")
        if self.coating is not None and self.coating not in COATINGS:
            raise ValueError(f"coating is {self.coating!r}, but must be None or one of {COATINGS}")
        _require("platelet_nm", self.platelet_nm, 0, 2000, "nm")
        # So that four deviations stay above 0.
        _require(
            "spread_nm", self.spread_nm, 0, self.platelet_nm / 4, "nm, a quarter of platelet_nm"
        )
        _require("coating_nm", self.coating_nm, 0, 500, "nm")


def named_flake(
    name: str,
    coating_nm: float | None = None,
    platelet_nm: float | None = None,
    spread_nm: float | None = None,
) -> Flake:
    """A flake of NAMES; without a spread of its own, a platelet spreads as its default does."""
    if name not in NAMES:
        raise ValueError(f"name is {name!r}, but must be one of {', '.join(NAMES)}")
    coating, platelet = name.split("-on-") if "-on-" in name else (None, name)
    usual_nm, usual_spread_nm = PLATELETS[platelet]
    if coating is None and coating_nm is not None:
        raise ValueError(f"coating_nm is {coating_nm}, but {name} has no coating")
    platelet_nm = usual_nm if platelet_nm is None else platelet_nm
    return Flake(
        platelet,
        platelet_nm,
        usual_spread_nm * platelet_nm / usual_nm if spread_nm is None else spread_nm,
        coating,
        0.0 if coating is None else 60.0 if coating_nm is None else coating_nm,
    )


def spectra(flake: Flake, binder_ior: float, cosine: ArrayLike) -> tuple[Array, Array]:
    """Mean R and T over the platelets' thicknesses, (wavelengths, cosines)."""
    platelet = index(flake.platelet)
    outer = [] if flake.coating is None else [(index(flake.coating), flake.coating_nm)]
    total = 0.0
    for thickness, share in _thicknesses(flake.platelet_nm, flake.spread_nm):
        films = [*outer, (platelet, thickness), *outer]
        both = reflect_and_transmit(films, binder_ior, WAVELENGTHS, cosine)
        total = total + share * np.array(both)
    return total[0], total[1]


def _thicknesses(mean: float, spread: float) -> list[tuple[float, float]]:
    """Nodes and weights of a Gaussian, cut at four deviations.

    Equal steps err by exp(-(2 pi / step - w)^2 spread^2 / 2) for a ripple of wave number w, which
    is 4 pi n m / lambda, at most 0.06 m / nm, for the m-th echo in the platelet. Measured: 2e-5.
    """
    if spread == 0:
        return [(mean, 1.0)]
    half = int(np.ceil(4 * max(3, spread / 10)))  # steps of a third of it, at most 10 nm
    deviations = np.linspace(-4, 4, 2 * half + 1)
    weights = np.exp(-(deviations**2) / 2)
    return list(zip(mean + spread * deviations, weights / weights.sum(), strict=True))


def colours(flake: Flake, cosine: ArrayLike, binder_ior: float = BINDER_IOR) -> tuple[Array, Array]:
    """RGB reflectance and transmittance, (cosines, 3), as they come: outside sRGB some are < 0."""
    reflectance, transmittance = spectra(flake, binder_ior, cosine)
    return linear_srgb(reflectance), linear_srgb(transmittance)


@dataclass(frozen=True)
class Table:
    reflectance: Array  # (nodes, 3)
    transmittance: Array
    clipped: float  # the most by which a value had to move to be a share of energy


def table(
    flake: Flake,
    binder_ior: float = BINDER_IOR,
    nodes: int = NODES,
    cosines: ArrayLike | None = None,
) -> Table:
    """Clipped to r in [0, 1], then t in [0, 1 - r], and rounded to DIGITS.

    At `nodes` equal steps of the cosine, or at `cosines`.
    """
    _require("nodes", nodes, 2, 4096, "")
    if cosines is None:
        cosines = np.linspace(0, 1, nodes)
    reflectance, transmittance = colours(flake, cosines, binder_ior)
    r = np.clip(reflectance, 0, 1).round(DIGITS)
    t = np.clip(transmittance, 0, 1 - r).round(DIGITS)
    moved = max(np.abs(r - reflectance).max(), np.abs(t - transmittance).max())
    return Table(r, t, float(moved))


def library_flake(kind: str, coating_nm: float) -> Flake:
    """A flake of METALS, whatever the thickness, or of PEARLS."""
    if kind in METALS:
        return named_flake(METALS[kind])
    name, platelet_nm = PEARLS[kind]
    return named_flake(name, coating_nm, platelet_nm)


def library() -> str:
    """The shader's table, as core/coating.h reads it: a line for each flake, numbers alone."""
    tables = {name: [_library_table(name, 0.0)] for name in METALS}
    tables |= {name: [_library_table(name, nm) for nm in LIBRARY_NM] for name in PEARLS}
    rows = [each.reflectance for kind in tables.values() for each in kind]
    rows += [each.transmittance for name in PASSING for each in tables[name]]
    return ",\n".join(", ".join(f"{x:.{DIGITS}f}" for x in row.flat) for row in rows) + "\n"


def _library_table(kind: str, coating_nm: float) -> Table:
    return table(library_flake(kind, coating_nm), cosines=LIBRARY_COSINES)


def _require(field: str, value: float, least: float, most: float, unit: str) -> None:
    if not least <= value <= most:
        raise ValueError(f"{field} is {value:g}, but must be from {least:g} to {most:g} {unit}")


def _list() -> str:
    lines = ["bare platelets, or COATING-on-PLATELET, coating one of " + ", ".join(COATINGS) + ":"]
    for name, (thickness, spread) in PLATELETS.items():
        lines.append(f"  {name:14} {MATERIALS[name]['title']}, {thickness:g} ± {spread:g} nm")
    lines += ["", "indices:"]
    lines += [
        f"  {name:14} {entry['source']} [{entry['data']}]" for name, entry in MATERIALS.items()
    ]
    return "\n".join(lines)


def _json(name: str, flake: Flake, binder_ior: float, result: Table) -> str:
    content = {
        "name": name,
        "platelet_nm": flake.platelet_nm,
        "spread_nm": flake.spread_nm,
        "coating_nm": flake.coating_nm,
        "binder_ior": binder_ior,
        "reflectance": result.reflectance.tolist(),
        "transmittance": result.transmittance.tolist(),
    }
    # A row of the table on each line.
    return re.sub(r"\[\s+([\d.]+),\s+([\d.]+),\s+([\d.]+)\s+\]", r"[\1, \2, \3]",
                  json.dumps(content, indent=2))  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("name", nargs="?", help="a flake, such as aluminium or tio2-on-mica")
    parser.add_argument("--list", action="store_true", help="the flakes and their sources")
    parser.add_argument("--thickness", type=float, metavar="NM", help="of the coating (60)")
    parser.add_argument("--platelet", type=float, metavar="NM", help="thickness of the platelet")
    parser.add_argument("--spread", type=float, metavar="NM", help="its standard deviation")
    parser.add_argument("--ior", type=float, default=BINDER_IOR, help="of the binder (1.5)")
    parser.add_argument("--nodes", type=int, default=NODES, help=f"rows of the table ({NODES})")
    parser.add_argument(
        "--plot", type=Path, metavar="FILE",
        help="draw its colours (needs the packages of requirements/accuracy.txt)",
    )  # fmt: skip
    parser.add_argument(
        "--library", action="store_true", help="print core/coating_library.inc, the shader's table"
    )
    arguments = parser.parse_args()
    if arguments.library:
        print(library(), end="")
        return 0
    if arguments.list:
        print(_list())
        return 0
    if arguments.name is None:
        parser.error("name a flake, or ask for --list or --library")
    try:
        flake = named_flake(
            arguments.name, arguments.thickness, arguments.platelet, arguments.spread
        )
        result = table(flake, arguments.ior, arguments.nodes)
    except ValueError as error:
        parser.error(str(error))
    print(_json(arguments.name, flake, arguments.ior, result))
    print(f"clipped by {result.clipped:.4f} at the most", file=sys.stderr)
    if arguments.plot:
        from coatings import plots

        plots.draw(arguments.name, flake, arguments.ior, arguments.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
