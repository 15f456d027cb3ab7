"""Feedforward for the swing: the torque of its motion, and the oil that its hoses take up first.

The swing carries the whole crane on two short hoses: it alone rocks slowly (2.3 Hz), and its load
changes as it speeds up. Boom and stick carry mostly their weight, which the valve driver measures.

| symbol | name | unit |
|---|---|---|
| M_11 | inertia about the swing axis | kg m^2 |
| r_b, r_s | distance of the boom's, stick's centre of mass from the swing axis | m |
| D | oil per swing angle | m^3/rad |
| C_1, C_2 | capacitance of hose and chamber on either side; both are springs of the motor | m^3/Pa |
| w_0 | natural frequency of the crane on this oil, w_0^2 = D^2 (1/C_1 + 1/C_2) / M_11 | rad/s |
| N | pressure drop of both edges of the swing's valve, as a torque | N m |
"""

import math
from typing import NamedTuple

from forest_control.servo.arm_feedforward import compliance
from forest_control.valve.valve_driver_parameters import axis_drivers
from forest_description.derived.bodies import boom_body, stick_body
from forest_description.machine import Machine
from forest_description.types import Vec3


class SwingModel(NamedTuple):
    """Constants of the crane as a load of its swing."""

    base_offset: float  # [m]
    boom_length: float  # [m]
    base_inertia: float  # [kg m^2] about the swing axis
    boom: tuple[float, ...]  # mass, x, y of its centre, I_xx, I_yy, I_zz, I_xy
    stick: tuple[float, ...]  # alike, with what it carries
    damping: float  # [N m s/rad]
    stiffness: float  # of the oil on both sides, D^2 (1/C_1 + 1/C_2) [N m/rad]
    valve_drop: float  # N [N m] of a crane that is not loaded
    compliance: float  # of the column [rad/(N m)]; 0: it does not twist


def inertia(q: Vec3, load: SwingModel) -> float:
    """Return M_11 [kg m^2] at joint angles [rad]. Thesis eq. 3.15."""
    c_2, s_2 = math.cos(q[1]), math.sin(q[1])
    c_23, s_23 = math.cos(q[1] + q[2]), math.sin(q[1] + q[2])
    elbow = load.base_offset + load.boom_length * c_2
    boom = _link_inertia(load.base_offset, c_2, s_2, load.boom)
    return load.base_inertia + boom + _link_inertia(elbow, c_23, s_23, load.stick)


def _link_inertia(offset: float, c: float, s: float, body: tuple[float, ...]) -> float:
    """Return a link's part of M_11; joint `offset` [m] from the axis, c and s of its elevation."""
    mass, x, y, xx, yy, _, xy = body
    r = offset + x * c - y * s
    return mass * r * r + yy * c * c + xx * s * s - 2.0 * xy * s * c


def swing_model(machine: Machine) -> SwingModel:
    """Return the constants for a machine."""
    m, axis = machine.manipulator, axis_drivers(machine)[0]
    oil = axis.displacement_1
    return SwingModel(
        base_offset=m.base_offset,
        boom_length=m.boom_length,
        base_inertia=m.base_zz + m.base_mass * m.base_x**2,
        boom=tuple(boom_body(m)),
        stick=tuple(stick_body(m)),
        damping=machine.swing.damping,
        stiffness=oil * oil / axis.oil_1.fixed + oil * oil / axis.oil_2.fixed,
        # A load-sensing pump leaves its margin for the inlet's edge; the outlet's, alike, takes as much.
        valve_drop=oil * min(machine.pump.supply_pressure, 2.0 * machine.pump.idle_pressure),
        compliance=compliance(machine.swing.elasticity),
    )
