"""One hydraulic actuator that carries a flexible arm with a hanging load, driven by its valve signal alone.

    signal --dead time, lag--> spool --deadbands--> edges --hoses--> chambers --> piston --> arm --> load
                                                  ^ load-sensing pump, which lags behind the load

| symbol | name | unit |
|---|---|---|
| s, u | spool position; valve signal after the dead time | V |
| P_1, P_2 | pressures in the chambers, 1 extends | P |
| P_s | supply pressure | P |
| Q_1, Q_2 | flow into chamber 1, out of chamber 2 | X/n |
| x, v | piston's position and speed | X, X/n |
| y, w; z, r | the arm's and the load's | X, X/n |
| a | area of chamber 2 over that of chamber 1 | 1 |
| C_1, C_2 | capacitance of chamber with its hose | X/P |

A record of unknown scales is in its own units: V of the signal, P of pressure, X of position, n the
time between two samples. Areas are shares of chamber 1's, so that a flow is a speed, a force a pressure and a
mass P n^2/X. Pressures count from the tank. Positive: s opens chamber 1 to the pump; x grows as 1 fills.

    ds/dt = (u - s)/T_v
    dP_1/dt = (Q_1 - v)/C_1,   dP_2/dt = (a v - Q_2)/C_2            (forest_sim…hydraulic_line.pressure_rate)
    M dv/dt = P_1 - a P_2 - F_0 - b v - F(v) - k_a (x - y) - c_a (v - w)
    M_a dw/dt = k_a (x - y) + c_a (v - w) - k_l (y - z) - c_l (w - r)
    M_l dr/dt = k_l (y - z) + c_l (w - r)
    T_p dP_s/dt = P_load + margin - P_s                           (forest_sim…supply.reference_rate)

F_0 holds the arm at rest. Edges pass k o sqrt(drop) at an opening o, up to the flow that a direction's
compensator lets through; a load check lets nothing back to the pump. The sensor sits upstream of the hose.

Everything here is in the subset that `forest_compile.frontend` turns into machine code.
"""

import math
from typing import NamedTuple

from forest_description.hydraulics.hose import Line
from forest_sim.hydraulics.hydraulic_line import PortGuard, pressure_rate
from forest_sim.hydraulics.supply import Supply, reference_rate
from forest_sim.mechanics.friction import Friction, friction_force

SMOOTH_DROP = 0.03  # [P] drop under which an edge's root is made straight
SMOOTH_SPEED = 0.0015  # [X/n] speed under which friction's sign is smoothed
CHECK_CONDUCTANCE = 0.05  # [X/(n P)] of the anti-cavitation valves


class Parameters(NamedTuple):
    """What is fitted, dead time aside; units as in the module's table."""

    spool_lag: float  # T_v [n]
    deadband_extend: float  # [V]
    deadband_retract: float  # [V]
    meter_in_extend: float  # edge's conductance k [X/(n V sqrt(P))]: pump to 1
    meter_in_retract: float  # pump to 2
    meter_out_extend: float  # 2 to tank
    meter_out_retract: float  # 1 to tank
    flow_limit_extend: float  # [X/n]
    flow_limit_retract: float  # [X/n]
    pump_lag: float  # T_p [n]
    pump_margin: float  # [P]
    rest_pressure_1: float  # [P]
    rest_pressure_2: float  # [P]
    area_ratio: float  # a
    capacitance_1: float  # C_1 [X/P]
    capacitance_2: float  # C_2 [X/P]
    capacitance_slope: float  # relative change of C_1 (and, negative, of C_2) with x [1/X]
    hose_resistance: float  # R in R Q|Q| between sensor and chamber [P n^2/X^2]
    mass: float  # M [P n^2/X]
    damping: float  # b [P n/X]
    friction_extend: float  # F [P]
    friction_retract: float  # F [P]
    gravity_slope: float  # change of F_0 with x [P/X]
    arm_stiffness: float  # k_a [P/X]
    arm_damping: float  # c_a [P n/X]
    arm_mass: float  # M_a [P n^2/X]
    load_stiffness: float  # k_l [P/X]
    load_damping: float  # c_l [P n/X]
    load_mass: float  # M_l [P n^2/X]
    sensed_share: float  # of chamber 2's pressure that the sensor takes off


class State(NamedTuple):
    """Where the actuator is; also holds time derivatives [1/n]."""

    spool: float  # s
    supply: float  # P_s
    pressure_1: float
    pressure_2: float
    position: float
    speed: float
    arm_position: float
    arm_speed: float
    load_position: float
    load_speed: float


class Flows(NamedTuple):
    """Through the valve, into chamber 1 and out of chamber 2 [X/n], and the pressure the pump senses [P]."""

    into_1: float
    out_of_2: float
    sensed: float


def at_rest(p: Parameters) -> State:
    """Return the state in which nothing moves and the valve is shut; positions count from there."""
    return State(
        spool=0.0,
        supply=p.pump_margin,
        pressure_1=p.rest_pressure_1,
        pressure_2=p.rest_pressure_2,
        position=0.0,
        speed=0.0,
        arm_position=0.0,
        arm_speed=0.0,
        load_position=0.0,
        load_speed=0.0,
    )


def edge(conductance: float, drop: float) -> float:
    """Return Q [X/n] = k dP/(dP^2 + e^2)^(1/4), which is k sgn(dP) sqrt|dP| off zero.

    Thesis eq. 3.1. Differs: made smooth through zero drop, where the plant's implicit stage solves for the
    true root; here a fit asks for a hundred thousand simulations and for their derivatives.
    """
    return conductance * drop / math.sqrt(math.sqrt(drop * drop + SMOOTH_DROP * SMOOTH_DROP))


def limited(flow: float, limit: float) -> float:
    """Return a flow [X/n] that bends into its compensator's limit: Q/(1 + (Q/Q_max)^8)^(1/8)."""
    ratio = flow / limit
    square = ratio * ratio * ratio * ratio
    return flow / math.sqrt(math.sqrt(math.sqrt(1.0 + square * square)))


def valve_flows(state: State, p: Parameters) -> Flows:
    """Return what passes the edges. Thesis eq. 4.1."""
    opening = state.spool - p.deadband_extend
    if opening > 0.0:
        filling = edge(p.meter_in_extend * opening, max(0.0, state.supply - state.pressure_1))
        leaving = edge(p.meter_out_extend * opening, state.pressure_2)
        return Flows(limited(filling, p.flow_limit_extend), leaving, state.pressure_1)
    opening = -state.spool - p.deadband_retract
    if opening > 0.0:
        filling = edge(p.meter_in_retract * opening, max(0.0, state.supply - state.pressure_2))
        leaving = edge(p.meter_out_retract * opening, state.pressure_1)
        return Flows(-limited(leaving, p.flow_limit_retract), -filling, state.pressure_2)
    return Flows(0.0, 0.0, 0.0)


def rate(state: State, signal: float, p: Parameters) -> State:
    """Return the state's time derivative [1/n] under a signal [V]; the module's head has the equations."""
    q = valve_flows(state, p)
    guard = PortGuard(math.inf, 0.0, 0.0, CHECK_CONDUCTANCE)
    chamber_1 = Line(0.0, 0.0, p.capacitance_1 * (1.0 + p.capacitance_slope * state.position))
    chamber_2 = Line(0.0, 0.0, p.capacitance_2 * (1.0 - p.capacitance_slope * state.position))
    coulomb = p.friction_extend if state.speed > 0.0 else p.friction_retract
    friction = friction_force(state.speed, Friction(coulomb, coulomb, 1.0, SMOOTH_SPEED))
    arm = p.arm_stiffness * (state.position - state.arm_position)
    arm += p.arm_damping * (state.speed - state.arm_speed)
    load = p.load_stiffness * (state.arm_position - state.load_position)
    load += p.load_damping * (state.arm_speed - state.load_speed)
    held = p.rest_pressure_1 - p.area_ratio * p.rest_pressure_2 + p.gravity_slope * state.position
    driving = state.pressure_1 - p.area_ratio * state.pressure_2 - held
    return State(
        spool=(signal - state.spool) / p.spool_lag,
        supply=reference_rate(state.supply, q.sensed, _load_sensing(p)),
        pressure_1=pressure_rate(state.pressure_1, q.into_1, state.speed, chamber_1, guard),
        pressure_2=pressure_rate(
            state.pressure_2, -q.out_of_2, -p.area_ratio * state.speed, chamber_2, guard
        ),
        position=state.speed,
        speed=(driving - p.damping * state.speed - friction - arm) / p.mass,
        arm_position=state.arm_speed,
        arm_speed=(arm - load) / p.arm_mass,
        load_position=state.load_speed,
        load_speed=load / p.load_mass,
    )


def _load_sensing(p: Parameters) -> Supply:
    """Return the supply of which only the control is of use: its reference follows the sensed pressure."""
    return Supply(
        ideal=0,
        set_pressure=math.inf,
        flow_limit=0.0,
        power_limit=0.0,
        efficiency=0.0,
        compensation=0.0,
        leakage=0.0,
        capacitance=0.0,
        relief_pressure=0.0,
        relief_conductance=0.0,
        margin=p.pump_margin,
        rate=1.0 / p.pump_lag,
    )


def sensed_pressure(state: State, p: Parameters) -> float:
    """Return what the sensor reads [P], zero at rest: upstream of the hose's turbulent resistance.

    Thesis eq. 4.4.
    """
    q = valve_flows(state, p)
    one = state.pressure_1 - p.rest_pressure_1 + p.hose_resistance * q.into_1 * abs(q.into_1)
    two = state.pressure_2 - p.rest_pressure_2 - p.hose_resistance * q.out_of_2 * abs(q.out_of_2)
    return one - p.sensed_share * two
