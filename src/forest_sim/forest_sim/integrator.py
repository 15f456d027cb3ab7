"""One time step of the plant, through shut valves and water hammer alike.

An L-stable, stiffly accurate, two-stage SDIRK of order 2 (gamma = 1 - 1/sqrt 2): each stage solves Y = y +
step f(Y) for the f of `plant.state_derivative`. The stiffness comes from the orifices (C_R = inf inside the
overlap) and the hoses, so each stage eliminates flows and pressures exactly (`line.solve_line`) and is left
with three joint rates, found by Newton. A stage's derivative is read off its increment, (Y - y)/step, never
from f: f has no value when an orifice shuts on a flow.

The step assumes that commands stand still over it. The spool's lag is linear and is advanced exactly.
"""

import math
from typing import NamedTuple

from forest_sim.actuator import actuator_force, inlet_flow, outlet_flow
from forest_sim.end_stop import end_stop_force, end_stop_resistance
from forest_sim.line import LineSolution, PortGuard, solve_line
from forest_sim.manipulator import dynamics
from forest_sim.parameters import Axis, PlantParameters
from forest_sim.plant import AxisState, PlantState, Ports, Transmission, transmissions, valve_ports

GAMMA = 1.0 - math.sqrt(0.5)
TOLERANCE = 1e-10  # [rad/s] last Newton correction; the correction after it would be a thousand times smaller
ITERATIONS = 30

Triple = tuple[float, float, float]


class Simulation(NamedTuple):
    """The plant between two steps."""

    plant: PlantState
    spools: Triple  # [V] swing, boom, stick


class AxisSolution(NamedTuple):
    """One axis of a stage at a guessed joint rate."""

    pressure_1: float
    pressure_2: float
    flow_1: float
    flow_2: float
    torque: float  # on the joint [N m]
    resistance: float  # -d(torque)/d(rate) [N m s]


def step(simulation: Simulation, voltages: Triple, h: float, p: PlantParameters) -> Simulation:
    """Advance the machine by h [s] with the valve voltages [V] held; spools end at the rated one."""
    plant = simulation.plant
    r = p.valve.rated_voltage
    targets = _clip(voltages[0], r), _clip(voltages[1], r), _clip(voltages[2], r)
    middle = spools_after(simulation.spools, targets, GAMMA * h, p.spool_rate)
    first = _solve_stage(plant, plant, _ports(middle, p), GAMMA * h, p)
    # y + (1 - gamma) h k_1, with k_1 = (Y_1 - y) / (gamma h)
    base = _blend(plant, first, (1.0 - GAMMA) / GAMMA)
    end = spools_after(simulation.spools, targets, h, p.spool_rate)
    return Simulation(_solve_stage(base, first, _ports(end, p), GAMMA * h, p), end)


def advance(simulation: Simulation, voltages: Triple, h: float, count: int, p: PlantParameters) -> Simulation:
    """Advance the machine by `count` steps of h [s] with the valve voltages [V] held."""
    for _ in range(count):
        simulation = step(simulation, voltages, h, p)
    return simulation


def _clip(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))


def spools_after(spools: Triple, voltages: Triple, time: float, rate: float) -> Triple:
    """Return the spool positions [V] after a time [s] of first-order lag towards held voltages.

    Thesis section 3.2.2. Differs: the thesis takes the spool to follow at once; so does a rate of inf.
    """
    rest = math.exp(-rate * time)
    return (
        voltages[0] + (spools[0] - voltages[0]) * rest,
        voltages[1] + (spools[1] - voltages[1]) * rest,
        voltages[2] + (spools[2] - voltages[2]) * rest,
    )


def _ports(spools: Triple, p: PlantParameters) -> tuple[Ports, Ports, Ports]:
    return (
        valve_ports(spools[0], p.supply_pressure, p.valve),
        valve_ports(spools[1], p.supply_pressure, p.valve),
        valve_ports(spools[2], p.supply_pressure, p.valve),
    )


def _blend(start: PlantState, stage: PlantState, weight: float) -> PlantState:
    """Return start + weight (stage - start)."""
    return PlantState(
        _blend_axis(start.swing, stage.swing, weight),
        _blend_axis(start.boom, stage.boom, weight),
        _blend_axis(start.stick, stage.stick, weight),
    )


def _blend_axis(a: AxisState, b: AxisState, w: float) -> AxisState:
    return AxisState(
        a.angle + w * (b.angle - a.angle),
        a.rate + w * (b.rate - a.rate),
        a.pressure_1 + w * (b.pressure_1 - a.pressure_1),
        a.pressure_2 + w * (b.pressure_2 - a.pressure_2),
        a.flow_1 + w * (b.flow_1 - a.flow_1),
        a.flow_2 + w * (b.flow_2 - a.flow_2),
    )


def _solve_stage(
    base: PlantState, guess: PlantState, ports: tuple[Ports, Ports, Ports], h: float, p: PlantParameters
) -> PlantState:
    """Return Y with Y = base + h f(Y). Newton in the three joint rates; the hoses are solved inside.

    Its matrix leaves out what the configuration's change contributes (of order h), so that it converges by
    about three decimal places an iteration.
    """
    u_1, u_2, u_3 = guess.swing.rate, guess.boom.rate, guess.stick.rate
    cross = guess.swing.pressure_1, guess.swing.pressure_2
    axis_1 = axis_2 = axis_3 = AxisSolution(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for _ in range(ITERATIONS):
        angles = base.swing.angle + h * u_1, base.boom.angle + h * u_2, base.stick.angle + h * u_3
        t_1, t_2, t_3 = transmissions(angles[0], angles[1], angles[2], p)
        axis_1 = _solve_axis(base.swing, u_1, t_1, ports[0], cross, p.swing, p.guard, h)
        axis_2 = _solve_axis(base.boom, u_2, t_2, ports[1], (0.0, 0.0), p.boom, p.guard, h)
        axis_3 = _solve_axis(base.stick, u_3, t_3, ports[2], (0.0, 0.0), p.stick, p.guard, h)
        cross = axis_1.pressure_1, axis_1.pressure_2
        d = dynamics(angles, (u_1, u_2, u_3), p.body)
        e_1, e_2, e_3 = u_1 - base.swing.rate, u_2 - base.boom.rate, u_3 - base.stick.rate
        r_1 = d.m_11 * e_1 + h * (d.bias[0] - axis_1.torque)
        r_2 = d.m_22 * e_2 + d.m_23 * e_3 + h * (d.bias[1] - axis_2.torque)
        r_3 = d.m_23 * e_2 + d.m_33 * e_3 + h * (d.bias[2] - axis_3.torque)
        n_22, n_33 = d.m_22 + h * axis_2.resistance, d.m_33 + h * axis_3.resistance
        determinant = n_22 * n_33 - d.m_23 * d.m_23
        c_1 = r_1 / (d.m_11 + h * axis_1.resistance)
        c_2 = (n_33 * r_2 - d.m_23 * r_3) / determinant
        c_3 = (n_22 * r_3 - d.m_23 * r_2) / determinant
        u_1, u_2, u_3 = u_1 - c_1, u_2 - c_2, u_3 - c_3
        if max(abs(c_1), abs(c_2), abs(c_3)) < TOLERANCE:
            break
    return PlantState(
        _assemble(base.swing, u_1, axis_1, h),
        _assemble(base.boom, u_2, axis_2, h),
        _assemble(base.stick, u_3, axis_3, h),
    )


def _assemble(base: AxisState, rate: float, solution: AxisSolution, h: float) -> AxisState:
    return AxisState(
        base.angle + h * rate,
        rate,
        solution.pressure_1,
        solution.pressure_2,
        solution.flow_1,
        solution.flow_2,
    )


def _solve_axis(
    base: AxisState,
    rate: float,
    t: Transmission,
    ports: Ports,
    cross: tuple[float, float],
    axis: Axis,
    guard: PortGuard,
    h: float,
) -> AxisSolution:
    """Solve both hoses of an axis at a guessed joint rate.

    The motor's small cross leakage takes the other hose's pressure from the last iteration (`cross`); it
    couples them by a thousandth, so that it converges along with Newton.
    """
    a = axis.actuator
    speed = t.arm * rate
    # Each actuator flow without its own hose's pressure, which solve_line eliminates through the leakage.
    q_1, q_2 = inlet_flow(speed, 0.0, cross[1], a), outlet_flow(speed, cross[0], 0.0, a)
    one = solve_line(base.pressure_1, base.flow_1, q_1, a.leakage_11, ports.orifice_1, axis.line_1, guard, h)
    two = solve_line(
        base.pressure_2, -base.flow_2, -q_2, a.leakage_22, ports.orifice_2, axis.line_2, guard, h
    )
    force = actuator_force(speed, one.pressure, two.pressure, a)
    force += end_stop_force(t.position, speed, axis.stop)
    return AxisSolution(
        pressure_1=one.pressure,
        pressure_2=two.pressure,
        flow_1=one.flow,
        flow_2=-two.flow,
        torque=t.arm * force,
        resistance=t.arm * t.arm * _resistance(speed, t, one, two, axis, h),
    )


def _resistance(
    speed: float, t: Transmission, one: LineSolution, two: LineSolution, axis: Axis, h: float
) -> float:
    """Return -dF/du [N s/m; N m s/rad] of an actuator within a stage."""
    a = axis.actuator
    return (
        a.displacement_1 * a.displacement_1 * one.stiffness
        + a.displacement_2 * a.displacement_2 * two.stiffness
        + a.linear_resistance
        + 2.0 * a.quadratic_resistance * abs(speed)
        + end_stop_resistance(t.position, speed, axis.stop, h)
    )
