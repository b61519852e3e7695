"""A headless browser for the tests of pages, and what is asked of every page in it."""

from __future__ import annotations

import json
import os
import shutil
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)

#: elements that the keyboard must reach, in their order; what a closed <details> hides is not among them
REACHABLE = """
return [...document.querySelectorAll('a[href], summary, [tabindex="0"]')].filter(e => e.checkVisibility());
"""
#: elements that stick out of the window and stand in no box that scrolls
STICKING_OUT = """
const moves = e => ['auto', 'scroll'].includes(getComputedStyle(e).overflowX);
const scrolls = e => e && (moves(e) || scrolls(e.parentElement));
return [...document.querySelectorAll('main *')].filter(e => e.checkVisibility()
    && e.getBoundingClientRect().right > document.documentElement.clientWidth + 1 && !scrolls(e)).map(e => e.outerHTML);
"""
#: formulas and their cells without a size
EMPTY_FORMULAS = """
const sized = e => e.getBoundingClientRect().width > 0 && e.getBoundingClientRect().height > 0;
return [...document.querySelectorAll('math, mtable, mtr, mtd:not(:empty)')]
    .filter(e => e.checkVisibility() && !sized(e)).map(e => e.outerHTML);
"""
#: boxes that scroll and that the keyboard cannot, or that nobody announces
MUTE_BOXES = """
const mute = e => !(e.tabIndex === 0 && e.getAttribute('role') === 'region' && e.getAttribute('aria-label'));
return [...document.querySelectorAll('.wide')]
    .filter(e => e.checkVisibility() && e.scrollWidth > e.clientWidth && mute(e)).map(e => e.outerHTML);
"""
#: pictures that show nothing, or say nothing to those who do not see them
DEAD_PICTURES = """
return [...document.images].filter(e => !(e.complete && e.naturalWidth && e.alt)).map(e => e.src.slice(0, 80));
"""


def start() -> Any:
    """A browser that logs its console and its requests; the test is skipped where there is none."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    driver = shutil.which("chromedriver")
    if not (browser and driver):
        pytest.skip("there is no chromium with its chromedriver (Debian: chromium chromium-driver)")
    options = webdriver.ChromeOptions()
    options.binary_location = browser
    for flag in FLAGS:  # with no profile named, chromedriver makes an empty one and removes it again
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    os.environ.setdefault("SE_AVOID_STATS", "true")
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))


def show(browser: Any, page: Path, width: int) -> None:
    """Load a page in a window so wide, with empty logs."""
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.get("about:blank")
    browser.get_log("browser"), browser.get_log("performance")
    browser.get(page.resolve().as_uri())


def requests(browser: Any) -> list[str]:
    """Addresses that were asked for since the page was shown, but those inside it."""
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    sent = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    return [address for address in sent if not address.startswith("data:")]


def check_reading(browser: Any, page: Path, width: int) -> None:
    """Nothing is loaded, nothing complains, everything can be seen and nothing sticks out."""
    show(browser, page, width)
    assert requests(browser) == [page.resolve().as_uri()]
    assert browser.get_log("browser") == []
    assert browser.execute_script(STICKING_OUT) == []
    assert browser.execute_script("return document.documentElement.scrollWidth <= window.innerWidth")
    assert browser.execute_script(EMPTY_FORMULAS) == []
    assert browser.execute_script(DEAD_PICTURES) == []


def check_keyboard(browser: Any, page: Path, width: int) -> None:
    """Tab reaches every link, fold and scrolling box in order, first of all a link over the navigation."""
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.keys import Keys

    show(browser, page, width)
    wanted = browser.execute_script(REACHABLE)
    assert browser.execute_script(MUTE_BOXES) == []
    for number, element in enumerate(wanted):
        ActionChains(browser, duration=0).send_keys(Keys.TAB).perform()
        assert browser.switch_to.active_element == element, element.get_attribute("outerHTML")[:200]
        if number == 0:
            assert element.get_attribute("href").endswith("#content")
            assert element.rect["x"] >= 0, "the skip link stays out of sight"


def check_headings(browser: Any, page: Path) -> None:
    """One heading of the first level, and none that skips a level."""
    show(browser, page, 1200)
    script = "return [...document.querySelectorAll('h1,h2,h3,h4,h5,h6')].map(e => +e.tagName[1])"
    levels = browser.execute_script(script)
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(below <= above + 1 for above, below in pairwise(levels)), levels
