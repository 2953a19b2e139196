# SPDX-License-Identifier: Apache-2.0
"""What a long command keeps of its findings, so that a run cut short goes on."""

from __future__ import annotations

from pathlib import Path

import pytest
from common import environments, kept

FINDINGS = {"first": 1.5, "second": [1, 2], "third": "three"}


@pytest.fixture(autouse=True)
def build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kept, "BUILD", tmp_path)


def filled() -> kept.Kept:
    found = kept.keep("command", seed=1)
    for name, finding in FINDINGS.items():
        found.add(name, finding)
    return found


def test_findings_are_read_back_unless_their_conditions_changed() -> None:
    filled()
    assert kept.keep("command", seed=1) == FINDINGS
    assert kept.keep("command", seed=1, again=True) == {}
    filled()
    assert kept.keep("command", seed=2) == {}


def test_a_finding_that_was_cut_short_is_found_again_and_spoils_no_other() -> None:
    file = filled().file
    whole = file.read_bytes()
    for end in range(whole.index(b"\n"), len(whole)):
        file.write_bytes(whole[:end])
        found = kept.keep("command", seed=1)
        count = len(found)
        assert found == dict(list(FINDINGS.items())[:count])
        assert count < len(FINDINGS)
        for name in [*FINDINGS][count:]:
            found.add(name, FINDINGS[name])
        assert kept.keep("command", seed=1) == FINDINGS


def test_a_head_that_was_cut_short_keeps_nothing() -> None:
    file = filled().file
    head, _, _ = file.read_text().partition("\n")
    file.write_text(head[:-1])
    assert kept.keep("command", seed=1) == {}


def test_a_room_of_the_tests_is_not_run_again_for_another_rooms_tests(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    places = (
        "core/a.h",
        "addon/a.py",
        "tests/conftest.py",
        "tests/core/a.cpp",
        "tests/blender/a.py",
    )
    for place in places:
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / place).touch()
    monkeypatch.setattr(kept, "ROOT", tmp_path)
    monkeypatch.setattr(environments, "ROOT", tmp_path)
    rooms = ("", "form", "core", "blender")
    changed_by = {}
    for place in places:
        before = [kept.digest_of_sources.__wrapped__(room) for room in rooms]
        (tmp_path / place).write_text(place)
        after = [kept.digest_of_sources.__wrapped__(room) for room in rooms]
        changed_by[place] = [
            room for room, a, b in zip(rooms, before, after, strict=True) if a != b
        ]
    assert changed_by == {
        "core/a.h": ["", "form", "core", "blender"],
        "addon/a.py": ["", "form", "blender"],
        "tests/conftest.py": ["", "form", "blender"],
        "tests/core/a.cpp": ["", "form", "core"],
        "tests/blender/a.py": ["", "form", "blender"],
    }
