"""What the page says at one time: who drives, how the deadman is, what is in the way, what to do next."""

import re
from typing import Any

import pytest
from page_stand_in import Js
from page_words import GRIP, HELD_BACK, NO_STOP, OTHER, STOP, YOU, seat, shown, state, states

from forest_control.limits.velocity_scaling import Limit
from forest_control.safety import motion_guard
from forest_station.operator.deadman import TOO_LATE

WAITS = "Edge 1 of 4 waits."
PUSH = "Edge 1 of 4: push the left stick away, or press W: 0.7 m to go, then left without a stop."
GO = f"Let go of {GRIP}."
STICKS = "Let go of sticks and keys."
MISSING = "Let go of sticks and keys: nothing moves without the deadman."
HOLD = f"Hold {GRIP}, then move a stick."
LATE = "Sticks and keys came too late: this computer or the network is too busy."
OFTEN = "Close programs, shrink the window, or click pictures/s to stop them."
REPLAY = {"replays": True}
IN_REPLAY = "The square is driven with the live crane."
GOES_ON = f"Hold {GRIP}, and leave the sticks alone: the cycle goes on."
ALL = "Stopped: control, valves, simulated crane."
RELEASED, PRESSED, HELD = "Deadman released", "Deadman pressed", "Deadman held"
DOUBTED = "Deadman does not count"
LOST = "The page asks for the crane. If this lasts: does scripts/station.sh run?"
HELD_HERE, DOUBTED_HERE, DEFLECTED = {"held": True}, {"doubted": True}, {"deflected": True}

# What a page with a marked square shows: deadman, line at the top, exercise.
TABLE: tuple[tuple[str, dict[str, Any], tuple[str, str, str]], ...] = (
    ("no connection", state(None), (RELEASED, LOST, "Without a connection nothing can be driven.")),
    (
        "nobody drives",
        state(seat(None)),
        (RELEASED, "Take the seat to drive.", "Nobody drives: take the seat, at the top."),
    ),
    ("others drive", state(seat(OTHER)), (HELD, "", "Somebody else drives: ask for control, at the top.")),
    (
        "another joystick",
        state(seat(None, why_not="Another node publishes /joy: /joystick.")),
        (RELEASED, "Another node publishes /joy: /joystick.", "Nobody drives: take the seat, at the top."),
    ),
    ("at rest", state(seat(state="ready")), (RELEASED, HOLD, f"{WAITS} {HOLD}")),
    ("let go, not yet heard", state(seat(state="waiting")), (RELEASED, "", WAITS)),
    (
        "a stick without the deadman",
        state(seat(state="ready"), here=DEFLECTED),
        (RELEASED, MISSING, f"{WAITS} {MISSING}"),
    ),
    ("pressed, not yet heard", state(seat(state="ready"), here=HELD_HERE), (PRESSED, "", WAITS)),
    (
        "held too early",
        state(seat(state="waiting"), here=HELD_HERE | DEFLECTED),
        (DOUBTED, GO, f"{WAITS} {GO}"),
    ),
    (
        "doubted",
        state(seat(state="ready", cause=TOO_LATE), here=DOUBTED_HERE),
        (DOUBTED, f"{LATE} {GO}", f"{WAITS} {GO}"),
    ),
    (
        "too late",
        state(seat(state="ready", cause=TOO_LATE)),
        (RELEASED, f"{LATE} {HOLD}", f"{WAITS} {HOLD}"),
    ),
    (
        "often too late",
        state(seat(state="ready", cause=TOO_LATE), here={"often": True}),
        (RELEASED, f"{LATE} {OFTEN}", f"{WAITS} {HOLD}"),
    ),
    ("drives", state(seat(), here=HELD_HERE | DEFLECTED), (HELD, "", PUSH)),
    (
        "a replay",
        state(seat(state="ready"), here=REPLAY),
        (RELEASED, "A replay is shown. Press Back to live to drive.", IN_REPLAY),
    ),
    (
        "a hand on the deadman in a replay",
        state(seat(state="ready"), here=REPLAY | DOUBTED_HERE),
        (DOUBTED, f"A replay is shown. {GO}", IN_REPLAY),
    ),
    ("a replay for who looks on", state(seat(OTHER), here=REPLAY), (HELD, "", IN_REPLAY)),
    (
        "a cycle that waits for the deadman",
        state(seat(state="ready"), here={"plays": True}),
        (RELEASED, GOES_ON, f"{WAITS} {GOES_ON}"),
    ),
    (
        "slowed",
        state(seat(), here=HELD_HERE | DEFLECTED, status={"factor": 0.28, "limit": Limit.FLOW}),
        (HELD, "Slowed to 28 % by the flow of the pumps.", PUSH),
    ),
    (
        "a stick before the deadman",
        state(seat(), here=HELD_HERE | DEFLECTED, status={"disarmed": True}),
        (HELD, STICKS, f"{WAITS} {STICKS}"),
    ),
    (
        "a trouble",
        state(
            seat(),
            here=HELD_HERE | DEFLECTED,
            status={"disarmed": True},
            cause=motion_guard.LOST_STATE,
        ),
        (HELD, f"The controller stopped: no state of the machine. {GO}", f"{WAITS} {GO}"),
    ),
    (
        "stopped",
        state(seat(state="waiting"), stop=STOP),
        (RELEASED, f"STOPPED. Nothing moves. Press Reset. {ALL}", "Stopped. Press Reset."),
    ),
    (
        "stopped, a hand on the deadman",
        state(seat(state="waiting"), here=DOUBTED_HERE, stop=STOP, note=f"Not reset: {HELD_BACK}"),
        (DOUBTED, f"STOPPED. Not reset: {HELD_BACK}", f"Stopped. {GO}"),
    ),
    (
        "stopped, a hand on a stick",
        state(seat(state="waiting"), here=DEFLECTED, stop=STOP),
        (RELEASED, f"STOPPED. Nothing moves. {STICKS} {ALL}", f"Stopped. {STICKS}"),
    ),
    (
        "stopped while others drive",
        state(seat(OTHER), stop=STOP),
        (
            HELD,
            f"STOPPED. Nothing moves until it is reset by who drives. {ALL}",
            "Stopped. Who drives can reset it.",
        ),
    ),
    (
        "sticks that move joints",
        state(seat(), here=HELD_HERE, movesTip=False),
        (
            HELD,
            "",
            f"""{WAITS} Set Scheme to "coordinated" and Sticks' axes to "cartesian", in Settings.""",
        ),
    ),
)


@pytest.mark.parametrize(("told", "texts"), [row[1:] for row in TABLE], ids=[row[0] for row in TABLE])
def test_each_state_shows_its_own_texts(js: Js, told: dict[str, Any], texts: tuple[str, str, str]) -> None:
    (found,) = shown(js, [told])
    assert (found["deadman"], found["line"], found["exercise"]) == texts


# What a person is told to do, by the words that tell it.
ORDERS = {
    "let go of the deadman": rf"et go of ({GRIP}|the deadman)",
    "let go of sticks": r"et go of sticks",
    "hold": r"Hold ",
    "reset": r"ress Reset",
    "back to live": r"Press Back to live",
    "push": r"push the",
    "take the seat": r"[Tt]ake the seat",
    "ask for control": r"[Aa]sk for control",
}


def orders(texts: dict[str, str]) -> set[str]:
    """Return what a person is told to do by all that stands on the page."""
    said = " ".join(str(text) for text in texts.values())
    return {name for name, words in ORDERS.items() if re.search(words, said)}


def is_open(order: str, told: dict[str, Any], texts: dict[str, Any]) -> bool:
    """Tell whether an order is not obeyed yet, and can be."""
    here, drives = told["here"], bool(told["seat"] and told["seat"]["you_drive"])
    pressed, deflected, stopped = here["held"] or here["doubted"], here["deflected"], told["stop"]["active"]
    at_rest = not (pressed or deflected)
    return {
        "let go of the deadman": drives and pressed,
        "let go of sticks": drives and deflected and (not pressed or told["status"]["disarmed"]),
        "hold": drives and at_rest and not (stopped or here["replays"]) and texts["deadman"] == RELEASED,
        "reset": drives and at_rest and stopped,
        "back to live": drives and at_rest and not stopped and here["replays"],
        "push": texts["moves"] and texts["deadman"] == HELD and not stopped,
        "take the seat": told["seat"] is not None and told["seat"]["driver"] is None and not stopped,
        "ask for control": told["seat"] is not None and told["seat"]["driver"] == OTHER and not stopped,
    }[order]


def test_in_no_state_do_two_texts_contradict_each_other_or_ask_for_what_is_done(js: Js) -> None:
    told = list(states())
    for one, found in zip(told, shown(js, told), strict=True):
        asked = orders(found)
        assert len(asked) <= 1, (one, found)
        assert all(is_open(order, one, found) for order in asked), (one, found)
        assert (found["driver"] == "You drive") == bool(one["seat"] and one["seat"]["driver"] == YOU)


def test_whoever_drives_and_moves_nothing_is_told_what_to_do_unless_it_is_heard_at_once(js: Js) -> None:
    told = [one for one in states() if one["seat"] and one["seat"]["driver"] == YOU]
    for one, found in zip(told, shown(js, told), strict=True):
        here, judged = one["here"], one["seat"]["deadman"]["state"]
        pressed = here["held"] or here["doubted"]
        on_its_way = {
            "waiting": not (pressed or here["deflected"]),
            "ready": here["held"],
            "held": not pressed and not here["deflected"],
        }[judged]
        stopped, told_otherwise = one["stop"]["active"], "Close programs" in found["line"]
        assert found["moves"] or orders(found) or told_otherwise or (on_its_way and not stopped), (one, found)


def test_an_overload_is_ended_in_the_same_way_wherever_it_is_told(js: Js) -> None:
    remedy = "et go of the deadman, then put the load down"
    told = state(seat(), here=HELD_HERE, status={"factor": 0.0, "limit": Limit.OVERLOAD})
    assert remedy in shown(js, [told])[0]["line"]
    text = "overload: stick went back by 0.021 rad in 0.30 s; allowed: put the load down"
    assert remedy in js("diagnostics/remedies.js", "(m, text) => m.remedy(text)", text)
    label = """(m, limit) => new m.Limits({ materials: new Map(), place: () => 0 }, { light() {} })
      .pose({ value: (name) => (name.endsWith("limit") ? limit : NaN) }, 0)[0].text"""
    assert remedy in js("scene/limits.js", label, Limit.OVERLOAD)


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (
            "valve_driver: refused: the valves are not shut.",
            "Not reset: valves: the valves are not shut.",
        ),
        ("north/controller: refused: no.", "Not reset: north/control: no."),
        ("No node tells of an emergency stop.", "Not reset: No node tells of an emergency stop."),
        (HELD_BACK, f"Not reset: {HELD_BACK}"),
    ],
)
def test_a_refused_reset_names_who_refuses_as_an_operator_does(js: Js, answer: str, said: str) -> None:
    assert js("hands/stop_words.js", "(m, text) => m.refusalText(text)", answer) == said


def test_the_stop_tells_who_stands_and_who_does_not(js: Js) -> None:
    told = [{"name": name, "state": kind} for name, kind in (("controller", "stopped"), ("crane", "ready"))]
    said = "(m, sources) => [m.sourcesText(sources), m.sourcesText(sources.slice(1)), m.sourcesText([])]"
    assert js("hands/stop_words.js", said, told) == [
        "Stopped: control; not stopped: crane.",
        "not stopped: crane.",
        "",
    ]
    assert js("hands/stop_words.js", "(m, told) => m.stopText(told, { note: '' })", NO_STOP) == ""


STANDING = """(m, [parts, logged, now]) => m.standingCause(parts, logged, now)"""
LOGGED = {"text": f"standing still: {motion_guard.LOST_STATE}", "at": 1000}
FROZEN = {"name": "crane/controller: machine", "level": "error", "text": "swing is frozen"}


@pytest.mark.parametrize(
    ("parts", "logged", "now", "cause"),
    [
        ([], LOGGED, 1500, motion_guard.LOST_STATE),
        ([FROZEN], LOGGED, 1500, "swing is frozen"),
        ([FROZEN | {"level": "warning"}], LOGGED, 12_000, ""),
        ([FROZEN | {"name": "simulator: machine"}], None, 0, ""),
    ],
)
def test_why_a_controller_stands_is_what_it_says_or_has_logged_lately(
    js: Js, parts: list[dict[str, str]], logged: dict[str, Any] | None, now: float, cause: str
) -> None:
    standing = "(m, texts) => texts.map((text) => m.isStanding(text))"
    assert js("hands/why.js", standing, [LOGGED["text"], "well"]) == [True, False]
    assert js("hands/why.js", STANDING, [parts, logged, now]) == cause


def test_a_deadman_is_shown_as_held_while_both_sides_hold_it(js: Js) -> None:
    found = """(m) => [[true, false], [false, true], [false, false]].flatMap(([held, doubted]) =>
      [true, false].map((you_drive) =>
        m.deadmanState({ you_drive, deadman: { state: "held" } }, { held, doubted }).state))"""
    assert js("hands/why.js", found) == ["held", "held", "pressed", "held", "waiting", "held"]


def test_of_all_that_is_said_at_the_top_the_most_important_is_shown(js: Js) -> None:
    steps = """(m) => {
      const line = m.messageLineOf({});
      const told = [];
      line.addEventListener("change", () => told.push(line.shown.text));
      const stop = ["stop", "stopped"];
      const said = [["hint", "hold"], ["drive", "let go"], stop, stop, ["hint", ""], ["stop", ""]];
      for (const one of said) line.say(...one);
      return told;
    }"""
    assert js("message_line.js", steps) == ["hold", "let go", "stopped", "stopped", "let go"]
