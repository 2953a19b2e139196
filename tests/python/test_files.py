# SPDX-License-Identifier: Apache-2.0
"""What the commands write is there whole or not at all, with no folder made for it either."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from common import environments, files
from common.processes import TOOLS, StepFailedError
from common.report_folder import MEASURE, REPORT, check_file

# As ./paint accuracy and ./paint measure: a program that starts another, which writes.
INNER = """
import sys, time
sys.path.insert(0, sys.argv[1])
from pathlib import Path
from common import environments, files
from common.processes import run_program

def main():
    with files.whole(Path(sys.argv[2])) as folder:
        folder.mkdir()
        (folder / "part").write_text("a part")
        print("writing", flush=True)
        time.sleep(60)
    return 0

run_program(main)
"""
OUTER = """
import signal
import sys
sys.path.insert(0, sys.argv[1])
signal.signal(signal.SIGINT, signal.default_int_handler)  # whatever our starter ignores
from common.processes import run_limited, run_program

run_program(lambda: run_limited([sys.executable, "-c", *sys.argv[2:]], seconds=60))
"""


def test_what_is_written_takes_the_place_of_what_was(tmp_path: Path) -> None:
    file, folder = tmp_path / "new" / "file.json", tmp_path / "folder"
    folder.mkdir()
    (folder / "old").write_text("old")
    files.write(file, "one")
    files.write(file, "two")
    with files.whole(folder) as beside:
        beside.mkdir()
        (beside / "new").write_text("new")
    assert file.read_text() == "two"
    assert [path.name for path in folder.iterdir()] == ["new"]
    assert sorted(tmp_path.iterdir()) == [folder, file.parent]
    assert list(file.parent.iterdir()) == [file]


def test_a_symbolic_link_stays_one(tmp_path: Path) -> None:
    file, link = tmp_path / "file.json", tmp_path / "elsewhere" / "link.json"
    link.parent.mkdir()
    link.symlink_to(file)
    for text in ("one", "two"):  # the first where the link dangles
        files.write(link, text)
        assert file.read_text() == text
    assert link.is_symlink()


def test_a_name_may_be_as_long_as_the_system_lets_it(tmp_path: Path) -> None:
    longest = [tmp_path / ("x" * 251 + suffix) for suffix in (".exr", ".png")]
    with files.whole(longest[0]) as exr, files.whole(longest[1]) as png:
        exr.write_text("exr")
        png.write_text("png")
    assert (exr.suffix, png.suffix) == (".exr", ".png")
    assert [path.read_text() for path in longest] == ["exr", "png"]
    files.write(tmp_path / ("a." + "x" * 253), "text")
    assert "too long" in files.obstacle(tmp_path / "new" / ("x" * 252 + ".png"))


def test_a_file_takes_no_place_of_a_folder(tmp_path: Path) -> None:
    (tmp_path / "report").mkdir()
    (tmp_path / "report" / "README.md").write_text("mine")
    with pytest.raises(IsADirectoryError):
        files.write(tmp_path / "report", "text")
    assert [path.name for path in tmp_path.rglob("*")] == ["report", "README.md"]


def test_a_failure_leaves_everything_as_it_was(tmp_path: Path) -> None:
    file = tmp_path / "file.txt"
    file.write_text("old")
    for path in (file, tmp_path / "new" / "deep" / "file.txt"):
        with pytest.raises(KeyboardInterrupt), files.whole(path) as beside:  # noqa: PT012
            beside.write_text("new")
            raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == [file]
    assert file.read_text() == "old"


def test_a_folder_made_on_the_way_stays_if_somebody_uses_it(tmp_path: Path) -> None:
    path = tmp_path / "a" / "b" / "c"
    with pytest.raises(ValueError, match="stop"), files.whole(path) as beside:  # noqa: PT012
        (beside.parent.parent / "theirs").write_text("theirs")
        raise ValueError("stop")
    assert [path.name for path in tmp_path.rglob("*")] == ["a", "theirs"]


def test_an_obstacle_is_found_before_and_nothing_is_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")
    assert files.obstacle(tmp_path / "new" / "deep" / "file.json") == ""
    assert files.obstacle(tmp_path / "file" / "file.json") == "Not a directory"
    assert files.obstacle(tmp_path / "dangling" / "file.json") == "Not a directory"
    check_file(tmp_path / "new" / "bars.json", tmp_path / "report")
    MEASURE.check(tmp_path / "new" / "report")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["dangling", "file"]


def test_a_pipe_or_device_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("pipe")
    (tmp_path / "loop").symlink_to("loop")
    for name in ("pipe", "link", "loop"):
        with pytest.raises(StepFailedError, match="neither a file nor a folder"):
            check_file(tmp_path / name)


def test_what_is_closed_to_us_is_refused(closed: Path) -> None:
    for path in (closed / "new", closed / "new" / "file.json"):
        assert files.obstacle(path) == "Permission denied"
        for check in (check_file, MEASURE.check):
            with pytest.raises(StepFailedError, match="Permission denied"):
                check(path)
    with pytest.raises(StepFailedError, match="Permission denied"):
        MEASURE.check(closed)


def test_whoever_may_not_write_in_build_only_runs_what_is_there(
    closed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(environments, "BUILD", closed)
    with environments.alone():
        pass
    with (
        pytest.raises(StepFailedError, match="log: Permission denied"),
        environments.alone(),
    ):
        (closed / "log").write_text("")


def test_a_folder_is_no_report(tmp_path: Path) -> None:
    (tmp_path / REPORT).mkdir()
    with pytest.raises(StepFailedError, match="is not a report of"):
        MEASURE.check(tmp_path)


def test_the_current_folder_is_not_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "report").mkdir()
    monkeypatch.chdir(tmp_path / "report")
    for out in (Path(), Path.cwd(), Path("..", "report")):
        with pytest.raises(StepFailedError, match="the current folder lies there"):
            MEASURE.check(out)
    MEASURE.check(Path("new"))


@pytest.mark.parametrize(
    ("file", "out", "complaint"),
    [
        ("report/bars.json", "report", "the report's folder holds the report alone"),
        ("report", "report", "the report's folder holds the report alone"),
        ("new", "new/report", "new: a folder"),
    ],
)
def test_file_and_report_do_not_hold_each_other(
    tmp_path: Path, file: str, out: str, complaint: str
) -> None:
    with pytest.raises(StepFailedError, match=complaint):
        check_file(tmp_path / file, tmp_path / out)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_leaves_nothing_and_is_said_once(
    tmp_path: Path, number: signal.Signals
) -> None:
    out = tmp_path / "new" / "deep" / "report"
    process = subprocess.Popen(
        [sys.executable, "-c", OUTER, TOOLS, INNER, TOOLS, out],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "writing\n"
    assert out.parent.is_dir()
    start = time.monotonic()
    process.send_signal(number)
    said, _ = process.communicate(timeout=60)
    assert process.returncode == 128 + number
    assert said.count("Interrupted.") == 1
    assert time.monotonic() - start < 30
    assert not list(tmp_path.iterdir())
