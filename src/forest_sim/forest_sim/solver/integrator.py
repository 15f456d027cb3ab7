"""One time step of the plant, through shut valves and water hammer alike.

An L-stable, stiffly accurate, two-stage SDIRK of order 2 (gamma = 1 - 1/sqrt 2): each stage solves
Y = y + step f(Y) for the f of `plant.state_derivative` (`implicit_stage.solve_stage`). A stage's
derivative is read off its increment, (Y - y)/step, never from f: f has no value when an orifice
shuts on a flow.

The step assumes that commands stand still over it. The spools are advanced exactly.
"""

import math
from typing import NamedTuple

from forest_description.types import Vec3
from forest_sim.equations.drive import DriveState
from forest_sim.equations.elastic_links import Roots, RootState
from forest_sim.equations.multibody import HeadState
from forest_sim.equations.plant import AxisState, PlantState
from forest_sim.equations.plant_parameters import PlantParameters, SpoolValve
from forest_sim.equations.valve_ports import Ports, has_poppets, is_compensated, ports_at, with_tank
from forest_sim.hydraulics.command_history import (
    NO_COMMANDS,
    Acting,
    AllActing,
    CommandHistory,
    Delayed,
    after_dead_time,
    held,
)
from forest_sim.hydraulics.flow_force import NO_JETS, AllJets
from forest_sim.hydraulics.hydraulic_line import PortGuard
from forest_sim.hydraulics.load_holding import AllLifts, lifts_along
from forest_sim.hydraulics.pump_drive import PumpState
from forest_sim.hydraulics.spool_dynamics import Spool, Spools, spool_after
from forest_sim.hydraulics.supply import SupplyState
from forest_sim.hydraulics.tank_line import TankState, pressure_after
from forest_sim.mechanics.manipulator import Pair
from forest_sim.midpoint.load_sensing import sensed_over
from forest_sim.midpoint.midpoint_state import NO_MIDPOINT, MidpointState, midpoint_after, with_jets
from forest_sim.midpoint.tank_step import returned, tank_at_stage
from forest_sim.solver.conserved_oil import settled, with_contents
from forest_sim.stage.implicit_stage import solve_stage

GAMMA = 1.0 - math.sqrt(0.5)
WEIGHTS = (1.0 - GAMMA, GAMMA)
"""Of both stages' derivatives in a step."""


class Events(NamedTuple):
    """What happened since the start, counted."""

    relief_openings: int
    anticavitation_openings: int
    unconverged_stages: int


class Simulation(NamedTuple):
    """The machine between two steps."""

    plant: PlantState
    spools: Spools
    events: Events
    accelerations: Vec3  # of the joints over the last stage [rad/s^2], from which Newton starts
    head_accelerations: Pair  # of the hanging head, as well
    history: CommandHistory = NO_COMMANDS  # kept where a valve has a dead time
    midpoint: MidpointState = NO_MIDPOINT  # what was known of the middle of the last step


def ports_of(simulation: Simulation, p: PlantParameters) -> tuple[Ports, Ports, Ports]:
    """Return what the spools of a machine connect, and how its poppets stand."""
    return ports_at(simulation.spools, p, simulation.midpoint.lifts, simulation.midpoint.tank.seen)


class Step(NamedTuple):
    """A step's end, and the machine as both stages have it: plant, spools, lifts, tank line."""

    after: Simulation
    early: Simulation
    late: Simulation


def step(simulation: Simulation, voltages: Vec3, h: float, p: PlantParameters) -> Simulation:
    """Advance the machine by h [s] with the valve voltages [V] held."""
    count = parts(p)
    for _ in range(count):
        simulation = step_by_stages(simulation, voltages, h / count, p).after
    return simulation


def parts(p: PlantParameters) -> int:
    """Return into how many equal ones a step is divided: two behind pressure compensators.

    A flow that heeds no pressure damps nothing. What a step is off by is not forgotten, but rings on.
    """
    return 2 if is_compensated(p) else 1


def step_by_stages(simulation: Simulation, voltages: Vec3, h: float, p: PlantParameters) -> Step:
    """Make one undivided step, and return both stages, too: what passes in a step is a sum over them."""
    plant, c = simulation.plant, GAMMA * h
    acting, history = _delayed(simulation.history, voltages, h, p)
    midpoint = with_jets(simulation.midpoint, plant, simulation.spools, p)
    middle = spools_after(simulation.spools, acting, c, p, midpoint.jets)
    end = spools_after(simulation.spools, acting, h, p, midpoint.jets)
    midpoint = midpoint_after(midpoint, plant, simulation.spools, end, h, p)
    early, late = _lifts_by_stage(simulation.midpoint.lifts, midpoint.lifts, p)
    way, rates = (simulation.spools, end), _rates_after(plant, simulation.accelerations, c)
    tank, ports = _stage_ports(plant, middle, early, midpoint.tank, way, c, p)
    base = start = contents = with_contents(plant, early, p)
    ahead = after = _with_head_ahead(plant, simulation.head_accelerations, c)
    first, first_tank, failures = plant, tank, 0
    for stage in range(2):  # one body for both, so that the compiled plant holds it once
        after, contents, failed = solve_stage(base, ahead, rates, ports, c, p)
        failures += failed
        if p.tank_line.capacitance > 0.0:
            share = (GAMMA if stage else 1.0 - GAMMA) * h
            tank = pressure_after(tank, returned(after, ports, p).flow, share, p.tank_line)
        if stage == 0:
            first, first_tank = after, tank
            # y + (1 - gamma) h k_1, with k_1 = (Y_1 - y) / (gamma h)
            base = _blend(start, contents, (1.0 - GAMMA) / GAMMA, p)
            ahead = _blend(plant, after, 1.0 / GAMMA, p)
            rates = ahead.swing.rate, ahead.boom.rate, ahead.stick.rate
            if end != middle or has_poppets(p) or p.tank_line.capacitance > 0.0:
                known = _blend(plant, after, (1.0 - GAMMA) / GAMMA, p)
                tank, ports = _stage_ports(known, end, late, tank, way, c, p)
    after = settled(after, contents, p)
    events = _count(simulation.events, plant, after, failures, p.guard, tank.seen)
    rates_after, head_after = _mean_accelerations(base, after, c), _head_accelerations(base, after, c)
    midpoint = midpoint._replace(tank=tank)
    stepped = Simulation(after, end, events, rates_after, head_after, history, midpoint)
    return Step(
        after=stepped,
        early=stepped._replace(
            plant=first, spools=middle, midpoint=midpoint._replace(lifts=early, tank=first_tank)
        ),
        late=stepped._replace(midpoint=midpoint._replace(lifts=late)),
    )


def _stage_ports(
    known: PlantState,
    spools: Spools,
    lifts: AllLifts,
    tank: TankState,
    way: tuple[Spools, Spools],
    c: float,
    p: PlantParameters,
) -> tuple[TankState, tuple[Ports, Ports, Ports]]:
    """Return the tank line at a stage's end, and what the valves connect there.

    Args:
        known: the stage's known part of the plant.
        spools: at its end.
        lifts: at its end.
        tank: the stage's known part of the line.
        way: the spools at the step's beginning and end.
        c: the stage's implicit step [s].
        p: the machine.
    """
    ports = ports_at(spools, p, lifts, tank.pressure)
    if p.tank_line.capacitance > 0.0:
        tank = tank_at_stage(known, ports, tank, c, p)
        ports = with_tank(ports, tank.seen)
    if p.supply.rate > 0.0:
        ports = sensed_over(ports, way[0], way[1], p)
    return tank, ports


def _lifts_by_stage(before: AllLifts, midpoint: AllLifts, p: PlantParameters) -> tuple[AllLifts, AllLifts]:
    """Return the lifts at both stages' ends, on a straight line through the middles of two steps."""
    if not has_poppets(p):
        return midpoint, midpoint
    return lifts_along(before, midpoint, 0.5 + GAMMA), lifts_along(before, midpoint, 1.5)


def _delayed(history: CommandHistory, voltages: Vec3, h: float, p: PlantParameters) -> Delayed:
    """Return what acts on the spools in a step: the voltages given [V], or those of a dead time ago."""
    late = p.valves[0].lag.dead_time, p.valves[1].lag.dead_time, p.valves[2].lag.dead_time
    if late[0] + late[1] + late[2] == 0.0:
        return Delayed(held(voltages), history)
    return after_dead_time(history, voltages, h, late)


def _mean_accelerations(before: PlantState, after: PlantState, time: float) -> Vec3:
    """Return the joints' mean accelerations [rad/s^2] over a time [s]."""
    per_time = 1.0 / time
    return (
        per_time * (after.swing.rate - before.swing.rate),
        per_time * (after.boom.rate - before.boom.rate),
        per_time * (after.stick.rate - before.stick.rate),
    )


def _head_accelerations(before: PlantState, after: PlantState, time: float) -> Pair:
    """Return the hanging head's mean accelerations [rad/s^2] over a time [s]."""
    a, b, per_time = before.head, after.head, 1.0 / time
    return per_time * (b.alpha_rate - a.alpha_rate), per_time * (b.beta_rate - a.beta_rate)


def _with_head_ahead(plant: PlantState, accelerations: Pair, time: float) -> PlantState:
    """Return the plant with the head's rates [rad/s] that steady accelerations [rad/s^2] lead to."""
    h = plant.head
    rates = h.alpha_rate + time * accelerations[0], h.beta_rate + time * accelerations[1]
    head = HeadState(h.alpha, h.beta, rates[0], rates[1])
    return PlantState(
        plant.swing, plant.boom, plant.stick, plant.supply, head, plant.drive, plant.pump, plant.roots
    )


def _rates_after(plant: PlantState, accelerations: Vec3, time: float) -> Vec3:
    """Return the joint rates [rad/s] that steady accelerations [rad/s^2] lead to."""
    return (
        plant.swing.rate + time * accelerations[0],
        plant.boom.rate + time * accelerations[1],
        plant.stick.rate + time * accelerations[2],
    )


def advance(simulation: Simulation, voltages: Vec3, h: float, count: int, p: PlantParameters) -> Simulation:
    """Advance the machine by `count` steps of h [s] with the valve voltages [V] held."""
    for _ in range(count):
        simulation = step(simulation, voltages, h, p)
    return simulation


def spools_after(
    spools: Spools, acting: AllActing, time: float, p: PlantParameters, jets: AllJets = NO_JETS
) -> Spools:
    """Return the spools after a time [s] of a step; they end at the rated voltage."""
    return (
        _spool_after(spools[0], acting[0], time, p.valves[0], jets[0].push),
        _spool_after(spools[1], acting[1], time, p.valves[1], jets[1].push),
        _spool_after(spools[2], acting[2], time, p.valves[2], jets[2].push),
    )


def _spool_after(spool: Spool, acting: Acting, time: float, valve: SpoolValve, push: float) -> Spool:
    rated, rest = valve.law.forward.rated_voltage, time
    voltage = acting.voltage if acting.change < time else acting.before
    if 0.0 < acting.change < time:
        spool = spool_after(spool, max(-rated, min(rated, acting.before)), acting.change, valve.lag, push)
        rest = time - acting.change
    return spool_after(spool, max(-rated, min(rated, voltage)), rest, valve.lag, push)


def _count(
    e: Events, before: PlantState, after: PlantState, failed: int, guard: PortGuard, tank: float
) -> Events:
    """Count the port valves that opened over a step, and the stages whose Newton did not converge."""
    if guard.relief_conductance == 0.0 and guard.anticavitation_conductance == 0.0:
        return Events(e.relief_openings, e.anticavitation_openings, e.unconverged_stages + failed)
    a, b, c = (
        _openings(before.swing, after.swing, guard, tank),
        _openings(before.boom, after.boom, guard, tank),
        _openings(before.stick, after.stick, guard, tank),
    )
    return Events(
        e.relief_openings + a[0] + b[0] + c[0],
        e.anticavitation_openings + a[1] + b[1] + c[1],
        e.unconverged_stages + failed,
    )


def _openings(before: AxisState, after: AxisState, guard: PortGuard, tank: float) -> tuple[int, int]:
    """Return how many of an axis' relief and anti-cavitation valves opened over a step."""
    relief, check = guard.relief_pressure + tank, guard.anticavitation_pressure + tank
    return (
        int(before.pressure_1 <= relief < after.pressure_1)
        + int(before.pressure_2 <= relief < after.pressure_2),
        int(before.pressure_1 >= check > after.pressure_1)
        + int(before.pressure_2 >= check > after.pressure_2),
    )


def _blend(start: PlantState, stage: PlantState, weight: float, p: PlantParameters) -> PlantState:
    """Return start + weight (stage - start)."""
    a, b = start.supply, stage.supply
    return PlantState(
        swing=_blend_axis(start.swing, stage.swing, weight),
        boom=_blend_axis(start.boom, stage.boom, weight),
        stick=_blend_axis(start.stick, stage.stick, weight),
        supply=SupplyState(
            a.pressure + weight * (b.pressure - a.pressure),
            a.reference + weight * (b.reference - a.reference),
        ),
        head=_blend_head(start.head, stage.head, weight),
        drive=_blend_drive(start.drive, stage.drive, weight) if p.drive.present else start.drive,
        pump=_blend_pump(start.pump, stage.pump, weight) if p.supply.drive.present else start.pump,
        roots=_blend_roots(start.roots, stage.roots, weight) if p.elastic.present else start.roots,
    )


def _blend_head(a: HeadState, b: HeadState, w: float) -> HeadState:
    return HeadState(
        a.alpha + w * (b.alpha - a.alpha),
        a.beta + w * (b.beta - a.beta),
        a.alpha_rate + w * (b.alpha_rate - a.alpha_rate),
        a.beta_rate + w * (b.beta_rate - a.beta_rate),
    )


def _blend_pump(a: PumpState, b: PumpState, w: float) -> PumpState:
    return PumpState(a.stroke + w * (b.stroke - a.stroke), a.speed + w * (b.speed - a.speed))


def _blend_drive(a: DriveState, b: DriveState, w: float) -> DriveState:
    return DriveState(
        a.motor_angle + w * (b.motor_angle - a.motor_angle),
        a.motor_rate + w * (b.motor_rate - a.motor_rate),
        a.bristle_angle + w * (b.bristle_angle - a.bristle_angle),
    )


def _blend_roots(a: Roots, b: Roots, w: float) -> Roots:
    return Roots(
        _blend_root(a.swing, b.swing, w), _blend_root(a.boom, b.boom, w), _blend_root(a.stick, b.stick, w)
    )


def _blend_root(a: RootState, b: RootState, w: float) -> RootState:
    return RootState(a.angle + w * (b.angle - a.angle), a.rate + w * (b.rate - a.rate))


def _blend_axis(a: AxisState, b: AxisState, w: float) -> AxisState:
    return AxisState(
        angle=a.angle + w * (b.angle - a.angle),
        rate=a.rate + w * (b.rate - a.rate),
        pressure_1=a.pressure_1 + w * (b.pressure_1 - a.pressure_1),
        pressure_2=a.pressure_2 + w * (b.pressure_2 - a.pressure_2),
        flow_1=a.flow_1 + w * (b.flow_1 - a.flow_1),
        flow_2=a.flow_2 + w * (b.flow_2 - a.flow_2),
    )
