"""One law for cylinders and motor: what flows through an actuator and how hard it pushes.

Thesis section 3.2.4, 3.2.5, 3.4, 3.5. Both actuators sit between the two hose capacitances of their
axis, and after their inner nodes are eliminated both obey

    q_1 = d_1 u + g_11 P_1 - g_12 P_2 - e_1 u|u|   flow out of hose 1 into the actuator
    q_2 = d_2 u + g_12 P_1 - g_22 P_2 - e_2 u|u|   flow out of the actuator into hose 2
    F   = d_1 P_1 - d_2 P_2 - b u - c u|u|         force on the load

| symbol | name | unit (cylinder; motor) |
|---|---|---|
| u | actuator speed, extending / turning left positive | m/s; rad/s |
| P_1, P_2 | pressure in the capacitance of hose 1, 2 | Pa |
| d_1, d_2 | displacement of port 1, 2 | m^2; m^3/rad |
| g_.. | leakage conductance | m^3/(s Pa) |
| e_.. | what a leaking actuator takes less for a turbulent hose's loss | m s; m^3 s/rad^2 |
| b, c | linear, quadratic resistance to motion | N s/m, N s^2/m^2; N m s, N m s^2 |
| F | force; torque | N; N m |

A turbulent hose's loss is taken at the flow D u that moves the load; what leakage adds to it would
be under 100 Pa. Port 1 feeds the piston head (extending) or turns the swing left.
"""

from typing import NamedTuple

from forest_description.hydraulics.hose import Line
from forest_description.mechanics.drives import CylinderDrive, SwingDrive


class Actuator(NamedTuple):
    """The constants of the law above, and the pressure drops between hose and actuator port."""

    displacement_1: float
    displacement_2: float
    own_displacement_1: float  # of the actuator alone, at its ports: a leaking motor's differs a little
    own_displacement_2: float
    internal_leakage: float  # between its ports
    external_leakage: float  # of each port to the case drain
    leakage_11: float
    leakage_12: float
    leakage_22: float
    leakage_loss_1: float
    leakage_loss_2: float
    damping: float  # viscous friction's share of the linear resistance
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
    moved = (a.displacement_1 - a.leakage_loss_1 * abs(speed)) * speed
    return moved + a.leakage_11 * pressure_1 - a.leakage_12 * pressure_2


def outlet_flow(speed: float, pressure_1: float, pressure_2: float, a: Actuator) -> float:
    """Return q_2 [m^3/s], the flow out of the actuator into hose 2.

    Thesis eq. 3.5, 3.11, 3.14, 3.17. Differs: 3.14 and 3.17 print a minus that 3.13 contradicts.
    """
    moved = (a.displacement_2 - a.leakage_loss_2 * abs(speed)) * speed
    return moved + a.leakage_12 * pressure_1 - a.leakage_22 * pressure_2


def actuator_force(speed: float, pressure_1: float, pressure_2: float, a: Actuator) -> float:
    """Return the force [N] or torque [N m] on the load.

    Thesis eq. 3.8, 3.14, 3.17, 3.19, 4.10. Differs: 3.19 prints the gear ratio upside down.
    """
    friction = (a.linear_resistance + a.quadratic_resistance * abs(speed)) * speed
    return a.displacement_1 * pressure_1 - a.displacement_2 * pressure_2 - friction


def port_pressures(speed: float, pressure_1: float, pressure_2: float, a: Actuator) -> tuple[float, float]:
    """Return the pressures [Pa] at the actuator's own ports, behind the hoses' resistance.

    Thesis eq. 3.8, 3.14. Differs: 3.14 prints a plus in front of the inlet's drop, which would
    inject energy.
    """
    q_1 = inlet_flow(speed, pressure_1, pressure_2, a)
    q_2 = outlet_flow(speed, pressure_1, pressure_2, a)
    moved_1, moved_2 = a.own_displacement_1 * speed, a.own_displacement_2 * speed
    return (
        pressure_1 - a.laminar_drop_1 * q_1 - a.turbulent_drop_1 * abs(moved_1) * moved_1,
        pressure_2 + a.laminar_drop_2 * q_2 + a.turbulent_drop_2 * abs(moved_2) * moved_2,
    )


def cylinder(drive: CylinderDrive, line_1: Line, line_2: Line) -> Actuator:
    """Return a single-ended cylinder without leakage behind its hoses. Thesis eq. 3.10-3.14, 3.17."""
    return _actuator(
        drive.head_area,
        drive.rod_area,
        0.0,
        0.0,
        drive.damping,
        line_1,
        line_2,
        drive.flow_regime == "laminar",
    )


def motor(drive: SwingDrive, line_1: Line, line_2: Line) -> Actuator:
    """Return the geared, leaking motor behind its hoses. Thesis eq. 3.4-3.9, 3.19, 4.7-4.9."""
    d = drive.gear_ratio * drive.motor_displacement
    g_i, g_e = 1.0 / drive.internal_leakage_resistance, 1.0 / drive.external_leakage_resistance
    return _actuator(d, d, g_i, g_e, drive.damping, line_1, line_2, drive.flow_regime == "laminar")


def leaking(a: Actuator, internal: float, external: float) -> Actuator:
    """Return an actuator with more leakage, worn: conductances [m^3/(s Pa)] added to its own.

    Args:
        a: cylinder or motor.
        internal: past piston or rotor, from port to port.
        external: of each port, to the case drain or past the rod's seal.
    """
    laminar = a.laminar_drop_1 > 0.0 or a.laminar_drop_2 > 0.0
    drops = (a.laminar_drop_1, a.laminar_drop_2) if laminar else (a.turbulent_drop_1, a.turbulent_drop_2)
    return _actuator(
        a.own_displacement_1,
        a.own_displacement_2,
        a.internal_leakage + internal,
        a.external_leakage + external,
        a.damping,
        Line(drops[0], 0.0, 0.0),
        Line(drops[1], 0.0, 0.0),
        laminar,
    )


def _actuator(
    d_1: float,
    d_2: float,
    g_i: float,
    g_e: float,
    damping: float,
    line_1: Line,
    line_2: Line,
    laminar: bool,
) -> Actuator:
    """Return the law of an actuator with internal and external leakage behind two hoses.

    Its ports p_1, p_2 are the inner nodes (D_1, D_2 displacements; g_i internal, g_e external
    leakage):

        (P_1 - p_1)/R_1 = D_1 u + (p_1 - p_2) g_i + p_1 g_e
        (p_2 - P_2)/R_2 = D_2 u + (p_1 - p_2) g_i - p_2 g_e

    They are linear, so their elimination gives constants; the network is reciprocal, hence one
    g_12. A turbulent hose has no R there, but lowers P_1 by R D_1^2 u|u| and raises P_2 alike.
    """
    r_1, r_2 = (line_1.resistance, line_2.resistance) if laminar else (0.0, 0.0)
    t_1, t_2 = (0.0, 0.0) if laminar else (line_1.resistance, line_2.resistance)
    # The node equations times the hose's resistance, so that no large conductances cancel.
    a_11, a_12 = 1.0 + r_1 * (g_i + g_e), r_1 * g_i
    a_21, a_22 = r_2 * g_i, 1.0 + r_2 * (g_i + g_e)
    determinant = a_11 * a_22 - a_12 * a_21
    reduced_1 = (a_22 * d_1 - a_21 * d_2) / determinant
    reduced_2 = (a_11 * d_2 - a_12 * d_1) / determinant
    leakage_11 = ((g_i + g_e) * a_22 - r_2 * g_i * g_i) / determinant
    leakage_12 = g_i / determinant
    leakage_22 = ((g_i + g_e) * a_11 - r_1 * g_i * g_i) / determinant
    loss_1, loss_2 = t_1 * d_1 * d_1, t_2 * d_2 * d_2
    return Actuator(
        displacement_1=reduced_1,
        displacement_2=reduced_2,
        own_displacement_1=d_1,
        own_displacement_2=d_2,
        internal_leakage=g_i,
        external_leakage=g_e,
        leakage_11=leakage_11,
        leakage_12=leakage_12,
        leakage_22=leakage_22,
        leakage_loss_1=leakage_11 * loss_1 + leakage_12 * loss_2,
        leakage_loss_2=leakage_12 * loss_1 + leakage_22 * loss_2,
        damping=damping,
        linear_resistance=damping + d_1 * r_1 * reduced_1 + d_2 * r_2 * reduced_2,
        quadratic_resistance=reduced_1 * loss_1 + reduced_2 * loss_2,
        laminar_drop_1=r_1,
        laminar_drop_2=r_2,
        turbulent_drop_1=t_1,
        turbulent_drop_2=t_2,
    )
