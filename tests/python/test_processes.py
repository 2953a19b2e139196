# SPDX-License-Identifier: Apache-2.0
"""What ./paint says while a step takes its time."""

from __future__ import annotations

import time

import pytest
from common import processes

pytestmark = pytest.mark.long


def test_a_long_step_tells_that_it_goes_on_and_a_short_one_is_quiet(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with processes.telling_time("A short step"):
        pass
    assert capsys.readouterr().out == ""
    monkeypatch.setattr(processes, "TELL_SECONDS", 0.05)
    with processes.telling_time("A long step"):
        time.sleep(0.5)
    lines = capsys.readouterr().out.splitlines()
    assert lines
    assert set(lines) <= {"  A long step: 0 s…", "  A long step: 1 s…"}
    time.sleep(0.2)
    assert capsys.readouterr().out == ""  # it ended with the step
