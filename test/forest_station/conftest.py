"""A browser for all tests of a module: starting one takes a second."""

import pytest
from browser import launched
from page_stand_in import ADDRESS, serve_file
from playwright.sync_api import sync_playwright


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
    page.route(f"{ADDRESS}/web/**", serve_file)
    page.route(ADDRESS + "/", lambda route: route.fulfill(body="", content_type="text/html"))
    page.goto(ADDRESS + "/")
    yield lambda module, function, argument=None: page.evaluate(
        f"async (argument) => ({function})(await import('/web/{module}'), argument)", argument
    )
    page.close()
