# SPDX-License-Identifier: Apache-2.0
"""What a long command has found on the sources as they are, so that a run cut short goes on.

Each command has a file in build/kept: first the digest of the sources and what else its findings
hold for, then a line for each finding.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

from common.environments import digest_of
from common.processes import BUILD, ROOT

NOT_SOURCES = {"build", "out", ".git"}


@cache
def digest_of_sources() -> str:
    return digest_of(path for path in ROOT.iterdir() if path.name not in NOT_SOURCES)


class Kept(dict):
    """Findings by their names, as JSON has them; each is on the disk once it is added."""

    def __init__(self, file: Path) -> None:
        self.file = file
        _, *lines = file.read_text(encoding="utf-8").splitlines()
        super().__init__(map(json.loads, lines))

    def add(self, name: str, finding: object) -> None:
        self[name] = finding
        with self.file.open("a", encoding="utf-8") as file:
            file.write(json.dumps([name, finding]) + "\n")


def keep(name: str, *, again: bool = False, **conditions: object) -> Kept:
    """The command's findings; those of other sources or other conditions are dropped."""
    file = BUILD / "kept" / f"{name}.jsonl"
    head = json.dumps({"sources": digest_of_sources(), **conditions})
    if again or not file.is_file() or file.read_text(encoding="utf-8").split("\n")[0] != head:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"{head}\n", encoding="utf-8")
    return Kept(file)
