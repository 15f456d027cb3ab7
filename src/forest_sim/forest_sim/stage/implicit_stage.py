"""One implicit stage of the plant, Y = base + h f(Y): hoses solved exactly, joint rates by Newton.

The stiffness comes from the orifices (C_R = inf inside the overlap) and the hoses, so a stage
eliminates flows and pressures exactly (`hydraulic_line.solve_line`) and is left with three joint
rates, a real pump's pressure, a hanging head's two rates and those of a motor behind play and of
elastic links' roots.
"""

import math
from typing import NamedTuple

from forest_description.types import Vec3
from forest_sim.equations.multibody import solve
from forest_sim.equations.plant import AxisState, PlantState, with_joint
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.equations.valve_ports import Ports
from forest_sim.hydraulics.oil_law import held_above_vapour
from forest_sim.hydraulics.supply import SupplyState, flow_after, manifold_oil
from forest_sim.mechanics.manipulator import Pair
from forest_sim.stage import stage_equations
from forest_sim.stage.axis_stage import AxisEnd, corrected_axis
from forest_sim.stage.drive_stage import (
    drive_after,
)
from forest_sim.stage.elastic_stage import (
    ALL_STIFF,
    ElasticSolution,
    first_root_rates,
    root_corrections,
    roots_after,
)
from forest_sim.stage.stage_equations import ELASTIC, RIGID, Iterate, StageEquations
from forest_sim.stage.supply_stage import (
    UNBOUNDED,
    supply_tolerance,
    tightened_bounds,
)

TOLERANCE = 1e-4  # [rad/s] of Newton's last correction; the next one would be a thousandth of it at 1 ms
LIGHT_SHARE = 0.01  # of a motor's and a root's correction that counts: they weigh a hundredth of the crane
BOUNDED = 6  # iterations after which the supply's pressure is kept between bounds, for its pump's kinks
ITERATIONS = 60
DAMPED, FULL = 12, 24  # iterations between which kinks (dry friction, a relief valve) are met by half steps


class StageEnd(NamedTuple):
    """What a stage leads to."""

    state: PlantState  # Y; where there are chambers, with pressures along the tangent of the oil's law
    contents: PlantState  # Y, with oil in place of pressures as `conserved_oil.with_contents` has it
    failed: int  # 1 if Newton did not converge


def solve_stage(
    base: PlantState,
    start: PlantState,
    rates: Vec3,
    ports: tuple[Ports, Ports, Ports],
    h: float,
    p: PlantParameters,
) -> StageEnd:
    """Return Y with Y = base + h f(Y). The hoses are solved inside.

    Newton starts from the joint rates given and from all else of `start`. Its matrix leaves out
    what the configuration's change contributes (of order h), so that it converges by about three
    decimal places an iteration at 1 ms. From rates that follow the last accelerations, off by order
    h^2, the first correction is mostly the last: the next would be of order h^3, as the step's own
    error is.
    """
    turning = rates[0]
    if p.drive.gear.inertia > 0.0:
        turning = base.drive.motor_rate + (rates[0] - base.swing.rate)
    iterate = Iterate(rates, (start.head.alpha_rate, start.head.beta_rate), start.supply, turning, rates)
    if p.elastic.present:
        return _iterate_elastic(base, start, _with_root_rates(iterate, base, p), ports, h, p)
    equations, _ = stage_equations.equations_at(base, start, iterate, ports, h, p, RIGID)
    after, size, supply_change = _newton_step(iterate, equations, ALL_STIFF, 1.0, UNBOUNDED, p, RIGID)
    if size < TOLERANCE and abs(supply_change) < supply_tolerance(after.supply.pressure, p):
        return _stage_end(base, after, equations, 0, h, p, RIGID)
    return _iterate_further(base, start, after, ports, h, p)


def _with_root_rates(iterate: Iterate, base: PlantState, p: PlantParameters) -> Iterate:
    """Return an iterate whose roots' rates, and the motor's without play, follow those of the links."""
    roots = first_root_rates(base, iterate.rates, p)
    motor = iterate.motor_rate if p.drive.gear.inertia > 0.0 else roots[0]
    return Iterate(iterate.rates, iterate.head_rates, iterate.supply, motor, roots)


def _iterate_further(
    base: PlantState,
    near: PlantState,
    iterate: Iterate,
    ports: tuple[Ports, Ports, Ports],
    h: float,
    p: PlantParameters,
) -> StageEnd:
    """Return what `solve_stage` does, from the second iteration on; seldom, hence not inlined."""
    return _iterate(base, near, iterate, ports, h, p, RIGID)


def _iterate_elastic(
    base: PlantState,
    near: PlantState,
    iterate: Iterate,
    ports: tuple[Ports, Ports, Ports],
    h: float,
    p: PlantParameters,
) -> StageEnd:
    """Return what `solve_stage` does where links give way; not inlined."""
    return _iterate(base, near, iterate, ports, h, p, ELASTIC)


def _iterate(
    base: PlantState,
    near: PlantState,
    iterate: Iterate,
    ports: tuple[Ports, Ports, Ports],
    h: float,
    p: PlantParameters,
    bends: int,
) -> StageEnd:
    """Return what Newton's iterations lead to."""
    failed, bounds = 1, UNBOUNDED
    equations, links = stage_equations.equations_again(base, near, iterate, ports, h, p, bends)
    for iteration in range(1, ITERATIONS):
        before, share = iterate.supply.pressure, 0.5 if DAMPED <= iteration < FULL else 1.0
        iterate, size, supply_change = _newton_step(iterate, equations, links, share, bounds, p, bends)
        tolerance = supply_tolerance(iterate.supply.pressure, p)
        if share == 1.0 and size < TOLERANCE and abs(supply_change) < tolerance:
            failed = 0
            break
        if iteration >= BOUNDED:
            bounds = tightened_bounds(bounds, before, supply_change)
        equations, links = stage_equations.equations_again(base, near, iterate, ports, h, p, bends)
    return _stage_end(base, iterate, equations, failed, h, p, bends)


def _stage_end(
    base: PlantState,
    iterate: Iterate,
    equations: StageEquations,
    failed: int,
    h: float,
    p: PlantParameters,
    bends: int,
) -> StageEnd:
    """Return the state at a stage's end, from the last iterate and the equations one correction before it."""
    supply_change, feeds = iterate.supply.pressure - equations.supply.state.pressure, equations.supply.feeds
    u, w, e = iterate.rates, iterate.root_rates, equations
    drive, roots = base.drive, base.roots
    swing = corrected_axis(base.swing, iterate.motor_rate, e.swing, feeds[0], supply_change, p.swing, h)
    if p.drive.present:
        drive = drive_after(base.drive, w[0], iterate.motor_rate, h, p.drive)
        angle = base.swing.angle + h * u[0]
        swing = AxisEnd(with_joint(swing.state, angle, u[0]), with_joint(swing.contents, angle, u[0]))
    boom = corrected_axis(base.boom, w[1], e.boom, feeds[1], supply_change, p.boom, h)
    stick = corrected_axis(base.stick, w[2], e.stick, feeds[2], supply_change, p.stick, h)
    if bends:
        roots = roots_after(base, w, h, p.elastic)
        swing = _with_link(swing, base.swing, u[0], h)
        boom, stick = _with_link(boom, base.boom, u[1], h), _with_link(stick, base.stick, u[2], h)
    head = stage_equations.head_at(base.head, iterate.head_rates, h)
    contents = SupplyState(manifold_oil(iterate.supply.pressure, p.supply), iterate.supply.reference)
    pump = base.pump
    if p.supply.drive.present:
        pump = flow_after(iterate.supply, base.pump, h, p.supply).pump
    return StageEnd(
        PlantState(swing.state, boom.state, stick.state, iterate.supply, head, drive, pump, roots),
        PlantState(swing.contents, boom.contents, stick.contents, contents, head, drive, pump, roots),
        failed,
    )


def _with_link(end: AxisEnd, base: AxisState, rate: float, h: float) -> AxisEnd:
    """Return an axis' end, solved at its root, with the angle and rate [rad/s] of the link."""
    angle = base.angle + h * rate
    return AxisEnd(with_joint(end.state, angle, rate), with_joint(end.contents, angle, rate))


def _newton_step(
    iterate: Iterate,
    equations: StageEquations,
    links: ElasticSolution,
    share: float,
    bounds: Pair,
    p: PlantParameters,
    bends: int,
) -> tuple[Iterate, float, float]:
    """Return the iterate after a share of Newton's correction, its size, and the supply's change [rad/s; Pa].

    Where that change would leave the bounds, they are halved instead.
    """
    c, d, pressure, change = _corrections(iterate.supply.pressure, equations, bounds, p)
    u, w = iterate.rates, iterate.head_rates
    supply = held_above_vapour(
        iterate.supply.pressure - share * pressure, iterate.supply.pressure, p.supply.oil
    )
    turns, roots = c, iterate.root_rates
    if bends:
        turns = root_corrections(c, pressure, links)
    roots = roots[0] - share * turns[0], roots[1] - share * turns[1], roots[2] - share * turns[2]
    turning, motor = 0.0, roots[0]
    if p.drive.present:
        e = equations.drive
        turning = e.share * turns[0] + e.excess + e.give * equations.motor_gain * pressure
        motor = iterate.motor_rate - share * turning
    reference, aims = equations.supply.state.reference, equations.supply.control
    if p.supply.rate > 0.0:
        driving = turning if p.drive.present else turns[0]
        followed = aims.by_rate[0] * driving + aims.by_rate[1] * turns[1] + aims.by_rate[2] * turns[2]
        reference -= share * (aims.by_supply * pressure + followed)
    after = Iterate(
        (u[0] - share * c[0], u[1] - share * c[1], u[2] - share * c[2]),
        (w[0] - share * d[0], w[1] - share * d[1]),
        SupplyState(supply, reference),
        motor,
        roots,
    )
    size = max(abs(c[0]), abs(c[1]), abs(c[2]), abs(d[0]), abs(d[1]), LIGHT_SHARE * abs(turning))
    if bends:
        size = max(size, LIGHT_SHARE * max(abs(turns[0]), abs(turns[1]), abs(turns[2])))
    return after, size, change


def _corrections(
    supply: float, equations: StageEquations, bounds: Pair, p: PlantParameters
) -> tuple[Vec3, Pair, float, float]:
    """Return Newton's corrections of rates, head rates and supply, and its change without bounds [rad/s; Pa].

    The supply's equation is eliminated from the matrix (Schur complement), which stays that of rigid bodies.
    """
    c, d = solve(equations.matrix, equations.residual, equations.head_residual)
    if p.supply.ideal:
        return c, d, 0.0, 0.0
    s = equations.supply
    b = s.by_rate
    z, y = solve(equations.matrix, s.on_rates, (0.0, 0.0))
    pressure = (s.residual - b[0] * c[0] - b[1] * c[1] - b[2] * c[2]) / (
        s.slope + b[0] * z[0] + b[1] * z[1] + b[2] * z[2]
    )
    change = -pressure
    middle = 0.5 * (bounds[0] + bounds[1])
    if math.isfinite(middle) and not bounds[0] < supply - pressure < bounds[1]:
        pressure = supply - middle
    c = c[0] + z[0] * pressure, c[1] + z[1] * pressure, c[2] + z[2] * pressure
    d = d[0] + y[0] * pressure, d[1] + y[1] * pressure
    return c, d, pressure, change
