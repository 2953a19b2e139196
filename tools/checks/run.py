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
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from common.environments import OWN
from common.kept import Kept, keep
from common.processes import BUILD, ROOT, StepFailedError, describe, run_limited, run_program, say

RESULTS = BUILD / "results"  # of each session a JUnit file under its name
REPORT = RESULTS / "sessions.json"
SECONDS = 4 * 3600
KINDS = ("passed", "failed", "skipped")
SEED = "METALLIC_PAINT_TEST_SEED"  # of the random draws, in the environment
GATE = ("form", "core", "python(4.5)", "blender(4.5)", "extension(4.5)")  # --all has the rest


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
    """Those in which something has the text in its line of the table."""
    listed = subprocess.run(
        [*nox, "--list-sessions", "--json"], capture_output=True, text=True, check=True
    )
    sessions = [session["session"] for session in json.loads(listed.stdout)]
    return [
        name
        for name in sessions
        if (everything or name in GATE)
        and (text in group("core") if name == "core" else chosen_files(name, text))
    ]


def kept_of(session: str, *, again: bool = False) -> Kept:
    """What has passed of the session, with the seconds that it took, by these draws."""
    room = session.partition("(")[0]
    return keep(f"tests, {session}", again=again, room=room, seed=os.environ[SEED])


def seed_of_all(again: bool) -> str:
    """New with --again and where the sources have changed: a run cut short keeps its draws."""
    kept = keep("seed", again=again)
    if SEED not in kept:
        kept.add(SEED, str(secrets.randbits(32)))
    return kept[SEED]


def cases(before: Mapping[str, Mapping[str, float]]) -> Iterator[Case]:
    """All that ran, by the reports of nox, pytest and CTest, and what had passed before."""
    for session in json.loads(REPORT.read_text())["sessions"]:
        [name] = session["signatures"] or [session["name"]]
        result = session["result"]
        found = list(_read(name, RESULTS / f"{name}.xml"))
        yield from found
        for test, seconds in before.get(name, {}).items():
            file = re.match(r"tests/\w+/test_(\w+)", test)
            yield Case(group(name, file[1] if file else ""), test, "passed", seconds)
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
    parser.add_argument(
        "--again", action="store_true", help="with --all: also what has passed on these sources"
    )
    asked = parser.parse_args()

    start = time.monotonic()
    shutil.rmtree(RESULTS, ignore_errors=True)
    RESULTS.mkdir(parents=True)
    nox = [OWN / "nox", "-f", ROOT / "noxfile.py"]
    sessions = ["sanitized"] if asked.sanitize else chosen_sessions(nox, asked.k, asked.all)
    if not sessions:
        raise StepFailedError(f"No group of tests has “{asked.k}” in its name.")
    before = {}
    if asked.all:
        os.environ.setdefault(SEED, seed_of_all(asked.again))
        before = {session: dict(kept_of(session, again=asked.again)) for session in sessions}
    passed_on = [*["--all"] * asked.all, "-k", asked.k]
    code = run_limited(
        [*nox, "--report", REPORT, "--sessions", *sessions, "--", *passed_on], seconds=SECONDS
    )
    if not REPORT.is_file():
        raise StepFailedError(f"The tests did not come to their end ({describe(code)}).")
    found = list(cases(before))
    if not found:
        raise StepFailedError(f"Only --all runs tests of groups with “{asked.k}” in their name.")
    note = f"{(time.monotonic() - start) / 60:.1f} minutes"
    if asked.all:
        say(f"{SEED}={os.environ[SEED]} repeats the random draws of this run")
        if count := sum(map(len, before.values())):
            note += f"; {count} tests had passed on these sources before, --again runs them too"
    else:
        note += "; ./paint test --all runs the long tests too"
    report(found, note)
    return 1 if any(case.kind == "failed" for case in found) else 0


if __name__ == "__main__":
    run_program(main)
