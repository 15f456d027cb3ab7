"""Dead time of the valves' electronics and pilot stages: a voltage acts later, and stays what it is.

What the valves were given is kept as its last changes. The last of them that begins to act within a step
begins at its own time there; one before it within the same step is passed over.

The history has `SIZE` places for the longest dead time T of the three. Changes nearer than
T/(SIZE - 1) are not all kept: the valve samples its input at that period. A voltage held for
longer than that, 1.8 ms at the longest dead time allowed, is late by its dead time and no more.
"""

from typing import NamedTuple

from forest_description.types import Vec3

SIZE = 12
AGED = 1.0  # [s] beyond which an age no longer counts: more than any dead time
ROUNDING = 1e-9  # [s]
Row = tuple[float, float, float, float, float, float, float, float, float, float, float, float]


class CommandHistory(NamedTuple):
    """The last changes of the voltages, the latest first."""

    ages: Row  # [s]
    swing: Row  # [V]
    boom: Row  # [V]
    stick: Row  # [V]


class Acting(NamedTuple):
    """What acts on a spool in a step."""

    before: float  # [V] up to the change
    change: float  # [s] from the step's beginning; 0: there is none
    voltage: float  # [V] from the change on


AllActing = tuple[Acting, Acting, Acting]


class Delayed(NamedTuple):
    """What acts on the spools in a step, and the history after it."""

    acting: AllActing
    history: CommandHistory


_ZEROS: Row = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
_LONG_AGO: Row = (AGED, AGED, AGED, AGED, AGED, AGED, AGED, AGED, AGED, AGED, AGED, AGED)
NO_COMMANDS = CommandHistory(_LONG_AGO, _ZEROS, _ZEROS, _ZEROS)


def held(voltages: Vec3) -> AllActing:
    """Return what acts on the spools while they follow voltages [V] at once."""
    return (
        Acting(voltages[0], 0.0, voltages[0]),
        Acting(voltages[1], 0.0, voltages[1]),
        Acting(voltages[2], 0.0, voltages[2]),
    )


def held_commands(voltages: Vec3) -> CommandHistory:
    """Return the history of voltages [V] that have been held for long."""
    one, two, three = ((v, v, v, v, v, v, v, v, v, v, v, v) for v in voltages)
    return CommandHistory(_LONG_AGO, one, two, three)


def after_dead_time(history: CommandHistory, voltages: Vec3, step: float, dead_times: Vec3) -> Delayed:
    """Return what acts on the spools in a step.

    Args:
        history: up to the step.
        voltages: given to the valves over the step [V].
        step: [s].
        dead_times: of swing, boom and stick [s]; 0: none.
    """
    history = _with_change(history, voltages, max(dead_times[0], dead_times[1], dead_times[2]))
    acting = (
        _acting(history.ages, history.swing, voltages[0], step, dead_times[0]),
        _acting(history.ages, history.boom, voltages[1], step, dead_times[1]),
        _acting(history.ages, history.stick, voltages[2], step, dead_times[2]),
    )
    return Delayed(
        acting, CommandHistory(_aged(history.ages, step), history.swing, history.boom, history.stick)
    )


def _with_change(h: CommandHistory, voltages: Vec3, longest: float) -> CommandHistory:
    """Return the history with the voltages if they are new, and the latest ones old enough."""
    same = voltages[0] == h.swing[0] and voltages[1] == h.boom[0] and voltages[2] == h.stick[0]
    if same or h.ages[0] + ROUNDING < longest / (SIZE - 1):
        return h
    return CommandHistory(
        _pushed(0.0, h.ages),
        _pushed(voltages[0], h.swing),
        _pushed(voltages[1], h.boom),
        _pushed(voltages[2], h.stick),
    )


def _acting(ages: Row, given: Row, voltage: float, step: float, dead_time: float) -> Acting:
    """Return what was given a dead time before a step's end [V], since when, and what before."""
    if dead_time == 0.0:
        return Acting(voltage, 0.0, voltage)
    k = 0
    while k < SIZE - 1 and ages[k] + step <= dead_time + ROUNDING:
        k += 1
    change = dead_time - ages[k]
    if k == SIZE - 1 or change <= ROUNDING:
        return Acting(given[k], 0.0, given[k])
    return Acting(given[k + 1], change, given[k])


def _pushed(new: float, r: Row) -> Row:
    return (new, r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8], r[9], r[10])


def _aged(ages: Row, time: float) -> Row:
    return (
        min(AGED, ages[0] + time),
        min(AGED, ages[1] + time),
        min(AGED, ages[2] + time),
        min(AGED, ages[3] + time),
        min(AGED, ages[4] + time),
        min(AGED, ages[5] + time),
        min(AGED, ages[6] + time),
        min(AGED, ages[7] + time),
        min(AGED, ages[8] + time),
        min(AGED, ages[9] + time),
        min(AGED, ages[10] + time),
        min(AGED, ages[11] + time),
    )
