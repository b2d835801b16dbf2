"""Portraits of one map of each kind, and their pages."""

import shutil
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from matplotlib.figure import Figure

from cyclemap.collection import Portrait, portrait
from cyclemap.collection.portrait_curves import portrait_curves
from cyclemap.evidence import Theta0Pairs, measured_overlay
from cyclemap.maps import CircleMap, WrappedNormal, sample_staircase
from cyclemap.views.portrait_page import portrait_page
from tests.views.firefox import Firefox, firefox_path


def sawtooth() -> CircleMap:
    """Falls through zero by a jump at 2, from both sides of which orbits are drawn in."""
    return CircleMap(
        lambda theta: theta - 1.0 + 0.35 * np.mod(theta - 2.0, 2 * np.pi),
        lambda theta: np.full_like(theta, 1.35),
        breaks=(2.0,),
    )


MAPS = {
    "locked": CircleMap.arnold(0.01, 0.2),
    "rotating": CircleMap.arnold(0.02, 0.1),
    "jumping": sawtooth(),
}


@pytest.fixture(scope="session")
def drawn(loop_of) -> Callable[..., tuple[Portrait, Figure]]:
    """The portrait of one of the maps and its page, with or without data."""

    @cache
    def draw(kind: str, data: bool = False) -> tuple[Portrait, Figure]:
        found = portrait(loop_of(MAPS[kind]), cycles=200)
        theta = sample_staircase(MAPS[kind], WrappedNormal(0.02), 300, 1.0, seed=5).theta
        pairs = Theta0Pairs(theta[:-1], theta[1:], theta)
        measured = measured_overlay(pairs, found.map.turn) if data else None
        return found, portrait_page(found, portrait_curves(found), measured)

    return draw


def browser_path():
    """The Chromium of this machine, or None."""
    names = ("chromium", "chromium-browser", "google-chrome", "chrome")
    return next((found for name in names if (found := shutil.which(name))), None)


@pytest.fixture(scope="module")
def chromium():
    """A real Chromium."""
    if browser_path() is None:
        pytest.skip("no Chromium found: pages are not tested in a browser; install chromium")
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="playwright drives the browser; install it"
    )
    with playwright.sync_playwright() as driver:
        arguments = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
        browser = driver.chromium.launch(executable_path=browser_path(), args=arguments)
        yield browser
        browser.close()


@pytest.fixture
def open_page(chromium):
    """Open a page of a real browser: at last it fits windows wide and narrow, had no trouble, asked
    nothing outside.
    """
    pages, troubles, asked = [], [], []

    def opened(address, **options):
        page = chromium.new_page(viewport={"width": 1400, "height": 1000}, **options)
        pages.append(page)
        page.set_default_timeout(120_000)
        page.on("console", lambda message: troubles.append(message.text))
        page.on("pageerror", lambda error: troubles.append(str(error)))
        home = address.partition("#")[0] if address.startswith("http") else "file:"

        def note(request):
            if not request.url.startswith((home, "data:", "blob:")):
                asked.append(request.url)

        page.on("request", note)
        page.goto(address)
        return page

    yield opened
    for page in pages:
        for width in (1400, 420):
            page.set_viewport_size({"width": width, "height": 900})
            assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
        page.close()
    assert troubles == asked == []


@pytest.fixture(scope="module")
def firefox(tmp_path_factory):
    """A real Firefox without a network."""
    if firefox_path() is None:
        pytest.skip("no Firefox found: pages are not tested in it; install firefox")
    browser = Firefox(tmp_path_factory.mktemp("firefox"))
    yield browser
    browser.close()
