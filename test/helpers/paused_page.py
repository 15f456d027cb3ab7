"""The operator's page before a stand-in of its server, with a clock that goes as far as a test lets it."""

from collections.abc import Callable

from browser import new_page
from page_stand_in import PageStandIn
from playwright.sync_api import Browser

from forest_station.operator.hands_message import Hands

PAUSED_S = 3600  # of the page's clock: later than a page takes to open
GAMEPAD = """
window.pads = [];
navigator.getGamepads = () => window.pads;
window.plugIn = (id, mapping, axes, buttons) => {
  const button = () => ({ pressed: false, value: 0 });
  const device = { id, index: window.pads.length, connected: true, mapping, axes: Array(axes).fill(0) };
  window.pads.push({ ...device, buttons: Array.from({ length: buttons }, button) });
};
"""


def opened(browser: Browser, viewport: dict[str, int]) -> PageStandIn:
    """Open the page, with gamepads of the test's own."""
    page, _ = new_page(browser, viewport)
    page.add_init_script(GAMEPAD)
    page.clock.install(time=0)
    met = PageStandIn(page)
    met.open()
    page.clock.pause_at(PAUSED_S)
    return met


def wait(met: PageStandIn, said: Callable[[Hands], bool]) -> Hands:
    """Let the page's time go on until it says something; return the message."""
    start = len(met.heard)
    for _ in range(100):
        met.page.clock.run_for(20)
        for hands in met.heard[start:]:
            if said(hands):
                return hands
    raise AssertionError(f"never said; last: {met.heard[-1:]}")
