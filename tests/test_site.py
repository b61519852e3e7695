"""The documentation site: it builds without a warning, and nothing public is missing in it."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from documents import ROOT
from sphinx.application import Sphinx

import lmic
from lmic import dsl, library
from lmic.cli import main

# what sphinx-click and MyST will have to change before a Sphinx to come
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::PendingDeprecationWarning")

PAGES = sorted(path.stem for path in (ROOT / "docs").glob("*.md"))
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


def test_the_site_builds_without_a_warning_and_nothing_is_missing(tmp_path: Path) -> None:
    """One test, since processes that share the tests would each build the site: as `make docs` does, strictly."""
    docs = str(ROOT / "docs")
    app = Sphinx(docs, docs, str(tmp_path / "html"), str(tmp_path / "trees"), "html", warningiserror=True, status=None)
    app.build()
    assert app.statuscode == 0
    every_public_name_is_described(app)
    every_command_is_described(app)
    every_theorem_is_linked(app)
    for name in PAGES:
        a_page_needs_no_network_and_its_links_lead_somewhere(name, app)
    if CHROMIUM is not None:
        a_browser_shows_the_page_without_complaint(CHROMIUM, "python", app)


def page(site: Sphinx, name: str) -> str:
    return (Path(site.outdir) / f"{name}.html").read_text(encoding="utf-8")


def every_public_name_is_described(site: Sphinx) -> None:
    described = site.env.get_domain("py").objects
    wanted = [f"lmic.{name}" for name in lmic.__all__] + [f"lmic.dsl.{name}" for name in dsl.__all__]
    assert [name for name in wanted if name not in described] == []


def every_command_is_described(site: Sphinx) -> None:
    text = page(site, "commands")
    for name, command in main.commands.items():
        assert f'id="lmic-{name}"' in text
        assert all(option.opts[0] in text for option in command.params if option.opts[0].startswith("--"))


def every_theorem_is_linked(site: Sphinx) -> None:
    links = re.findall(r'href="gallery/([^"]*)\.html"', page(site, "theorems"))
    assert links == library.names()
    assert all((Path(site.outdir) / "gallery" / f"{name}.html").is_file() for name in links)


def a_page_needs_no_network_and_its_links_lead_somewhere(name: str, site: Sphinx) -> None:
    text = page(site, name)
    loaded = re.findall(r'<(?:script|img|iframe|source)[^>]*src="([^"]*)"', text)
    loaded += re.findall(r'<link[^>]*rel="stylesheet"[^>]*href="([^"]*)"', text)
    assert [source for source in loaded if "//" in source] == []
    for target in loaded + re.findall(r'<a [^>]*href="([^"]*)"', text):
        file, _, anchor = target.partition("#")
        if "//" in target or target.startswith("mailto:"):
            continue
        path = Path(site.outdir) / file.partition("?")[0] if file else Path(site.outdir) / f"{name}.html"
        assert path.is_file(), target
        assert not anchor or f'id="{anchor}"' in path.read_text(encoding="utf-8"), target


def a_browser_shows_the_page_without_complaint(chromium: str, name: str, site: Sphinx) -> None:
    command = [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--dump-dom"]
    address = (Path(site.outdir) / f"{name}.html").as_uri()
    shown = subprocess.run([*command, address], capture_output=True, text=True, timeout=60, check=True)
    assert "<h1>" in shown.stdout
    assert "CONSOLE" not in shown.stderr
