"""The operator's page in a real browser: it shows the crane, drives it, and stops it when the browser ends.

The real station, controller, valve driver and simulator; the page in Chromium.
"""

import contextlib
import math
import os
import re
import signal
from collections.abc import Iterator

import pytest
from browser import SMALL, WINDOWLESS, launch_process, new_page
from driven_page import PAD, SMALL_STEP, STICK, DrivenPage, Hand, key

LEFT, RIGHT = key("a"), key("d")
X, Y = 0, 1
HEARD = 25  # messages of /joy: half a second


@pytest.fixture(scope="module")
def browser(playwright, tmp_path_factory):
    """A browser that comes before the host's other programs."""
    with launch_process(playwright, tmp_path_factory.mktemp("profile"), WINDOWLESS) as (context, _):
        yield context.browser


@contextlib.contextmanager
def opened_page(browser, crane) -> Iterator[DrivenPage]:
    """The station's page in a profile of its own; nothing may go wrong in it."""
    page, errors = new_page(browser, SMALL)
    driven = DrivenPage(page, crane)
    driven.open()
    yield driven
    page.context.close()
    assert errors == []


@pytest.fixture(scope="module")
def opened(browser, crane) -> Iterator[DrivenPage]:
    """One page for all tests."""
    with opened_page(browser, crane) as page:
        yield page


@pytest.fixture
def other(browser, crane) -> Iterator[DrivenPage]:
    """A second browser's page, which looks on."""
    with opened_page(browser, crane) as page:
        yield page


@pytest.fixture
def driver(opened) -> Iterator[DrivenPage]:
    """A page that has the seat; in the end nothing is pressed, and the crane stands."""
    opened.take_seat()
    yield opened
    for hand in (LEFT, RIGHT, STICK, PAD):
        hand.let_go(opened.page)
    opened.wait(opened.crane.ears.at_rest)


def assert_nothing_moves(crane, page):
    """What the page does from now on moves nothing."""
    crane.ears.forget()
    page.wait(lambda: len(crane.ears.joy) > HEARD)
    assert not any(joy.held for joy in crane.ears.joy)
    assert not any(any(values) for _, values in crane.ears.voltages)


def test_the_page_shows_the_crane_as_it_stands(crane, opened):
    told = opened.page.evaluate("() => fetch('/scene.json').then((answer) => answer.json())")
    assert told["machine"] == opened.page.get_attribute("#scene", "data-machine") == "c180_hoses"
    opened.wait(lambda: math.dist(opened.tip(), crane.ears.tip()) < SMALL_STEP)


@pytest.mark.parametrize(
    ("hand", "axis", "sign"),
    [(STICK, X, -1), (LEFT, Y, 1), (PAD, Y, -1)],
    ids=["stick", "key", "gamepad"],
)
def test_a_hand_moves_the_drawn_crane_while_the_deadman_is_held(
    crane, driver, hand: Hand, axis: int, sign: int
):
    hand.move(driver.page)
    assert_nothing_moves(crane, driver)
    hand.let_go(driver.page)
    before = driver.tip()[axis]
    driver.drive(hand, lambda: sign * (driver.tip()[axis] - before) > SMALL_STEP)
    hand.let_go(driver.page)
    driver.wait(crane.ears.at_rest)


@pytest.mark.parametrize("way", ["click", "Escape", " "], ids=["click", "escape", "space"])
def test_an_emergency_stop_is_one_click_or_key_away(crane, driver, way):
    page = driver.page
    driver.drive(RIGHT)
    page.click("#emergency_stop .stop") if way == "click" else page.keyboard.press(way)
    driver.wait(crane.ears.at_rest)
    page.wait_for_selector("#message :text('STOPPED')")
    assert_nothing_moves(crane, driver)
    RIGHT.let_go(page)
    driver.wait(lambda: not any(crane.ears.joy[-1].axes))
    page.click("#emergency_stop button:text('Reset')")
    page.wait_for_selector("#emergency_stop button:text('Reset')", state="hidden")


def test_of_two_browsers_one_drives_until_it_hands_over_and_its_end_stops_the_crane(crane, driver, other):
    assert re.fullmatch(r"operator \d+ drives, you look on", other.page.text_content("#seat .driver"))
    LEFT.hold(other.page)
    LEFT.move(other.page)
    assert_nothing_moves(crane, other)
    LEFT.let_go(other.page)
    other.page.click("#seat button:text('Ask for control')")
    driver.page.click("#seat button:text('Hand over')")
    other.page.wait_for_selector("#seat .driver:text('You drive')")
    other.drive(LEFT)
    stall = crane.stall()
    other.page.close()
    driver.wait(crane.ears.at_rest)
    crane.assert_it_stopped(stall)


def test_a_browser_that_freezes_or_is_killed_stops_the_crane(crane, driver, playwright, tmp_path):
    driver.page.click("#seat button:text('Leave the seat')")
    with launch_process(playwright, tmp_path) as (context, processes):
        page = DrivenPage(context.pages[0], crane)
        page.open()
        page.take_seat()
        for number in (signal.SIGSTOP, signal.SIGKILL):
            page.drive(RIGHT)
            stall = crane.stall()
            for pid in processes():
                os.kill(pid, number)
            driver.wait(crane.ears.at_rest)
            crane.assert_it_stopped(stall)
            if number == signal.SIGSTOP:
                for pid in processes():
                    os.kill(pid, signal.SIGCONT)
                assert_nothing_moves(crane, driver)  # its keys are down all the time
