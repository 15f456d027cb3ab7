"""A browser for all tests of a module: starting one takes a second."""

import pytest
from browser import launched
from page_stand_in import ADDRESS, serve_file
from playwright.sync_api import Error, sync_playwright


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
