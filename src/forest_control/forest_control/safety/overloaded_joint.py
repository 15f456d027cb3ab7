"""Whether a joint goes against its commands, or stands, although its valve is open.

A joint that goes back bears more than its actuator can. An open valve does not hold such a load, it lets its
oil back to the pump; a shut one bears as much as its relief valve. A joint that stands is held by its load or
by what it has met, or no voltage reaches its spool, or its valve has no oil. Once it comes free, an open
valve throws the tip. So the valves are shut, and a person must want to move again.

| symbol | name | unit |
|---|---|---|
| V | voltage of the joint's valve, as the driver says | V |
| u, v | commanded and measured joint rate | rad/s |
| w | u behind a low-pass of `OIL` and the spool's lag; 0: the valve is shut | rad/s |
| agreement | mean of w v over `TOGETHER`; of boom and stick at most `AGAINST` | rad^2/s^2 |
| deficit | what it has not gone with it: integral of abs u - abs v / `ANSWERS`, of low-passed u and v | rad |
| deficit time | how long there has been one | s |

A joint that rocks on its oil is almost half a period behind its command, and w up to a quarter: so w and v
agree. Behind a valve that is wired the other way they do not, whether the joint rocks or goes. However well
boom or stick have gone before, they are named as soon. A log sways its swing to and fro: good ways count.

A boom that bears as much as the pump does sinks while a person puts its load down, and a servo that would
have it slower opens the valve against that. So there only a valve that is wide open counts; and where no
pressure is measured.

Times begin once the pump may have built up its pressure: a load-sensing one takes its time from when a valve
opens, and a load moves its joint back meanwhile.

Not seen: a joint that goes at a tenth of its rate.
"""

import math
from typing import NamedTuple

from forest_control.config.controller_settings import Parameters
from forest_control.limits.load_weighing import Pressures
from forest_description.derived.actuator_kinematics import actuator_speeds_to_joint_rates
from forest_description.types import AXES, ZERO, Vec3

OIL = 0.05  # [s] of w: up to a quarter of a period late where a joint rocks, from 3 Hz on
TOGETHER = (0.4, 0.3, 0.3)  # [s] of the means: joints rock on their oil, and loads that slip throw them
AGAINST = (2e-3, 1e-3, 2e-3)  # [rad^2/s^2] of the mean of -w v; a log that sways gave a swing 1e-3
BORNE = 0.9  # [1] of the pump's pressure in the side that is fed, from which a load presses the boom back
WIDE = 0.4  # [1] of the way from the overlap's edge to the rated voltage, from which it counts all the same
OWED = 0.03  # [rad] of deficit, twice a sound joint's: 0.014 of the forwarder's swing, 0.011 in the matrix
OWED_LAG = 0.1  # [s] of both low-passes: what rocks at 4 Hz on its oil is no answer, what trembles no command
ANSWERS = 0.1  # [1] of u, at which a deficit grows no more
STARTS = 0.3  # [s] the deficit may be greater at a step of its lever: spool and oil take so long, at any rate


class Overload(NamedTuple):
    """Of swing, boom, stick, since each last went with its valve, or had it shut."""

    lagged_command: Vec3 = ZERO  # w [rad/s]
    agreement: Vec3 = ZERO  # [rad^2/s^2]
    deficit: Vec3 = ZERO  # [rad]
    deficit_time: Vec3 = ZERO  # [s]
    filtered_rate: Vec3 = ZERO  # v, low-passed [rad/s]
    filtered_command: Vec3 = ZERO  # u, likewise
    open_time: Vec3 = ZERO  # [s] since the valve opened to this side, signed by it


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


def borne(voltages: Vec3, pressures: Pressures, p: Parameters) -> float:
    """Return the pressure of the boom's side that is fed, in the pump's [1]; NaN: it is not measured."""
    return (pressures[0] if voltages[1] > 0.0 else pressures[1]) / p.speed_limits.supply_pressure


def updated_overload(
    before: Overload,
    u: Vec3,
    rates: Vec3,
    voltages: Vec3,
    pressures: Pressures,
    p: Parameters,
    dt: float,
) -> Overload:
    """Return what joints have gone against their valves, or not with them, after a sample.

    Args:
        before: as it was.
        u: commanded joint rates [rad/s].
        rates: measured joint rates [rad/s].
        voltages: of the valves since the last sample [V].
        pressures: in the boom's cylinder, head and rod side [Pa]; NaN: not measured.
        p: the controller's parameters.
        dt: since the last sample [s].
    """
    open_time = (
        _open_time(before, voltages, 0, p, dt),
        _open_time(before, voltages, 1, p, dt),
        _open_time(before, voltages, 2, p, dt),
    )
    before = before._replace(open_time=open_time)
    slow_rates = _low_passed(before.filtered_rate, rates, dt)
    slow_commands = _low_passed(before.filtered_command, u, dt)
    deficit = (
        _deficit(before, u, slow_commands, slow_rates, voltages, 0, p, dt),
        _deficit(before, u, slow_commands, slow_rates, voltages, 1, p, dt),
        _deficit(before, u, slow_commands, slow_rates, voltages, 2, p, dt),
    )
    deficit_time = (
        _deficit_time(before, deficit, 0, p, dt),
        _deficit_time(before, deficit, 1, p, dt),
        _deficit_time(before, deficit, 2, p, dt),
    )
    counts = _is_wide(voltages[1], p) or borne(voltages, pressures, p) <= BORNE
    lagged_command = (
        _lagged_command(before, u, voltages, 0, p, dt),
        _lagged_command(before, u, voltages, 1, p, dt),
        _lagged_command(before, u, voltages, 2, p, dt),
    )
    agreement = (
        _agreement(before, lagged_command, rates, is_fed(before, 0, p), 0, dt),
        _agreement(before, lagged_command, rates, counts and is_fed(before, 1, p), 1, dt),
        _agreement(before, lagged_command, rates, is_fed(before, 2, p), 2, dt),
    )
    return Overload(lagged_command, agreement, deficit, deficit_time, slow_rates, slow_commands, open_time)


def _open_time(before: Overload, voltages: Vec3, i: int, p: Parameters, dt: float) -> float:
    """Return for how long one valve has been open to its side [s], signed by it; 0: it is shut."""
    if not opens(voltages[i], i, p):
        return 0.0
    begun = before.open_time[i] if before.open_time[i] * voltages[i] > 0.0 else 0.0
    return begun + math.copysign(dt, voltages[i])


def is_fed(overload: Overload, i: int, p: Parameters) -> bool:
    """Tell whether one joint's valve has been open for as long as the pump may need for its pressure."""
    return abs(overload.open_time[i]) > p.speed_limits.build_up


def _low_passed(before: Vec3, now: Vec3, dt: float) -> Vec3:
    """Return rates [rad/s] behind the low-pass."""
    weight = 1.0 - math.exp(-dt / OWED_LAG)
    return (
        before[0] + weight * (now[0] - before[0]),
        before[1] + weight * (now[1] - before[1]),
        before[2] + weight * (now[2] - before[2]),
    )


def _deficit(
    before: Overload, u: Vec3, commands: Vec3, rates: Vec3, voltages: Vec3, i: int, p: Parameters, dt: float
) -> float:
    """Return what one joint has not gone with its open valve [rad], never less than zero."""
    if not opens(voltages[i], i, p) or voltages[i] * u[i] <= 0.0:
        return 0.0
    return max(0.0, before.deficit[i] + (abs(commands[i]) - abs(rates[i]) / ANSWERS) * dt)


def _deficit_time(before: Overload, deficit: Vec3, i: int, p: Parameters, dt: float) -> float:
    """Return how long one joint has had a deficit [s], from below zero for its spool's lag."""
    if deficit[i] <= 0.0:
        return 0.0
    begun = before.deficit_time[i] if before.deficit[i] > 0.0 else -p.speed_limits.axes[i].spool.lag
    return begun + dt if is_fed(before, i, p) else begun


def _is_wide(voltage: float, p: Parameters) -> bool:
    """Tell whether a voltage [V] opens the boom's valve wide."""
    law = p.speed_limits.axes[1].valve
    edge = law.forward.deadband_voltage if voltage > 0.0 else law.backward.deadband_voltage
    return abs(voltage) > edge + WIDE * (p.rated_voltages[1] - edge)


def _lagged_command(before: Overload, u: Vec3, voltages: Vec3, i: int, p: Parameters, dt: float) -> float:
    """Return w of one joint [rad/s]."""
    now = u[i] if opens(voltages[i], i, p) else 0.0
    weight = 1.0 - math.exp(-dt / (OIL + p.speed_limits.axes[i].spool.lag))
    return before.lagged_command[i] + weight * (now - before.lagged_command[i])


def _agreement(before: Overload, lagged_command: Vec3, rates: Vec3, counts: bool, i: int, dt: float) -> float:
    """Return the agreement of one joint [rad^2/s^2]."""
    now = lagged_command[i] * rates[i] if counts else 0.0
    mean = before.agreement[i] + (1.0 - math.exp(-dt / TOGETHER[i])) * (now - before.agreement[i])
    return mean if i == 0 else min(AGAINST[i], mean)


def is_overloaded(overload: Overload) -> bool:
    """Tell whether a joint goes against its commands or stands; `objection` says which."""
    return _refuses(overload, 0) or _refuses(overload, 1) or _refuses(overload, 2)


def _refuses(overload: Overload, i: int) -> bool:
    """Tell whether one joint goes back or stands; one that catches up has only started late."""
    command = overload.filtered_command[i]
    catches_up = overload.filtered_rate[i] * command > ANSWERS * command * command
    stands = overload.deficit[i] > OWED and overload.deficit_time[i] > STARTS and not catches_up
    return goes_back(overload, i) or stands


def goes_back(overload: Overload, i: int) -> bool:
    """Tell whether one joint goes against its commands: a load drives it, or its valve is reversed."""
    return overload.agreement[i] < -AGAINST[i]


def objection(overload: Overload) -> str:
    """Return which joint its load drives back or holds, or ""."""
    for i, name in enumerate(AXES):
        if goes_back(overload, i):
            return (
                f"overload: {name} went back though its valve is open; allowed: put the load down, draw it"
                f" in, or check oil, sensor, valve and its cable"
            )
        if _refuses(overload, i):
            return (
                f"overload: {name} stands though its valve is open; allowed: free it, put the load down, or"
                f" check oil, the valves' cable and parameter machine"
            )
    return ""
