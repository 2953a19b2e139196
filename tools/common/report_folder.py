# SPDX-License-Identifier: Apache-2.0
"""Reports: the folder that one owns, filled whole or not at all, and its tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from common import files
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
        if why := files.obstacle(out):
            raise StepFailedError(f"--out {out}: cannot be written ({why}).")
        if out.is_symlink() or (out.exists() and not out.is_dir()):
            raise StepFailedError(f"--out {out}: not a folder.")
        others = sorted(p.name for p in out.iterdir()) if out.is_dir() else []
        others = [name for name in others if name not in (REPORT, *self.pictures)]
        if others:
            raise StepFailedError(
                f"--out {out}: holds {others[0]}, which ./paint {self.command} did not make."
            )
        report = out / REPORT
        try:
            is_ours = not report.exists() or self.mark in report.read_text(errors="replace")
        except OSError:  # a folder, or closed to us
            is_ours = False
        if not is_ours:
            raise StepFailedError(f"{report} is not a report of ./paint {self.command}.")

    @contextmanager
    def fill(self, out: Path) -> Iterator[Path]:
        """A new folder that takes the place of `out` if the block ends well."""
        with files.whole(out) as folder:
            folder.mkdir()
            yield folder


ACCURACY = ReportFolder("accuracy", ("choices.png", "draws.png", "depth.png", "pictures.png"))
MEASURE = ReportFolder("measure", ("goniophotometer.png",))


def fit_folder(name: str) -> ReportFolder:
    """Of ./paint measure --fit, with the preset that it found."""
    return ReportFolder("measure --fit", ("curves.png", "spheres.png", f"{name}.json"))


BENCH = ReportFolder("bench", ("waits.png", "samples.png", "growth.png", "error.png"))
MOTION = ReportFolder("motion", ("motion.webp", "turntable.jpg", "dolly.jpg", "pan.jpg", "sun.jpg"))


GALLERY = ReportFolder(
    "gallery",
    ("swatches.jpg", "car-sun.jpg", "car-sky.jpg", "car-surroundings.jpg", "car-studio.jpg",
     "macro.jpg", "distance.jpg", "turntable.webp"),
)  # fmt: skip


def check_file(file: Path, out: Path | None = None) -> None:
    """Finds out before the work whether --json can be written."""
    if why := files.obstacle(file):
        raise StepFailedError(f"--json {file}: cannot be written ({why}).")
    if out and file.resolve().is_relative_to(out.resolve()):
        raise StepFailedError(f"--json {file}: the report's folder holds the report alone.")
    if file.is_dir() or (out and out.resolve().is_relative_to(file.resolve())):
        raise StepFailedError(f"--json {file}: a folder.")


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """The lines of a Markdown table, all columns but the first to the right."""
    yield "| " + " | ".join(head) + " |"
    yield "| --- |" + " ---: |" * (len(head) - 1)
    for row in rows:
        yield "| " + " | ".join(row) + " |"
    yield ""
