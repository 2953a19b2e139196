# SPDX-License-Identifier: Apache-2.0
"""Running the programs that measure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from common.processes import StepFailedError, describe, run_limited

SECONDS = 3600  # for one of them


def run(what: str, command: Sequence[str | Path]) -> None:
    code = run_limited(command, seconds=SECONDS)
    if code != 0:
        raise StepFailedError(f"{what} failed ({describe(code)}); nothing was written.")
