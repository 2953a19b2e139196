# SPDX-License-Identifier: Apache-2.0
"""How every program of ours that imports bpy begins and ends: prepare(), import bpy, finish()."""

from __future__ import annotations

import importlib.util
import os
import shutil
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from common.processes import is_outermost, stop_signals

_scratch: list[Path] = []


def prepare() -> None:
    """Gives Blender empty user settings, and Python Blender's own packages, and imports bpy.

    The bpy module, unlike the program, does not put its OpenImageIO and oslquery on sys.path, and
    without oslquery no script node compiles. Call this before anything imports bpy.
    """
    spec = importlib.util.find_spec("bpy")
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError("This Python has no bpy: run ./paint, which finds the right one.")
    packages = sorted(Path(spec.origin).parent.glob("*/python/lib/python3*/site-packages"))
    sys.path[:0] = map(str, packages)

    # Ctrl-C within the import is lost, or bpy crashes: it has to wait, and so it has from where
    # there is a folder to remove.
    signal.pthread_sigmask(signal.SIG_BLOCK, stop_signals())
    user = Path(tempfile.mkdtemp(prefix="metallic-paint-"))
    os.environ["BLENDER_USER_RESOURCES"] = str(user)
    _scratch.append(user)
    importlib.import_module("bpy")
    if came := signal.sigpending() & set(stop_signals()):
        if is_outermost():
            print("\nInterrupted.", file=sys.stderr)
        finish(128 + min(came))
    signal.pthread_sigmask(signal.SIG_UNBLOCK, stop_signals())


def run(main: Callable[[], int]) -> NoReturn:
    """Ends with main's code, or with 3 for a bug of ours."""
    try:
        code = main()
    except Exception:
        traceback.print_exc()
        code = 3
    finish(code)


def finish(code: int) -> NoReturn:
    """Ends the process at once: an ordinary exit can hang in bpy 4.5, and lose the exit code."""
    sys.stdout.flush()
    sys.stderr.flush()
    if bpy := sys.modules.get("bpy"):
        _scratch.append(Path(bpy.app.tempdir))
    for folder in _scratch:
        shutil.rmtree(folder, ignore_errors=True)
    os._exit(code)
