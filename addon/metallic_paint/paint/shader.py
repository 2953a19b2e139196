# SPDX-License-Identifier: GPL-3.0-or-later
"""The shader's OSL text as one piece, and its compilation into a script node."""

from __future__ import annotations

import os
import re
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import bpy

_PACKAGE = Path(__file__).resolve().parent.parent
FOLDERS = (_PACKAGE / "osl", _PACKAGE.parent.parent / "osl")  # installed; in the repository
FILE = "metallic_paint.osl"
LIBRARY = _PACKAGE / "assets" / "metallic_paint.blend"  # the presets as assets; in the zip alone
DIGEST = ".sha256"  # the suffix of a file beside it: material.digest of the shader in it

_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+"([^"]+)"[^\n]*$', re.MULTILINE)
# Each header goes in once as it is; in a text of one piece the pragma crashes Blender's oslc.
_ONCE = re.compile(r"^[ \t]*#[ \t]*pragma[ \t]+once[ \t]*\n", re.MULTILINE)
_COMPILERS_OWN = ("stdosl.h", "stdcycles.h")


class CompileError(RuntimeError):
    """A text that is no shader, with what the compiler said."""


def source(diagnostics: bool = False) -> str:
    """The OSL source with its includes inside: a script node in a .blend finds no files.

    With diagnostics, the variant that can show inner values instead of the paint.
    """
    for folder in FOLDERS:
        if (folder / FILE).is_file():
            text = flatten(folder / FILE)
            return f"#define DIAGNOSTICS 1\n{text}" if diagnostics else text
    raise FileNotFoundError(f"{FILE} is in none of {', '.join(map(str, FOLDERS))}.")


def flatten(path: Path) -> str:
    """The file with every header (.h) at its first mention, and every table (.inc) at each one."""
    return _flatten(path.resolve(), set(), ())


def _flatten(path: Path, seen: set[Path], within: tuple[Path, ...]) -> str:
    if path in within:
        raise ValueError(f"{path} includes itself.")

    def included(match: re.Match[str]) -> str:
        name = match[1]
        if name in _COMPILERS_OWN:
            return match[0]
        file = (path.parent / name).resolve()
        if file in seen:
            return ""
        if not file.is_file():
            raise FileNotFoundError(f"{path} includes {name!r}, and there is no {file}.")
        if file.suffix == ".h":
            seen.add(file)
        return _flatten(file, seen, (*within, path)).rstrip("\n")

    return _INCLUDE.sub(included, _ONCE.sub("", path.read_text(encoding="utf-8")))


def compile_into(node: bpy.types.ShaderNodeScript, text: bpy.types.Text) -> None:
    """Compiles the text into the node, bytecode inside.

    Blender itself does not tell a failure: the node would render black. Raises CompileError with
    what the compiler said.
    """
    node.mode = "INTERNAL"
    with _cycles_scene():
        node.script = text
        if not node.bytecode or not node.outputs:
            said = _compilers_words(text.as_string()) or "the compiler said nothing"
            raise CompileError(f"{text.name} does not compile as OSL: {said}")


def _compilers_words(source: str) -> str:
    """Of a text that does not compile: what oslc says when it is asked once more.

    oslc is a library within Blender, which writes to the process's standard output and error and
    nowhere else. So for this one call, both lead into a file. Where the text compiles, as it does
    unless Blender is broken, nothing is redirected.
    """
    import _cycles

    with tempfile.TemporaryFile() as said, tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / FILE
        file.write_text(source, encoding="utf-8")
        with _output_into(said):
            _cycles.osl_compile(str(file), f"{file}.oso")
        said.seek(0)
        return said.read().decode(errors="replace").strip()


@contextmanager
def _cycles_scene() -> Iterator[None]:
    """Lends the context a scene that renders with Cycles: in any other, scripts do not compile."""
    scene = bpy.data.scenes.new("Compiling")
    try:
        scene.render.engine = "CYCLES"
        with bpy.context.temp_override(scene=scene):
            yield
    finally:
        bpy.data.scenes.remove(scene)


@contextmanager
def _output_into(file: IO[bytes]) -> Iterator[None]:
    """Sends what the process writes into a file."""
    streams = [stream for stream in (sys.stdout, sys.stderr) if stream is not None]
    try:
        kept = [(fd, os.dup(fd)) for fd in (1, 2)]
    except OSError:  # a program without a console: nobody hears the compiler
        yield
        return
    try:
        for stream in streams:
            stream.flush()
        for fd, _ in kept:
            os.dup2(file.fileno(), fd)
        yield
    finally:
        for stream in streams:
            stream.flush()
        for fd, copy in kept:
            os.dup2(copy, fd)
            os.close(copy)
