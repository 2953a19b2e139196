# SPDX-License-Identifier: Apache-2.0
"""Running other programs: within a time limit, whole process groups at once, with logs."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import IO

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build"
LOGS = BUILD / "logs"

TIMED_OUT = 124
GRACE_SECONDS = 5


class StepFailedError(Exception):
    """A step of the build failed; the message says which and why."""


def say(line: str) -> None:
    print(line, flush=True)


def tail(log: Path, lines: int = 25) -> str:
    return "\n".join(log.read_text(errors="replace").splitlines()[-lines:])


def run_limited(command: Sequence[str | Path], *, seconds: float, log: Path | None = None) -> int:
    """Runs a command, its output in `log` if given, and returns its exit code.

    The code is negative for a signal and TIMED_OUT if the time ran out. Whatever ends the wait,
    nothing that the command started is left behind.
    """
    if log is None:
        return _run(command, seconds, None)
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("wb") as output:
        return _run(command, seconds, output)


def _run(command: Sequence[str | Path], seconds: float, output: IO[bytes] | None) -> int:
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=output,
        stderr=None if output is None else subprocess.STDOUT,
        start_new_session=True,
    )
    try:
        return process.wait(timeout=seconds)
    except subprocess.TimeoutExpired:
        return TIMED_OUT
    finally:
        _end_group(process)


def _end_group(process: subprocess.Popen[bytes]) -> None:
    for sign in (signal.SIGTERM, signal.SIGKILL):
        try:
            os.killpg(process.pid, sign)
            process.wait(timeout=GRACE_SECONDS)
        except ProcessLookupError:
            return
        except subprocess.TimeoutExpired:
            continue


def run_step(what: str, command: Sequence[str | Path], log_name: str) -> None:
    """Runs one step of a build, quietly; a failure carries the end of its log."""
    log = LOGS / log_name
    code = run_limited(command, seconds=3600, log=log)
    if code != 0:
        raise StepFailedError(
            f"{what} failed ({describe(code)}). The end of {log.relative_to(ROOT)}:\n{tail(log)}"
        )


def describe(code: int) -> str:
    if code == TIMED_OUT:
        return "it ran out of time"
    if code < 0:
        return f"it crashed with {signal.Signals(-code).name}"
    return f"exit code {code}"


def stop_children_on_sigterm() -> None:
    """Lets SIGTERM unwind like Ctrl-C, so that no child outlives us."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
