"""The core of the deadband-compensating valve driver: it alone knows how real valves differ from ideal ones.

An ideal valve has no lap, is linear, and always sees the nominal pressure drop: its command is an
actuator speed. A real valve opens only beyond its deadband, and its flow goes with the root of the
pressure drop that the load leaves:

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
spool needs time to cross its overlap: `beyond_valve` compensates these. With `adapt` deadband and
gain are those that `valve_adaptation` has estimated.
"""

import math
from typing import NamedTuple

from forest_control.valve.spool_model import left
from forest_control.valve.valve_adaptation import (
    NO_ESTIMATE,
    ValveEstimate,
    estimated_law,
    unmeasured,
    updated_estimate,
)
from forest_control.valve.valve_driver_parameters import (
    AxisDriver,
    Parameters,
    moved_spools,
)
from forest_control.valve.valve_flow import AxisMeasurement
from forest_control.valve.valve_hold import SHUT, HoldState, held_command
from forest_control.valve.valve_inverse import OilState, spool_voltage
from forest_description.hydraulics.valve_characteristic import ValveLaw
from forest_description.types import Vec3

ValveEstimates = tuple[ValveEstimate, ValveEstimate, ValveEstimate]
Holds = tuple[HoldState, HoldState, HoldState]

LOWEST_SUPPLY = 0.25  # [1] of the idle supply pressure: below, the pump is off or its transducer broken
HIGHEST = 1.5  # [1] of the nominal supply pressure: above, a transducer is broken; levers thrown give 1.26
APART = 0.5  # [1] of it between both ends of a swing's hose: beyond, one is broken; a push gives 0.3
FILLING = 60.0  # [rad/s] low-pass of the ports' mean pressure, 10 Hz; chosen, not measured
HOLD_COMMAND = 1e-6  # [V] below which the actuator is to be held: above the servo's `HOLD_RATE` as a voltage
LOWEST_PORT = 1e6  # [Pa] below tank: behind a long hose a port may read less than zero for a moment
SOONEST = 0.0025  # [s] between two commands at the least, whatever the stamps say: half a period
FORGOTTEN = 0.3  # [s] time constant with which a late voltage is forgotten; chosen, not measured
BORNE = 0.4  # [rad/s] low-pass of what the swing bears at rest: one that cycles at 2.8 Hz feigns none; chosen


class State(NamedTuple):
    """What the driver remembers of swing, boom, stick."""

    loads: Vec3  # low-passed [N m, N, N]
    primed: bool  # the first pressures have arrived
    means: Vec3 = (0.0, 0.0, 0.0)  # (P_1 + P_2 A_2/A_1)/2 [Pa], low-passed more quickly
    spools: Vec3 = (0.0, 0.0, 0.0)  # [V] where they should have been when the voltages were given
    strokes: Vec3 = (0.0, 0.0, 0.0)  # [V] where they were on average since the last step
    holds: Holds = (SHUT, SHUT, SHUT)
    voltages: Vec3 = (0.0, 0.0, 0.0)  # [V] given last, without dither
    saturated: tuple[bool, bool, bool] = (False, False, False)  # a valve could not open as far as commanded
    phase: float = 0.0  # of the dither, in turns; zero while all valves are shut: equal openings are alike
    estimates: ValveEstimates = (NO_ESTIMATE, NO_ESTIMATE, NO_ESTIMATE)
    ahead: float = 0.0  # [s] for how long a voltage may stay in force
    borne: float = 0.0  # swing's load, low-passed more slowly [N m]
    place: float = math.inf  # swing's position behind the same low-pass [rad]; infinite: not measured
    rocking: Vec3 = (0.0, 0.0, 0.0)  # load less its low-passed one [N m, N, N]


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


class AxisMemory(NamedTuple):
    """What `State` holds of one axis, and what is given to its valve."""

    hold: HoldState
    voltage: float
    saturated: bool


REST = State((0.0, 0.0, 0.0), False)
_NOTHING: Vec3 = (math.nan, math.nan, math.nan)  # [Pa; rad, m, m] of what was not measured
UNSEEN, STILL = Pressures(_NOTHING, _NOTHING, math.nan), Motion(_NOTHING, _NOTHING, _NOTHING)


def at_rest(state: State) -> State:
    """Return the state of a driver whose valves were centred without it; its estimates stay."""
    one, two, three = state.estimates
    return REST._replace(estimates=(unmeasured(one), unmeasured(two), unmeasured(three)), ahead=state.ahead)


def step(
    state: State, command: Vec3, pressures: Pressures, motion: Motion, p: Parameters, dt: float
) -> tuple[State, Vec3]:
    """Return the amplifier voltages [V] for commands [V] of ideal valves; zero for one that is no number.

    Args:
        state: what the last step returned; `REST` at first.
        command: actuator speeds, swing, boom, stick, as voltages of ideal valves [V].
        pressures: `UNSEEN` when no fresh measurement is there: the nominal drop is assumed, as it is
            for pressures that cannot be true.
        motion: `STILL` when no fresh measurement is there: nothing is adapted.
        p: machine and settings.
        dt: for how long the last voltages were in force [s], by the machine's time; 0 where these
            commands come so close behind others that those never took effect.
    """
    measured = plausible(pressures, p) and ends_agree(pressures, motion, p)
    state = _filter_loads(state, pressures, motion.positions[0], measured, p, dt)
    if dt > 0.0:
        state = _moved_on(state, p, dt)
    if p.adapt and dt > 0.0:
        state = state._replace(estimates=_learn(state, pressures, motion, measured, p, dt))
    supply, tank = pressures.supply if measured else p.idle_pressure, _tank_pressure(command, p)
    swing = _axis(0, command[0], supply, tank, measured, motion, state, p, dt)
    boom = _axis(1, command[1], supply, tank, measured, motion, state, p, dt)
    stick = _axis(2, command[2], supply, tank, measured, motion, state, p, dt)
    is_shut = swing.voltage == 0.0 and boom.voltage == 0.0 and stick.voltage == 0.0
    phase = 0.0 if is_shut else (state.phase + p.dither_frequency * dt) % 1.0
    after = state._replace(
        holds=(swing.hold, boom.hold, stick.hold),
        voltages=(swing.voltage, boom.voltage, stick.voltage),
        saturated=(swing.saturated, boom.saturated, stick.saturated),
        phase=phase,
    )
    wave = math.sin(2.0 * math.pi * phase)
    return after, (
        _dithered(swing.voltage, wave, p.axes[0]),
        _dithered(boom.voltage, wave, p.axes[1]),
        _dithered(stick.voltage, wave, p.axes[2]),
    )


def _moved_on(state: State, p: Parameters, dt: float) -> State:
    """Return the state with the spools where the last voltages have brought them in dt [s].

    After a voltage that was in force for longer than usual, the next ones may be, too: the longest
    time counts, and is forgotten with `FORGOTTEN`.
    """
    spools = moved_spools(state.spools, state.voltages, p.axes, dt)
    before = state.spools
    return state._replace(
        spools=spools,
        strokes=(
            0.5 * (before[0] + spools[0]),
            0.5 * (before[1] + spools[1]),
            0.5 * (before[2] + spools[2]),
        ),
        ahead=max(dt, dt + math.exp(-dt / FORGOTTEN) * (state.ahead - dt)),
    )


def _axis(
    i: int,
    command: float,
    supply: float,
    tank: float,
    measured: bool,
    motion: Motion,
    state: State,
    p: Parameters,
    dt: float,
) -> AxisMemory:
    """Return one axis a step on; supply and tank [Pa]; measured: the pressures are."""
    position = motion.positions[i]
    axis, hold, wanted, saturated = p.axes[i], state.holds[i], command, False
    low, high = -axis.valve.backward.rated_voltage, axis.valve.forward.rated_voltage
    if not math.isfinite(command):
        return AxisMemory(SHUT, 0.0, False)
    if p.compensate:
        hold, fed = _fed(i, command, position, state, p, dt)
        law = estimated_law(axis.valve, state.estimates[i]) if p.adapt else axis.valve
        mean = max(0.0, state.means[i]) if measured and axis.fills else -1.0
        wanted = 0.0
        if fed != 0.0:
            along = math.copysign(fed, hold.way)
            outlet = motion.valve_2[i] if along > 0.0 else motion.valve_1[i]
            oil = OilState(state.loads[i], state.rocking[i], mean, supply, tank, outlet)
            wanted = spool_voltage(along, oil, position, axis, law, p)
        if fed * hold.way < 0.0:
            wanted = _within_the_overlap(wanted, law)
        saturated = not low < wanted < high
        if p.beyond_valve:
            wanted = _over_the_overlap(wanted, state.spools[i], state.ahead, law, axis)
    return AxisMemory(hold, max(low, min(high, wanted)), saturated)


def _fed(
    i: int, command: float, position: float, state: State, p: Parameters, dt: float
) -> tuple[HoldState, float]:
    """Return the hold a step on, and the command [V] that passes, with what leaks.

    A leaking motor under load must be fed to stand still, by however small a command; zero is zero.
    While the swing is held what it bears at rest counts, as its weight on a slope, and not its rocking.
    """
    axis, held, scale = p.axes[i], abs(command) < HOLD_COMMAND, _leakage(p.axes[i])
    borne = scale * _borne_at_rest(state, position, axis) if i == 0 else 0.0
    leaked = borne if held else scale * state.loads[i] - _given_way(command, state.rocking[i], axis)
    fed, least = command + leaked if command != 0.0 else 0.0, axis.least_fed
    leaks = abs(borne) > _least_leakage(borne, state.spools[i], least)
    opens = min(least, p.hold_zone) if leaks else p.hold_zone
    side = math.copysign(1.0, borne) if leaks else 0.0
    return held_command(state.holds[i], fed, p.hold_zone, opens, side, p.command_noises[i], held, dt)


def _given_way(command: float, rocking: float, axis: AxisDriver) -> float:
    """Return the command [V] that a load takes off; never more than there is of it.

    Args:
        command: [V].
        rocking: load less what of it stays [N; N m].
        axis: whose `load_feedback` counts.
    """
    given = axis.valve.forward.rated_voltage * axis.load_feedback * rocking / axis.rated_speed
    return max(-abs(command), min(abs(command), given))


def _leakage(axis: AxisDriver) -> float:
    """Return the command that makes up for what leaks under a load [V per N m; N]."""
    return axis.valve.forward.rated_voltage * axis.slip / axis.rated_speed


def _borne_at_rest(state: State, position: float, axis: AxisDriver) -> float:
    """Return the swing's steady load [N m] without its friction: that goes when it rests.

    Else a valve that a wrong overlap opens too wide would keep itself open.
    """
    gone = position - state.place
    return state.borne - axis.damping * BORNE * gone if math.isfinite(gone) else state.borne


def _within_the_overlap(beyond: float, law: ValveLaw) -> float:
    """Return the voltage [V] as far from the edge inwards as one is beyond it; centred at the most."""
    edge = (law.forward if beyond > 0.0 else law.backward).deadband_voltage
    return math.copysign(max(0.0, 2.0 * edge - abs(beyond)), beyond)


def _over_the_overlap(wanted: float, spool: float, ahead: float, law: ValveLaw, axis: AxisDriver) -> float:
    """Return the voltage [V] that brings a spool from within the overlap to where it is wanted.

    A first-order spool needs some time constants to just beyond the overlap. With more voltage it is
    there in one period; in force for longer, that voltage would open the valve wide. Outside the
    overlap the command's lead makes up for the lag.
    """
    edge = (law.forward if wanted > 0.0 else law.backward).deadband_voltage
    if wanted == 0.0 or ahead == 0.0 or math.copysign(1.0, wanted) * spool >= edge:
        return wanted
    return spool + (wanted - spool) / (1.0 - left(axis.spool.lag, max(SOONEST, ahead)))


def _tank_pressure(command: Vec3, p: Parameters) -> float:
    """Return the pressure of the tank line [Pa] while all actuators move as commanded; 0 without a line."""
    flow = (
        _returned(command[0], p.axes[0]) + _returned(command[1], p.axes[1]) + _returned(command[2], p.axes[2])
    )
    return p.preload + p.return_resistance * flow * flow if math.isfinite(flow) else p.preload


def _returned(command: float, axis: AxisDriver) -> float:
    """Return what an actuator gives to the tank [m^3/s]."""
    speed = axis.rated_speed * command / axis.valve.forward.rated_voltage
    return speed * axis.displacement_2 if speed > 0.0 else -speed * axis.displacement_1


def _least_leakage(leaked: float, spool: float, least: float) -> float:
    """Return the leakage [V] from which it is fed; less where it is fed already, against chatter."""
    return least if spool * leaked <= 0.0 else 0.75 * least


def _dithered(voltage: float, wave: float, axis: AxisDriver) -> float:
    if voltage == 0.0:
        return 0.0
    added = voltage + axis.dither * wave
    return max(-axis.valve.backward.rated_voltage, min(axis.valve.forward.rated_voltage, added))


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


def _filter_loads(
    state: State, pressures: Pressures, position: float, measured: bool, p: Parameters, dt: float
) -> State:
    """Return the state with its loads and means a step on; position: of the swing [rad]."""
    if not measured:
        state = state._replace(loads=REST.loads, primed=False, means=REST.means, rocking=REST.rocking)
        return state._replace(borne=REST.borne, place=REST.place)
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
        rocking=(swing[2], boom[2], stick[2]),
        borne=state.borne + slow * (swing[0] - state.borne),
        place=_followed(state.place, position, slow),
    )


def _followed(before: float, position: float, weight: float) -> float:
    """Return the swing's low-passed position [rad]; infinite: not measured."""
    if not math.isfinite(position):
        return math.inf
    return before + weight * (position - before) if math.isfinite(before) else position


def _filtered(
    i: int, state: State, pressures: Pressures, axis: AxisDriver, weight: float, fast: float
) -> Vec3:
    """Return an axis' load and mean pressure behind their low-passes, and what the load is above its own."""
    one, two = pressures.port_1[i], pressures.port_2[i]
    load = axis.displacement_1 * one - axis.displacement_2 * two
    ratio = axis.displacement_2 / axis.displacement_1
    slow = state.loads[i] + weight * (load - state.loads[i])
    return slow, state.means[i] + fast * (0.5 * (one + two * ratio) - state.means[i]), load - slow


def _learn(
    state: State, pressures: Pressures, motion: Motion, measured: bool, p: Parameters, dt: float
) -> ValveEstimates:
    """Return the estimates after another period's measurements."""
    if not measured:
        one, two, three = state.estimates
        return unmeasured(one), unmeasured(two), unmeasured(three)
    return (
        _learn_axis(0, state, pressures, motion, p, dt),
        _learn_axis(1, state, pressures, motion, p, dt),
        _learn_axis(2, state, pressures, motion, p, dt),
    )


def _learn_axis(
    i: int, state: State, pressures: Pressures, motion: Motion, p: Parameters, dt: float
) -> ValveEstimate:
    sample = AxisMeasurement(
        position=motion.positions[i],
        valve_1=motion.valve_1[i],
        valve_2=motion.valve_2[i],
        port_1=pressures.port_1[i],
        port_2=pressures.port_2[i],
        supply=pressures.supply,
        spool=state.strokes[i],
    )
    if not math.isfinite(sample.position + sample.valve_1 + sample.valve_2):
        return unmeasured(state.estimates[i])
    return updated_estimate(state.estimates[i], sample, p.axes[i].valve, p.flows[i], p.adaptation, dt)
