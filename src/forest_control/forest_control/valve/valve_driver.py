"""The deadband-compensating valve driver's core: it alone knows how a real valve differs from an ideal one.

An ideal valve has no lap, is linear, and always sees the nominal pressure drop; its command is a wished
actuator speed. The real one opens only beyond its deadband, and its flow goes with the root of the pressure
drop that the load leaves:

| symbol | name | unit (cylinder; motor) |
|---|---|---|
| c, v | command of the ideal valve; the actuator speed it asks for | V; m/s, rad/s |
| A_1, A_2 | displacement of port 1, 2 | m^2; m^3/rad |
| F | load: A_1 P_1 - A_2 P_2 from the measured pressures, low-passed | N; N m |
| N | pressure force left for the orifices: A_in P_s - sgn(v) F | N; N m |
| C_1, C_2 | the open valve's resistance in the direction of v, port 1's edge and port 2's | Pa s^2/m^6 |
| S | C_1 A_1^3 + C_2 A_2^3: both orifices' share, reduced to the actuator | N s^2/m^2; N m s^2 |

At steady speed and full opening N = S v^2 (`valve_inverse.required_opening`), hence the opening
|v| sqrt(S / N). Beyond the valve, hoses take part of N, a motor leaks, its hoses fill after a rest, and the
spool needs time to cross its overlap; `beyond_valve` allows for these. With `adapt` deadband and gain are
those that `valve_adaptation` has learnt.
"""

import math
from typing import NamedTuple

from forest_control.valve.valve_adaptation import UNLEARNT, Learner, blind, learn, learnt_law
from forest_control.valve.valve_driver_parameters import (
    AxisDriver,
    Parameters,
    Settings,
    axis_drivers,
    left,
    moved_spools,
    parameters,
)
from forest_control.valve.valve_flow import Sight
from forest_control.valve.valve_hold import CALM, SHUT, Hold, obeyed
from forest_control.valve.valve_inverse import required_opening, spool_voltage
from forest_description.types import Vec3

__all__ = [
    "REST",
    "AxisDriver",
    "Motion",
    "Parameters",
    "Pressures",
    "Settings",
    "State",
    "at_rest",
    "axis_drivers",
    "parameters",
    "plausible",
    "required_opening",
    "step",
]

Learners = tuple[Learner, Learner, Learner]
Holds = tuple[Hold, Hold, Hold]

LOWEST_SUPPLY = 0.25  # of the idle supply pressure: below, the pump is off or its transducer broken
HIGHEST = 2.0  # of the nominal supply pressure
FILLING = 60.0  # [rad/s] low-pass of the ports' mean pressure
HELD = 1e-6  # [V] a command below wishes that the actuator be held
LOWEST_PORT = 1e6  # [Pa] below tank: behind a long hose a port may read less than nothing for a moment
SOONEST = 0.0025  # [s] no command is expected sooner than this after another, whatever the stamps say
FORGOTTEN = 0.3  # [s] in which it is expected again that voltages come in time
BORNE = 1.5  # [rad/s] low-pass of the load that the swing has borne for long
LASTING = 2.0  # times that, at the most, its load may be, or that its load, to be fed while it is held


class State(NamedTuple):
    """What the driver remembers of swing, boom, stick."""

    loads: Vec3  # low-passed [N m, N, N]
    primed: bool  # the first pressures have arrived
    means: Vec3 = (0.0, 0.0, 0.0)  # [Pa] of both ports
    spools: Vec3 = (0.0, 0.0, 0.0)  # [V] where the spools should have been when the voltages were given
    strokes: Vec3 = (0.0, 0.0, 0.0)  # [V] where they were on average since the last step
    holds: Holds = (SHUT, SHUT, SHUT)
    voltages: Vec3 = (0.0, 0.0, 0.0)  # [V] given last, without dither
    saturated: tuple[bool, bool, bool] = (False, False, False)  # a valve could not open as far as wished
    phase: float = 0.0  # of the dither, in turns
    learners: Learners = (UNLEARNT, UNLEARNT, UNLEARNT)
    ahead: float = 0.0  # [s] for how long a voltage may stay in force
    borne: float = 0.0  # swing's load, low-passed more slowly [N m]


class Pressures(NamedTuple):
    """What the transducers say [Pa]: at both actuator ports of each axis, and at the pump."""

    port_1: Vec3
    port_2: Vec3
    supply: float


class Motion(NamedTuple):
    """What is measured for learning, too: actuator positions [rad, m, m], pressures at the valves [Pa]."""

    positions: Vec3
    valve_1: Vec3
    valve_2: Vec3


class AxisMemory(NamedTuple):
    """What `State` holds of one axis, and what is given to its valve."""

    hold: Hold
    voltage: float
    saturated: bool


REST = State((0.0, 0.0, 0.0), False)
_NOTHING: Vec3 = (math.nan, math.nan, math.nan)
UNSEEN, STILL = Pressures(_NOTHING, _NOTHING, math.nan), Motion(_NOTHING, _NOTHING, _NOTHING)


def at_rest(state: State) -> State:
    """Return the state of a driver whose valves were centred without it; what it has learnt stays."""
    one, two, three = state.learners
    return REST._replace(learners=(blind(one), blind(two), blind(three)), ahead=state.ahead)


def step(
    state: State,
    command: Vec3,
    pressures: Pressures | None,
    p: Parameters,
    dt: float,
    motion: Motion | None = None,
) -> tuple[State, Vec3]:
    """Return the amplifier voltages [V] for commands [V] of ideal valves; zero for one that is no number.

    Args:
        state: what the last step returned; `REST` at first.
        command: wished actuator speeds, swing, boom, stick, as voltages of ideal valves [V].
        pressures: None when no fresh measurement is there: the nominal drop is assumed, as it is for
            pressures that cannot be true.
        p: what the driver knows of the machine.
        dt: for how long the last voltages were in force [s], by the machine's time; 0 where these commands
            come so close behind others that those were never obeyed.
        motion: None when no fresh measurement is there: nothing is learnt.
    """
    seen = UNSEEN if pressures is None else pressures
    return step_seen(state, command, seen, STILL if motion is None else motion, p, dt)


def step_seen(
    state: State, command: Vec3, pressures: Pressures, motion: Motion, p: Parameters, dt: float
) -> tuple[State, Vec3]:
    """Do as `step`; what is not measured is NaN (`UNSEEN`, `STILL`), for a compiler knows no None."""
    seen = plausible(pressures, p)
    state = _filter_loads(state, pressures, seen, p, dt)
    if dt > 0.0:
        state = _moved_on(state, p, dt)
    if p.adapt and dt > 0.0:
        state = state._replace(learners=_learn(state, pressures, motion, seen, p, dt))
    supply, mean = p.idle_pressure, -1.0
    if seen:
        supply = pressures.supply
        mean = max(0.0, state.means[0]) if p.beyond_valve else -1.0
    swing = _axis(0, command[0], mean, supply, state, p, dt)
    boom = _axis(1, command[1], -1.0, supply, state, p, dt)
    stick = _axis(2, command[2], -1.0, supply, state, p, dt)
    phase = (state.phase + p.dither_frequency * dt) % 1.0
    after = state._replace(
        holds=(swing.hold, boom.hold, stick.hold),
        voltages=(swing.voltage, boom.voltage, stick.voltage),
        saturated=(swing.saturated, boom.saturated, stick.saturated),
        phase=phase,
    )
    dither = p.dither_amplitude * math.sin(2.0 * math.pi * phase)
    return after, (
        _dithered(swing.voltage, dither, p.axes[0]),
        _dithered(boom.voltage, dither, p.axes[1]),
        _dithered(stick.voltage, dither, p.axes[2]),
    )


def _moved_on(state: State, p: Parameters, dt: float) -> State:
    """Return the state with the spools where the last voltages have brought them in dt [s].

    A voltage that was in force for longer than usual lets expect that the next ones may be, too: the longest
    time, forgotten in `FORGOTTEN`.
    """
    before, after = state.spools, moved_spools(state.spools, state.voltages, p.axes, dt)
    return state._replace(
        spools=after,
        strokes=(0.5 * (before[0] + after[0]), 0.5 * (before[1] + after[1]), 0.5 * (before[2] + after[2])),
        ahead=max(dt, dt + math.exp(-dt / FORGOTTEN) * (state.ahead - dt)),
    )


def _axis(
    i: int, command: float, mean: float, supply: float, state: State, p: Parameters, dt: float
) -> AxisMemory:
    """Return one axis a step on; mean [Pa]: see `spool_voltage`."""
    axis, spool = p.axes[i], state.spools[i]
    rated = axis.valve.forward.rated_voltage
    if not math.isfinite(command):
        return AxisMemory(SHUT, 0.0, False)
    low = axis.valve.backward.rated_voltage
    hold, wanted, saturated = state.holds[i], command, False
    if p.compensate:
        # A leaking motor under load must be fed to stand still, be the command ever so small; none is none.
        # While the swing is held its weight on a slope counts, not how it was stopped, nor how it rocks.
        load = _weight(state.loads[0], state.borne) if i == 0 and abs(command) < HELD else state.loads[i]
        leaked = rated * axis.slip * load / axis.rated_speed
        fed = command + leaked if command != 0.0 else 0.0
        least = axis.least_fed
        opens = p.hold_zone if abs(leaked) <= _worth(leaked, spool, least) else min(least, p.hold_zone)
        hold, fed = obeyed(
            hold, fed, p.hold_zone, opens, p.command_noises[i], abs(command) < HELD, p.adapt, dt
        )
        law = learnt_law(axis.valve, state.learners[i]) if p.adapt else axis.valve
        wanted = spool_voltage(fed, state.loads[i], mean, supply, axis, law, p) if fed != 0.0 else 0.0
        saturated = not -low < wanted < rated
        edge = (law.forward if wanted > 0.0 else law.backward).deadband_voltage
        gently = hold.calm_for >= CALM and hold.wide > 2.0
        crosses = p.beyond_valve and wanted != 0.0 and state.ahead > 0.0 and not gently
        if crosses and math.copysign(1.0, wanted) * spool < edge:
            # A first-order spool comes to just beyond the overlap only after some time constants; asked for
            # more, it is there in one period; in force for longer, that would throw the valve wide open.
            # Outside the overlap the command's lead makes up for the lag; at rest there is time.
            wanted = spool + (wanted - spool) / (1.0 - left(axis, max(SOONEST, state.ahead)))
    most = p.slew_limit * dt if dt > 0.0 or p.slew_limit < math.inf else math.inf  # not inf * 0
    slewed = max(state.voltages[i] - most, min(state.voltages[i] + most, wanted))
    voltage = max(-low, min(rated, slewed))
    return AxisMemory(hold, voltage, saturated)


def _weight(load: float, borne: float) -> float:
    """Return a load [N m] that has been borne for long, within `LASTING`; none that comes and goes."""
    return load if load * borne > 0.0 and 1.0 / LASTING < load / borne < LASTING else 0.0


def _worth(leaked: float, spool: float, least: float) -> float:
    """Return what must leak [V] to be fed; 3/4 of it keep a valve open, so that it does not chatter."""
    return least if spool * leaked <= 0.0 else 0.75 * least


def _dithered(voltage: float, dither: float, axis: AxisDriver) -> float:
    if voltage == 0.0:
        return 0.0
    return max(-axis.valve.backward.rated_voltage, min(axis.valve.forward.rated_voltage, voltage + dither))


def plausible(pressures: Pressures, p: Parameters) -> bool:
    """Tell whether transducers can be believed: a dead one must not open a valve wide."""
    low, high = LOWEST_SUPPLY * p.idle_pressure, HIGHEST * p.supply_pressure
    if not low <= pressures.supply <= high:
        return False
    for i in range(3):
        if not -LOWEST_PORT <= pressures.port_1[i] <= high or not -LOWEST_PORT <= pressures.port_2[i] <= high:
            return False
    return True


def _filter_loads(state: State, pressures: Pressures, seen: bool, p: Parameters, dt: float) -> State:
    if not seen:
        return state._replace(loads=REST.loads, primed=False, means=REST.means, borne=REST.borne)
    weight = 1.0 - math.exp(-p.load_bandwidth * dt) if state.primed else 1.0
    fast = 1.0 - math.exp(-FILLING * dt) if state.primed else 1.0
    slow = 1.0 - math.exp(-BORNE * dt) if state.primed else 1.0
    swing = _filtered(0, state, pressures, p.axes[0], weight, fast)
    boom = _filtered(1, state, pressures, p.axes[1], weight, fast)
    stick = _filtered(2, state, pressures, p.axes[2], weight, fast)
    return state._replace(
        loads=(swing[0], boom[0], stick[0]),
        primed=True,
        means=(swing[1], boom[1], stick[1]),
        borne=state.borne + slow * (swing[0] - state.borne),
    )


def _filtered(
    i: int, state: State, pressures: Pressures, axis: AxisDriver, weight: float, fast: float
) -> tuple[float, float]:
    """Return an axis' load and mean pressure behind their low-passes."""
    one, two = pressures.port_1[i], pressures.port_2[i]
    load = axis.displacement_1 * one - axis.displacement_2 * two
    return (
        state.loads[i] + weight * (load - state.loads[i]),
        state.means[i] + fast * (0.5 * (one + two) - state.means[i]),
    )


def _learn(
    state: State, pressures: Pressures, motion: Motion, seen: bool, p: Parameters, dt: float
) -> Learners:
    """Return what is known of the valves after another period's measurements."""
    if not seen:
        one, two, three = state.learners
        return blind(one), blind(two), blind(three)
    return (
        _learn_axis(0, state, pressures, motion, p, dt),
        _learn_axis(1, state, pressures, motion, p, dt),
        _learn_axis(2, state, pressures, motion, p, dt),
    )


def _learn_axis(
    i: int, state: State, pressures: Pressures, motion: Motion, p: Parameters, dt: float
) -> Learner:
    seen = Sight(
        position=motion.positions[i],
        valve_1=motion.valve_1[i],
        valve_2=motion.valve_2[i],
        port_1=pressures.port_1[i],
        port_2=pressures.port_2[i],
        supply=pressures.supply,
        spool=state.strokes[i],
    )
    if not math.isfinite(seen.position + seen.valve_1 + seen.valve_2):
        return blind(state.learners[i])
    return learn(state.learners[i], seen, p.axes[i].valve, p.flows[i], p.adaptation, dt)
