"""The page's pure modules, imported by a browser: what the hands, the history and the instruments compute."""

import math
from typing import Any

import pytest
from page_stand_in import Js

from forest_control.config.profile_file import shipped
from forest_control.limits.velocity_scaling import Limit
from forest_control.operator import joystick_watch
from forest_control.operator.levers import AXIS_COUNT, BUTTON_COUNT, LEFT_SHOULDER
from forest_control.operator.operator_profile import Frame, Mode
from forest_control.safety import motion_guard
from forest_control.servo.schemes import Scheme
from forest_control.valve import command_gate
from forest_description.types import AXES
from forest_msgs_py.interfaces.topics import JOY_AXES, JOY_BUTTONS
from forest_station.operator.hands_message import Hands, decode_hands, encode_hands


def test_axes_and_buttons_have_the_names_and_the_order_of_joy(js: Js) -> None:
    assert js("hands/joy.js", "m => [m.AXES, m.BUTTONS]") == [list(JOY_AXES), list(JOY_BUTTONS)]
    assert js("hands/joy.js", "m => m.DEADMAN") == LEFT_SHOULDER


def test_of_several_hands_on_one_axis_the_one_that_asks_for_most_counts(js: Js) -> None:
    sources = [[0.2, -0.5, 0, 0, 0, 0], [-0.4, 0.1, 0, 2, 0, None], [0, 0, 0, 0, 0, 0]]
    assert js("hands/joy.js", "(m, s) => m.mergeAxes(s)", sources) == [-0.4, -0.5, 0, 1, 0, 0]
    assert js("hands/joy.js", "m => m.mergeAxes([[NaN, 0, 0, 0, 0, 0]])") == [0] * AXIS_COUNT


def test_the_deadmans_button_says_what_the_deadman_says(js: Js) -> None:
    pressed = [True] * BUTTON_COUNT
    everything = 2**BUTTON_COUNT - 1
    assert js("hands/joy.js", "(m, p) => m.buttonBits(p, true)", pressed) == everything
    assert js("hands/joy.js", "(m, p) => m.buttonBits(p, false)", pressed) == everything - (
        1 << LEFT_SHOULDER
    )
    assert js("hands/joy.js", "m => m.buttonBits([], true)") == 1 << LEFT_SHOULDER


def test_a_deadzone_has_no_step_behind_it(js: Js) -> None:
    values = js("hands/joy.js", "m => [0.1, -0.1, 0.100001, -1, 1].map((v) => m.withDeadzone(v, 0.1))")
    assert values == pytest.approx([0, 0, 0, -1, 1], abs=1e-5)


def test_a_hands_message_is_what_the_server_reads(js: Js) -> None:
    said = Hands(True, 7, 1.5, (0.25, -0.5, 0.0, 1.0, 0.0, 0.0), 0x1200, 5)
    written = js(
        "hands/message.js",
        "m => [...new Uint8Array(m.handsMessage({number: 7, time: 1500, held: true,"
        " axes: [0.25, -0.5, 0, 1, 0, 0], buttons: 0x1200, pong: 5}))]",
    )
    assert bytes(written) == encode_hands(said)
    assert decode_hands(bytes(written)) == said


def test_keys_ramp_outwards_slowly_and_back_fast_through_the_centre(js: Js) -> None:
    ramp = "(m, [axes, wanted, dt]) => m.rampedAxes(axes, wanted, dt)"
    assert js("hands/keys.js", ramp, [[0.0], [1.0], 0.1]) == pytest.approx([0.25])
    assert js("hands/keys.js", ramp, [[0.9], [1.0], 0.1]) == pytest.approx([1.0])
    assert js("hands/keys.js", ramp, [[0.9], [0.0], 0.1]) == pytest.approx([0.1])
    assert js("hands/keys.js", ramp, [[0.5], [-1.0], 0.1]) == pytest.approx([0.0])
    assert js("hands/keys.js", ramp, [[-0.2], [-1.0], 0.1]) == pytest.approx([-0.45])


def test_keys_ask_for_the_tips_directions(js: Js) -> None:
    wanted = "(m, keys) => m.wantedAxes(keys)"
    assert js("hands/keys.js", wanted, ["KeyW", "KeyA", "ArrowUp"]) == [1, 1, 0, 1, 0, 0]
    assert js("hands/keys.js", wanted, ["KeyS", "KeyD", "ArrowDown", "KeyX"]) == [-1, -1, 0, -1, 0, 0]
    assert js("hands/keys.js", wanted, ["KeyW", "KeyS"]) == [0] * AXIS_COUNT


def test_the_deadman_is_held_while_any_holder_holds_it(js: Js) -> None:
    steps = """(m) => {
      const deadman = new m.Deadman();
      const told = [];
      for (const [holder, pressed] of [["a", true], ["b", true], ["a", false], ["b", false]]) {
        deadman.set(holder, pressed);
        told.push(deadman.held);
      }
      return [told, deadman.why];
    }"""
    assert js("hands/deadman.js", steps) == [[True, True, True, False], "b was released"]


def test_what_lets_the_deadman_go_asks_every_holder_to_press_anew(js: Js) -> None:
    steps = """(m) => {
      const deadman = new m.Deadman();
      deadman.set("a", true);
      deadman.release("the page hung");
      const told = [deadman.held];
      for (const pressed of [true, false, true]) {
        deadman.set("a", pressed);
        told.push(deadman.held);
      }
      return [told, deadman.why];
    }"""
    assert js("hands/deadman.js", steps) == [[False, False, False, True], "the page hung"]


def test_a_page_hung_after_a_gap_of_a_tenth_of_a_second(js: Js) -> None:
    assert js("hands/deadman.js", "m => [m.hung(0, 100), m.hung(0, 100.1), m.hung(-Infinity, 0)]") == [
        False,
        True,
        True,
    ]


def test_a_page_that_hangs_often_says_what_is_to_be_done_about_the_computer(js: Js) -> None:
    steps = """(m) => {
      const hangs = new m.Hangs();
      return [0, 61_000, 61_500].map((now) => hangs.told(250, now));
    }"""
    told = js("hands/deadman.js", steps)
    assert set(told[:2]) == {"the page hung for 0.25 s, longer than 0.1 s"}
    assert "stop the drawing" in told[2]


def test_a_gap_a_little_too_long_reads_as_longer_than_what_is_allowed(js: Js) -> None:
    told = js("hands/deadman.js", "(m) => new m.Hangs().told(100.1, 0)")
    assert told == "the page hung for 0.11 s, longer than 0.1 s"


def test_the_figure_of_a_slow_drawing_says_how_to_stop_it(js: Js) -> None:
    told = js("scene/overlay.js", "(m) => [m.rateText(1, 0.4), m.rateText(5, 0.4), m.rateText(60, 1)]")
    assert told == [
        "1 picture/s · 40 %: click to stop the drawing",
        "5 pictures/s · 40 %",
        "60 pictures/s · 100 %",
    ]


def test_without_a_connection_the_page_says_where_to_look(js: Js) -> None:
    why = """(m) => {
      const told = (lost) => m.whyText(null, { lost }, false, {});
      return [told(""), told(m.lostText("")), told(m.lostText("The station ends."))];
    }"""
    first, lost, ended = js("hands/why.js", why)
    assert "does scripts/station.sh run?" in first
    assert lost.startswith("The crane stands still until the page is connected again.")
    assert ended == "The station ends. Its terminal says why. Start scripts/station.sh anew."


def test_a_limit_that_lets_nothing_through_is_no_slowing_to_nothing(js: Js) -> None:
    why = """(m, [limit, axis]) => {
      const seat = { you_drive: true, driver: "you", asking: [], deadman: { state: "held" } };
      const told = (factor) => m.whyText(seat, {}, false, { armed: 1, factor, limit, axis });
      return [0, 0.004, 0.28].map(told);
    }"""
    held = "Held back by the flow of the pumps."
    assert js("hands/why.js", why, [Limit.FLOW, ""]) == [
        held,
        held,
        "Slowed to 28 % by the flow of the pumps.",
    ]
    held = "Held back: the boom joint is at its limit."
    told = js("hands/why.js", why, [Limit.JOINT, "boom"])
    assert told == [held, held, "Slowed to 28 %: the boom joint nears its limit."]
    assert js("hands/why.js", why, [Limit.JOINT, ""])[0] == "Held back: the joint is at its limit."


@pytest.mark.parametrize(
    ("angles", "rates", "axis"),
    [
        ((0.0, 0.95, 0.1), (0.0, 0.0, 0.0), "boom"),
        ((0.0, 0.95, 0.1), (0.0, -0.1, -0.2), "stick"),  # the boom moves away from its limit
        ((0.0, 0.9, 0.1), (0.0, 0.1, -0.2), "boom"),
    ],
)
def test_the_joint_at_its_limit_is_the_nearest_one_that_moves_towards_it(
    js: Js, angles: tuple[float, ...], rates: tuple[float, ...], axis: str
) -> None:
    joints = [{"name": name, "limit": [0.0, 1.0], "signal": f"{name}.position"} for name in AXES]
    joints[0]["limit"] = [-4.0, 4.0]
    values = {f"{name}.position": angle for name, angle in zip(AXES, angles, strict=True)}
    values |= {f"joint_states/{name}.velocity": rate for name, rate in zip(AXES, rates, strict=True)}
    found = "(m, [joints, values]) => m.axisAtLimit(joints, (name) => values[name])"
    assert js("scene/axes.js", found, [joints, values]) == axis


def test_who_pushes_a_stick_without_the_deadman_is_told_what_is_missing(js: Js) -> None:
    why = """(m, here) => {
      const deadman = { state: "waiting", text: "What the page sends arrives too late." };
      return m.whyText({ you_drive: true, driver: "you", asking: [], deadman }, here, false, {});
    }"""
    here = {"held": False, "doubted": False, "why": "", "grip": "the left Shift key"}
    missing = "Nothing moves without the deadman: let go of sticks and keys, then hold the left Shift key."
    assert js("hands/why.js", why, here | {"deflected": True}) == missing
    assert js("hands/why.js", why, here | {"deflected": False}).endswith("too late.")
    assert js("hands/why.js", why, here | {"deflected": True, "held": True}).endswith("too late.")


def test_a_standard_gamepad_means_what_game_controller_means(js: Js) -> None:
    buttons = "Array.from({length: 17}, (_, i) => ({pressed: i === 4, value: i === 7}))"
    device = f"{{axes: [0.5, -1, 1, 0.5], buttons: {buttons}}}"
    axes = js("hands/mapping.js", f"m => m.mappedAxes({device}, m.standardMapping())")
    assert axes == pytest.approx([-(0.5 - 0.08) / 0.92, 1, -1, -(0.5 - 0.08) / 0.92, 0, 1])
    pressed = js("hands/mapping.js", f"m => m.mappedButtons({device}, m.standardMapping())")
    assert [place for place, down in enumerate(pressed) if down] == [LEFT_SHOULDER]


def test_two_industrial_joysticks_are_the_two_hands(js: Js) -> None:
    device = "{axes: [1, -1], buttons: []}"
    both = js(
        "hands/mapping.js", f"m => [false, true].map((r) => m.mappedAxes({device}, m.joystickMapping(r)))"
    )
    assert both == [[-1, 1, 0, 0, 0, 0], [0, 0, -1, 1, 0, 0]]


def test_a_device_that_lost_an_axis_asks_for_nothing(js: Js) -> None:
    assert (
        js("hands/mapping.js", "m => m.mappedAxes({axes: [], buttons: []}, m.standardMapping())")
        == [0] * AXIS_COUNT
    )


def test_a_calibrated_axis_reaches_its_ends_from_its_centre(js: Js) -> None:
    steps = """async (m) => {
      const { Calibration } = await import("/web/hands/calibration.js");
      const mapping = m.joystickMapping(false);
      const at = (x, y) => ({ axes: [x, y], buttons: [] });
      const calibration = new Calibration(at(0.1, 0), mapping);
      for (const x of [0.7, -0.4, 0.1]) calibration.look(at(x, 0));
      const found = calibration.finish();
      return [[0.1, 0.7, -0.4].map((x) => m.mappedAxes(at(x, 0), found)[0]), found.axes[1]];
    }"""
    ends, untouched = js("hands/mapping.js", steps)
    assert ends == pytest.approx([0, -1, 1])
    assert untouched["high"] == 1  # an axis that was not moved keeps what it had


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("m.axes.pop()", "A mapping has 6 axes."),
        ("m.buttons = 3", "A mapping has 21 buttons."),
        ("m.axes[1].from = 'axis'", 'left_y: "from" is "axis N" or "button N".'),
        ("m.axes[0].invert = 1", 'left_x: "invert" is true or false.'),
        ("m.axes[0].deadzone = 0.9", 'left_x: "deadzone" is from 0 to 0.5.'),
        ("m.axes[3].centre = 1", 'right_y: "low", "centre" and "high" are numbers that rise.'),
        ("m.buttons[9] = -1", "left_shoulder: a button's number is from 0 to 63, or null."),
    ],
)
def test_a_mapping_that_cannot_be_is_refused_in_a_sentence(js: Js, change: str, told: str) -> None:
    steps = f"""(module) => {{
      const m = JSON.parse(JSON.stringify(module.standardMapping()));
      module.checkedMapping(m);
      {change};
      try {{ module.checkedMapping(m); }} catch (error) {{ return error.message; }}
    }}"""
    assert js("hands/mapping.js", steps) == told


def test_a_corner_of_the_square_that_was_passed_counts_and_the_way_on_is_told_from_where_the_tip_is(
    js: Js,
) -> None:
    steps = """(m) => {
      let attempt = m.begun(m.squareAt([5, 0, 1]));
      return [[5.5, 0, 1], [5.9, 0.05, 1], [5.8, 1.1, 1], [4.9, 1.1, 1], [5, 0.05, 1]].map((tip, i) => {
        attempt = m.after(attempt, tip, i);
        const [word, key, metres] = m.isDone(attempt) ? ["done", "", 0] : m.way(attempt, tip);
        return [attempt.side, word, key, Math.round(100 * metres)];
      });
    }"""
    told = [
        [0, "away", "W", 30],
        [1, "left", "A", 75],
        [2, "back", "S", 80],
        [3, "right", "D", 110],
        [4, "done", "", 0],
    ]
    assert js("exercise/square.js", steps) == told


def test_how_far_beside_the_square_the_tip_was_counts_the_way_and_not_the_time_it_stood_there(
    js: Js,
) -> None:
    steps = """(m) => {
      let attempt = m.begun(m.squareAt([5, 0, 1]));
      const drive = (x, y) => { attempt = m.after(attempt, [x, y, 1], time++); };
      let time = 0;
      const go = (x0, y0, x1, y1) => {
        for (let i = 1; i <= 40; i++) drive(x0 + ((x1 - x0) * i) / 40, y0 + ((y1 - y0) * i) / 40);
      };
      go(5, 0, 5.8, 0);
      go(5.8, 0, 5.8, 1.3);
      for (let i = 0; i < 1000; i++) drive(5.8 + 0.002 * (i % 2), 1.3);
      go(5.8, 1.3, 5.8, 0.8);
      go(5.8, 0.8, 5, 0.8);
      go(5, 0.8, 5, 0);
      return [m.isDone(attempt), m.result(attempt)];
    }"""
    done, found = js("exercise/square.js", steps)
    assert done
    assert found["most"] == pytest.approx(0.5, abs=0.01)
    along = 4 * 0.8 - 0.1  # the last corner is reached 0.1 m before it
    assert found["rms"] == pytest.approx(math.sqrt(2 * 0.5**3 / 3 / (along + 2 * 0.5)), rel=0.05)


def test_the_emergency_stop_is_told_once_by_its_own_panel(js: Js) -> None:
    seat = {
        "you_drive": True,
        "asking": [],
        "why_not": "",
        "deadman": {"state": "waiting", "text": "Release it."},
    }
    why = """(m, seat) => {
      const [here, status] = [{ held: true, why: "", you: "1" }, { armed: 1, factor: 1, limit: 0 }];
      return [false, true].map((stopped) => m.whyText(seat, here, stopped, status));
    }"""
    assert js("hands/why.js", why, seat) == ["Release it.", ""]


STANDING = """(m, [parts, logged, now]) => {
  const seat = { you_drive: true, asking: [], why_not: "", deadman: { state: "held", text: "" } };
  const status = { armed: 0, factor: 1, limit: 0 };
  return m.whyText(seat, { held: true, why: "" }, false, status, m.standingCause(parts, logged, now));
}"""
LOST = {"text": f"standing still: {motion_guard.LOST_STATE}", "at": 1000}
FROZEN = {"name": "crane/controller: machine", "level": "error", "text": "swing is frozen"}


@pytest.mark.parametrize(
    ("parts", "logged", "now", "said"),
    [
        ([], LOST, 1500, "The controller stopped: no state of the machine. Centre the sticks, then go on."),
        ([FROZEN], LOST, 1500, "The controller stopped: swing is frozen. Centre the sticks, then go on."),
        ([FROZEN | {"level": "warning"}], LOST, 12_000, "Centre the sticks, then go on."),
        ([FROZEN | {"name": "simulator: machine"}], None, 0, "Centre the sticks, then go on."),
    ],
)
def test_who_holds_the_deadman_of_a_controller_that_stands_reads_why_and_what_to_do(
    js: Js, parts: list[dict[str, str]], logged: dict[str, Any] | None, now: float, said: str
) -> None:
    assert [
        js("hands/why.js", "(m, text) => m.isStanding(text)", text) for text in (LOST["text"], "well")
    ] == [
        True,
        False,
    ]
    assert js("hands/why.js", STANDING, [parts, logged, now]) == said


def test_history_keeps_the_newest_frames_and_begins_anew_when_time_goes_back(js: Js) -> None:
    steps = """(m) => {
      const history = new m.History(2, 3);
      const push = (time, ...values) => history.push({ time, values });
      for (const time of [1, 2, 3, 4]) push(time, time, -time);
      push(4, 5, -5);
      push(9, 1, 2, 3);
      const kept = history.series(1);
      const told = [[...kept.times], [...kept.values], history.newest(0)];
      push(2, 7, 8);
      return [...told, [...history.series(0).values], String(history.newest(undefined))];
    }"""
    assert js("history.js", steps) == [[2, 3, 4], [-2, -3, -5], 5, [7], "NaN"]


def test_energy_is_the_integral_of_power_and_gaps_add_nothing(js: Js) -> None:
    assert js("instruments/lines.js", "m => m.integral([0, 1, 2, 3, 4], [2, 4, NaN, 6, 8])") == [
        0,
        3,
        3,
        3,
        10,
    ]


def test_the_tip_error_is_the_way_that_the_command_of_the_last_second_was_missed_by(js: Js) -> None:
    steps = """(m) => {
      const times = Array.from({ length: 25 }, (_, i) => i / 8);
      const zero = times.map(() => 0);
      const x = times.map((t) => 0.3 * t);
      const vx = times.map((_, i) => (i === 20 ? NaN : 0.4));
      return m.pathError(1, times, x, zero, zero, vx, zero, zero);
    }"""
    error = js("instruments/lines.js", steps)
    unknown = [place for place, value in enumerate(error) if value != value]
    assert unknown == [*range(8), *range(20, 25)]  # before a whole second is known, and while a gap is in it
    assert error[8:20] == pytest.approx([0.1] * 12)


MESSAGES = (
    *filter(None, joystick_watch.PROBLEMS.values()),
    *(motion_guard.GOES_BACK, motion_guard.LOST_STATE, motion_guard.PRESSED),
    *(
        command_gate.NOT_ZERO,
        "no command",
        "valve driver: no voltages",
        "valve driver: keeps the valves shut",
    ),
    "joint state: boom is 3.1 rad; allowed: 0.100 .. 1.200",
    "machine: boom goes by itself, 3 degrees though its valve is shut; allowed: shut off the hydraulics",
    "joint state: boom moves at 9 rad/s; allowed: up to 5",
    "valve_commands: boom is 12 V, clipped to its rating of 10 V",
    "hydraulics/pressures: 3 values; allowed: 12; the nominal load is taken",
    *(f"waiting for {what} on /x" for what in ("a joystick", "the machine's state", "commands", "voltages")),
    "/joy of /driver is not heard: best effort",
    f"the graph starts: {motion_guard.LOST_STATE}",
)


@pytest.mark.parametrize("text", MESSAGES)
def test_every_message_of_our_nodes_has_something_to_do(js: Js, text: str) -> None:
    remedy = "(m, text) => m.remedy(text)"
    assert js("diagnostics/remedies.js", remedy, text) != js("diagnostics/remedies.js", remedy, "of others")


def test_every_choice_that_is_made_while_driving_has_a_sentence(js: Js) -> None:
    choices = [("profile", name) for name in shipped()]
    for setting, kinds in (("scheme", Scheme), ("mode", Mode), ("axis_frame", Frame)):
        choices += [(setting, kind.name.lower()) for kind in kinds]
    said = js("settings/meanings.js", "(m, choices) => choices.map((one) => m.meaning(...one))", choices)
    assert len(said) == 14
    assert all(said)
    assert js("settings/meanings.js", "m => m.meaning('tip_speed', 0.5)") == ""


def test_troubles_are_told_the_worst_first_and_what_is_well_is_not(js: Js) -> None:
    parts = [
        {"name": "b", "level": "warning", "text": "waits"},
        {"name": "c", "level": "ok", "text": "well"},
        {"name": "a", "level": "warning", "text": "clips"},
        {"name": "d", "level": "error", "text": "stopped"},
        {"name": "e", "level": "error", "text": "stopped"},
    ]
    found = js("diagnostics/remedies.js", "(m, parts) => m.troubles(parts)", parts)
    assert [part["name"] for part in found] == ["d, e", "a", "b"]  # what two say is told once


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ((True, "recording to mine"), "mine: 00:00:05, 2 kB. recording to mine"),
        ((True, "0:00:31.7, 3.46 MB, lost 0"), "mine: 0:00:31.7, 3.46 MB, lost 0"),
        ((False, "Nothing is recorded."), "Nothing is recorded."),
        (
            (False, "recorded 9000 messages, 30 topics, lost 9, 9 of /joy: mine"),
            "recorded 9000 messages, 30 topics, lost 9: mine",
        ),
        (
            (False, "recorded 900 messages, 30 topics, lost 9, 5 of /joy, 4 of /a/b: mine"),
            "recorded 900 messages, 30 topics, lost 9: mine. Too many are lost for figures.",
        ),
        (
            (False, "recorded 0 messages, 0 topics, lost 0: mine"),
            "recorded 0 messages, 0 topics, lost 0: mine. Nothing was heard: record longer.",
        ),
    ],
)
def test_a_recordings_losses_are_told_once_with_what_they_mean(
    js: Js, told: tuple[bool, str], said: str
) -> None:
    state = {
        "active": told[0],
        "hears": told[0],
        "name": "mine",
        "seconds": 5,
        "bytes": 2000,
        "text": told[1],
    }
    assert js("panels/recording.js", "(m, state) => m.stateText(state)", state) == said
