"""Every state in which the page says who drives and what to do, and what it then says."""

import itertools
import json
from collections.abc import Iterator
from typing import Any

from page_stand_in import Js

from forest_control.safety import motion_guard
from forest_station.operator.deadman import TOO_LATE

# For each state {seat, here, stop, note, status, cause, push}: the texts that stand on the page together.
# Both as JSON: the browser's protocol takes far longer over objects.
# `push`: null, no square is marked; else where the tip is, from the beginning of its first edge.
_SHOWN = """async (m, text) => {
  const states = JSON.parse(text);
  const { stopText } = await import("/web/hands/stop_words.js");
  const { exerciseText } = await import("/web/exercise/words.js");
  const { begun, squareAt } = await import("/web/exercise/square.js");
  const { messageLineOf } = await import("/web/message_line.js");
  const texts = (state) => {
    const { seat, here, stop, note, status, cause, push, fingers = false, movesTip = true } = state;
    const advice = m.adviceFor(seat, here, stop.active, status, cause);
    const line = messageLineOf({});
    line.say("stop", stopText(stop, { note, drives: Boolean(seat?.you_drive), order: advice.order }));
    line.say("drive", advice.text);
    const attempt = push && begun(squareAt([5, 0, 1]));
    const tip = (push ?? [0, 0, 0]).map((way, i) => [5, 0, 1][i] + way);
    const { replays } = here;
    const shown = { attempt, tip, best: NaN, advice, stopped: stop.active, seat, fingers, movesTip, replays };
    return {
      driver: m.driverText(seat),
      deadman: m.deadmanState(seat, here).text,
      line: line.shown.text,
      exercise: exerciseText(shown),
      moves: advice.moves,
    };
  };
  return JSON.stringify(states.map(texts));
}"""
YOU, OTHER = "operator 1", "operator 2"
GRIP = "the left Shift key"
NO_STOP: dict[str, Any] = {"active": False, "sources": []}
NODES = ("controller", "valve_driver", "simulator")
STOP = {"active": True, "sources": [{"name": name, "state": "stopped"} for name in NODES]}
HELD_BACK = "let go of the deadman first."
HANDS = tuple(
    {"held": held, "doubted": doubted, "deflected": deflected}
    for held, doubted in ((False, False), (True, False), (False, True))
    for deflected in (False, True)
)


def shown(js: Js, told: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return what stands on the page in each of some states."""
    found: list[dict[str, Any]] = json.loads(js("hands/why.js", _SHOWN, json.dumps(told)))
    return found


def seat(driver: str | None = YOU, state: str = "held", cause: str = "", **more: Any) -> dict[str, Any]:
    """Return a message `seat` as this page hears it."""
    deadman = {"state": "waiting" if driver is None else state, "cause": cause}
    told = {"driver": driver, "you_drive": driver == YOU, "asking": [], "why_not": "", "deadman": deadman}
    return told | more


def state(told: dict[str, Any] | None = None, **changes: Any) -> dict[str, Any]:
    """Return a state: this page drives, nothing is pressed or in the way, and a square is marked."""
    here = {"held": False, "doubted": False, "deflected": False, "why": "", "often": False, "grip": GRIP}
    here |= {"you": YOU, "lost": "", "replays": False, "plays": False} | changes.pop("here", {})
    status = {"disarmed": False, "factor": 1.0, "limit": 0, "axis": ""} | changes.pop("status", {})
    rest = {"stop": NO_STOP, "note": "", "cause": "", "push": [0.1, 0.0, 0.0]}
    return {"seat": told, "here": here, "status": status} | rest | changes


def states() -> Iterator[dict[str, Any]]:
    """Yield every combination of seat, deadman, hands, stop and controller, live and beside a replay."""
    seats = [None, seat(None), seat(OTHER), seat(OTHER, asking=[YOU])]
    seats += [seat(YOU, judged, cause) for judged in ("waiting", "ready", "held") for cause in ("", TOO_LATE)]
    troubles = ((False, ""), (True, ""), (True, motion_guard.LOST_STATE))
    pushes: tuple[Any, ...] = (None, [0.1, 0.0, 0.0], [0.3, -0.3, 0.5])
    twice = (False, True)
    for told, hands, stop, (disarmed, cause), push, often, replays in itertools.product(
        seats, HANDS, (NO_STOP, STOP), troubles, pushes, twice, twice
    ):
        here = hands | {"often": often, "replays": replays}
        yield state(told, here=here, stop=stop, status={"disarmed": disarmed}, cause=cause, push=push)
