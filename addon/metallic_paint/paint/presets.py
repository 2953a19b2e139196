# SPDX-License-Identifier: GPL-3.0-or-later
"""Paints as JSON files: those that ship in presets/, and anyone's.

A file is an object with "schema_version": 1, an optional "description", and "paint": an object
with the fields of Paint, units and ranges as there; "second" and "third" in it are objects with
the fields of Flakes. A field that is left out has its default.
Files are read strictly, since they come from anywhere. Nothing here needs Blender.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NoReturn

from .parameters import NO_FLAKES, Color, Flakes, Paint, PaintError, shown

__all__ = ["Color", "Flakes", "Paint", "PaintError", "PresetError", "load", "names", "save"]

SCHEMA_VERSION = 1
MAX_BYTES = 64 * 1024
FOLDER = Path(__file__).parent / "presets"

_KEYS = ("schema_version", "description", "paint")
_SPECIES = ("second", "third")


class PresetError(ValueError):
    """A preset that cannot be read, said in a sentence with file and key."""


class _NotStrictError(ValueError):
    """JSON that Python would take and we do not."""


def names() -> list[str]:
    """The presets that ship with the add-on."""
    return sorted(path.stem for path in FOLDER.glob("*.json"))


def load(name_or_path: str | os.PathLike[str]) -> Paint:
    """The paint of a shipped preset, or of a file."""
    if name_or_path in names():
        return _read(FOLDER / f"{name_or_path}.json")
    path = Path(name_or_path)
    try:
        is_file = path.is_file()
    except OSError as error:  # a name too long, a folder closed to us
        raise PresetError(f"{shown(str(path))} cannot be read: {error.strerror}.") from error
    if not is_file:
        raise PresetError(
            f"{os.fspath(name_or_path)!r} is neither a file nor a preset; "
            f"the presets are {', '.join(names())}."
        )
    return _read(path)


def save(paint: Paint, path: str | os.PathLike[str], description: str = "") -> None:
    """Writes the file whole or not at all."""
    content: dict[str, Any] = {"schema_version": SCHEMA_VERSION}
    if description:
        content["description"] = description
    content["paint"] = dataclasses.asdict(paint)
    for name in _SPECIES:
        if getattr(paint, name) == NO_FLAKES:
            del content["paint"][name]
    path = Path(path)
    unfinished = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        unfinished.write_text(_text(content), encoding="utf-8")
        unfinished.replace(path)
    finally:
        with contextlib.suppress(FileNotFoundError):
            unfinished.unlink()


def _text(content: dict[str, Any]) -> str:
    """One line for each field, colours included, so that presets compare line by line."""
    lines = []
    for key, value in content["paint"].items():
        text = json.dumps(value)
        if isinstance(value, dict):
            inner = ",\n".join(f"      {json.dumps(k)}: {json.dumps(v)}" for k, v in value.items())
            text = "{\n" + inner + "\n    }"
        lines.append(f"    {json.dumps(key)}: {text}")
    head = "".join(
        f"  {json.dumps(key)}: {json.dumps(value, ensure_ascii=False)},\n"
        for key, value in content.items()
        if key != "paint"
    )
    return "{\n" + head + '  "paint": {\n' + ",\n".join(lines) + "\n  }\n}\n"


def _read(path: Path) -> Paint:
    content = _parse(path)
    if not isinstance(content, dict):
        raise PresetError(f"{path}: the file must hold an object {{...}}.")
    _check_keys(path, "", content, _KEYS)
    version = content.get("schema_version")
    if type(version) is not int or version != SCHEMA_VERSION:
        raise PresetError(
            f"{path}: schema_version is {shown(version)} and must be {SCHEMA_VERSION}, the only "
            "one that this add-on knows."
        )
    if not isinstance(content.get("description", ""), str):
        raise PresetError(f"{path}: description must be a text.")
    paint = content.get("paint")
    if not isinstance(paint, dict):
        raise PresetError(f"{path}: paint is missing or no object {{...}}.")
    fields = dict(paint)
    for name in _SPECIES:
        if name in paint:
            if not isinstance(paint[name], dict):
                raise PresetError(f"{path}: paint.{name} is no object {{...}}.")
            fields[name] = _build(path, f"paint.{name}.", Flakes, paint[name])
    return _build(path, "paint.", Paint, fields)


def _build(path: Path, where: str, kind: type[Flakes], values: dict[str, Any]) -> Any:  # noqa: ANN401
    _check_keys(path, where, values, [field.name for field in dataclasses.fields(kind)])
    try:
        return kind(**values)
    except PaintError as error:
        raise PresetError(f"{path}: {where}{error}") from error


def _parse(path: Path) -> object:
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise PresetError(f"{path} cannot be read: {error.strerror}.") from error
    if len(data) > MAX_BYTES:
        raise PresetError(f"{path} is larger than {MAX_BYTES} bytes, the limit for a preset.")
    try:
        return json.loads(
            data.decode("utf-8"), parse_constant=_reject_constant, object_pairs_hook=_unique
        )
    except _NotStrictError as error:
        raise PresetError(f"{path}: {error}") from error
    except (ValueError, RecursionError) as error:  # also bad UTF-8 and numbers of 5000 digits
        raise PresetError(f"{path} is no JSON: {error}.") from error


def _reject_constant(word: str) -> NoReturn:
    raise _NotStrictError(f"{word} is no number that a paint can have.")


def _unique(pairs: list[tuple[str, object]]) -> dict[str, object]:
    content: dict[str, object] = {}
    for key, value in pairs:
        if key in content:
            raise _NotStrictError(f"the key {shown(key)} stands there twice.")
        content[key] = value
    return content


def _check_keys(path: Path, where: str, content: dict[str, Any], known: Iterable[str]) -> None:
    for key in content:
        if key not in known:
            raise PresetError(
                f"{path}: {shown(where + key)} is no key of a preset; "
                f"the keys are {', '.join(known)}."
            )
