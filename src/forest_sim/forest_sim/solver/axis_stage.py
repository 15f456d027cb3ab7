"""One axis within an implicit stage: both hoses solved exactly at a guessed joint rate.

The hoses feel each other through the actuator's cross leakage alone, which is small: it is taken to
first order. After Newton's last correction the hoses follow it to first order, too, so that no oil
is lost.
"""

from typing import NamedTuple

from forest_sim.hydraulics.actuator import actuator_force, inlet_flow, outlet_flow
from forest_sim.hydraulics.hydraulic_line import LineSolution, PortGuard, solve_line, with_outflow
from forest_sim.mechanics.end_stop import cushion_resistance, end_stop_resistance
from forest_sim.mechanics.friction import friction_slope
from forest_sim.mechanics.manipulator import Pair
from forest_sim.solver.plant import AxisState, Ports, Transmission, passive_force
from forest_sim.solver.plant_parameters import Axis


class AxisSolution(NamedTuple):
    """One axis of a stage at a guessed joint rate."""

    rate: float  # [rad/s]
    arm: float  # d(actuator position)/d(angle)
    one: LineSolution  # hose 1
    two: LineSolution  # hose 2, its flow counted from the valve
    torque: float  # on the joint [N m]
    resistance: float  # -d(torque)/d(rate) [N m s]


def solve_axis(
    base: AxisState,
    rate: float,
    t: Transmission,
    ports: Ports,
    supply: float,
    axis: Axis,
    guard: PortGuard,
    h: float,
) -> AxisSolution:
    """Solve both hoses of an axis at a guessed joint rate.

    The motor's small cross leakage is taken at the stage's known pressures, and its change after
    that to first order: it couples the hoses by a thousandth.
    """
    a = axis.actuator
    speed, p_1, p_2 = t.arm * rate, base.pressure_1, base.pressure_2
    # Each actuator flow without its own hose's pressure, which solve_line eliminates through the leakage.
    q_1, q_2 = inlet_flow(speed, 0.0, p_2, a), outlet_flow(speed, p_1, 0.0, a)
    one = solve_line(p_1, base.flow_1, q_1, a.leakage_11, ports.port_1, supply, axis.line_1, guard, h)
    two = solve_line(p_2, -base.flow_2, -q_2, a.leakage_22, ports.port_2, supply, axis.line_2, guard, h)
    if a.leakage_12 != 0.0:
        more_1, more_2 = -a.leakage_12 * (two.pressure - p_2), -a.leakage_12 * (one.pressure - p_1)
        one, two = _both_with_outflow(one, two, more_1, more_2, a.leakage_12)
    force = actuator_force(speed, one.pressure, two.pressure, a) + passive_force(t.position, speed, axis)
    return AxisSolution(
        rate=rate,
        arm=t.arm,
        one=one,
        two=two,
        torque=t.arm * force,
        resistance=t.arm * t.arm * _resistance(speed, t, one, two, axis, h),
    )


def _resistance(
    speed: float, t: Transmission, one: LineSolution, two: LineSolution, axis: Axis, h: float
) -> float:
    """Return -dF/du [N s/m; N m s/rad] of an actuator within a stage."""
    a = axis.actuator
    braking = a.quadratic_resistance + cushion_resistance(t.position, speed, axis.cushion)
    return (
        a.displacement_1 * a.displacement_1 * one.stiffness
        + a.displacement_2 * a.displacement_2 * two.stiffness
        + a.linear_resistance
        + 2.0 * braking * abs(speed)
        + friction_slope(speed, axis.friction)
        + end_stop_resistance(t.position, speed, axis.stop, h)
    )


def corrected_axis(
    base: AxisState,
    rate: float,
    solution: AxisSolution,
    feeds: Pair,
    supply_change: float,
    axis: Axis,
    h: float,
) -> AxisState:
    """Return an axis at the stage's end: the hoses follow Newton's last correction to first order.

    Without that the oil that this correction moves would be lost, step after step.

    Args:
        base: the stage's known part.
        rate: the joint's, corrected [rad/s].
        solution: the axis before the correction.
        feeds: d(flow into hose 1, 2)/dP_s [m^3/(s Pa)].
        supply_change: the correction of P_s [Pa].
        axis: its constants.
        h: the stage's implicit step [s].
    """
    a, moved = axis.actuator, solution.arm * (rate - solution.rate)
    q_1, q_2 = feeds[0] * supply_change, feeds[1] * supply_change
    p_1, p_2 = solution.one.slope * q_1, solution.two.slope * q_2
    more_1 = a.displacement_1 * moved - a.leakage_12 * p_2
    more_2 = -a.displacement_2 * moved - a.leakage_12 * p_1
    one, two = _both_with_outflow(solution.one, solution.two, more_1, more_2, a.leakage_12)
    return AxisState(
        base.angle + h * rate,
        rate,
        one.pressure + p_1,
        two.pressure + p_2,
        one.flow + q_1,
        -two.flow - q_2,
    )


def _both_with_outflow(
    one: LineSolution, two: LineSolution, flow_1: float, flow_2: float, leakage: float
) -> tuple[LineSolution, LineSolution]:
    """Return both hoses after the actuator takes more by small flows [m^3/s], as they leak into each other.

    dP_1 = -z_1 (dq_1 - g dP_2) and dP_2 = -z_2 (dq_2 - g dP_1), z their stiffness, g the cross
    leakage.
    """
    if leakage != 0.0:
        z_1, z_2 = leakage * one.stiffness, leakage * two.stiffness
        closing = 1.0 / (1.0 - z_1 * z_2)
        flow_1, flow_2 = (flow_1 + z_2 * flow_2) * closing, (flow_2 + z_1 * flow_1) * closing
    return with_outflow(one, flow_1), with_outflow(two, flow_2)
