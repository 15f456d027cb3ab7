"""What a hand feels of the delay: from the lever's new deflection to the voltage that follows it, from a bag.

`joy_to_valve_ms` of the summary is what the graph adds. The controller reads the levers later than that, on
lines between the joystick's samples (`joystick_interpolation`), and its reference has a slope of its own.

| key | from | to the first voltage that answers |
|---|---|---|
| `first` | each joystick sample | with a lever that this sample could have moved |
| `half_step` | each lever's step, thrown from one sample to the next | when half of the step is wished |
| `half_way` | the middle of each other movement of a lever | the middle of what was wished for it |

`first` needs no step: the lever in force leaves the sample before as soon as the time t, at which levers are
read, has passed that sample. t is computed from the bag by the controller's own law. What is wished is the
tip's velocity after every limit, in the joint scheme the valve's command; axes are Cartesian.

| symbol | name | unit |
|---|---|---|
| t | time at which the levers are read | s |
| said, known | when a sample was published; when it was received | ns |
"""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_bag.read.timeseries import Bag
from forest_control.operator import joystick_interpolation
from forest_control.operator.levers import RIGHT_Y, levers_from_axes
from forest_description.types import Floats
from forest_msgs_py.interfaces import topics

Times = NDArray[np.int64]
DIGITS = 1  # of a millisecond
MOVED = 0.2  # of the greatest deflection or wish: less is no movement
LONGEST = 400_000_000  # [ns] what follows a movement later follows something else
NAMES = {"first": "lever to valve", "half_step": "half of a step", "half_way": "half of a movement"}
WISHED_BY = (1, 2, 0)  # the tip's y, z, x: what swing, boom and stick lever wish


def lever_to_valve_ms(bag: Bag) -> dict[str, dict[str, float] | None]:
    """Return median and 99th percentile [ms] of each delay, None where nothing moved that way.

    Raises:
        NotInBag: the bag lacks a topic that tells.
    """
    if bag.series(topics.JOY).values.shape[1] <= RIGHT_Y:
        return dict.fromkeys(NAMES)
    read = _read_ns(bag)
    steps, others = _half_ns(bag, read)
    delays = {"first": _first_ns(bag, read), "half_step": steps, "half_way": others}
    return {name: _percentiles(found) for name, found in delays.items()}


def rows(delays: dict[str, Any]) -> list[tuple[str, str]]:
    """Return name and text of each delay for a table; what a session does not tell is left out."""
    found = ((NAMES[name], part) for name, part in delays.items() if part is not None)
    return [(name, f"{part['p50']:.1f} ms median, {part['p99']:.1f} ms p99") for name, part in found]


def _first_ns(bag: Bag, read: Times) -> Floats:
    """Return from each joystick sample that counted to the first voltage that it could move [N] [ns]."""
    states, voltages = bag.series(topics.JOINT_STATES), bag.series(topics.VALVE_VOLTAGES)
    said, known = bag.sent_ns(topics.JOY), bag.series(topics.JOY).log_time_ns
    reading = np.flatnonzero(read >= 0)
    if len(said) < 2 or len(reading) == 0:
        return np.array([])
    so_far = np.maximum.accumulate(read[reading])
    passed = np.searchsorted(so_far, said[:-1], side="right")
    state = np.searchsorted(states.log_time_ns, known[1:])  # the first that knows of the sample
    heard = np.searchsorted(reading, state)
    places = np.maximum(passed, heard)
    last = np.minimum(places, len(reading) - 1)
    never_disarmed = reading[last] - state == last - heard
    counts = (places < len(reading)) & never_disarmed
    stamps = states.time_ns[reading[places[counts]]]
    answers = np.minimum(np.searchsorted(voltages.time_ns, stamps), len(voltages.time_ns) - 1)
    delays = voltages.log_time_ns[answers] - said[1:][counts]
    return np.asarray(delays[voltages.time_ns[answers] == stamps], dtype=float)


def _read_ns(bag: Bag) -> Times:
    """Return t of every state of the machine [M] [ns]; -1 while the joystick moves nothing."""
    states, joy, status = (
        bag.series(topic) for topic in (topics.JOINT_STATES, topics.JOY, topics.CONTROLLER_STATUS)
    )
    sent, said = bag.sent_ns(topics.JOINT_STATES), bag.sent_ns(topics.JOY)
    newest = np.searchsorted(joy.log_time_ns, states.log_time_ns, side="right") - 1
    steps = np.diff(states.time_ns, prepend=states.time_ns[:1]) * 1e-9
    armed = set(status.time_ns[status.column("armed") > 0.0].tolist())
    begun, hold, found = int(states.time_ns[0]), joystick_interpolation.CENTRED, []
    for k, stamp in enumerate(states.time_ns.tolist()):
        if stamp not in armed or newest[k] < 0:
            hold = joystick_interpolation.CENTRED
            found.append(-1)
            continue
        levers = levers_from_axes(tuple(joy.values[newest[k]].tolist()))
        times = (int(said[newest[k]]) - begun) * 1e-9, (int(sent[k]) - begun) * 1e-9
        hold = joystick_interpolation.interpolated(hold, levers, *times, float(steps[k]))
        found.append(begun + round(hold.at * 1e9))
    return np.array(found, dtype=np.int64)


class Movement(NamedTuple):
    """A signal's way from one extreme to the next."""

    middle: float  # [ns] when it passed its middle, on a line between two samples; a step: when it was said
    passed: int  # [ns] of the first sample past the middle
    rises: bool
    step: bool  # half of it at once


def _half_ns(bag: Bag, read: Times) -> tuple[Floats, Floats]:
    """Return from the middle of each lever's step, and of its other movements, to that of its wish [ns]."""
    joy, voltages = bag.series(topics.JOY), bag.series(topics.VALVE_VOLTAGES)
    levers = np.array([levers_from_axes(tuple(row)) for row in joy.values.tolist()])
    joint = bag.name(topics.TIP_TWIST_COMMAND) is None
    wish = bag.series(topics.VALVE_COMMANDS if joint else topics.TIP_TWIST_COMMAND)
    wished = wish.values[:, :3] if joint else wish.values[:, WISHED_BY]
    stamps = bag.series(topics.JOINT_STATES).time_ns[read >= 0]
    answer = np.minimum(np.searchsorted(voltages.time_ns, wish.time_ns), len(voltages.time_ns) - 1)
    counts = (voltages.time_ns[answer] == wish.time_ns) & np.isin(wish.time_ns, stamps)
    felt, found = voltages.log_time_ns[answer[counts]], []
    for i in range(3):
        causes = _movements(bag.sent_ns(topics.JOY), levers[:, i])
        found += _answered(causes, _movements(felt, wished[counts, i]))
    steps, others = ([delay for delay, step in found if step is wanted] for wanted in (True, False))
    return np.array(steps), np.array(others)


def _answered(causes: list[Movement], effects: list[Movement]) -> list[tuple[float, bool]]:
    """Return how long after each cause [ns] the next effect of its direction came, and whether a step."""
    found = []
    for cause in causes:
        delays = (one.passed - cause.middle for one in effects if one.rises == cause.rises)
        delay = next((delay for delay in delays if 0 <= delay < LONGEST), None)
        if delay is not None:
            found.append((delay, cause.step))
    return found


def _movements(times: Times, values: Floats) -> list[Movement]:
    """Return the ways of a signal from extreme to extreme."""
    least, found = MOVED * float(np.abs(values).max(initial=0.0)), []
    turns = _turns(values, least) if least > 0.0 else []
    for begun, end in pairwise(turns):
        rises = bool(values[end] > values[begun])
        middle = 0.5 * (values[begun] + values[end])
        way = values[begun : end + 1] - middle
        k = begun + int(np.argmax(way >= 0.0 if rises else way <= 0.0))
        share = float((middle - values[k - 1]) / (values[k] - values[k - 1]))
        at_once = bool(abs(values[k] - values[k - 1]) >= abs(middle - values[begun]))
        between = times[k - 1] + share * (times[k] - times[k - 1])
        found.append(Movement(float(times[k] if at_once else between), int(times[k]), rises, at_once))
    return found


def _turns(values: Floats, least: float) -> list[int]:
    """Return the places of a signal's extremes, each further than `least` from the one before."""
    low = high = 0
    turns: list[int] = []
    rising: bool | None = None
    for k, value in enumerate(values.tolist()):
        if rising is not False and value > values[high]:
            high = k
        if rising is not True and value < values[low]:
            low = k
        if rising is not True and value - values[low] >= least:
            turns.append(low)
            rising, high = True, k
        elif rising is not False and values[high] - value >= least:
            turns.append(high)
            rising, low = False, k
    return [*turns, high if rising else low] if turns else []


def _percentiles(delays: Floats) -> dict[str, float] | None:
    if len(delays) == 0:
        return None
    p50, p99 = (round(1e-6 * float(part), DIGITS) for part in np.percentile(delays, [50, 99]))
    return {"p50": p50, "p99": p99}
