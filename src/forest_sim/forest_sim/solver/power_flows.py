"""Where the power goes: from the engine's shaft through pump, valves and hoses to the links.

Every entry is a power at one state [W], positive in the direction that its name says. The entries
of a part close: what flows in equals what is lost, stored and handed on. That they do is a test of
the laws' signs, and their integrals over a run are its energy account. What a valve destroys at
once has no power: `stopped_energy` has it.

| part | flows in | lost | stored | handed on |
|---|---|---|---|---|
| pump | engine | pump_friction, pump_leakage, main_relief | manifold, flywheel | supply |
| valve | supply | throttling | | hose inlets, tank line |
| tank line | returned, relieved | return_line | tank_line | |
| hose | its inlet | port_valves, resistance, holding, compression | hose | actuator, tank line |
| actuator | | leakage, damping, dry_friction, cushion, gear, bending | stop, elastic | joint |
| links | joint, external | | kinetic and potential energy | |
"""

from typing import NamedTuple

from forest_description.types import Vec3
from forest_sim.equations.drive import NO_POWER, DrivePower, drive_power, driven
from forest_sim.equations.elastic_links import NO_BENDING, BendingPower, bending_power
from forest_sim.equations.plant import (
    AxisState,
    PlantState,
    Transmission,
    at_joints,
    axis_draw,
    joint_torque,
    motor_side,
    sides,
    state_derivative,
    transmissions,
)
from forest_sim.equations.plant_parameters import Axis, PlantParameters
from forest_sim.equations.valve_ports import Ports
from forest_sim.hydraulics.actuator import inlet_flow, outlet_flow, port_pressures
from forest_sim.hydraulics.hydraulic_line import PortGuard, guard_flow
from forest_sim.hydraulics.load_holding import holding_drop, is_held
from forest_sim.hydraulics.oil_volume import filled_share, hose_drop
from forest_sim.hydraulics.port import Port, edge_flows, is_shut, port_pressure
from forest_sim.hydraulics.pump_drive import engine_torque
from forest_sim.hydraulics.side import Side, is_torn, side_rates, storage
from forest_sim.hydraulics.supply import flow_at, manifold_capacitance
from forest_sim.hydraulics.tank_line import line_flow
from forest_sim.mechanics.end_stop import cushion_resistance, end_stop_force
from forest_sim.mechanics.friction import friction_force
from forest_sim.mechanics.manipulator import Pair
from forest_sim.midpoint.tank_step import tank_flow
from forest_sim.solver.integrator import WEIGHTS, Simulation, ports_of

Sides = tuple[Side, Side]
RIGID = (NO_BENDING, NO_BENDING, NO_BENDING)


class SupplyPower(NamedTuple):
    """The pump and its manifold [W]."""

    engine: float  # taken from the shaft
    pump_friction: float
    pump_leakage: float
    main_relief: float
    manifold: float  # stored
    supply: float  # handed to the axes
    flywheel: float = 0.0  # stored in engine and pumps as they turn
    return_line: float = 0.0  # lost in filter and tank line
    tank_line: float = 0.0  # stored before them


IDEAL = SupplyPower(
    engine=0.0, pump_friction=0.0, pump_leakage=0.0, main_relief=0.0, manifold=0.0, supply=0.0
)
"""Of a supply without pump."""


class AxisPower(NamedTuple):
    """One axis from its valve to its joint [W]."""

    supply: float  # drawn from the manifold
    throttling: float  # lost in the valve's edges and its compensator, leakage past them included
    inlets: float  # handed to the hoses
    hose: float  # stored in inertances, hoses and chambers
    compression: float  # of the oil in chambers, given back where it leaves; 0 without chambers
    port_valves: float  # lost over relief and anti-cavitation valves
    resistance: float  # lost in the hoses
    holding: float  # lost in load-holding valves
    leakage: float  # lost inside the motor, where vapour collapses too, and to its case drain
    damping: float  # lost to viscous friction
    dry_friction: float
    cushion: float
    stop: float  # stored and lost in the end stop
    joint: float  # handed to the joint
    gear: float  # lost between the teeth of a gear with play
    elastic: float  # stored in motor, teeth and the bristles of a bearing that sticks; in links that give way
    returned: float  # handed to the tank line by the valve's edges
    relieved: float  # handed to it by port valves, less what they take from it
    bending: float  # lost in links that give way


class PowerFlows(NamedTuple):
    """The whole machine [W]."""

    pump: SupplyPower
    swing: AxisPower
    boom: AxisPower
    stick: AxisPower


def power_flows(simulation: Simulation, p: PlantParameters) -> PowerFlows:
    """Return where the power goes at a state. Thesis section 2.2, fig. 2.3."""
    state, ports = simulation.plant, ports_of(simulation, p)
    joints = at_joints(state, p)
    t_1, t_2, t_3 = transmissions(joints.swing.angle, joints.boom.angle, joints.stick.angle, p)
    pressure = state.supply.pressure
    motor, drive, bending = motor_side(joints, p), NO_POWER, RIGID
    if p.drive.present:
        torque = joint_torque(motor, t_1, p.swing)
        drive = drive_power(state.drive, joints.swing.angle, joints.swing.rate, torque, p.drive)
    if p.elastic.present:
        bending = _bending(state, motor, (t_1, t_2, t_3), p)
    swing = _axis_power(motor, t_1, ports[0], pressure, p.swing, drive, bending[0], p)
    boom = _axis_power(joints.boom, t_2, ports[1], pressure, p.boom, NO_POWER, bending[1], p)
    stick = _axis_power(joints.stick, t_3, ports[2], pressure, p.stick, NO_POWER, bending[2], p)
    return PowerFlows(_supply_power(simulation, (swing, boom, stick), ports, p), swing, boom, stick)


def _supply_power(
    simulation: Simulation,
    axes: tuple[AxisPower, AxisPower, AxisPower],
    ports: tuple[Ports, Ports, Ports],
    p: PlantParameters,
) -> SupplyPower:
    """Return the power of pump, manifold and tank line."""
    swing, boom, stick = axes
    state = simulation.plant
    pressure = state.supply.pressure
    drawn = swing.supply + boom.supply + stick.supply
    seen = simulation.midpoint.tank.seen
    lost = seen * line_flow(seen, p.tank_line)
    taken_up = swing.returned + boom.returned + stick.returned - lost
    taken_up += swing.relieved + boom.relieved + stick.relieved
    if p.supply.ideal:
        return IDEAL._replace(engine=drawn, supply=drawn, return_line=lost, tank_line=taken_up)
    pump = flow_at(state.supply, state.pump, p.supply)
    hydraulic = pressure * pump.displaced
    engine = hydraulic / p.supply.efficiency
    if hydraulic < 0.0 and p.supply.volume > 0.0:  # the oil drives the pump, and its friction stays a loss
        engine = hydraulic * p.supply.efficiency
    leakage = p.supply.leakage * pressure
    rates = state_derivative(state, ports, p)
    rate, shaft, flywheel = rates.supply.pressure, engine, 0.0
    if p.supply.drive.inertia > 0.0:
        engine = engine_torque(state.pump.speed, p.supply.drive) * state.pump.speed
        flywheel = p.supply.drive.inertia * state.pump.speed * rates.pump.speed
    return SupplyPower(
        engine=engine,
        pump_friction=shaft - hydraulic,
        pump_leakage=pressure * leakage,
        main_relief=pressure * (pump.displaced - leakage - pump.delivered),
        manifold=manifold_capacitance(pressure, p.supply) * pressure * rate,
        supply=drawn,
        flywheel=flywheel,
        return_line=lost,
        tank_line=taken_up,
    )


def stopped_energy(
    before: PlantState, early: Simulation, late: Simulation, h: float, p: PlantParameters
) -> Vec3:
    """Return the energy [J] of oil in the hoses of each axis that a valve stops at once within a step.

    No power carries it away. A valve that shuts on a flow stops all of it, I Q^2/2. Behind a torn
    column it stops more than dQ/dt tells: I Q dQ/dt lacks it.

    Args:
        before: the plant at the step's beginning.
        early: the machine at the first stage.
        late: the machine at the step's end.
        h: the step [s].
        p: the machine's parameters.
    """
    a, b = _all_sides(early, p), _all_sides(late, p)
    supplies = early.plant.supply.pressure, late.plant.supply.pressure
    return (
        _stopped(before.swing, a[0], b[0], supplies, h, p.guard),
        _stopped(before.boom, a[1], b[1], supplies, h, p.guard),
        _stopped(before.stick, a[2], b[2], supplies, h, p.guard),
    )


def _all_sides(simulation: Simulation, p: PlantParameters) -> tuple[Sides, Sides, Sides]:
    """Return both sides of every axis."""
    ports, joints = ports_of(simulation, p), at_joints(simulation.plant, p)
    t = transmissions(joints.swing.angle, joints.boom.angle, joints.stick.angle, p)
    return (
        sides(motor_side(joints, p), t[0], ports[0], p.swing),
        sides(joints.boom, t[1], ports[1], p.boom),
        sides(joints.stick, t[2], ports[2], p.stick),
    )


def _stopped(
    before: AxisState, early: Sides, late: Sides, supplies: Pair, h: float, guard: PortGuard
) -> float:
    one = _stopped_in(before.flow_1, early[0], late[0], supplies, h, guard)
    return one + _stopped_in(-before.flow_2, early[1], late[1], supplies, h, guard)


def _stopped_in(before: float, early: Side, late: Side, supplies: Pair, h: float, guard: PortGuard) -> float:
    """Return what one hose loses [J] beside what its powers tell."""
    inertance = early.line.inertance
    if early.flow == 0.0:
        return 0.5 * inertance * before * before
    if not (is_torn(early, supplies[0]) or is_torn(late, supplies[1])):
        return 0.0
    told = WEIGHTS[0] * early.flow * side_rates(early, supplies[0], guard).flow
    told += WEIGHTS[1] * late.flow * side_rates(late, supplies[1], guard).flow
    return inertance * (0.5 * (before * before - late.flow * late.flow) + h * told)


def _bending(
    state: PlantState,
    motor: AxisState,
    t: tuple[Transmission, Transmission, Transmission],
    p: PlantParameters,
) -> tuple[BendingPower, BendingPower, BendingPower]:
    """Return what elastic links take of their actuators' powers, the motor's with its own angle."""
    joints, roots = at_joints(state, p), state.roots
    torque = joint_torque(motor, t[0], p.swing)
    if p.drive.present:
        torque = driven(state.drive, joints.swing.angle, joints.swing.rate, torque, p.drive).torque
    bends, lifts = joint_torque(joints.boom, t[1], p.boom), joint_torque(joints.stick, t[2], p.stick)
    return (
        bending_power(roots.swing, state.swing.angle, state.swing.rate, torque, p.elastic.swing),
        bending_power(roots.boom, state.boom.angle, state.boom.rate, bends, p.elastic.boom),
        bending_power(roots.stick, state.stick.angle, state.stick.rate, lifts, p.elastic.stick),
    )


def _axis_power(
    s: AxisState,
    t: Transmission,
    ports: Ports,
    supply: float,
    axis: Axis,
    drive: DrivePower,
    bending: BendingPower,
    p: PlantParameters,
) -> AxisPower:
    a, u = axis.actuator, t.arm * s.rate
    through = u * filled_share(u, s.pressure_1, s.pressure_2, axis.oil_1)
    q_1 = inlet_flow(through, s.pressure_1, s.pressure_2, a)
    q_2 = outlet_flow(through, s.pressure_1, s.pressure_2, a)
    unfilled = (through - u) * (a.displacement_1 * s.pressure_1 - a.displacement_2 * s.pressure_2)
    p_1, p_2 = port_pressures(u, s.pressure_1, s.pressure_2, a)
    lost_1, in_1 = _valve(s.pressure_1, s.flow_1, ports.port_1, supply)
    lost_2, in_2 = _valve(s.pressure_2, -s.flow_2, ports.port_2, supply)
    one, two = sides(s, t, ports, axis)
    taken_up_1, taken_up_2 = storage(one, supply, p.guard), storage(two, supply, p.guard)
    drop_1, drop_2 = hose_drop(one.flow, axis.oil_1), hose_drop(two.flow, axis.oil_2)
    tank = ports.port_1.tank
    above_1, above_2 = s.pressure_1 - tank, s.pressure_2 - tank
    guarded_1, guarded_2 = guard_flow(above_1, p.guard), guard_flow(above_2, p.guard)
    to_tank = tank_flow(s.pressure_1, s.flow_1, ports.port_1, supply)
    to_tank += tank_flow(s.pressure_2, -s.flow_2, ports.port_2, supply)
    return AxisPower(
        supply=supply * axis_draw(s, ports, supply).flow,
        throttling=lost_1 + lost_2,
        inlets=in_1 + in_2,
        hose=taken_up_1.stored + taken_up_2.stored,
        compression=taken_up_1.compression + taken_up_2.compression,
        port_valves=-above_1 * guarded_1 - above_2 * guarded_2,
        resistance=(s.pressure_1 - p_1) * q_1
        + (p_2 - s.pressure_2) * q_2
        + (drop_1 * one.flow + drop_2 * two.flow),
        holding=_holding(one) + _holding(two),
        leakage=a.internal_leakage * ((p_1 - p_2) * (p_1 - p_2))
        + a.external_leakage * (p_1 * p_1 + p_2 * p_2)
        + unfilled,
        damping=a.damping * u * u,
        dry_friction=friction_force(u, axis.friction, s.pressure_1, s.pressure_2) * u + drive.friction,
        cushion=cushion_resistance(t.position, u, axis.cushion) * abs(u) * u * u,
        stop=-end_stop_force(t.position, u, axis.stop) * u + drive.stop,
        joint=joint_torque(s, t, axis) * s.rate
        - drive.friction
        - drive.gear
        - drive.elastic
        - drive.stop
        - bending.lost
        - bending.elastic,
        gear=drive.gear,
        elastic=drive.elastic + bending.elastic,
        returned=tank * to_tank,
        relieved=-tank * (guarded_1 + guarded_2),
        bending=bending.lost,
    )


def _holding(s: Side) -> float:
    """Return what a side's load-holding valve loses [W]: nothing of a flow that stops behind a shut one."""
    return 0.0 if is_held(s.flow, s.holding) else holding_drop(s.flow, s.holding) * s.flow


def _valve(pressure: float, flow: float, port: Port, supply: float) -> tuple[float, float]:
    """Return what a port's edges lose and what it hands to its hose [W]."""
    if is_shut(port):
        return 0.0, 0.0
    p = port_pressure(pressure, flow, port, supply)
    from_supply, to_tank = edge_flows(flow, p, port, supply)
    return (supply - p) * from_supply + (p - port.tank) * to_tank, p * flow
