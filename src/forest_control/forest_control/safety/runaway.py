"""Whether a joint goes by itself although its valve is shut: a spool that sticks, a pipe that is torn.

No voltage stops such a joint. The crane stands as far as it can, and a person is told to shut off the
hydraulics.

| symbol | name | unit |
|---|---|---|
| V | voltage of the joint's valve, as the driver says | V |
| v | measured joint rate | rad/s |
| way | what the joint has gone one way under a shut valve, integral of v | rad |
| v_0 | rate at which that way began | rad/s |

A joint that is stopped at full speed brakes over its relief valves, and goes on for a while. It gets slower
all the time; so its way must be longer than what v_0 makes in `BRAKES`.

Not seen: a joint that sinks more slowly than `SLOW`, and one whose valve the servo opens against it; that is
`overloaded_joint`'s.
"""

import math
from typing import NamedTuple

from forest_control.config.controller_settings import Parameters
from forest_description.types import AXES, ZERO, Vec3

SLOW = 0.05  # [rad/s] motors that leak sink at a quarter of it on a platform tilted by 10 degrees
WAY = 0.05  # [rad] 0.3 m of the tip at 6 m
BRAKES = 1.0  # [s] of v_0: a swing with 1.15 t, arm out, that is stopped at 0.47 rad/s goes half of that
LONG = 0.4  # [s] twice the half period of a swing that rocks on its hoses


class Runaway(NamedTuple):
    """Of swing, boom, stick, since each last turned round, stood, or had its valve open."""

    ways: Vec3 = ZERO  # [rad]
    times: Vec3 = ZERO  # [s]
    firsts: Vec3 = ZERO  # |v_0| [rad/s]


def updated_runaway(before: Runaway, rates: Vec3, voltages: Vec3, p: Parameters, dt: float) -> Runaway:
    """Return what joints have gone under shut valves after a sample.

    Args:
        before: as it was.
        rates: measured joint rates [rad/s].
        voltages: of the valves since the last sample [V].
        p: the controller's parameters.
        dt: since the last sample [s].
    """
    way_1, time_1, first_1 = _gone(before, rates, voltages, 0, p, dt)
    way_2, time_2, first_2 = _gone(before, rates, voltages, 1, p, dt)
    way_3, time_3, first_3 = _gone(before, rates, voltages, 2, p, dt)
    return Runaway((way_1, way_2, way_3), (time_1, time_2, time_3), (first_1, first_2, first_3))


def _gone(
    before: Runaway, rates: Vec3, voltages: Vec3, i: int, p: Parameters, dt: float
) -> tuple[float, float, float]:
    """Return way [rad] and time [s] that one joint has gone under its shut valve, and |v_0| [rad/s]."""
    law, v, way = p.speed_limits.axes[i].valve, rates[i], before.ways[i]
    shut = -law.backward.deadband_voltage <= voltages[i] <= law.forward.deadband_voltage
    if (voltages[i] != 0.0 and not shut) or abs(v) < SLOW:
        return 0.0, 0.0, 0.0
    if way * v <= 0.0:
        return v * dt, dt, abs(v)
    return way + v * dt, before.times[i] + dt, before.firsts[i]


def runs_away(runaway: Runaway) -> bool:
    """Tell whether a joint goes by itself; `objection` says which."""
    return _runs(runaway, 0) or _runs(runaway, 1) or _runs(runaway, 2)


def _runs(runaway: Runaway, i: int) -> bool:
    return abs(runaway.ways[i]) > WAY + BRAKES * runaway.firsts[i] and runaway.times[i] > LONG


def objection(runaway: Runaway) -> str:
    """Return which joint goes by itself, or ""."""
    for i, name in enumerate(AXES):
        if _runs(runaway, i):
            return (
                f"machine: {name} goes by itself, {math.degrees(abs(runaway.ways[i])):.0f} degrees though its"
                f" valve is shut; allowed: shut off the hydraulics, a spool sticks or a pipe is torn"
            )
    return ""
