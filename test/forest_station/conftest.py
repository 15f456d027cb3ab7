"""A browser for all tests of a module: starting one takes a second."""

import pytest
from browser import launched
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
