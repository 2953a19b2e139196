# SPDX-License-Identifier: Apache-2.0
"""./paint bench: what it refuses, and what becomes of the times that it took."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import seeds
from bench.equal_error import Series, crossing
from bench.instructions import read as read_counts
from bench.rows import Found, Row, ratios, read, write
from bench.waits import LIVE, METALS, ONE_METAL, ONE_PAINT, PRESETS, SHARED, wait_rows
from common.processes import TOOLS

pytestmark = pytest.mark.long


def run(*options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, TOOLS, "bench.run", *options]
    return subprocess.run(
        list(map(str, command)), capture_output=True, text=True, timeout=60, check=False
    )


def test_a_folder_with_other_things_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("mine")
    done = run("--quick", "--out", tmp_path)
    assert done.returncode == 1
    assert "letter.txt, which ./paint bench did not make" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]


def test_a_file_in_the_reports_folder_is_refused(tmp_path: Path) -> None:
    done = run("--out", tmp_path / "bench", "--json", tmp_path / "bench" / "bars.json")
    assert done.returncode == 1
    assert "the report's folder holds the report alone" in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_part_that_there_is_not_is_refused_and_the_others_named(tmp_path: Path) -> None:
    done = run("--out", tmp_path / "bench", "--only", "speed of light")
    assert done.returncode == 1
    assert done.stderr.startswith("--only speed of light: none of waits, ")
    assert not list(tmp_path.iterdir())


def test_a_row_has_the_median_and_the_quartiles_of_its_values() -> None:
    row = Row("a over b", [5, 1, 4, 2, 3])
    assert row.median == 3
    assert row.quartiles == (2, 4)
    assert Row("once", [7]).quartiles == (7, 7)


def test_the_median_is_held_against_the_limit() -> None:
    [bar] = Row("a over b", [1, 2, 9], 2).bars("here")
    assert (bar.name, bar.value, bar.holds) == ("here: a over b, at most", 2, True)
    [bar] = Row("a over b", [1, 2, 9], 2.5, bound="at least").bars("here")
    assert not bar.holds
    assert not list(Row("for orientation", [1, 2, 9]).bars("here"))


def test_a_time_of_nothing_gives_no_ratio_and_no_bar_that_holds() -> None:
    assert math.isnan(ratios([1.0], [0.0])[0])
    [bar] = Row("a over b", ratios([1.0], [0.0]), 2).bars("here")
    assert bar.value is None
    assert not bar.holds


@pytest.mark.parametrize(("more", "holds"), [(0.049, True), (0.051, False)])
def test_a_wait_may_be_twice_principleds_and_a_twentieth_of_a_second(
    more: float, holds: bool
) -> None:
    metal = {"first": [0.1], "slider": [0.03], "move": [0.01], "frame": [0.01]}
    paint = {"first": [0.2 + more], "slider": [0.06 + more], "made": [1.0]}
    paint |= {"move": [0.01 + more], "frame": [0.01 + more]}
    found = {ONE_METAL: metal, ONE_PAINT: paint, LIVE: paint, SHARED: paint, METALS: metal}
    found[PRESETS] = {"first": [2.0 if holds else 2.1]}
    judged = [bar for row in wait_rows(found) for bar in row.bars("here")]
    assert len(judged) == 6
    assert all(bar.holds is holds for bar in judged)


@pytest.mark.parametrize("blender", ["4.5", ""])
def test_what_was_found_comes_back_from_its_file(tmp_path: Path, blender: str) -> None:
    rows = [Row("a over b", [1.5, 2], 3, orientation="7 ns"), Row("grows", [1], curve="c", at=4)]
    found = Found("samples", blender, rows)
    write([found], tmp_path / "found.json")
    assert read(tmp_path / "found.json") == [found]


def series(noise: float, samples: int, seconds: float = 1e-6) -> Series:
    """Pictures of 1 with noise that falls as the root of the samples."""
    rng = seeds.fresh(13)
    counts = 4 ** np.arange(5)

    def picture(count: int) -> np.ndarray:
        return 1 + rng.normal(scale=noise / math.sqrt(count), size=(200, 200, 3))

    pictures = np.array([picture(count) for count in counts])
    return Series(seconds, counts, pictures, samples, picture(samples))


def test_the_noise_of_the_converged_picture_is_none_of_the_error() -> None:
    """120,000 numbers: each RMSE is known to 0.2 %, six standard errors are within 2 %."""
    found = series(noise=2, samples=256)
    assert found.rmse() == pytest.approx(2 / 2.0 ** np.arange(5), rel=0.02)


@pytest.mark.parametrize("error", [1.5, 0.3, 0.125, 0.02])  # the last beyond all pictures
def test_time_to_an_error_is_that_of_the_law_of_noise(error: float) -> None:
    found = series(noise=2, samples=1 << 20, seconds=1e-6)
    assert found.time_to(error) == pytest.approx(1e-6 * (2 / error) ** 2, rel=0.05)


def test_an_advantage_ends_where_its_factor_passes_one() -> None:
    assert crossing({4: 0.1, 16: 10, 64: 100}) == pytest.approx(8)
    assert crossing({4: 2, 16: 10}) is None
    assert crossing({4: 1, 16: 10}) is None


CALLGRIND = """\
# callgrind format
desc: Timerange: Basic block 0 - 9
desc: Trigger: dump the paint, 33

positions: line
events: Ir
summary: 1015

ob=(1) /lib/libcycles.so
fn=(1) render
10 5
+2 3
cob=(2) ???
cfn=(2) 0x4c3be000
calls=2 0
* 1007

ob=(2)
fn=(2)
0 900
0 100
cob=(1)
cfn=(3) sine
calls=4 80
0 7

ob=(1)
fn=(3)
80 7

totals: 1015
"""


def test_instructions_are_counted_where_they_are_executed_and_once(tmp_path: Path) -> None:
    file = tmp_path / "callgrind.1"
    file.write_text(CALLGRIND, encoding="utf-8")
    assert read_counts(file) == ("the paint, 33", (1015, 1000))
