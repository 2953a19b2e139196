# SPDX-License-Identifier: Apache-2.0
"""Renders the scenes of scenes.py in this Blender and checks each pixel against the core."""

from __future__ import annotations

import argparse
import dataclasses
import math
import os
import statistics
import sys
from pathlib import Path

from common import blender_env

blender_env.prepare()

import bpy  # noqa: E402
import metallic_paint_core as core  # noqa: E402
import numpy as np  # noqa: E402
from common import bars  # noqa: E402
from common.kept import keep  # noqa: E402
from metallic_paint import verify  # noqa: E402
from metallic_paint.native import core_lights  # noqa: E402
from metallic_paint.paint import core_paint  # noqa: E402
from metallic_paint.scene import lights  # noqa: E402

from verification import scenes as verify_scenes  # noqa: E402
from verification.images import write_comparison  # noqa: E402

SIZE = 256  # pixels along each side of a picture
LEAST_SAME_COUNT = 0.9999
STANDARD_ERRORS = 4.0  # two-sided: passed by chance once in 16,000
LEAST_SPARKLES = 400  # expected in the pictures from which a variance is found
VARIANCE_LEVEL = 1e-4  # of all variances in all scenes together
MOST_SEEDS = 64
JOINT_SAMPLES = 16
LEAST_BY_CHANCE = 100  # pixels, for a sum near enough to normal


@dataclasses.dataclass
class Sums:
    """Moments of the sparkles of one light over pixels and seeds: the picture's and the core's."""

    radiance: np.ndarray  # RGB, as all below
    expected: np.ndarray
    square: np.ndarray  # of the deviation from the expected value
    variance: np.ndarray
    fourth: np.ndarray  # of the square's deviation from the variance, squared
    sparkles: float = 0.0  # expected

    @classmethod
    def zero(cls) -> Sums:
        return cls(*(np.zeros(3) for _ in range(5)))

    def add(self, radiance: np.ndarray, predicted: dict, light: int) -> None:
        mean = predicted["mean_radiance"][:, light]
        self.radiance += radiance.sum(axis=0, dtype=float)
        self.expected += mean.sum(axis=0)
        square, variance = (radiance - mean) ** 2, predicted["variance"][:, light]
        self.square += square.sum(axis=0)
        self.variance += variance.sum(axis=0)
        self.fourth += ((square - variance) ** 2).sum(axis=0)
        leader = np.maximum(predicted["leader"][:, [light]], 0)  # whose sparkles this light shows
        self.sparkles += float(np.take_along_axis(predicted["mean_count"], leader, axis=1).sum())

    def standard_errors(self) -> float:
        # Seen from afar nothing fluctuates: then rounding is left.
        error = np.maximum(np.sqrt(self.variance), 1e-6 * self.expected)
        return float(np.abs((self.radiance - self.expected) / error).max())

    def variance_errors(self) -> float:
        """Standard errors between found and expected variance, of the worst colour."""
        if not self.variance.any():
            return 0.0
        return float(
            np.abs((self.square - self.variance) / np.maximum(np.sqrt(self.fourth), 1e-300)).max()
        )


def variance_bar() -> float:
    """Standard errors that no variance of any colour, lamp and scene passes by chance (Sidak)."""
    tests = 3 * sum(len(scene.lamps) for scene in verify_scenes.SCENES)
    each = -math.expm1(math.log1p(-VARIANCE_LEVEL) / tests)
    return statistics.NormalDist().inv_cdf(1 - each / 2)


def check(spec: verify_scenes.Scene, out: Path) -> list[bars.Bar]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    item = verify_scenes.build(scene, spec, SIZE)
    probe = verify.Probe(scene, [item.active_material])
    probe.drive("Seed")
    geometry = probe.geometry()
    slots = core_lights()
    found = lights.fill(scene)
    lamps = (*found.slots, *([scene.world] if found.sky else []))
    label = f"{blender()}, {spec.name}"
    report = check_camera(label, scene, geometry) + check_passes(label, probe, geometry)
    report += check_mixture(label, spec, probe, geometry)

    for light, lamp in enumerate(lamps):
        comparison, sums, shown = None, Sums.zero(), None
        for seed in range(MOST_SEEDS):
            if seed >= spec.seeds and sums.sparkles >= LEAST_SPARKLES:
                break
            paint = core_paint(dataclasses.replace(spec.paint, seed=spec.paint.seed + seed))
            probe.set("Seed", paint.seed)
            first = verify.predict(paint, slots, geometry, "float")
            leader = int(first["leader"][:, light].max())
            if leader < 0:
                break  # below the horizon of every pixel: nothing to see
            radiance = probe.image(verify.RADIANCE, leader)
            sums.add(
                radiance[geometry.hit], verify.predict(paint, slots, geometry, "double"), light
            )
            if seed:
                continue
            count = probe.image(verify.COUNT, leader)[..., 0]
            cone = probe.image(verify.CONE, leader)[..., 0]
            lit = [probe.lit_by([lamp], d, leader) for d in (verify.SPARKLES, verify.IRRADIANCE)]
            comparison = verify.compare(
                paint, slots, geometry, first, light, leader, count, cone, *lit
            )
            shown = lit, first
        where = label if len(lamps) == 1 else f"{label}, {lamp.name}"
        if comparison is None:
            dark = probe.lit_by([lamp], verify.SPARKLES)
            report.append(bars.at_most(f"{where}: brightest pixel of a light that is down",
                                       float(dark.max()), 0.0, "W/m²/sr"))  # fmt: skip
            continue
        report += judge_counts(where, comparison)
        if _are_independent(spec):
            report += judge_sums(where, sums)
        (picture, irradiance), predicted = shown
        faces = predicted["leader"][:, light] >= 0
        report += check_irradiance(where, spec, lamp, geometry, irradiance, faces)
        wanted = np.zeros_like(picture)
        wanted[geometry.hit] = predicted["radiance"][:, light] * irradiance[geometry.hit]
        leader = int(predicted["leader"][:, light].max())
        report += check_by_chance(where, probe, lamp, leader, comparison, irradiance)
        title = f"{spec.name}{'' if len(lamps) == 1 else f', {lamp.name}'}"
        write_comparison(out / f"{slug(title)}.png", picture, wanted)
    if len(lamps) > 1:
        report.append(check_joint(label, probe, lamps))
    return report


def check_irradiance(
    where: str,
    spec: verify_scenes.Scene,
    lamp: bpy.types.Object | bpy.types.World,
    geometry: verify.Geometry,
    irradiance: np.ndarray,
    faces: np.ndarray,
) -> list[bars.Bar]:
    """Lit cones of radiance 1 against the lamp's own irradiance, and that no pixel is missed."""
    found = irradiance[geometry.hit][faces].max(axis=-1)
    report = []
    kind = "WORLD" if isinstance(lamp, bpy.types.World) else lamp.data.type
    if spec.shape in ("plane", "sphere") and kind != "SPOT":  # nothing shadows itself
        share = (found > 0).mean()
        report.append(bars.at_least(f"{where}: share of facing pixels that are lit", share, 0.99))
    if kind == "SUN":
        # Cycles gives each direction of the disc the same share; energy weighs them by the cosine.
        expected = np.full(len(found), lamp.data.energy * 2 / (1 + np.cos(lamp.data.angle / 2)))
    elif kind == "AREA":
        # A sample of an ellipse tells no more of it than its place there: the mean over all pixels.
        expected = area_irradiance(lamp, geometry.position[geometry.hit][faces])
        error = abs(float(found.mean() / expected.mean()) - 1)
        return [*report, bars.at_most(f"{where}: relative error of the mean irradiance", error,
                                      1e-2)]  # fmt: skip
    elif kind == "POINT" and lamp.data.shadow_soft_size == 0:
        away = geometry.position[geometry.hit][faces] - np.array(lamp.matrix_world.translation)
        expected = lamp.data.energy / (4 * np.pi * (away**2).sum(axis=-1))
    else:
        return report
    error = np.abs(found / expected - 1)[found > 0]
    report.append(bars.at_most(f"{where}: relative error of the irradiance, 99.9 % of pixels",
                               float(np.quantile(error, 0.999)), 1e-3))  # fmt: skip
    return report


def area_irradiance(lamp: bpy.types.Object, positions: np.ndarray) -> np.ndarray:
    """Of an area light, on planes that face it: its radiance times its solid angle."""
    data, steps = lamp.data, 24
    middles = (np.arange(steps) + 0.5) / steps - 0.5
    u, v = (each.ravel() for each in np.meshgrid(middles, middles))
    inside = u * u + v * v <= 0.25 if data.shape in ("DISK", "ELLIPSE") else u == u
    across = data.size, data.size_y if data.shape in ("RECTANGLE", "ELLIPSE") else data.size
    matrix = np.array(lamp.matrix_world, dtype=float)
    local = np.stack([u * across[0], v * across[1], 0 * u], axis=-1)[inside]
    off = (local @ matrix[:3, :3].T + matrix[:3, 3])[np.newaxis] - positions[:, np.newaxis]
    squared = (off**2).sum(axis=-1)
    facing = off @ matrix[:3, 2]  # the lit side is that of -z
    return data.energy / np.pi * (facing / squared**1.5).mean(axis=-1)


def check_joint(
    label: str, probe: verify.Probe, lamps: tuple[bpy.types.Object | bpy.types.World, ...]
) -> bars.Bar:
    """All lamps at once against the sum of the pictures of each: Cycles picks a lamp per sample."""
    probe.scene.cycles.samples = JOINT_SAMPLES
    total = sum(probe.lit_by([lamp], verify.SPARKLES) for lamp in lamps)
    difference = (probe.lit_by(lamps, verify.SPARKLES) - total).mean(axis=-1)
    probe.scene.cycles.samples = 1
    difference = difference[total.max(axis=-1) > 0]
    error = max(difference.std() / np.sqrt(difference.size), 1e-6 * total.mean())
    return bars.at_most(f"{label}: all lamps at once off the sum of each, standard errors",
                        float(np.abs(difference.mean()) / error), STANDARD_ERRORS)  # fmt: skip


def blender() -> str:
    return f"Blender {bpy.app.version_string.removesuffix(' LTS')}"


def _are_independent(spec: verify_scenes.Scene) -> bool:
    """Whether the pixels' sparkles are.

    A cell of the surface is no smaller than a flake, so close up several pixels share one.
    """
    pixel = spec.width / SIZE
    flake = max(each.flake_diameter_um for each in spec.paint.species if each.flakes_per_mm2 > 0)
    return spec.paint.anchor == "pixel" or pixel > 2e-6 * flake


def judge_counts(where: str, comparison: verify.Comparison) -> list[bars.Bar]:
    c = comparison
    print(f"  {where}: {c.pixels} pixels, another count in {c.pixels - c.same_count} "
          f"(pixel edge {c.at_pixel_edge}, threshold {c.at_threshold}, "
          f"unexplained {c.unexplained}), {int(c.by_chance.sum())} below Cycles' least weight",
          flush=True)  # fmt: skip
    error = c.radiance_error if c.radiance_error.size else np.array([np.inf])
    return [
        bars.at_least(f"{where}: share of pixels with the same count", c.same_count / c.pixels,
                      LEAST_SAME_COUNT),
        bars.at_most(f"{where}: pixels with an unexplained count", c.unexplained, 0, "pixels"),
        bars.at_most(f"{where}: relative error of radiance, 99.9 % of pixels",
                     float(np.quantile(error, 0.999)), 1e-3),
        bars.at_most(f"{where}: relative error of radiance, all pixels", float(error.max()),
                     verify.MOST_RADIANCE_ERROR),
    ]  # fmt: skip


def judge_sums(where: str, sums: Sums) -> list[bars.Bar]:
    return [
        bars.at_most(f"{where}: mean radiance off the closed form, standard errors",
                     sums.standard_errors(), STANDARD_ERRORS),
        bars.at_least(f"{where}: expected sparkles of the variance", sums.sparkles,
                      LEAST_SPARKLES, "sparkles"),
        bars.at_most(f"{where}: variance off the closed form, standard errors",
                     sums.variance_errors(), variance_bar()),
    ]  # fmt: skip


def check_camera(label: str, scene: bpy.types.Scene, geometry: verify.Geometry) -> list[bars.Bar]:
    """The shader's view vectors and footprints against the camera, computed here in double."""
    hit = geometry.hit
    camera = scene.camera
    world = np.array(camera.matrix_world, dtype=float)
    axis = world[:3, 2]
    data, size = camera.data, scene.render.resolution_x
    position = geometry.position[hit].astype(float)
    normal = geometry.normal[hit].astype(float)
    to_eye = world[:3, 3] - position
    depth = to_eye @ axis
    if data.type == "ORTHO":
        view = np.broadcast_to(axis, position.shape)
        pixel = np.full(len(position), data.ortho_scale / size)
    else:
        view = to_eye / np.linalg.norm(to_eye, axis=1, keepdims=True)
        pixel = depth * 2 * np.tan(data.angle / 2) / size
    # A pixel's rays cut pixel² out of a plane across the view axis.
    footprint = pixel**2 * (view @ axis) / (view * normal).sum(axis=1)
    facing = (view * normal).sum(axis=1) > 0.01
    report = [
        bars.at_most(f"{label}: error of the view vector",
                     float(np.abs(geometry.view[hit] - view).max()), 1e-5),
    ]  # fmt: skip
    if data.type == "PANO":  # whose footprints are differentials of Cycles
        return report
    return [
        *report,
        bars.at_most(f"{label}: relative error of the pixel's footprint, 99.9 % of pixels",
                     float(np.quantile(np.abs(geometry.footprint[hit] / footprint - 1)[facing],
                                       0.999)), 1e-3),
    ]  # fmt: skip


def check_passes(label: str, probe: verify.Probe, geometry: verify.Geometry) -> list[bars.Bar]:
    """The places that the core is given against Cycles' own Position and Normal passes."""
    position, normal = probe.passes()
    hit = geometry.hit
    extent = np.abs(geometry.position[hit]).max()
    off = np.abs(position[hit] - geometry.position[hit]).max() / extent
    turned = np.abs(normal[hit] - geometry.normal[hit]).max()
    return [
        bars.at_most(f"{label}: position off Cycles' pass, of the scene's extent", off, 1e-6),
        bars.at_most(f"{label}: normal off Cycles' pass", turned, 1e-6),
    ]


def check_mixture(
    label: str, spec: verify_scenes.Scene, probe: verify.Probe, geometry: verify.Geometry
) -> list[bars.Bar]:
    """What substrate and mixtures reflect, and the factor of their texture, against the core."""
    paint, hit = spec.paint, geometry.hit
    cosine = (geometry.normal[hit] * geometry.view[hit]).sum(axis=-1)
    wanted = core.mixture(core_paint(paint), paint.substrate_color, np.clip(cosine, 1e-4, 1))
    if paint.composition == "published":
        for lobe in ("glossy", "returned"):
            wanted["diffuse"] += wanted[lobe]  # type: ignore[literal-required]
            wanted[lobe][...] = 0  # type: ignore[literal-required]
    factor = 1.0
    report = []
    if paint.texture_contrast > 0:
        found = probe.image(verify.TEXTURE)[hit][:, 0]
        report.append(check_texture(label, core_paint(paint), geometry, found))
        factor = found[:, np.newaxis]
    # 1e-4 of white: float against double, and the cosine by another sum.
    for lobe, shown in (
        ("diffuse", verify.DIFFUSE), ("glossy", verify.GLOSSY), ("returned", verify.RETURNED)
    ):  # fmt: skip
        found = probe.image(shown)[hit] / factor
        report.append(
            bars.at_most(f"{label}: error of the {lobe} albedo",
                         float(np.abs(found - wanted[lobe]).max()), 1e-4)
        )  # fmt: skip
    found = probe.image(verify.ROUGHNESS)[hit][:, 0]
    report.append(
        bars.at_most(f"{label}: error of the glossy lobe's roughness",
                     float(np.abs(found - wanted["alpha"]).max()), 1e-4)
    )  # fmt: skip
    return report


def check_texture(
    label: str, paint: core.Paint, geometry: verify.Geometry, found: np.ndarray
) -> bars.Bar:
    """The factor that each pixel shows, or each cell of the surface."""
    hit = geometry.hit
    if paint.anchor == core.Anchor.pixel:
        x, y = geometry.own_pixel()[hit].T
        expected = core.pixel_texture(
            paint.texture_contrast, geometry.footprint[hit], x, y, seed=paint.seed
        )
        inside = (geometry.pixel[hit] == geometry.own_pixel()[hit]).all(axis=-1)
        return bars.at_most(f"{label}: relative error of the texture",
                            float(np.abs(found / expected - 1)[inside].max()), 1e-5)  # fmt: skip
    # In double, which in one pixel of a million takes a parent whole that the shader halves; the
    # rounding of the deviate's quantile is the rest.
    expected = core.shade(paint, [], **geometry.places())["texture"]
    error = np.quantile(np.abs(found / expected - 1), 0.999)
    return bars.at_most(f"{label}: relative error of the texture, 99.9 % of pixels",
                        float(error), 1e-4)  # fmt: skip


def check_by_chance(
    where: str,
    probe: verify.Probe,
    lamp: bpy.types.Object,
    leader: int,
    comparison: verify.Comparison,
    irradiance: np.ndarray,
) -> list[bars.Bar]:
    """Pixels below Cycles' least weight are kept by lot: few, and right on average.

    Both pictures have the same samples; the lots are independent from pixel to pixel.
    """
    dim = comparison.by_chance
    report = [bars.at_most(f"{where}: share of pixels kept by lot", dim.mean(), 0.05)]
    if dim.sum() < LEAST_BY_CHANCE:
        return report
    probe.scene.cycles.samples = JOINT_SAMPLES
    found = probe.lit_by([lamp], verify.SPARKLES)[dim]
    expected = probe.image(verify.RADIANCE, leader)[dim] * irradiance[dim]
    probe.scene.cycles.samples = 1
    off = (found - expected).sum(axis=-1)
    report.append(
        bars.at_most(f"{where}: sum of the pixels kept by lot, standard errors",
                     abs(off.sum()) / np.sqrt((off**2).sum()), STANDARD_ERRORS)
    )  # fmt: skip
    return report


def _send_chatter_to(log: Path) -> None:
    """What Blender writes of each picture goes into the log, our own lines to the console."""
    sys.stdout = os.fdopen(os.dup(1), "w")
    with log.open("wb") as file:
        os.dup2(file.fileno(), 1)


def slug(name: str) -> str:
    return "-".join("".join(c if c.isalnum() else " " for c in name.lower()).split())


def main() -> int:
    parser = argparse.ArgumentParser(prog="paint verify", description=__doc__)
    parser.add_argument("--json", type=Path, required=True, help="the report")
    parser.add_argument("--out", type=Path, required=True, help="folder for the pictures")
    parser.add_argument(
        "--only", default="", metavar="TEXT", help="only scenes with TEXT in the name"
    )
    parser.add_argument(
        "--again", action="store_true", help="also the scenes whose bars held on these sources"
    )
    arguments = parser.parse_args()
    scenes = [s for s in verify_scenes.SCENES if arguments.only in s.name]
    if not scenes:
        print(f"No scene has “{arguments.only}” in its name.", file=sys.stderr)
        return 2
    arguments.out.mkdir(parents=True, exist_ok=True)
    _send_chatter_to(arguments.out / "blender.log")
    report: list[bars.Bar] = []
    kept = keep(f"verify, {blender()}", again=arguments.again)
    for number, spec in enumerate(scenes, 1):
        before = kept.get(spec.name)
        print(f"[{number}/{len(scenes)}] {spec.name}{': held before' * bool(before)}", flush=True)
        found = [bars.Bar(**bar) for bar in before] if before else check(spec, arguments.out)
        for bar in found:
            if not bar.holds:
                print(f"  {bar}", flush=True)
        if not before and all(bar.holds for bar in found):
            kept.add(spec.name, [dataclasses.asdict(bar) for bar in found])
        report += found
    bars.write(report, arguments.json)
    return 0 if all(bar.holds for bar in report) else 1


if __name__ == "__main__":
    blender_env.run(main)
