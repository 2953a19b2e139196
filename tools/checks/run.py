# SPDX-License-Identifier: Apache-2.0
"""Runs the sessions of noxfile.py and counts what they found: ./paint test."""

from __future__ import annotations

import argparse
import json
import os
import re
import secrets
import shutil
import subprocess
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from common.environments import OWN
from common.processes import BUILD, ROOT, StepFailedError, describe, run_limited, run_program, say

RESULTS = BUILD / "results"  # of each session a JUnit file under its name
REPORT = RESULTS / "sessions.json"
SECONDS = 4 * 3600
KINDS = ("passed", "failed", "skipped")


class Case(NamedTuple):
    group: str
    name: str
    kind: str
    seconds: float
    reason: str = ""  # why it was skipped


def group(session: str, file: str = "") -> str:
    """A line of the table: a session, or one file of pytest's."""
    room, _, version = session.removesuffix(")").partition("(")
    name = room if file in ("", room) else f"{room} {file}"
    return f"{name}, Blender {version}" if version else name


def chosen_files(session: str, text: str) -> list[Path]:
    """Of the session's room those with the text in their line of the table."""
    room = session.partition("(")[0]
    files = sorted((ROOT / "tests" / room).glob("test_*.py"))
    return [file for file in files if text in group(session, file.stem.removeprefix("test_"))]


def chosen_sessions(nox: list[str | Path], text: str, everything: bool) -> list[str]:
    """Those in which something has the text in its line of the table; fuzzers run with --all."""
    listed = subprocess.run(
        [*nox, "--list-sessions", "--json"], capture_output=True, text=True, check=True
    )
    sessions = [session["session"] for session in json.loads(listed.stdout)]
    sessions = [name for name in sessions if everything or name != "fuzz"]
    chosen = [name for name in sessions if chosen_files(name, text)]
    return ["core", *chosen] if text in group("core") else chosen


def cases() -> Iterator[Case]:
    """All that ran, by the reports of nox, pytest and CTest."""
    for session in json.loads(REPORT.read_text())["sessions"]:
        [name] = session["signatures"] or [session["name"]]
        result = session["result"]
        found = list(_read(name, RESULTS / f"{name}.xml"))
        yield from found
        if result == "skipped":
            yield Case(group(name), "all", "skipped", 0, session["reason"])
        elif result != "success" and all(case.kind != "failed" for case in found):
            yield Case(group(name), "the session itself", "failed", session["duration"])


def _read(session: str, results: Path) -> Iterator[Case]:
    if not results.is_file():
        return
    for case in ElementTree.parse(results).iter("testcase"):
        file = re.match(r"tests\.\w+\.test_(\w+)", case.get("classname", ""))
        skipped = case.find("skipped")
        if case.find("failure") is not None or case.find("error") is not None:
            kind = "failed"
        else:
            kind = "passed" if skipped is None else "skipped"
        reason = "" if skipped is None else skipped.get("message", "")
        seconds = float(case.get("time", 0))
        yield Case(group(session, file[1] if file else ""), case.get("name", ""), kind, seconds,
                   reason)  # fmt: skip


def report(found: list[Case], note: str) -> None:
    """The table, what failed, what was skipped and why, and the counts on a line of their own."""
    say(f"\n{'group':<48}{'passed':>8}{'failed':>8}{'skipped':>8}{'seconds':>9}")
    for name in dict.fromkeys(case.group for case in found):
        inside = [case for case in found if case.group == name]
        counts = Counter(case.kind for case in inside)
        numbers = "".join(f"{counts[kind]:>8}" for kind in KINDS)
        say(f"{name:<48}{numbers}{sum(case.seconds for case in inside):>9.1f}")
    for case in found:
        if case.kind == "failed":
            say(f"Failed: {case.group}: {case.name}")
    skipped = Counter((case.group, case.reason) for case in found if case.kind == "skipped")
    for (name, reason), count in skipped.items():
        say(f"Skipped: {name}: {count}: {reason}")
    say(note)
    counts = Counter(case.kind for case in found)
    say(", ".join(f"{counts[kind]} {kind}" for kind in KINDS))


def main() -> int:
    parser = argparse.ArgumentParser(prog="paint test", description=__doc__)
    parser.add_argument("--all", action="store_true", help="the long tests too, in every Blender")
    parser.add_argument(
        "--sanitize",
        action="store_true",
        help="only the core's tests, built with the address and undefined sanitizers",
    )
    parser.add_argument("-k", metavar="TEXT", default="", help="only groups with TEXT in the name")
    asked = parser.parse_args()

    start = time.monotonic()
    shutil.rmtree(RESULTS, ignore_errors=True)
    RESULTS.mkdir(parents=True)
    nox = [OWN / "nox", "-f", ROOT / "noxfile.py"]
    sessions = ["sanitized"] if asked.sanitize else chosen_sessions(nox, asked.k, asked.all)
    if not sessions:
        raise StepFailedError(f"No group of tests has “{asked.k}” in its name.")
    seed = os.environ.setdefault("METALLIC_PAINT_TEST_SEED", str(secrets.randbits(32)))
    passed_on = [*["--all"] * asked.all, "-k", asked.k]
    code = run_limited(
        [*nox, "--report", REPORT, "--sessions", *sessions, "--", *passed_on], seconds=SECONDS
    )
    if not REPORT.is_file():
        raise StepFailedError(f"The tests did not come to their end ({describe(code)}).")
    found = list(cases())
    if not found:
        raise StepFailedError(f"Only --all runs tests of groups with “{asked.k}” in their name.")
    say(f"METALLIC_PAINT_TEST_SEED={seed} repeats the random draws of this run")
    minutes = f"{(time.monotonic() - start) / 60:.1f} minutes"
    report(
        found, minutes if asked.all else f"{minutes}; ./paint test --all runs the long tests too"
    )
    return 1 if any(case.kind == "failed" for case in found) else 0


if __name__ == "__main__":
    run_program(main)
