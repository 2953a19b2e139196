# SPDX-License-Identifier: Apache-2.0
"""What ./paint demo and ./paint render share: one picture, with progress on the way, whole or not.

Cycles' own lines go into a log that shows only when something breaks; ours go to the console.
Each file is written beside its place and moved there when it is complete.
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
from dataclasses import dataclass
from pathlib import Path
from typing import IO, NoReturn

import blender_env
import bpy
import numpy as np
import OpenImageIO as oiio
from metallic_paint import lights, material, presets
from metallic_paint.paint import Paint

SUFFIXES = (".exr", ".png")
PAINT_INDEX = 31417  # of our material in the index pass, which tells where the picture shows it
STEPS = 12  # tiles of a picture at least: Cycles tells its progress per tile
LOG_LINES = 25


class RenderError(Exception):
    """What hinders the render, said in a sentence to the one who asked for it."""


@dataclass(frozen=True)
class Size:
    width: int
    height: int

    def __str__(self) -> str:
        return f"{self.width} × {self.height} pixels"


# --- the console ---------------------------------------------------------------------------------

_console: IO[str] = sys.stdout
_unfinished: set[Path] = set()


def say(line: str) -> None:
    print(line, file=_console, flush=True)


def run(command: Callable[[], None]) -> NoReturn:
    """Runs a tool to its exit code: 0, 1 after a sentence, 2 for usage, 3 for a bug of ours."""
    _end_at_once_on_signals()
    code = 0
    with tempfile.TemporaryFile() as log:
        try:
            command_line_done = command()  # parses; what follows it returns
            del command_line_done
        except SystemExit as request:  # argparse
            code = request.code if isinstance(request.code, int) else 1
        except RenderError as error:
            print(error, file=sys.stderr)
            code = 1
        except Exception:
            traceback.print_exc()
            code = 3
    blender_env.finish(code)
