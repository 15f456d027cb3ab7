"""What the operator's page says of its hands, in a real browser whose clock goes as far as a test lets it."""

import page_words
import pytest
from page_stand_in import Js, PageStandIn
from paused_page import wait

from forest_control.operator.levers import AXIS_COUNT, LEFT_SHOULDER, LEFT_X, LEFT_Y, RIGHT_Y
from forest_msgs_py.interfaces.topics import JOY_AXES
from forest_station.operator.deadman import TOO_LATE

RIGHT_X = JOY_AXES.index("right_x")
CENTRED = (0.0,) * AXIS_COUNT
SIGNALS = (("controller/status/armed", "1"), *((f"tip/pose/{axis}", "m") for axis in "xyz"))
TIP = (5.0, 0.0, 1.0)  # [m]
PHONES = [(390, 844), (844, 390)]
SIZES = [(1280, 800), (900, 600), *PHONES]
CHOICE = {"type": "str", "text": "", "live": True, "choices": ["joint", "coordinated"]}


def centre_of(met: PageStandIn, selector: str) -> tuple[float, float]:
    """Return where the middle of an element is [px]."""
    box = met.page.locator(selector).bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_messages_are_numbered_and_tell_of_the_newest_pong(met: PageStandIn) -> None:
    wait(met, lambda hands: hands.pong > 0)
    numbers = [hands.number for hands in met.heard]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert all(later.sent > earlier.sent for earlier, later in zip(met.heard, met.heard[1:], strict=False))


def test_keys_drive_while_shift_is_held(met: PageStandIn) -> None:
    met.page.keyboard.down("Shift")
    pressed = wait(met, lambda hands: hands.held)
    assert pressed.buttons == 1 << LEFT_SHOULDER
    assert pressed.axes == CENTRED
    for key, axis, sign in (("w", LEFT_Y, 1), ("d", LEFT_X, -1), ("ArrowDown", RIGHT_Y, -1)):
        met.page.keyboard.down(key)
        assert wait(met, lambda hands, a=axis, s=sign: hands.axes[a] == s).held  # type: ignore[misc]
        met.page.keyboard.up(key)
        wait(met, lambda hands: hands.axes == CENTRED)
    met.page.keyboard.up("Shift")
    assert wait(met, lambda hands: not hands.held).buttons == 0


def test_a_mouse_moves_a_stick_and_its_release_centres_it(met: PageStandIn) -> None:
    x, y = centre_of(met, "#left_stick")
    met.page.mouse.move(x + 10, y + 10)
    met.page.mouse.down()
    met.page.mouse.move(x + 10, y - 200, steps=5)
    assert wait(met, lambda hands: hands.axes[LEFT_Y] == 1.0).axes[LEFT_X] == 0.0
    met.page.mouse.move(x + 200, y + 10, steps=5)
    wait(met, lambda hands: hands.axes[LEFT_X] == -1.0 and hands.axes[LEFT_Y] == 0.0)
    met.page.mouse.up()
    wait(met, lambda hands: hands.axes == CENTRED)


def test_two_fingers_move_two_sticks_while_a_third_holds_the_deadman(phone: PageStandIn) -> None:
    met = phone
    fingers = {
        0: centre_of(met, "#left_stick"),
        1: centre_of(met, "#right_stick"),
        2: centre_of(met, ".hold"),
    }
    touch = met.page.context.new_cdp_session(met.page)

    def send(kind: str, **moved: float) -> None:
        points = [{"x": x, "y": y + moved.get(f"y{i}", 0), "id": i} for i, (x, y) in fingers.items()]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    send("touchStart")
    assert wait(met, lambda hands: hands.held).axes == CENTRED
    send("touchMove", y0=-150, y1=150)
    driven = wait(met, lambda hands: hands.axes[LEFT_Y] == 1.0 and hands.axes[RIGHT_Y] == -1.0)
    assert driven.held
    fingers.clear()
    send("touchEnd")
    wait(met, lambda hands: not hands.held and hands.axes == CENTRED)


DOUBTS = (
    "window.dispatchEvent(new Event('blur'))",
    "document.dispatchEvent(new Event('visibilitychange'))",
    "document.dispatchEvent(new Event('fullscreenchange'))",
    "document.body.dispatchEvent(new PointerEvent('pointercancel', {bubbles: true}))",
    "document.body.dispatchEvent(new Event('touchcancel', {bubbles: true}))",
    "document.body.dispatchEvent(new MouseEvent('contextmenu', {bubbles: true}))",
    "document.querySelector('.hold').dispatchEvent(new PointerEvent('lostpointercapture', {pointerId: 1}))",
)


def test_any_doubt_about_the_hand_lets_the_deadman_go_until_it_is_pressed_anew(met: PageStandIn) -> None:
    met.page.mouse.move(*centre_of(met, ".hold"))
    for doubt in DOUBTS:
        met.page.mouse.down()
        wait(met, lambda hands: hands.held)
        met.page.evaluate(doubt)
        released = wait(met, lambda hands: not hands.held)
        met.page.clock.run_for(200)
        held = [hands.number for hands in met.heard if hands.held and hands.number > released.number]
        assert held == [], doubt
        met.page.mouse.up()


def test_a_button_that_loses_the_focus_to_another_one_is_no_doubt(met: PageStandIn) -> None:
    met.page.get_by_role("button", name="Read the list again").focus()
    met.page.keyboard.down("Shift")
    held = wait(met, lambda hands: hands.held)
    met.page.get_by_role("button", name="Mark a square").focus()
    met.page.clock.run_for(200)
    assert all(hands.held for hands in met.heard if hands.number > held.number)
    met.page.keyboard.up("Shift")
    wait(met, lambda hands: not hands.held)


def test_what_a_newcomer_reads_is_in_sight_beside_the_crane_and_on_a_phone_over_it(
    met: PageStandIn, phone: PageStandIn
) -> None:
    for page, place in ((met.page, "#left"), (phone.page, "#scene")):
        text = page.locator(f"{place} > #first_minute p")
        assert text.is_visible()
        assert "Mark a square" in text.inner_text()


def test_a_page_that_hung_has_let_go(met: PageStandIn) -> None:
    met.page.keyboard.down("Shift")
    wait(met, lambda hands: hands.held)
    met.page.clock.fast_forward(101)
    wait(met, lambda hands: not hands.held)
    met.page.wait_for_selector(f"#message :text('{TOO_LATE} Let go of the left Shift key.')")
    met.page.wait_for_selector(".deadman[data-state=pressed]")
    met.page.keyboard.up("Shift")
    met.page.clock.run_for(20)
    met.page.wait_for_selector(".deadman[data-state=waiting]")


def test_a_bag_that_cannot_be_replayed_says_why_beside_the_list(met: PageStandIn) -> None:
    page, bag = met.page, {"name": "empty", "bytes": 2000, "modified": 0, "seconds": 0}
    page.route("**/bags.json", lambda route: route.fulfill(json=[bag]))
    page.route("**/bags/empty.json", lambda route: route.fulfill(status=400, body="empty has no messages"))
    page.get_by_role("button", name="Read the list again").click()
    page.get_by_role("button", name="Replay").click()
    page.wait_for_selector("#recording >> text=The recording cannot be replayed: empty has no messages")
    for pattern in ("**/bags.json", "**/bags/empty.json"):
        page.unroute(pattern)


def test_a_gamepad_drives_and_its_unplugging_lets_go(met: PageStandIn) -> None:
    met.page.evaluate("plugIn('Pad (STANDARD GAMEPAD)', 'standard', 4, 17)")
    met.page.evaluate("Object.assign(pads[0].buttons[4], {pressed: true, value: 1})")
    wait(met, lambda hands: hands.held)
    met.page.evaluate("pads[0].axes = [1, -1, 0, 1]")
    assert wait(met, lambda hands: hands.axes[LEFT_Y] == 1.0).axes == (-1.0, 1.0, 0.0, -1.0, 0.0, 0.0)
    met.page.evaluate("pads[0].connected = false")
    wait(met, lambda hands: not hands.held and hands.axes == CENTRED)


def test_a_mapping_is_edited_calibrated_and_kept_for_its_device(met: PageStandIn) -> None:
    page = met.page
    page.evaluate("plugIn('Joystick L', '', 3, 2); plugIn('Joystick R', '', 2, 2)")
    page.evaluate("pads[1].axes = [0.9, 0]")
    wait(met, lambda hands: hands.axes[RIGHT_X] < -0.8)  # the second joystick is the right hand's
    page.evaluate("pads[1].axes = [0, 0]")
    page.clock.run_for(200)
    device = page.locator("#gamepads details").first
    device.locator("summary").click()
    device.get_by_label("left_y: from").select_option("axis 2")
    device.get_by_label("left_y: invert").uncheck()
    device.get_by_label("deadman button").select_option("1")
    device.get_by_role("button", name="Calibrate").click()
    for value in (-0.5, 0.5, 0):
        page.evaluate("(value) => (pads[0].axes = [0, 0, value])", value)
        page.clock.run_for(200)  # two looks
    device.get_by_role("button", name="Done").click()
    page.reload()
    page.wait_for_selector(".driver[data-drives=true]")  # taking over lets the deadman go
    page.evaluate("plugIn('Joystick L', '', 3, 2)")
    page.evaluate("pads[0].axes = [0, 0, 0.5]; Object.assign(pads[0].buttons[1], {pressed: true})")
    wait(met, lambda hands: hands.axes[LEFT_Y] == 1.0 and hands.held)


def test_a_gamepad_that_rests_aside_is_named_and_one_without_a_deadman_is_no_grip(met: PageStandIn) -> None:
    page, line = met.page, met.page.locator("#message p")
    page.evaluate("plugIn('Acme Stick (Vendor: 1234 Product: 5678)', '', 2, 2)")
    page.evaluate("pads[0].axes = [0.2, 0]")
    met.tell_seat(deadman=("ready", ""))
    page.clock.run_for(400)
    assert line.inner_text().startswith("Let go of Acme Stick, or calibrate it")
    page.evaluate("pads[0].axes = [0, 0]")
    page.clock.run_for(400)
    assert line.inner_text() == "Hold the left Shift key, then move a stick."
    device = page.locator("#gamepads details")
    device.locator("summary").click()
    narrow = """() => [...document.querySelectorAll("#gamepads :is(select, meter)")].filter((part) => {
      const { left, right } = part.getBoundingClientRect();
      return right - left < 60 || right > document.getElementById("left").clientWidth;
    }).length"""
    assert page.evaluate(narrow) == 0
    device.get_by_label("deadman button").select_option("1")
    page.clock.run_for(400)
    assert "or the gamepad's left shoulder" in line.inner_text()
    page.get_by_role("button", name="As usual").click()
    met.tell_seat()


def test_who_looks_on_sends_nothing_asks_for_control_and_the_driver_hands_over(met: PageStandIn) -> None:
    met.tell_seat(asking=("operator 2",))
    met.page.get_by_role("button", name="Hand over to operator 2").click()
    met.tell_seat(driver="operator 2")
    met.page.wait_for_selector("text=operator 2 drives, you look on")
    assert {"do": "leave_seat", "to": "operator 2"}.items() <= met.asked[-1].items()
    met.page.clock.run_for(100)  # what was on its way
    count = len(met.heard)
    met.page.keyboard.down("Shift")
    met.page.keyboard.press("w")
    met.page.get_by_role("button", name="Ask for control").click()
    met.page.wait_for_selector("text=done")
    assert met.asked[-1]["do"] == "take_seat"
    assert len(met.heard) == count
    met.tell_seat()  # with the key still down: it was pressed when somebody else drove
    assert not wait(met, lambda hands: hands.number > count).held


def test_the_button_tells_a_deadman_that_is_pressed_from_one_that_counts(met: PageStandIn) -> None:
    met.page.keyboard.down("Shift")
    wait(met, lambda hands: hands.held)
    for judged, shown in (("waiting", "pressed"), ("held", "held")):
        met.tell_seat(deadman=(judged, ""))
        met.page.wait_for_selector(f"#sticks .hold[data-state={shown}]")
    met.page.keyboard.up("Shift")
    wait(met, lambda hands: not hands.held)
    met.page.wait_for_selector("#sticks .hold[data-state=released]")


def test_two_keys_stop_from_anywhere_also_while_others_drive(met: PageStandIn) -> None:
    met.tell_seat(driver="operator 2")
    met.page.get_by_role("button", name="Ask for control").focus()
    for key in ("Escape", "Space"):
        met.page.keyboard.press(key)
        met.page.clock.run_for(100)
    assert [request["do"] for request in met.asked] == ["emergency_stop", "emergency_stop"]


def test_one_click_stops_and_a_refused_reset_tells_why(met: PageStandIn) -> None:
    met.page.locator(".stop").click()
    met.page.clock.run_for(100)
    assert [request["do"] for request in met.asked] == ["emergency_stop"]
    sources = [{"name": "controller", "state": "stopped"}, {"name": "valve_driver", "state": "ready"}]
    met.tell("emergency_stop", active=True, sources=sources)
    met.page.wait_for_selector(
        "#message :text('STOPPED. Nothing moves. Press Reset. Stopped: control; not stopped: valves.')"
    )
    met.refusals["reset_emergency_stop"] = "refused: the levers must be centred and the deadman released"
    met.page.get_by_role("button", name="Reset").click()
    met.page.wait_for_selector("#message :text('STOPPED. Not reset: refused: the levers must be centred')")
    met.tell_seat(driver="operator 2")
    met.tell("emergency_stop", active=True, sources=sources)
    met.page.wait_for_selector("#emergency_stop button:disabled:text-is('Reset')")
    met.page.wait_for_selector("#message :text('until it is reset by who drives')")


def test_a_reset_waits_until_the_deadman_is_let_go(met: PageStandIn) -> None:
    met.page.keyboard.down("Shift")
    wait(met, lambda hands: hands.held)
    met.page.keyboard.press("Space")
    wait(met, lambda hands: not hands.held)
    met.tell("emergency_stop", active=True, sources=[{"name": "controller", "state": "stopped"}])
    reset = met.page.get_by_role("button", name="Reset")
    reset.click()
    met.page.wait_for_selector("#message :text('STOPPED. Not reset: let go of the left Shift key first.')")
    met.page.wait_for_selector("#first_minute :text('Stopped. Let go of the left Shift key.')")
    met.page.keyboard.up("Shift")
    met.page.clock.run_for(40)
    met.page.wait_for_selector(
        "#message :text('STOPPED. Nothing moves. Press Reset.')"
    )  # what is obeyed is not asked for
    met.page.wait_for_selector("#first_minute :text('Stopped. Press Reset.')")
    reset.click()
    met.page.wait_for_selector("text=Not reset", state="hidden")
    assert [request["do"] for request in met.asked] == ["emergency_stop", "reset_emergency_stop"]


def test_a_reset_that_a_node_refuses_for_a_stick_is_told_until_the_stick_is_let_go(met: PageStandIn) -> None:
    met.tell("emergency_stop", active=True, sources=[{"name": "controller", "state": "stopped"}])
    met.refusals["reset_emergency_stop"] = "controller: refused: the levers must be centred."
    met.page.keyboard.down("w")
    met.page.clock.run_for(400)
    met.page.get_by_role("button", name="Reset").click()
    refused = "#message :text('STOPPED. Not reset: control: the levers must be centred.')"
    met.page.wait_for_selector(refused)
    met.page.clock.run_for(1000)
    assert met.page.locator(refused).count() == 1
    met.page.keyboard.up("w")
    met.page.clock.run_for(400)
    met.page.wait_for_selector("#message :text('STOPPED. Nothing moves. Press Reset.')")
    met.page.get_by_role("button", name="Reset").click()  # refused for another reason than these hands
    met.page.wait_for_selector(refused)
    met.page.clock.run_for(1000)
    assert met.page.locator(refused).count() == 1


def test_a_controller_that_arms_is_no_trouble_and_one_that_stays_disarmed_says_what_to_do(
    met: PageStandIn,
) -> None:
    page = met.page
    met.tell("welcome", you="operator 1", signals=SIGNALS)
    met.tell_seat(deadman=("ready", ""))
    page.keyboard.down("Shift")
    wait(met, lambda hands: hands.held)
    met.tell_seat(deadman=("held", ""))
    page.keyboard.down("w")
    met.send_frame(1, 0.0, [0.0, *TIP])
    page.clock.run_for(200)
    page.wait_for_selector(".deadman[data-state=held]")
    order = "Let go of sticks and keys."
    assert order not in page.inner_text("#message")
    page.clock.run_for(400)
    page.wait_for_selector(f"#message :text('{order}')")
    met.send_frame(2, 0.1, [1.0, *TIP])
    page.clock.run_for(300)
    assert order not in page.inner_text("#message")
    met.tell("welcome", you="operator 1", signals=[])


def test_the_exercise_tells_a_wrong_way_while_it_is_pushed_and_sticks_that_move_joints(
    met: PageStandIn,
) -> None:
    page, (x, y, z) = met.page, TIP
    met.tell("welcome", you="operator 1", signals=SIGNALS)
    met.send_frame(1, 0.0, [1.0, *TIP])
    page.get_by_role("button", name="Mark a square").click()
    met.tell_seat(deadman=("ready", ""))
    page.keyboard.down("Shift")
    wait(met, lambda hands: hands.held)
    met.tell_seat(deadman=("held", ""))
    page.wait_for_selector("#first_minute :text('push the left stick away, or press W: 0.8 m to go')")
    page.keyboard.down("s")
    page.clock.run_for(300)
    for number, way in ((2, -0.02), (3, -0.2)):
        met.send_frame(number, 0.1 * number, [1.0, x + way, y, z])
    page.wait_for_selector("#first_minute :text('this is the wrong way: push the left stick away')")
    page.keyboard.up("s")
    page.clock.run_for(300)
    met.send_frame(4, 0.4, [1.0, x - 0.2, y, z])
    right = "Edge 1 of 4: push the left stick away, or press W: 1.0 m to go"
    page.wait_for_selector(f"#first_minute :text('{right}')")
    for scheme, told in (("joint", "waits. Set Scheme to"), ("coordinated", "push the left stick away")):
        met.tell("parameters", nodes={"controller": {"scheme": CHOICE | {"value": scheme}}})
        page.clock.run_for(300)
        page.wait_for_selector(f"#first_minute :text('Edge 1 of 4'):text('{told}')")
    page.get_by_role("button", name="Take the square away").click()
    met.tell("welcome", you="operator 1", signals=[])


def test_keys_are_slowed_and_sped_up_while_they_are_pressed_and_the_page_tells_by_how_much(
    met: PageStandIn,
) -> None:
    page = met.page
    page.keyboard.down("w")

    def pushed_by(share: float) -> None:
        wait(met, lambda hands: hands.axes[LEFT_Y] == share)

    pushed_by(1.0)
    for key, share in (("q", 0.5), ("q", 0.25), ("q", 0.25), ("e", 0.5), ("e", 1.0)):
        page.keyboard.press(key)
        pushed_by(share)
        page.wait_for_selector(f"#sticks .speed :text-is('{100 * share:.0f} %')")
    page.keyboard.up("w")
    wait(met, lambda hands: hands.axes == CENTRED)


def test_a_key_without_the_deadman_says_what_is_missing(met: PageStandIn) -> None:
    missing = "Let go of sticks and keys: nothing moves without the deadman."
    met.page.keyboard.down("w")
    met.page.clock.run_for(400)
    met.page.wait_for_selector(f"text={missing}")
    met.page.keyboard.up("w")
    met.page.clock.run_for(400)
    met.page.wait_for_selector(f"text={missing}", state="hidden")


def test_a_recording_is_marked_once_the_recorder_hears(met: PageStandIn) -> None:
    mark = met.page.get_by_role("button", name="Mark", exact=True)
    told = {"active": True, "name": "mine", "seconds": 3, "bytes": 0, "text": "The recorder starts."}
    for hears in (False, True):
        met.tell("recording", **told, hears=hears)
        met.page.wait_for_selector(
            "#recording .state:text('not hear')", state="hidden" if hears else "visible"
        )
        assert mark.is_visible() == hears
    met.tell("recording", **told | {"active": False}, hears=True)


def test_a_stop_lets_go_and_says_so_when_nobody_confirms_it(met: PageStandIn) -> None:
    met.page.keyboard.down("Shift")
    wait(met, lambda hands: hands.held)
    met.silent.add("emergency_stop")
    met.page.keyboard.press("Space")
    wait(met, lambda hands: not hands.held)
    met.page.wait_for_selector("text=Emergency stop sent, not yet confirmed.")
    met.page.clock.run_for(6000)
    met.page.wait_for_selector("text=Emergency stop not confirmed: The server has not answered yet.")
    met.silent.clear()
    met.page.keyboard.press("Space")
    met.page.wait_for_selector("text=Emergency stop not confirmed", state="hidden")


def test_a_stop_without_connection_is_sent_when_there_is_one(met: PageStandIn) -> None:
    met.refusals["emergency_stop"] = "Nobody hears the emergency stop."
    met.page.keyboard.press("Escape")
    met.page.wait_for_selector("text=Emergency stop not confirmed: Nobody hears the emergency stop.")
    met.refusals.clear()
    met.asked.clear()
    met.drop_connection()
    met.page.wait_for_selector(".driver[data-drives=false]")
    for _ in range(100):
        met.page.clock.run_for(20)
    assert met.asked[0]["do"] == "emergency_stop"


@pytest.mark.parametrize("sized", SIZES, indirect=True)
def test_the_emergency_stop_is_in_sight_and_nothing_covers_it(
    met: PageStandIn, sized: tuple[int, int]
) -> None:
    met.tell("emergency_stop", active=True, sources=[{"name": "controller", "state": "stopped"}])
    met.tell_seat(asking=("operator 2",), why_not="Another node publishes /joy: a node of somebody's.")
    met.page.wait_for_selector("text=Hand over to operator 2")
    if drawer := sized[0] < 960:
        met.page.click("#drawer-button")
    covered = """() => [...document.querySelectorAll(".stop, .hold, .stick")].filter((element) => {
      const { left, top, right, bottom } = element.getBoundingClientRect();
      const seen = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
      const inside = left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
      return !inside || !element.contains(seen) || Math.min(right - left, bottom - top) < 44;
    }).map((element) => element.className)"""
    assert met.page.evaluate(covered) == []
    if drawer:
        met.page.click("#drawer-button")


FREE = """() => {
  const isScene = (x, y) => {
    const seen = document.elementFromPoint(x, y);
    return seen.closest("#scene") && !seen.closest("#first_minute");
  };
  let [all, seen] = [0, 0];
  for (let x = 5; x < innerWidth; x += 10) {
    for (let y = 5; y < innerHeight; y += 10, all++) if (isScene(x, y)) seen++;
  }
  return seen / all;
}"""


@pytest.mark.usefixtures("sized")
@pytest.mark.parametrize("sized", PHONES, indirect=True)
def test_a_phone_shows_the_crane_on_more_than_a_third_of_its_screen(met: PageStandIn) -> None:
    assert met.page.evaluate(FREE) > 0.34


def test_what_the_server_says_stands_in_the_way_is_shown(met: PageStandIn) -> None:
    met.tell_seat(why_not="Another node publishes /joy: /joystick.")
    met.page.wait_for_selector("#message :text('Another node publishes /joy: /joystick.')")
    met.tell_seat(deadman=("ready", ""))
    met.page.keyboard.down("Shift")
    wait(met, lambda hands: hands.held)
    met.tell_seat(deadman=("held", "The deadman is held."))
    met.page.wait_for_selector(".deadman[data-state=held]")
    met.tell_seat(cause=TOO_LATE)  # the server lets go: so does the page, and says so once
    assert not wait(met, lambda hands: not hands.held).held
    met.page.wait_for_selector(".deadman[data-state=pressed]")
    met.page.wait_for_selector("#message :text('Let go of the left Shift key.')")
    met.page.keyboard.up("Shift")
    met.page.clock.run_for(40)
    met.tell_seat(deadman=("ready", ""))
    met.page.wait_for_selector(f"#message :text('{TOO_LATE} Hold the left Shift key')")


WORST_CAUSES = (
    "joint state: boom is 3.14159 rad; allowed: 0.100 .. 1.200",
    "machine: boom goes by itself, 3 degrees though its valve is shut; allowed: shut off the hydraulics",
)
# The longest sentence of the exercise.
LONGEST_WAY = """async (fingers) => {
  const { wayText } = await import("/web/exercise/words.js");
  const push = (stick, word, key, metres) => ({ stick, word, key, metres });
  const [along, aside] = [push("left", "right", "D", 10.5), push("left", "away", "W", 0)];
  const way = { along, aside, height: push("right", "down", "↓", 10.5), wrong: true, then: "" };
  return `Edge 4 of 4: ${wayText(way, fingers)}`;
}"""
# Which of the texts are cut off in an element, one after the other.
CUT = """([selector, texts]) => {
  const element = document.querySelector(selector);
  const before = element.textContent;
  if (element.dataset.tone) element.dataset.tone = "warn"; // a hint's letters are thinner
  const cut = texts.filter((text) => {
    element.textContent = text;
    return element.scrollHeight > element.clientHeight + 1;
  });
  element.textContent = before;
  return cut;
}"""


@pytest.mark.parametrize("sized", SIZES, indirect=True)
def test_no_advice_is_cut_off(met: PageStandIn, js: Js, sized: tuple[int, int]) -> None:
    page = met.page
    phone = min(sized) < 400
    grip = {"grip": "HOLD TO DRIVE"} if phone else {}
    told = [one | {"fingers": phone, "here": one["here"] | grip} for one in page_words.states()]
    told += [one | {"cause": cause} for one in told for cause in WORST_CAUSES if one["cause"]]
    found = page_words.shown(js, told)
    lines = {one["line"] for one in found}
    stops = {text for text in lines if text.startswith("STOPPED")}
    exercise = {one["exercise"] for one in found} | {page.evaluate(LONGEST_WAY, phone)}
    assert page.evaluate(CUT, ["#first_minute p", sorted(exercise)]) == []
    assert page.evaluate(CUT, ["#message p", sorted(lines - stops)]) == []
    met.tell("emergency_stop", active=True, sources=[])  # then the reset stands beside the line
    page.wait_for_selector("#emergency_stop .reset", state="visible")
    assert page.evaluate(CUT, ["#message p", sorted(stops)]) == []


@pytest.mark.usefixtures("sized")
@pytest.mark.parametrize("sized", [(1280, 800)], indirect=True)
def test_what_to_do_about_a_stop_is_read_without_scrolling(met: PageStandIn) -> None:
    page = met.page
    stop = {"level": "error", "text": "emergency stop pressed", "values": {}}
    nodes = ("valve_driver", "controller", "simulator")
    met.tell("diagnostics", parts=[stop | {"name": f"{node}: emergency stop"} for node in nodes])
    page.wait_for_selector("#diagnostics :text('emergency stop: valves, control, simulated crane')")
    bottoms = """() => ["#diagnostics .remedy", "#diagnostics .now"].map((name) =>
      document.querySelector(name).getBoundingClientRect().bottom)"""
    remedy, box = page.evaluate(bottoms)
    assert remedy <= box
    met.tell("diagnostics", parts=[])


PARTS = ("#left", "#scene", "#right", "#bottom", ".stop", "#diagnostics ~ #recording", "#drawer-button")
PLACES = """(parts) => [...parts, "#message"].map((name) => {
  const { x, y, width, height } = document.querySelector(name).getBoundingClientRect();
  return name === "#message" ? [y, height] : [x, y, width, height];  // beside it a reset may stand
})"""


@pytest.mark.usefixtures("sized")
@pytest.mark.parametrize("sized", SIZES, indirect=True)
def test_nothing_jumps_when_a_message_comes_or_goes(met: PageStandIn) -> None:
    page = met.page
    places = page.evaluate(PLACES, PARTS)
    sources = [{"name": name, "state": "stopped"} for name in ("controller", "valve_driver", "simulator")]
    part = {
        "name": "controller: joystick",
        "level": "warning",
        "text": "waiting for a joystick",
        "values": {},
    }
    for act in (
        lambda: met.tell("emergency_stop", active=True, sources=sources),
        lambda: met.tell("emergency_stop", active=False, sources=[]),
        lambda: met.tell_seat(asking=("operator 2",), cause=TOO_LATE),
        lambda: met.tell_seat(why_not="Another node publishes /joy: a node that was just found. " * 3),
        lambda: met.tell("diagnostics", parts=[part, part | {"name": "b", "text": "is not heard"}]),
        lambda: met.tell_seat(driver="operator 2"),
        lambda: met.tell_seat(),
    ):
        act()
        page.clock.run_for(400)
        assert page.evaluate(PLACES, PARTS) == places
    met.tell("diagnostics", parts=[])


def test_a_page_without_a_connection_says_one_thing_that_can_be_read(met: PageStandIn) -> None:
    met.drop_connection()
    met.page.wait_for_selector("#message :text('The crane stands still until the page is connected again.')")
    width = met.page.evaluate("() => document.querySelector('#message p').getBoundingClientRect().width")
    assert width > 1000
    assert met.page.locator("text=Not connected").count() == 0
    for _ in range(50):
        met.page.clock.run_for(20)
    met.page.wait_for_selector("#message :text('Take the seat to drive.')")


def test_a_stop_of_a_recording_shows_at_once_that_it_was_heard(met: PageStandIn) -> None:
    told = {"name": "mine", "seconds": 3, "bytes": 0, "text": "The recorder starts.", "hears": True}
    met.tell("recording", active=True, **told)
    met.silent.add("stop_recording")
    met.page.get_by_role("button", name="Stop", exact=True).click()
    met.page.wait_for_selector("#recording .record:disabled:text('Stopping')")
    met.page.wait_for_selector("#recording :text('Stop was heard')")
    met.tell("recording", active=True, **told)  # it goes on for a while
    met.page.wait_for_selector("#recording .record:disabled:text('Stopping')")
    lost = ", ".join(f"{number} of /topic_{number}" for number in range(1, 26))
    ended = told | {"text": f"recorded 9000 messages, 32 topics, lost 325, {lost}: mine"}
    met.tell("recording", active=False, **ended)
    met.page.wait_for_selector("#recording .record:not(:disabled):text('Record')")
    met.page.wait_for_selector("#recording .state:text('lost 325 in 25 topics')")
    assert not met.page.locator("#recording .losses p").is_visible()
    met.page.locator("#recording .losses summary").click()
    assert met.page.locator("#recording .losses p").inner_text() == lost
    met.page.locator("#recording .losses summary").click()


def test_the_sticks_are_named_anew_with_the_scheme(met: PageStandIn) -> None:
    for scheme, words in (("joint", "stick out"), ("coordinated", "away")):
        met.tell("parameters", nodes={"controller": {"scheme": CHOICE | {"value": scheme}}})
        met.page.wait_for_selector(f"#left_stick .away span:text('{words}')")
