"""Rigid-body dynamics of swing, boom and stick: M(q) q'' + V(q, q') + G(q) = tau. Thesis eq. 3.15, App. B.

| symbol | name | unit |
|---|---|---|
| q | angles of swing, boom (from the platform's plane, up positive), stick (relative to the boom) | rad |
| r_b, r_s | distance of the boom's, stick's centre of mass from the swing axis | m |
| h_b, h_s | its height above the boom's pivot | m |
| k_s | the part of h_s that turns with the stick alone | m |
| m, I | mass; moment of inertia about the centre of mass | kg; kg m^2 |

In these words Appendix B's long sums are short: M_11 = m_3 r_s^2 + m_2 r_b^2 + ..., and V follows from its
derivatives. The swing axis is inertially decoupled (M_12 = M_13 = 0), because all centres of mass lie in the
crane's plane.
"""

import math
from typing import NamedTuple

from forest_description.machine import Manipulator


class Body(NamedTuple):
    """Appendix B's inertial constants with the head folded into the stick as a point mass."""

    base_offset: float  # l1 [m]
    boom_length: float  # l2 [m]
    base_inertia: float  # about the swing axis, base alone [kg m^2]
    base_moment: float  # m1 x1 [kg m]
    boom_mass: float
    boom_x: float
    boom_y: float
    boom_yy: float
    boom_zz: float
    stick_mass: float  # stick and head
    stick_x: float
    stick_y: float
    stick_yy: float
    stick_zz: float
    gravity_across: float  # g sin(tilt) [m/s^2], along the platform's y
    gravity_down: float  # g cos(tilt) [m/s^2]


class Dynamics(NamedTuple):
    """M, V and G at one state; M_12 = M_13 = 0."""

    m_11: float  # [kg m^2]
    m_22: float
    m_23: float
    m_33: float
    bias: tuple[float, float, float]  # V + G [N m]


def fold_head(m: Manipulator) -> Body:
    """Return the constants of the dynamics, the head's point mass folded into the stick. Thesis App. B.

    As in the thesis, I3xx and I3xy stay zero although a folded point mass off the axis has some (0.3 % of
    M_11 with the crane extended, 3 % folded).
    """
    m_3 = m.stick_mass + m.head_mass
    x_3 = (m.stick_mass * m.stick_x + m.head_mass * m.stick_length) / m_3
    y_3 = m.stick_mass * m.stick_y / m_3
    shift = m.stick_mass * (x_3 - m.stick_x) ** 2 + m.head_mass * (m.stick_length - x_3) ** 2
    shift_y = m.stick_mass * (y_3 - m.stick_y) ** 2 + m.head_mass * y_3**2
    return Body(
        base_offset=m.base_offset,
        boom_length=m.boom_length,
        base_inertia=m.base_zz + m.base_mass * m.base_x**2,
        base_moment=m.base_mass * m.base_x,
        boom_mass=m.boom_mass,
        boom_x=m.boom_x,
        boom_y=m.boom_y,
        boom_yy=m.boom_yy,
        boom_zz=m.boom_zz,
        stick_mass=m_3,
        stick_x=x_3,
        stick_y=y_3,
        stick_yy=m.stick_yy + shift,
        stick_zz=m.stick_zz + shift + shift_y,
        gravity_across=m.gravity * math.sin(m.platform_tilt),
        gravity_down=m.gravity * math.cos(m.platform_tilt),
    )


def dynamics(q: tuple[float, float, float], rates: tuple[float, float, float], body: Body) -> Dynamics:
    """Return M(q), and V(q, q') + G(q). Thesis eq. 3.15, App. B.

    Args:
        q: joint angles [rad].
        rates: joint rates [rad/s].
        body: inertial constants, from `fold_head`.
    """
    b = body
    c_2, s_2 = math.cos(q[1]), math.sin(q[1])
    c_3, s_3 = math.cos(q[2]), math.sin(q[2])
    c_23, s_23 = c_2 * c_3 - s_2 * s_3, s_2 * c_3 + c_2 * s_3
    x_b, h_b = b.boom_x * c_2 - b.boom_y * s_2, b.boom_x * s_2 + b.boom_y * c_2
    x_s, k_s = b.stick_x * c_23 - b.stick_y * s_23, b.stick_x * s_23 + b.stick_y * c_23
    h_s = b.boom_length * s_2 + k_s
    r_b, r_s = b.base_offset + x_b, b.base_offset + b.boom_length * c_2 + x_s

    stick_own = b.stick_mass * (b.stick_x**2 + b.stick_y**2) + b.stick_zz
    coupling = b.stick_mass * b.boom_length * (b.stick_x * c_3 - b.stick_y * s_3)
    coriolis = b.stick_mass * b.boom_length * (b.stick_x * s_3 + b.stick_y * c_3)
    half_dm11_dq3 = -b.stick_mass * r_s * k_s - b.stick_yy * c_23 * s_23
    half_dm11_dq2 = (
        -b.stick_mass * r_s * h_s - b.boom_mass * r_b * h_b - b.boom_yy * c_2 * s_2 - b.stick_yy * c_23 * s_23
    )

    u_1, u_2, u_3 = rates
    g_y, g_z = b.gravity_across, b.gravity_down
    s_1, c_1 = math.sin(q[0]), math.cos(q[0])
    first_moment = b.stick_mass * r_s + b.boom_mass * r_b + b.base_moment
    return Dynamics(
        m_11=b.stick_mass * r_s**2
        + b.boom_mass * r_b**2
        + b.base_inertia
        + b.boom_yy * c_2**2
        + b.stick_yy * c_23**2,
        m_22=stick_own
        + 2.0 * coupling
        + b.stick_mass * b.boom_length**2
        + b.boom_mass * (b.boom_x**2 + b.boom_y**2)
        + b.boom_zz,
        m_23=stick_own + coupling,
        m_33=stick_own,
        bias=(
            2.0 * (half_dm11_dq2 * u_2 + half_dm11_dq3 * u_3) * u_1 + g_y * c_1 * first_moment,
            -half_dm11_dq2 * u_1**2
            - coriolis * (2.0 * u_2 + u_3) * u_3
            + g_z * (b.stick_mass * (b.boom_length * c_2 + x_s) + b.boom_mass * x_b)
            - g_y * s_1 * (b.stick_mass * h_s + b.boom_mass * h_b),
            -half_dm11_dq3 * u_1**2
            + coriolis * u_2**2
            + g_z * b.stick_mass * x_s
            - g_y * s_1 * b.stick_mass * k_s,
        ),
    )
