"""The operator's page in a real browser: it shows the crane, drives it, and stops it when the browser ends.

The real station, controller, valve driver and simulator; the page in Chromium.
"""

import math
import os
import signal
import time

import pytest
from browser import DESKTOP, PHONE, launch_process, new_page

MET_S = 60.0
PATIENCE_S = 3.0  # after which the deadman is pressed anew
CONNECTED = "#seat .driver:not(:text('No connection'))"
GAMEPAD = """
    const pad = { index: 0, id: "scripted", connected: true, mapping: "standard", timestamp: 0,
                  axes: [0, 0, 0, 0],
                  buttons: Array.from({ length: 17 }, () => ({ pressed: false, value: 0 })) };
    window.pad = pad;
    navigator.getGamepads = () => [pad];
"""


@pytest.fixture
def wait(crane):
    """Wait for a condition while the page runs and the crane's topics are read."""

    def until(page, condition):
        end = time.monotonic() + MET_S
        while not condition():
            assert time.monotonic() < end, page.inner_text("body")
            page.wait_for_timeout(10)
            crane.ears.read()

    return until


@pytest.fixture
def open_page(crane, browser):
    """Open the station's page in a profile of its own; nothing may go wrong in it."""
    opened = []

    def open_(viewport=DESKTOP, script=""):
        page, errors = new_page(browser, viewport)
        opened.append((page, errors))
        page.add_init_script(script)
        page.goto(crane.address)
        page.wait_for_selector(CONNECTED, state="attached")
        return page

    yield open_
    for page, errors in opened:
        page.context.close()
        assert not errors


@pytest.fixture
def driver(crane, open_page, wait):
    """A page that has the seat."""

    def open_(viewport=DESKTOP, script=""):
        page = open_page(viewport, script)
        wait(page, lambda: page.text_content("#seat .driver") == "You drive" or take_seat(page))
        crane.ears.forget()
        return page

    return open_


def take_seat(page):
    """Ask for the seat; whoever left it without a word keeps it for a while."""
    for button in page.query_selector_all("#seat button:text('seat'), #seat button:text('control')"):
        button.click()
    return False


def drawn_tip(page):
    return page.evaluate("document.getElementById('scene').tipPosition()")


def voltage(crane):
    return crane.ears.voltages[-1][1] if crane.ears.voltages else (0.0,) * 3


def moves(crane):
    return lambda: any(voltage(crane))


def stands(crane):
    return lambda: bool(crane.ears.voltages) and not any(voltage(crane))


def stick_centre(page, name="left"):
    box = page.locator(f"#{name}_stick").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, box["height"] / 2


def hold_and_press(page, key):
    page.keyboard.down("ShiftLeft")
    page.wait_for_timeout(100)
    page.keyboard.down(key)


def let_go(page, key):
    page.keyboard.up(key)
    page.keyboard.up("ShiftLeft")


@pytest.fixture
def drive(wait):
    """Press, and press anew, until a condition holds.

    Where the processor draws the picture, the page hangs now and then for longer than the deadman allows.
    """

    def until(page, press, release, condition):
        def pressed():
            release()
            page.wait_for_timeout(300)
            press()
            end = time.monotonic() + PATIENCE_S
            while not condition() and time.monotonic() < end:
                wait(page, lambda: True)
                page.wait_for_timeout(10)
            return condition()

        wait(page, pressed)

    return until


@pytest.fixture
def drive_by_key(crane, drive):
    """Hold the deadman and a key until the crane moves."""

    def until(page, key):
        drive(page, lambda: hold_and_press(page, key), lambda: let_go(page, key), moves(crane))

    return until


@pytest.mark.parametrize("viewport", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_the_page_shows_the_crane_as_it_stands(crane, open_page, wait, viewport):
    page = open_page(viewport)
    wait(page, lambda: all(value is not None and math.isfinite(value) for value in drawn_tip(page)))
    told = page.evaluate("fetch('/scene.json').then((answer) => answer.json())")
    assert told["machine"] == "c180"
    assert math.hypot(*drawn_tip(page)) > 1.0
    stop = page.locator("#emergency_stop button").first.bounding_box()
    assert stop["x"] >= 0
    assert stop["y"] >= 0
    assert stop["x"] + stop["width"] <= viewport["width"]
    assert stop["y"] + stop["height"] <= viewport["height"]
    assert min(stop["width"], stop["height"]) >= 44


def test_a_stick_moves_the_drawn_crane(crane, driver, drive, wait):
    page = driver()
    x, y, radius = stick_centre(page)
    before = []

    def press():
        page.keyboard.down("ShiftLeft")
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x, y + 0.6 * radius, steps=5)
        before[:] = before or drawn_tip(page)

    def release():
        page.mouse.up()
        page.keyboard.up("ShiftLeft")

    drive(page, press, release, lambda: before and drawn_tip(page)[0] < before[0] - 0.1)
    release()
    wait(page, stands(crane))


def test_keys_move_the_crane_and_nothing_moves_without_the_deadman(crane, driver, drive_by_key, wait):
    page = driver()
    page.keyboard.down("a")
    wait(page, lambda: len(crane.ears.joy) > 50)
    assert not any(joy.held for joy in crane.ears.joy)
    page.keyboard.up("a")
    wait(page, lambda: not any(crane.ears.joy[-1].axes))
    crane.ears.forget()
    drive_by_key(page, "a")
    let_go(page, "a")
    wait(page, stands(crane))


def test_a_gamepad_moves_the_crane(crane, driver, drive, wait):
    page = driver(script=GAMEPAD)

    def press():
        page.evaluate("pad.buttons[4] = { pressed: true, value: 1 }")  # the left shoulder
        page.wait_for_timeout(100)
        page.evaluate("pad.axes[0] = 0.6")  # the browser's sign: right

    def release():
        page.evaluate("pad.buttons[4] = { pressed: false, value: 0 }; pad.axes[0] = 0")

    drive(page, press, release, moves(crane))
    assert crane.ears.joy[-1].axes[0] < 0.0
    release()
    wait(page, stands(crane))


@pytest.mark.parametrize("way", ["click", "Escape", " "], ids=["click", "escape", "space"])
def test_an_emergency_stop_is_one_click_or_key_away(crane, driver, drive_by_key, open_page, wait, way):
    page = driver()
    drive_by_key(page, "a")
    if way == "click":
        open_page().click("#emergency_stop button")  # also of a page that only looks on
    else:
        page.keyboard.press(way)
    wait(page, stands(crane))
    wait(page, lambda: "Reset" in page.inner_text("#emergency_stop"))
    let_go(page, "a")
    wait(page, lambda: not any(crane.ears.joy[-1].axes))
    page.click("#emergency_stop button:text('Reset')")
    wait(page, lambda: page.locator("#emergency_stop button:text('Reset'):visible").count() == 0)


def test_a_page_that_is_closed_while_it_drives_stops_the_crane(crane, driver, drive_by_key, open_page, wait):
    page, other = driver(), open_page()
    drive_by_key(page, "a")
    stall = crane.stall()
    page.close()
    wait(other, stands(crane))
    crane.assert_it_stopped(stall)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "frozen"])
def test_a_browser_that_is_killed_or_frozen_stops_the_crane(
    crane, playwright, drive_by_key, open_page, wait, tmp_path, number
):
    with launch_process(playwright, tmp_path) as (page, processes):
        page.goto(crane.address)
        page.wait_for_selector(CONNECTED, state="attached")
        wait(page, lambda: page.text_content("#seat .driver") == "You drive" or take_seat(page))
        looker = open_page()
        crane.ears.forget()
        drive_by_key(page, "d")
        stall = crane.stall()
        for pid in processes():
            os.kill(pid, number)
        wait(looker, stands(crane))
        crane.assert_it_stopped(stall)


def test_of_two_browsers_one_drives_until_it_hands_over(crane, driver, drive_by_key, open_page, wait):
    page, other = driver(), open_page()
    assert "you look on" in other.text_content("#seat .driver")
    hold_and_press(other, "a")
    wait(other, lambda: len(crane.ears.joy) > 50)
    assert not any(joy.held for joy in crane.ears.joy)
    let_go(other, "a")
    other.click("#seat button:text('Ask for control')")
    page.click("#seat button:text('Hand over')")
    wait(other, lambda: other.text_content("#seat .driver") == "You drive")
    drive_by_key(other, "a")
    let_go(other, "a")
    wait(other, stands(crane))


def test_the_first_minute_marks_a_square_and_tells_what_to_do(crane, driver, wait):
    page = driver()
    wait(page, lambda: all(value is not None for value in drawn_tip(page)))
    page.click("#first_minute button")
    wait(page, lambda: "hold the left Shift key" in page.inner_text("#first_minute p"))
    page.keyboard.down("ShiftLeft")
    wait(page, lambda: "Side 1 of 4" in page.inner_text("#first_minute p"))
    page.keyboard.up("ShiftLeft")
    page.click("#first_minute button")
    wait(page, lambda: "Mark a square" in page.inner_text("#first_minute"))
