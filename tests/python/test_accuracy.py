# SPDX-License-Identifier: Apache-2.0
"""./paint accuracy, run as a user runs it. It needs no Blender: one Python is enough."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from common import bars
from common.processes import ROOT
from common.report_folder import ACCURACY, REPORT

SECONDS = 900  # the first run builds and installs
GROUPS = ("number type", "orientation", "blocked area", "draw", "radiometry", "depth",
          "flake spread", "all together")  # fmt: skip

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(sys.version_info[:2] != (3, 11), reason="runs with Python 3.11"),
]


def accuracy(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [ROOT / "paint", "accuracy", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[dict], str]:
    """The folder, the bars and what was said."""
    folder = tmp_path_factory.mktemp("accuracy")
    out, file = folder / "new" / "report", folder / "bars.json"
    done = accuracy("--quick", "--out", out, "--json", file)
    assert done.returncode == 0, done.stdout + done.stderr
    assert sorted(path.name for path in folder.iterdir()) == ["bars.json", "new"]
    assert list(out.parent.iterdir()) == [out]
    return out, json.loads(file.read_text()), done.stdout


def test_the_bars_have_the_form_of_every_report(run: tuple[Path, list[dict], str]) -> None:
    _, found, _ = run
    for bar in found:
        assert bars.Bar(**bar).holds
    names = [bar["name"] for bar in found]
    assert len(names) == len(set(names))
    for part in (
        "choices that dominate what ships",
        "FLIP",
        "Wasserstein",
        "variance off the closed form",
        "traced flakes",
        "mean of correlated",
    ):
        assert any(part in name for name in names), part


def test_the_report_holds_every_choice_with_its_numbers(run: tuple[Path, list[dict], str]) -> None:
    out, _, _ = run
    text = (out / REPORT).read_text()
    assert text.startswith(ACCURACY.mark)
    titles = re.findall(r"^### (.*)$", text, re.MULTILINE)
    assert len(titles) == len(GROUPS)
    for group, title in zip(GROUPS, titles, strict=True):
        assert group in title.lower()
        section = text.split(f"### {title}\n")[1].split("###")[0]
        rows = [line.split("|")[1:-1] for line in section.splitlines() if line.startswith("| ")]
        choices = rows[2:]
        assert len(choices) >= 2
        assert sum(row[0].strip().startswith("**") for row in choices) == 1  # what ships
        for row in choices:
            assert len(row) == len(rows[0])
            assert all(cell.strip() for cell in row[:-1]), row
            times = [float(part.replace(",", "")) for part in row[2].split("/")]
            assert len(times) == len(rows[0][2].split("/"))
            assert min(times) > 0, row
    assert "nan" not in text


def test_the_pictures_of_the_report_are_there_and_small(run: tuple[Path, list[dict], str]) -> None:
    out, _, _ = run
    shown = re.findall(r"!\[[^]]+\]\(([^)]+)\)", (out / REPORT).read_text())
    assert sorted(shown) == sorted(ACCURACY.pictures)
    assert sorted(path.name for path in out.iterdir()) == sorted([*shown, REPORT])
    for name in shown:
        data = (out / name).read_bytes()
        assert data.startswith(b"\x89PNG")
        assert 10_000 < len(data) < 500_000


def test_the_conclusions_are_said_as_well(run: tuple[Path, list[dict], str]) -> None:
    out, _, said = run
    text = (out / REPORT).read_text()
    short = text.split("## In short\n")[1].split("##")[0].strip()
    assert short in said
    assert str(out / REPORT) in said


@pytest.mark.parametrize("name", ["README.md", "notes.txt"])
def test_nobody_elses_folder_is_written_to(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine")
    done = accuracy("--quick", "--out", tmp_path)
    assert done.returncode == 1
    assert name in done.stderr
    assert "Traceback" not in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "mine"


def test_what_cannot_be_written_is_said_before_measuring(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("mine")
    for arguments in (
        ["--out", file],
        ["--out", tmp_path / "a", "--json", file / "bars.json"],
        ["--out", tmp_path / "a", "--json", tmp_path / "a" / "bars.json"],
        ["--out", tmp_path / "a", "--json", tmp_path],
    ):
        done = accuracy("--quick", *arguments)
        assert done.returncode == 1
        assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == [file]
