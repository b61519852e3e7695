"""The gallery: a page for every theorem of the library, and an index."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby
from pathlib import Path

from lmic import library
from lmic.files import write_whole
from lmic.pages.site import render
from lmic.pages.statement import cases_of, statement
from lmic.papers.cases import case_tables


def write_gallery(folder: Path, advance: Callable[[str], None] = lambda name: None) -> Path:
    """Write ``index.html`` and a page per theorem into the folder; returns the index."""
    tables = case_tables()
    statements = []
    for name in library.names():
        shown = statement(library.theorem(name))
        cases = cases_of(name, tables)
        write_whole(folder / f"{name}.html", render("theorem.html", title=shown.title, theorem=shown, cases=cases))
        statements.append(shown)
        advance(name)
    groups = [
        (group, list(members)) for group, members in groupby(statements, key=lambda shown: shown.name.partition(".")[0])
    ]
    index = folder / "index.html"
    write_whole(index, render("gallery.html", title="Theorems of lmic", groups=groups, count=len(statements)))
    return index
