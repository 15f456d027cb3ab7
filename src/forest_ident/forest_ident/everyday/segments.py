"""Parts of everyday work that can be predicted: each begins at rest, and ends at the next rest.

A prediction needs a start that is known. At rest with shut valves the angles and pressures that are read are
that: `REST` seconds before the first opening nothing may move or rock. What begins otherwise is left out.

A log in the head is another machine. Cylinder forces at rest weigh what the tip carries, before and after
each part. The empty head is what the lightest parts carry; what is heavier by `LOG` is left out.
"""

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy

from forest_description.machine import Machine
from forest_description.types import AXES, Bools, Floats
from forest_ident.estimators import gravity
from forest_ident.measurements.session import Session, SessionError

REST = 0.4  # [s] before the first opening: two periods of a rocking crane
STILL = 1e-3  # [rad] within which a resting joint stays
CALM = 0.05  # of the pump's pressure, within which the ports of a resting crane stay
LONGEST = 10.0  # [s] of motion: later, the errors of speeds have summed up
SHORTEST = 1.0  # [s]
MOVES = 0.05  # [rad] that some joint goes at least
LIGHTEST = 0.2  # share of the parts that carry no log, at least
LOG = 0.15  # of the head's mass: dry seals feign less


class Segment(NamedTuple):
    """A part of the work."""

    session: Session
    bag: str
    begin: float  # [s] in its bag
    opening: int  # row of the first opening
    head: float = float("nan")  # [kg] that the tip carries, as the rest before weighs it


class Cut(NamedTuple):
    """What the bags' parts are, and what was left out."""

    segments: list[Segment]
    left_out: list[str]  # in words


def cut(machine: Machine, sessions: dict[str, Session]) -> Cut:
    """Return the parts of all bags that can be predicted.

    Args:
        machine: the start.
        sessions: by the name of the bag.

    Raises:
        SessionError: there is none.
    """
    found = [one for bag, session in sessions.items() for one in _segments(machine, bag, session)]
    if not found:
        raise SessionError(
            f"{', '.join(sessions)}: no motion begins at rest; allowed: work with pauses of {REST:g} s and "
            "more, in which valves are shut and nothing rocks, and motions after them"
        )
    empty = [one for one, loaded in zip(found, _loaded(machine, found), strict=True) if not loaded]
    total = sum(session.time[-1] for session in sessions.values())
    used = sum(one.session.time[-1] - one.session.time[0] for one in found)
    left = [f"{max(0.0, total - used):.0f} of {total:.0f} s: pauses, or motion without a rest before it"]
    if len(empty) < len(found):
        left.append(
            f"{len(found) - len(empty)} of {len(found)} parts: a log was carried, or grasped, or dropped"
        )
    return Cut(empty, left)


def _segments(machine: Machine, bag: str, session: Session) -> list[Segment]:
    shut = _shut(machine, session)
    ready = shut & _resting(machine, session, shut)
    rows, longest = round(REST / session.period), round(LONGEST / session.period)
    openings = np.flatnonzero(ready[:-1] & ~shut[1:]) + 1
    rests, found = np.flatnonzero(ready), []
    for opening in openings[openings >= rows].tolist():
        after = int(np.searchsorted(rests, opening))
        end = min(opening + longest, int(rests[after]) if after < len(rests) else len(session.time))
        part = _part(session, opening - rows, end, rows)
        if end - opening >= SHORTEST / session.period and _moves(part):
            head = _weighed(machine, part.part(0, rows))
            found.append(Segment(part, bag, float(session.time[opening - rows]), rows, head))
    return found


def _part(session: Session, first: int, last: int, rows: int) -> Session:
    """Return some rows, with no voltage in those at rest: within the overlap nothing flows."""
    part = session.part(first, last)
    voltages = part.voltages.copy()
    voltages[:rows] = 0.0
    return dataclasses.replace(part, voltages=voltages, time=part.time - part.time[0])


def _shut(machine: Machine, session: Session) -> Bools:
    """Return the rows in which all valves stay within their overlap."""
    shut = np.ones(len(session.time), dtype=bool)
    for axis in range(3):
        law = machine.valve_of(axis).law
        volts = session.voltages[:, axis]
        shut &= (volts < law.forward.deadband_voltage) & (volts > -law.backward.deadband_voltage)
    return shut


def _resting(machine: Machine, session: Session, shut: Bools) -> Bools:
    """Return the rows before which the crane rested for a while."""
    rows, quarter = round(REST / session.period), round(0.25 * REST / session.period)
    resting: Bools = _within(shut.astype(np.float64), rows) == 0.0
    for axis in AXES:
        smoothed = scipy.ndimage.uniform_filter1d(session.column(f"{axis}_resolver"), quarter)
        resting &= _within(smoothed, rows) < STILL
    for name, column in session.readings.items():
        if name.endswith("_actuator"):
            resting &= _within(column, rows) < CALM * machine.pump.supply_pressure
    resting[:rows] = False
    return resting


def _within(column: Floats, rows: int) -> Floats:
    """Return the range of a column's last rows, at each row."""
    late = rows // 2 - (1 - rows % 2)  # filters are centred
    high = scipy.ndimage.maximum_filter1d(column, rows, origin=late)
    return np.asarray(high - scipy.ndimage.minimum_filter1d(column, rows, origin=late))


def _moves(part: Session) -> bool:
    return any(np.ptp(part.column(f"{axis}_resolver")) > MOVES for axis in AXES)


def _weighed(machine: Machine, rest: Session) -> float:
    """Return what the tip carries [kg]; NaN without pressures."""
    if not rest.has(*(f"{axis}_pressure_{port}_actuator" for axis in AXES[1:] for port in (1, 2))):
        return float("nan")
    return float(gravity.masses(machine, rest).values[0])


def _loaded(machine: Machine, found: Sequence[Segment]) -> Bools:
    """Return which parts begin or end with a log."""
    heads = np.array([one.head for one in found])
    if np.isnan(heads).any():
        return np.zeros(len(found), dtype=bool)
    heavy = heads > np.quantile(heads, 0.5 * LIGHTEST) + LOG * machine.manipulator.head_mass
    bags = np.array([one.bag for one in found])
    after = np.append(heavy[1:] & (bags[1:] == bags[:-1]), False)
    return np.asarray(heavy | after)
