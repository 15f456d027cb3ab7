"""The machine's equations of motion, Thesis eq. 3.20 and App. B, for both directions of every valve.

State, in Appendix B's order, for swing, boom and stick in turn: joint angle [rad], joint rate
[rad/s], pressure in hose 1 and in hose 2 [Pa], flow through hose 1 from the valve and through hose
2 to the valve [m^3/s]. A real pump adds the pressure in its manifold, one that takes time or droops
its `pump`, a hanging head its two angles and their rates, a swing whose gear has play or whose
bearing sticks what `drive` has, links that give way their `roots`. An axis then has the angle and
rate of its link.

Pressures are above the tank's; `Port.tank` is that of a line to it. Actuator coordinates are the
swing angle and the two cylinders' lengths. What the valves connect is given (`valve_ports`).

The laws of the parts live in `hydraulics` and `mechanics`, their combinations in `drive`,
`elastic_links` and `multibody`; here they are put together. Everything in this module is pure and
stays in the subset of Python that `translate` makes machine code of.
"""

import math
from typing import NamedTuple

from forest_description.geometry.linkage import Linkage, length_and_arm
from forest_description.types import Vec3
from forest_sim.equations.drive import AT_REST, DriveState, driven
from forest_sim.equations.elastic_links import RIGID_ROOTS, Roots, RootState, bent
from forest_sim.equations.multibody import HeadState, Mechanics, mechanics, solve
from forest_sim.equations.plant_parameters import Axis, PlantParameters
from forest_sim.equations.valve_ports import Ports
from forest_sim.hydraulics.actuator import actuator_force, inlet_flow, outlet_flow
from forest_sim.hydraulics.load_holding import restriction
from forest_sim.hydraulics.oil_volume import filled_share
from forest_sim.hydraulics.port import Port, edge_flows, is_shut, port_pressure
from forest_sim.hydraulics.pump_drive import UNDRIVEN, PumpState, engine_torque, stroke_rate
from forest_sim.hydraulics.side import Side, side_rates
from forest_sim.hydraulics.supply import (
    SupplyState,
    asked_stroke,
    flow_at,
    manifold_capacitance,
    pump_torque,
    reference_rate,
)
from forest_sim.mechanics.elasticity import ElasticLink
from forest_sim.mechanics.end_stop import cushion_resistance, end_stop_force
from forest_sim.mechanics.friction import friction_force
from forest_sim.mechanics.manipulator import Pair


class AxisState(NamedTuple):
    """One axis in Appendix B's order; also holds its time derivative."""

    angle: float
    rate: float
    pressure_1: float
    pressure_2: float
    flow_1: float
    flow_2: float


class PlantState(NamedTuple):
    """The 18 states of Thesis eq. 3.20, and those of pump, head, swing's drive and links' roots."""

    swing: AxisState
    boom: AxisState
    stick: AxisState
    supply: SupplyState
    head: HeadState
    drive: DriveState = AT_REST
    pump: PumpState = UNDRIVEN
    roots: Roots = RIGID_ROOTS

    @property
    def axes(self) -> tuple[AxisState, AxisState, AxisState]:
        """The axes in the order of `AXES`."""
        return (self.swing, self.boom, self.stick)


class Draw(NamedTuple):
    """What one axis, or all of them, ask of the supply."""

    flow: float  # [m^3/s]
    load: float  # greatest pressure at a port that is open to the supply [Pa], 0 if none is


class Transmission(NamedTuple):
    """An actuator's position and the joint's lever arm about it."""

    position: float  # [rad; m]
    arm: float  # d(position)/d(angle) [1; m/rad]


def transmissions(
    swing: float, boom: float, stick: float, p: PlantParameters
) -> tuple[Transmission, Transmission, Transmission]:
    """Return actuator positions and lever arms at the joint angles [rad]. Thesis eq. 3.16, App. A."""
    return Transmission(swing, 1.0), _cylinder(boom, p.boom_linkage), _cylinder(stick, p.stick_linkage)


def _cylinder(angle: float, linkage: Linkage) -> Transmission:
    # From the angle's cosine and sine, which the dynamics need as well: compiled, they are taken once.
    length, arm = length_and_arm(math.cos(angle), math.sin(angle), linkage)
    return Transmission(length, arm)


def joint_torque(state: AxisState, transmission: Transmission, axis: Axis) -> float:
    """Return the torque [N m] of an axis' actuator and end stop on its joint. Thesis eq. 3.16, 3.18, 3.19."""
    speed = transmission.arm * state.rate
    force = actuator_force(speed, state.pressure_1, state.pressure_2, axis.actuator)
    friction = friction_force(speed, axis.friction, state.pressure_1, state.pressure_2)
    return transmission.arm * (force + passive_force(transmission.position, speed, friction, axis))


def passive_force(position: float, speed: float, friction: float, axis: Axis) -> float:
    """Return what dry friction, cushion and end stop do to the load [N; N m].

    Args:
        position: of the actuator [rad; m].
        speed: of the actuator [rad/s; m/s].
        friction: dry, at that speed [N; N m].
        axis: its constants.
    """
    braking = cushion_resistance(position, speed, axis.cushion) * abs(speed) * speed
    return end_stop_force(position, speed, axis.stop) - braking - friction


def accelerations(m: Mechanics, torques: Vec3) -> tuple[Vec3, Pair]:
    """Return M^-1 (tau - V - G) of the joints and of the hanging head [rad/s^2]. Thesis eq. 3.15, 4.11."""
    b = m.bias
    driving = torques[0] - b[0], torques[1] - b[1], torques[2] - b[2]
    return solve(m.inertia, driving, (-m.head_bias[0], -m.head_bias[1]))


def state_derivative(state: PlantState, ports: tuple[Ports, Ports, Ports], p: PlantParameters) -> PlantState:
    """Return the time derivative of all states. Thesis eq. 3.20, App. B.

    A shut orifice (C_R = inf) has a derivative only at zero flow; the integrator holds it there.
    """
    joints = at_joints(state, p)
    swing, boom, stick = motor_side(joints, p), joints.boom, joints.stick
    joint = joints.swing.angle, joints.swing.rate
    t_1, t_2, t_3 = transmissions(joint[0], boom.angle, stick.angle, p)
    angles = state.swing.angle, state.boom.angle, state.stick.angle
    rates = state.swing.rate, state.boom.rate, state.stick.rate
    torques, drive = (
        (
            joint_torque(swing, t_1, p.swing),
            joint_torque(boom, t_2, p.boom),
            joint_torque(stick, t_3, p.stick),
        ),
        AT_REST,
    )
    if p.drive.present:
        swung = driven(state.drive, joint[0], joint[1], torques[0], p.drive)
        torques, drive = (swung.torque, torques[1], torques[2]), swung.rates
    roots = RIGID_ROOTS
    if p.elastic.present:
        torques, roots = bent(state.roots, angles, rates, torques, p.elastic)
    (a_1, a_2, a_3), (a_alpha, a_beta) = accelerations(mechanics(angles, rates, state.head, p), torques)
    return PlantState(
        swing=with_joint(
            _axis_derivative(swing, a_1, t_1, ports[0], state.supply.pressure, p.swing, p), rates[0], a_1
        ),
        boom=with_joint(
            _axis_derivative(boom, a_2, t_2, ports[1], state.supply.pressure, p.boom, p), rates[1], a_2
        ),
        stick=with_joint(
            _axis_derivative(stick, a_3, t_3, ports[2], state.supply.pressure, p.stick, p), rates[2], a_3
        ),
        supply=_supply_derivative(state, ports, p),
        head=HeadState(state.head.alpha_rate, state.head.beta_rate, a_alpha, a_beta),
        drive=drive,
        pump=pump_derivative(state, p),
        roots=roots,
    )


def at_joints(state: PlantState, p: PlantParameters) -> PlantState:
    """Return the machine as actuators and sensors have it: with the motion of elastic links' roots."""
    if p.elastic.present == 0:
        return state
    roots, e = state.roots, p.elastic
    return PlantState(
        swing=_at_root(state.swing, roots.swing, e.swing),
        boom=_at_root(state.boom, roots.boom, e.boom),
        stick=_at_root(state.stick, roots.stick, e.stick),
        supply=state.supply,
        head=state.head,
        drive=state.drive,
        pump=state.pump,
        roots=roots,
    )


def _at_root(s: AxisState, root: RootState, link: ElasticLink) -> AxisState:
    return s if link.inertia == 0.0 else with_joint(s, root.angle, root.rate)


def motor_side(state: PlantState, p: PlantParameters) -> AxisState:
    """Return the swing as its motor has it: behind a gear with play, with the motor's angle and rate.

    Args:
        state: `at_joints`.
        p: the machine.
    """
    if p.drive.gear.inertia == 0.0:
        return state.swing
    return with_joint(state.swing, state.drive.motor_angle, state.drive.motor_rate)


def with_joint(s: AxisState, angle: float, rate: float) -> AxisState:
    """Return an axis with another angle and rate."""
    return AxisState(
        angle=angle,
        rate=rate,
        pressure_1=s.pressure_1,
        pressure_2=s.pressure_2,
        flow_1=s.flow_1,
        flow_2=s.flow_2,
    )


def _axis_derivative(
    s: AxisState,
    acceleration: float,
    t: Transmission,
    ports: Ports,
    supply: float,
    axis: Axis,
    p: PlantParameters,
) -> AxisState:
    """Return one axis' six derivatives. Hose 2 is counted towards the valve, hence the signs."""
    side_1, side_2 = sides(s, t, ports, axis)
    one, two = side_rates(side_1, supply, p.guard), side_rates(side_2, supply, p.guard)
    return AxisState(
        angle=s.rate,
        rate=acceleration,
        pressure_1=one.pressure,
        pressure_2=two.pressure,
        flow_1=one.flow,
        flow_2=-two.flow,
    )


def sides(s: AxisState, t: Transmission, ports: Ports, axis: Axis) -> tuple[Side, Side]:
    """Return both sides of an axis. Hose 2 is counted towards the valve, hence the signs."""
    speed = t.arm * s.rate
    through = speed * filled_share(speed, s.pressure_1, s.pressure_2, axis.oil_1)
    q_1 = inlet_flow(through, s.pressure_1, s.pressure_2, axis.actuator)
    q_2 = outlet_flow(through, s.pressure_1, s.pressure_2, axis.actuator)
    held_1, held_2 = (
        restriction(ports.lifts.one, axis.holding_1),
        restriction(ports.lifts.two, axis.holding_2),
    )
    line_1, line_2 = axis.line_1, axis.line_2
    return (
        Side(s.pressure_1, s.flow_1, q_1, t.position, speed, ports.port_1, line_1, axis.oil_1, held_1),
        Side(s.pressure_2, -s.flow_2, -q_2, t.position, speed, ports.port_2, line_2, axis.oil_2, held_2),
    )


def _supply_derivative(
    state: PlantState, ports: tuple[Ports, Ports, Ports], p: PlantParameters
) -> SupplyState:
    """Return the manifold's and the pump control's derivatives. Thesis section 3.2.1."""
    if p.supply.ideal:
        return SupplyState(0.0, 0.0)
    pressure, reference = state.supply
    draw = supply_draw(state, ports)
    delivered = flow_at(state.supply, state.pump, p.supply).delivered
    return SupplyState(
        (delivered - draw.flow) / manifold_capacitance(pressure, p.supply),
        reference_rate(reference, draw.load, p.supply),
    )


def pump_derivative(state: PlantState, p: PlantParameters) -> PumpState:
    """Return the derivatives of swash plate [1/s] and engine [rad/s^2]; one at rest stays so."""
    d, pump = p.supply.drive, state.pump
    if d.present == 0:
        return UNDRIVEN
    asked, turning = asked_stroke(state.supply, p.supply).value, 0.0
    if d.inertia > 0.0 and pump.speed > 0.0:
        stroke = pump.stroke if d.up > 0.0 else asked
        load = pump_torque(stroke, state.supply.pressure, p.supply)
        turning = (engine_torque(pump.speed, d) - load) / d.inertia
    return PumpState(stroke_rate(pump.stroke, asked, d), turning)


def supply_draw(state: PlantState, ports: tuple[Ports, Ports, Ports]) -> Draw:
    """Return what the three axes together draw from the supply, and the greatest load that it feels."""
    swing = axis_draw(state.swing, ports[0], state.supply.pressure)
    boom = axis_draw(state.boom, ports[1], state.supply.pressure)
    stick = axis_draw(state.stick, ports[2], state.supply.pressure)
    return Draw(swing.flow + boom.flow + stick.flow, max(swing.load, boom.load, stick.load))


def axis_draw(s: AxisState, ports: Ports, supply: float) -> Draw:
    """Return what one axis draws from the supply, and the load that it shows there."""
    one = _port_draw(s.pressure_1, s.flow_1, ports.port_1, supply)
    two = _port_draw(s.pressure_2, -s.flow_2, ports.port_2, supply)
    return Draw(one.flow + two.flow, max(one.load, two.load))


def _port_draw(pressure: float, flow: float, port: Port, supply: float) -> Draw:
    if is_shut(port):
        return Draw(0.0, 0.0)
    p = port_pressure(pressure, flow, port, supply)
    return Draw(edge_flows(flow, p, port, supply)[0], sensed_load(p, port))


def sensed_load(pressure: float, port: Port) -> float:
    """Return what a load-sensing line takes from a port [Pa]: its pressure while open to the supply."""
    return pressure if port.to_supply < math.inf else 0.0
