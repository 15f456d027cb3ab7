"""Whether a joint goes back, or stands, although its valve is open.

A joint that goes back bears more than its actuator can. An open valve does not hold such a load, it lets its
oil back to the pump; a shut one bears as much as its relief valve. A joint that stands is held by its load or
by what it has met, or no voltage reaches its spool, or its valve has no oil. Once it comes free, an open
valve throws the tip. So the valves are shut, and a person must want to move again.

| symbol | name | unit |
|---|---|---|
| V | voltage of the joint's valve, as the driver says | V |
| u, v | commanded and measured joint rate | rad/s |
| way | what the joint has gone against its open valve, integral of abs v | rad |
| owed | what it has not gone with it: integral of abs u - abs v / `ANSWERS`, of low-passed u and v | rad |
| since | how long it has owed something | s |

Times begin once the pump may have built up its pressure: a load-sensing one takes its time from when a valve
opens, and a load moves its joint back meanwhile.

Not seen: a joint that goes at a tenth of its rate.
"""

import math
from typing import NamedTuple

from forest_control.config.controller_settings import Parameters
from forest_description.derived.actuator_kinematics import actuator_speeds_to_joint_rates
from forest_description.types import AXES, ZERO, Vec3

WAY = 0.005  # [rad] 30 mm of the tip at 6 m; a joint that turns round under a lagging valve goes less
LONG = (0.5, 0.1, 0.1)  # [s] in which oil turns a joint round; a swing rocks slowly on its hoses
OPEN = 0.4  # [1] of the way from the overlap's edge to the rated voltage: small openings are leakage's
OWED = 0.03  # [rad] twice what a joint owes that goes: 0.014 of the forwarder's swing, 0.011 in the matrix
OWED_LAG = 0.1  # [s] of both low-passes: what rocks at 4 Hz on its oil is no answer, what trembles no command
ANSWERS = 0.1  # [1] of u, at which a joint owes no more
STARTS = 0.3  # [s] a joint may owe more at a step of its lever: spool and oil take so long, at any rate


class Overload(NamedTuple):
    """Of swing, boom, stick, since each last went with its valve, or had it shut."""

    ways: Vec3 = ZERO  # [rad]
    times: Vec3 = ZERO  # [s] for which the valve has been as open as its voltage
    owed: Vec3 = ZERO  # [rad]
    since: Vec3 = ZERO  # [s]
    gone: Vec3 = ZERO  # v, low-passed [rad/s]
    told: Vec3 = ZERO  # u, likewise
    opened: Vec3 = ZERO  # [s] since the valve opened to this side, signed by it


def commanded_rates(angles: Vec3, command: Vec3, p: Parameters) -> Vec3:
    """Return the joint rates u [rad/s] that a command of ideal valves [V] asks for at joint angles [rad]."""
    speeds = (
        command[0] * p.rated_speeds[0] / p.rated_voltages[0],
        command[1] * p.rated_speeds[1] / p.rated_voltages[1],
        command[2] * p.rated_speeds[2] / p.rated_voltages[2],
    )
    return actuator_speeds_to_joint_rates(angles, speeds, p.linkages)


def opens(voltage: float, i: int, p: Parameters) -> bool:
    """Tell whether a voltage [V] brings its spool beyond the overlap."""
    law = p.speed_limits.axes[i].valve
    return -law.backward.deadband_voltage > voltage or voltage > law.forward.deadband_voltage


def watched(before: Overload, u: Vec3, rates: Vec3, voltages: Vec3, p: Parameters, dt: float) -> Overload:
    """Return what joints have gone against their valves, or not with them, after a sample.

    Args:
        before: as it was.
        u: commanded joint rates [rad/s].
        rates: measured joint rates [rad/s].
        voltages: of the valves since the last sample [V].
        p: the controller's parameters.
        dt: since the last sample [s].
    """
    opened = (
        _opened(before, voltages, 0, p, dt),
        _opened(before, voltages, 1, p, dt),
        _opened(before, voltages, 2, p, dt),
    )
    before = before._replace(opened=opened)
    gone, told = _passed(before.gone, rates, dt), _passed(before.told, u, dt)
    owed = (
        _owed(before, u, told, gone, voltages, 0, p, dt),
        _owed(before, u, told, gone, voltages, 1, p, dt),
        _owed(before, u, told, gone, voltages, 2, p, dt),
    )
    since = (
        _later(before, owed, 0, p, dt),
        _later(before, owed, 1, p, dt),
        _later(before, owed, 2, p, dt),
    )
    way_1, time_1 = _gone_back(before, rates, voltages, 0, p, dt)
    way_2, time_2 = _gone_back(before, rates, voltages, 1, p, dt)
    way_3, time_3 = _gone_back(before, rates, voltages, 2, p, dt)
    return Overload((way_1, way_2, way_3), (time_1, time_2, time_3), owed, since, gone, told, opened)


def _opened(before: Overload, voltages: Vec3, i: int, p: Parameters, dt: float) -> float:
    """Return for how long one valve has been open to its side [s], signed by it; 0: it is shut."""
    if not opens(voltages[i], i, p):
        return 0.0
    begun = before.opened[i] if before.opened[i] * voltages[i] > 0.0 else 0.0
    return begun + math.copysign(dt, voltages[i])


def is_fed(overload: Overload, i: int, p: Parameters) -> bool:
    """Tell whether one joint's valve has been open for as long as the pump may need for its pressure."""
    return abs(overload.opened[i]) > p.speed_limits.build_up


def _passed(before: Vec3, now: Vec3, dt: float) -> Vec3:
    """Return rates [rad/s] behind the low-pass."""
    weight = 1.0 - math.exp(-dt / OWED_LAG)
    return (
        before[0] + weight * (now[0] - before[0]),
        before[1] + weight * (now[1] - before[1]),
        before[2] + weight * (now[2] - before[2]),
    )


def _owed(
    before: Overload, u: Vec3, told: Vec3, gone: Vec3, voltages: Vec3, i: int, p: Parameters, dt: float
) -> float:
    """Return what one joint has not gone with its open valve [rad], never less than zero."""
    if not opens(voltages[i], i, p) or voltages[i] * u[i] <= 0.0:
        return 0.0
    return max(0.0, before.owed[i] + (abs(told[i]) - abs(gone[i]) / ANSWERS) * dt)


def _later(before: Overload, owed: Vec3, i: int, p: Parameters, dt: float) -> float:
    """Return how long one joint has owed something [s], from below zero for its spool's lag."""
    if owed[i] <= 0.0:
        return 0.0
    begun = before.since[i] if before.owed[i] > 0.0 else -p.speed_limits.axes[i].spool.lag
    return begun + dt if is_fed(before, i, p) else begun


def _gone_back(
    before: Overload, rates: Vec3, voltages: Vec3, i: int, p: Parameters, dt: float
) -> tuple[float, float]:
    """Return way [rad] and time [s] that one joint has gone against its valve."""
    axis = p.speed_limits.axes[i]
    law = axis.valve
    edge = law.forward.deadband_voltage if voltages[i] > 0.0 else law.backward.deadband_voltage
    is_open = abs(voltages[i]) > edge + OPEN * (p.rated_voltages[i] - edge)
    if not is_open or voltages[i] * rates[i] >= 0.0:
        return 0.0, 0.0
    # A spool that lags opens by and by: its time begins below zero.
    time = before.times[i] if before.ways[i] > 0.0 else -axis.spool.lag
    return before.ways[i] + abs(rates[i]) * dt, time + dt if is_fed(before, i, p) else time


def is_overloaded(overload: Overload) -> bool:
    """Tell whether a joint goes back or stands; `objection` says which."""
    return _refuses(overload, 0) or _refuses(overload, 1) or _refuses(overload, 2)


def _refuses(overload: Overload, i: int) -> bool:
    """Tell whether one joint goes back, or stands; one that pays what it owes has only started late."""
    told = overload.told[i]
    pays = overload.gone[i] * told > ANSWERS * told * told
    return goes_back(overload, i) or (overload.owed[i] > OWED and overload.since[i] > STARTS and not pays)


def goes_back(overload: Overload, i: int) -> bool:
    """Tell whether one joint is driven back."""
    return overload.ways[i] > WAY and overload.times[i] > LONG[i]


def objection(overload: Overload) -> str:
    """Return which joint its load drives back or holds, or ""."""
    for i, name in enumerate(AXES):
        if goes_back(overload, i):
            way, time = overload.ways[i], overload.times[i]
            return (
                f"overload: {name} went back by {way:.3f} rad in {time:.2f} s though its valve is open;"
                f" allowed: put the load down, or draw it in"
            )
        if _refuses(overload, i):
            return (
                f"overload: {name} stands though its valve is open; allowed: free it, put the load down, or"
                f" check oil, the valves' cable and parameter machine"
            )
    return ""
