"""A real browser for the tests of the operator's page: the system's Chromium, driven by Playwright."""

import contextlib
import os
import shutil
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

NAMES = ("chromium", "chromium-browser", "google-chrome")
# Root needs --no-sandbox; without a graphics card SwiftShader draws; the rest keeps it off the network.
OPTIONS = (
    "--no-sandbox",
    "--disable-gpu",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
DESKTOP = {"width": 1600, "height": 900}
PHONE = {"width": 390, "height": 844}


def installed() -> str:
    """Return the path of a Chromium; a computer without one skips the test, CI fails."""
    for name in NAMES:
        if path := shutil.which(name):
            return path
    reason = "no Chromium is installed: scripts/setup.sh test as root, or apt install chromium"
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)


@contextlib.contextmanager
def launched() -> Iterator[Browser]:
    """A headless browser; it ends with the block."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=installed(), args=OPTIONS)
        try:
            yield browser
        finally:
            browser.close()


def new_page(browser: Browser, viewport: dict[str, int] = DESKTOP) -> tuple[Page, list[str]]:
    """Return a page in a profile of its own, and the list that its errors go into."""
    page = browser.new_context(viewport=viewport, has_touch=viewport is PHONE).new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda line: errors.append(line.text) if line.type == "error" else None)
    return page, errors
