"""One law for cylinders and motor: what flows through an actuator and how hard it pushes.

Thesis section 3.2.4, 3.2.5, 3.4, 3.5. Both actuators sit between the two hose capacitances of their axis,
and after their inner nodes are eliminated both obey

    q_1 = d_1 u + g_11 P_1 - g_12 P_2      flow out of hose 1 into the actuator
    q_2 = d_2 u + g_12 P_1 - g_22 P_2      flow out of the actuator into hose 2
    F   = d_1 P_1 - d_2 P_2 - b u - c u|u| force on the load

| symbol | name | unit (cylinder; motor) |
|---|---|---|
| u | actuator speed, extending / turning left positive | m/s; rad/s |
| P_1, P_2 | pressure in the capacitance of hose 1, 2 | Pa |
| d_1, d_2 | displacement of port 1, 2 | m^2; m^3/rad |
| g_.. | leakage conductance | m^3/(s Pa) |
| b, c | linear, quadratic resistance to motion | N s/m, N s^2/m^2; N m s, N m s^2 |
| F | force; torque | N; N m |

Port 1 feeds the piston head (extending) or turns the swing left.
"""

from typing import NamedTuple

from forest_description.machine import CylinderDrive, Line, SwingDrive


class Actuator(NamedTuple):
    """The constants of the law above, and the pressure drops between hose and actuator port."""

    displacement_1: float
    displacement_2: float
    own_displacement_1: float  # of the actuator alone, at its ports: a leaking motor's differs a little
    own_displacement_2: float
    leakage_11: float
    leakage_12: float
    leakage_22: float
    linear_resistance: float
    quadratic_resistance: float
    laminar_drop_1: float  # [Pa s/m^3] of hose 1 between its capacitance and the actuator
    laminar_drop_2: float
    turbulent_drop_1: float  # [Pa s^2/m^6]
    turbulent_drop_2: float


def inlet_flow(speed: float, pressure_1: float, pressure_2: float, a: Actuator) -> float:
    """Return q_1 [m^3/s], the flow out of hose 1 into the actuator.

    Thesis eq. 3.5, 3.11, 3.14, 3.17. Differs: 3.14 and 3.17 print a minus that 3.13 contradicts.
    """
    return a.displacement_1 * speed + a.leakage_11 * pressure_1 - a.leakage_12 * pressure_2


def outlet_flow(speed: float, pressure_1: float, pressure_2: float, a: Actuator) -> float:
    """Return q_2 [m^3/s], the flow out of the actuator into hose 2.

    Thesis eq. 3.5, 3.11, 3.14, 3.17. Differs: 3.14 and 3.17 print a minus that 3.13 contradicts.
    """
    return a.displacement_2 * speed + a.leakage_12 * pressure_1 - a.leakage_22 * pressure_2


def actuator_force(speed: float, pressure_1: float, pressure_2: float, a: Actuator) -> float:
    """Return the force [N] or torque [N m] on the load.

    Thesis eq. 3.8, 3.14, 3.17, 3.19, 4.10. Differs: 3.19 prints the gear ratio upside down.
    """
    friction = (a.linear_resistance + a.quadratic_resistance * abs(speed)) * speed
    return a.displacement_1 * pressure_1 - a.displacement_2 * pressure_2 - friction


def port_pressures(speed: float, pressure_1: float, pressure_2: float, a: Actuator) -> tuple[float, float]:
    """Return the pressures [Pa] at the actuator's own ports, behind the hoses' resistance.

    Thesis eq. 3.8, 3.14. Differs: 3.14 prints a plus in front of the inlet's drop, which would inject
    energy.
    """
    q_1 = inlet_flow(speed, pressure_1, pressure_2, a)
    q_2 = outlet_flow(speed, pressure_1, pressure_2, a)
    return (
        pressure_1 - (a.laminar_drop_1 + a.turbulent_drop_1 * abs(q_1)) * q_1,
        pressure_2 + (a.laminar_drop_2 + a.turbulent_drop_2 * abs(q_2)) * q_2,
    )


def cylinder(drive: CylinderDrive, line_1: Line, line_2: Line) -> Actuator:
    """Return a single-ended cylinder without leakage behind turbulent hoses. Thesis eq. 3.10-3.14, 3.17.

    The hoses' resistance R q|q| at q = A u acts on the piston like a quadratic friction A^3 R u|u|.
    """
    a_1, a_2 = drive.head_area, drive.rod_area
    return Actuator(
        displacement_1=a_1,
        displacement_2=a_2,
        own_displacement_1=a_1,
        own_displacement_2=a_2,
        leakage_11=0.0,
        leakage_12=0.0,
        leakage_22=0.0,
        linear_resistance=drive.damping,
        quadratic_resistance=a_1**3 * line_1.resistance + a_2**3 * line_2.resistance,
        laminar_drop_1=0.0,
        laminar_drop_2=0.0,
        turbulent_drop_1=line_1.resistance,
        turbulent_drop_2=line_2.resistance,
    )


def motor(drive: SwingDrive, line_1: Line, line_2: Line) -> Actuator:
    """Return the geared, leaking motor behind laminar hoses. Thesis eq. 3.4-3.9, 3.19, 4.7-4.9.

    The motor's ports p_1, p_2 are the inner nodes (D = N D_m, R_i internal, R_e external leakage):

        (P_1 - p_1)/R_1 = D u + (p_1 - p_2)/R_i + p_1/R_e
        (p_2 - P_2)/R_2 = D u + (p_1 - p_2)/R_i - p_2/R_e

    They are linear, so their elimination gives constants; the network is reciprocal, hence one g_12.
    """
    r_1, r_2 = line_1.resistance, line_2.resistance
    g_i, g_e = 1.0 / drive.internal_leakage_resistance, 1.0 / drive.external_leakage_resistance
    d = drive.gear_ratio * drive.motor_displacement
    # The node equations times the hose's resistance, so that no large conductances cancel.
    a_11, a_12 = 1.0 + r_1 * (g_i + g_e), r_1 * g_i
    a_21, a_22 = r_2 * g_i, 1.0 + r_2 * (g_i + g_e)
    determinant = a_11 * a_22 - a_12 * a_21
    return Actuator(
        displacement_1=d * (1.0 + r_2 * g_e) / determinant,
        displacement_2=d * (1.0 + r_1 * g_e) / determinant,
        own_displacement_1=d,
        own_displacement_2=d,
        leakage_11=((g_i + g_e) * a_22 - r_2 * g_i * g_i) / determinant,
        leakage_12=g_i / determinant,
        leakage_22=((g_i + g_e) * a_11 - r_1 * g_i * g_i) / determinant,
        linear_resistance=drive.damping
        + d * d * (r_1 * (1.0 + r_2 * g_e) + r_2 * (1.0 + r_1 * g_e)) / determinant,
        quadratic_resistance=0.0,
        laminar_drop_1=r_1,
        laminar_drop_2=r_2,
        turbulent_drop_1=0.0,
        turbulent_drop_2=0.0,
    )
