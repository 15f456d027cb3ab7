"""The page's instruments in a real browser: units, charts, a pause, diagnostics, and one dropped in."""

import math
import re
from pathlib import Path
from typing import Any

import pytest
from browser import new_page
from page_stand_in import PageStandIn
from playwright.sync_api import Browser

PAGE = Path(__file__).parents[2] / "docs/how-to/add-an-instrument.md"
SIGNALS = (
    ("hydraulics/supply/pressure", "Pa"),
    ("hydraulics/supply/flow", "m³/s"),
    ("valve_voltages/boom", "V"),
    ("valve_driver/status/boom_backward_deadband", "V"),
    ("valve_driver/status/boom_forward_deadband", "V"),
    ("hydraulics/auxiliary/tank_temperature", "K"),
    ("ground_truth/load/mass", "kg"),
    ("joint_states/boom.position", "rad"),
    ("ground_truth/pump/displacement", "1"),
    ("ground_truth/pump/speed", "rad/s"),
    ("ground_truth/tank_line/pressure", "Pa"),
    *((f"ground_truth/tip_over/{side}", "1") for side in ("ahead", "left", "behind", "right")),
    ("ground_truth/deflections/boom", "rad"),
    ("ground_truth/head/head_in_plane.position", "rad"),
    ("ground_truth/joint_states/boom.position", "rad"),
    ("ground_truth/joint_states/stick.position", "rad"),
    *((f"tip/{kind}/{axis}", "") for kind in ("pose", "twist", "twist_command") for axis in "xyz"),
)
RATE = 30.0  # [Hz] of the frames
UNKNOWN = (math.nan,) * 3  # the tip's command, as in the joint scheme
PUMP = (0.25, 50 * math.pi, 3.5e5)  # its displacement, its speed, the tank line
MARGINS = (0.95, 0.62, 1.0, 0.71)  # against tipping over
BENT = (math.radians(-0.25), math.radians(-12.5), math.radians(60), math.radians(-50))  # boom; head's sway
MEASURED = (18e6, 5e-4, 2.5, 1.25, 1.5, 313.15, 620.0, math.pi / 6)
FRAME = [*MEASURED, *PUMP, *MARGINS, *BENT, 4.0, 0.0, 1.0, 0.3, 0.0, 0.4, *UNKNOWN]


@pytest.fixture(scope="module")
def met(browser: Browser) -> Any:
    """The page with the how-to's instrument dropped in, after 10 s of frames."""
    page, _ = new_page(browser, viewport={"width": 1600, "height": 3600})  # all charts in sight
    example = re.search(r"^```js\n(.*?)^```", PAGE.read_text("utf-8"), re.DOTALL | re.MULTILINE)
    assert example is not None
    standing = PageStandIn(page, SIGNALS, {"panels/tip_speed.js": example[1]})
    standing.open()
    for number in range(int(10 * RATE)):
        standing.send_frame(number, number / RATE, FRAME)
    yield standing
    page.context.close()


def shows(met: PageStandIn, panel: str, text: str) -> None:
    """Wait until a panel shows a text."""
    met.page.locator(f"#{panel}").get_by_text(text, exact=False).first.wait_for()


def test_values_are_told_in_the_operators_units(met: PageStandIn) -> None:
    for panel, text in (
        ("pressures", "supply 180"),
        ("flows", "supply 30.0"),
        ("spools", "boom valve 2.50"),
        ("temperatures", "tank 40.0"),
        ("load", "log 620"),
        ("joints", "boom 30.0"),
        ("pump", "displacement 25"),
        ("pump", "engine 1500"),
        ("tank_line", "before the filter 3.5"),
        ("tip_over", "least 62"),
        ("bending", "boom -0.25"),
        ("sway", "in the plane -2.5"),
        ("power", "hydraulic power 9.0"),
        ("power", "energy of the minute 90"),
    ):
        shows(met, panel, text)


def test_what_a_machine_does_not_have_has_no_instrument(met: PageStandIn) -> None:
    assert met.page.locator("#sway").is_visible()
    assert not met.page.locator("#compensators").is_visible()


def test_the_driver_has_the_head_grasp_and_drop(met: PageStandIn) -> None:
    for button, act in (("Grasp a log", "grasp"), ("Drop it", "drop")):
        met.page.get_by_role("button", name=button).click()
        met.page.wait_for_function("() => document.querySelector('#load .said').textContent === 'done'")
        assert {"do": "grapple", "act": act}.items() <= met.asked[-1].items()
    met.tell_seat(driver="operator 2")
    met.page.wait_for_selector("#load button:disabled")
    met.tell_seat()


def test_an_instrument_is_one_file_dropped_in(met: PageStandIn) -> None:
    shows(met, "tip_speed", "measured 0.50")
    shows(met, "tip_speed", "commanded –")


def test_without_a_command_of_the_tip_there_is_no_tip_error(met: PageStandIn) -> None:
    shows(met, "tip_error", "off within 1 s –")


def test_the_cursor_reads_a_moment_and_a_click_stops_all_charts(met: PageStandIn) -> None:
    frame = met.page.locator("#flows .frame")
    frame.locator("canvas").wait_for()
    frame.hover(position={"x": 230, "y": 30})
    met.page.wait_for_function(
        "() => /^-[0-9.]+ s$/.test(document.querySelector('#flows .moment').textContent)"
    )
    frame.click(position={"x": 230, "y": 30})
    assert met.page.locator(".chart.paused").count() == met.page.locator(".chart").count()
    met.send_frame(1000, 11.0, [2 * value for value in FRAME])
    met.page.wait_for_timeout(300)
    assert "30.0" in met.page.locator("#flows").inner_text()
    met.page.mouse.move(0, 0)
    frame.press("Enter")
    shows(met, "flows", "supply 60.0")


def test_the_deadband_is_shaded_where_the_driver_knows_it(met: PageStandIn) -> None:
    chart = met.page.locator("#spools .chart:not([hidden]) canvas")
    chart.wait_for()
    inside, outside = met.page.evaluate(
        """() => {
          const canvas = document.querySelector("#spools .chart:not([hidden]) canvas");
          const context = canvas.getContext("2d");
          const [x, height] = [canvas.width / 2, canvas.height];
          const alpha = (share) => context.getImageData(x, Math.round(share * height), 1, 1).data[3];
          return [0.385, 0.15].map(alpha);
        }"""
    )
    assert inside > 0
    assert outside == 0


def test_diagnostics_tell_what_to_do(met: PageStandIn) -> None:
    part = {
        "name": "controller: emergency stop",
        "level": "error",
        "text": "emergency stop pressed",
        "values": {},
    }
    well = {"name": "simulator: machine", "level": "ok", "text": "well", "values": {}}
    met.tell("diagnostics", parts=[part, well])
    shows(met, "diagnostics", "Then release the deadman, centre the sticks, and reset it.")
    met.tell("diagnostics", parts=[well])
    shows(met, "diagnostics", "All is well: 1 parts")


def test_latency_is_half_the_round_trip_and_the_servers_part(met: PageStandIn) -> None:
    met.tell("latency", server_ms=12.0)
    shows(met, "latency", "12 ms from there")
