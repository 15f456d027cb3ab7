"""One implicit stage of the plant, Y = base + h f(Y): hoses solved exactly, joint rates by Newton.

The stiffness comes from the orifices (C_R = inf inside the overlap) and the hoses, so a stage eliminates
flows and pressures exactly (`line.solve_line`) and is left with three joint rates, a real pump's pressure and
a hanging head's two rates.
"""

import math
from typing import NamedTuple

from forest_description.types import Vec3
from forest_sim.hydraulics.actuator import actuator_force, inlet_flow, outlet_flow
from forest_sim.hydraulics.hydraulic_line import LineSolution, PortGuard, drained, solve_line, supply_coupling
from forest_sim.hydraulics.supply import SupplyState, pump_flow, reference_after
from forest_sim.mechanics.end_stop import cushion_resistance, end_stop_resistance
from forest_sim.mechanics.friction import friction_slope
from forest_sim.mechanics.manipulator import Pair
from forest_sim.solver.multibody import HeadState, Inertia, mechanics, resisted, solve, times
from forest_sim.solver.plant import (
    AxisState,
    PlantState,
    Ports,
    Transmission,
    passive_force,
    sensed_load,
    transmissions,
)
from forest_sim.solver.plant_parameters import Axis, PlantParameters

TOLERANCE = 1e-4  # [rad/s] of Newton's last correction; the next one would be a thousandth of it at 1 ms
SUPPLY_TOLERANCE = 1e3  # [Pa] of P_s, as above
REFERENCE_TOLERANCE = 1.0  # [Pa] of P_r, which is not corrected but found anew
BOUNDED = 6  # iterations after which the supply's pressure is kept between bounds, for its pump's kinks
UNBOUNDED = (-math.inf, math.inf)
UNFED = ((0.0, 0.0), (0.0, 0.0), (0.0, 0.0))
ITERATIONS = 60
DAMPED, FULL = 12, 24  # iterations between which kinks (dry friction, a relief valve) are met by half steps


class AxisSolution(NamedTuple):
    """One axis of a stage at a guessed joint rate."""

    rate: float  # [rad/s]
    arm: float  # d(actuator position)/d(angle)
    one: LineSolution  # hose 1
    two: LineSolution  # hose 2, its flow counted from the valve
    torque: float  # on the joint [N m]
    resistance: float  # -d(torque)/d(rate) [N m s]


class AxisDraw(NamedTuple):
    """What one axis asks of the supply within a stage."""

    flow: float  # [m^3/s]
    conductance: float  # d(flow)/dP_s [m^3/(s Pa)]
    gain: float  # d(flow)/d(actuator speed) [m^2; m^3/rad]
    load: float  # that it shows [Pa]
    feeds: Pair  # d(flow into hose 1, 2)/dP_s [m^3/(s Pa)]


class SupplyError(NamedTuple):
    """The manifold's equation of a stage and its slopes."""

    residual: float  # [m^3]
    slope: float  # by P_s [m^3/Pa]
    by_rate: Vec3  # by the joint rates [m^3 s], which is also -d(residual of the joints)/dP_s
    feeds: tuple[Pair, Pair, Pair]  # d(flow into hose 1, 2)/dP_s of swing, boom, stick [m^3/(s Pa)]
    state: SupplyState  # P_s [Pa] of the guess, and the P_r that follows from it


class Guess(NamedTuple):
    """What Newton looks for: the rates and the supply's pressure at a stage's end."""

    rates: Vec3  # of the joints [rad/s]
    head_rates: Pair  # of the hanging head [rad/s]
    supply: SupplyState


class Trial(NamedTuple):
    """A stage's equations at a guess."""

    swing: AxisSolution
    boom: AxisSolution
    stick: AxisSolution
    matrix: Inertia
    residual: Vec3  # of the joints [N m s]
    head_residual: Pair
    supply: SupplyError


def solve_stage(
    base: PlantState,
    start: PlantState,
    rates: Vec3,
    ports: tuple[Ports, Ports, Ports],
    h: float,
    p: PlantParameters,
) -> tuple[PlantState, int]:
    """Return Y with Y = base + h f(Y), and 1 if Newton did not converge. The hoses are solved inside.

    Newton starts from the joint rates given and from all else of `start`. Its matrix leaves out what the
    configuration's change contributes (of order h), so that it converges by about three decimal places an
    iteration at 1 ms. From rates that follow the last accelerations, off by order h^2, the first correction
    is mostly the last: the next would be of order h^3, as the step's own error is.
    """
    guess = Guess(rates, (start.head.alpha_rate, start.head.beta_rate), start.supply)
    trial = _try(base, guess, ports, h, p)
    after, size, supply_change = _correct(guess, trial, 1.0, UNBOUNDED, p)
    if _is_small(size, supply_change, trial.supply.state.reference - guess.supply.reference):
        return _finished(base, after, trial, h, p), 0
    return _solve_further(base, after, ports, h, p)


def _solve_further(
    base: PlantState, guess: Guess, ports: tuple[Ports, Ports, Ports], h: float, p: PlantParameters
) -> tuple[PlantState, int]:
    """Return what `solve_stage` does, from the second iteration on; seldom, hence not inlined."""
    failed, bounds = 1, UNBOUNDED
    trial = _try_again(base, guess, ports, h, p)
    for iteration in range(1, ITERATIONS):
        before, share = guess.supply.pressure, 0.5 if DAMPED <= iteration < FULL else 1.0
        reference_change = trial.supply.state.reference - guess.supply.reference
        guess, size, supply_change = _correct(guess, trial, share, bounds, p)
        if share == 1.0 and _is_small(size, supply_change, reference_change):
            failed = 0
            break
        if iteration >= BOUNDED:
            bounds = _tightened(bounds, before, supply_change)
        trial = _try_again(base, guess, ports, h, p)
    return _finished(base, guess, trial, h, p), failed


def _finished(base: PlantState, guess: Guess, trial: Trial, h: float, p: PlantParameters) -> PlantState:
    """Return the state at a stage's end, from the last guess and the equations one correction before it."""
    fed, feeds = guess.supply.pressure - trial.supply.state.pressure, trial.supply.feeds
    return PlantState(
        swing=_assemble(base.swing, guess.rates[0], trial.swing, feeds[0], fed, p.swing, h),
        boom=_assemble(base.boom, guess.rates[1], trial.boom, feeds[1], fed, p.boom, h),
        stick=_assemble(base.stick, guess.rates[2], trial.stick, feeds[2], fed, p.stick, h),
        supply=guess.supply,
        head=_head_at(base.head, guess.head_rates, h),
    )


def _is_small(rates: float, supply: float, reference: float) -> bool:
    """Tell whether corrections [rad/s; Pa; Pa] leave nothing to speak of for the next iteration."""
    if not rates < TOLERANCE:
        return False
    return abs(supply) < SUPPLY_TOLERANCE and abs(reference) < REFERENCE_TOLERANCE


def _tightened(bounds: Pair, pressure: float, change: float) -> Pair:
    """Return the bounds of the supply's pressure after Newton has pointed up or down from one [Pa].

    Its equation rises with the pressure, but with the kinks of a pump's characteristic, across which Newton
    alone may jump to and fro. The rates move meanwhile: bounds that have closed on nothing are dropped.
    """
    low, high = (pressure, bounds[1]) if change > 0.0 else (bounds[0], pressure)
    return (low, high) if high - low > SUPPLY_TOLERANCE else UNBOUNDED


def _head_at(base: HeadState, rates: Pair, h: float) -> HeadState:
    return HeadState(base.alpha + h * rates[0], base.beta + h * rates[1], rates[0], rates[1])


def _try(
    base: PlantState,
    guess: Guess,
    ports: tuple[Ports, Ports, Ports],
    h: float,
    p: PlantParameters,
) -> Trial:
    """Return a stage's equations, M (rates - base) + h (bias - torque) = 0 and the supply's, at a guess."""
    u, w, supply = guess.rates, guess.head_rates, guess.supply.pressure
    angles = base.swing.angle + h * u[0], base.boom.angle + h * u[1], base.stick.angle + h * u[2]
    t_1, t_2, t_3 = transmissions(angles[0], angles[1], angles[2], p)
    swing = _solve_axis(base.swing, u[0], t_1, ports[0], supply, p.swing, p.guard, h)
    boom = _solve_axis(base.boom, u[1], t_2, ports[1], supply, p.boom, p.guard, h)
    stick = _solve_axis(base.stick, u[2], t_3, ports[2], supply, p.stick, p.guard, h)
    m = mechanics(angles, u, _head_at(base.head, w, h), p)
    gained, head_gained = times(
        m.inertia,
        (u[0] - base.swing.rate, u[1] - base.boom.rate, u[2] - base.stick.rate),
        (w[0] - base.head.alpha_rate, w[1] - base.head.beta_rate),
    )
    error = SupplyError(residual=0.0, slope=1.0, by_rate=(0.0, 0.0, 0.0), feeds=UNFED, state=guess.supply)
    if not p.supply.ideal:
        error = _supply_error(
            base.supply, supply, (swing, boom, stick), ports, (t_1.arm, t_2.arm, t_3.arm), h, p
        )
    return Trial(
        swing=swing,
        boom=boom,
        stick=stick,
        matrix=resisted(m.inertia, (swing.resistance, boom.resistance, stick.resistance), p.head.damping, h),
        residual=(
            gained[0] + h * (m.bias[0] - swing.torque),
            gained[1] + h * (m.bias[1] - boom.torque),
            gained[2] + h * (m.bias[2] - stick.torque),
        ),
        head_residual=(head_gained[0] + h * m.head_bias[0], head_gained[1] + h * m.head_bias[1]),
        supply=error,
    )


def _try_again(
    base: PlantState, guess: Guess, ports: tuple[Ports, Ports, Ports], h: float, p: PlantParameters
) -> Trial:
    """Return what `_try` does; not inlined."""
    return _try(base, guess, ports, h, p)


def _correct(
    guess: Guess, trial: Trial, share: float, bounds: Pair, p: PlantParameters
) -> tuple[Guess, float, float]:
    """Return the guess after a share of Newton's correction, its size, and the supply's change [rad/s; Pa].

    Where that change would leave the bounds, they are halved instead.
    """
    c, d = solve(trial.matrix, trial.residual, trial.head_residual)
    pressure = change = 0.0
    if not p.supply.ideal:
        s = trial.supply
        b = s.by_rate
        z, y = solve(trial.matrix, b, (0.0, 0.0))
        pressure = (s.residual - b[0] * c[0] - b[1] * c[1] - b[2] * c[2]) / (
            s.slope + b[0] * z[0] + b[1] * z[1] + b[2] * z[2]
        )
        change = -pressure
        here = guess.supply.pressure
        middle = 0.5 * (bounds[0] + bounds[1])
        if math.isfinite(middle) and not bounds[0] < here - pressure < bounds[1]:
            pressure = here - middle
        c = c[0] + z[0] * pressure, c[1] + z[1] * pressure, c[2] + z[2] * pressure
        d = d[0] + y[0] * pressure, d[1] + y[1] * pressure
    u, w = guess.rates, guess.head_rates
    after = Guess(
        (u[0] - share * c[0], u[1] - share * c[1], u[2] - share * c[2]),
        (w[0] - share * d[0], w[1] - share * d[1]),
        SupplyState(guess.supply.pressure - share * pressure, trial.supply.state.reference),
    )
    return after, max(abs(c[0]), abs(c[1]), abs(c[2]), abs(d[0]), abs(d[1])), change


def _supply_error(
    base: SupplyState,
    supply: float,
    axes: tuple[AxisSolution, AxisSolution, AxisSolution],
    ports: tuple[Ports, Ports, Ports],
    arms: Vec3,
    h: float,
    p: PlantParameters,
) -> SupplyError:
    """Return the manifold's equation, C (P_s - base) = h (delivered - drawn), at a guess."""
    one = _draw(axes[0], ports[0], supply, p.swing, h)
    two = _draw(axes[1], ports[1], supply, p.boom, h)
    three = _draw(axes[2], ports[2], supply, p.stick, h)
    reference = reference_after(base.reference, max(one.load, two.load, three.load), p.supply, h)
    pump = pump_flow(supply, reference, p.supply)
    drawn = one.flow + two.flow + three.flow
    conductance = one.conductance + two.conductance + three.conductance
    return SupplyError(
        residual=p.supply.capacitance * (supply - base.pressure) + h * (drawn - pump.delivered),
        slope=p.supply.capacitance + h * (conductance - pump.slope),
        by_rate=(h * arms[0] * one.gain, h * arms[1] * two.gain, h * arms[2] * three.gain),
        feeds=(one.feeds, two.feeds, three.feeds),
        state=SupplyState(supply, reference),
    )


def _draw(axis: AxisSolution, ports: Ports, supply: float, a: Axis, h: float) -> AxisDraw:
    """Return what an axis asks of the supply within a stage."""
    one = supply_coupling(axis.one, ports.port_1, supply, a.line_1, h)
    two = supply_coupling(axis.two, ports.port_2, supply, a.line_2, h)
    gain = a.actuator.displacement_1 * one.gain - a.actuator.displacement_2 * two.gain
    load = max(
        sensed_load(axis.one.port_pressure, ports.port_1), sensed_load(axis.two.port_pressure, ports.port_2)
    )
    feeds = one.feed, two.feed
    return AxisDraw(
        flow=one.draw + two.draw,
        conductance=one.conductance + two.conductance,
        gain=gain,
        load=load,
        feeds=feeds,
    )


def _assemble(
    base: AxisState, rate: float, solution: AxisSolution, feeds: Pair, fed: float, axis: Axis, h: float
) -> AxisState:
    """Return an axis at the stage's end: the hoses follow Newton's last correction to first order.

    Without that the oil that this correction moves would be lost, step after step.

    Args:
        base: the stage's known part.
        rate: the joint's, corrected [rad/s].
        solution: the axis before the correction.
        feeds: d(flow into hose 1, 2)/dP_s [m^3/(s Pa)].
        fed: the correction of P_s [Pa].
        axis: its constants.
        h: the stage's implicit step [s].
    """
    a, moved = axis.actuator, solution.arm * (rate - solution.rate)
    q_1, q_2 = feeds[0] * fed, feeds[1] * fed
    p_1, p_2 = solution.one.slope * q_1, solution.two.slope * q_2
    more_1 = a.displacement_1 * moved - a.leakage_12 * p_2
    more_2 = -a.displacement_2 * moved - a.leakage_12 * p_1
    one, two = _both_drained(solution.one, solution.two, more_1, more_2, a.leakage_12)
    return AxisState(
        angle=base.angle + h * rate,
        rate=rate,
        pressure_1=one.pressure + p_1,
        pressure_2=two.pressure + p_2,
        flow_1=one.flow + q_1,
        flow_2=-two.flow - q_2,
    )


def _both_drained(
    one: LineSolution, two: LineSolution, flow_1: float, flow_2: float, leakage: float
) -> tuple[LineSolution, LineSolution]:
    """Return both hoses after the actuator takes more by small flows [m^3/s], as they leak into each other.

    dP_1 = -z_1 (dq_1 - g dP_2) and dP_2 = -z_2 (dq_2 - g dP_1), z their stiffness, g the cross leakage.
    """
    if leakage != 0.0:
        z_1, z_2 = leakage * one.stiffness, leakage * two.stiffness
        closing = 1.0 / (1.0 - z_1 * z_2)
        flow_1, flow_2 = (flow_1 + z_2 * flow_2) * closing, (flow_2 + z_1 * flow_1) * closing
    return drained(one, flow_1), drained(two, flow_2)


def _solve_axis(
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

    The motor's small cross leakage is taken at the stage's known pressures, and its change after that to
    first order: it couples the hoses by a thousandth.
    """
    a = axis.actuator
    speed, p_1, p_2 = t.arm * rate, base.pressure_1, base.pressure_2
    # Each actuator flow without its own hose's pressure, which solve_line eliminates through the leakage.
    q_1, q_2 = inlet_flow(speed, 0.0, p_2, a), outlet_flow(speed, p_1, 0.0, a)
    one = solve_line(p_1, base.flow_1, q_1, a.leakage_11, ports.port_1, supply, axis.line_1, guard, h)
    two = solve_line(p_2, -base.flow_2, -q_2, a.leakage_22, ports.port_2, supply, axis.line_2, guard, h)
    if a.leakage_12 != 0.0:
        more_1, more_2 = -a.leakage_12 * (two.pressure - p_2), -a.leakage_12 * (one.pressure - p_1)
        one, two = _both_drained(one, two, more_1, more_2, a.leakage_12)
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
