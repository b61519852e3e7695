"""Every kind of page in a real browser: it shows what it holds, on a phone too, to eyes and to the keyboard."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import browser_tools as tools
import pytest
from click.testing import CliRunner

import lmic
from lmic import library
from lmic.analysis.sampling import cover
from lmic.cli import main
from lmic.pages.gallery import write_gallery
from lmic.pages.site import render
from lmic.papers.cases import case_tables
from lmic.relax.relax import Relaxation

PAGES = ("filter", "sampled", "norm", "notebook", "reproduction", "gallery", "theorem", "benchmarks")
#: those that show formulas
FORMULAS = ("filter", "sampled", "norm", "notebook", "reproduction", "theorem")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    driver = tools.start()
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def pages(browser: Any, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """One page of every kind, by name."""
    folder = tmp_path_factory.mktemp("pages")
    found = {name: folder / f"{name}.html" for name in PAGES}
    root = library.root()
    filtered = lmic.run(
        lmic.compile(
            library.theorem("peixoto2025.theorem1"), lmic.read_plant(root / "peixoto2025/example1.toml"), {"eps": 50}
        )
    )
    lmic.report(filtered, file=found["filter"])
    plant = lmic.read_plant(root / "mustafa/example1.toml")
    gridded = Relaxation(grid={"h": cover(plant).grid})
    sampled = lmic.run(lmic.compile(library.theorem("mustafa.theorem3"), plant, relaxation=gridded))
    lmic.report(sampled, file=found["sampled"])
    constant = lmic.Plant.polytopic("rho", A=[[0.5, 0.1], [0, 0.3]], B=[[1], [1]], C=[[1, 0]], D=[[0]])
    norm = lmic.run(lmic.compile(library.theorem("standard.h2_discrete"), constant))
    lmic.report(norm, file=found["norm"])
    shown = "".join(one._repr_html_() for one in (filtered.theorem, filtered.problem, filtered))
    body = f'<h1>cell</h1><main id="content"><h2>A</h2><h3>B</h3>{shown}</main>'
    found["notebook"].write_text(f'<!DOCTYPE html><html lang="en"><meta charset="utf-8"><body>{body}', "utf-8")
    answer = CliRunner().invoke(main, ["reproduce", "mustafa.example2.published", "-o", str(folder)])
    assert answer.exit_code == 0, answer.output
    found["reproduction"] = folder / "index.html"
    site = tmp_path_factory.mktemp("site")
    found["gallery"], found["theorem"] = write_gallery(site), site / f"{case_tables()[0].cases[0].theorem}.html"
    found["benchmarks"].write_text(benchmarks(), "utf-8")
    return found


def benchmarks() -> str:
    """The page of benchmarks with made-up times."""
    row = {"series": "S1 Theorem 3", "size": 100, "lmis": 202, "lmic": {"first": {"cpu": 0.1}}}
    tools = {name: {"first": {"cpu": 10.0}, "ratio": 100.0} for name in ("CVXPY", "PICOS")}
    return render(
        "benchmarks.html",
        title="lmic: how long it takes",
        found={
            "made": "today",
            "mode": "quick",
            "load": [0.5],
            "ratios": [("compiling the same problem, CVXPY over lmic", "100", "at least 20")],
            "compared": [row | tools | {"same": True, "optimum": {"lmic": 1.0}}],
            "machine": {"cores": "2"},
        },
        plots=[],
        proofs=[{"what": "case", "solve": 1, "certify": 2, "verify": 3, "ratio": 2, "standing": "certified"}],
    )


@pytest.mark.parametrize("width", [1200, 400])
@pytest.mark.parametrize("name", PAGES)
def test_everything_is_seen_and_nothing_is_loaded(name: str, width: int, pages: dict[str, Path], browser: Any) -> None:
    tools.check_reading(browser, pages[name], width)
    if name in FORMULAS:
        assert browser.execute_script("return document.querySelectorAll('math mtable mtd').length") > 1


@pytest.mark.parametrize("name", [name for name in PAGES if name != "notebook"])
def test_the_keyboard_reaches_everything_in_order(name: str, pages: dict[str, Path], browser: Any) -> None:
    tools.check_keyboard(browser, pages[name], 400)
    tools.check_headings(browser, pages[name])


def test_a_wide_matrix_scrolls_in_its_own_box(pages: dict[str, Path], browser: Any) -> None:
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys

    tools.show(browser, pages["filter"], 400)
    box = browser.find_element(By.CSS_SELECTOR, "[aria-label='block matrix performance']")
    assert box.get_property("scrollWidth") > 2 * box.get_property("clientWidth")
    browser.execute_script("arguments[0].focus()", box)
    box.send_keys(Keys.END)
    for _ in range(5):
        box.send_keys(Keys.ARROW_RIGHT)
    browser.execute_async_script("setTimeout(arguments[0], 300)")  # scrolling is smooth
    assert box.get_property("scrollLeft") > 0
    assert browser.execute_script("return window.scrollX") == 0


def test_the_page_is_dark_where_the_reader_asks(pages: dict[str, Path], browser: Any) -> None:
    script = "return getComputedStyle(document.body).backgroundColor"
    shades = {}
    for scheme in ("light", "dark"):
        wish = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", wish)
        tools.show(browser, pages["filter"], 400)
        shades[scheme] = sum(map(int, browser.execute_script(script).removeprefix("rgb(").rstrip(")").split(",")))
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    assert shades["dark"] < 150
    assert shades["light"] > 600


FAULTS = {
    "a request": ("<img alt='a' src='https://example.invalid/a.png'>", tools.check_reading),
    "an error": ("<script>throw new Error('broken')</script>", tools.check_reading),
    "too wide": ("<p style='width: 900px'>wide</p>", tools.check_reading),
    "an empty formula": ("<math style='display: block; width: 0'></math>", tools.check_reading),
    "a mute picture": ("<img src='data:image/gif;base64,R0lGODlhAQABAAAAACw='>", tools.check_reading),
    "no way by keyboard": ("<a href='#content' tabindex='-1'>x</a>", tools.check_keyboard),
    "a mute box": ("<div class='wide'><p style='width: 900px'>wide</p></div>", tools.check_keyboard),
    "a skipped heading": ("<h4>deep</h4>", lambda browser, page, width: tools.check_headings(browser, page)),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_the_checks_see_a_fault(fault: str, tmp_path: Path, browser: Any) -> None:
    body, check = FAULTS[fault]
    text = render("gallery.html", title="faulty", groups=[], count=0)
    page, whole = tmp_path / "faulty.html", tmp_path / "whole.html"
    whole.write_text(text, "utf-8")
    check(browser, whole, 400)
    page.write_text(text.replace("</main>", f"{body}</main>"), "utf-8")
    with pytest.raises(AssertionError):
        check(browser, page, 400)
