# SPDX-License-Identifier: Apache-2.0
"""Each fuzzer for a while: the same inputs in every run."""

import subprocess
import sys
from pathlib import Path

import pytest

RUNS = 60_000  # about 15 s
FUZZERS = sorted(Path(__file__).parent.glob("fuzz_*.py"))


@pytest.mark.long
@pytest.mark.parametrize("fuzzer", FUZZERS, ids=lambda file: file.stem)
def test_fuzzer_finds_nothing(fuzzer: Path) -> None:
    """What fails is kept where its output says."""
    command = [sys.executable, fuzzer, f"-runs={RUNS}", "-seed=1"]
    subprocess.run(command, check=True, timeout=1800)
