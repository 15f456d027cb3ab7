"""Whether a joint goes back although its valve is open: the load is more than the actuator can bear.

An open valve does not hold such a load, it lets its oil back to the pump; a shut one bears as much as its
relief valve. And once the load slips, an open valve throws the tip. So the valves are shut.

| symbol | name | unit |
|---|---|---|
| V | voltage of the joint's valve, as the driver says | V |
| v | measured joint rate | rad/s |
| way | what the joint has gone against its open valve, integral of abs v | rad |

Not seen: a joint that its load only holds. There the reference waits for it (`valve.tracking_limit`).
"""

from typing import NamedTuple

from forest_control.config.controller_settings import Parameters
from forest_description.types import AXES, ZERO, Vec3

WAY = 0.005  # [rad] 30 mm of the tip at 6 m; a joint that turns round under a lagging valve goes less
LONG = (0.5, 0.1, 0.1)  # [s] in which oil turns a joint round; a swing rocks slowly on its hoses
LAGS = 1.0  # [1] time constants of its spool until a valve counts as open as its voltage; chosen
OPEN = 0.4  # [1] of the way from the overlap's edge to the rated voltage: small openings are leakage's


class Sinking(NamedTuple):
    """Of swing, boom, stick, since each last went with its valve, or had it shut."""

    ways: Vec3 = ZERO  # [rad]
    times: Vec3 = ZERO  # [s] for which the valve has been as open as its voltage


def watched(before: Sinking, rates: Vec3, voltages: Vec3, p: Parameters, dt: float) -> Sinking:
    """Return what joints have gone against their valves after a sample.

    Args:
        before: as it was.
        rates: measured joint rates [rad/s].
        voltages: of the valves since the last sample [V].
        p: the controller's parameters.
        dt: since the last sample [s].
    """
    way_1, time_1 = _gone_back(before, rates, voltages, 0, p, dt)
    way_2, time_2 = _gone_back(before, rates, voltages, 1, p, dt)
    way_3, time_3 = _gone_back(before, rates, voltages, 2, p, dt)
    return Sinking((way_1, way_2, way_3), (time_1, time_2, time_3))


def _gone_back(
    before: Sinking, rates: Vec3, voltages: Vec3, i: int, p: Parameters, dt: float
) -> tuple[float, float]:
    """Return way [rad] and time [s] that one joint has gone against its valve."""
    axis = p.speed_limits.axes[i]
    law = axis.valve
    edge = law.forward.deadband_voltage if voltages[i] > 0.0 else law.backward.deadband_voltage
    is_open = abs(voltages[i]) > edge + OPEN * (p.rated_voltages[i] - edge)
    if not is_open or voltages[i] * rates[i] >= 0.0:
        return 0.0, 0.0
    # A spool that lags opens by and by: its time begins below zero.
    time = before.times[i] if before.ways[i] > 0.0 else -LAGS * axis.spool.lag
    return before.ways[i] + abs(rates[i]) * dt, time + dt


def is_sinking(sinking: Sinking) -> bool:
    """Tell whether a load drives a joint back; `objection` says which."""
    return sinks(sinking, 0) or sinks(sinking, 1) or sinks(sinking, 2)


def sinks(sinking: Sinking, i: int) -> bool:
    """Tell whether one joint is driven back."""
    return sinking.ways[i] > WAY and sinking.times[i] > LONG[i]


def objection(sinking: Sinking) -> str:
    """Return which joint its load drives back, or ""."""
    for i, name in enumerate(AXES):
        if sinks(sinking, i):
            way, time = sinking.ways[i], sinking.times[i]
            return (
                f"overload: {name} went back by {way:.3f} rad in {time:.2f} s though its valve is open;"
                f" allowed: put the load down, or draw it in"
            )
    return ""
