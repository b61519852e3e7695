"""The gallery and the report: every theorem has its page, and the page holds what it should."""

from __future__ import annotations

from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
from click.testing import CliRunner

from lmic import library
from lmic.cli import main
from lmic.pages.gallery import write_gallery
from lmic.pages.site import render
from lmic.pages.statement import statement

VOID = {"meta", "img", "br", "link", "hr", "input"}


class Page(HTMLParser):
    """Tags as they open and close, links, sources and text."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []
        self.sources: list[str] = []
        self.ids: set[str] = set()
        self.tags: list[str] = []
        self.words = ""
        self.feed(path.read_text(encoding="utf-8"))
        assert not self.open, f"{self.open[-1]} is not closed"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        self.tags.append(tag)
        self.links += [found["href"] or ""] if "href" in found else []
        self.sources += [found["src"] or ""] if "src" in found else []
        self.ids |= {found["id"] or ""} if "id" in found else set()
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words += data


@pytest.fixture(scope="module")
def gallery(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    write_gallery(folder)
    return folder


@pytest.mark.parametrize("name", library.names())
def test_every_theorem_has_a_page_from_itself(name: str, gallery: Path) -> None:
    page, theorem = Page(gallery / f"{name}.html"), library.theorem(name)
    for text in (theorem.title, str(theorem.source), theorem.description.splitlines()[0], *theorem.data):
        assert text in page.words
    assert page.tags.count("math") >= len(theorem.lmis)
    assert "\\" not in page.words


def test_the_index_links_every_page(gallery: Path) -> None:
    links = Page(gallery / "index.html").links
    assert links == ["#content", *(f"{name}.html" for name in library.names())]
    assert all((gallery / link).is_file() for link in links[1:])


def test_what_a_theorem_says_is_escaped() -> None:
    hostile = replace(statement(library.theorem("standard.stability_discrete")), title="<script>alert(1)</script>")
    page = render("theorem.html", title=hostile.title, theorem=hostile, cases=[])
    assert "<script" not in page
    assert "&lt;script&gt;alert(1)" in page


def test_the_report_needs_no_other_file_and_holds_the_numbers(tmp_path: Path) -> None:
    answer = CliRunner().invoke(main, ["reproduce", "mustafa.example1.published", "-o", str(tmp_path)])
    assert answer.exit_code == 0, answer.output
    page = Page(tmp_path / "index.html")
    assert "script" not in page.tags
    assert all(source.startswith("data:image/png;base64,") for source in page.sources)
    assert all(link.startswith("#") and link[1:] in page.ids for link in page.links)
    text = (tmp_path / "index.md").read_text(encoding="utf-8")
    for words in (page.words, text):
        for wanted in ("0.1017399", "0.1017", "reproduced", "numpy"):
            assert wanted in words
    assert "math" in page.tags
    assert "sampling" in page.words


def test_a_figure_is_embedded(tmp_path: Path) -> None:
    answer = CliRunner().invoke(main, ["reproduce", "mustafa.example2.published", "-o", str(tmp_path)])
    assert answer.exit_code == 0, answer.output
    assert len(Page(tmp_path / "index.html").sources) == 2
    assert "![mustafa.example2.figure2](mustafa.example2.figure2.png)" in (tmp_path / "index.md").read_text("utf-8")
