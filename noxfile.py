# SPDX-License-Identifier: Apache-2.0
"""The sessions of ./paint test, each with its results as JUnit XML in build/results.

The environments are those of the other commands too (tools/common/environments.py): nox makes none.
Of what --all runs, that which has passed on these sources is left out (tools/common/kept.py).
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

import nox

sys.path.insert(0, str(Path(__file__).parent / "tools"))

from checks.run import RESULTS, SEED, chosen_files, kept_of
from common import environments
from common.environments import BLENDER_BETWEEN, BLENDERS, FIRST_BLENDER, Blender
from common.kept import Kept
from common.processes import BUILD, ROOT, StepFailedError
from extension import build

nox.needs_version = ">=2026.10"
nox.options.default_venv_backend = "none"

AT_ONCE = "2"  # Blenders; most of a test's time is one thread compiling the shader
SECONDS = 900  # of one GoogleTest; pytest's limit is in pyproject.toml
NO_TEST_LEFT = 5  # pytest's exit code where the marks leave out all that -k chose
LONG = r"(^|[./])Long"  # a GoogleTest's suite or name

PLACES = {blender.version: blender for blender in (*BLENDERS, BLENDER_BETWEEN)}


def in_each(blenders: Iterable[Blender]) -> Callable:
    return nox.parametrize("version", [nox.param(b.version, id=b.version) for b in blenders])


def asked(session: nox.Session) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    parser.add_argument("--all", action="store_true")
    parser.add_argument("-k", metavar="TEXT", default="")
    return parser.parse_args(session.posargs)


@nox.session
def form(session: nox.Session) -> None:
    """Formatters, linters, types."""
    run_pytest(session, environments.FORM)


@nox.session
def core(session: nox.Session) -> None:
    run_core(session, "")


@nox.session(default=False)
def sanitized(session: nox.Session) -> None:
    """The core's tests under the address and undefined-behaviour sanitizers."""
    run_core(session, "address,undefined")


def run_core(session: nox.Session, sanitizers: str) -> None:
    choice = asked(session)
    folder = BUILD / ("sanitize" if sanitizers else "tests")
    every_file = "ON" if choice.all or sanitizers else "OFF"
    with environments.alone():
        session.run("cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "--log-level=WARNING",
                    "-DMETALLIC_PAINT_WERROR=ON", f"-DMETALLIC_PAINT_SANITIZE={sanitizers}",
                    f"-DMETALLIC_PAINT_LONG_TESTS={every_file}")  # fmt: skip
        session.run("cmake", "--build", folder, "--target", "core_tests")
        ctest = ["ctest", "--test-dir", folder, "--parallel", AT_ONCE,
                 "--timeout", str(SECONDS), "--output-on-failure", "--no-tests=ignore",
                 "--output-junit", RESULTS / f"{session.name}.xml"]  # fmt: skip
        if not choice.all:
            session.run(*ctest, "-E", LONG)
        elif not run_what_has_not_passed(ctest, kept_of(session.name)):
            session.error("CTest: see above.")


def run_what_has_not_passed(ctest: list[str | Path], kept: Kept) -> bool:
    """Keeps each test as soon as it has passed; whether all that ran did."""
    listed = subprocess.run([*ctest, "--show-only=json-v1"], capture_output=True, check=True)
    tests = enumerate(json.loads(listed.stdout)["tests"], 1)
    left = [str(number) for number, test in tests if test["name"] not in kept]
    if not left:
        return True
    command = [*ctest, "-I", ",".join(["0", "0", "0", *left])]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        for line in running.stdout:
            print(line, end="", flush=True)
            if found := re.search(r"Test +#\d+: (\S+) \.+ +Passed +([\d.]+) sec", line):
                kept.add(found[1], float(found[2]))
    return running.returncode == 0


@nox.session
@in_each(BLENDERS)
def python(session: nox.Session, version: str) -> None:
    """The bindings and what else needs no Blender, in the Python of each."""
    run_pytest(session, PLACES[version])


@nox.session
@in_each(BLENDERS)
def blender(session: nox.Session, version: str) -> None:
    run_pytest(session, PLACES[version])


@nox.session
@in_each(PLACES.values())
def extension(session: nox.Session, version: str) -> None:
    """The zip as a user installs it."""
    run_pytest(session, PLACES[version])


@nox.session
def website(session: nox.Session) -> None:
    """The documents and the site that is made of them."""
    run_pytest(session, environments.WEBSITE)


@nox.session
def fuzz(session: nox.Session) -> None:
    run_pytest(session, environments.FUZZER)


def run_pytest(session: nox.Session, place: Blender | environments.Environment) -> None:
    """The files of the session's room, two processes at once."""
    choice = asked(session)
    prepare(session, place, choice.all)
    chosen = ["-m", "not long"]
    if choice.all:
        os.environ["METALLIC_PAINT_KEPT"] = str(kept_of(session.name).file)
        chosen = [f"--hypothesis-seed={os.environ[SEED]}"]
    session.run(place.python, "-m", "pytest", "-q", "-c", ROOT / "pyproject.toml",
                f"--rootdir={ROOT}", "-n", AT_ONCE, "--dist", "worksteal", *chosen,
                f"--junit-xml={RESULTS / f'{session.name}.xml'}",
                *chosen_files(session.name, choice.k),
                success_codes=[0, NO_TEST_LEFT] if choice.k or choice.all else [0])  # fmt: skip


def prepare(
    session: nox.Session, place: Blender | environments.Environment, everything: bool
) -> None:
    try:
        if isinstance(place, environments.Environment):
            environments.prepare_tool(place)
        elif lack := environments.lack_of(place):
            session.skip(lack)
        else:
            environments.prepare(place, bindings=place != BLENDER_BETWEEN)
            if session.name.startswith("extension"):
                build_zip(everything)
    except StepFailedError as error:
        session.error(str(error))


def build_zip(everything: bool) -> None:
    """The zip that tests/extension installs, with the native module for each Blender's Python."""
    blenders = environments.prepare_blenders() if everything else [FIRST_BLENDER]
    build.build(FIRST_BLENDER, build.TESTED, build.own_platform(), build.own_wheels(blenders))
