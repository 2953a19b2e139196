# SPDX-License-Identifier: Apache-2.0
"""Reports: the folder that one owns, filled whole or not at all, and its tables."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from common.processes import StepFailedError

REPORT = "README.md"


@dataclass(frozen=True)
class ReportFolder:
    command: str
    pictures: tuple[str, ...]

    @property
    def mark(self) -> str:
        """The first line of every report."""
        return f"<!-- Written by ./paint {self.command}; every number comes from its run. -->"

    def check(self, out: Path) -> None:
        """Finds out before minutes of measuring whether the report may be written there."""
        if out.is_symlink() or (out.exists() and not out.is_dir()):
            raise StepFailedError(f"--out {out}: not a folder.")
        others = sorted(p.name for p in out.iterdir()) if out.is_dir() else []
        others = [name for name in others if name not in (REPORT, *self.pictures)]
        if others:
            raise StepFailedError(
                f"--out {out}: holds {others[0]}, which ./paint {self.command} did not make."
            )
        report = out / REPORT
        if report.exists() and self.mark not in report.read_text(errors="replace"):
            raise StepFailedError(f"{report} is not a report of ./paint {self.command}.")
        unfinished = _unfinished(out)
        try:
            unfinished.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StepFailedError(f"--out {out}: cannot be written ({error.strerror}).") from error
        shutil.rmtree(unfinished, ignore_errors=True)

    @contextmanager
    def fill(self, out: Path) -> Iterator[Path]:
        """A new folder that takes the place of `out` if the block ends well."""
        unfinished = _unfinished(out)
        try:
            unfinished.mkdir(parents=True)
            yield unfinished
            earlier = unfinished.with_suffix(".earlier")
            shutil.rmtree(earlier, ignore_errors=True)
            if out.exists():
                out.rename(earlier)
            unfinished.rename(out.absolute())
            shutil.rmtree(earlier, ignore_errors=True)
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)


ACCURACY = ReportFolder("accuracy", ("choices.png", "draws.png", "depth.png", "pictures.png"))
MEASURE = ReportFolder("measure", ("goniophotometer.png",))


GALLERY = ReportFolder(
    "gallery",
    ("swatches.jpg", "car-sun.jpg", "car-sky.jpg", "car-surroundings.jpg", "car-studio.jpg",
     "macro.jpg", "distance.jpg"),
)  # fmt: skip


def check_file(file: Path, out: Path) -> None:
    """Finds out before the measuring whether --json can be written."""
    if out.resolve() in file.resolve().parents:
        raise StepFailedError(f"--json {file}: the report's folder holds the report alone.")
    if file.is_dir():
        raise StepFailedError(f"--json {file}: a folder.")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StepFailedError(
            f"--json {file}: no folder to write to ({error.strerror})."
        ) from error


def _unfinished(out: Path) -> Path:
    whole = out.absolute()
    return whole.with_name(f".{whole.name}.unfinished")


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """The lines of a Markdown table, all columns but the first to the right."""
    yield "| " + " | ".join(head) + " |"
    yield "| --- |" + " ---: |" * (len(head) - 1)
    for row in rows:
        yield "| " + " | ".join(row) + " |"
    yield ""
