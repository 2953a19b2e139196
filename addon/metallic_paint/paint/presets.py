# SPDX-License-Identifier: GPL-3.0-or-later
"""Paints as JSON files: those that ship in presets/, and anyone's.

A file is an object with "schema_version": 2, "defaults": a number, an optional "description", and
"paint": an object with the fields of Paint, units and ranges as there; "second" and "third" in it
are objects with the fields of Flakes, and no flakes where they are left out. Any other field that
is left out has its default, as it was in the version "defaults" of the defaults: a preset keeps its
look when a default changes or a parameter comes. "schema_version": 1 stands for version 1 of them.
Files are read strictly, since they come from anywhere. Nothing here needs Blender.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from . import table
from .parameters import Color, Flakes, Paint, PaintError, shown

__all__ = ["Color", "Flakes", "Paint", "PaintError", "PresetError", "load", "names", "save"]

SCHEMA_VERSION = 2
MAX_BYTES = 64 * 1024
FOLDER = Path(__file__).parent / "presets"

_KEYS = {1: ("schema_version", "description", "paint"),
         2: ("schema_version", "defaults", "description", "paint")}  # fmt: skip
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
    """Writes the file whole or not at all, through a symbolic link into the file it names.

    Raises PresetError for what load would refuse, OSError where nothing can be written.
    """
    content: dict[str, Any] = {"schema_version": SCHEMA_VERSION}
    content["defaults"] = table.VERSION_OF_DEFAULTS
    if description:
        content["description"] = description
    content["paint"] = _differences(paint)
    data = _text(content).encode("utf-8")
    path = Path(os.path.realpath(path))
    if len(data) > MAX_BYTES:
        raise PresetError(
            f"{path}: description has {len(description)} characters, but a preset must be of at "
            f"most {MAX_BYTES} bytes."
        )
    unfinished = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        unfinished.write_bytes(data)
        unfinished.replace(path)
    finally:
        with contextlib.suppress(FileNotFoundError):
            unfinished.unlink()


def _differences(flakes: Flakes) -> dict[str, Any]:
    """The fields in which flakes, or a paint, differ from the defaults."""
    found: dict[str, Any] = {}
    for field in dataclasses.fields(flakes):
        value = getattr(flakes, field.name)
        if value != field.default:
            found[field.name] = _differences(value) if isinstance(value, Flakes) else value
    return found


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
    schema = content.get("schema_version")
    if type(schema) is not int or schema not in _KEYS:
        raise PresetError(
            f"{path}: schema_version is {shown(schema)}, but must be 1 or {SCHEMA_VERSION}: this "
            "add-on knows no other."
        )
    _check_keys(path, "", content, _KEYS[schema])
    version = content.get("defaults") if schema > 1 else 1
    if type(version) is not int or not 1 <= version <= table.VERSION_OF_DEFAULTS:
        raise PresetError(
            f"{path}: defaults is {shown(version)}, but must be from 1 to "
            f"{table.VERSION_OF_DEFAULTS}: this add-on knows no other."
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
                raise PresetError(
                    f"{path}: paint.{name} is {shown(paint[name])}, but must be an object {{...}}."
                )
            fields[name] = _build(path, f"paint.{name}.", Flakes, paint[name], version)
    return _build(path, "paint.", Paint, fields, version)


def _build(path: Path, where: str, kind: type[Flakes], values: dict[str, Any], version: int) -> Any:  # noqa: ANN401
    known = [field.name for field in dataclasses.fields(kind)]
    _check_keys(path, where, values, known)
    former = {name: default for name, default in _defaults_of(version).items() if name in known}
    try:
        return kind(**(former | values))
    except PaintError as error:
        raise PresetError(f"{path}: {where}{error}") from error


def _defaults_of(version: int) -> dict[str, Any]:
    """Those defaults of that version that are others today."""
    return {
        name: next(default for through, default in changes if through >= version)
        for name, changes in table.FORMER_DEFAULTS.items()
        if changes[-1][0] >= version
    }


def _parse(path: Path) -> object:
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise PresetError(f"{path} cannot be read: {error.strerror}.") from error
    if len(data) > MAX_BYTES:
        raise PresetError(f"{path} is larger than {MAX_BYTES} bytes, the limit for a preset.")
    try:
        return json.loads(data.decode("utf-8-sig"), parse_int=_whole, object_pairs_hook=_unique)
    except _NotStrictError as error:
        raise PresetError(f"{path}: {error}") from error
    except (ValueError, RecursionError) as error:  # also bad UTF-8
        raise PresetError(f"{path} is no JSON: {error}.") from error


def _whole(word: str) -> float:
    """Python makes an integer of no more than 4300 digits; no field may have such a value."""
    return int(word) if len(word) < 1000 else float(word)


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
