"""What the monitor reads of a machine in one sample: every topic that is there, NaN for what is not."""

import math
from typing import NamedTuple

from forest_description.types import AXES, Vec3

NAN = math.nan
NOTHING: Vec3 = (NAN, NAN, NAN)
PORTS = tuple(f"{axis}_pressure_{port}" for axis in AXES for port in (1, 2))
CHANNELS = (
    *(f"{axis}_resolver" for axis in AXES),
    *("boom_transducer", "stick_transducer"),
    *(f"{port}_{place}" for port in PORTS for place in ("valve", "actuator")),
    "supply_pressure",
    *(f"{axis}_spool" for axis in AXES),
    *("swing_flow", "stick_flow"),
)
"""The sensors that are watched one by one, by the names of `sensor_suite.CHANNELS`."""
COUNT = len(CHANNELS)


class Way(NamedTuple):
    """One direction of a valve as the driver has learnt it."""

    deadband: float = NAN  # [V]
    gain: float = NAN  # [1] of the file's
    deadband_spread: float = NAN  # [V]
    gain_spread: float = NAN  # [1]


class Learnt(NamedTuple):
    """One valve as the driver has learnt it."""

    forward: Way = Way()
    backward: Way = Way()


class Readings(NamedTuple):
    """One sample."""

    voltages: Vec3  # [V] at the amplifiers
    angles: Vec3 = NOTHING  # [rad]
    lengths: tuple[float, float] = (NAN, NAN)  # [m] of boom's and stick's cylinder
    pressures: tuple[float, ...] = (NAN,) * 12  # [Pa] by axis, port, place (valve, actuator)
    supply: float = NAN  # [Pa]
    spools: Vec3 = NOTHING  # [V]
    flows: tuple[float, float] = (NAN, NAN)  # [m^3/s] into port 1 of swing and stick
    case_drain: float = NAN  # [m^3/s]
    temperature: float = NAN  # [K] of the oil in the tank
    valves: tuple[Learnt, Learnt, Learnt] = (Learnt(), Learnt(), Learnt())


def channels(r: Readings) -> tuple[float, ...]:
    """Return the readings in the order of `CHANNELS` [`COUNT`]: rad, m, Pa, V, m^3/s."""
    return (
        *r.angles,
        *r.lengths,
        *r.pressures,
        r.supply,
        *r.spools,
        *r.flows,
    )
