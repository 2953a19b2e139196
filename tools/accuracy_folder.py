# SPDX-License-Identifier: Apache-2.0
"""The folder that ./paint accuracy owns: filled whole or not at all, nobody else's files in it."""

from __future__ import annotations

import shutil
from pathlib import Path

from processes import StepFailedError

REPORT = "README.md"
MARK = "<!-- Written by ./paint accuracy; every number comes from its run. -->"
PICTURES = ("choices.png", "draws.png", "depth.png", "pictures.png")


def check(out: Path) -> None:
    """Finds out before minutes of measuring whether the report may be written there."""
    if out.is_symlink() or (out.exists() and not out.is_dir()):
        raise StepFailedError(f"--out {out}: not a folder.")
    others = sorted(p.name for p in out.iterdir()) if out.is_dir() else []
    others = [name for name in others if name not in (REPORT, *PICTURES)]
    if others:
        raise StepFailedError(
            f"--out {out}: holds {others[0]}, which ./paint accuracy did not make."
        )
    report = out / REPORT
    if report.exists() and MARK not in report.read_text(errors="replace"):
        raise StepFailedError(f"{report} is not a report of ./paint accuracy.")
    try:
        unfinished(out).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StepFailedError(f"--out {out}: cannot be written ({error.strerror}).") from error
    discard(out)


def unfinished(out: Path) -> Path:
    whole = out.absolute()
    return whole.with_name(f".{whole.name}.unfinished")


def discard(out: Path) -> None:
    shutil.rmtree(unfinished(out), ignore_errors=True)


def publish(out: Path) -> None:
    """Puts what stands in unfinished(out) in the place of out."""
    earlier = unfinished(out).with_suffix(".earlier")
    shutil.rmtree(earlier, ignore_errors=True)
    if out.exists():
        out.rename(earlier)
    unfinished(out).rename(out.absolute())
    shutil.rmtree(earlier, ignore_errors=True)
