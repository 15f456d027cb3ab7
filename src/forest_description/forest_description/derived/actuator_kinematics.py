"""Between joints and actuators: speeds through the linkages, and the speed scale of an ideal valve.

Symbols:
    P_s     pump pressure [Pa]
    C_R     orifice resistance of the fully open valve [Pa·s²/m⁶], of its port 1 and port 2
    N D_m   oil per swing angle [m³/rad]
    A1, A2  head and rod area [m²]
    D1, D2  what an actuator takes at port 1 and 2: A1 and A2, or N D_m twice
    P_m     margin of a load-sensing pump [Pa]; Q_max greatest flow of the pump [m³/s]
    x, q    cylinder length [m], joint angle [rad]

Actuator speeds are (swing [rad/s], boom cylinder [m/s], stick cylinder [m/s]). The swing's is that
of the joint, behind the gear train, not of the motor shaft. Extending is positive.
"""

import math

from forest_description.geometry.linkage import Linkage, lever_arm
from forest_description.hydraulics.compensator_parameters import CompensatorAfterSpool
from forest_description.hydraulics.pump import LoadSensingPump
from forest_description.machine import Machine
from forest_description.types import Vec3

Linkages = tuple[Linkage, Linkage]
"""Of boom and stick, as ``Machine.linkages``."""


def rated_speeds(machine: Machine) -> Vec3:
    """Return the unloaded actuator speeds of the fully open valve, one axis alone (rad/s, m/s, m/s).

    Hoses, leakage and friction are left out. Both orifices share the pump's P_s: D1 P_1 = D2 P_2
    gives sqrt(D1 P_s / (C_R1 D1³ + C_R2 D2³)). A load-sensing pump keeps P_m over the inlet's
    orifice whatever the outlet's takes: sqrt(P_m/C_R1)/D1. A compensator keeps `metering_drop`
    there. No axis gets more than Q_max. This is the scale of /valve_commands: the rated voltage of
    the ideal valve wishes this speed. Positive direction.

    Thesis eq. 3.1, 3.9, 3.13 at rest of pressures and flows.
    """
    return (_rated_speed(machine, 0), _rated_speed(machine, 1), _rated_speed(machine, 2))


def _rated_speed(machine: Machine, axis: int) -> float:
    d_1, d_2 = displacements(machine, axis)
    pump, way = machine.pump, machine.valve_of(axis).law.forward
    drop = metering_drop(machine, axis)
    if isinstance(pump, LoadSensingPump):
        drop = min(drop, pump.margin)
    if drop < math.inf:
        by_valve = math.sqrt(drop / way.resistance_1) / d_1
    else:
        orifices = way.resistance_1 * d_1**3 + way.resistance_2 * d_2**3
        by_valve = math.sqrt(d_1 * pump.supply_pressure / orifices)
    return min(by_valve, pump.flow_limit / d_1)


def metering_drop(machine: Machine, axis: int) -> float:
    """Return the drop [Pa] that a compensator keeps over the edge to the pump, half open; inf without one."""
    compensator = machine.valve_of(axis).compensator
    if compensator is None:
        return math.inf
    kept = compensator.setting - 0.5 * compensator.control_range
    if isinstance(compensator, CompensatorAfterSpool):
        assert isinstance(machine.pump, LoadSensingPump)  # `Machine` saw to it
        kept = machine.pump.margin - compensator.setting - 0.5 * compensator.control_range
    return kept


def displacements(machine: Machine, axis: int) -> tuple[float, float]:
    """Return what an actuator takes at port 1 and 2 per motion of its own [m³/rad, swing; m²]."""
    if axis == 0:
        oil_per_angle = machine.swing.gear_ratio * machine.swing.motor_displacement
        return oil_per_angle, oil_per_angle
    drive = machine.boom if axis == 1 else machine.stick
    return drive.head_area, drive.rod_area


def joint_rates_to_actuator_speeds(q: Vec3, rates: Vec3, linkages: Linkages) -> Vec3:
    """Return the actuator speeds (q̇1, ẋ_boom, ẋ_stick) of joint rates; ẋ = (dx/dq) q̇. Thesis eq. 3.16.

    Args:
        q: Joint angles (swing, boom, stick) [rad].
        rates: Joint rates [rad/s].
        linkages: Of boom and stick.
    """
    return (rates[0], lever_arm(q[1], linkages[0]) * rates[1], lever_arm(q[2], linkages[1]) * rates[2])


def actuator_speeds_to_joint_rates(q: Vec3, speeds: Vec3, linkages: Linkages) -> Vec3:
    """Return the joint rates [rad/s] of actuator speeds, the inverse of ``joint_rates_to_actuator_speeds``.

    At a dead point of a linkage (no lever arm; outside every stroke that a machine file may have)
    the rate is 0.

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
