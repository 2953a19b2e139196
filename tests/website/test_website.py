# SPDX-License-Identifier: Apache-2.0
"""The documents and the site that is made of them: links, pictures, nothing from elsewhere."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from common.processes import ROOT, StepFailedError
from website import build

SECONDS = 120


class Page(HTMLParser):
    """What a page names, and what a browser loads with it."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.pictures: list[tuple[str, str]] = []
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value or "" for name, value in attrs}
        self.anchors.add(values.get("id", ""))
        leads = tag == "a" or values.get("rel") in ("canonical", "next", "prev")
        if leads and "href" in values:
            self.links.append(values["href"])
        else:
            self.loaded += [values[name] for name in ("src", "href", "data") if name in values]
        if tag == "img":
            self.pictures.append((values["src"], values.get("alt", "")))


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("website") / "site"
    build.build(out)
    return out


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    return {file: Page(file) for file in sorted(site.rglob("*.html"))}


def html_of(site: Path, document: str) -> Path:
    path = site / document
    return path.with_name("index.html") if path.name == "README.md" else path.with_suffix(".html")


def test_every_document_is_a_page(site: Path) -> None:
    named = set(build.documents())
    assert len(named) == len(build.documents())
    assert {str(file.relative_to(ROOT)) for file in ROOT.glob("docs/**/*.md")} <= named
    for document in named:
        assert html_of(site, document).is_file(), document


def test_every_link_leads_somewhere(site: Path, pages: dict[Path, Page]) -> None:
    counted = 0
    for file, page in pages.items():
        if file.name == "404.html":  # served from any address, its links begin at the root
            continue
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme:
                continue
            target = file.parent / unquote(parts.path) if parts.path else file
            target = target / "index.html" if target.is_dir() else target
            assert target.resolve().is_relative_to(site.resolve()), (file, link)
            assert target.is_file(), (file, link)
            anchor = unquote(parts.fragment)
            assert not anchor or anchor in pages[target.resolve()].anchors, (file, link)
            counted += 1
    assert counted > 500


def test_links_of_the_sources_lead_somewhere() -> None:
    """Where GitHub shows the Markdown: also those that the site leaves out."""
    for document in build.documents():
        text = (ROOT / document).read_text(encoding="utf-8")
        for _, _, link in build.LINK.findall(text):
            name, _, _anchor = link.partition("#")
            if name and not urlsplit(link).scheme:
                assert ((ROOT / document).parent / name).exists(), (document, link)


def test_pictures_are_there_and_described(site: Path, pages: dict[Path, Page]) -> None:
    for document in build.documents():
        text = (ROOT / document).read_text(encoding="utf-8")
        file = html_of(site, document)
        assert len(pages[file].pictures) == len(re.findall(r"!\[", text)), document
        for source, words in pages[file].pictures:
            assert (file.parent / source).is_file(), (document, source)
            assert words, (document, source)


def test_no_page_loads_anything_from_elsewhere(site: Path, pages: dict[Path, Page]) -> None:
    for file, page in pages.items():
        assert page.loaded
        for source in page.loaded:
            assert not urlsplit(source).scheme, (file, source)
            assert not source.startswith("//"), (file, source)
    for sheet in site.rglob("*.css"):
        for source in re.findall(r"url\(\s*[\"']?([^)\"']+)|@import", sheet.read_text()):
            assert urlsplit(source).scheme in ("", "data"), (sheet, source)


def test_markdown_is_read_as_on_github(site: Path) -> None:
    """No list, table, line break or emphasis is left as the characters that make it."""
    for document in build.documents():
        body = html_of(site, document).read_text(encoding="utf-8")
        body = body.partition("<article")[2].partition("</article>")[0]
        body = re.sub(r"<(pre|code)\b.*?</\1>", "", body, flags=re.DOTALL)
        for left in (r"^\s*(<p>)?(-|\d+\.) ", r"^\s*(<p>)?\|", r"\\$", r"\*\*", r"\]\("):
            assert not (found := re.search(left, body, re.MULTILINE)), (document, left, found)


def test_the_search_knows_every_heading(site: Path) -> None:
    entries = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))
    titles = {entry["title"] for entry in entries["docs"]}
    for document in build.manual_pages():
        for head in re.findall(r"^#+ (.*)$", (ROOT / document).read_text("utf-8"), re.MULTILINE):
            assert any(head in title for title in titles), (document, head)


def test_the_search_runs_from_a_file(site: Path, tmp_path: Path) -> None:
    if not (browser := shutil.which("chromium")):
        pytest.skip("no chromium here")
    page = f"{site.as_uri()}/index.html?q=rest+position"
    done = subprocess.run(
        [browser, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path}",
         "--virtual-time-budget=20000", "--dump-dom", page],
        capture_output=True, text=True, timeout=SECONDS, check=True,
    )  # fmt: skip
    results = re.findall(r'href="([^"?]*)[^"]*" class="md-search-result__link"', done.stdout)
    assert f"{site.as_uri()}/docs/manual/animation.html" in results


def test_a_link_to_nothing_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for document in build.documents():
        (tmp_path / document).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / document).write_text((ROOT / document).read_text("utf-8"), "utf-8")
    (tmp_path / "README.md").write_text("# Home\n\n[not there](docs/absent.md)\n")
    monkeypatch.setattr(build, "ROOT", tmp_path)
    with pytest.raises(StepFailedError, match=r"the link docs/absent\.md leads nowhere"):
        build.stage(tmp_path / "staged")
