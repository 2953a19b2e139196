# SPDX-License-Identifier: Apache-2.0
"""What a long command has found on the sources as they are, so that a run cut short goes on.

Each command has a file in build/kept: first the digest of the sources and what else its findings
hold for, then a line for each finding. Each begins with its line's end, so that one that was cut
short spoils no other.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path

from common.environments import digest_of
from common.processes import BUILD, ROOT

NOT_SOURCES = {"build", "out", ".git"}
_OF_CORE = ("CMakeLists.txt", "core", "osl", "tests/core")
_ROOMS = {"blender", "core", "extension", "fuzz", "python", "website"}  # form looks at all


@cache
def digest_of_sources(room: str = "") -> str:
    """Of all; of a room of the tests, of what it can see: no tests of other rooms."""
    if room == "core":
        return digest_of(ROOT / path for path in _OF_CORE)
    unseen = {ROOT / "tests" / other for other in _ROOMS - {room}} if room in _ROOMS else set()
    top = (path for path in ROOT.iterdir() if path.name not in {*NOT_SOURCES, "tests"})
    return digest_of([*top, *{*(ROOT / "tests").iterdir()} - unseen])


class Kept(dict):
    """Findings by their names, as JSON has them; each is on the disk once it is added."""

    def __init__(self, file: Path) -> None:
        self.file = file
        _, *lines = file.read_text(encoding="utf-8").splitlines()
        super().__init__(_whole(lines))

    def add(self, name: str, finding: object) -> None:
        self[name] = finding
        with self.file.open("a", encoding="utf-8") as file:
            file.write("\n" + json.dumps([name, finding]))


def _whole(lines: Iterable[str]) -> Iterator[tuple[str, object]]:
    """Without those whose writing was cut short: what they told is found again."""
    for line in lines:
        with suppress(json.JSONDecodeError):
            yield json.loads(line)


def keep(name: str, *, again: bool = False, room: str = "", **conditions: object) -> Kept:
    """The command's findings, of a room of the tests if one is named; those of other sources or
    other conditions are dropped.
    """
    file = BUILD / "kept" / f"{name}.jsonl"
    head = json.dumps({"sources": digest_of_sources(room), **conditions})
    if again or not file.is_file() or file.read_text(encoding="utf-8").split("\n")[0] != head:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(head, encoding="utf-8")
    return Kept(file)
