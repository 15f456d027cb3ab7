"""Where the power goes: from the engine's shaft through pump, valves and hoses to the links.

Every entry is a power at one state [W], positive in the direction that its name says. The entries
of a part
close: what flows in equals what is lost, stored and handed on. That they do is a test of the laws'
signs, and their integrals over a run are its energy account.

| part | flows in | lost | stored | handed on |
|---|---|---|---|---|
| pump | engine | pump_friction, pump_leakage, main_relief | manifold | supply |
| valve | supply | throttling | | hose inlets |
| hose | its inlet | port_valves, resistance, holding, compression | hose | actuator |
| actuator | | leakage, damping, dry_friction, cushion, gear | stop, elastic | joint |
| links | joint, external | | kinetic and potential energy | |
"""

from typing import NamedTuple

from forest_sim.equations.drive import NO_POWER, DrivePower, drive_power
from forest_sim.equations.plant import (
    AxisState,
    Ports,
    Transmission,
    axis_draw,
    joint_torque,
    motor_side,
    ports_at,
    sides,
    state_derivative,
    transmissions,
)
from forest_sim.equations.plant_parameters import Axis, PlantParameters
from forest_sim.hydraulics.actuator import inlet_flow, outlet_flow, port_pressures
from forest_sim.hydraulics.hydraulic_line import guard_flow
from forest_sim.hydraulics.load_holding import holding_drop
from forest_sim.hydraulics.oil_volume import hose_drop
from forest_sim.hydraulics.port import Port, edge_flows, is_shut, port_pressure
from forest_sim.hydraulics.side import storage
from forest_sim.hydraulics.supply import manifold_capacitance, pump_flow
from forest_sim.mechanics.end_stop import cushion_resistance, end_stop_force
from forest_sim.mechanics.friction import friction_force
from forest_sim.solver.integrator import Simulation


class SupplyPower(NamedTuple):
    """The pump and its manifold [W]."""

    engine: float  # taken from the shaft
    pump_friction: float
    pump_leakage: float
    main_relief: float
    manifold: float  # stored
    supply: float  # handed to the axes


class AxisPower(NamedTuple):
    """One axis from its valve to its joint [W]."""

    supply: float  # drawn from the manifold
    throttling: float  # lost in the valve's edges, leakage past them included
    inlets: float  # handed to the hoses
    hose: float  # stored in inertances, hoses and chambers
    compression: float  # of the oil in chambers, given back where it leaves; 0 without chambers
    port_valves: float  # lost over relief and anti-cavitation valves
    resistance: float  # lost in the hoses
    holding: float  # lost in load-holding valves
    leakage: float  # lost inside the motor and to its case drain
    damping: float  # lost to viscous friction
    dry_friction: float
    cushion: float
    stop: float  # stored and lost in the end stop
    joint: float  # handed to the joint
    gear: float  # lost between the teeth of a gear with play
    elastic: float  # stored in motor, teeth and the bristles of a bearing that sticks


class PowerFlows(NamedTuple):
    """The whole machine [W]."""

    pump: SupplyPower
    swing: AxisPower
    boom: AxisPower
    stick: AxisPower


def power_flows(simulation: Simulation, p: PlantParameters) -> PowerFlows:
    """Return where the power goes at a state. Thesis section 2.2, fig. 2.3."""
    state, ports = simulation.plant, ports_at(simulation.spools, p, simulation.lifts)
    t_1, t_2, t_3 = transmissions(state.swing.angle, state.boom.angle, state.stick.angle, p)
    pressure = state.supply.pressure
    motor, drive = motor_side(state, p), NO_POWER
    if p.drive.present:
        torque = joint_torque(motor, t_1, p.swing)
        drive = drive_power(state.drive, state.swing.angle, state.swing.rate, torque, p.drive)
    swing = _axis_power(motor, t_1, ports[0], pressure, p.swing, drive, p)
    boom = _axis_power(state.boom, t_2, ports[1], pressure, p.boom, NO_POWER, p)
    stick = _axis_power(state.stick, t_3, ports[2], pressure, p.stick, NO_POWER, p)
    drawn = swing.supply + boom.supply + stick.supply
    if p.supply.ideal:
        return PowerFlows(
            SupplyPower(
                engine=drawn, pump_friction=0.0, pump_leakage=0.0, main_relief=0.0, manifold=0.0, supply=drawn
            ),
            swing,
            boom,
            stick,
        )
    pump = pump_flow(pressure, state.supply.reference, p.supply)
    hydraulic = pressure * pump.displaced
    engine = hydraulic / p.supply.efficiency
    if hydraulic < 0.0 and p.supply.volume > 0.0:  # the oil drives the pump, and its friction stays a loss
        engine = hydraulic * p.supply.efficiency
    leakage = p.supply.leakage * pressure
    rate = state_derivative(state, ports, p).supply.pressure
    return PowerFlows(
        SupplyPower(
            engine=engine,
            pump_friction=engine - hydraulic,
            pump_leakage=pressure * leakage,
            main_relief=pressure * (pump.displaced - leakage - pump.delivered),
            manifold=manifold_capacitance(pressure, p.supply) * pressure * rate,
            supply=drawn,
        ),
        swing,
        boom,
        stick,
    )


def _axis_power(
    s: AxisState,
    t: Transmission,
    ports: Ports,
    supply: float,
    axis: Axis,
    drive: DrivePower,
    p: PlantParameters,
) -> AxisPower:
    a, u = axis.actuator, t.arm * s.rate
    q_1 = inlet_flow(u, s.pressure_1, s.pressure_2, a)
    q_2 = outlet_flow(u, s.pressure_1, s.pressure_2, a)
    p_1, p_2 = port_pressures(u, s.pressure_1, s.pressure_2, a)
    lost_1, in_1 = _valve(s.pressure_1, s.flow_1, ports.port_1, supply)
    lost_2, in_2 = _valve(s.pressure_2, -s.flow_2, ports.port_2, supply)
    one, two = sides(s, t, ports, axis)
    taken_up_1, taken_up_2 = storage(one, supply, p.guard), storage(two, supply, p.guard)
    drop_1, drop_2 = hose_drop(one.flow, axis.oil_1), hose_drop(two.flow, axis.oil_2)
    return AxisPower(
        supply=supply * axis_draw(s, ports, supply).flow,
        throttling=lost_1 + lost_2,
        inlets=in_1 + in_2,
        hose=taken_up_1.stored + taken_up_2.stored,
        compression=taken_up_1.compression + taken_up_2.compression,
        port_valves=-s.pressure_1 * guard_flow(s.pressure_1, p.guard)
        - s.pressure_2 * guard_flow(s.pressure_2, p.guard),
        resistance=(s.pressure_1 - p_1) * q_1
        + (p_2 - s.pressure_2) * q_2
        + (drop_1 * one.flow + drop_2 * two.flow),
        holding=holding_drop(one.flow, one.held) * one.flow + holding_drop(two.flow, two.held) * two.flow,
        leakage=a.internal_leakage * ((p_1 - p_2) * (p_1 - p_2))
        + a.external_leakage * (p_1 * p_1 + p_2 * p_2),
        damping=a.damping * u * u,
        dry_friction=friction_force(u, axis.friction, s.pressure_1, s.pressure_2) * u + drive.friction,
        cushion=cushion_resistance(t.position, u, axis.cushion) * abs(u) * u * u,
        stop=-end_stop_force(t.position, u, axis.stop) * u + drive.stop,
        joint=joint_torque(s, t, axis) * s.rate - drive.friction - drive.gear - drive.elastic - drive.stop,
        gear=drive.gear,
        elastic=drive.elastic,
    )


def _valve(pressure: float, flow: float, port: Port, supply: float) -> tuple[float, float]:
    """Return what a port's edges lose and what it hands to its hose [W]."""
    if is_shut(port):
        return 0.0, 0.0
    p = port_pressure(pressure, flow, port, supply)
    from_supply, to_tank = edge_flows(flow, p, port, supply)
    return (supply - p) * from_supply + p * to_tank, p * flow
