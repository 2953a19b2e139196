# SPDX-License-Identifier: Apache-2.0
"""Makes what of the extension is rendered: an asset library of the presets, or their swatches.

The library's folder holds metallic_paint.blend and .sha256, and blender_assets.cats.txt; that of
the swatches PRESET.jpg. The swatches are committed (./paint extension --swatches).
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
from collections.abc import Sequence
from pathlib import Path

from common import blender_env

blender_env.prepare()

import bpy  # noqa: E402
import numpy as np  # noqa: E402
from metallic_paint.interface import operators, preset_operators  # noqa: E402
from metallic_paint.paint import material, presets, shader  # noqa: E402
from pictures import gallery_scenes as scenes  # noqa: E402
from pictures import render_scene  # noqa: E402

PIXELS = 128
SAMPLES = 32
CATALOG = "4f1f5c8e-4c0e-4f0e-9a55-6d2b7a6a1d10"
CATALOGS = f"VERSION 1\n\n{CATALOG}:Metallic Paint:Metallic Paint\n"

# Of the bytecode: which line of which file on this machine each operation comes from; which of its
# arguments it writes, where that is the first alone, as OSL takes it without being told; between
# which operations a variable lives, which OSL finds again itself. Of these hints is more than half
# of the text, which every file with a paint holds.
_HINTS = re.compile(
    r'^#.*\n|[ \t]*%filename\{"[^"\n]*"\}|[ \t]*%line\{\d+\}|[ \t]*%argrw\{"wr*"\}', re.MULTILINE
)
_VARIABLE = re.compile(r"^(?:temp|local|const)\t.*", re.MULTILINE)
_LIFETIME = re.compile(r"[ \t]*%(?:read|write)\{[-\d,]*\}")


def render_swatches(folder: Path, names: Sequence[str]) -> None:
    scene = scenes.empty_scene(PIXELS, PIXELS, SAMPLES)
    scene.render.use_persistent_data = True  # the world is prepared once
    ball = scenes.small_swatch(scene)
    painted = material.create(render_scene.load_paint(names[0]))
    material.assign(ball, painted)
    painted.pass_index = render_scene.PAINT_INDEX
    for name in names:
        material.apply(painted, render_scene.load_paint(name))
        render_scene.take(scene)
        settings = scene.render.image_settings
        if hasattr(settings, "media_type"):  # Blender 5
            settings.media_type = "IMAGE"
        settings.file_format, settings.quality, settings.color_mode = "JPEG", 92, "RGB"
        bpy.data.images["Render Result"].save_render(str(folder / f"{name}.jpg"), scene=scene)
        render_scene.say(f"  {name}")


def write_library(folder: Path) -> None:
    """In a file of their own: the paints know no light of the swatches."""
    folder.mkdir(parents=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    paints = set()
    for name in presets.names():
        content = json.loads((presets.FOLDER / f"{name}.json").read_text(encoding="utf-8"))
        painted = material.create(presets.load(name), operators.title(name))
        painted.asset_mark()
        painted.asset_data.catalog_id = CATALOG
        painted.asset_data.description = content["description"]
        _set_preview(painted, preset_operators.SWATCHES / f"{name}.jpg")
        paints.add(painted)
    _drop_hints(material.node_group().nodes[material.NAME])
    file = folder / "metallic_paint.blend"
    bpy.data.libraries.write(str(file), paints, fake_user=True, compress=True)
    (folder / "blender_assets.cats.txt").write_text(CATALOGS, encoding="utf-8")
    kept = file.with_suffix(shader.DIGEST)
    kept.write_text(material.digest(shader.source()), encoding="ascii")


def _drop_hints(script: bpy.types.ShaderNodeScript) -> None:
    bare = _HINTS.sub("", script.bytecode)
    script.bytecode = _VARIABLE.sub(lambda line: _LIFETIME.sub("", line[0]), bare)
    script.bytecode_hash = hashlib.md5(script.bytecode.encode(), usedforsecurity=False).hexdigest()


def _set_preview(painted: bpy.types.Material, file: Path) -> None:
    picture = bpy.data.images.load(str(file))
    pixels = np.empty(4 * PIXELS * PIXELS, dtype=np.float32)
    picture.pixels.foreach_get(pixels)
    preview = painted.preview_ensure()
    preview.image_size = (PIXELS, PIXELS)
    preview.image_pixels_float.foreach_set(pixels)
    bpy.data.images.remove(picture)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument(
        "--swatches", nargs="*", metavar="PRESET", help="not the library, but all swatches or these"
    )
    asked = parser.parse_args()
    with render_scene.quiet():
        if asked.swatches is None:
            write_library(asked.folder)
        else:
            render_swatches(asked.folder, asked.swatches or presets.names())


if __name__ == "__main__":
    render_scene.run(main)
