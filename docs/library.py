"""What the site takes from the theorem library: the gallery, the list of its pages, and the papers' report."""

from __future__ import annotations

import shutil
from itertools import groupby
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from lmic.index import Entry, entries
from lmic.pages.gallery import write_gallery

ROOT = Path(__file__).parent.parent
#: where the gallery and the report stand in the site, beside the pages that list them
GALLERY, REPORTS = "gallery", "reports"


class Theorems(SphinxDirective):
    """A list of all theorems, each with a link to its page in the gallery."""

    def run(self) -> list[nodes.Node]:
        """The list, with one heading for each group of the library."""
        found: list[nodes.Node] = []
        for group, members in groupby(entries(), key=lambda entry: entry.name.partition(".")[0]):
            listed = nodes.bullet_list("", *(nodes.list_item("", _line(entry)) for entry in members))
            found += [nodes.rubric("", group), listed]
        return found


class Reports(SphinxDirective):
    """A link to the report of the papers' numbers, where `make reproduce` has made one."""

    def run(self) -> list[nodes.Node]:
        """One paragraph."""
        if not (ROOT / REPORTS / "index.html").is_file():
            return [nodes.paragraph(text="This copy of the site was built without a report; make one first.")]
        return [nodes.paragraph("", "", _link("The report of this copy of the site", f"{REPORTS}/index.html"))]


def _line(entry: Entry) -> nodes.paragraph:
    link = _link(entry.title, f"{GALLERY}/{entry.name}.html")
    return nodes.paragraph("", "", link, nodes.Text(f" ({entry.source.short}) "), nodes.literal(text=entry.name))


def _link(text: str, target: str) -> nodes.reference:
    return nodes.reference("", text, refuri=target, internal=True)


def _copy(app: Sphinx, failure: Exception | None) -> None:
    """Put the gallery and the report beside the pages."""
    if failure or app.builder.name != "html":
        return
    folder = Path(app.outdir)
    (folder / GALLERY).mkdir(exist_ok=True)
    write_gallery(folder / GALLERY)
    if (ROOT / REPORTS / "index.html").is_file():
        shutil.copytree(ROOT / REPORTS, folder / REPORTS, dirs_exist_ok=True)


def _link_to_the_readme(app: Sphinx, page: str, source: list[str]) -> None:
    """On the site the README is the first page."""
    source[0] = source[0].replace("(../README.md)", "(index.md)")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    app.add_directive("theorems", Theorems)
    app.add_directive("reports", Reports)
    app.connect("source-read", _link_to_the_readme)
    app.connect("build-finished", _copy)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
