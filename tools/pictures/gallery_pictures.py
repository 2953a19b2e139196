# SPDX-License-Identifier: Apache-2.0
"""Renders one picture of ./paint gallery, of one or more shots side by side, to a JPEG."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from common import blender_env

blender_env.prepare()

import bpy  # noqa: E402
import numpy as np  # noqa: E402
import OpenImageIO  # noqa: E402
from mathutils import Vector  # noqa: E402
from metallic_paint.paint import material  # noqa: E402

from pictures import gallery_scenes as scenes  # noqa: E402
from pictures import render_scene, studio  # noqa: E402
from pictures.render_scene import RenderError, say  # noqa: E402

QUICK_SAMPLES = 4
MOST_BYTES = {"swatches": 490_000, "macro": 390_000}  # a picture of the repository is small
OTHERWISE_MOST = 290_000


class Photographer:
    """How large and how well the shots are taken.

    Photographs are denoised but for their sparkles, and shown through AgX. Other pictures show
    colours as they are, to be compared.
    """

    def __init__(self, quick: bool, names: Sequence[str], as_photographs: bool = True) -> None:
        self.quick = quick
        self.names = names
        self.as_photographs = as_photographs

    def scene(self, width: int, height: int, samples: int, exposure: float = 0) -> bpy.types.Scene:
        if self.quick:
            width, height, samples = width // 2, height // 2, QUICK_SAMPLES
        return scenes.empty_scene(width, height, samples, exposure, self.as_photographs)

    def shoot(self, scene: bpy.types.Scene, what: str) -> np.ndarray:
        """The picture (h, w, 3) of 8 bits."""
        start = time.monotonic()
        if self.as_photographs:
            render_scene.denoise_all_but_sparkles(scene)
        render_scene.take(scene)
        file = Path(bpy.app.tempdir) / "shot.png"
        render_scene.save(scene, file)
        say(f"  {what}, {time.monotonic() - start:.0f} s")
        return OpenImageIO.ImageBuf(str(file)).get_pixels(OpenImageIO.UINT8)[..., :3]


# ---- The pictures: each a list of rows of shots ----


def swatches(photographer: Photographer) -> list[list[np.ndarray]]:
    scene = photographer.scene(280, 210, 16)
    things = scenes.swatch(scene)
    render_scene.paint_objects(things, render_scene.load_paint(photographer.names[0]))
    label = scenes.add_label(scene, "")
    shots = []
    for name in photographer.names:
        material.apply(things[0].data.materials[0], render_scene.load_paint(name))
        label.data.body = name
        shots.append(photographer.shoot(scene, name))
    columns = 6 if len(shots) > 12 else min(len(shots), 4)
    shots += [np.zeros_like(shots[0])] * (-len(shots) % columns)
    return [shots[i : i + columns] for i in range(0, len(shots), columns)]


def car(
    photographer: Photographer,
    preset: str,
    light: Callable[[bpy.types.Scene], None],
    samples: int = 24,
) -> list[list[np.ndarray]]:
    scene = photographer.scene(880, 495, samples)
    body = scenes.car(scene)
    render_scene.paint_objects([body], render_scene.load_paint(preset))
    light(scene)
    return [[photographer.shoot(scene, preset)]]


def direction(azimuth: float, elevation: float) -> tuple[float, float, float]:
    """Towards that place of the sky; degrees, the azimuth from the car's nose to its left."""
    a, e = math.radians(azimuth), math.radians(elevation)
    return (math.cos(a) * math.cos(e), math.sin(a) * math.cos(e), math.sin(e))


def sun(scene: bpy.types.Scene) -> None:
    turn = -21
    scenes.add_street(scene, 0.09, (7, 25))
    scenes.set_studio_light(scene, "sunrise", 1.4, turn)
    # The picture's own sun, half under the horizon, stands at -36 degrees.
    scenes.add_sun(scene, direction(-36 - turn, 25), 5, (1, 0.88, 0.7))


def sky(scene: bpy.types.Scene) -> None:
    towards_sun = direction(-95, 14)
    scenes.add_street(scene, 0.12, (300, 3000))
    scenes.add_sun(scene, towards_sun, 4, (1, 0.85, 0.66))
    scenes.set_sky(scene, towards_sun, 0.18)


def surroundings(scene: bpy.types.Scene) -> None:
    scenes.add_street(scene, 0.06, (7, 25))
    scenes.set_studio_light(scene, "forest", 0.85, 200)


def softboxes(scene: bpy.types.Scene) -> None:
    studio.build(scene, scene.objects["Body"])


def macro(photographer: Photographer) -> list[list[np.ndarray]]:
    shown = [
        ("silver-coarse", 2.5), ("green-purple", 1), ("glass-flake-black", 5), ("bass-boat", 10)
    ]  # fmt: skip
    shots = []
    for preset, mm in shown[:2] if photographer.quick else shown:
        scene = photographer.scene(300, 300, 128, exposure=0.7)
        ball = scenes.macro(scene, mm * 1e-3)
        render_scene.paint_objects([ball], render_scene.load_paint(preset))
        shots.append(photographer.shoot(scene, preset))
    return [shots]


def distance(photographer: Photographer) -> list[list[np.ndarray]]:
    preset, enlarged = "silver-coarse", 8
    scene = photographer.scene(400, 300, 20)
    body = scenes.car(scene)
    render_scene.paint_objects([body], render_scene.load_paint(preset))
    sky(scene)
    scene.render.use_persistent_data = True  # the paint stays compiled
    away = Vector((0.78, -0.95, 0.12)).normalized()
    target = scenes.seen_point(scene, Vector((0.5, -0.4, 0.7)), away)
    shots = []
    for metres in (1, 10, 100):
        camera = scenes.add_camera(scene, target + metres * away, target, 0.45 * metres)  # one lens
        shot = photographer.shoot(scene, f"{preset}, {metres} m")
        shots.append(_middle(shot, enlarged if metres == 100 else 1))
        bpy.data.objects.remove(camera)
    return [shots]


def _middle(shot: np.ndarray, scale: int) -> np.ndarray:
    """The middle of the shot, each of its pixels `scale` pixels wide."""
    if scale == 1:
        return shot
    h, w = shot.shape[:2]
    top, left = h * (scale - 1) // (2 * scale), w * (scale - 1) // (2 * scale)
    part = shot[top : top + -(-h // scale), left : left + -(-w // scale)]
    return part.repeat(scale, axis=0).repeat(scale, axis=1)[:h, :w]


TURN = math.radians(5)  # of the turntable, to and fro
FRAMES = 16  # one way


def turntable(photographer: Photographer) -> list[list[np.ndarray]]:
    """The front wing while the car turns to and fro: a row for each frame."""
    scene = photographer.scene(480, 270, 16)
    scene.render.use_persistent_data = True  # the paint stays compiled
    body = scenes.car(scene)
    render_scene.paint_objects([body], render_scene.load_paint("candy-red"))
    table = bpy.data.objects.new("Turntable", None)
    for thing in scene.objects:
        if thing.type == "MESH":
            thing.parent = table
    scene.collection.objects.link(table)
    softboxes(scene)
    away = Vector((0.45, -1, 0.35)).normalized()
    target = scenes.seen_point(scene, Vector((1.05, -0.8, 0.72)), away)
    bpy.data.objects.remove(scene.camera)
    camera = scenes.add_camera(scene, target + 3 * away, target, 0.9).data
    camera.dof.use_dof, camera.dof.focus_distance, camera.dof.aperture_fstop = True, 3, 2.0
    frames = 3 if photographer.quick else FRAMES
    rows = []
    for k in range(frames):
        table.rotation_euler.z = -TURN / 2 * math.cos(math.pi * k / (frames - 1))
        rows.append([photographer.shoot(scene, f"frame {k}")])
    return rows


PICTURES: dict[str, Callable[[Photographer], list[list[np.ndarray]]]] = {
    "swatches": swatches,
    "car-sun": lambda photographer: car(photographer, "deep-blue", sun),
    "car-sky": lambda photographer: car(photographer, "silver-coarse", sky),
    "car-surroundings": lambda photographer: car(photographer, "green-purple", surroundings),
    "car-studio": lambda photographer: car(photographer, "candy-red", softboxes),
    "macro": macro,
    "distance": distance,
    "turntable": turntable,
}


def write(picture: np.ndarray, file: Path, most: int) -> None:
    """As good as the bytes allow; sparkles keep their colour (no chroma subsampling)."""
    for quality in range(95, 30, -5):
        image = OpenImageIO.ImageBuf(np.ascontiguousarray(picture))
        image.specmod().attribute("compression", f"jpeg:{quality}")
        image.specmod().attribute("jpeg:subsampling", "4:4:4")
        if not image.write(str(file), OpenImageIO.UINT8):
            raise RenderError(f"{file} cannot be written: {image.geterror()}")
        if file.stat().st_size <= most:
            return


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("picture", choices=PICTURES)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--presets", nargs="+", required=True)
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    with render_scene.quiet():
        rows = PICTURES[arguments.picture](Photographer(arguments.quick, arguments.presets))
        if arguments.out.suffix == ".npy":  # frames of a film
            np.save(arguments.out, np.stack([np.concatenate(row, axis=1) for row in rows]))
            return
        picture = np.concatenate([np.concatenate(row, axis=1) for row in rows])
        write(picture, arguments.out, MOST_BYTES.get(arguments.picture, OTHERWISE_MOST))


if __name__ == "__main__":
    render_scene.run(main)
