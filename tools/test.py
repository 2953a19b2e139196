# SPDX-License-Identifier: Apache-2.0
"""Runs every test there is: checks of form, the core, the bindings, renders in each Blender."""

from __future__ import annotations

import argparse
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

from checks import form
from common import environments
from common.processes import (
    BUILD,
    LOGS,
    ROOT,
    StepFailedError,
    describe,
    end_all,
    run_limited,
    run_program,
    run_step,
    say,
    tail,
)
from extension import build as extension

GROUP_SECONDS = 1800
FUZZ_RUNS = 60_000  # about 15 s
NO_TEST_COLLECTED = 5  # pytest's exit code
CORE_SHARDS = 2
# What only ./paint test --all runs: GoogleTests by their names, pytest's by their mark.
LONG_GOOGLETESTS = "-Long*:*.Long*:*/Long*"
NOT_LONG = "not long"
AT_ONCE = 2  # Blenders; most of a test's time is one thread compiling the shader
# GoogleTests in as many processes as result files: `sh -c RUN_SHARDS tests results...`. One process
# group, so that a time limit or Ctrl-C ends them all.
RUN_SHARDS = """
export GTEST_TOTAL_SHARDS=$# GTEST_SHARD_INDEX=0
for results; do
  "$0" --gtest_brief=1 --gtest_output="xml:$results" &
  pids="$pids $!"
  GTEST_SHARD_INDEX=$((GTEST_SHARD_INDEX + 1))
done
for pid in $pids; do wait "$pid" || code=$?; done
exit "${code:-0}"
"""


@dataclass
class Outcome:
    passed: int = 0
    failed: int = 0
    skipped: int = 0
    report: list[str] = field(default_factory=list)

    def fail(self, why: str) -> None:
        self.failed += 1
        self.report.append(why)


@dataclass(frozen=True)
class Group:
    name: str
    run: Callable[[], Outcome]
    beside: bool = False  # may run beside others


def check_groups() -> Iterator[Group]:
    environments.prepare_tool(environments.TOOLS)
    for name, command in form.commands().items():
        yield Group(f"check {name}", lambda name=name, command=command: _check(name, command))
    yield Group("check types", _check_types)
    yield Group("check licence lines", _check_licences)


def _check(name: str, command: Sequence[str | Path]) -> Outcome:
    return _run_whole(command, LOGS / f"check-{name.replace(' ', '-')}.log")


def _check_types() -> Outcome:
    environments.prepare_tool(environments.TYPES)
    return _check("types", form.types())


def _run_whole(command: Sequence[str | Path], log: Path) -> Outcome:
    """A program that is one test."""
    if run_limited(command, seconds=GROUP_SECONDS, log=log) == 0:
        return Outcome(passed=1)
    return Outcome(failed=1, report=[tail(log, 60)])


def _check_licences() -> Outcome:
    complaints = form.without_licence_line()
    return Outcome(failed=1, report=complaints) if complaints else Outcome(passed=1)


def core_group(folder: Path, sanitizers: str, everything: bool) -> Group:
    name = "core, sanitized" if sanitizers else "core"
    return Group(name, lambda: _test_core(folder, sanitizers, everything))


def _test_core(folder: Path, sanitizers: str, everything: bool) -> Outcome:
    with environments.alone():
        return _build_and_test_core(folder, sanitizers, everything)


def _build_and_test_core(folder: Path, sanitizers: str, everything: bool) -> Outcome:
    say("Building the core's tests…")
    options = ["-DMETALLIC_PAINT_WERROR=ON", f"-DMETALLIC_PAINT_SANITIZE={sanitizers}"]
    try:
        run_step(
            "Configuring the core's tests",
            ["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", *options],
            f"configure-{folder.name}.log",
        )
        run_step("Building the core's tests", ["cmake", "--build", folder], f"{folder.name}.log")
    except StepFailedError as error:
        return Outcome(failed=1, report=[str(error)])
    tests = folder / "tests" / "core" / "core_tests"
    results = [folder / f"results-{shard}.xml" for shard in range(CORE_SHARDS)]
    chosen = "*" if everything else LONG_GOOGLETESTS
    command = ["env", f"GTEST_FILTER={chosen}", "sh", "-c", RUN_SHARDS, tests, *results]
    return _run_tests(command, results, f"test-{folder.name}")


def fuzz_groups() -> Iterator[Group]:
    for file in sorted((ROOT / "tests" / "fuzz").glob("fuzz_*.py")):
        target = file.stem.removeprefix("fuzz_")
        yield Group(f"fuzz {target}", lambda file=file: _fuzz(file))


def _fuzz(file: Path) -> Outcome:
    """The same inputs in every run; what fails is kept where the log says."""
    environments.prepare_tool(environments.FUZZER)
    command = [environments.FUZZER.python, file, f"-runs={FUZZ_RUNS}", "-seed=1"]
    return _run_whole(command, LOGS / f"{file.stem.replace('_', '-')}.log")


def blender_groups(blenders: Sequence[environments.Blender], everything: bool) -> Iterator[Group]:
    """One process for each file and Blender: bpy holds one scene, and a crash takes all of it."""
    zipped = _Extension(blenders, everything)
    by_pytest = partial(_pytest, everything)
    rooms = (
        ("python", by_pytest, blenders),
        ("blender", by_pytest, blenders),
        ("extension", zipped.test, (*blenders, environments.BLENDER_BETWEEN)),
    )
    for room, test, used in rooms:
        for blender in used:
            for file in sorted((ROOT / "tests" / room).glob("test_*.py")):
                name = f"{room} {file.stem.removeprefix('test_')}, Blender {blender.version}"
                yield Group(name, partial(test, blender, file), beside=True)


class _Extension:
    """The zip that tests/extension installs, built when the first of them needs it."""

    def __init__(self, blenders: Sequence[environments.Blender], everything: bool) -> None:
        self._blenders, self._everything = blenders, everything
        self._lock = threading.Lock()
        self._problem: str | None = None  # empty: it is built

    def test(self, blender: environments.Blender, file: Path) -> Outcome:
        with self._lock:
            if self._problem is None:
                self._problem = self._build()
        if self._problem:
            return Outcome(failed=1, report=[self._problem])
        return _pytest(self._everything, blender, file)

    def _build(self) -> str:
        say("Building the extension…")
        try:
            extension.build(self._blenders, extension.TESTED, extension.own_platform())
        except StepFailedError as error:
            return str(error)
        return ""


def _pytest(everything: bool, blender: environments.Blender, file: Path) -> Outcome:
    name = f"test-{blender.version}-{file.parent.name}-{file.stem}"
    results = BUILD / "results" / f"{name}.xml"
    command = [blender.python, "-m", "pytest", "-v", f"--rootdir={ROOT}", "-c",
               ROOT / "pyproject.toml", "-m", "" if everything else NOT_LONG,
               f"--junit-xml={results}", file]  # fmt: skip
    return _run_tests(command, [results], name)


def _run_tests(command: Sequence[str | Path], results: Sequence[Path], name: str) -> Outcome:
    log = LOGS / f"{name}.log"
    for file in results:
        file.unlink(missing_ok=True)
    code = run_limited(command, seconds=GROUP_SECONDS, log=log)
    outcome = _count([file for file in results if file.is_file()])
    if outcome.failed:
        outcome.report.append(tail(log, 200))
    elif code not in (0, NO_TEST_COLLECTED):
        outcome.fail(
            f"Its process failed: {describe(code)}. The end of its output:\n{tail(log, 60)}"
        )
    elif not outcome.passed + outcome.skipped:
        outcome.fail("It ran no test.")
    return outcome


def _count(results: Sequence[Path]) -> Outcome:
    """Counts JUnit files, as both GoogleTest and pytest write them."""
    outcome = Outcome()
    for case in (case for file in results for case in ElementTree.parse(file).iter("testcase")):
        if case.find("failure") is not None or case.find("error") is not None:
            outcome.failed += 1
        elif case.find("skipped") is not None or case.get("status") == "notrun":
            outcome.skipped += 1
        else:
            outcome.passed += 1
    return outcome


def _timed(group: Group) -> tuple[Outcome, float]:
    start = time.monotonic()
    return group.run(), time.monotonic() - start


def run(groups: Sequence[Group]) -> bool:
    """Runs the groups, prints what failed and a table of counts, and says whether all is well."""
    rows = []

    def finish(group: Group, outcome: Outcome, seconds: float) -> None:
        say(f"{'FAILED' if outcome.failed else 'ok':>6}  {group.name} ({seconds:.1f} s)")
        for text in outcome.report:
            say(text)
        rows.append((group.name, outcome, seconds))

    for group in groups:
        if not group.beside:
            finish(group, *_timed(group))
    with ThreadPoolExecutor(AT_ONCE) as pool:
        running = {pool.submit(_timed, group): group for group in groups if group.beside}
        try:
            for done in as_completed(running):
                finish(running[done], *done.result())
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            end_all()
            raise

    say(f"\n{'group':<48}{'passed':>8}{'failed':>8}{'skipped':>8}{'seconds':>9}")
    for name, outcome, seconds in rows:
        counts = f"{outcome.passed:>8}{outcome.failed:>8}{outcome.skipped:>8}"
        say(f"{name:<48}{counts}{seconds:>9.1f}")
    passed, failed, skipped = (
        sum(getattr(outcome, kind) for _, outcome, _ in rows)
        for kind in ("passed", "failed", "skipped")
    )
    say(f"{passed} passed, {failed} failed, {skipped} skipped")
    return failed == 0


def main() -> int:
    parser = argparse.ArgumentParser(prog="paint test", description=__doc__)
    parser.add_argument(
        "--sanitize",
        action="store_true",
        help="only the core's tests, built with the address and undefined sanitizers",
    )
    parser.add_argument("--all", action="store_true", help="the long tests too")
    parser.add_argument("-k", metavar="TEXT", default="", help="only groups with TEXT in the name")
    arguments = parser.parse_args()

    if arguments.sanitize:
        groups = [core_group(BUILD / "sanitize", "address,undefined", arguments.all)]
    else:
        blenders = environments.prepare_blenders()
        environments.prepare(environments.BLENDER_BETWEEN, bindings=False)
        groups = [
            *check_groups(),
            core_group(BUILD / "tests", "", arguments.all),
            *fuzz_groups(),
            *blender_groups(blenders, arguments.all),
        ]
    groups = [group for group in groups if arguments.k in group.name]
    if not groups:
        raise StepFailedError(f"No group of tests has “{arguments.k}” in its name.")
    return 0 if run(groups) else 1


if __name__ == "__main__":
    run_program(main)
