"""The bounds of an experiment, and whether the readings are within them.

| symbol | name | unit |
|---|---|---|
| low, high | joint angles between which an axis is driven | rad |
| peak | time for which a pressure may be beyond its bound | s |
| open | voltage beyond which a joint moves | V |

The programme turns an axis round at its soft limits (`experiment_plan`). These bounds lie behind them; beyond
one, the operator stops altogether. A pressure must be beyond its bound for a while: a closing valve makes a
peak, and closing it cures none.

Pure: `step` is called with every sample.
"""

import math
from typing import NamedTuple

from forest_description.derived.limits import joint_limits
from forest_description.machine import Machine
from forest_description.types import AXES, ZERO, Vec3
from forest_ident.experiments.excitation import Programme, Track
from forest_ident.experiments.experiment_plan import SWING_ROOM, Plan, cylinder_range

MARGIN = 0.05  # of a cylinder's stroke, at either end; soft limits are at thrice that
SWING_MARGIN = 0.1  # [rad] before the swing's ends
SWING_BEYOND = 0.4  # [rad] by which the swing may go beyond where it turns round
OVERLOAD = 1.5  # of the highest pressure that pump or relief valves allow
STARVED = 0.25  # of the pump's idle pressure: below, it is off
PEAK = 0.3  # [s]
OPENED = 1.0  # [V] beyond the overlap: there each joint moves at once
STILL = 0.3  # [s] for which an angle may be the same to the last bit then: valve and oil take 0.15 s; chosen
HOTTEST = 350.0  # [K]
DEGREES = 180.0 / math.pi


class Bounds(NamedTuple):
    """Ranges within which an experiment is driven."""

    driven: tuple[bool, bool, bool]  # axes; those of a rig have no joints
    low: Vec3
    high: Vec3
    pressure: float  # [Pa] at an actuator, at most
    supply: float  # [Pa] at least
    open: Vec3 = (math.inf, math.inf, math.inf)  # [V]
    temperature: float = HOTTEST  # [K] at most


class Readings(NamedTuple):
    """One sample; NaN: there is no such sensor."""

    angles: Vec3  # [rad]
    pressures: tuple[float, ...]  # [Pa] at the ports of actuators
    supply: float  # [Pa]
    temperature: float  # [K]


class State(NamedTuple):
    """Times for which pressures have been beyond their bounds, and angles the same [s]."""

    over: float = 0.0
    starved: float = 0.0
    still: Vec3 = (0.0, 0.0, 0.0)
    angles: Vec3 = (math.nan, math.nan, math.nan)  # [rad] the last ones


def bounds(plan: Plan, programme: Programme) -> Bounds:
    """Return the bounds of an experiment whose operator follows a programme."""
    m, joints = plan.machine, [track is not None and not plan.bench for track in programme.tracks]
    ranges = [_swing(m, programme.tracks[0]), *(cylinder_range(drive, MARGIN) for drive in m.drives[1:])]
    relief = m.port_valves.relief_pressure if m.port_valves is not None else 0.0
    return Bounds(
        driven=(joints[0], joints[1], joints[2]),
        low=(ranges[0][0], ranges[1][0], ranges[2][0]),
        high=(ranges[0][1], ranges[1][1], ranges[2][1]),
        pressure=OVERLOAD * max(m.pump.supply_pressure, relief),
        supply=STARVED * m.pump.idle_pressure,
        open=(_opened(m, 0), _opened(m, 1), _opened(m, 2)),
    )


def _opened(machine: Machine, axis: int) -> float:
    law = machine.valve_of(axis).law
    return OPENED + max(law.forward.deadband_voltage, law.backward.deadband_voltage)


def around(programme: Programme, plan: Plan, swing: float) -> Programme:
    """Return the programme with the swing going to and fro about its present angle [rad]."""
    track = programme.tracks[0]
    if track is None or plan.bench:
        return programme
    low, high = joint_limits(plan.machine)[0]
    room = max(low + SWING_MARGIN, swing - SWING_ROOM), min(high - SWING_MARGIN, swing + SWING_ROOM)
    moved = track._replace(low=room[0], high=room[1])
    return programme._replace(tracks=(moved, *programme.tracks[1:]))


def step(state: State, seen: Readings, b: Bounds, dt: float, volts: Vec3 = ZERO) -> tuple[State, str]:
    """Return the state after a period [s] under voltages [V], and why the experiment must stop, or ""."""
    over = state.over + dt if any(p > b.pressure for p in seen.pressures) else 0.0
    starved = state.starved + dt if seen.supply < b.supply else 0.0
    after = State(over, starved, _still(state, seen.angles, b, dt, volts), seen.angles)
    for name, still in zip(AXES, after.still, strict=True):
        if still > STILL:
            return (
                after,
                f"the {name} reads the same to the last bit though its valve is open: frozen, or stuck",
            )
    if reason := out_of_bounds(seen.angles, b):
        return after, reason
    if over > PEAK:
        highest = max(p for p in seen.pressures if p > b.pressure)
        return after, f"an actuator's pressure stays at {_mega(highest)}; allowed: up to {_mega(b.pressure)}"
    if starved > PEAK:
        return after, f"the supply pressure is {_mega(seen.supply)}; allowed: {_mega(b.supply)} or more"
    if seen.temperature > b.temperature:
        return after, f"the oil is at {seen.temperature:.1f} K; allowed: up to {b.temperature:g} K"
    return after, ""


def _still(state: State, angles: Vec3, b: Bounds, dt: float, volts: Vec3) -> Vec3:
    """Return for how long driven joints have read the same under open valves [s]."""
    swing, boom, stick = (
        before + dt if driven and angle == last and abs(volt) > opened else 0.0
        for before, driven, angle, last, volt, opened in zip(
            state.still, b.driven, angles, state.angles, volts, b.open, strict=True
        )
    )
    return swing, boom, stick


def out_of_bounds(angles: Vec3, b: Bounds) -> str:
    """Return which driven axis is not where it may be driven; "" if none."""
    for name, driven, angle, low, high in zip(AXES, b.driven, angles, b.low, b.high, strict=True):
        if driven and not low <= angle <= high:
            told = f"{DEGREES * low:.1f} .. {DEGREES * high:.1f} deg"
            return f"the {name} stands at {DEGREES * angle:.1f} deg; allowed in this experiment: {told}"
    return ""


def monitored_ports(plan: Plan) -> tuple[str, ...]:
    """Return the labels of the monitored actuator pressures: of the driven axes, else of the swing."""
    driven = [axis for axis, track in zip(AXES, plan.programme.tracks, strict=True) if track is not None]
    there = plan.machine.sensors.pressure is not None
    return tuple(f"{axis}_{port}_actuator" for axis in driven or AXES[:1] for port in (1, 2) if there)


def _swing(machine: Machine, track: Track | None) -> tuple[float, float]:
    low, high = joint_limits(machine)[0]
    if track is None:
        return low, high
    low, high = low + 0.5 * SWING_MARGIN, high - 0.5 * SWING_MARGIN
    return max(low, track.low - SWING_BEYOND), min(high, track.high + SWING_BEYOND)


def _mega(pressure: float) -> str:
    return f"{1e-6 * pressure:.2f} MPa"
