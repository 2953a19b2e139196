# SPDX-License-Identifier: Apache-2.0
"""Measured BRDFs: two published fits of MERL's metallic paints, and anyone's own file.

data/README.md names the papers, and MERL's terms of use.

Directions are unit vectors away from the surface, whose normal is z. A BRDF is in 1/sr.
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

Value = Callable[[np.ndarray, np.ndarray], np.ndarray]  # (n, 3) of (n, 3) lights and views

FITS = json.loads((Path(__file__).parent / "data" / "merl-fits.json").read_text())
NAMES = tuple(FITS)

# Of MERL's files: cells along the half angle (finer near 0), the difference angle and its azimuth,
# and what one unit of each colour stands for.
MERL_SIDES = (90, 90, 180)
MERL_SCALES = np.array([1.0, 1.15, 1.66]) / 1500

COLUMNS = ("theta_light", "theta_view", "phi", "red", "green", "blue")
FEWEST_ROWS = 30  # twice the numbers that a fit finds
MOST_VALUE = 1e6  # 1/sr, and below it
MOST_BYTES = 4 * 2**20
MOST_FITTED = 800  # rows that a fit looks at, evenly through the file
PLACES_AT_ONCE = 256
NEAR = math.radians(10)  # a place of a file's picture this far from all that it measured is unknown

GRAZING = math.radians(80)  # beyond, gonioreflectometers are not trusted; so all fits of MERL
INCIDENCES = (5, 15, 30, 45, 60, 75)
OFFSETS = (1.5, 3, 5, 7.5, 10, 13, 17, 22, 28, 35, 43, 52, 62, 75, 90, 110, 130)  # off the mirror
SIDES = (0, 45, 90, 135, 180)  # azimuths about the mirror direction, 0 towards the normal


class BrdfError(ValueError):
    """A BRDF that cannot be had, said in a sentence."""


@dataclass(frozen=True)
class Brdf:
    name: str
    source: str
    value: Value  # NaN where nothing is known
    light: np.ndarray  # (n, 3): where a paint is fitted to it
    view: np.ndarray
    second: Value | None = None  # another fit of the same measurement
    is_scattered: bool = False  # known only where it was measured


def direction(theta: np.ndarray, phi: np.ndarray | float = 0.0) -> np.ndarray:
    """From the angle to the normal and the azimuth, rad."""
    theta, phi = np.broadcast_arrays(theta, phi)
    return np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
    )


def load(name: str) -> Brdf:
    """One of NAMES, or a file."""
    if name in FITS:
        return published(name)
    path = Path(name)
    try:
        if not path.is_file():
            raise BrdfError(
                f"{name!r} is neither a file nor a measured paint; these are {', '.join(NAMES)}."
            )
        if path.suffix == ".csv":
            return _of_csv(path)
        if path.suffix == ".binary":
            return _of_merl(path)
    except OSError as error:  # a name too long, a file closed to us
        raise BrdfError(f"{path} cannot be read: {error.strerror}.") from error
    raise BrdfError(f"{path}: a measured BRDF is a .csv or one of MERL's .binary files.")


def standard(value: Value, name: str, source: str, second: Value | None = None) -> Brdf:
    """A BRDF that is known everywhere, fitted at even steps about the mirror direction."""
    # A reciprocal BRDF has the same value with both exchanged, and our paint is the faster to
    # compute the fewer views there are.
    views, lights = [], []
    for incidence in np.radians(INCIDENCES):
        about = np.concatenate([_about(incidence, math.radians(offset)) for offset in OFFSETS])
        about = about[about[:, 2] > math.cos(GRAZING)]
        views.append(np.tile(direction(incidence, np.pi), (len(about), 1)))
        lights.append(about)
    return Brdf(name, source, value, np.concatenate(lights), np.concatenate(views), second)


def _about(incidence: float, offset: float) -> np.ndarray:
    """Directions at that angle from the mirror direction of light from the left."""
    mirror = direction(np.array(incidence))
    inwards = direction(np.array(incidence - math.pi / 2))
    sides = np.radians(SIDES)[:, None]
    return math.cos(offset) * mirror + math.sin(offset) * (
        np.cos(sides) * inwards + np.sin(sides) * np.array([0.0, 1, 0])
    )


def published(name: str) -> Brdf:
    fits = FITS[name]
    sgd = {key: np.array(value) for key, value in fits["sgd"].items()}
    abc = {key: np.array(value) for key, value in fits["abc"].items()}
    return standard(
        lambda light, view: shifted_gamma(sgd, light, view), name,
        "MERL's measurement as fitted by Bagher, Soler and Holzschuch 2012",
        lambda light, view: abc_model(abc, light, view),
    )  # fmt: skip


def _halves(light: np.ndarray, view: np.ndarray) -> tuple[np.ndarray, ...]:
    """Cosines of light, view, half vector to the normal, and of light to the half vector."""
    half = light + view
    half = half / np.linalg.norm(half, axis=-1, keepdims=True)
    to_half = np.clip(np.sum(light * half, axis=-1, keepdims=True), 0, 1)
    return light[..., 2:], view[..., 2:], np.clip(half[..., 2:], 0, 1), to_half


def shifted_gamma(fit: dict[str, np.ndarray], light: np.ndarray, view: np.ndarray) -> np.ndarray:
    """Bagher et al. 2012: (rho_d + rho_s F D G G'/(cos cos'))/pi.

    D is a density of facets: its integral times the cosine is 1, kap alpha Gamma(1 - p, alpha) = 1,
    as the table's numbers have it.
    """
    cos_light, cos_view, cos_half, to_half = _halves(light, view)
    tan2 = 1 / cos_half**2 - 1
    x = fit["alpha"] + tan2 / fit["alpha"]
    density = fit["kap"] * np.exp(-x) * x ** -fit["p"] / (np.pi * cos_half**4)
    fresnel = fit["f0"] - fit["f1"] * to_half + (1 - fit["f0"]) * (1 - to_half) ** 5

    def unmasked(cosine: np.ndarray) -> np.ndarray:
        beyond = np.maximum(np.arccos(cosine) - fit["theta0"], 0)
        return np.clip(1 + fit["lambda"] * (1 - np.exp(fit["c"] * beyond ** fit["k"])), 0, 1)

    masked = unmasked(cos_light) * unmasked(cos_view)
    facets = fresnel * density * masked / (cos_light * cos_view)
    return (fit["diffuse"] + fit["specular"] * facets) / np.pi


def abc_model(fit: dict[str, np.ndarray], light: np.ndarray, view: np.ndarray) -> np.ndarray:
    """Löw et al. 2012: (rho_d + F S G/(cos cos'))/pi with S = A/(1 + B (1 - cos(theta_h)))^C.

    F is Fresnel's of the index ior, G that of V-shaped grooves (Cook and Torrance 1982).
    """
    cos_light, cos_view, cos_half, to_half = _halves(light, view)
    shape = fit["a"] / (1 + fit["b"] * (1 - cos_half)) ** fit["c"]
    g = np.sqrt(fit["ior"] ** 2 - 1 + to_half**2)
    ratio = (to_half * (g + to_half) - 1) / (to_half * (g - to_half) + 1)
    fresnel = ((g - to_half) / (g + to_half)) ** 2 * (1 + ratio**2) / 2
    grooves = np.minimum(1, 2 * cos_half * np.minimum(cos_light, cos_view) / to_half)
    return (fit["diffuse"] + fresnel * shape * grooves / (cos_light * cos_view)) / np.pi


def _of_merl(path: Path) -> Brdf:
    """Three counts, then planes of red, green and blue: doubles, negative where nothing is known.

    Rusinkiewicz's angles: of the half vector to the normal, in cells that grow as its square root;
    of the light to the half vector, and its azimuth about it.
    """
    expected = 12 + 3 * math.prod(MERL_SIDES) * 8
    if (size := path.stat().st_size) != expected:
        raise BrdfError(f"{path} has {size} bytes, but a MERL file has {expected}.")
    data = path.read_bytes()
    sides = tuple(int(n) for n in np.frombuffer(data, "<i4", 3))
    if sides != MERL_SIDES:
        raise BrdfError(f"{path} says that it has {sides} cells, but a MERL file has {MERL_SIDES}.")
    planes = np.frombuffer(data, "<f8", offset=12).reshape(3, *MERL_SIDES)
    if not np.isfinite(planes).all():
        raise BrdfError(f"{path} holds values that are no numbers.")
    if not (planes > 0).any():
        raise BrdfError(f"{path} holds no value above 0.")
    if (planes.max(axis=(1, 2, 3)) * MERL_SCALES >= MOST_VALUE).any():
        raise BrdfError(f"{path} holds values of {MOST_VALUE:.0f} 1/sr and more.")

    def value(light: np.ndarray, view: np.ndarray) -> np.ndarray:
        found = planes[(slice(None), *_merl_cell(light, view))]
        return np.where((found < 0).any(axis=0), np.nan, found).T * MERL_SCALES

    return _known(standard(value, path.stem, f"MERL's file {path.name}"))


def _merl_cell(light: np.ndarray, view: np.ndarray) -> tuple[np.ndarray, ...]:
    half = light + view
    half = half / np.linalg.norm(half, axis=-1, keepdims=True)
    theta_half = np.arccos(np.clip(half[:, 2], -1, 1))
    theta_difference = np.arccos(np.clip(np.sum(light * half, axis=-1), -1, 1))
    # The light in the frame of the half vector: turned by minus its azimuth, then by minus its
    # angle.
    away = np.hypot(half[:, 0], half[:, 1])
    cos_phi = np.where(away > 0, half[:, 0] / np.maximum(away, 1e-300), 1.0)
    sin_phi = np.where(away > 0, half[:, 1] / np.maximum(away, 1e-300), 0.0)
    x = light[:, 0] * cos_phi + light[:, 1] * sin_phi
    y = light[:, 1] * cos_phi - light[:, 0] * sin_phi
    x = x * half[:, 2] - light[:, 2] * away
    azimuth = np.arctan2(y, x) % np.pi
    cells = (
        np.sqrt(theta_half / (np.pi / 2)) * MERL_SIDES[0],
        theta_difference / (np.pi / 2) * MERL_SIDES[1],
        azimuth / np.pi * MERL_SIDES[2],
    )
    return tuple(
        np.clip(cell.astype(int), 0, side - 1) for cell, side in zip(cells, MERL_SIDES, strict=True)
    )


def _of_csv(path: Path) -> Brdf:
    """COLUMNS in any order; degrees, 1/sr; phi is the view's azimuth less the light's."""
    rows = np.array(list(_rows_of(path)))
    if len(rows) < FEWEST_ROWS:
        raise BrdfError(f"{path} has {len(rows)} rows, but a fit needs at least {FEWEST_ROWS}.")
    if not rows[:, 3:].any():
        raise BrdfError(f"{path} is black in every row.")
    theta_light, theta_view, phi = np.radians(rows[:, :3]).T
    light, view = direction(theta_light), direction(theta_view, phi)
    here = _place(light, view)
    places = np.concatenate([here, _place(view, light)])  # reciprocity
    values = np.concatenate([rows[:, 3:], rows[:, 3:]])

    def value(light: np.ndarray, view: np.ndarray) -> np.ndarray:
        wanted = _place(light, view)
        some = range(0, len(wanted), PLACES_AT_ONCE)
        return np.concatenate([_near(places, values, wanted[i : i + PLACES_AT_ONCE]) for i in some])

    lit = (theta_light <= GRAZING) & (theta_view <= GRAZING)
    different = len(np.unique(here[lit].round(6), axis=0))
    if different < FEWEST_ROWS:
        raise BrdfError(
            f"{path} has {different} rows of different angles up to {math.degrees(GRAZING):.0f}°, "
            f"but a fit needs at least {FEWEST_ROWS}."
        )
    lit &= np.cumsum(lit) % math.ceil(lit.sum() / MOST_FITTED) == 0
    return Brdf(path.stem, f"the file {path.name}", value, light[lit], view[lit], is_scattered=True)


def _near(places: np.ndarray, values: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """The mean of the four nearest places, by inverse squares of their distance."""
    square = np.sum(places**2, 1) + np.sum(wanted**2, 1)[:, None] - 2 * wanted @ places.T
    near = np.argpartition(square, 4, axis=1)[:, :4]
    square = np.maximum(np.take_along_axis(square, near, axis=1), 1e-18)
    mean = np.einsum("ij,ijk->ik", 1 / square, values[near]) / np.sum(1 / square, 1)[:, None]
    mean[square.min(axis=1) > NEAR**2] = np.nan
    return mean


def _place(light: np.ndarray, view: np.ndarray) -> np.ndarray:
    """One place for all pairs that are the same but for a turn or a mirror: an isotropic paint."""
    across = np.hypot(light[:, 0], light[:, 1])
    flat = np.stack([view[:, 0], view[:, 1]], axis=-1)
    towards = np.where(across[:, None] > 0, light[:, :2] / np.maximum(across, 1e-300)[:, None],
                       [1.0, 0.0])  # fmt: skip
    along = np.sum(flat * towards, axis=-1)
    aside = np.abs(flat[:, 0] * towards[:, 1] - flat[:, 1] * towards[:, 0])
    return np.stack([across, light[:, 2], along, aside, view[:, 2]], axis=-1)


def _rows_of(path: Path) -> Iterator[list[float]]:
    if path.stat().st_size > MOST_BYTES:
        raise BrdfError(f"{path} is larger than {MOST_BYTES} bytes.")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise BrdfError(f"{path} cannot be read: {error}.") from error
    lines = [(i, line) for i, line in enumerate(text.splitlines(), 1)
             if line.strip() and not line.startswith("#")]  # fmt: skip
    head = [word.strip() for word in _fields_of(path, *lines[0])] if lines else []
    for column in COLUMNS:
        if column not in head:
            raise BrdfError(
                f"{path} has no column {column}: its first line must name "
                f"{', '.join(COLUMNS)} (degrees, and 1/sr)."
            )
        if head.count(column) > 1:
            raise BrdfError(f"{path} has two columns {column}.")
    for number, line in lines[1:]:
        fields = _fields_of(path, number, line)
        if len(fields) > len(head):
            raise BrdfError(
                f"{path}, line {number} has {len(fields)} fields for {len(head)} columns: commas "
                "part them, and numbers need decimal points."
            )
        row = []
        for column in COLUMNS:
            at = head.index(column)
            word = fields[at].strip() if at < len(fields) else ""
            row.append(_number(f"{path}, line {number}: {column}", column, word))
        yield row


def _fields_of(path: Path, number: int, line: str) -> list[str]:
    try:
        return next(csv.reader([line]))
    except csv.Error as error:
        raise BrdfError(f"{path}, line {number} is no CSV: {error}.") from error


def _number(where: str, column: str, word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        raise BrdfError(f"{where} is {word!r}, but must be a number.") from None
    if column.startswith("theta"):
        low, high, range_ = 0.0, 90.0, "from 0 to below 90 degrees"
    elif column == "phi":
        low, high, range_ = -360.0, math.nextafter(360, 361), "from -360 to 360 degrees"
    else:
        low, high, range_ = 0.0, MOST_VALUE, f"from 0 to below {MOST_VALUE:.0f} 1/sr"
    if not low <= value < high:
        raise BrdfError(f"{where} is {word}, but must be {range_}.")
    return value


def _known(brdf: Brdf) -> Brdf:
    """Fitted only where it is known."""
    known = np.isfinite(brdf.value(brdf.light, brdf.view)).all(axis=1)
    if known.sum() < FEWEST_ROWS:
        raise BrdfError(f"{brdf.source} is unknown nearly everywhere.")
    return Brdf(brdf.name, brdf.source, brdf.value, brdf.light[known], brdf.view[known])
