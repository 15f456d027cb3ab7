"""Feedforward for boom and stick: what oil and links give way as the load of the motion grows.

A cylinder's piston hangs between two springs of oil, and a link bends. As the torque on a joint grows by dT,
they yield by dT/k each, and the link falls behind by that. So the rate dT/dt/k is added to the command.

| symbol | name | unit |
|---|---|---|
| T | torque on a joint: M b + G | N m |
| M | inertia of boom and stick about their joints, head included | kg m^2 |
| G | torque of gravity | N m |
| b, c | reference acceleration of a joint, its rate of change | rad/s^2, rad/s^3 |
| A, C | piston area and capacitance of hose and chamber on either side | m^2, m^3/Pa |
| k | stiffness: the oil's, (A_1^2/C_1 + A_2^2/C_2) times the lever arm squared; the link's | N m/rad |

Without chambers in the machine's file the oil adds nothing: hoses alone are stiff.
"""

import math
from typing import NamedTuple

from forest_control.valve.valve_driver_parameters import AxisDriver, axis_drivers
from forest_description.derived.actuator_kinematics import Linkages
from forest_description.derived.bodies import bearing_stick, boom_body
from forest_description.geometry.linkage import Linkage, cylinder_length, lever_arm
from forest_description.machine import Machine
from forest_description.mechanics.drives import Friction
from forest_description.mechanics.elasticity_parameters import Elasticity
from forest_description.types import Vec3

Pair = tuple[float, float]


class Seal(NamedTuple):
    """A cylinder's friction F v/sqrt(v^2 + u^2) at a speed v."""

    force: float = 0.0  # F [N]
    speed: float = 1.0  # u [m/s]


class ArmModel(NamedTuple):
    """Constants of boom and stick as loads of their cylinders."""

    boom_inertia: float  # [kg m^2] of boom, and of the stick as a point at the elbow, about the boom's joint
    stick_inertia: float  # [kg m^2] about the elbow
    boom_length: float  # [m]
    stick_length: float  # [m]
    boom_moment: Pair  # [kg m] mass of boom, and of the stick at the elbow, times x, y of its centre
    stick_moment: Pair  # [kg m]
    gravity: float  # [m/s^2]
    boom: AxisDriver
    stick: AxisDriver
    seals: tuple[Seal, Seal]
    linkages: Linkages
    compliance: Pair  # 1/k of the links [rad/(N m)]; 0: rigid


def yielding_rates(q: Vec3, a: Vec3, b: Vec3, c: Vec3, arm: ArmModel) -> Pair:
    """Return the rates [rad/s] to add to the commands of boom and stick.

    Args:
        q: joint angles [rad].
        a: reference rates [rad/s].
        b: their rates of change [rad/s^2].
        c: and those of b [rad/s^3].
        arm: constants.
    """
    boom, stick = torque_rates(q, a, b, c, arm)
    on_boom = boom + friction_rate(q[1], a[1], b[1], arm.seals[0], arm.linkages[0])
    on_stick = stick + friction_rate(q[2], a[2], b[2], arm.seals[1], arm.linkages[1])
    oil_1 = on_boom / stiffness(q[1], arm.boom, arm.linkages[0]) if arm.boom.fills else 0.0
    oil_2 = on_stick / stiffness(q[2], arm.stick, arm.linkages[1]) if arm.stick.fills else 0.0
    return oil_1 + boom * arm.compliance[0], oil_2 + stick * arm.compliance[1]


def torque_rates(q: Vec3, a: Vec3, b: Vec3, c: Vec3, arm: ArmModel) -> Pair:
    """Return how fast the torques on boom and stick change [N m/s]. Thesis eq. 3.15.

    Arguments as `yielding_rates`.

    Differs: torques of joint rates squared, some percent at the rates that are driven, are left out.
    """
    m_22, m_23, m_33 = arm_inertia(q, arm)
    c_3, s_3 = math.cos(q[2]), math.sin(q[2])
    turned = -arm.boom_length * (arm.stick_moment[0] * s_3 + arm.stick_moment[1] * c_3) * a[2]
    c_23, s_23 = math.cos(q[1] + q[2]), math.sin(q[1] + q[2])
    lifted = -arm.gravity * (arm.stick_moment[0] * s_23 + arm.stick_moment[1] * c_23) * (a[1] + a[2])
    raised = arm.boom_moment[0] * math.sin(q[1]) + arm.boom_moment[1] * math.cos(q[1])
    boom = m_22 * c[1] + m_23 * c[2] + turned * (2.0 * b[1] + b[2]) - arm.gravity * raised * a[1] + lifted
    return boom, m_23 * c[1] + m_33 * c[2] + turned * b[1] + lifted


def friction_rate(angle: float, a: float, b: float, seal: Seal, linkage: Linkage) -> float:
    """Return how fast a cylinder's friction changes as a torque on its joint [N m/s]."""
    arm = lever_arm(angle, linkage)
    v, u = arm * a, seal.speed
    slope = u * u / ((v * v + u * u) * math.sqrt(v * v + u * u))
    return arm * seal.force * slope * arm * b


def stiffness(angle: float, axis: AxisDriver, linkage: Linkage) -> float:
    """Return k [N m/rad] of a cylinder's oil at a joint angle [rad]. Merritt, section 6.2."""
    x, arm = cylinder_length(angle, linkage), lever_arm(angle, linkage)
    one = axis.displacement_1 * axis.displacement_1 / (axis.oil_1.fixed + axis.oil_1.growing * x)
    two = axis.displacement_2 * axis.displacement_2 / (axis.oil_2.fixed + axis.oil_2.growing * x)
    return (one + two) * arm * arm


def arm_inertia(q: Vec3, arm: ArmModel) -> Vec3:
    """Return M_22, M_23, M_33 [kg m^2]."""
    coupled = arm.boom_length * (arm.stick_moment[0] * math.cos(q[2]) - arm.stick_moment[1] * math.sin(q[2]))
    return (
        arm.boom_inertia + arm.stick_inertia + 2.0 * coupled,
        arm.stick_inertia + coupled,
        arm.stick_inertia,
    )


def arm_model(machine: Machine) -> ArmModel:
    """Return the constants for a machine."""
    m, axes = machine.manipulator, axis_drivers(machine)
    boom, stick = boom_body(m), bearing_stick(m)
    boom_inertia = boom.zz + boom.mass * (boom.x**2 + boom.y**2)
    return ArmModel(
        boom_inertia=boom_inertia + stick.mass * m.boom_length**2,
        stick_inertia=stick.zz + stick.mass * (stick.x**2 + stick.y**2),
        boom_length=m.boom_length,
        stick_length=m.stick_length,
        boom_moment=(boom.mass * boom.x + stick.mass * m.boom_length, boom.mass * boom.y),
        stick_moment=(stick.mass * stick.x, stick.mass * stick.y),
        gravity=m.gravity,
        boom=axes[1],
        stick=axes[2],
        seals=(_seal(machine, machine.boom.friction), _seal(machine, machine.stick.friction)),
        linkages=machine.linkages,
        compliance=(compliance(machine.boom.elasticity), compliance(machine.stick.elasticity)),
    )


def compliance(link: Elasticity | None) -> float:
    """Return 1/k [rad/(N m)] of a link; 0 where it is rigid."""
    return 0.0 if link is None else 1.0 / link.stiffness


def _seal(machine: Machine, friction: Friction | None) -> Seal:
    """Return a cylinder's friction; the pressures of both chambers together are taken as the supply's."""
    if friction is None:
        return Seal()
    pressed = (friction.pressure_coefficient or 0.0) * machine.pump.supply_pressure
    return Seal(friction.coulomb_force + pressed, friction.smoothing_speed)
