# SPDX-License-Identifier: Apache-2.0
"""Mean and variance of the surface anchor's pixels over footprints, slants and paints, by renders.

A plane under a sun, in the preset's closed form and with its sparkles. The variance is the
covariance of two renders with other random samples: their noise drops out. A pixel's first sample
is Cycles' at the pixel's centre whatever the seed, so it is taken off both.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import metallic_paint_core as core
import numpy as np
from mathutils import Matrix, Vector
from metallic_paint.paint import COATINGS, Paint, core_paint, material, presets
from metallic_paint.scene import lights
from pictures.render_scene import say

from motion.rows import Row
from motion.scenes import Stage

PRESETS = ("silver-coarse", "white-pearl", "candy-red", "glass-flake-black")  # of one species each
FOOTPRINTS = tuple(10.0**power for power in range(-2, 7))  # in flakes
ASPECTS = (1, 2, 5, 20, 50)
AZIMUTHS = (0, 20, 45)  # of the view to the cells' lattice, degrees
MOST_CELLS = 64
FEW = 2  # flakes: in smaller footprints a sample is as good as a pixel, and pixels are rare
SAMPLES, FEW_SAMPLES = 64, 4
# Pixels: tiles of so many have next to nothing in common; a flake may be 20 pixels wide, or one.
TILE, FEW_TILE = 8, 40


@dataclass(frozen=True)
class Case:
    flakes: float  # in a pixel's footprint
    aspect: float  # of the footprint
    azimuth: float

    @property
    def sun(self) -> float:
        """Its diameter, so large that some of the few flakes are lit."""
        return math.radians(0.53 if self.flakes > 300 else 4 if self.flakes > FEW else 20)


@dataclass(frozen=True)
class Found:
    case: Case
    mean: float  # over the closed form
    share: float  # of the variance that point flakes have through the same filter, or discs
    mean_error: float  # standard errors of both
    share_error: float


def law(size: int, names: Sequence[str]) -> Iterator[Row]:
    """Of these presets, in pictures of size x size pixels; larger where flakes are rare."""
    usual: list[Found] = []
    finest: list[Found] = []
    views = itertools.cycle(zip(ASPECTS * 3, AZIMUTHS * 5, strict=True))
    for name in names:
        paint = dataclasses.replace(presets.load(name), texture_contrast=0.0, orange_peel=0.0)
        cases = [Case(flakes, *next(views)) for flakes in FOOTPRINTS]
        usual += measure(name, paint, cases, size)
        fine = dataclasses.replace(paint, cells_per_pixel=float(MOST_CELLS))
        finest += measure(f"{name}, {MOST_CELLS} cells", fine, cases[4:], size)
    yield from summary("", usual, 0.7)
    yield from summary(f"{MOST_CELLS} cells a pixel, ", finest, 0.9)


def summary(what: str, found: Sequence[Found], least: float) -> Iterator[Row]:
    """Means over the cases of an aspect, of an azimuth and of a footprint, weighed by their errors.

    Three standard errors speak for the paint: of a dozen such means, one run in thirty has one that
    is farther off by chance.
    """
    shares, errors = [], []
    for key, name in (
        ("aspect", "{:g} to 1"),
        ("azimuth", "{:g}° to the lattice"),
        ("flakes", "{:g} flakes a pixel"),
    ):
        for value in sorted({getattr(each.case, key) for each in found}):
            alike = [each for each in found if getattr(each.case, key) == value]
            weights = np.array([each.share_error**-2 for each in alike])
            shares.append(np.average([each.share for each in alike], weights=weights))
            errors.append(weights.sum() ** -0.5)
            quantity = f"{what}{name.format(value)}: variance over that of flakes"
            yield Row(quantity, {"surface": float(shares[-1])})
    share, error = np.array(shares), 3 * np.array(errors)
    off = max(abs(each.mean - 1) - 3 * each.mean_error for each in found)
    yield Row(f"{what}largest standard error of these", {"surface": max(errors)})
    yield Row(f"{what}least of these, its three errors in favour",
              {"surface": float((share + error).min())}, least, "at least")  # fmt: skip
    yield Row(f"{what}greatest of these, its three errors in favour",
              {"surface": float((share - error).max())}, 1.05, "at most")  # fmt: skip
    for flakes in sorted({each.case.flakes for each in found}):
        worst = max(each.mean_error for each in found if each.case.flakes == flakes)
        yield Row(f"{what}{flakes:g} flakes: standard error of the mean", {"surface": worst})
    yield Row(f"{what}mean off the closed form, of all cases, their three errors in favour",
              {"surface": max(off, 0)}, 0.01, "at most")  # fmt: skip


def measure(name: str, paint: Paint, cases: Sequence[Case], size: int) -> list[Found]:
    stage = Stage(size, paint)
    stage.add_plane(2)
    mean = dataclasses.replace(paint, sparkle_contrast=0)
    closed = []
    stage.wear(material.create(mean))
    for case in cases:
        place(stage, case, 8)
        closed.append(stage.picture(FEW_SAMPLES)[..., 1].mean())
    stage.wear(material.create(dataclasses.replace(paint, anchor="surface")))
    found = []
    for case, whole in zip(cases, closed, strict=True):
        few = case.flakes < FEW
        scene = place(stage, case, size * 4 if few else size)
        mean, variance = scene.expected()
        samples = FEW_SAMPLES if few else SAMPLES
        centre = stage.picture(1)[..., 1]
        a, b = (
            ((samples * stage.picture(samples, seed)[..., 1] - centre) / (samples - 1) - whole)
            / mean
            for seed in (1, 2)
        )
        tile = FEW_TILE if few else TILE
        off, off_error = tiled((a + b) / 2, tile)
        share, share_error = tiled((a - off) * (b - off) * (mean * mean / variance), tile)
        found.append(Found(case, 1 + off, share, off_error, share_error))
        say(
            f"  {name}, {case.flakes:g} flakes, {case.aspect} to 1, {case.azimuth}°: "
            f"mean {1 + off:.4f} ± {off_error:.4f}, variance {share:.3f} ± {share_error:.3f}"
        )
    return found


def tiled(picture: np.ndarray, tile: int) -> tuple[float, float]:
    """Mean and its standard error, of tiles that are as good as independent."""
    height, width = (length // tile * tile for length in picture.shape)
    tiles = picture[:height, :width].reshape(height // tile, tile, width // tile, tile)
    means = tiles.mean(axis=(1, 3))
    return float(means.mean()), float(means.std(ddof=1) / math.sqrt(means.size))


def place(stage: Stage, case: Case, size: int) -> View:
    """The camera over the plane's middle so that a pixel has the case's footprint."""
    view = View(stage.paint, case)
    width = size * math.sqrt(view.footprint / case.aspect)
    away = 2 * width * case.aspect
    stage.thing.scale = 3 * [away]
    render, data = stage.scene.render, stage.camera.data
    render.resolution_x = render.resolution_y = size
    data.ortho_scale, data.clip_start, data.clip_end = width, away * 1e-2, away * 10
    stage.camera.location = away * view.towards_camera
    stage.camera.rotation_euler = view.towards_camera.to_track_quat("Z", "Y").to_euler()
    stage.sun.data.angle = case.sun
    stage.turn_sun(view.towards_sun)
    lights.fill(stage.scene)
    return view


TURNED = 0.12  # rad: what the flakes that sparkle are tilted by, towards the camera


class View:
    """A plane seen with the case's slant, and what the closed forms say of its pixels."""

    def __init__(self, paint: Paint, case: Case) -> None:
        self.paint, self.case = paint, case
        self.footprint = case.flakes / (paint.flakes_per_mm2 * 1e6)
        turn = Matrix.Rotation(math.radians(case.azimuth), 3, "Z")
        inside = math.asin(math.sqrt(1 - case.aspect**-2) / paint.binder_ior)

        def towards(angle_inside: float) -> Vector:
            sine = paint.binder_ior * math.sin(angle_inside)
            return turn @ Vector((sine, 0, math.sqrt(1 - sine * sine)))

        self.towards_camera = towards(inside)
        self.towards_sun = towards(2 * TURNED - inside)

    def expected(self) -> tuple[float, float]:
        """Mean and variance of a filtered pixel of green, of flakes of no size or of discs."""
        paint = self.paint
        disc = math.pi / 4 * (paint.flake_diameter_um * 1e-6) ** 2
        many = 1000 * disc  # m2: neither so few that they fill it nor so many that it is the mean
        pixel = dataclasses.replace(paint, anchor="pixel")
        light = core.Light(core.LightKind.parallel, self.towards_sun, math.sin(self.case.sun / 2))
        where: dict[str, list] = {
            "normal": [[0, 0, 1]],
            "view": [self.towards_camera],
            "position": [[0, 0, 0]],
            "pixel": [[0, 0]],
            "footprint": [many],
        }

        def evaluate(slant: list | None = None) -> dict[str, np.ndarray]:
            return core.evaluate(core_paint(pixel), [light], slant_depth=slant, **where)

        found = evaluate()
        mean, variance = (found[key][0, 0, 1] for key in ("mean_radiance", "variance"))
        seen = core.shade(core_paint(pixel), [light], **where)["coat_rest"][0]
        shown = IRRADIANCE * seen
        variance = variance * many / self.footprint * SQUARE * shown * shown
        cell = self.footprint / paint.cells_per_pixel + disc
        if cell < 64 * disc:
            clear = evaluate([[[0, 0, 0]]])["mean_radiance"][0, 0, 1]
            lit = found["mean_count"][0, 0] / (paint.flakes_per_mm2 * 1e6 * many)
            variance *= self.discs(disc, depth_of(mean / clear), lit)
        return mean * shown, variance

    def discs(self, disc: float, depth: float, lit: float) -> float:
        """The variance of discs, seen through the filter, over that of the closed form.

        Two samples on one disc, d apart, are filtered by the filter's autocorrelation at d. At the
        depth z, a share of the layer, both see it if no other disc hides either: discs over both
        count once, exp(-b z (2 - O(d/D))) with b the mean number of discs over a point and O the
        share of two discs d apart that overlap. The way of the light is the closed form's: in all
        exp(-(2 x - b O) z), x the depth of the layer there and back. Discs that let q pass, there
        and back, take (1 - q) b for b from one sample, and (1 - q)^2 b O count once. Correlated,
        the closed form has the mean square of the share of a disc that is free on both ways, that
        of traced discs: only how that square is spread over d is left. Else it has exp(-2 x z),
        flakes of no size. Of the discs over a point, b of which a share `lit` is lit, no second one
        is seen but through the first: that takes the square of the mean, less what such pairs show.
        """
        random = np.random.default_rng()  # a quadrature: 1e5 points leave 0.5 %
        paint, count = self.paint, 100_000
        sizes = np.maximum(1 + paint.flake_area_spread * random.standard_normal(count), 1e-9)
        radius = np.sqrt(disc * sizes / math.pi)[:, None]
        ends = [
            radius * np.sqrt(random.random((count, 1))) * np.stack([np.cos(t), np.sin(t)], axis=1)
            for t in 2 * math.pi * random.random((2, count))
        ]
        across = ends[1] - ends[0]
        side = math.sqrt(self.footprint / self.case.aspect)
        weight = sizes**2 * autocorrelation(across[:, 0] / (side * self.case.aspect))
        weight *= autocorrelation(across[:, 1] / side)
        u = np.minimum(np.hypot(*across.T) / (2 * radius[:, 0]), 1)
        overlap = 2 / math.pi * (np.arccos(u) - u * np.sqrt(1 - u * u))
        hiding = paint.flakes_per_mm2 * 1e6 * disc
        passed = self.passed()
        both = averaged(2 * depth - hiding * (1 - passed) ** 2 * overlap)
        correlated = paint.depth_model == "correlated"
        alone = both if correlated else averaged(2 * depth)
        upper, lower = np.sort(random.random((2, count)), axis=0)
        pairs = passed * np.exp(-hiding * (1 - passed) * ((1 + passed) * upper + lower - upper))
        mean = averaged(hiding * (1 - passed))
        square = averaged(hiding * (1 - passed * passed))
        alike = (weight * both).sum() / (sizes**2 * alone).sum()
        return float(alike * (1 - hiding * lit * (mean * mean - pairs.mean()) / square))

    def passed(self) -> float:
        """The share of green that flakes let pass on the ways there and back."""
        kind = COATINGS.index(self.paint.coating)
        if kind == 0:
            return self.paint.flake_transmission[1] ** 2
        _, through = core.library_coating([kind], [self.paint.coating_nm], [0.9])
        return float(through[0, 1]) ** 2


IRRADIANCE = 3.0  # of the stage's sun

# Blackman and Harris with the width of 1.5 pixels, which Cycles doubles (filter_table in its
# scene/film.cpp): its autocorrelation over that at 0, and the integral of its square in two
# dimensions, 1/pixel^2.
_STEP = 3 / 3000
_SHAPE = np.sum(
    [a * np.cos(2 * math.pi * k * np.linspace(0, 1, 3001)) for k, a in
     enumerate((0.35875, -0.48829, 0.14128, -0.01168))], axis=0,
)  # fmt: skip
_BOTH = np.correlate(_SHAPE, _SHAPE, "full")[3000:]
SQUARE = float(_BOTH[0] / _SHAPE.sum() ** 2 / _STEP) ** 2


def autocorrelation(pixels: np.ndarray) -> np.ndarray:
    return np.interp(np.abs(pixels), _STEP * np.arange(len(_BOTH)), _BOTH / _BOTH[0], right=0)


def averaged(x: float | np.ndarray) -> float | np.ndarray:
    """(1 - exp(-x))/x, paper, (6)."""
    return -np.expm1(-x) / x


def depth_of(left: float) -> float:
    """The depth that leaves so much on average."""
    depths = np.geomspace(1e-6, 1e3, 20_000)
    return float(np.interp(-left, -averaged(depths), depths))
