# SPDX-License-Identifier: Apache-2.0
"""Builds the documents of this repository as a site: the same Markdown, by MkDocs with Material.

Runs in the environment of requirements/site.txt; ./paint manual --site prepares it.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import tempfile
from pathlib import Path

# The theme's makers ask on the console whether we know of the next MkDocs; ours is pinned.
os.environ["NO_MKDOCS_2_WARNING"] = "1"

from common.processes import ROOT, StepFailedError, run_program
from mkdocs.commands import build as mkdocs
from mkdocs.config import load_config
from mkdocs.exceptions import MkDocsException

SETTINGS = Path(__file__).with_name("mkdocs.yml")
ASSETS = ("iframe-worker.js", "narrow.css")  # mkdocs.yml names them
HOME = "README.md"
MANUAL = "docs/manual/README.md"  # links the manual's other pages, in their order

# Documents outside docs/manual, by the heading that they stand under in the menu.
PAGES = {
    "Seen and measured": {
        "Gallery": "docs/gallery/README.md",
        "In motion": "docs/motion/README.md",
        "What it costs": "docs/bench/README.md",
        "Speed and accuracy": "docs/accuracy/README.md",
    },
    "For those who know the paper": {
        "Symbols and formulas": "docs/model/README.md",
        "Closures": "docs/model/closures.md",
        "Fitted formulas": "docs/fits.md",
    },
    "Project": {
        "Changes": "CHANGELOG.md",
        "Contributing": "CONTRIBUTING.md",
    },
}

PICTURES = {".jpg", ".png", ".svg", ".webp"}
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")


def manual_pages() -> list[str]:
    """As the manual's first page links them."""
    links = [link for _, _, link in LINK.findall((ROOT / MANUAL).read_text(encoding="utf-8"))]
    folder = Path(MANUAL).parent
    return [MANUAL, *dict.fromkeys(str(folder / link) for link in links if "/" not in link)]


def menu() -> list[dict]:
    """MkDocs' nav: the manual's pages are called by their own headings."""
    return [
        {"What it is": HOME},
        {"Manual": [{"Overview": MANUAL}, *manual_pages()[1:]]},
        *({head: [{name: page} for name, page in pages.items()]} for head, pages in PAGES.items()),
    ]


def documents() -> list[str]:
    return [HOME, *manual_pages(), *(page for pages in PAGES.values() for page in pages.values())]


def stage(folder: Path) -> None:
    """The documents and their pictures in `folder`, where they lie in the repository."""
    (folder / "assets").mkdir(parents=True)
    for name in ASSETS:
        shutil.copy(Path(__file__).with_name(name), folder / "assets")
    pages = documents()
    for page in pages:

        def lead(match: re.Match[str], page: str = page) -> str:
            """The link; of one to a file that the site does not hold, its words."""
            mark, words, link = match.groups()
            name = link.partition("#")[0]
            if not name or ":" in name:
                return match[0]
            target = Path(os.path.normpath(Path(page).parent / name))
            if not (ROOT / target).exists():
                raise StepFailedError(f"{page}: the link {link} leads nowhere.")
            if target.suffix in PICTURES:
                (folder / target).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(ROOT / target, folder / target)
            elif str(target) not in pages:
                return mark + words
            return match[0]

        text = LINK.sub(lead, (ROOT / page).read_text(encoding="utf-8"))
        (folder / page).parent.mkdir(parents=True, exist_ok=True)
        (folder / page).write_text(text, encoding="utf-8")


def build(out: Path) -> None:
    """The site in the new folder `out`; whatever MkDocs warns of is an error."""
    with tempfile.TemporaryDirectory() as folder:
        stage(Path(folder))
        try:
            mkdocs.build(load_config(
                str(SETTINGS), docs_dir=folder, site_dir=str(out), nav=menu(), strict=True
            ))  # fmt: skip
        except MkDocsException as error:
            raise StepFailedError(f"The site could not be built: {error}") from error


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("out", type=Path)
    build(parser.parse_args().out)
    return 0


if __name__ == "__main__":
    run_program(main)
