"""Whether the valve driver is there, and does what it is told: its voltages tell.

While it is not, the crane stands, but a reference would run ahead, and the crane after it once the driver is
back. Of a driver that has never spoken nothing is expected: it may be in shadow, or somebody else's.
"""

import math
from typing import NamedTuple

from forest_description.types import ZERO, Vec3

SILENT = 0.2  # [s] at which the driver is missed: by then the valves are shut, and the reference is ahead
DEAF = 1.5  # [s] of shut valves at which it counts as not obeying: links may be 0.6 s late, either way
HEARD = 0.5  # [V] of an ideal valve: what is commanded beyond is more than any hold zone, and opens the valve


class DriverSample(NamedTuple):
    """The newest voltages that the driver has said."""

    voltages: Vec3 = ZERO  # [V]
    received: float = -math.inf  # [s]


class DriverResponse(NamedTuple):
    """When the driver was there."""

    heard: float = -math.inf  # [s] it spoke last
    obeyed: float = -math.inf  # [s] a valve was open last, or none had to be


def response(before: DriverResponse, driver: DriverSample, command: Vec3, now: float) -> DriverResponse:
    """Return the response at a time [s].

    Args:
        before: as it was.
        driver: what it has said.
        command: of ideal valves, the last one [V].
        now: local time [s].
    """
    obeys = driver.voltages != ZERO or max(abs(command[0]), abs(command[1]), abs(command[2])) <= HEARD
    is_there = now - driver.received <= SILENT
    return DriverResponse(driver.received, now if is_there and obeys else before.obeyed)


def responds(driver: DriverResponse, now: float) -> bool:
    """Tell whether a driver does what can be expected of it; `objection` says what it does not."""
    return driver.heard == -math.inf or (now - driver.heard <= SILENT and now - driver.obeyed <= DEAF)


def objection(driver: DriverResponse, now: float) -> str:
    """Return why commands do not reach the valves, or ""."""
    if responds(driver, now):
        return ""
    silent = now - driver.heard > SILENT
    return "valve driver: no voltages" if silent else "valve driver: keeps the valves shut"
