"""The report of a reproduction: tables, figures and statements as one HTML file, and as Markdown."""

from __future__ import annotations

import os
import platform
from base64 import b64encode
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from lmic import library
from lmic.files import write_whole
from lmic.pages.site import render
from lmic.pages.statement import statement
from lmic.papers.reporting import COLUMNS, Reproduction

#: packages whose version decides a number
PACKAGES = ("lmic", "sympy", "numpy", "scipy", "clarabel", "python-flint", "control")


def write_report(papers: Sequence[Reproduction], folder: Path, seconds: float) -> list[Path]:
    """Write ``index.html``, which needs no other file, and ``index.md`` beside the figures."""
    used = dict.fromkeys(outcome.case.theorem for paper in papers for outcome in paper.outcomes.values())
    content = {
        "title": "lmic: the papers' numbers beside ours",
        "papers": papers,
        "columns": COLUMNS,
        "statements": [statement(library.theorem(name)) for name in used],
        "machine": machine(),
        "seconds": seconds,
        "made": datetime.now(UTC),
    }
    page, text = folder / "index.html", folder / "index.md"
    write_whole(page, render("report.html", **content, embedded=embedded))
    write_whole(text, render("report.md", **content))
    return [page, text]


def machine() -> dict[str, str]:
    """Where the numbers were computed, and with what."""
    found = {
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "Python": platform.python_version(),
    }
    return found | {name: version(name) for name in PACKAGES}


def embedded(image: Path) -> str:
    """A PNG as a data URI."""
    return f"data:image/png;base64,{b64encode(image.read_bytes()).decode('ascii')}"
