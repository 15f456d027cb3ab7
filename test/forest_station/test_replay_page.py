"""Recordings, replays and settings in a real browser, against a station with a simulated crane."""

import io
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("playwright")

from browser import LOW, new_page
from PIL import Image
from running_graph import free_port, running, wait_for_text

from forest_bag.cli.main import main as forest_bag
from forest_bag.read.timeseries import read_bag
from forest_msgs_py.interfaces import topics

BAGS = Path("bags")
SHOWN_S = 60_000  # [ms] in which a page shows what it is to show, on a busy computer
# Counts the hands messages that tell of a held deadman.
WATCH = """
  window.heldMessages = 0;
  const send = WebSocket.prototype.send;
  WebSocket.prototype.send = function (data) {
    if (typeof data !== "string") heldMessages += new Uint8Array(data.buffer ?? data)[1] & 1;
    send.call(this, data);
  };
"""
SETTLED = 0.02  # [m] between the drawn tip and the recorded one: the frame of the bar is up to 5 ms older


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    directory = tmp_path_factory.mktemp("bags")
    for name in ("coordinated", "fault"):
        shutil.copytree(BAGS / name, directory / name)
    return directory


@pytest.fixture(scope="module")
def address(bags, tmp_path_factory, session_domain_id):
    """A station with a simulated crane."""
    port, log = free_port(), tmp_path_factory.mktemp("station") / "log"
    options = ("--port", str(port), "--no-browser", "--bags", str(bags))
    with running("forest_station.station", log, session_domain_id, *options) as station:
        wait_for_text(station, log, "the page is at")
        yield f"http://127.0.0.1:{port}/"


@pytest.fixture(scope="module")
def page(browser, address):
    """A page of the station, whose errors fail the tests."""
    opened, errors = new_page(browser, LOW)
    opened.set_default_timeout(SHOWN_S)
    opened.add_init_script(WATCH)
    opened.goto(address)
    opened.wait_for_selector("#recording li")
    opened.wait_for_selector("#seat .driver[data-drives=true]")
    yield opened
    assert errors == []


def recorded_tip(name, time):
    """The recorded tip at a time since the bag's start [m]."""
    series = read_bag(BAGS / name).series(topics.TIP_POSE)
    place = np.searchsorted(series.log_time_ns, round(time * 1e9), side="right") - 1
    return series.values[place, :3]


def wait_for_tip(page, wanted):
    """Wait until the crane is drawn with its tip there."""
    page.wait_for_function(
        """([wanted, settled]) => {
          const tip = document.getElementById("scene").tipPosition?.() ?? [];
          return tip.length === 3 && Math.hypot(...tip.map((x, i) => x - wanted[i])) < settled;
        }""",
        arg=[list(map(float, wanted)), SETTLED],
    )


def go_to(page, seconds):
    """Draw the time bar's thumb."""
    page.eval_on_selector(
        "#replay .slider",
        "(bar, frame) => { bar.value = frame; bar.dispatchEvent(new Event('input')); }",
        round(seconds * 30),
    )


def open_replay(page, name):
    page.locator("#recording li", has_text=name).get_by_role("button", name="Replay").click()
    page.wait_for_function(
        "name => document.querySelector('#replay_banner .name').textContent === name", arg=name
    )


def holds_the_deadman(page):
    """Press the deadman anew, for a page that hung lets it go; tell whether one message said so."""
    page.keyboard.up("ShiftLeft")
    page.keyboard.down("ShiftLeft")
    return page.evaluate("() => heldMessages") > 0


def violet_pixels(page):
    """How many pixels of the scene have the ghost's colour, more blue than red, and more red than green."""
    picture = np.array(Image.open(io.BytesIO(page.locator("#scene canvas").screenshot())), dtype=int)
    red, green, blue = picture[..., 0], picture[..., 1], picture[..., 2]
    return np.count_nonzero((blue > red + 10) & (red > green + 10))


def test_the_time_bar_moves_the_drawn_tip_to_where_it_was_recorded(page):
    open_replay(page, "coordinated")
    assert page.locator("#replay_banner").inner_text().startswith("REPLAY of coordinated")
    for seconds in (1.0, 4.5, 2.5):
        go_to(page, seconds)
        wait_for_tip(page, recorded_tip("coordinated", seconds))


def test_on_a_narrow_screen_what_a_newcomer_reads_does_not_lie_over_a_replay(page):
    wide = page.viewport_size
    page.set_viewport_size({"width": 600, "height": wide["height"]})
    page.wait_for_selector("#scene > #first_minute", state="hidden")
    page.set_viewport_size(wide)
    page.wait_for_selector("#left > #first_minute", state="visible")


def test_it_plays_and_steps_by_keys_and_the_hands_are_off_the_crane(page):
    go_to(page, 1.0)
    page.keyboard.press(".")
    page.wait_for_function("() => document.querySelector('#replay .time').textContent.startsWith('1.03')")
    page.keyboard.press(",")
    page.keyboard.press(",")
    page.wait_for_function("() => document.querySelector('#replay .time').textContent.startsWith('0.97')")
    page.keyboard.press("k")
    page.wait_for_function("() => parseFloat(document.querySelector('#replay .time').textContent) > 1.5")
    page.keyboard.press("k")
    page.wait_for_selector("#replay .play:text('Play')")
    assert not page.locator("#sticks").is_visible()
    page.keyboard.down("ShiftLeft")
    page.keyboard.up("ShiftLeft")
    assert page.evaluate("() => heldMessages") == 0


def test_a_second_bag_is_laid_over_the_first(page, wait_until):
    go_to(page, 3.0)
    assert violet_pixels(page) < 10
    page.locator("#replay .overlay select").first.select_option("fault")
    apart = np.linalg.norm(recorded_tip("fault", 3.0) - recorded_tip("coordinated", 3.0))
    assert apart > 0.05
    page.wait_for_selector(f"#replay output:text('tips {apart:.2f} m apart')")
    wait_until(lambda: violet_pixels(page) > 100)
    offset = page.locator("#replay .offset")
    offset.fill("0.5")
    offset.press("Enter")
    later = np.linalg.norm(recorded_tip("fault", 2.5) - recorded_tip("coordinated", 3.0))
    page.wait_for_selector(f"#replay output:text('tips {later:.2f} m apart')")


def test_a_shared_link_opens_the_moment_with_both_bags(page, browser, address):
    link = page.url
    assert link == f"{address}#bag=coordinated&t=3.00&with=fault&offset=0.5"
    other, errors = new_page(browser, LOW)
    other.set_default_timeout(SHOWN_S)
    other.goto(link)
    wait_for_tip(other, recorded_tip("coordinated", 3.0))
    assert other.locator("#replay .time").inner_text() == "3.00 of 5.30 s"
    assert other.locator("#replay .overlay select").first.input_value() == "fault"
    assert errors == []
    other.close()


def test_one_click_leads_back_to_the_live_crane(page, address, wait_until):
    page.locator("#replay_banner button").click()
    page.wait_for_selector("#replay_banner", state="hidden")
    assert page.url == address
    assert page.locator("#sticks").is_visible()
    wait_for_tip(page, (5.5, 0.0, 1.0))  # where the simulated crane stands at its start
    wait_until(lambda: holds_the_deadman(page))
    page.keyboard.up("ShiftLeft")


def test_a_setting_is_switched_and_a_refusal_is_the_nodes_own_sentence(page):
    page.get_by_role("group", name="Scheme").get_by_role("button", name="joint").click()
    page.wait_for_selector("#settings [aria-label=Scheme] [aria-pressed=true]:text-is('joint')")
    page.locator("#settings summary").click()
    page.locator("#settings [type=search]").fill("controller feedback_gain")
    assert page.locator("#settings .row:visible").count() == 1
    field = page.locator("#settings .row:visible input")
    field.fill("3, 4, 500")
    field.press("Enter")
    page.wait_for_selector("#settings .answer[data-ok=false]:text('allowed: -1 .. 30 1/s')")


def test_a_recording_is_made_marked_and_readable(page, bags, capsys):
    page.locator("#recording [aria-label='Name of the recording']").fill("trial")
    page.locator("#recording .record").click()
    page.wait_for_selector("#recording .state:text('trial: ')")
    page.locator("#recording form input").fill("log dropped")
    page.locator("#recording form button").click()
    page.wait_for_selector("#recording .answer:text('Marked: log dropped')")
    page.locator("#recording .record").click()
    page.wait_for_selector("#recording .state:text('Recorded')")
    page.wait_for_selector("#recording li .name:text-is('trial')")
    assert forest_bag(["info", "--json", str(bags / "trial")]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["complete"]
    assert [event["text"] for event in found["events"]] == ["log dropped"]
    assert found["topics"]["/joint_states"]["messages"] > 10
