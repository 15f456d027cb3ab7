"""A browser, and pages of it, for all tests of a module: starting one takes a second."""

from collections.abc import Iterator

import pytest
from browser import DESKTOP, PHONE, launched
from page_stand_in import ADDRESS, PageStandIn, serve_file
from paused_page import opened
from playwright.sync_api import Browser, Error, sync_playwright


@pytest.fixture(scope="module")
def playwright():
    """What starts browsers; there can be one at a time."""
    with sync_playwright() as running:
        yield running


@pytest.fixture(scope="module")
def browser(playwright):
    """A headless Chromium."""
    with launched(playwright) as running:
        yield running


@pytest.fixture(scope="module")
def js(browser):
    """Calls an arrow function with a module of the page, and with an argument."""
    page = browser.new_page()
    missing = []

    def serve(route):
        if not serve_file(route):
            missing.append(route.request.url.removeprefix(ADDRESS))

    def call(module, function, argument=None):
        missing.clear()
        script = f"async (argument) => ({function})(await import('/web/{module}'), argument)"
        try:
            return page.evaluate(script, argument)
        except Error:
            if missing:
                pytest.fail(f"the page has no file {', '.join(missing)}")
            raise

    page.route(f"{ADDRESS}/web/**", serve)
    page.route(ADDRESS + "/", lambda route: route.fulfill(body="", content_type="text/html"))
    page.goto(ADDRESS + "/")
    yield call
    page.close()


@pytest.fixture(scope="module")
def desktop(browser: Browser) -> PageStandIn:
    """The page for all tests: to open one costs more than they do."""
    return opened(browser, DESKTOP)


@pytest.fixture(scope="module")
def phone(browser: Browser) -> PageStandIn:
    """The page on a phone."""
    return opened(browser, PHONE)


@pytest.fixture
def met(desktop: PageStandIn) -> PageStandIn:
    """The page at rest."""
    desktop.page.evaluate("pads.length = 0")
    desktop.rest()
    return desktop


@pytest.fixture
def sized(met: PageStandIn, request: pytest.FixtureRequest) -> Iterator[tuple[int, int]]:
    """The page in a window of another size [px]."""
    before = met.page.viewport_size
    assert before is not None
    width, height = request.param
    met.page.set_viewport_size({"width": width, "height": height})
    yield width, height
    met.page.set_viewport_size(before)
