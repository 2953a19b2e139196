# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks a small region of the artist's own scene against the core, in another process.

The other Blender opens a copy of the file, in which check.py does its work. Here the scene stays as
it is, and the interface alive.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np

from ..native import core_missing
from ..paint import PaintError, material, shader
from .check import Found, VerifyError, as_found

SIZE = 96  # pixels along each side of the region
PICTURES = ("Cycles", "Core", "Difference × 100")
SECONDS = 0.2  # between looks at the other process


def why_not(scene: bpy.types.Scene, thing: bpy.types.Object | None) -> str:
    """What keeps the scene from being checked, in a sentence; quick enough for a panel."""
    if missing := core_missing():
        return f"{missing} The paint works without it"
    if scene.camera is None:
        return "The scene has no camera"
    painted = painted_of(thing)
    if painted is None:
        return "Select an object with a metallic paint"
    if file := material.linked_from(material.paint_node(painted)):
        return f"The paint is linked from {file} and keeps its lights: check it in that file"
    return ""


def _unlike_core(painted: bpy.types.Material) -> str:
    """Why the core cannot have this paint, in a sentence; too slow for a panel."""
    tree = material.paint_node(painted).node_tree
    if not material.is_current(tree, material.digest(shader.source())):
        return f"The paint of “{painted.name}” is of an older version: update it first"
    try:
        material.paint_of(painted)
    except PaintError as error:
        return str(error).rstrip(".")
    return ""


def painted_of(thing: bpy.types.Object | None) -> bpy.types.Material | None:
    """The object's active material if it is a paint, or else its first paint."""
    slots = (
        []
        if thing is None
        else [thing.active_material, *(s.material for s in thing.material_slots)]
    )
    return next((each for each in slots if each is not None and material.has_paint(each)), None)


class Job:
    """The other process, and what it has said. close() ends it and removes its files."""

    def __init__(self, scene: bpy.types.Scene, thing: bpy.types.Object, size: int = SIZE) -> None:
        if reason := why_not(scene, thing) or _unlike_core(painted_of(thing)):
            raise VerifyError(f"{reason}.")
        self.progress, self.what = 0.0, "Starting Blender"
        self.found: Found | None = None
        self.folder = Path(tempfile.mkdtemp(prefix="metallic-paint-"))
        self._log = (self.folder / "log").open("wb")
        try:
            blend = self.folder / "scene.blend"
            _save_copy(blend)
            job = {
                "modules": _modules(), "blend": str(blend), "folder": str(self.folder),
                "scene": scene.name_full, "object": thing.name_full,
                "material": painted_of(thing).name_full, "size": size,
            }  # fmt: skip
            file = self.folder / "job.json"
            file.write_text(json.dumps(job), encoding="utf-8")
            self._process = subprocess.Popen(
                [*_blender(), str(file)], stdin=subprocess.DEVNULL, stdout=self._log,
                stderr=subprocess.STDOUT,
            )  # fmt: skip
        except BaseException:
            self._log.close()
            shutil.rmtree(self.folder, ignore_errors=True)
            raise

    def poll(self) -> bool:
        """Whether it has ended; progress, what and found tell the rest.

        Raises VerifyError if it failed.
        """
        ended = self._process.poll() is not None
        said = self.folder / "said.jsonl"
        text = said.read_text(encoding="utf-8") if said.exists() else ""
        lines = [json.loads(line) for line in text.splitlines(keepends=True) if line[-1] == "\n"]
        for line in lines:
            if "error" in line:
                raise VerifyError(line["error"])
            if "found" in line:
                self.found = as_found(line["found"])
            self.progress = line.get("progress", self.progress)
            self.what = line.get("what", self.what)
        if ended and self.found is None:
            log = (self.folder / "log").read_text(encoding="utf-8", errors="replace")
            print(log, file=sys.stderr)
            last = " ".join(log.splitlines()[-3:]) or "without a word"
            raise VerifyError(f"The other Blender ended: {last} (The console has all it said.)")
        return ended

    def pictures(self) -> list[bpy.types.Image]:
        """Its three pictures as images of this file, in place of those of an earlier check.

        Raises VerifyError where their file is not whole, as on a full disk.
        """
        try:
            arrays = np.load(self.folder / "pictures.npy")
        except (OSError, ValueError, EOFError) as error:
            raise VerifyError(f"The pictures of the check cannot be read: {error}.") from error
        return [
            _image(f"Metallic Paint {name}", array)
            for name, array in zip(PICTURES, arrays, strict=True)
        ]

    def close(self) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        self._log.close()
        shutil.rmtree(self.folder, ignore_errors=True)


def run(scene: bpy.types.Scene, thing: bpy.types.Object, size: int = SIZE) -> Found:
    """Checks the region of size x size pixels where the object sparkles most, and waits for it.

    Its pictures become images of the file. Raises VerifyError, in a sentence, where that cannot be.
    """
    job = Job(scene, thing, size)
    try:
        while not job.poll():
            time.sleep(SECONDS)
        job.pictures()
        return job.found
    finally:
        job.close()


def _save_copy(file: Path) -> None:
    """Raises VerifyError where Blender cannot write it."""
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(file), copy=True, compress=False)
    except RuntimeError as error:  # all that an operator raises
        raise VerifyError(f"The scene cannot be copied for the check: {error}") from error


def _blender() -> list[str]:
    """What runs process.py: this Blender, or the Python that has it as a module."""
    script = str(Path(__file__).with_name("process.py"))
    if bpy.app.binary_path:
        return [bpy.app.binary_path, "--background", "--factory-startup", "--python", script, "--"]
    return [sys.executable, script]


def _modules() -> dict[str, str]:
    """Where the other process finds what it imports, under the names it knows them by."""
    import metallic_paint_core
    import OpenImageIO
    import oslquery

    modules = (metallic_paint_core, OpenImageIO, oslquery)  # Cycles needs the last to compile
    found = {module.__name__: module.__file__ for module in modules}
    return {**found, "metallic_paint": str(Path(__file__).parent.with_name("__init__.py"))}


def _image(name: str, array: np.ndarray) -> bpy.types.Image:
    """Linear light (h, w, 3), row 0 at the bottom."""
    h, w, _ = array.shape
    image: bpy.types.Image | None = bpy.data.images.get(name)
    if image is None or tuple(image.size) != (w, h) or not image.is_float:
        if image is not None:
            bpy.data.images.remove(image)
        image = bpy.data.images.new(name, w, h, float_buffer=True)
    image.pixels.foreach_set(np.dstack([array, np.ones((h, w, 1))]).astype(np.float32).ravel())
    image.update()
    image.pack()
    return image
