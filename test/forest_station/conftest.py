"""A browser for all files that need one: starting it takes a second. Pages of it for all tests of a file."""

import contextlib
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

import pytest
from browser import DESKTOP, PHONE, launched
from page_stand_in import ADDRESS, PageStandIn, serve_file
from paused_page import opened
from playwright.sync_api import Browser, Error, Playwright, sync_playwright

_lives = contextlib.ExitStack()
_kept: dict[str, Any] = {}
_users: set[Path] = set()  # files with tests that need a browser


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Note which files need a browser."""
    _users.update(item.path for item in items if "playwright" in getattr(item, "fixturenames", ()))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(nextitem: pytest.Item | None) -> Generator[None, Any, Any]:
    """End the browser before a file that needs none: while it runs, nobody else can use asyncio."""
    try:
        return (yield)
    finally:
        if nextitem is None or nextitem.path not in _users:
            _kept.clear()
            _lives.close()


def _keep(name: str, made: contextlib.AbstractContextManager[Any]) -> Any:
    _kept[name] = _lives.enter_context(made)
    return _kept[name]


@pytest.fixture(scope="module")
def playwright() -> Any:
    """What starts browsers; there can be one at a time."""
    return _kept["playwright"] if "playwright" in _kept else _keep("playwright", sync_playwright())


@pytest.fixture(scope="module")
def browser(playwright: Playwright) -> Iterator[Browser]:
    """A headless Chromium; of a file's pages nothing is left to the next one."""
    running = _kept.get("browser")
    if running is None or not running.is_connected():
        running = _keep("browser", launched(playwright))
    yield running
    for context in running.contexts:
        context.close()


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
