# SPDX-License-Identifier: Apache-2.0
"""Fuzzes the reading of presets, which come from anywhere: a file is a paint or a PresetError.

Takes libFuzzer's options; without any it runs until it is stopped or finds something. What fails
is kept in build/fuzz/; give that file as the argument to see it fail again.
"""

from __future__ import annotations

import dataclasses
import json
import os
import random
import shutil
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import atheris

ROOT = Path(__file__).resolve().parent.parent.parent
FOUND = ROOT / "build" / "fuzz"

sys.path.insert(0, str(ROOT / "addon"))
with atheris.instrument_imports(include=["metallic_paint"]):
    from metallic_paint.paint import presets

LONGEST_SENTENCE = 1000  # characters: fits a console or a pop-up; no file may flood either

# What no field takes, or only just: as JSON text, since no Python value becomes some of these.
VALUES = (
    "null", "true", "false", "0", "-0.0", "1", "-1", "2", "0.5", "1e-999", "1e999", "-1e999",
    "NaN", "Infinity", "-Infinity", "1e308", "5e-324", "0.1", "1e-6", "9.9e-7", "100", "1e9",
    "2147483647", "2147483648", "-2147483649", "9" * 400, "9" * 4300, "9" * 4301, "0." + "9" * 5000,
    '""', '"ggx"', '"gaussian"', '"thinned"', '"published"', '"\\ud800"', '"\\u0000"',
    '"\\u001b[2J"', '"\\ud83d\\ude00"', "[]", "{}", "[0,0,0]", "[1,1,1]", "[0,0]", "[0,0,0,0]",
    "[0,0,NaN]", "[[0],0,0]", '["a",0,0]', '{"0":0,"1":0,"2":0}', "[" * 200 + "]" * 200,
)  # fmt: skip
KEYS = (
    "schema_version",
    "defaults",
    "description",
    "paint",
    "",
    "a",
    "\ud800",
    "\0",
    "\x1b[2J",
    "k" * 5000,
)


FIELDS = [field.name for field in dataclasses.fields(presets.Paint)]
TABLE = tomllib.loads((ROOT / "parameters.toml").read_text(encoding="utf-8"))
FORMER = {
    name: parameter.get("former", ())
    for part in ("flakes", "paint")
    for name, parameter in TABLE[part].items()
}


def seeds() -> Iterator[bytes]:
    for name in presets.names():
        yield (presets.FOLDER / f"{name}.json").read_bytes()
    least = b'{"schema_version": 1, "paint": {%s}}'
    yield b"\xef\xbb\xbf" + least % b""
    yield (least % b"").decode().encode("utf-16")
    yield least % b'"tilt": 0.1, "tilt": 0.1'
    yield (least % b"").ljust(presets.MAX_BYTES)
    yield (least % b"").ljust(presets.MAX_BYTES + 1)
    yield b'{"schema_version": 2, "defaults": 1, "paint": {"tilt": 0.1, "second": {}}}'
    yield least % b'"second": {"tilt": 0.1}, "third": {"flakes_per_mm2": 5}'
    for depth in (100, *range(900, 1001, 10), 10000):  # Python's recursion ends at 1000
        for where in (
            b'"tilt": %s',
            b'"flake_color": [%s, 0, 0]',
            b'"orientation": %s',
            b'"a": %s',
        ):
            yield least % (where % (b"[" * depth + b"]" * depth))
            yield least % (where % (b'{"a":' * depth + b"0" + b"}" * depth))
        yield b'{"schema_version": %s, "paint": {}}' % (b"[" * depth + b"]" * depth)


def mutate(data: bytes, max_size: int, seed: int) -> bytes:
    """Half of the time another value or key in what is JSON: bytes alone rarely leave it so."""
    chance = random.Random(seed)
    if chance.random() < 0.5:
        return atheris.Mutate(data, max_size)
    try:
        content = json.loads(data)
        place = content["paint"] if chance.random() < 0.8 else content
        keys = (*FIELDS, *place) if chance.random() < 0.9 else KEYS
        place[chance.choice(keys)] = "%s"
        text = json.dumps(content).replace('"%s"', chance.choice(VALUES), 1)
    except (ValueError, RecursionError, TypeError, LookupError):
        return atheris.Mutate(data, max_size)
    return text.encode()[:max_size]


_memory = os.memfd_create("preset")  # a file that no disk slows down
FILE = Path(f"/proc/self/fd/{_memory}")


def read(data: bytes) -> None:
    os.ftruncate(_memory, 0)
    os.pwrite(_memory, data, 0)
    try:
        paint = presets.load(FILE)
    except presets.PresetError as error:
        said = str(error).removeprefix(str(FILE))
        assert said.endswith(".")
        assert len(said) <= LONGEST_SENTENCE
        assert said.isprintable()
        return
    content = json.loads(data)
    expect(paint, content["paint"], content.get("defaults", 1))


def expect(made: presets.Flakes, given: dict[str, object], version: int) -> None:
    for field in dataclasses.fields(made):
        value = getattr(made, field.name)
        wanted = given.get(field.name, default_of(field, version))
        if isinstance(wanted, dict):
            expect(value, wanted, version)
        else:
            assert value == (tuple(wanted) if isinstance(wanted, list) else wanted)


def default_of(field: dataclasses.Field, version: int) -> object:
    """As it was in that version of the defaults."""
    for change in FORMER.get(field.name, ()):
        if version <= change["through"]:
            return change["default"]
    return field.default


def main() -> None:
    scratch = FOUND / "scratch"  # libFuzzer ends the process, and leaves nobody to clean up
    shutil.rmtree(scratch, ignore_errors=True)
    corpus = scratch / "corpus"
    corpus.mkdir(parents=True)
    for number, seed in enumerate(seeds()):
        (corpus / f"seed-{number}").write_bytes(seed)
    words = scratch / "words"
    texts = [json.dumps(word) for word in (*FIELDS, *KEYS[:4])]
    words.write_text("".join(f"{json.dumps(word)}\n" for word in texts))
    options = ["-timeout=10", "-rss_limit_mb=1024", f"-max_len={presets.MAX_BYTES + 1024}",
               f"-artifact_prefix={FOUND}/", f"-dict={words}"]  # fmt: skip
    given = sys.argv[1:]
    if all(argument.startswith("-") for argument in given):
        given = [*given, str(corpus)]
    atheris.Setup([sys.argv[0], *options, *given], read, custom_mutator=mutate)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
