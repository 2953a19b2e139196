# SPDX-License-Identifier: Apache-2.0
"""./paint motion: what it measures of a motion, and its report, whole or not at all."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from common import bars
from common.processes import ROOT, TOOLS
from common.report_folder import MOTION, REPORT
from motion.rows import FILM, FILMED, MEASURED, strip_of

pytestmark = pytest.mark.long

SECONDS = 1200  # a quick run of all motions that takes longer hangs


def run(*command: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        list(map(str, command)), capture_output=True, text=True, timeout=SECONDS, check=False
    )


def test_sparkles_ride_on_the_paint_as_it_slides_past(tmp_path: Path) -> None:
    file = tmp_path / "pan.json"
    done = run(sys.executable, TOOLS, "motion.measure", "pan", "--json", file, "--quick")
    assert done.returncode == 0, done.stderr
    rows = {row["quantity"]: row["values"] for row in json.loads(file.read_text())["rows"]}
    what = "correlation of neighbouring frames"
    warped, same = rows[f"{what}, warped, 64 samples"], rows[f"{what}, at the same pixel"]
    # What is drawn anew correlates within the chance of some hundred sparkles.
    assert warped["surface"] > 0.9 > 0.25 > abs(same["surface"])
    assert same["pixel"] > 0.9 > 0.25 > abs(warped["pixel"])
    assert warped["Voronoi"] > 0.4
    assert rows["nothing moves: share of pixels as in another frame"] == {"surface": 1}


def test_a_report_holds_film_strips_and_bars(tmp_path: Path) -> None:
    out, file = tmp_path / "new" / "motion", tmp_path / "bars.json"
    done = run(ROOT / "paint", "motion", "--quick", "--out", out, "--json", file)
    assert done.returncode in (0, 1), done.stdout + done.stderr  # 1: a rough value misses its bar
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bars.json", "new"]
    assert list(out.parent.iterdir()) == [out]
    assert sorted(path.name for path in out.iterdir()) == sorted([REPORT, *MOTION.pictures])
    text = (out / REPORT).read_text(encoding="utf-8")
    assert text.startswith(MOTION.mark)
    assert f"]({FILM})" in text
    found = [bars.Bar(**bar) for bar in json.loads(file.read_text())]
    assert len({bar.name for bar in found}) == len(found)
    for motion in MEASURED:
        assert f"## {motion.capitalize()}" in text
        assert any(f", {motion}: " in bar.name for bar in found)
    assert all(bar.value is not None for bar in found)
    assert (done.returncode == 0) == all(bar.holds for bar in found)


def test_a_folder_with_other_things_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("mine")
    done = run(sys.executable, TOOLS, "motion.run", "--quick", "--out", tmp_path)
    assert done.returncode == 1
    assert "letter.txt, which ./paint motion did not make" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]


def test_the_folder_owns_the_film_and_a_strip_of_each_motion() -> None:
    assert MOTION.pictures == (FILM, *map(strip_of, FILMED))


def test_the_committed_report_shows_every_motion() -> None:
    folder = ROOT / "docs" / "motion"
    text = (folder / REPORT).read_text(encoding="utf-8")
    assert text.startswith(MOTION.mark)
    for motion in MEASURED:
        assert f"## {motion.capitalize()}" in text
    for picture in MOTION.pictures:
        assert f"({picture})" in text
        assert (folder / picture).stat().st_size < (2_000_000 if picture == FILM else 500_000)
