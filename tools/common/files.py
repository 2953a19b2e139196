# SPDX-License-Identifier: Apache-2.0
"""Output is written whole or not at all: neither a part of it nor a folder made for it is left."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path

_numbers = count()
_unfinished: dict[Path, list[Path]] = {}  # with the folders made for each, innermost first


def obstacle(path: Path) -> str:
    """Why nothing can be written there, found out before minutes of work; it makes nothing."""
    try:
        if path.is_symlink():
            path = Path(os.path.realpath(path))
        if os.path.lexists(path) and not (path.is_file() or path.is_dir()):
            return "neither a file nor a folder"
        if Path.cwd().is_relative_to(os.path.realpath(path)):
            return "the current folder lies there"
        there = next(folder for folder in path.absolute().parents if os.path.lexists(folder))
    except OSError as error:  # a folder closed to us
        return os.strerror(error.errno)
    if not there.is_dir():
        return os.strerror(errno.ENOTDIR)
    if len(os.fsencode(path.name)) > os.pathconf(there, "PC_NAME_MAX"):
        return os.strerror(errno.ENAMETOOLONG)
    needed = [(there, os.W_OK | os.X_OK)]
    if path.is_dir():
        needed.append((path, os.R_OK | os.W_OK | os.X_OK))
    return "" if all(os.access(*each) for each in needed) else os.strerror(errno.EACCES)


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A path beside it for a new file or folder, which takes its place if the block ends well.

    A symbolic link stays one: what it names is written.
    """
    # A picture's form is chosen by its suffix; long names have no room for more.
    suffix = path.suffix[:8]
    path = Path(os.path.realpath(path))
    beside = path.with_name(f".{os.getpid()}-{next(_numbers)}{suffix}")
    _unfinished[beside] = [folder for folder in path.parents if not folder.exists()]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield beside
        if path.is_dir() and beside.is_dir():  # only an empty one would give way
            earlier = beside.with_suffix(".earlier")
            path.rename(earlier)
            beside.rename(path)
            shutil.rmtree(earlier)
        else:
            beside.replace(path)
    except BaseException:
        _remove(beside)
        raise
    del _unfinished[beside]


def write(path: Path, text: str) -> None:
    with whole(path) as beside:
        beside.write_text(text, encoding="utf-8")


def remove_unfinished() -> None:
    """What a program that ends at once calls; else whole() does."""
    for beside in list(_unfinished):
        _remove(beside)


def _remove(beside: Path) -> None:
    with suppress(OSError):
        if beside.is_dir():
            shutil.rmtree(beside, ignore_errors=True)
        else:
            beside.unlink()
    with suppress(OSError):  # a folder that holds something else by now stays
        for folder in _unfinished.pop(beside):
            folder.rmdir()
