"""One axis within an implicit stage: both hoses solved exactly at a guessed joint rate.

The hoses feel each other through the actuator's cross leakage alone, which is small: it is taken to
first order. After Newton's last correction the hoses follow it to first order, too, so that no oil
is lost.
"""

from typing import NamedTuple

from forest_description.hydraulics.hose import Line
from forest_sim.equations.plant import AxisState, Transmission, passive_force
from forest_sim.equations.plant_parameters import Axis
from forest_sim.equations.valve_ports import Ports
from forest_sim.hydraulics.actuator import actuator_force, inlet_flow, outlet_flow
from forest_sim.hydraulics.hydraulic_line import LineSolution, PortGuard, solve_line, with_outflow
from forest_sim.hydraulics.load_holding import Restriction, restriction
from forest_sim.hydraulics.oil_law import held_above_vapour, is_near
from forest_sim.hydraulics.oil_volume import StageHose, filled_share, stage_hose
from forest_sim.mechanics.end_stop import cushion_resistance, end_stop_resistance
from forest_sim.mechanics.friction import Rubbing, rubbing
from forest_sim.mechanics.manipulator import Pair
from forest_sim.stage.holding_stage import first_flow, held_hose, next_flow


class AxisEnd(NamedTuple):
    """One axis at a stage's end."""

    state: AxisState  # where there are chambers, with pressures along the tangent of the oil's law
    contents: AxisState  # where there are chambers, with their oil in place of pressures


TANGENTS = 30  # to the oil's law that a stage tries
STEADY = 1e-3  # of the oil that a motor takes, by which it may still change


class AxisSolution(NamedTuple):
    """One axis of a stage at a guessed joint rate."""

    rate: float  # [rad/s]
    arm: float  # d(actuator position)/d(angle)
    one: LineSolution  # hose 1
    two: LineSolution  # hose 2, its flow counted from the valve
    torque: float  # on the joint [N m]
    resistance: float  # -d(torque)/d(rate) [N m s]
    known: Pair  # pressures of both sides before the stage's flows [Pa]
    swept: Pair  # oil that port 1 takes and port 2 gives per actuator speed [m^2; m^3/rad]
    lines: tuple[Line, Line]  # as the stage took them: with the chambers' capacitance, the hoses' resistance
    friction: Rubbing  # which torque and resistance have in them


def solve_axis(
    base: AxisState,
    near: AxisState,
    rate: float,
    t: Transmission,
    ports: Ports,
    supply: float,
    axis: Axis,
    guard: PortGuard,
    h: float,
) -> AxisSolution:
    """Solve both hoses of an axis at a guessed joint rate.

    Args:
        base: the stage's known part; where there are chambers, with their oil in place of pressures
            (`conserved_oil.with_contents`).
        near: a state whose pressures are near the stage's.
        rate: of the joint [rad/s].
        t: position and lever arm at the stage's end.
        ports: what the valve connects.
        supply: P_s [Pa].
        axis: its constants.
        guard: the relief and anti-cavitation valves of its ports.
        h: the stage's implicit step [s].
    """
    if axis.oil_1.yields:
        if axis.holds:
            return _solve_with_holding(base, near, rate, t, ports, supply, axis, guard, h)
        return _solve_with_chambers(base, near, rate, t, ports, supply, axis, guard, h)
    hose_1 = StageHose(base.pressure_1, base.flow_1, axis.line_1)
    hose_2 = StageHose(base.pressure_2, -base.flow_2, axis.line_2)
    one, two = _solve_hoses(hose_1, hose_2, t.arm * rate, ports, supply, axis, guard, h)
    swept = axis.actuator.displacement_1, axis.actuator.displacement_2
    return _solution(rate, t, one, two, hose_1, hose_2, swept, axis, h)


def _solve_with_chambers(
    base: AxisState,
    near: AxisState,
    rate: float,
    t: Transmission,
    ports: Ports,
    supply: float,
    axis: Axis,
    guard: PortGuard,
    h: float,
) -> AxisSolution:
    """Do as `solve_axis` where the oil of hose and chamber is one volume; not inlined.

    Oil with air is not linear in the pressure: its tangent is moved until it is near enough. A
    piston takes no oil from its chamber, but moves its wall.
    """
    oil_1, oil_2 = axis.oil_1, axis.oil_2
    near_1 = held_above_vapour(near.pressure_1, 0.0, oil_1.oil)
    near_2 = held_above_vapour(near.pressure_2, 0.0, oil_2.oil)
    hose_1 = stage_hose(base.pressure_1, base.flow_1, t.position, near_1, axis.line_1, oil_1, h)
    hose_2 = stage_hose(base.pressure_2, -base.flow_2, t.position, near_2, axis.line_2, oil_2, h)
    through = _motor_takes(t.arm * rate, near_1, near_2, axis)
    one, two = _solve_hoses(hose_1, hose_2, through, ports, supply, axis, guard, h)
    for _ in range(TANGENTS):
        steady = _is_steady(through, t.arm * rate, one.pressure, two.pressure, axis)
        if steady and is_near(one.pressure, near_1, oil_1.oil) and is_near(two.pressure, near_2, oil_2.oil):
            break
        near_1 = held_above_vapour(one.pressure, near_1, oil_1.oil)
        near_2 = held_above_vapour(two.pressure, near_2, oil_2.oil)
        hose_1 = stage_hose(base.pressure_1, base.flow_1, t.position, near_1, axis.line_1, oil_1, h)
        hose_2 = stage_hose(base.pressure_2, -base.flow_2, t.position, near_2, axis.line_2, oil_2, h)
        through = _motor_takes(t.arm * rate, near_1, near_2, axis)
        one, two = _solve_hoses(hose_1, hose_2, through, ports, supply, axis, guard, h)
    swept = _swept(t.arm * rate, (near_1, near_2), hose_1, hose_2, axis)
    return _solution(rate, t, one, two, hose_1, hose_2, swept, axis, h)


def _solve_with_holding(
    base: AxisState,
    near: AxisState,
    rate: float,
    t: Transmission,
    ports: Ports,
    supply: float,
    axis: Axis,
    guard: PortGuard,
    h: float,
) -> AxisSolution:
    """Do as `_solve_with_chambers` with load-holding valves, whose tangents move along; not inlined."""
    oil_1, oil_2, speed = axis.oil_1, axis.oil_2, t.arm * rate
    pressures = (
        held_above_vapour(near.pressure_1, 0.0, oil_1.oil),
        held_above_vapour(near.pressure_2, 0.0, oil_2.oil),
    )
    held = restriction(ports.lifts.one, axis.holding_1), restriction(ports.lifts.two, axis.holding_2)
    flows = (
        first_flow(near.flow_1, pressures[0], ports.port_1, held[0], supply),
        first_flow(-near.flow_2, pressures[1], ports.port_2, held[1], supply),
    )
    one, two, hose_1, hose_2 = _tangents(
        base, pressures, flows, held, speed, t, ports, supply, axis, guard, h
    )
    for _ in range(TANGENTS):
        after_1 = next_flow(one, flows[0], ports.port_1, held[0], supply)
        after_2 = next_flow(two, flows[1], ports.port_2, held[1], supply)
        near_1, near_2 = pressures
        through = _motor_takes(speed, near_1, near_2, axis)
        steady = _is_steady(through, speed, one.pressure, two.pressure, axis)
        steady = steady and after_1 == flows[0] and after_2 == flows[1]
        if steady and is_near(one.pressure, near_1, oil_1.oil) and is_near(two.pressure, near_2, oil_2.oil):
            break
        pressures = (
            held_above_vapour(one.pressure, near_1, oil_1.oil),
            held_above_vapour(two.pressure, near_2, oil_2.oil),
        )
        flows = after_1, after_2
        one, two, hose_1, hose_2 = _tangents(
            base, pressures, flows, held, speed, t, ports, supply, axis, guard, h
        )
    swept = _swept(speed, pressures, hose_1, hose_2, axis)
    return _solution(rate, t, one, two, hose_1, hose_2, swept, axis, h)


def _motor_takes(speed: float, near_1: float, near_2: float, axis: Axis) -> float:
    """Return the speed [rad/s] with which a motor takes its oil, 0 of a piston, which takes none."""
    if axis.oil_1.area != 0.0:
        return 0.0
    return speed * filled_share(speed, near_1, near_2, axis.oil_1)


def _is_steady(through: float, speed: float, pressure_1: float, pressure_2: float, axis: Axis) -> bool:
    """Tell whether a motor takes as much oil at the pressures found [Pa] as it was taken to [rad/s]."""
    return abs(_motor_takes(speed, pressure_1, pressure_2, axis) - through) <= STEADY * abs(through)


def _swept(speed: float, near: Pair, hose_1: StageHose, hose_2: StageHose, axis: Axis) -> Pair:
    """Return the oil that port 1 takes and port 2 gives per actuator speed [m^2; m^3/rad]."""
    a = axis.actuator
    if axis.oil_1.area != 0.0:
        return a.displacement_1 * hose_1.density, a.displacement_2 * hose_2.density
    filled = filled_share(speed, near[0], near[1], axis.oil_1)
    return filled * a.displacement_1, filled * a.displacement_2


def _tangents(
    base: AxisState,
    near: Pair,
    flows: Pair,
    held: tuple[Restriction, Restriction],
    speed: float,
    t: Transmission,
    ports: Ports,
    supply: float,
    axis: Axis,
    guard: PortGuard,
    h: float,
) -> tuple[LineSolution, LineSolution, StageHose, StageHose]:
    """Return both hoses along tangents at pressures [Pa] and at flows through load-holding valves [m^3/s].

    Not inlined.
    """
    hose_1 = stage_hose(base.pressure_1, base.flow_1, t.position, near[0], axis.line_1, axis.oil_1, h)
    hose_2 = stage_hose(base.pressure_2, -base.flow_2, t.position, near[1], axis.line_2, axis.oil_2, h)
    hose_1 = held_hose(hose_1, flows[0], held[0], h)
    hose_2 = held_hose(hose_2, flows[1], held[1], h)
    through = _motor_takes(speed, near[0], near[1], axis)
    one, two = _solve_hoses(hose_1, hose_2, through, ports, supply, axis, guard, h)
    return one, two, hose_1, hose_2


def _solve_hoses(
    hose_1: StageHose,
    hose_2: StageHose,
    through: float,
    ports: Ports,
    supply: float,
    axis: Axis,
    guard: PortGuard,
    h: float,
) -> tuple[LineSolution, LineSolution]:
    """Return both hoses with an actuator that takes its oil at a speed [m/s; rad/s].

    The motor's small cross leakage is taken at the stage's known pressures, and its change after
    that to first order: it couples the hoses by a thousandth.
    """
    a, p_1, p_2 = axis.actuator, hose_1.pressure, hose_2.pressure
    # Each actuator flow without its own hose's pressure, which solve_line eliminates through the leakage.
    q_1, q_2 = inlet_flow(through, 0.0, p_2, a), outlet_flow(through, p_1, 0.0, a)
    one = solve_line(p_1, hose_1.flow, q_1, a.leakage_11, ports.port_1, supply, hose_1.line, guard, h)
    two = solve_line(p_2, hose_2.flow, -q_2, a.leakage_22, ports.port_2, supply, hose_2.line, guard, h)
    if a.leakage_12 != 0.0:
        more_1, more_2 = -a.leakage_12 * (two.pressure - p_2), -a.leakage_12 * (one.pressure - p_1)
        one, two = _both_with_outflow(one, two, more_1, more_2, a.leakage_12)
    return one, two


def _solution(
    rate: float,
    t: Transmission,
    one: LineSolution,
    two: LineSolution,
    hose_1: StageHose,
    hose_2: StageHose,
    swept: Pair,
    axis: Axis,
    h: float,
) -> AxisSolution:
    """Return what both hoses do to the joint."""
    a, speed = axis.actuator, t.arm * rate
    stiffness = a.displacement_1 * swept[0] * one.stiffness + a.displacement_2 * swept[1] * two.stiffness
    friction = rubbing(speed, axis.friction, one.pressure, two.pressure)
    passive = passive_force(t.position, speed, friction.force, axis)
    force = actuator_force(speed, one.pressure, two.pressure, a) + passive
    return AxisSolution(
        rate=rate,
        arm=t.arm,
        one=one,
        two=two,
        torque=t.arm * force,
        resistance=t.arm * t.arm * _resistance(speed, t, stiffness, friction, axis, h),
        known=(hose_1.pressure, hose_2.pressure),
        swept=swept,
        lines=(hose_1.line, hose_2.line),
        friction=friction,
    )


def _resistance(
    speed: float, t: Transmission, stiffness: float, friction: Rubbing, axis: Axis, h: float
) -> float:
    """Return -dF/du [N s/m; N m s/rad] of an actuator within a stage, the oil's stiffness first.

    What the pressures add to the seals' friction on the way is left out: it is k/A of the oil's
    stiffness, a few hundredths. Newton then gains less, by k/A (w h)^2 an iteration.
    """
    a = axis.actuator
    braking = a.quadratic_resistance + cushion_resistance(t.position, speed, axis.cushion)
    return (
        stiffness
        + a.linear_resistance
        + 2.0 * braking * abs(speed)
        + friction.slope
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
) -> AxisEnd:
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
    leakage, moved = axis.actuator.leakage_12, solution.arm * (rate - solution.rate)
    q_1, q_2 = feeds[0] * supply_change, feeds[1] * supply_change
    p_1, p_2 = solution.one.slope * q_1, solution.two.slope * q_2
    more_1 = solution.swept[0] * moved - leakage * p_2
    more_2 = -solution.swept[1] * moved - leakage * p_1
    one, two = _both_with_outflow(solution.one, solution.two, more_1, more_2, leakage)
    state = AxisState(
        base.angle + h * rate,
        rate,
        one.pressure + p_1,
        two.pressure + p_2,
        one.flow + q_1,
        -two.flow - q_2,
    )
    return AxisEnd(state, _contents(base, state, solution, h * moved, axis) if axis.oil_1.yields else state)


def _contents(base: AxisState, end: AxisState, solution: AxisSolution, way: float, axis: Axis) -> AxisState:
    """Return a stage's end with the oil that has flowed in place of its pressures.

    Args:
        base: the stage's known part, with its oil in place of pressures.
        end: the stage's end, its pressures along the tangent.
        solution: the axis before Newton's last correction.
        way: how much further that correction moves the actuator [m; rad].
        axis: its constants.
    """
    oil_1 = base.pressure_1 + solution.lines[0].capacitance * (end.pressure_1 - solution.known[0])
    oil_2 = base.pressure_2 + solution.lines[1].capacitance * (end.pressure_2 - solution.known[1])
    if axis.oil_1.area != 0.0:
        oil_1 += solution.swept[0] * way
        oil_2 -= solution.swept[1] * way
    return AxisState(end.angle, end.rate, oil_1, oil_2, end.flow_1, end.flow_2)


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
