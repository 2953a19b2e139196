# SPDX-License-Identifier: Apache-2.0
"""Running other programs: within a time limit, whole process groups at once, with logs."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, NoReturn

ROOT = Path(__file__).resolve().parents[2]
TOOLS = ROOT / "tools"
BUILD = ROOT / "build"
LOGS = BUILD / "logs"

TIMED_OUT = 124
GRACE_SECONDS = 5
TELL_SECONDS = 10  # whoever waits longer without a word thinks that it hangs


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


@contextmanager
def telling_time(what: str) -> Iterator[None]:
    """Says from time to time that the work goes on."""
    start, done = time.monotonic(), threading.Event()

    def tell() -> None:
        while not done.wait(TELL_SECONDS):
            say(f"  {what}: {time.monotonic() - start:.0f} s…")

    thread = threading.Thread(target=tell, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def run_measurement(
    what: str, command: Sequence[str | Path], *, good: Collection[int] = (0,), seconds: float = 3600
) -> int:
    """Runs one program of a report, which is written at the end; returns its exit code."""
    code = run_limited(command, seconds=seconds)
    if code not in good:
        raise StepFailedError(f"{what} failed ({describe(code)}); nothing was written.")
    return code


def describe(code: int) -> str:
    if code == TIMED_OUT:
        return "it ran out of time"
    if code < 0:
        return f"it crashed with {signal.Signals(-code).name}"
    return f"exit code {code}"


class _InterruptedError(BaseException):
    """Ctrl-C or SIGTERM; only run_program may catch it."""


def run_program(main: Callable[[], int]) -> NoReturn:
    """Exits with main's code; a failed step or an interruption ends with a sentence instead.

    No child outlives us, however we are told to stop.
    """
    for number in stop_signals():
        signal.signal(number, _interrupt)
    try:
        sys.exit(main())
    except StepFailedError as error:
        sys.exit(str(error))
    except _InterruptedError as interruption:
        if is_outermost():
            print("\nInterrupted.", file=sys.stderr)
        sys.exit(128 + interruption.args[0])


def is_outermost() -> bool:
    """Whether nobody of ours says what befell us: what run_limited starts leads a session."""
    return os.getsid(0) != os.getpid()


def _interrupt(number: int, _frame: object) -> None:
    for each in stop_signals():  # a second Ctrl-C must not stop the ending of the children
        signal.signal(each, signal.SIG_IGN)
    raise _InterruptedError(number)


def stop_signals() -> list[int]:
    """Leaves alone what our starter ignores, as a shell does with Ctrl-C for its background."""
    both = (signal.SIGINT, signal.SIGTERM)
    return [number for number in both if signal.getsignal(number) != signal.SIG_IGN]
