"""A real browser for the tests of the operator's page: the system's Chromium, driven by Playwright."""

import contextlib
import os
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, Playwright

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
WINDOWLESS = "chromium-headless-shell"  # draws the same, and has no window to draw: half the work
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
LOW = {"width": 1000, "height": 640}  # few pixels beside all panels
NICE = -5  # of a browser that drives: after the nodes, which have -10
SMALL = {"width": 640, "height": 480}  # few pixels, and no chart: where the picture does not matter


def installed(*names: str) -> str:
    """Return the path of a Chromium; a computer without one skips the test, CI fails."""
    for name in names:
        if path := shutil.which(name):
            return path
    reason = "no Chromium is installed: scripts/setup.sh test as root, or apt install chromium"
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)


@contextlib.contextmanager
def launched(playwright: Playwright) -> Iterator[Browser]:
    """A headless browser; it ends with the block."""
    path = installed(WINDOWLESS, *BROWSERS)
    browser = playwright.chromium.launch(executable_path=path, args=OPTIONS)
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


@contextlib.contextmanager
def launch_process(
    playwright: Playwright, profile: Path, *names: str
) -> Iterator[tuple[BrowserContext, Callable[[], list[int]]]]:
    """A browser that drives, or is killed or frozen: its first profile, and what gives its processes' pids.

    `names` are tried before the browsers that people use.

    It comes before other programs, where the user may ask for that: a page that waits for its turn lets the
    deadman go. Chromium sets the precedence of its threads itself, so it is asked for the session.
    """

    def processes() -> list[int]:
        found = Path("/proc").glob("[0-9]*/cmdline")
        return [int(path.parent.name) for path in found if str(profile).encode() in _bytes(path)]

    context = playwright.chromium.launch_persistent_context(
        profile, executable_path=installed(*names, *BROWSERS), args=OPTIONS, viewport=SMALL
    )
    try:
        for pid in processes()[:1]:
            with contextlib.suppress(OSError):
                Path(f"/proc/{pid}/autogroup").write_text(str(NICE), encoding="ascii")
        yield context, processes
    finally:
        for pid in processes():
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""
