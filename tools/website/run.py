# SPDX-License-Identifier: Apache-2.0
"""Builds the manual and the documents beside it as a site that can be searched, from files too."""

from __future__ import annotations

import argparse
from pathlib import Path

from common import files
from common.environments import WEBSITE, prepare_tool
from common.processes import ROOT, TOOLS, StepFailedError, run_program, run_step, say

MARK = "sitemap.xml"  # in every site that MkDocs made


def check(out: Path) -> None:
    if why := files.obstacle(out):
        raise StepFailedError(f"--out {out}: cannot be written ({why}).")
    if out.is_symlink() or (out.exists() and not out.is_dir()):
        raise StepFailedError(f"--out {out}: not a folder.")
    if out.is_dir() and any(out.iterdir()) and not (out / MARK).is_file():
        raise StepFailedError(f"--out {out}: holds something else than a site.")


def main() -> int:
    parser = argparse.ArgumentParser(prog="paint manual --site", description=__doc__)
    parser.add_argument("--site", action="store_true", help="the site, not the manual's pictures")
    parser.add_argument(
        "--out", type=Path, default=ROOT / "out" / "site", metavar="DIR",
        help="folder for the site, which takes the place of the one there (out/site)",
    )  # fmt: skip
    out: Path = parser.parse_args().out
    check(out)
    prepare_tool(WEBSITE)
    with files.whole(out) as folder:
        run_step(
            "Building the site", [WEBSITE.python, TOOLS, "website.build", folder], "website.log"
        )
    say(f"{out / 'index.html'}")
    return 0


if __name__ == "__main__":
    run_program(main)
