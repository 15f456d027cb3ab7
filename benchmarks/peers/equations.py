"""The plant as a peer's user would write it: the right-hand side of Appendix B for both valve directions.

Independent of forest_sim: only the machine's numbers are shared. It is written for speed: constants are
folded beforehand, the motor's inner network is solved numerically, sums are factored. The same source is
interpreted (NumPy peers), compiled by Numba, and traced by CasADi.

A general solver has no use for C_R = inf: behind a shut valve the flow decays with SHUT_RATE instead, which
moves no oil (a cap on C_R would leak) and is no stiffer than the open orifice.

States y are Appendix B's 18 in units that make them of order one, as solvers with a scalar tolerance need:
rad, rad/s, 10 MPa, 10 MPa, l/s, l/s for swing, boom, stick.
"""

# ruff: noqa: F821
# The equations' numbers, `NUMBERS`, are globals of this module: that is fastest when interpreted, and when
# compiled they are constants.

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from forest_description.machine import Machine, load_machine
from forest_description.mechanics.drives import CylinderDrive

PRESSURE, FLOW = 1e7, 1e-3  # [Pa], [m^3/s] a unit
SCALE = np.tile([1.0, 1.0, PRESSURE, PRESSURE, FLOW, FLOW], 3)
SHUT_RATE = 1e5  # [1/s]
SHUT_OPENING = 1e-5  # below it a valve counts as shut

Rates = Callable[..., tuple[Any, ...]]


def constants(machine: Machine) -> dict[str, float]:
    """Return all numbers of the right-hand side, in the units of the module's head."""
    valve = machine.valve
    names = {
        "supply": machine.pump.supply_pressure / PRESSURE,
        "deadband": valve.deadband_voltage,
        "per_volt": 1.0 / (valve.rated_voltage - valve.deadband_voltage),
        "resistance": valve.minimum_resistance * FLOW**2 / PRESSURE,
    }
    names |= _motor(machine) | _cylinder(machine, machine.boom, 1) | _cylinder(machine, machine.stick, 2)
    for axis in range(3):
        for port in (1, 2):
            line = machine.line(axis, port)
            names[f"yield_{axis}{port}"] = FLOW / (PRESSURE * line.capacitance)
            names[f"push_{axis}{port}"] = PRESSURE / (FLOW * line.inertance)
    return names | _links(machine)


def _motor(machine: Machine) -> dict[str, float]:
    """Return flows and torque of the motor as linear functions of speed and both hose pressures."""
    drive = machine.swing
    r_1, r_2 = machine.line(0, 1).resistance, machine.line(0, 2).resistance
    g_i, g_e = 1.0 / drive.internal_leakage_resistance, 1.0 / drive.external_leakage_resistance
    d = drive.gear_ratio * drive.motor_displacement
    # Node equations of the motor's two ports p, (P_1 - p_1)/r_1 = d u + leaks, (p_2 - P_2)/r_2 = d u + leaks.
    nodes = np.array([[1.0 / r_1 + g_i + g_e, -g_i], [-g_i, 1.0 / r_2 + g_i + g_e]])
    # Columns: answers to u, P_1, P_2. Oil leaves node 1 with +u and enters node 2.
    p = np.linalg.solve(nodes, np.array([[-d, 1.0 / r_1, 0.0], [d, 0.0, 1.0 / r_2]]))
    unit = np.array([1.0, PRESSURE, PRESSURE])
    inlet = (np.array([0.0, 1.0, 0.0]) - p[0]) / r_1 * unit / FLOW
    outlet = (p[1] - np.array([0.0, 0.0, 1.0])) / r_2 * unit / FLOW
    torque = d * (p[0] - p[1]) * unit - np.array([drive.damping, 0.0, 0.0])
    rows = {"inlet": inlet, "outlet": outlet, "torque": torque}
    return {
        f"{row}_{k}": float(v) for row, values in rows.items() for k, v in zip("u12", values, strict=True)
    }


def _cylinder(machine: Machine, drive: CylinderDrive, axis: int) -> dict[str, float]:
    a, b = drive.pivot_to_base, drive.pivot_to_rod
    a_1, a_2 = drive.head_area, drive.rod_area
    r_1, r_2 = machine.line(axis, 1).resistance, machine.line(axis, 2).resistance
    return {
        f"squares_{axis}": a * a + b * b,
        f"product_{axis}": a * b,
        f"offset_{axis}": drive.angle_offset,
        f"area_{axis}1": a_1 / FLOW,
        f"area_{axis}2": a_2 / FLOW,
        f"force_{axis}1": a_1 * PRESSURE,
        f"force_{axis}2": a_2 * PRESSURE,
        f"damping_{axis}": drive.damping,
        f"drag_{axis}": r_1 * a_1**3 + r_2 * a_2**3,
    }


def _links(machine: Machine) -> dict[str, float]:
    """Return the mass matrix' and the bias' constants, Thesis App. B (level platform)."""
    m = machine.manipulator
    m_3 = m.stick_mass + m.head_mass
    x_3 = (m.stick_mass * m.stick_x + m.head_mass * m.stick_length) / m_3
    y_3 = m.stick_mass * m.stick_y / m_3
    along = m.stick_mass * (m.stick_x - x_3) ** 2 + m.head_mass * (m.stick_length - x_3) ** 2
    across = m.stick_mass * (m.stick_y - y_3) ** 2 + m.head_mass * y_3**2
    stick = m.stick_zz + along + across + m_3 * (x_3**2 + y_3**2)
    return {
        "l_1": m.base_offset,
        "l_2": m.boom_length,
        "m_2": m.boom_mass,
        "m_3": m_3,
        "x_2": m.boom_x,
        "y_2": m.boom_y,
        "x_3": x_3,
        "y_3": y_3,
        "boom_yy": m.boom_yy,
        "stick_yy": m.stick_yy + along,
        "base": m.base_zz + m.base_mass * m.base_x**2,
        "stick": stick,
        "boom": m.boom_zz + m.boom_mass * (m.boom_x**2 + m.boom_y**2) + m_3 * m.boom_length**2 + stick,
        "turn_x": m_3 * m.boom_length * x_3,
        "turn_y": m_3 * m.boom_length * y_3,
        "gravity": m.gravity,
    }


def make_rates(sine: Any, cosine: Any, root: Any, magnitude: Any, valve: Any) -> Rates:
    """Return rates(y_0 ... y_17, v_1, v_2, v_3), made of the functions given.

    Args:
        sine: of an angle.
        cosine: of an angle.
        root: square root.
        magnitude: absolute value.
        valve: valve(v, p_1, p_2, q_1, q_2, push_1, push_2), the two flow rates of an axis.
    """

    def rates(y0, u1, p1, r1, f1, g1, q2, u2, p2, r2, f2, g2, q3, u3, p3, r3, f3, g3, v1, v2, v3):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202, ARG001
        c2, s2, c3, s3 = cosine(q2), sine(q2), cosine(q3), sine(q3)
        c23, s23 = c2 * c3 - s2 * s3, s2 * c3 + c2 * s3
        # Centres of mass: x from the pivot of boom and stick, h above it.
        x2, h2 = x_2 * c2 - y_2 * s2, x_2 * s2 + y_2 * c2
        x3, h3 = x_3 * c23 - y_3 * s23, x_3 * s23 + y_3 * c23
        far, high = l_2 * c2 + x3, l_2 * s2 + h3
        m2r2, m3r3 = m_2 * (l_1 + x2), m_3 * (l_1 + far)
        m11 = m3r3 * (l_1 + far) + m2r2 * (l_1 + x2) + base + boom_yy * c2 * c2 + stick_yy * c23 * c23
        n3 = m3r3 * h3 + stick_yy * c23 * s23  # -1/2 dm11/dq3
        n2 = m3r3 * high + m2r2 * h2 + boom_yy * c2 * s2 + stick_yy * c23 * s23  # -1/2 dm11/dq2
        turn = turn_x * c3 - turn_y * s3
        bend = turn_x * s3 + turn_y * c3
        m22, m23 = boom + 2.0 * turn, stick + turn
        weight3 = gravity * m_3 * x3
        weight2 = weight3 + gravity * (m_3 * l_2 * c2 + m_2 * x2)

        length2 = root(squares_1 - 2.0 * product_1 * cosine(q2 + offset_1))
        length3 = root(squares_2 - 2.0 * product_2 * cosine(q3 + offset_2))
        arm2 = product_1 * sine(q2 + offset_1) / length2
        arm3 = product_2 * sine(q3 + offset_2) / length3
        w2, w3 = arm2 * u2, arm3 * u3
        t2 = arm2 * (force_11 * p2 - force_12 * r2 - (damping_1 + drag_1 * magnitude(w2)) * w2)
        t3 = arm3 * (force_21 * p3 - force_22 * r3 - (damping_2 + drag_2 * magnitude(w3)) * w3)
        a1 = (torque_u * u1 + torque_1 * p1 + torque_2 * r1 + 2.0 * (n2 * u2 + n3 * u3) * u1) / m11
        b2 = t2 - n2 * u1 * u1 + bend * (2.0 * u2 + u3) * u3 - weight2
        b3 = t3 - n3 * u1 * u1 - bend * u2 * u2 - weight3
        scale = 1.0 / (m22 * stick - m23 * m23)
        a2, a3 = (stick * b2 - m23 * b3) * scale, (m22 * b3 - m23 * b2) * scale

        df1, dg1 = valve(v1, p1, r1, f1, g1, push_01, push_02)
        df2, dg2 = valve(v2, p2, r2, f2, g2, push_11, push_12)
        df3, dg3 = valve(v3, p3, r3, f3, g3, push_21, push_22)
        dp1 = yield_01 * (f1 - inlet_u * u1 - inlet_1 * p1 - inlet_2 * r1)
        dr1 = yield_02 * (outlet_u * u1 + outlet_1 * p1 + outlet_2 * r1 - g1)
        dp2, dr2 = yield_11 * (f2 - area_11 * w2), yield_12 * (area_12 * w2 - g2)
        dp3, dr3 = yield_21 * (f3 - area_21 * w3), yield_22 * (area_22 * w3 - g3)
        return (u1, a1, dp1, dr1, df1, dg1, u2, a2, dp2, dr2, df2, dg2, u3, a3, dp3, dr3, df3, dg3)

    return rates


def valve(v, p_1, p_2, q_1, q_2, push_1, push_2):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Return both flow rates of an axis, Thesis eq. 3.7, 3.13, for either direction of its spool."""
    opening = min(1.0, (abs(v) - deadband) * per_volt)
    if opening < SHUT_OPENING:
        return -SHUT_RATE * q_1, -SHUT_RATE * q_2
    drop = resistance / (opening * opening)
    p_1 = (supply if v > 0.0 else 0.0) - p_1
    p_2 = p_2 - (0.0 if v > 0.0 else supply)
    return push_1 * (p_1 - drop * q_1 * abs(q_1)), push_2 * (p_2 - drop * q_2 * abs(q_2))


NUMBERS = constants(load_machine("c180_thesis"))
globals().update(NUMBERS)
rates = make_rates(math.sin, math.cos, math.sqrt, abs, valve)


def right_hand_side(t: float, y: Any, wave: Sequence[float]) -> list[float]:
    """Return dy/dt, interpreted; `wave` is `work.Segment.wave` as a list."""
    m1, a1, w1, o1, m2, a2, w2, o2, m3, a3, w3, o3 = wave
    sin = math.sin
    v1, v2, v3 = m1 + a1 * sin(w1 * t + o1), m2 + a2 * sin(w2 * t + o2), m3 + a3 * sin(w3 * t + o3)
    return list(rates(*y.tolist(), v1, v2, v3))
