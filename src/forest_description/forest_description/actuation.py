"""Between joints and actuators: speeds through the linkages, and the speed scale of an ideal valve.

Symbols:
    P_s     pump pressure [Pa]
    C_R     orifice resistance of the fully open valve [Pa·s²/m⁶], of its port 1 and port 2
    N D_m   oil per swing angle [m³/rad]
    A1, A2  head and rod area [m²]
    x, q    cylinder length [m], joint angle [rad]

Actuator speeds are (swing [rad/s], boom cylinder [m/s], stick cylinder [m/s]). The swing's is that of the
joint, behind the gear train, not of the motor shaft. Extending is positive.
"""

from __future__ import annotations

import math

from forest_description.kinematics import Vector
from forest_description.linkage import Linkage, lever_arm
from forest_description.machine import Machine

Linkages = tuple[Linkage, Linkage]
"""Of boom and stick, as ``Machine.linkages``."""


def rated_speeds(machine: Machine) -> Vector:
    """Return the unloaded actuator speeds of the fully open valve at pump pressure (rad/s, m/s, m/s).

    Both orifices share P_s; hoses, leakage and friction are left out. At the actuator with displacements D1
    and D2, D1 P_1 = D2 P_2 gives sqrt(D1 P_s / (C_R1 D1³ + C_R2 D2³)); for the swing D1 = D2 = N D_m. This is
    the scale of /valve_commands: the rated voltage of the ideal valve wishes this speed. Positive direction.

    Thesis eq. 3.1, 3.9, 3.13 at rest of pressures and flows.
    """
    swing, boom, stick = (
        math.sqrt(
            d_1 * machine.pump.supply_pressure / (way.resistance_1 * d_1**3 + way.resistance_2 * d_2**3)
        )
        for (d_1, d_2), way in (
            (displacements(machine, axis), machine.valve_of(axis).law.forward) for axis in range(3)
        )
    )
    return (swing, boom, stick)


def displacements(machine: Machine, axis: int) -> tuple[float, float]:
    """Return what an actuator takes at port 1 and 2 per motion of its own [m³/rad, swing; m²]."""
    if axis == 0:
        oil_per_angle = machine.swing.gear_ratio * machine.swing.motor_displacement
        return oil_per_angle, oil_per_angle
    drive = machine.boom if axis == 1 else machine.stick
    return drive.head_area, drive.rod_area


def joint_rates_to_actuator_speeds(q: Vector, rates: Vector, linkages: Linkages) -> Vector:
    """Return the actuator speeds (q̇1, ẋ_boom, ẋ_stick) of joint rates; ẋ = (dx/dq) q̇. Thesis eq. 3.16.

    Args:
        q: Joint angles (swing, boom, stick) [rad].
        rates: Joint rates [rad/s].
        linkages: Of boom and stick.
    """
    return (rates[0], lever_arm(q[1], linkages[0]) * rates[1], lever_arm(q[2], linkages[1]) * rates[2])


def actuator_speeds_to_joint_rates(q: Vector, speeds: Vector, linkages: Linkages) -> Vector:
    """Return the joint rates [rad/s] of actuator speeds, the inverse of ``joint_rates_to_actuator_speeds``.

    At a dead point of a linkage (no lever arm; outside every stroke that a machine file may have) the rate is
    0.

    Thesis eq. 3.16, 3.18, App. A.

    Args:
        q: Joint angles (swing, boom, stick) [rad].
        speeds: Actuator speeds (rad/s, m/s, m/s).
        linkages: Of boom and stick.
    """
    boom_arm, stick_arm = lever_arm(q[1], linkages[0]), lever_arm(q[2], linkages[1])
    boom = speeds[1] / boom_arm if boom_arm != 0.0 else 0.0
    stick = speeds[2] / stick_arm if stick_arm != 0.0 else 0.0
    return (speeds[0], boom, stick)
