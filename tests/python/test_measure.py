# SPDX-License-Identifier: Apache-2.0
"""./paint measure, run as a user runs it. It needs no Blender: one Python is enough."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from common.processes import ROOT
from common.report_folder import MEASURE, REPORT

SECONDS = 900  # the first run builds and installs

pytestmark = pytest.mark.skipif(sys.version_info[:2] != (3, 11), reason="runs with Python 3.11")


def measure(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [ROOT / "paint", "measure", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)


def test_a_report_holds_every_number_with_its_error(tmp_path: Path) -> None:
    out, file = tmp_path / "new" / "report", tmp_path / "numbers.json"
    done = measure("silver-coarse", "--quick", "--out", out, "--json", file)
    assert done.returncode == 0, done.stdout + done.stderr
    assert list(out.parent.iterdir()) == [out]
    assert sorted(path.name for path in out.iterdir()) == sorted([REPORT, *MEASURE.pictures])
    assert (out / MEASURE.pictures[0]).read_bytes().startswith(b"\x89PNG")

    text = (out / REPORT).read_text()
    assert text.startswith(MEASURE.mark)
    assert f"]({MEASURE.pictures[0]})" in text
    figures = json.loads(file.read_text())
    assert len(figures) == 6 * 3 + 1 + 3 * 2 + 1
    for figure in figures:
        assert list(figure) == ["name", "value", "unit", "error"]
        if figure["value"] is not None:
            assert figure["error"] > 0, figure
    values = {figure["name"]: figure["value"] for figure in figures}
    assert 10 < values["flop index"] < 17
    assert values["L* at 15°"] > values["L* at 45°"] > values["L* at 110°"]
    printed = re.search(r"Flop index: (\S+) ± (\S+)", done.stdout)
    assert printed is not None
    assert float(printed[1]) == pytest.approx(values["flop index"], abs=float(printed[2]))
    assert str(out / REPORT) in done.stdout


def test_an_unknown_preset_is_named_and_nothing_is_written(tmp_path: Path) -> None:
    done = measure("mauve", "--out", tmp_path / "out")
    assert done.returncode == 1
    assert "'mauve' is neither a file nor a preset" in done.stderr
    assert "silver-fine" in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_paint_that_the_references_cannot_trace_is_a_sentence(tmp_path: Path) -> None:
    dense = tmp_path / "dense.json"
    paint = {"flakes_per_mm2": 1e9, "flake_diameter_um": 1e3}
    dense.write_text(json.dumps({"schema_version": 1, "paint": paint}))
    done = measure(dense, "--quick", "--out", tmp_path / "out")
    assert done.returncode == 1
    assert "number of flakes" in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == [dense]


def test_what_cannot_be_written_is_said_before_measuring(tmp_path: Path) -> None:
    file, folder = tmp_path / "file", tmp_path / "folder"
    file.write_text("mine")
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    for arguments in (
        ["--out", file],
        ["--out", folder],
        ["--out", tmp_path / "a", "--json", file / "numbers.json"],
        ["--out", tmp_path / "a", "--json", tmp_path],
    ):
        done = measure("gold", "--quick", *arguments)
        assert done.returncode == 1
        assert "Traceback" not in done.stderr
        assert "Goniophotometer" not in done.stdout
    assert sorted(tmp_path.iterdir()) == [file, folder]
    assert [path.name for path in folder.iterdir()] == ["notes.txt"]
