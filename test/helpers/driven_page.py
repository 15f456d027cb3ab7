"""The operator's page in a browser with a hand that does what the page says, and the crane that it moves."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any, NamedTuple

from playwright.sync_api import Page

MET_S = 60.0
SMALL_STEP = 0.05  # [m] of the drawn tip that nobody takes for a standing crane
GAMEPAD = """
  const buttons = Array.from({ length: 17 }, () => ({ pressed: false, value: 0 }));
  const device = { index: 0, id: "scripted", connected: true, mapping: "standard", timestamp: 0 };
  window.pad = { ...device, axes: [0, 0, 0, 0], buttons };
  navigator.getGamepads = () => [window.pad];
  window.shoulder = (pressed) => (window.pad.buttons[4] = { pressed, value: Number(pressed) });
"""


class Hand(NamedTuple):
    """What a person does to drive; each a function of the page."""

    hold: Callable[[Page], Any]  # the deadman
    move: Callable[[Page], Any]
    let_go: Callable[[Page], Any]  # of everything


def key(name: str) -> Hand:
    """A key, with the deadman's."""
    return Hand(
        lambda page: page.keyboard.down("ShiftLeft"),
        lambda page: page.keyboard.down(name),
        lambda page: (page.keyboard.up(name), page.keyboard.up("ShiftLeft")),
    )


def _pull(page: Page) -> None:
    """Take the left stick, and pull it back."""
    box = page.locator("#left_stick").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + 0.3 * box["height"], steps=3)


STICK = Hand(
    lambda page: page.keyboard.down("ShiftLeft"),
    _pull,
    lambda page: (page.mouse.up(), page.keyboard.up("ShiftLeft")),
)
PAD = Hand(
    lambda page: page.evaluate("() => shoulder(true)"),
    lambda page: page.evaluate("() => (window.pad.axes[0] = 0.6)"),  # the browser's sign: right
    lambda page: page.evaluate("() => { shoulder(false); window.pad.axes[0] = 0; }"),
)


class DrivenPage:
    """A page of the station.

    Args:
        page: that is to be opened.
        crane: a running graph with a station, and ears in it.
    """

    def __init__(self, page: Page, crane: Any) -> None:
        self.page, self.crane = page, crane

    def open(self) -> None:
        """Open the page, and wait until it draws the live crane."""
        self.page.add_init_script(GAMEPAD)
        self.page.goto(self.crane.address)
        self.page.wait_for_selector("body[data-link=live]")
        self.wait(lambda: all(map(math.isfinite, self.tip())))

    def wait(self, condition: Callable[[], Any]) -> None:
        """Wait until a condition holds, at most `MET_S`; the crane's topics are read meanwhile."""
        end = time.monotonic() + MET_S
        while not condition():
            assert time.monotonic() < end, self.page.inner_text("body")
            time.sleep(0.01)
            self.crane.ears.read()

    def tip(self) -> list[float]:
        """Return where the tip is drawn [m]; NaN before the first picture."""
        return self.page.evaluate("() => document.getElementById('scene').tipPosition?.() ?? [NaN]")

    def take_seat(self) -> None:
        """Ask for the seat until it is had: who left it without a word keeps it for a while."""
        self.wait(self._sits)
        self.crane.ears.forget()

    def drive(self, hand: Hand, condition: Callable[[], Any] | None = None) -> None:
        """Do what the page says until a condition holds, by default that the crane is driven."""
        condition = condition or self.crane.ears.driven
        self.wait(lambda: self._obey(hand) or condition())

    def _sits(self) -> bool:
        if self.page.text_content("#seat .driver") == "You drive":
            return True
        self.page.evaluate("() => document.querySelector('#seat .urgent')?.click()")
        return False

    def _obey(self, hand: Hand) -> None:
        """Do the next thing: a busy computer may make the deadman let go at any time."""
        state, why = self.page.evaluate(
            """() => [document.querySelector("#seat .deadman").dataset.state,
                      document.querySelector("#message p").textContent]"""
        )
        if "et go of" in why:  # it may begin the sentence
            hand.let_go(self.page)
        elif state == "ready":
            hand.let_go(self.page)
            hand.hold(self.page)
        elif state == "held":
            hand.move(self.page)
