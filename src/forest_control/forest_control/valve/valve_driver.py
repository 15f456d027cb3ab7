"""The core of the deadband-compensating valve driver: it alone knows how real valves differ from ideal ones.

An ideal valve has no lap, is linear, and always sees the nominal pressure drop: its command is an
actuator speed. A real valve opens only beyond its deadband, and its flow goes with the root of the
pressure drop that the load leaves:

| symbol | name | unit (cylinder; motor) |
|---|---|---|
| c, v | command of the ideal valve; the actuator speed it asks for | V; m/s, rad/s |
| A_1, A_2 | displacement of port 1, 2 | m^2; m^3/rad |
| F | load by the measured pressures, low-passed (`load_estimate`) | N; N m |
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

from forest_control.valve.load_estimate import (
    UNMEASURED,
    LoadEstimate,
    Motion,
    Pressures,
    borne_at_rest,
    updated_load,
)
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
from forest_description.types import ZERO, Vec3

ValveEstimates = tuple[ValveEstimate, ValveEstimate, ValveEstimate]
Holds = tuple[HoldState, HoldState, HoldState]

HOLD_COMMAND = 1e-6  # [V] below which the actuator is to be held: above the servo's `HOLD_RATE` as a voltage
SOONEST = 0.0025  # [s] between two commands at the least, whatever the stamps say: half a period
GONE = 2e6  # [Pa] of the supply, or half of what it keeps at idle, under which no pump runs; chosen
FELL = 0.7  # [1] of what a pump gave in a motion; 0.8 stops a sound c180 thrown at 1.5 m/s; chosen
UNFED = 0.048  # [s] without pressure at the pump, ten samples: a glitch stops nothing
FORGOTTEN = 0.3  # [s] time constant with which a late voltage is forgotten; chosen, not measured
STILL_LEAKS = 0.75  # [1] of `least_fed`, under which a leak that is fed is over: against chatter; chosen
NO_PUMP = (
    f"the supply is under {GONE * 1e-6:g} MPa, or half of its idle pressure, or {FELL:g} of what it was: "
    "no pump, or no transducer; the valves stay shut until nothing is commanded"
)


class State(NamedTuple):
    """What the driver remembers of swing, boom, stick."""

    load: LoadEstimate = UNMEASURED
    spools: Vec3 = (0.0, 0.0, 0.0)  # [V] where they should have been when the voltages were given
    strokes: Vec3 = (0.0, 0.0, 0.0)  # [V] where they were on average since the last step
    holds: Holds = (SHUT, SHUT, SHUT)
    voltages: Vec3 = (0.0, 0.0, 0.0)  # [V] given last, without dither
    saturated: tuple[bool, bool, bool] = (False, False, False)  # a valve could not open as far as commanded
    phase: float = 0.0  # of the dither, in turns; zero while all valves are shut: equal openings are alike
    estimates: ValveEstimates = (NO_ESTIMATE, NO_ESTIMATE, NO_ESTIMATE)
    ahead: float = 0.0  # [s] for how long a voltage may stay in force
    given: float = 0.0  # [Pa] most of the supply since nothing was commanded, up to its idle pressure
    unfed: float = 0.0  # [s] for which the pump has given nothing; from `UNFED` on the valves stay shut


class AxisMemory(NamedTuple):
    """What `State` holds of one axis, and what is given to its valve."""

    hold: HoldState
    voltage: float
    saturated: bool


REST = State()


def at_rest(state: State) -> State:
    """Return the state of a driver whose valves were centred without it; its estimates stay."""
    one, two, three = state.estimates
    estimates = unmeasured(one), unmeasured(two), unmeasured(three)
    return REST._replace(estimates=estimates, ahead=state.ahead, unfed=state.unfed)


def is_unfed(state: State) -> bool:
    """Tell whether the valves stay shut for want of a pump, until nothing is commanded.

    Behind open valves its return would throw the crane.
    """
    return state.unfed >= UNFED


def objection(state: State) -> str:
    """Return why the valves stay shut whatever is commanded, or ""."""
    return NO_PUMP if is_unfed(state) else ""


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
    state = state._replace(
        load=updated_load(state.load, pressures, motion, p, dt),
        given=_given(state.given, command, min(pressures.supply, p.idle_pressure)),
        unfed=_unfed(state, command, pressures.supply, p, dt),
    )
    if dt > 0.0:
        state = _moved_on(state, p, dt)
    if p.adapt and dt > 0.0:
        state = state._replace(estimates=_learn(state, pressures, motion, p, dt))
    command = ZERO if is_unfed(state) else command
    supply, tank = pressures.supply if state.load.primed else p.idle_pressure, _tank_pressure(command, p)
    swing = _axis(0, command[0], supply, tank, motion, state, p, dt)
    boom = _axis(1, command[1], supply, tank, motion, state, p, dt)
    stick = _axis(2, command[2], supply, tank, motion, state, p, dt)
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


def _given(before: float, command: Vec3, supply: float) -> float:
    """Return the most [Pa] that the pump has given since nothing was commanded."""
    if command == ZERO:
        return 0.0
    return max(before, supply)


def _unfed(before: State, command: Vec3, supply: float, p: Parameters, dt: float) -> float:
    """Return for how long the pump has given nothing [s], or gave nothing while this was commanded."""
    if supply < max(min(GONE, 0.5 * p.idle_pressure), FELL * before.given):
        return before.unfed + dt
    return before.unfed if is_unfed(before) and command != ZERO else 0.0


def _moved_on(state: State, p: Parameters, dt: float) -> State:
    """Return the state with the spools where the last voltages have brought them in dt [s].

    After a voltage that was in force for longer than usual, the next ones may be, too: the longest
    time counts, and is forgotten with `FORGOTTEN`.
    """
    spools = moved_spools(state.spools, state.voltages, p.axes, dt)
    return state._replace(
        spools=spools,
        strokes=(
            0.5 * (state.spools[0] + spools[0]),
            0.5 * (state.spools[1] + spools[1]),
            0.5 * (state.spools[2] + spools[2]),
        ),
        ahead=max(dt, dt + math.exp(-dt / FORGOTTEN) * (state.ahead - dt)),
    )


def _axis(
    i: int,
    command: float,
    supply: float,
    tank: float,
    motion: Motion,
    state: State,
    p: Parameters,
    dt: float,
) -> AxisMemory:
    """Return one axis a step on; supply and tank [Pa]."""
    position = motion.positions[i]
    axis, hold, wanted, saturated = p.axes[i], state.holds[i], command, False
    low, high = -axis.valve.backward.rated_voltage, axis.valve.forward.rated_voltage
    if not math.isfinite(command):
        return AxisMemory(SHUT, 0.0, False)
    if p.compensate:
        hold, fed = _fed(i, command, position, state, p, dt)
        law = estimated_law(axis.valve, state.estimates[i]) if p.adapt else axis.valve
        mean = max(0.0, state.load.means[i]) if state.load.primed and axis.fills else -1.0
        wanted = 0.0
        if fed != 0.0:
            along = math.copysign(fed, hold.way)
            outlet = motion.valve_2[i] if along > 0.0 else motion.valve_1[i]
            oil = OilState(state.load.loads[i], state.load.rocking[i], mean, supply, tank, outlet)
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
    axis, held = p.axes[i], abs(command) < HOLD_COMMAND
    scale = axis.valve.forward.rated_voltage * axis.slip / axis.rated_speed  # [V per N m] of load
    borne = scale * borne_at_rest(state.load, position, axis) if i == 0 else 0.0
    leaked = borne if held else scale * state.load.loads[i] - _given_way(command, state.load.rocking[i], axis)
    fed, least = command + leaked if command != 0.0 else 0.0, axis.least_fed
    leaks = abs(borne) > (least if state.spools[i] * borne <= 0.0 else STILL_LEAKS * least)
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


def _dithered(voltage: float, wave: float, axis: AxisDriver) -> float:
    if voltage == 0.0:
        return 0.0
    added = voltage + axis.dither * wave
    return max(-axis.valve.backward.rated_voltage, min(axis.valve.forward.rated_voltage, added))


def _learn(state: State, pressures: Pressures, motion: Motion, p: Parameters, dt: float) -> ValveEstimates:
    """Return the estimates after another period's measurements."""
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
    if not state.load.primed or not math.isfinite(sample.position + sample.valve_1 + sample.valve_2):
        return unmeasured(state.estimates[i])
    return updated_estimate(state.estimates[i], sample, p.axes[i].valve, p.flows[i], p.adaptation, dt)
