"""A person's run at the station, judged by the same measures: from a recorded bag.

The task begins with the first log that is grasped and ends with the eighth act. Acts are the changes of
`ground_truth/load`. The head's true angles and the engine's work are not always told: without a topic of the
head it hangs straight, and in place of the engine's work stands what the pump gave to its oil.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from forest_bag.read.timeseries import Bag, NotInBag, Series, read_bag
from forest_control.operator.levers import LEFT_X, LEFT_Y, RIGHT_Y
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_msgs_py.interfaces import topics
from forest_study.log_work.clearance import chain
from forest_study.log_work.site import Site, site_of
from forest_study.log_work.task import ACROSS, DOWN, UP, legs
from forest_study.log_work.work import LOOK_TIME, Work
from forest_study.results import StudyError


class Recorded(NamedTuple):
    """A person's run."""

    work: Work
    misses: list[float]  # of each act's place [m]


def read(path: Path, machine: Machine) -> Recorded:
    """Return the run of a bag.

    Raises:
        StudyError: the bag lacks a topic, or does not hold the task.
        FileNotFoundError: there is no bag.
    """
    try:
        return recorded(read_bag(path), machine)
    except NotInBag as error:
        raise StudyError(f"logs: {path}: {error}") from error


def recorded(bag: Bag, machine: Machine) -> Recorded:
    """Return the run of a bag that is read; errors as `read`, and NotInBag.

    Raises:
        StudyError: there are fewer acts than the task has.
    """
    site, load = site_of(machine), bag.series(topics.GROUND_TRUTH_LOAD)
    acts = [leg for leg in legs(site) if leg.act]
    at = _act_times(load, len(acts))
    time = np.arange(at[0], at[-1] + 1.0, 1e9 * LOOK_TIME)
    angles = _at(time, bag.series(topics.GROUND_TRUTH_JOINT_STATES), (0, 1, 2))
    head = np.zeros((len(time), 2))
    if bag.name(topics.GROUND_TRUTH_HEAD) is not None:
        head = _at(time, bag.series(topics.GROUND_TRUTH_HEAD), (0, 1))
    m = machine.manipulator
    _, _, grip, _ = chain(m, site, angles, head)
    number = np.clip(np.searchsorted(at, time, side="right"), 1, len(acts) - 1)
    held = np.searchsorted(load.time_ns, time, side="right") - 1  # 0 at least: the task begins with a change
    work = Work(
        machine=machine,
        site=site,
        angles=angles,
        head=head,
        tip=np.array([tip_position((a, b, c), m.links) for a, b, c in angles.tolist()]),
        levers=_said(time, bag.series(topics.JOY)),
        engine=_pump_work(time, bag.series(topics.SUPPLY)),
        number=number.astype(np.float64),
        part=_parts(grip[:, 2], number, site),
        loaded=load.column("mass")[held] / site.log_mass,
    )
    rows = np.minimum(np.searchsorted(time, at), len(time) - 1)
    away = [float(np.linalg.norm(grip[k] - np.array(leg.goal))) for k, leg in zip(rows, acts, strict=True)]
    return Recorded(work, away)


def _act_times(load: Series, count: int) -> Floats:
    """Return when the acts of the task were [count] ns."""
    holds = load.column("mass") > 0.0
    changes = 1 + np.flatnonzero(holds[1:] != holds[:-1])
    first = next((k for k, row in enumerate(changes) if holds[row]), len(changes))
    times = load.time_ns[changes[first:]].astype(np.float64)
    if len(times) < count:
        raise StudyError(
            f"logs: {len(times)} times a log was grasped or dropped; allowed: {count}, the whole task"
        )
    return times[:count]


def _at(time: Floats, series: Series, columns: tuple[int, ...]) -> Floats:
    """Return values at times [ns], straight between two messages."""
    stamps = series.time_ns.astype(np.float64)
    return np.column_stack([np.interp(time, stamps, series.values[:, k]) for k in columns])


def _said(time: Floats, joy: Series) -> Floats:
    """Return the levers as they were said last [N, 3]: swing, boom, stick."""
    row = np.searchsorted(joy.time_ns.astype(np.float64), time, side="right") - 1
    said = np.clip(joy.values[np.maximum(0, row)][:, [LEFT_X, RIGHT_Y, LEFT_Y]], -1.0, 1.0)
    levers: Floats = np.where(row[:, None] >= 0, said, 0.0)
    return levers


def _pump_work(time: Floats, supply: Series) -> Floats:
    """Return what the pump gave to its oil over each look [N] J."""
    stamps = supply.time_ns.astype(np.float64)
    power = supply.column("pressure") * supply.column("flow")
    work: Floats = LOOK_TIME * np.interp(time, stamps, power)
    return work


def _parts(
    height: Floats, number: "np.ndarray[tuple[int, ...], np.dtype[np.int64]]", site: Site
) -> tuple[str, ...]:
    """Return the part of a carry at each look: across while the grip is high."""
    high, found = height > site.clear - 0.6 * site.scale, []
    been, last = False, 0
    for now, k in zip(high.tolist(), number.tolist(), strict=True):
        been = (been and k == last) or now
        found.append(ACROSS if now else DOWN if been else UP)
        last = k
    return tuple(found)
