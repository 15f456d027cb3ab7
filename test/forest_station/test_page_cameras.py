"""The free camera in a real browser: the picture follows a drag, one and two fingers, and the wheel."""

import io
import math
import struct
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from browser import LOW, PHONE, new_page
from page_stand_in import PageStandIn
from PIL import Image
from playwright.sync_api import Browser, Route

from forest_description.derived.limits import pose_at, start_tip
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_station.scene.scene_description import scene_of

C180 = load_machine("c180_hoses")
BAG = {"name": "mine", "bytes": 2000, "modified": 0, "seconds": 1.0}
BACK = 3.0  # [px] within which a label is where it was
STANDS = 200  # [px] of the beams' colour from which on a crane stands there
# The colours as drawn: without labels, also while no new poses come.
BARE = """([visibility, filter]) => {
  document.querySelector("#scene .labels").style.visibility = visibility;
  document.querySelector("#scene canvas").style.filter = filter;
}"""
AWAY = 20.0  # [px] from which on it is elsewhere
# Where the picture shows the middle of the reach, and of the tip's height [px].
PLACES = """() => [...document.querySelectorAll("#scene .label.figure")].map((label) => {
  const { e, f } = new DOMMatrix(getComputedStyle(label).transform);
  return [e, f];
})"""


class Picture:
    """The page with a standing crane, drawn."""

    def __init__(self, browser: Browser, viewport: dict[str, int]) -> None:
        self.page, self.errors = new_page(browser, viewport)
        tip = [(f"tip/pose/{axis}", "m") for axis in "xyz"]
        joints = [(f"joint_states/{axis}.position", "rad") for axis in AXES]
        self.met = met = PageStandIn(self.page, (*tip, *joints), hands=False)
        met.pages |= {"/scene.json": scene_of(C180), "/bags.json": []}
        met.open()
        self.page.wait_for_selector("#scene[data-rate]")
        assert self.places() == []
        self.wait(lambda _: self.shown()[0])
        assert self.shown()[1] == 0  # before anybody tells where the joints are, no crane stands there
        met.send_frame(1, 0.0, [*start_tip(C180), *pose_at(start_tip(C180), C180)])
        self.page.wait_for_function("() => document.querySelectorAll('#scene .label.figure').length === 2")
        self.wait(lambda _: self.shown()[1] > STANDS)
        box = self.page.locator("#scene canvas").bounding_box()
        assert box is not None
        self.x, self.y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        self.touch = self.page.context.new_cdp_session(self.page)

    def shown(self) -> tuple[bool, int]:
        """Return whether anything is drawn, and how many pixels before the vehicle have the beams' colour."""
        picture = self.pixels()
        height, width, _ = picture.shape
        seen = picture[height // 7 : height * 3 // 4, width // 2 :]  # no buttons, no banner
        return bool(np.ptp(seen) > 20), np.count_nonzero(seen[..., 0] > seen[..., 2] + 10)

    def pixels(self) -> Any:
        """Return the picture, and what lies over it: rows of columns of red, green and blue."""
        shot = self.page.locator("#scene canvas").screenshot()
        return np.array(Image.open(io.BytesIO(shot)), dtype=int)[..., :3]

    def settled(self) -> list[list[float]]:
        """Return where the labels are once they stay there: at first the page finds its size."""
        seen = [self.places()]
        while len(seen) < 10 or seen[-10:] != seen[-1:] * 10:
            self.page.wait_for_timeout(50)
            seen.append(self.places())
        return seen[-1]

    def places(self) -> list[list[float]]:
        return self.page.evaluate(PLACES)

    def wait(self, condition: Callable[[list[list[float]]], Any]) -> None:
        """Wait until the labels' places meet a condition."""
        for _ in range(600):
            if condition(self.places()):
                return
            self.page.wait_for_timeout(50)
        raise AssertionError(f"never; last: {self.places()}")

    def view(self) -> str | None:
        return self.page.text_content(".views [aria-pressed=true]")

    def drag(self, way: float) -> None:
        """Drag with the mouse, to the right."""
        self.page.mouse.move(self.x, self.y)
        self.page.mouse.down()
        self.page.mouse.move(self.x + way, self.y, steps=4)
        self.page.mouse.up()

    def move_fingers(self, *fingers: tuple[tuple[float, float], tuple[float, float]]) -> None:
        """Move fingers from offsets of the middle to others [px]."""
        self._send("touchStart", [begin for begin, _ in fingers])
        for share in (0.25, 0.5, 0.75, 1.0):
            places = [tuple(a + share * (b - a) for a, b in zip(*each, strict=True)) for each in fingers]
            self._send("touchMove", places)
        self._send("touchEnd", [])

    def _send(self, kind: str, places: list[Any]) -> None:
        points = [{"x": self.x + x, "y": self.y + y, "id": i} for i, (x, y) in enumerate(places)]
        self.touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})


def apart(one: list[list[float]], other: list[list[float]]) -> float:
    """Return how far a label went that went farthest [px]."""
    return max(map(math.dist, one, other))


def size(places: list[list[float]]) -> float:
    """Return how far the labels are beside each other [px]; up and down they make room for each other."""
    return abs(places[0][0] - places[1][0])


@pytest.fixture(scope="module")
def desktop(browser: Browser) -> Iterator[Picture]:
    picture = Picture(browser, LOW)
    yield picture
    assert picture.errors == []


@pytest.fixture(scope="module")
def phone(browser: Browser) -> Iterator[Picture]:
    picture = Picture(browser, PHONE)
    yield picture
    assert picture.errors == []


def test_a_drag_turns_the_picture_and_back(desktop: Picture) -> None:
    assert desktop.view() == "side"
    before = desktop.settled()
    desktop.drag(60)
    desktop.wait(lambda places: apart(places, before) > AWAY)
    assert desktop.view() == "free"
    desktop.drag(-60)
    desktop.wait(lambda places: apart(places, before) < BACK)


def test_the_wheel_goes_away_and_comes_nearer(desktop: Picture) -> None:
    before = size(desktop.settled())
    desktop.page.mouse.move(desktop.x, desktop.y)
    desktop.page.mouse.wheel(0, 400)
    desktop.wait(lambda places: size(places) < 0.9 * before)
    desktop.page.mouse.wheel(0, -400)
    desktop.wait(lambda places: abs(size(places) - before) < BACK)


def test_the_free_camera_is_found_again_where_it_was_left(desktop: Picture) -> None:
    left = desktop.settled()
    desktop.page.keyboard.press("3")
    desktop.wait(lambda places: apart(places, left) > AWAY)
    desktop.page.keyboard.press("4")
    desktop.wait(lambda places: apart(places, left) < BACK)


def test_a_square_that_is_marked_is_looked_at(desktop: Picture) -> None:
    desktop.page.keyboard.press("2")
    desktop.wait(lambda _: desktop.view() == "side")
    before = desktop.settled()
    desktop.page.get_by_role("button", name="Mark a square").click()
    desktop.page.wait_for_selector("text=drive here")
    desktop.wait(lambda places: apart(places, before) > AWAY)
    assert desktop.view() == "free"


def test_a_square_that_was_driven_stays_until_it_is_taken_away(desktop: Picture) -> None:
    page, (x, y, z) = desktop.page, start_tip(C180)
    desktop.met.tell_seat(deadman=("ready", ""))
    waits = "text=Edge 1 of 4 waits. Hold the left Shift key, then move a stick."
    page.wait_for_selector(waits)  # of the square that was marked before
    side, angles = 0.8, pose_at((x, y, z), C180)
    corners = ((0.0, 0.0), (side, 0.0), (side, side), (0.0, side), (0.0, 0.0))
    for number, (out, left) in enumerate(corners):
        desktop.met.send_frame(2 + number, 0.1 * number, [x + out, y + left, z, *angles])
    page.wait_for_selector("text=the tip was 0.0 cm from the edge on average, 0.0 cm at most.")
    assert page.locator("#scene[data-exercise]").count() == 1
    assert page.get_by_role("button", name="Mark another square").is_visible()
    page.get_by_role("button", name="Take the square away").click()
    page.wait_for_selector("#scene:not([data-exercise])")
    assert page.get_by_role("button", name="Mark a square").is_visible()
    assert not page.get_by_role("button", name="Take the square away").is_visible()
    desktop.met.send_frame(9, 1.0, [x, y, z, *angles])


def test_the_drawing_is_stopped_and_goes_on_by_a_click_on_its_figure(desktop: Picture) -> None:
    page = desktop.page
    page.click(".rate")
    page.wait_for_selector("text=The drawing is stopped: click to draw.")
    desktop.met.send_frame(10, 1.1, [*start_tip(C180), *pose_at(start_tip(C180), C180)])
    page.wait_for_timeout(300)
    assert desktop.places() == []
    page.click(".rate")
    desktop.wait(lambda places: len(places) == 2)


def test_one_finger_turns_the_picture_and_back(phone: Picture) -> None:
    before = phone.settled()
    phone.move_fingers(((0, 0), (60, 0)))
    phone.wait(lambda places: apart(places, before) > AWAY)
    assert phone.view() == "free"
    phone.move_fingers(((60, 0), (0, 0)))
    phone.wait(lambda places: apart(places, before) < BACK)


def test_two_fingers_pinched_go_away_and_moved_together_shift_the_picture(phone: Picture) -> None:
    before = phone.settled()
    phone.move_fingers(((-60, 0), (-30, 0)), ((60, 0), (30, 0)))
    phone.wait(lambda places: size(places) < 0.8 * size(before))
    farther = phone.settled()
    phone.move_fingers(((-30, 0), (-30, 50)), ((30, 0), (30, 50)))
    phone.wait(lambda places: all(y - was > AWAY for (_, y), (_, was) in zip(places, farther, strict=True)))


def test_on_a_phone_a_marked_square_is_seen_in_the_middle_of_what_its_text_leaves(phone: Picture) -> None:
    page = phone.page
    page.get_by_role("button", name="Mark a square").click()
    page.wait_for_selector("text=drive here")
    phone.settled()
    bottom = """() => {
      const { offsetTop, offsetHeight } = document.querySelector("#scene > #first_minute");
      return offsetTop + offsetHeight;
    }"""
    page.evaluate(BARE, ["hidden", "none"])
    picture = phone.pixels()
    page.evaluate(BARE, ["", ""])
    red, green, blue = picture[..., 0], picture[..., 1], picture[..., 2]
    rows = np.nonzero((red > 200) & (green > 200) & (blue < 150))[0]  # of the square's lines
    height = len(picture)
    assert len(rows) > STANDS / 4
    middle = 0.5 * (rows.min() + rows.max())
    assert middle == pytest.approx(0.5 * (page.evaluate(bottom) + height), abs=0.05 * height)
    page.get_by_role("button", name="Take the square away").click()


def test_a_recording_and_the_live_crane_are_never_shown_for_each_other(desktop: Picture) -> None:
    page, met = desktop.page, desktop.met
    tip, angles = start_tip(C180), pose_at(start_tip(C180), C180)
    signals = [list(one) for one in met.signals]
    told = {"seconds": 1.0, "start": 0.0, "signals": signals, "events": [], "first": {}, "notes": []}
    frames = b"".join(
        struct.pack(f"<B3xId{len(signals)}f", 2, number, number / 30, *tip, *angles) for number in range(31)
    )
    page.route("**/bags.json", lambda route: route.fulfill(json=[BAG]))
    page.route("**/bags/mine.json", lambda route: route.fulfill(json=told | {"scene": scene_of(C180)}))
    waiting: list[Route] = []
    page.route("**/bags/mine/frames?*", lambda route: waiting.append(route))
    page.get_by_role("button", name="Read the list again").click()
    page.get_by_role("button", name="Replay").click()
    page.wait_for_selector("#replay .time:text('loading')")
    page.get_by_role("button", name="Play the recording").click()
    page.wait_for_selector("#scene[data-awaits=replay] canvas", state="hidden")
    page.wait_for_timeout(300)
    assert page.locator("#replay .time").inner_text() == "0.00 of 1.00 s, loading"  # its clock waits
    waiting[0].fulfill(body=frames, content_type="application/octet-stream")
    page.wait_for_selector("#scene:not([data-awaits]) canvas", state="visible")
    page.wait_for_selector("#replay .time:text-is('1.00 of 1.00 s')")
    page.get_by_role("button", name="Back to live").click()
    page.wait_for_selector("#scene[data-awaits=live] canvas", state="hidden")
    page.wait_for_timeout(300)
    assert desktop.places() == []
    assert page.locator("#scene[data-awaits=live]").count() == 1
    met.send_frame(20, 2.0, [*tip, *angles])
    page.wait_for_selector("#scene:not([data-awaits]) canvas", state="visible")
    page.wait_for_selector("#scene .label.figure")
