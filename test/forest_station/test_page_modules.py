"""The page's pure modules, imported by a browser: what the hands, the history and the instruments compute."""

import shutil
from pathlib import Path

import page_stand_in
import pytest
from page_stand_in import Js

from forest_control.config.profile_file import shipped
from forest_control.config.workspace_file import shipped as shipped_workspaces
from forest_control.limits.velocity_scaling import Limit
from forest_control.operator import joystick_watch
from forest_control.operator.levers import AXIS_COUNT, BUTTON_COUNT, LEFT_SHOULDER
from forest_control.operator.operator_profile import Frame, Mode
from forest_control.safety import machine_file_check, motion_guard
from forest_control.safety.machine_file_check import FileCheck
from forest_control.servo.schemes import Scheme
from forest_control.valve import command_gate, valve_driver
from forest_description.types import AXES
from forest_msgs_py.interfaces.topics import JOY_AXES, JOY_BUTTONS
from forest_station.operator.deadman import TOO_LATE
from forest_station.operator.hands_message import Hands, decode_hands, encode_hands
from forest_station.scene.surroundings import CLEARING


@pytest.mark.parametrize("module", ["hands/none.js", "dropped/imports_none.js"])
def test_a_module_that_is_missing_fails_a_test_and_is_named(
    js: Js, module: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    shutil.copytree(page_stand_in.WEB, tmp_path / "web")
    (tmp_path / "web/dropped").mkdir()
    (tmp_path / "web/dropped/imports_none.js").write_text('import "/web/hands/none.js";', encoding="utf-8")
    monkeypatch.setattr(page_stand_in, "WEB", tmp_path / "web")
    with pytest.raises(pytest.fail.Exception, match=r"the page has no file /web/hands/none\.js"):
        js(module, "(m) => m")


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
    slowly = "(m, keys) => m.wantedAxes(keys, 0.25)"
    assert js("hands/keys.js", slowly, ["KeyW", "KeyD"]) == [-0.25, 0.25, 0, 0, 0, 0]


def test_two_keys_choose_how_far_a_key_pushes_a_stick(js: Js) -> None:
    steps = """(m) => ["KeyQ", "KeyQ", "KeyQ", "KeyE", "KeyE", "KeyE"].map((code, i, all) =>
      all.slice(0, i + 1).reduce((speed, key) => m.nextSpeed(speed, key), 1))"""
    assert js("hands/keys.js", steps) == [0.5, 0.25, 0.25, 0.5, 1, 1]


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
    assert js("hands/deadman.js", steps) == [[True, True, True, False], ""]  # a release explains itself


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


def test_hands_that_are_often_too_late_are_told_what_is_to_be_done_about_the_computer(js: Js) -> None:
    steps = """async (m) => {
      const { adviceFor } = await import("/web/hands/why.js");
      const lateness = new m.Lateness();
      const deadman = { state: "ready", cause: "" };
      const seat = { you_drive: true, driver: "you", asking: [], deadman };
      return [0, 61_000, 61_500].map((now) => {
        lateness.count(now);
        const often = lateness.isOften(now);
        const here = { held: false, doubted: false, why: m.TOO_LATE, grip: "the key", often };
        return [here, { ...here, doubted: true }].map((one) => adviceFor(seat, one, false, {}).text);
      });
    }"""
    late = "Sticks and keys came too late: this computer or the network is too busy."
    pressed = f"{late} Let go of the key."
    remedies = "Close programs, shrink the window, or click pictures/s to stop them."
    once = [f"{late} Hold the key, then move a stick.", pressed]
    often = [f"{late} {remedies}", pressed]
    assert js("hands/late.js", steps) == [once, once, often]


def test_the_page_and_the_server_say_the_same_of_hands_that_come_too_late(js: Js) -> None:
    assert js("hands/late.js", "(m, told) => m.isLateness(told)", TOO_LATE)
    assert not js("hands/late.js", "(m) => m.isLateness('the window lost the focus')")
    shown = "(m, told) => [m.TOO_LATE.toLowerCase() + '.', told.toLowerCase()]"
    page, server = js("hands/late.js", shown, TOO_LATE)
    assert page == server


def test_the_figure_of_a_slow_drawing_says_how_to_stop_it(js: Js) -> None:
    told = js("scene/overlay.js", "(m) => [m.rateText(1, 0.4), m.rateText(5, 0.4), m.rateText(60, 1)]")
    assert told == [
        "1 picture/s, 40 % sharp: click to stop",
        "5 pictures/s, 40 % sharp",
        "60 pictures/s, 100 % sharp",
    ]


def test_a_browser_without_webgl_is_told_how_to_start_chromium(js: Js) -> None:
    failed = ["Error creating WebGL context.", "x"]
    told, other = js("scene/overlay.js", "(m, texts) => texts.map(m.failureText)", failed)
    options = "--use-angle=swiftshader --enable-unsafe-swiftshader"
    remedy = f"Without a graphics processor start Chromium with {options}."
    assert told == f"The crane cannot be drawn: Error creating WebGL context. {remedy}"
    assert other == "The crane cannot be drawn: x."


def test_without_a_connection_the_page_says_where_to_look(js: Js) -> None:
    why = """(m) => {
      const told = (lost) => m.adviceFor(null, { lost }, false, {}).text;
      return [told(""), told(m.lostText("")), told(m.lostText("The station ends."))];
    }"""
    first, lost, ended = js("hands/why.js", why)
    assert "does scripts/station.sh run?" in first
    assert lost.startswith("The crane stands still until the page is connected again.")
    assert ended == "The station ends. Its terminal says why. Start scripts/station.sh anew."


def test_a_limit_that_lets_nothing_through_is_no_slowing_to_nothing(js: Js) -> None:
    why = """(m, [limit, axis]) => {
      const seat = { you_drive: true, driver: "you", asking: [], deadman: { state: "held" } };
      const told = (factor) => m.adviceFor(seat, { held: true }, false, { factor, limit, axis }).text;
      return [0, 0.004, 0.28, 0.997].map(told);
    }"""
    held = "Held back by the flow of the pumps."
    assert js("hands/why.js", why, [Limit.FLOW, ""]) == [
        held,
        held,
        "Slowed to 28 % by the flow of the pumps.",
        "",
    ]
    held = "Held back: the boom joint is at its limit."
    told = js("hands/why.js", why, [Limit.JOINT, "boom"])
    assert told == [held, held, "Slowed to 28 %: the boom joint nears its limit.", ""]
    assert js("hands/why.js", why, [Limit.JOINT, ""])[0] == "Held back: the joint is at its limit."
    wall = "Held back by a wall: along it and away from it the tip is free."
    assert js("hands/why.js", why, [Limit.WALL, ""]) == [wall] * 4
    told = [js("hands/why.js", why, [Limit.RATE, axis])[2] for axis in ("stick", "")]
    assert told == [f"Slowed to 28 % by {who} joint's greatest speed." for who in ("the stick", "a")]


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


@pytest.mark.parametrize(("software", "rest", "longest"), [(False, 1, 80), (True, 3, 1000)])
def test_a_picture_that_takes_longer_gets_a_longer_rest_and_becomes_coarser(
    js: Js, software: bool, rest: float, longest: float
) -> None:
    steps = """(m, [software, took]) => {
      const resolution = new m.Resolution(software);
      const shares = [resolution.share];
      for (let i = 0, now = 0; i < 60; i++, now += took + resolution.rest()) {
        if (resolution.drawn(now, now + took)) shares.push(resolution.share);
      }
      return [resolution.rest(), shares.at(-1)];
    }"""
    for took, reached in ((10, 1.0), (400, 0.3)):
        rested, share = js("scene/resolution.js", steps, [software, took])
        assert rested == pytest.approx(min(longest, rest * took))
        assert share == reached


@pytest.mark.parametrize(
    ("took", "count", "rounds"),
    [(1, 6, 20), (1, 16, 13), (15, 4, 4)],  # in a second: at most 20, and a fifth of the time for drawing
)
def test_charts_are_drawn_one_after_the_other_and_rest_in_proportion_to_what_they_took(
    js: Js, took: float, count: int, rounds: int
) -> None:
    steps = """async (m, [took, count]) => {
      let now = 0;
      const [told, failed] = [[], []];
      const pause = (time) => {
        now += time;
        told.push(time > 0 ? "rest" : "pause");
        return now < 1000 ? null : new Promise(() => {});
      };
      const charts = new m.Rounds({ now: () => now, pause });
      globalThis.reportError = ({ message }) => failed.push(message);
      const broken = { drawNew: () => { throw new Error("of one chart"); } };
      const idle = { drawNew: () => false };
      const drawn = (i) => ({ drawNew: () => ((now += took), told.push(i), true) });
      const all = [broken, idle, ...Array.from({ length: count }, (_, i) => drawn(i))];
      for (const chart of all) charts.add(chart);
      await new Promise((resolve) => setTimeout(resolve)); // all of its steps have been taken by then
      return [told, failed];
    }"""
    told, failed = js("instruments/drawing.js", steps, [took, count])
    one_round = [step for i in range(count) for step in (i, "pause")] + ["rest"]
    assert told == ["rest", *rounds * one_round][: len(told)]
    assert told.count("rest") == rounds  # the first one, which fails, among them
    assert failed == ["of one chart"]


def test_the_clock_of_the_hands_beats_every_20_ms_from_a_thread_of_its_own(js: Js) -> None:
    beats = """async () => {
      const clock = new Worker("/web/hands/clock.js");
      const beat = () => new Promise((heard) => (clock.onmessage = heard));
      await beat();
      const begun = performance.now();
      for (let i = 0; i < 50; i++) await beat();
      const took = performance.now() - begun;
      let queued = 0;
      clock.onmessage = () => queued++;
      const until = performance.now() + 300;
      while (performance.now() < until); // a page that hangs
      await new Promise((soon) => setTimeout(soon, 5));
      clock.terminate();
      return [took, queued];
    }"""
    took, queued = js("hands/joy.js", beats)
    assert 900 <= took <= 3000  # 50 periods; a busy computer may be late, never early
    assert queued >= 3  # it went on meanwhile


def test_labels_keep_off_each_other_and_off_what_lies_over_the_picture(js: Js) -> None:
    labels = [
        {"key": "bend", "text": "bent by 2 cm", "kind": "rigid", "x": 200, "y": 300},
        {"key": "reach", "text": "reach 6.39 m", "kind": "figure", "x": 210, "y": 305},
        {"key": "goal", "text": "drive here", "kind": "goal", "x": 205, "y": 300},
        {"key": "limit", "text": "boom: joint limit", "kind": "limit", "x": 200, "y": 336},
        {"key": "lost", "text": "bent by 3 cm", "kind": "rigid", "x": -50, "y": 900},
        {"key": "height", "text": "height 3.17 m", "kind": "figure", "x": 5, "y": 590},
    ]
    button = [0, 550, 390, 600]
    found = js(
        "scene/placing.js",
        "(m, [labels, button]) => m.placed(labels, { width: 390, height: 600 }, [button])",
        [labels, button],
    )
    at = {label["key"]: (label["x"], label["y"]) for label in found}
    assert at["limit"] == (200, 300)  # the most important has its place, above what it names
    assert "lost" not in at
    boxes = [button]
    for label in found:
        half, (x, y) = 4.5 * len(label["text"]) + 12, (label["x"], label["y"])
        boxes.append([x - half, y - 14, x + half, y + 14])
    assert len(boxes) == 6
    for i, one in enumerate(boxes):
        for other in boxes[:i]:
            assert one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1]


CAMERAS = """async (m, [scene, width, height, act]) => {
  localStorage.clear();
  const cameras = new m.Cameras(document.createElement("canvas"), scene);
  cameras.resize(width, height);
  return (0, eval)(act)(cameras);
}"""
SCENE = {"work_area": {"section": [[2.0, -1.0], [8.0, 4.0]]}, "ground": -2.2}
TREES_BEGIN = CLEARING * 8.0 - 2.4  # [m] from the swing axis: the inner ones' boughs


def test_labels_know_the_places_of_sticks_that_lie_over_the_picture(js: Js) -> None:
    taken = """({ Labels }) => {
      const put = (parent, name, left, top, width, height) => {
        const element = document.createElement("div");
        Object.assign(element.style, { position: "fixed", inset: `${top}px auto auto ${left}px` });
        Object.assign(element.style, { width: `${width}px`, height: `${height}px` });
        element.className = element.id = name;
        parent.append(element);
        return element;
      };
      const scene = put(document.body, "scene", 20, 90, 800, 300);
      const stick = put(put(document.body, "sticks", 20, 90, 800, 300), "stick", 30, 250, 100, 120);
      const { taken } = new Labels(put(scene, "labels", 20, 90, 800, 300));
      for (const part of [scene, stick.parentElement]) part.remove();
      return taken;
    }"""
    assert js("scene/labels.js", taken) == [[10, 160, 110, 280]]


@pytest.mark.parametrize("width", [1600, 900, 390])
def test_no_tree_stands_between_the_side_camera_and_the_crane(js: Js, width: int) -> None:
    look = """(cameras) => {
      cameras.choose("side");
      cameras.jump();
      cameras.camera.updateMatrixWorld();
      cameras.camera.updateProjectionMatrix();
      const far = cameras.camera.position.clone().set(8, 0, 0).project(cameras.camera);
      return [Math.hypot(...cameras.camera.position.toArray().slice(0, 2)), far.x];
    }"""
    away, reach = js("scene/cameras.js", CAMERAS, [SCENE, width, 550, look])
    assert away < TREES_BEGIN
    assert 0 < reach < 1  # the farthest the crane reaches is in the picture


@pytest.mark.parametrize("covered", [0.3, 0.5])
def test_the_camera_follows_the_tip_of_an_exercise_below_the_text_until_somebody_drags(
    js: Js, covered: float
) -> None:
    look = """(cameras) => {
      cameras.covered = COVERED;
      const corners = [[5, 0, 1], [5.8, 0, 1], [5.8, 0.8, 1], [5, 0.8, 1]];
      cameras.watch(corners, 0.8);
      const seen = (points) => {
        const { camera } = cameras;
        camera.updateMatrixWorld();
        camera.updateProjectionMatrix();
        const project = (point) => camera.position.clone().set(...point).project(camera);
        return points.map(project).map(({ x, y }) => [x, y]);
      };
      const views = [[5, 0, 1], [7.5, -2, 1], [3, 3, 2]].map((tip) => {
        cameras.step(100, 0, tip);
        const watched = [...corners, tip];
        const middle = [0, 1, 2].map((i) => watched.map((point) => point[i]).sort((a, b) => a - b));
        return seen([...watched, middle.map((sorted) => 0.5 * (sorted[0] + sorted.at(-1)))]);
      });
      cameras.controls.dispatchEvent({ type: "start" });
      const before = cameras.camera.position.toArray();
      cameras.step(100, 0, [9, 0, 1]);
      const stays = cameras.camera.position.distanceTo(cameras.camera.position.clone().set(...before));
      cameras.choose("free");
      cameras.step(100, 0, [5, 0, 1]);
      return [views, stays, cameras.following];
    }"""
    views, stays, follows = js(
        "scene/cameras.js", CAMERAS, [SCENE, 390, 550, look.replace("COVERED", str(covered))]
    )
    for view in views:
        for x, y in view:
            assert -1 < x < 1
            assert -1 < y < 1 - 2 * covered  # below what covers the upper part
        assert view[-1] == pytest.approx([0.0, -covered], abs=1e-3)  # the middle of what is left
    assert stays < 0.1
    assert follows  # the button of the view brings it back


def test_an_exercise_is_drawn_as_much_smaller_as_text_leaves_less_of_the_picture(js: Js) -> None:
    look = """(cameras) => [0, 0, 0.25, 0.5].map((covered) => {
      cameras.covered = covered;
      cameras.watch(null);
      cameras.watch([[5, 0, 1], [5.8, 0, 1], [5.8, 0.8, 1], [5, 0.8, 1]], 0.8);
      cameras.step(100, 0, [5, 0, 1]);
      return cameras.camera.position.distanceTo(cameras.controls.target);
    })"""
    _, whole, *distances = js("scene/cameras.js", CAMERAS, [SCENE, 390, 550, look])
    assert distances == pytest.approx([whole / 0.75, whole / 0.5], rel=0.01)


def test_the_sticks_say_what_they_move_in_each_scheme_and_frame(js: Js) -> None:
    words = """(m) => [[], ["coordinated", "cylindrical"], ["joint", "cartesian"]].map((chosen) => {
      const { away, left, up } = m.moves(...chosen);
      return [away, left, up];
    })"""
    assert js("hands/moves.js", words) == [
        ["away", "left", "up"],
        ["out", "round left", "up"],
        ["stick out", "swing left", "boom up"],
    ]
    meant = "(m) => ['joint', 'coordinated'].map((scheme) => m.meaning('mode', 'rate', scheme))"
    assert js("settings/meanings.js", meant) == [
        "The farther the stick, the faster the joint.",
        "The farther the stick, the faster the tip.",
    ]


def test_a_bag_that_is_opened_or_loading_says_so(js: Js) -> None:
    said = """(m) => [
      m.beforeText({ active: false, opening: "mine" }), m.beforeText({ active: false, opening: "" }),
      m.beforeText({ active: true, opening: "other" }),
      ...[true, false].map((isLoading) => m.timeText({ time: 1, bag: { seconds: 2 }, isLoading })),
    ]"""
    assert js("panels/replay.js", said) == [
        "The recording mine is being opened: the crane that you see is the live one.",
        "",
        "",
        "1.00 of 2.00 s, loading",
        "1.00 of 2.00 s",
    ]


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


def test_a_chart_has_always_the_same_frames_of_the_history_and_the_newest(js: Js) -> None:
    steps = """(m) => {
      const history = new m.History(1, 7);
      return [6, 7, 8, 9, 10].map((last) => {
        while (history.count <= last) history.push({ time: history.count, values: [history.count] });
        return [...history.series(0, 3).values];
      });
    }"""
    assert js("history.js", steps) == [[0, 3, 6], [3, 6, 7], [3, 6, 8], [3, 6, 9], [6, 9, 10]]


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
        valve_driver.NO_PUMP,
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


def test_a_pump_s_pressure_of_another_machine_s_file_asks_for_the_right_file(js: Js) -> None:
    text = machine_file_check.objection(FileCheck(wrong=machine_file_check.LIGHT, starved=True))
    assert "this crane's machine file" in js("diagnostics/remedies.js", "(m, text) => m.remedy(text)", text)


def test_every_choice_that_is_made_while_driving_has_a_sentence(js: Js) -> None:
    choices = [("profile", name) for name in shipped()]
    for setting, kinds in (("scheme", Scheme), ("mode", Mode), ("axis_frame", Frame)):
        choices += [(setting, kind.name.lower()) for kind in kinds]
    choices += [(name, value) for name in ("adapt", "anti_sway") for value in (False, True)]
    choices += [("workspace", name) for name in ("", *shipped_workspaces())]
    said = js("settings/meanings.js", "(m, choices) => choices.map((one) => m.meaning(...one))", choices)
    assert len(said) == 20
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


def test_parts_of_nodes_are_named_as_an_operator_calls_them(js: Js) -> None:
    stop = {"level": "error", "text": "emergency stop pressed"}
    parts = [stop | {"name": f"{node}: emergency stop"} for node in ("controller", "valve_driver")]
    named = "(m, parts) => m.troubles(parts).map(({ name }) => name)"
    assert js("diagnostics/remedies.js", named, parts) == ["emergency stop: control, valves"]
    parts = [stop | {"name": name} for name in ("north/simulator: machine", "engine: oil: hot")]
    told = ["north/simulated crane: machine, engine: oil: hot"]
    assert js("diagnostics/remedies.js", named, parts) == told


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ((True, "recording to mine"), "mine: 00:00:05, 2 kB."),
        ((True, "0:00:31.7, 3.46 MB, lost 0"), "mine: 0:00:31.7, 3.46 MB, lost 0"),
        ((False, "Nothing is recorded."), "Nothing is recorded."),
        (
            (False, "recorded 9000 messages, 30 topics, lost 9, 9 of /joy: mine"),
            "Recorded 9000 messages, 30 topics, lost 9 in 1 topic: mine",
        ),
        (
            (False, "recorded 900 messages, 30 topics, lost 9, 5 of /joy, 4 of /a/b: mine"),
            "Recorded 900 messages, 30 topics, lost 9 in 2 topics: mine. Too many are lost for figures.",
        ),
        (
            (False, "recorded 0 messages, 0 topics, lost 0: mine"),
            "Recorded 0 messages, 0 topics, lost 0: mine. Nothing was heard: record longer.",
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


def test_what_was_lost_of_each_topic_is_told_apart_at_the_end(js: Js) -> None:
    text = "recorded 900 messages, 30 topics, lost 9, 5 of /joy, 4 of /a/b: mine"
    told = "(m, text) => [true, false].map((active) => m.lossesText({ active, text }))"
    assert js("panels/recording.js", told, text) == ["", "5 of /joy, 4 of /a/b"]
    assert js("panels/recording.js", told, "recorded 9 messages, 3 topics, lost 0: mine") == ["", ""]
