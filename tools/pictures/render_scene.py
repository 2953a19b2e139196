# SPDX-License-Identifier: Apache-2.0
"""What ./paint demo and ./paint render share: one picture, with progress on the way, whole or not.

What Blender prints goes into a log that shows only when something breaks. Each file is written
beside its place and moved there when all of them are complete.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import re
import signal
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import IO, NoReturn

import bpy
import numpy as np
import OpenImageIO
from common import blender_env, files
from common.processes import is_outermost
from metallic_paint import denoise
from metallic_paint.paint import Paint, material, presets
from metallic_paint.scene import needs, placed

SUFFIXES = (".exr", ".png")
PAINT_INDEX = 31417  # of our material in the index pass, which tells where the picture shows it
INDEX_PASSES = ("IndexMA", "Material Index")  # its names in Blender 4 and 5
TILES = 12  # of a picture, at least: Cycles tells how far it is after each
LOG_LINES = 25

STUDIO_SIZE = (960, 540)
STUDIO_SAMPLES = 24
MOST_SAMPLES, MOST_PIXELS = 2**24, 2**16  # Blender's own limits
VIEW_TRANSFORM, LOOK = "AgX", "AgX - Medium High Contrast"  # as a camera's film takes bright light

_console: IO[str] = sys.stdout


class RenderError(Exception):
    """What keeps the picture from being made, in a sentence for whoever asked for it."""


# --- the process -----------------------------------------------------------------------------


def run(main: Callable[[], None]) -> NoReturn:
    """Ends with 0, 1 after a sentence on stderr, 2 for wrong usage, 3 for a bug of ours."""
    _watch_signals()
    code = 0
    try:
        main()
    except SystemExit as request:  # of argparse
        code = request.code
    except RenderError as error:
        print(error, file=sys.stderr)
        code = 1
    except Exception:
        traceback.print_exc()
        code = 3
    _end(code)


def _watch_signals() -> None:
    """Ends the process within a render too, where Python would see Ctrl-C only afterwards."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    signal.set_wakeup_fd(writer)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: None)

    def wait() -> None:
        number = os.read(reader, 1)[0]
        if is_outermost():
            say("\nInterrupted.")
        _end(128 + number)

    threading.Thread(target=wait, daemon=True).start()


def _end(code: int) -> NoReturn:
    try:
        files.remove_unfinished()
    finally:
        blender_env.finish(code)


def say(line: str) -> None:
    print(line, file=_console, flush=True)


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Only say() reaches the console; after a bug, the end of what Blender said follows."""
    global _console
    with contextlib.ExitStack() as stack:
        log = stack.enter_context(tempfile.TemporaryFile())
        kept = [os.dup(fd) for fd in (1, 2)]
        _console = stack.enter_context(os.fdopen(os.dup(kept[0]), "w"))

        def restore() -> None:
            global _console
            for stream in (sys.stdout, sys.stderr):
                stream.flush()
            for fd, copy in zip((1, 2), kept, strict=True):
                os.dup2(copy, fd)
                os.close(copy)
            _console = sys.stdout

        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        for fd in (1, 2):
            os.dup2(log.fileno(), fd)
        stack.callback(restore)
        try:
            yield
        except RenderError:
            raise
        except Exception:
            for stream in (sys.stdout, sys.stderr):
                stream.flush()
            log.seek(0)
            said = log.read().decode(errors="replace").splitlines()[-LOG_LINES:]
            os.write(kept[1], "\n".join(["Blender said last:", *said, ""]).encode())
            raise


# --- the command line ------------------------------------------------------------------------


def whole_number(most: int) -> Callable[[str], int]:
    """The type of an argument from 1 to `most`."""

    def read(text: str) -> int:
        number = int(text)
        if not 1 <= number <= most:
            raise ValueError
        return number

    read.__name__ = f"whole number from 1 to {most}"  # argparse names the type in its message
    return read


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--samples", type=whole_number(MOST_SAMPLES), metavar="N",
        help=f"samples per pixel ({STUDIO_SAMPLES})",
    )  # fmt: skip
    parser.add_argument(
        "--width", type=whole_number(MOST_PIXELS), metavar="W",
        help=f"of the picture, pixels ({STUDIO_SIZE[0]})",
    )  # fmt: skip


def load_paint(name: str) -> Paint:
    try:
        return presets.load(name)
    except presets.PresetError as error:
        raise RenderError(str(error)) from error


def check_outputs(pictures: Sequence[Path]) -> None:
    """Finds out before the work whether the files can be written."""
    for file in pictures:
        if file.suffix.lower() not in SUFFIXES:
            raise RenderError(f"{file}: a picture's name ends in {' or '.join(SUFFIXES)}.")
        if why := files.obstacle(file):
            raise RenderError(f"{file} cannot be written: {why}.")
        if file.is_dir():
            raise RenderError(f"{file} cannot be written: it is a folder.")


# --- the picture -----------------------------------------------------------------------------


def set_up(
    scene: bpy.types.Scene, samples: int | None, width: int | None, height: int | None
) -> None:
    """Cycles with OSL, and nothing that takes sparkles for noise: no denoising, no clamping.

    Of width and height, one that is not given follows from the other; what neither gives stays the
    scene's own. The picture is what Cycles renders: compositing might write files elsewhere.
    """
    material.set_up_cycles(scene)
    cycles, render = scene.cycles, scene.render
    cycles.samples = samples or cycles.samples
    cycles.use_denoising = False
    cycles.sample_clamp_direct = 0
    cycles.time_limit = 0
    if width or height:
        aspect = render.resolution_x / render.resolution_y
        render.resolution_x = width or max(1, round(height * aspect))
        render.resolution_y = height or max(1, round(width / aspect))
        render.resolution_percentage = 100
    render.use_border = render.use_multiview = False
    render.use_compositing = render.use_sequencer = False
    w, h = size(scene)
    cycles.use_auto_tile = True
    cycles.tile_size = min(max(8 * math.ceil(math.sqrt(w * h / TILES) / 8), 64), 2048)


def set_up_studio(scene: bpy.types.Scene) -> None:
    """What the studio needs of Cycles, and no more: it is to be quick."""
    scene.render.resolution_x, scene.render.resolution_y = STUDIO_SIZE
    scene.render.resolution_percentage = 100
    scene.cycles.samples = STUDIO_SAMPLES
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.max_bounces = 4
    scene.cycles.sample_clamp_indirect = 1  # sparkles that the floor mirrors would be fireflies
    scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = False
    scene.view_settings.view_transform = VIEW_TRANSFORM
    scene.view_settings.look = LOOK


def denoise_all_but_sparkles(scene: bpy.types.Scene) -> None:
    """As the add-on's button does. The scene has no compositing of its own."""
    denoise.set_up(scene)


def size(scene: bpy.types.Scene) -> tuple[int, int]:
    render = scene.render
    w, h = (max(1, int(pixels * render.resolution_percentage / 100))
            for pixels in (render.resolution_x, render.resolution_y))  # fmt: skip
    return w, h


def paint_objects(things: Sequence[bpy.types.Object], paint: Paint) -> None:
    try:
        painted = material.create(paint)
        for thing in things:
            material.assign(thing, painted)
    except ValueError as error:
        raise RenderError(str(error)) from error
    painted.pass_index = PAINT_INDEX


def rendered(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The objects that a render shows, each once."""
    layers = [layer for layer in scene.view_layers if layer.use]
    return list(dict.fromkeys(thing for layer in layers for thing in placed.rendered(layer)))


def render(scene: bpy.types.Scene, pictures: Sequence[Path], preset: str) -> None:
    """Renders into the files, and says what they show."""
    start = time.monotonic()
    with _progress(", then denoising…" if scene.render.use_compositing else ""):
        report = take(scene)
    seconds = time.monotonic() - start
    _write(scene, pictures)
    for file in pictures:
        say(f"{file} ({_describe(file, scene)})")
    w, h = size(scene)
    say(f"{preset}, {w} × {h} pixels, {scene.cycles.samples} samples, {seconds:.0f} s")
    say(str(report))


def take(scene: bpy.types.Scene) -> needs.Needs:
    """Renders, and says nothing; save() has the picture."""
    report = needs.fit(scene)
    for layer in scene.view_layers:
        layer.use_pass_material_index = True
    bpy.ops.render.render(scene=scene.name)
    _check_paint(scene)
    return report


def _write(scene: bpy.types.Scene, pictures: Sequence[Path]) -> None:
    try:
        with contextlib.ExitStack() as stack:
            for picture in pictures:
                save(scene, stack.enter_context(files.whole(picture)))
    except OSError as error:
        names = " and ".join(map(str, pictures))
        raise RenderError(f"{names} cannot be written: {error.strerror}.") from error


def _describe(file: Path, scene: bpy.types.Scene) -> str:
    if _is_exr(file):
        return "32 bit, linear"
    return f"8 bit, view transform {scene.view_settings.view_transform}"


def _is_exr(file: Path) -> bool:
    return file.suffix.lower() == ".exr"


@contextlib.contextmanager
def _progress(at_end: str) -> Iterator[None]:
    """Tells how far the render is: on a terminal in one line, else a line each tenth."""
    start = time.monotonic()
    live = _console.isatty()
    told = -1

    def tell(stats: str, _: object = None) -> None:
        nonlocal told
        done = _share_done(stats)
        percent = int(100 * done)
        if percent <= told if live else percent // 10 <= told // 10:
            return
        told = percent
        elapsed = time.monotonic() - start
        line = f"{percent:3} %, {elapsed:.0f} s"
        if 0 < done < 1:
            line += f", {elapsed / done - elapsed:.0f} s remain"
        elif done == 1:
            line += at_end
        _console.write(f"\r{line:<40}" if live else f"{line}\n")
        _console.flush()

    handlers = bpy.app.handlers.render_stats
    handlers.append(tell)
    try:
        yield
    finally:
        handlers.remove(tell)  # else bpy 4.5 hangs when it ends
        if live:
            _console.write("\n")


def _share_done(stats: str) -> float:
    tiles = re.search(r"Rendered (\d+)/(\d+) Tiles", stats)
    samples = re.search(r"Sample (\d+)/(\d+)", stats)
    within = int(samples[1]) / int(samples[2]) if samples else 0.0
    return (int(tiles[1]) + within) / int(tiles[2]) if tiles else within


def _check_paint(scene: bpy.types.Scene) -> None:
    """Cycles renders a shader that fails as black, without a word."""
    file = Path(bpy.app.tempdir) / "passes.exr"
    save(scene, file, layers=True)
    color, index = _passes(file)
    shown = index == PAINT_INDEX
    if not shown.any():
        say("Note: the camera sees none of the paint.")
    elif not color[shown].any():
        raise RenderError(
            "All the paint in the picture is black: no light reaches it, or its shader failed."
        )


def _passes(file: Path) -> tuple[np.ndarray, np.ndarray]:
    """Colour (n, 3) and material index (n) of the pixels of all view layers."""
    channels: dict[str, np.ndarray] = {}
    for part in range(OpenImageIO.ImageBuf(str(file)).nsubimages):
        image = OpenImageIO.ImageBuf(str(file), part, 0)
        pixels = image.get_pixels(OpenImageIO.FLOAT)
        for name, values in zip(image.spec().channelnames, np.moveaxis(pixels, -1, 0), strict=True):
            channels[name] = values.ravel()
    colors, indices = [], []
    for name, index in channels.items():
        layer, _, passed = name.removesuffix(".X").rpartition(".")
        if passed in INDEX_PASSES:
            colors.append(np.stack([channels[f"{layer}.Combined.{c}"] for c in "RGB"], axis=-1))
            indices.append(index)
    return np.concatenate(colors), np.concatenate(indices)


def save(scene: bpy.types.Scene, file: Path, *, layers: bool = False) -> None:
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):  # Blender 5
        settings.media_type = "MULTI_LAYER_IMAGE" if layers else "IMAGE"
    if _is_exr(file):
        settings.file_format = "OPEN_EXR_MULTILAYER" if layers else "OPEN_EXR"
        settings.color_depth, settings.exr_codec = "32", "ZIP"
    else:
        settings.file_format, settings.color_depth = "PNG", "8"
    has_alpha = _is_exr(file) or scene.render.film_transparent
    settings.color_mode = "RGBA" if has_alpha else "RGB"
    try:
        bpy.data.images["Render Result"].save_render(str(file), scene=scene)
    except RuntimeError as error:
        raise RenderError(f"{file} cannot be written: {error}") from error
