"""What the transducers tell the driver of each actuator's load: pressures are checked, then low-passed.

| symbol | name | unit (cylinder; motor) |
|---|---|---|
| P_1, P_2 | pressure at the actuator's port 1, 2 | Pa |
| A_1, A_2 | displacement of port 1, 2 | m^2; m^3/rad |
| A_1 P_1 - A_2 P_2 | load | N; N m |
"""

import math
from typing import NamedTuple

from forest_control.valve.valve_driver_parameters import AxisDriver, Parameters
from forest_description.types import ZERO, Vec3

LOWEST_SUPPLY = 0.25  # [1] of the idle supply pressure: below, the pump is off or its transducer broken
HIGHEST = 1.5  # [1] of the nominal supply pressure: above, a transducer is broken; levers thrown give 1.26
APART = 0.5  # [1] of it between both ends of a swing's hose: beyond, one is broken; a push gives 0.3
FILLING = 60.0  # [rad/s] low-pass of the ports' mean pressure, 10 Hz; chosen, not measured
LOWEST_PORT = 1e6  # [Pa] below tank: behind a long hose a port may read less than zero for a moment
BORNE = 0.4  # [rad/s] low-pass of what the swing bears at rest: one that cycles at 2.8 Hz feigns none; chosen


class Pressures(NamedTuple):
    """Pressures by the transducers [Pa]: at both actuator ports of each axis, and at the pump."""

    port_1: Vec3
    port_2: Vec3
    supply: float


class Motion(NamedTuple):
    """Measurements for the adaptation: actuator positions [rad, m, m], pressures at the valves [Pa]."""

    positions: Vec3
    valve_1: Vec3
    valve_2: Vec3


class LoadEstimate(NamedTuple):
    """What swing, boom, stick bear."""

    loads: Vec3 = ZERO  # low-passed [N m, N, N]
    primed: bool = False  # the newest pressures are believed
    means: Vec3 = ZERO  # (P_1 + P_2 A_2/A_1)/2 [Pa], low-passed more quickly
    borne: float = 0.0  # swing's load, low-passed more slowly [N m]
    place: float = math.inf  # swing's position behind the same low-pass [rad]; infinite: not measured
    rocking: Vec3 = ZERO  # load less its low-passed one [N m, N, N]


UNMEASURED = LoadEstimate()
_NOTHING: Vec3 = (math.nan, math.nan, math.nan)  # [Pa; rad, m, m] of what was not measured
UNSEEN, STILL = Pressures(_NOTHING, _NOTHING, math.nan), Motion(_NOTHING, _NOTHING, _NOTHING)


def updated_load(
    before: LoadEstimate, pressures: Pressures, motion: Motion, p: Parameters, dt: float
) -> LoadEstimate:
    """Return the estimate dt [s] on; `UNMEASURED` by pressures that cannot be true. The first count whole."""
    if not plausible(pressures, p) or not ends_agree(pressures, motion, p):
        return UNMEASURED
    weight = 1.0 - math.exp(-p.load_bandwidth * dt) if before.primed else 1.0
    fast = 1.0 - math.exp(-FILLING * dt) if before.primed else 1.0
    slow = 1.0 - math.exp(-BORNE * dt) if before.primed else 1.0
    swing = _filtered(0, before, pressures, p.axes[0], weight, fast)
    boom = _filtered(1, before, pressures, p.axes[1], weight, fast)
    stick = _filtered(2, before, pressures, p.axes[2], weight, fast)
    return LoadEstimate(
        loads=(swing[0], boom[0], stick[0]),
        primed=True,
        means=(swing[1], boom[1], stick[1]),
        borne=before.borne + slow * (swing[0] - before.borne),
        place=_followed(before.place, motion.positions[0], slow),
        rocking=(swing[2], boom[2], stick[2]),
    )


def borne_at_rest(load: LoadEstimate, position: float, axis: AxisDriver) -> float:
    """Return the swing's steady load [N m] without its friction: that goes when it rests.

    Else a valve that a wrong overlap opens too wide would keep itself open.
    """
    gone = position - load.place
    return load.borne - axis.damping * BORNE * gone if math.isfinite(gone) else load.borne


def plausible(pressures: Pressures, p: Parameters) -> bool:
    """Tell whether transducers can be believed: a dead one must not open a valve wide."""
    low, high = LOWEST_SUPPLY * p.idle_pressure, HIGHEST * p.supply_pressure
    if not low <= pressures.supply <= high:
        return False
    for i in range(3):
        if not -LOWEST_PORT <= pressures.port_1[i] <= high or not -LOWEST_PORT <= pressures.port_2[i] <= high:
            return False
    return True


def ends_agree(pressures: Pressures, motion: Motion, p: Parameters) -> bool:
    """Tell whether the transducers at both ends of the swing's hoses agree, as far as there are two.

    By a swing that seems to bear what it does not, its valve would be opened while it should rest.
    """
    one, two = pressures.port_1[0] - motion.valve_1[0], pressures.port_2[0] - motion.valve_2[0]
    return not (abs(one) > APART * p.supply_pressure or abs(two) > APART * p.supply_pressure)


def _followed(before: float, position: float, weight: float) -> float:
    """Return the swing's low-passed position [rad]; infinite: not measured."""
    if not math.isfinite(position):
        return math.inf
    return before + weight * (position - before) if math.isfinite(before) else position


def _filtered(
    i: int, before: LoadEstimate, pressures: Pressures, axis: AxisDriver, weight: float, fast: float
) -> Vec3:
    """Return an axis' load and mean pressure behind their low-passes, and what the load is above its own."""
    one, two = pressures.port_1[i], pressures.port_2[i]
    load = axis.displacement_1 * one - axis.displacement_2 * two
    slow = before.loads[i] + weight * (load - before.loads[i])
    mean = 0.5 * (one + two * (axis.displacement_2 / axis.displacement_1))
    return slow, before.means[i] + fast * (mean - before.means[i]), load - slow
