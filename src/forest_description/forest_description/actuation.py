"""Between joints and actuators: speeds through the linkages, and the speed scale of an ideal valve.

Symbols:
    P_s     pump pressure [Pa]
    C_R     orifice resistance of the fully open valve [Pa·s²/m⁶]
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
from forest_description.machine import CylinderDrive, Machine

Linkages = tuple[Linkage, Linkage]
"""Of boom and stick, as ``Machine.linkages``."""


def rated_speeds(machine: Machine) -> Vector:
    """Return the unloaded actuator speeds of the fully open valve at pump pressure (rad/s, m/s, m/s).

    Both orifices share P_s; hoses, leakage and friction are left out. Swing: P_s = 2 C_R Q², so
    sqrt(P_s / (2 C_R)) / (N D_m). Extending cylinder: A1 P_1 = A2 P_2 gives sqrt(A1 P_s / (C_R (A1³ + A2³))).
    This is the scale of /valve_commands: the rated voltage of the ideal valve wishes this speed.

    Thesis eq. 3.1, 3.9, 3.13 at rest of pressures and flows.
    """
    pressure, resistance = machine.pump.supply_pressure, machine.valve.minimum_resistance
    oil_per_angle = machine.swing.gear_ratio * machine.swing.motor_displacement
    swing = math.sqrt(pressure / (2.0 * resistance)) / oil_per_angle
    return (
        swing,
        _extending_speed(machine.boom, pressure, resistance),
        _extending_speed(machine.stick, pressure, resistance),
    )


def _extending_speed(drive: CylinderDrive, pressure: float, resistance: float) -> float:
    """Return sqrt(A1 P_s / (C_R (A1³ + A2³))) [m/s]."""
    return math.sqrt(drive.head_area * pressure / (resistance * (drive.head_area**3 + drive.rod_area**3)))


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
