"""A bag as the monitor would have read it live: at each state of the joints, the newest of all else."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_bag.read.timeseries import Bag, read_bag
from forest_description.types import AXES, Floats
from forest_ident.diagnosis.monitor_parameters import MonitorParameters
from forest_ident.diagnosis.monitor_readings import Learnt, Readings, Way
from forest_ident.measurements.session import SessionError
from forest_msgs_py.interfaces.topics import (
    ACTUATOR_STATES,
    AUXILIARY,
    FLOWS,
    JOINT_STATES,
    PRESSURES,
    SUPPLY,
    VALVE_DRIVER_STATUS,
    VALVE_VOLTAGES,
    Topic,
)

AS_LIVE = MonitorParameters()  # its timeouts
LONGEST = 0.1  # [s] between two states that count as one period
LEARNT = tuple(
    f"{axis}_{way}_{what}"
    for axis in AXES
    for way in ("forward", "backward")
    for what in ("deadband", "gain", "deadband_spread", "gain_spread")
)
PARTS: tuple[tuple[Topic, tuple[str, ...]], ...] = (
    (VALVE_VOLTAGES, AXES),
    (JOINT_STATES, tuple(f"{axis}.position" for axis in AXES)),
    (ACTUATOR_STATES, ("boom_cylinder.position", "stick_cylinder.position")),
    (PRESSURES, PRESSURES.labels),
    (SUPPLY, ("pressure",)),
    (AUXILIARY, (*(f"{axis}_spool" for axis in AXES), "case_drain_flow", "tank_temperature")),
    (FLOWS, FLOWS.labels),
    (VALVE_DRIVER_STATUS, LEARNT),
)
"""Topics that the monitor reads, with the labels that it wants of them."""


class Sample(NamedTuple):
    """What a bag told at a time."""

    time: float  # [s] since its beginning
    dt: float  # [s] since the last sample
    readings: Readings


def readings_of(row: list[float]) -> Readings:
    """Return the readings of the numbers of `PARTS`, one after the other, in the topics' units."""
    volts = [0.0 if math.isnan(x) else x for x in row[0:3]]  # a driver that is silent opens nothing
    angles, lengths, ports = row[3:6], row[6:8], row[8:20]
    spools, flows, learnt = row[21:24], row[26:28], row[28:]
    swing, boom, stick = (
        Learnt(Way(*learnt[8 * i : 8 * i + 4]), Way(*learnt[8 * i + 4 : 8 * i + 8])) for i in range(3)
    )
    return Readings(
        voltages=(volts[0], volts[1], volts[2]),
        angles=(angles[0], angles[1], angles[2]),
        lengths=(lengths[0], lengths[1]),
        pressures=tuple(ports),
        supply=row[20],
        spools=(spools[0], spools[1], spools[2]),
        flows=(flows[0], flows[1]),
        case_drain=row[24],
        temperature=row[25],
        valves=(swing, boom, stick),
    )


def samples(path: Path) -> Iterator[Sample]:
    """Yield what a bag told, state by state.

    Raises:
        SessionError: it holds no states of the joints, or no voltages.
        FileNotFoundError: there is no bag.
    """
    bag = read_bag(path)
    for topic in (JOINT_STATES, VALVE_VOLTAGES):
        if bag.name(topic) is None:
            raise SessionError(f"{path}: no topic {topic.name}; the monitor needs angles and voltages")
    base = bag.series(JOINT_STATES).time_ns
    base = base[np.concatenate([[True], np.diff(np.maximum.accumulate(base)) > 0])]  # stamps that rise
    table = np.hstack([_column(bag, topic, labels, base) for topic, labels in PARTS])
    time = (base - base[0]) * 1e-9
    before = -math.inf
    for now, row in zip(time.tolist(), table.tolist(), strict=True):
        yield Sample(now, min(LONGEST, now - before), readings_of(row))
        before = now


def _column(bag: Bag, topic: Topic, labels: tuple[str, ...], base: NDArray[np.int64]) -> Floats:
    """Return a topic's newest values at times [ns]; NaN where it is too old, or lacks the label."""
    found = np.full((len(base), len(labels)), math.nan)
    if bag.name(topic) is None:
        return found
    series = bag.series(topic)
    until = base - 1 if topic is VALVE_VOLTAGES else base  # a voltage acts from the next state on
    at = np.searchsorted(series.time_ns, until, side="right") - 1
    oldest = 1e9 * (AS_LIVE.slow_timeout if topic is VALVE_DRIVER_STATUS else AS_LIVE.timeout)
    fresh = (at >= 0) & (base - series.time_ns[np.maximum(at, 0)] <= oldest)
    for i, label in enumerate(labels):
        if label in series.labels:
            found[fresh, i] = series.column(label)[at[fresh]]
    return found
